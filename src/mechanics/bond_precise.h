/* Forces and energies of bond-based bodies with histories in double, for implicit integrators: they
   never commit, and critical stretch keeps the bonds that its flags say, so that energy, force and
   tangent belong to each other. `components`, `law`, `each` (moduli a point) and `marked` are
   literals where the loops are instantiated (precise_kernels.c). */
#ifndef SDR_MECHANICS_BOND_PRECISE_H
#define SDR_MECHANICS_BOND_PRECISE_H

#include "damage/bond_law.h"
#include "mechanics/bond_body.h"

#define SDR_INLINE static inline __attribute__((always_inline))

enum { SDR_PRECISE_BLOCK = 256 };

/* Consecutive pairs of a run. */
typedef struct {
  const sdr_bond_class *class;
  const double *ui[3], *uj[3];
  const double *ci, *cj, *qi, *qj, *ri, *rj; /* moduli a point, else NULL */
  const double *history;
  const sdr_flags *flags;
  int64_t i, j;
  int count;
} sdr_precise_block;

SDR_INLINE sdr_precise_block precise_block(const int components, const sdr_bond_body *body,
                                           const sdr_bond_run *run, int32_t start,
                                           double *const u[3])
{
  const int64_t i = run->i0 + start, j = run->j0 + start, slot = run->slot + start;
  const int32_t rest = run->length - start;
  sdr_precise_block b = {.class = &body->bonds->classes[run->class_index], .i = i, .j = j};
  b.count = rest < SDR_PRECISE_BLOCK ? rest : SDR_PRECISE_BLOCK;
  for (int a = 0; a < components; ++a) {
    b.ui[a] = u[a] + i;
    b.uj[a] = u[a] + j;
  }
  if (body->stiffness_at) {
    b.ci = body->stiffness_at + i;
    b.cj = body->stiffness_at + j;
    b.qi = body->threshold_at + i;
    b.qj = body->threshold_at + j;
  }
  if (body->decline_at) {
    b.ri = body->decline_at + i;
    b.rj = body->decline_at + j;
  }
  if (body->history) b.history = body->history + slot;
  if (body->flags) b.flags = body->flags + slot;
  return b;
}

/* Constants of a pair's two directed bonds. */
typedef struct {
  double ci, cj, qi, qj, ri, rj;
} sdr_precise_constants;

SDR_INLINE sdr_precise_constants precise_constants(const int law, const int each,
                                                   const sdr_bond_body *body,
                                                   const sdr_precise_block *b, int k)
{
  const int second = each && law == SDR_LAW_COHESIVE;
  return (sdr_precise_constants){
      each ? b->ci[k] : body->stiffness, each ? b->cj[k] : body->stiffness,
      each ? b->qi[k] : body->threshold, each ? b->qj[k] : body->threshold,
      second ? b->ri[k] : body->decline, second ? b->rj[k] : body->decline};
}

/* A directed bond at stretch s: `before` is its history or a mark, `lost` its flag. */
SDR_INLINE sdr_bond_answer precise_answer(const int law, const int marked, double s, double before,
                                          int lost, double q, double r)
{
  if (!sdr_law_softens(law)) {
    const double left = lost ? 0.0 : 1.0;
    return (sdr_bond_answer){left * s, left, 0.5 * left * s * s, 0.0, 1.0 - left};
  }
  const double k = before > s ? before : s;
  sdr_bond_answer answer = sdr_bond_law_at(law, s, k > 0.0 ? k : 0.0, 0, q, r);
  if (marked) {
    const double left = before == (double)SDR_STRETCH_CUT ? 0.0 : 1.0;
    answer.force = before < 0.0 ? left * s : answer.force;
    answer.stored = before < 0.0 ? 0.5 * left * s * s : answer.stored;
    answer.dissipated = before < 0.0 ? 0.0 : answer.dissipated;
    answer.damage = before < 0.0 ? 0.0 : answer.damage;
  }
  return answer;
}

/* z = l^2/|xi|^2 - 1 of a pair whose end moved by e relative to its start. */
SDR_INLINE double precise_elongation(const int components, const double xi[3], const double e[3],
                                     double inverse_square)
{
  double sum = (2.0 * xi[0] + e[0]) * e[0];
  if (components > 1) sum += (2.0 * xi[1] + e[1]) * e[1];
  if (components > 2) sum += (2.0 * xi[2] + e[2]) * e[2];
  return sum * inverse_square;
}

SDR_INLINE double precise_ratio(double z)
{
  const double square = 1.0 + z;
  return sqrt(square > 1e-200 ? square : 1e-200); /* l = 0: no direction, no force */
}

/* ---- runs ------------------------------------------------------------------------------------ */

