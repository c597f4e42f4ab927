/* Loops over the runs of ordinary bodies and over points, written once; literals as in bond_loop.h.
   `linear`: stretches and directions of the reference shape. */
#ifndef SDR_MECHANICS_ORDINARY_LOOP_H
#define SDR_MECHANICS_ORDINARY_LOOP_H

#include "mechanics/ordinary_body.h"
#include "mechanics/state_loop.h"

/* ---- sums of points -------------------------------------------------------------------------- */

SDR_INLINE void stretches_of_block(const int components, const int linear,
                                   const sdr_ordinary_class *class, const sdr_state_pairs *at,
                                   double *const u[3], double *s)
{
  const double *ui[3] = {NULL}, *uj[3] = {NULL};
  for (int a = 0; a < components; ++a) {
    ui[a] = u[a] + at->i;
    uj[a] = u[a] + at->j;
  }
  const double xx = class->xi[0], xy = class->xi[1], xz = class->xi[2];
  const double inverse = class->inverse_square, quadratic = linear ? 0.0 : 1.0;
  const double twice = linear ? 1.0 : 2.0;
#pragma omp simd
  for (int k = 0; k < at->count; ++k) {
    const double ex = uj[0][k] - ui[0][k];
    const double ey = components > 1 ? uj[1][k] - ui[1][k] : 0.0;
    const double ez = components > 2 ? uj[2][k] - ui[2][k] : 0.0;
    double z = (twice * xx + quadratic * ex) * ex;
    if (components > 1) z += (twice * xy + quadratic * ey) * ey;
    if (components > 2) z += (twice * xz + quadratic * ez) * ez;
    z *= inverse;
    s[k] = linear ? z : sdr_state_stretch_of(z).s;
  }
}

/* sum += p s and, with squares, square += q s^2 of one side of a block. */
SDR_INLINE void add_sums(const int squares, int count, const double *s, double p, double q,
                         double *sum, double *square)
{
#pragma omp simd
  for (int k = 0; k < count; ++k) {
    sum[k] += p * s[k];
    if (squares) square[k] += q * s[k] * s[k];
  }
}

/* Halves of a pair lost at stretch s; a loss that is new is marked fresh. */
SDR_INLINE sdr_flags grown_flags(sdr_flags before, double s, double qi, double qj)
{
  const sdr_flags broken =
      (s > 0.0 && s * s > qi ? SDR_LOST_I : 0) | (s > 0.0 && s * s > qj ? SDR_LOST_J : 0);
  const sdr_flags fresh = broken & ~before;
  return before & SDR_PROTECTED ? before : before | fresh | fresh << 2;
}

/* Flags of a block as this pass sees them, stretches of its halves (0: lost), and what is new. */
SDR_INLINE sdr_flags sift_block(const int use, const sdr_ordinary *o, const sdr_state_pairs *at,
                                const double *s, sdr_flags *now, double *si, double *sj)
{
  sdr_flags *const flags = o->body.flags + at->slot;
  const double *const qi = use ? o->body.threshold + at->i : NULL;
  const double *const qj = use ? o->body.threshold + at->j : NULL;
  sdr_flags all = 0;
#pragma omp simd reduction(| : all)
  for (int k = 0; k < at->count; ++k) {
    const sdr_flags grown = use ? grown_flags(flags[k], s[k], qi[k], qj[k]) : flags[k];
    now[k] = grown;
    si[k] = grown & SDR_LOST_I ? 0.0 : s[k];
    sj[k] = grown & SDR_LOST_J ? 0.0 : s[k];
    all |= grown;
    if (use) flags[k] = grown;
  }
  return all;
}

/* lost += r where the half is gone since the start. */
SDR_INLINE void add_lost(int count, const sdr_flags *flags, sdr_flags half, double r, double *lost)
{
#pragma omp simd
  for (int k = 0; k < count; ++k) lost[k] += (flags[k] & (half | SDR_CUT)) == half ? r : 0.0;
}

/* A block with flags set, or with stretches that may set some; returns all flags in it. */
SDR_INLINE sdr_flags add_sifted(const int squares, const int use, sdr_ordinary *o,
                                const sdr_ordinary_class *class, const sdr_state_pairs *at,
                                const double *s)
{
  _Alignas(64) double si[SDR_STATE_PAIRS], sj[SDR_STATE_PAIRS];
  _Alignas(64) sdr_flags now[SDR_STATE_PAIRS];
  const sdr_flags all = sift_block(use, o, at, s, now, si, sj);
  double *const qi = squares ? o->square + at->i : NULL, *const qj =
                                                             squares ? o->square + at->j : NULL;
  add_sums(squares, at->count, si, class->p_ij, class->q_ij, o->sum + at->i, qi);
  add_sums(squares, at->count, sj, class->p_ji, class->q_ji, o->sum + at->j, qj);
  if (o->lost && all & (SDR_LOST_I | SDR_LOST_J)) {
    add_lost(at->count, now, SDR_LOST_I, class->r_ij, o->lost + at->i);
    add_lost(at->count, now, SDR_LOST_J, class->r_ji, o->lost + at->j);
  }
  return all;
}

SDR_INLINE int any_above(int count, const double *s, double square)
{
  int any = 0;
#pragma omp simd reduction(| : any)
  for (int k = 0; k < count; ++k) any |= s[k] > 0.0 && s[k] * s[k] > square;
  return any;
}

SDR_INLINE void sums_of_runs(const int components, const int squares, const int use,
                             const int linear, sdr_ordinary *o, int64_t first, int64_t end,
                             double *const u[3])
{
  _Alignas(64) double s[SDR_STATE_PAIRS];
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &o->body.bonds->runs[r];
    const sdr_ordinary_class *class = &o->classes[run->class_index];
    const int flagged = o->body.run_flagged && o->body.run_flagged[r];
    sdr_flags all = 0;
    for (int32_t start = 0; start < run->length; start += SDR_STATE_PAIRS) {
      const sdr_state_pairs at = sdr_state_pairs_of(run, start);
      stretches_of_block(components, linear, class, &at, u, s);
      if (flagged || (use && any_above(at.count, s, o->weakest))) {
        all |= add_sifted(squares, use, o, class, &at, s);
        continue;
      }
      double *const qi = squares ? o->square + at.i : NULL;
      double *const qj = squares ? o->square + at.j : NULL;
      add_sums(squares, at.count, s, class->p_ij, class->q_ij, o->sum + at.i, qi);
      add_sums(squares, at.count, s, class->p_ji, class->q_ji, o->sum + at.j, qj);
    }
    if (!use || !all) continue;
    o->body.run_flagged[r] = 1;
    if (all & (SDR_FRESH_I | SDR_FRESH_J)) o->body.run_fresh[r] = 1;
  }
}

/* ---- points ---------------------------------------------------------------------------------- */

/* One point's coefficients a and c. */
SDR_INLINE void coefficients_of_point(const int law, const int commit, sdr_ordinary *o, int64_t i)
{
  const sdr_ordinary_constants of = law == SDR_LAW_CRITICAL_STRETCH
                                        ? sdr_ordinary_now(o, (int32_t)i)
                                        : (sdr_ordinary_constants){o->t[i], o->a[i], o->b[i]};
  const double volume = o->body.head.points->volume[i], bulk = o->body.bulk[i];
  const double square = law == SDR_LAW_VARIATIONAL ? o->square[i] : 0.0;
  const sdr_ordinary_point now = sdr_ordinary_point_of(&of, bulk, o->sum[i], square);
  double left = 1.0;
  if (law == SDR_LAW_VARIATIONAL) {
    const double before = o->body.history[i], h = now.plus > before ? now.plus : before;
    const double intact = 1.0 / (1.0 + h * o->body.softness[i]);
    left = intact * intact;
    if (commit) o->body.history[i] = h;
  }
  const double pull = (now.theta > 0.0 ? left : 1.0) * bulk - 2.0 * of.a * left;
  o->along[i] = volume * of.t * now.theta * pull;
  o->across[i] = 2.0 * of.b * volume * left;
}

SDR_INLINE void coefficients_of_points(const int law, const int commit, sdr_ordinary *o,
                                       int64_t first, int64_t end)
{
#pragma omp simd
  for (int64_t i = first; i < end; ++i) coefficients_of_point(law, commit, o, i);
}

/* ---- forces ---------------------------------------------------------------------------------- */

/* Forces of a block onto f, or, where i and j points overlap, `into` F. `flagged`: of the bonds
   that the flags leave. */