/* Forces on the points i of a block into F. */
SDR_INLINE void precise_forces(const int components, const int law, const int each,
                               const int marked, const sdr_bond_body *body,
                               const sdr_precise_block *b, double F[3][SDR_PRECISE_BLOCK])
{
  const sdr_bond_class *class = b->class;
  const double xi[3] = {class->xi[0], class->xi[1], class->xi[2]};
  const double square = class->inverse_square, wi = class->by_length_ij, wj = class->by_length_ji;
#pragma omp simd
  for (int k = 0; k < b->count; ++k) {
    const double e[3] = {b->uj[0][k] - b->ui[0][k],
                         components > 1 ? b->uj[1][k] - b->ui[1][k] : 0.0,
                         components > 2 ? b->uj[2][k] - b->ui[2][k] : 0.0};
    const double z = precise_elongation(components, xi, e, square), ratio = precise_ratio(z);
    const double s = z / (1.0 + ratio);
    const sdr_precise_constants of = precise_constants(law, each, body, b, k);
    const double before = sdr_law_softens(law) ? b->history[k] : 0.0;
    const sdr_flags flags = marked && !sdr_law_softens(law) ? b->flags[k] : 0;
    const double fi =
        precise_answer(law, marked, s, before, flags & SDR_LOST_I, of.qi, of.ri).force;
    const double fj =
        each || !sdr_law_softens(law)
            ? precise_answer(law, marked, s, before, flags & SDR_LOST_J, of.qj, of.rj).force
            : fi;
    const double phi = (wi * of.ci * fi + wj * of.cj * fj) / ratio;
    F[0][k] = phi * (xi[0] + e[0]);
    if (components > 1) F[1][k] = phi * (xi[1] + e[1]);
    if (components > 2) F[2][k] = phi * (xi[2] + e[2]);
  }
}

/* One side after the other: a run along its own row overlaps itself. */
SDR_INLINE void precise_add(const int components, const sdr_precise_block *b,
                            double F[3][SDR_PRECISE_BLOCK], double *const f[3])
{
  for (int a = 0; a < components; ++a) {
    double *const fi = f[a] + b->i, *const fj = f[a] + b->j;
    const double *const force = F[a];
#pragma omp simd
    for (int k = 0; k < b->count; ++k) fi[k] += force[k];
#pragma omp simd
    for (int k = 0; k < b->count; ++k) fj[k] -= force[k];
  }
}

SDR_INLINE int run_is_marked(const sdr_bond_body *body, int64_t run)
{
  return body->run_marked && body->run_marked[run];
}

SDR_INLINE void precise_force_of_runs(const int components, const int law, const int each,
                                      const sdr_bond_body *body, int64_t first, int64_t end,
                                      double *const u[3], double *const f[3])
{
  _Alignas(64) double F[3][SDR_PRECISE_BLOCK];
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    const int marked = law == SDR_LAW_CRITICAL_STRETCH || run_is_marked(body, r);
    for (int32_t start = 0; start < run->length; start += SDR_PRECISE_BLOCK) {
      const sdr_precise_block b = precise_block(components, body, run, start, u);
      if (marked)
        precise_forces(components, law, each, 1, body, &b, F);
      else
        precise_forces(components, law, each, 0, body, &b, F);
      precise_add(components, &b, F, f);
    }
  }
}

SDR_INLINE void precise_energies(const int components, const int law, const int each,
                                 const int marked, const sdr_bond_body *body,
                                 const sdr_precise_block *b, sdr_stripe_energies *sum)
{
  const sdr_bond_class *class = b->class;
  const double xi[3] = {class->xi[0], class->xi[1], class->xi[2]};
  const double wi = class->weight_ij * class->length, wj = class->weight_ji * class->length;
  const double ni = wi > 0.0 ? 1.0 : 0.0, nj = wj > 0.0 ? 1.0 : 0.0; /* bond present */
  double stored = 0.0, dissipated = 0.0, most = sum->max_damage, broken = 0.0;
#pragma omp simd reduction(+ : stored, dissipated, broken) reduction(max : most)
  for (int k = 0; k < b->count; ++k) {
    const double e[3] = {b->uj[0][k] - b->ui[0][k],
                         components > 1 ? b->uj[1][k] - b->ui[1][k] : 0.0,
                         components > 2 ? b->uj[2][k] - b->ui[2][k] : 0.0};
    const double z = precise_elongation(components, xi, e, class->inverse_square);
    const double s = z / (1.0 + precise_ratio(z));
    const sdr_precise_constants of = precise_constants(law, each, body, b, k);
    const double before = sdr_law_softens(law) ? b->history[k] : 0.0;
    const sdr_flags flags = marked && !sdr_law_softens(law) ? b->flags[k] : 0;
    const double grown = flags & SDR_CUT ? 0.0 : 1.0; /* bonds cut at the start are not counted */
    const sdr_bond_answer i =
        precise_answer(law, marked, s, before, flags & SDR_LOST_I, of.qi, of.ri);
    const sdr_bond_answer j =
        precise_answer(law, marked, s, before, flags & SDR_LOST_J, of.qj, of.rj);
    stored += wi * of.ci * i.stored + wj * of.cj * j.stored;
    dissipated += wi * of.ci * i.dissipated + wj * of.cj * j.dissipated;
    const double di = grown * ni * i.damage, dj = grown * nj * j.damage;
    broken += (di > 0.5 ? 1.0 : 0.0) + (dj > 0.5 ? 1.0 : 0.0);
    const double larger = di > dj ? di : dj;
    most = most > larger ? most : larger;
  }
  sum->stored += stored;
  sum->dissipated += dissipated;
  sum->broken += (int64_t)broken;
  sum->max_damage = most;
}