SDR_INLINE void force_of_block(const int components, const int flagged, const int linear,
                               const sdr_ordinary *o, const sdr_state_pairs *at, double *const u[3],
                               double *const f[3], const int into, double F[3][SDR_STATE_PAIRS])
{
  const sdr_ordinary_class *class = &o->classes[at->class_index];
  const double *ui[3] = {NULL}, *uj[3] = {NULL};
  double *to[3] = {NULL}, *fj[3] = {NULL}; /* of the i points, of the j points */
  for (int a = 0; a < components; ++a) {
    ui[a] = u[a] + at->i;
    uj[a] = u[a] + at->j;
    to[a] = into ? F[a] : f[a] + at->i;
    fj[a] = f[a] + at->j;
  }
  const double *const ai = o->along + at->i, *const aj = o->along + at->j;
  const double *const ci = o->across + at->i, *const cj = o->across + at->j;
  const sdr_flags *const flags = flagged ? o->body.flags + at->slot : NULL;
  const double xx = class->xi[0], xy = class->xi[1], xz = class->xi[2];
  const double pij = class->pf_ij, pji = class->pf_ji, qij = class->qf_ij, qji = class->qf_ji;
  const double inverse = class->inverse_square;
#pragma omp simd
  for (int k = 0; k < at->count; ++k) {
    const double ex = uj[0][k] - ui[0][k];
    const double ey = components > 1 ? uj[1][k] - ui[1][k] : 0.0;
    const double ez = components > 2 ? uj[2][k] - ui[2][k] : 0.0;
    double z = linear ? xx * ex : (2.0 * xx + ex) * ex;
    if (components > 1) z += linear ? xy * ey : (2.0 * xy + ey) * ey;
    if (components > 2) z += linear ? xz * ez : (2.0 * xz + ez) * ez;
    z *= inverse;
    const sdr_state_stretch now = linear ? (sdr_state_stretch){z, 1.0} : sdr_state_stretch_of(z);
    double hi = pij * ai[k] + qij * ci[k] * now.s, hj = pji * aj[k] + qji * cj[k] * now.s;
    if (flagged) {
      hi = flags[k] & SDR_LOST_I ? 0.0 : hi;
      hj = flags[k] & SDR_LOST_J ? 0.0 : hj;
    }
    const double phi = linear ? -(hi + hj) : (hi + hj) / now.r;
    const double fx = phi * (linear ? xx : xx + ex), fy = phi * (linear ? xy : xy + ey);
    const double fz = phi * (linear ? xz : xz + ez);
    to[0][k] = into ? fx : to[0][k] + fx;
    if (!into) fj[0][k] -= fx;
    if (components > 1) to[1][k] = into ? fy : to[1][k] + fy;
    if (components > 1 && !into) fj[1][k] -= fy;
    if (components > 2) to[2][k] = into ? fz : to[2][k] + fz;
    if (components > 2 && !into) fj[2][k] -= fz;
  }
}

SDR_INLINE void add_forces(const int components, const sdr_state_pairs *at, double *const f[3],
                           double F[3][SDR_STATE_PAIRS])
{
  for (int a = 0; a < components; ++a) {
    double *const fi = f[a] + at->i, *const fj = f[a] + at->j;
    const double *const force = F[a];
#pragma omp simd
    for (int k = 0; k < at->count; ++k) fi[k] += force[k];
#pragma omp simd
    for (int k = 0; k < at->count; ++k) fj[k] -= force[k];
  }
}

SDR_INLINE void force_of_runs(const int components, const int linear, const sdr_ordinary *o,
                              int64_t first, int64_t end, double *const u[3], double *const f[3])
{
  _Alignas(64) double F[3][SDR_STATE_PAIRS];
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &o->body.bonds->runs[r];
    const int flagged = o->body.run_flagged && o->body.run_flagged[r];
    const int overlap = flagged || sdr_state_overlap(run);
    for (int32_t start = 0; start < run->length; start += SDR_STATE_PAIRS) {
      const sdr_state_pairs at = sdr_state_pairs_of(run, start);
      if (flagged)
        force_of_block(components, 1, linear, o, &at, u, f, 1, F);
      else if (overlap)
        force_of_block(components, 0, linear, o, &at, u, f, 1, F);
      else
        force_of_block(components, 0, linear, o, &at, u, f, 0, F);
      if (overlap) add_forces(components, &at, f, F);
    }
  }
}

#endif