SDR_INLINE void precise_energies_of_runs(const int components, const int law, const int each,
                                         const sdr_bond_body *body, int64_t first, int64_t end,
                                         double *const u[3], sdr_stripe_energies *sum)
{
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    const int marked = law == SDR_LAW_CRITICAL_STRETCH || run_is_marked(body, r);
    for (int32_t start = 0; start < run->length; start += SDR_PRECISE_BLOCK) {
      const sdr_precise_block b = precise_block(components, body, run, start, u);
      if (marked)
        precise_energies(components, law, each, 1, body, &b, sum);
      else
        precise_energies(components, law, each, 0, body, &b, sum);
    }
  }
}

/* ---- loose pairs ----------------------------------------------------------------------------- */

/* A column of a chunk of eight points, one slot each; padding has weights of zero. */
SDR_INLINE void precise_column(const int components, const int law, const int each,
                               const sdr_bond_body *body, int64_t point, int64_t column,
                               double *const u[3], double sum[3][SDR_LANES])
{
  const sdr_loose *loose = &body->bonds->loose;
  const int flagged = !sdr_law_softens(law) && body->loose_flags;
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane, i = point + lane;
    const int32_t j = loose->j[slot];
    double xi[3] = {0.0}, e[3] = {0.0}, square = 0.0;
    for (int a = 0; a < components; ++a) {
      xi[a] = loose->xi[a][slot];
      e[a] = u[a][j] - u[a][i];
      square += xi[a] * xi[a];
    }
    const double z = precise_elongation(components, xi, e, 1.0 / square);
    const double ratio = precise_ratio(z), s = z / (1.0 + ratio);
    const int second = each && law == SDR_LAW_COHESIVE;
    const double qi = each ? body->threshold_at[i] : body->threshold;
    const double qj = each ? body->threshold_at[j] : body->threshold;
    const double ri = second ? body->decline_at[i] : body->decline;
    const double rj = second ? body->decline_at[j] : body->decline;
    const double ci = each ? body->stiffness_at[i] : body->stiffness;
    const double cj = each ? body->stiffness_at[j] : body->stiffness;
    const double before = sdr_law_softens(law) ? body->loose_history[slot] : 0.0;
    const sdr_flags flags = flagged ? body->loose_flags[slot] : 0;
    const double fi = precise_answer(law, 1, s, before, flags & SDR_LOST_I, qi, ri).force;
    const double fj = precise_answer(law, 1, s, before, flags & SDR_LOST_J, qj, rj).force;
    const double phi = (loose->weight_ij[slot] * ci * fi + loose->weight_ji[slot] * cj * fj) /
                       (sqrt(square) * ratio);
    for (int a = 0; a < components; ++a) sum[a][lane] += phi * (xi[a] + e[a]);
  }
}

SDR_INLINE void precise_force_of_loose(const int components, const int law, const int each,
                                       const sdr_bond_body *body, int64_t first, int64_t end,
                                       double *const u[3], double *const f[3])
{
  const int64_t *const slot = body->bonds->loose.chunk_slot;
  for (int64_t chunk = first; chunk < end; ++chunk) {
    const int64_t point = chunk * SDR_LANES;
    _Alignas(64) double sum[3][SDR_LANES] = {{0.0}};
    for (int64_t column = slot[chunk]; column < slot[chunk + 1]; column += SDR_LANES)
      precise_column(components, law, each, body, point, column, u, sum);
    for (int a = 0; a < components; ++a)
      for (int lane = 0; lane < SDR_LANES; ++lane) f[a][point + lane] += sum[a][lane];
  }
}

#endif
