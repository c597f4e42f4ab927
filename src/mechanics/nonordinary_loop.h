/* The passes over the pairs of runs, written once; `n` (components), `finite` strain, `sums`,
   `marked` are literals where they are inlined (nonordinary_kernels.c).

   Pass A gathers the moments of displacement differences eta; pass A2 (finite strain) what the
   control of the normal part needs, whose direction F xi is known only then; pass B hands out
   forces. A pair's two directed states see xi, eta and -xi, -eta: every product of two of them is
   the same for both. Points and pairs go in lanes (lanes.h). What they add to i is stored before j
   is read, so runs along their own row, where both overlap, need no care. */
#ifndef SDR_MECHANICS_NONORDINARY_LOOP_H
#define SDR_MECHANICS_NONORDINARY_LOOP_H

#include "mechanics/lanes.h"
#include "mechanics/nonordinary_body.h"

/* A run at work, and the pairs of it that are in the lanes. */
typedef struct {
  const sdr_bond_class *class;
  const sdr_flags *flags; /* of the run's first pair; marked runs */
  int64_t i, j;           /* points of the first lane */
  int64_t at;             /* the first lane's pair in the run */
  int count;              /* lanes in use */
} sdr_pairs;

/* W of the lanes' halves: 0 where they are lost. */
SDR_INLINE sdr_lanes weight_of(const int marked, const sdr_pairs *pairs, sdr_flags lost, double w)
{
  if (!marked) return all_lanes(w);
  double weight[SDR_WIDTH] = {0.0};
  for (int l = 0; l < pairs->count; ++l) weight[l] = pairs->flags[pairs->at + l] & lost ? 0.0 : w;
  return load_lanes(weight, SDR_WIDTH);
}

SDR_INLINE void eta_of(const int n, const sdr_pairs *p, double *const u[3], sdr_lanes eta[3])
{
  for (int a = 0; a < n; ++a)
    eta[a] = load_lanes(u[a] + p->j, p->count) - load_lanes(u[a] + p->i, p->count);
}

/* ---- pass A ---------------------------------------------------------------------------------- */

/* Of the upper half of Q so many values are kept; the last is the trace of M less the others. */
SDR_INLINE int kept_of_normal(const int n)
{
  return n == 1 ? 0 : n == 2 ? 2 : 5;
}

/* Add the moments of the lanes' directed states to point i and those after it. */
SDR_INLINE void add_moments(const int n, const int finite, const int sums,
                            const sdr_nonordinary_body *body, int64_t i, int count,
                            const sdr_lanes *eta, const sdr_lanes *xi, sdr_lanes by_length,
                            sdr_lanes w)
{
  sdr_lanes along = all_lanes(0.0), square = all_lanes(0.0), weighted[3];
  for (int a = 0; a < n; ++a) {
    along += eta[a] * xi[a];
    square += eta[a] * eta[a];
    weighted[a] = w * xi[a];
  }
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b)
      add_lanes(body->gradient[n * a + b] + i, count, weighted[b] * eta[a]);
  if (finite) return;
  const sdr_lanes share = along * (by_length * by_length);
  int k = 0;
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b)
      if (k < kept_of_normal(n)) {
        add_lanes(body->bearing[k] + i, count, share * (weighted[a] * xi[b]));
        ++k;
      }
  if (!sums) return;
  add_lanes(body->square + i, count, w * square);
  add_lanes(body->along + i, count, w * (along * share));
}

SDR_INLINE void gather_pairs(const int n, const int finite, const int sums, const int marked,
                             const sdr_nonordinary_body *body, const sdr_pairs *p,
                             double *const u[3])
{
  sdr_lanes eta[3], xi[3];
  eta_of(n, p, u, eta);
  for (int a = 0; a < n; ++a) xi[a] = all_lanes(p->class->xi[a]);
  const sdr_lanes by_length = all_lanes(1.0 / p->class->length);
  add_moments(n, finite, sums, body, p->i, p->count, eta, xi, by_length,
              weight_of(marked, p, SDR_LOST_I, p->class->weight_ij));
  add_moments(n, finite, sums, body, p->j, p->count, eta, xi, by_length,
              weight_of(marked, p, SDR_LOST_J, p->class->weight_ji));
}

/* ---- pass A2 --------------------------------------------------------------------------------- */

/* p = G xi and f = F xi of a point, z = eta - p, (z.f) and f.f. */
typedef struct {
  sdr_lanes f[3], z[3], along, square;
} sdr_residual;

SDR_INLINE void residual_of(const int n, const sdr_lanes *g, const sdr_lanes *xi,
                            const sdr_lanes *eta, sdr_residual *r)
{
  r->along = all_lanes(0.0);
  r->square = all_lanes(1e-300);
  for (int a = 0; a < n; ++a) {
    sdr_lanes p = all_lanes(0.0);
    for (int b = 0; b < n; ++b) p += g[n * a + b] * xi[b];
    r->f[a] = xi[a] + p;
    r->z[a] = eta[a] - p;
    r->along += r->z[a] * r->f[a];
    r->square += r->f[a] * r->f[a];
  }
}

/* Add to S = sum W h_p (x) xi, with h = (z.f)^2/(2 f.f), p = G xi, and to the sums of points from
   i on. by_square: 1/(f.f); w: W. */
SDR_INLINE void add_control(const int n, const sdr_nonordinary_body *body, int64_t i, int count,
                            const sdr_residual *r, sdr_lanes by_square, sdr_lanes w,
                            const sdr_lanes *xi)
{
  const sdr_lanes share = r->along * by_square, part = w * share;
  sdr_lanes z = all_lanes(0.0);
  for (int a = 0; a < n; ++a) {
    const sdr_lanes h = part * (r->z[a] - r->f[a] - share * r->f[a]);
    for (int b = 0; b < n; ++b) add_lanes(body->bearing[n * a + b] + i, count, h * xi[b]);
    z += r->z[a] * r->z[a];
  }
  add_lanes(body->square + i, count, w * z);
  add_lanes(body->along + i, count, part * r->along);
}

SDR_INLINE void load_all(const int count, double *const from[9], int64_t i, int lanes,
                         sdr_lanes *to)
{
  for (int k = 0; k < count; ++k) to[k] = load_lanes(from[k] + i, lanes);
}

SDR_INLINE void control_pairs(const int n, const int marked, const sdr_nonordinary_body *body,
                              const sdr_pairs *p, double *const u[3])
{
  sdr_lanes eta[3], xi[3], g[9];
  sdr_residual ri, rj;
  eta_of(n, p, u, eta);
  for (int a = 0; a < n; ++a) xi[a] = all_lanes(p->class->xi[a]);
  load_all(n * n, body->gradient, p->i, p->count, g);
  residual_of(n, g, xi, eta, &ri);
  load_all(n * n, body->gradient, p->j, p->count, g);
  residual_of(n, g, xi, eta, &rj);
  const sdr_lanes both = all_lanes(1.0) / (ri.square * rj.square);
  add_control(n, body, p->i, p->count, &ri, rj.square * both,
              weight_of(marked, p, SDR_LOST_I, p->class->weight_ij), xi);
  add_control(n, body, p->j, p->count, &rj, ri.square * both,
              weight_of(marked, p, SDR_LOST_J, p->class->weight_ji), xi);
}

/* ---- pass B ---------------------------------------------------------------------------------- */

/* What bears on the bonds of points: A, G, control. */
typedef struct {
  sdr_lanes a[9], g[9], soft, stiff;
} sdr_bearing;

SDR_INLINE void bearing_at(const int n, const int finite, const sdr_nonordinary_body *body,
                           int64_t i, int count, sdr_bearing *at)
{
  load_all(n * n, body->bearing, i, count, at->a);
  if (finite) load_all(n * n, body->gradient, i, count, at->g);
  for (int a = 0; !finite && a < n; ++a) /* symmetric */
    for (int b = a; b < n; ++b) at->g[n * a + b] = load_lanes(body->gradient[n * a + b] + i, count);
  at->soft = load_lanes(body->soft + i, count);
  at->stiff = load_lanes(body->stiff + i, count);
}

/* n.G xi |xi|, G symmetric; xi_xi: xi_a xi_b. */
SDR_INLINE sdr_lanes strain_along(const int n, const sdr_lanes *g, const sdr_lanes *xi)
{
  sdr_lanes strain = all_lanes(0.0);
  for (int a = 0; a < n; ++a) {
    strain += g[n * a + a] * (xi[a] * xi[a]);
    for (int b = a + 1; b < n; ++b) strain += g[n * a + b] * (2.0 * (xi[a] * xi[b]));
  }
  return strain;
}

/* Force of a pair on i; wi, wj: W of its halves. */
SDR_INLINE void pair_force(const int n, const int finite, const sdr_bearing *i,
                           const sdr_bearing *j, const sdr_lanes *xi, const sdr_lanes *eta,
                           sdr_lanes by_length, sdr_lanes wi, sdr_lanes wj, sdr_lanes *force)
{
  const sdr_lanes soft = wi * i->soft + wj * j->soft;
  const sdr_lanes ci = wi * i->stiff, cj = wj * j->stiff;
  for (int a = 0; a < n; ++a) {
    force[a] = soft * eta[a];
    for (int b = 0; b < n; ++b) force[a] += (wi * i->a[n * a + b] + wj * j->a[n * a + b]) * xi[b];
  }
  if (finite) {
    sdr_residual ri, rj;
    residual_of(n, i->g, xi, eta, &ri);
    residual_of(n, j->g, xi, eta, &rj);
    const sdr_lanes both = all_lanes(1.0) / (ri.square * rj.square);
    const sdr_lanes si = ci * (ri.along * (rj.square * both));
    const sdr_lanes sj = cj * (rj.along * (ri.square * both));
    for (int a = 0; a < n; ++a) force[a] += si * ri.f[a] + sj * rj.f[a];
  } else {
    sdr_lanes along = all_lanes(0.0);
    for (int a = 0; a < n; ++a) along += eta[a] * xi[a];
    const sdr_lanes c =
        (ci * (along - strain_along(n, i->g, xi)) + cj * (along - strain_along(n, j->g, xi))) *
        (by_length * by_length);
    for (int a = 0; a < n; ++a) force[a] += c * xi[a];
  }
}

SDR_INLINE void force_pairs(const int n, const int finite, const int marked,
                            const sdr_nonordinary_body *body, const sdr_pairs *p,
                            double *const u[3], double *const f[3])
{
  sdr_lanes eta[3], xi[3], force[3];
  sdr_bearing i, j;
  eta_of(n, p, u, eta);
  for (int a = 0; a < n; ++a) xi[a] = all_lanes(p->class->xi[a]);
  bearing_at(n, finite, body, p->i, p->count, &i);
  bearing_at(n, finite, body, p->j, p->count, &j);
  pair_force(n, finite, &i, &j, xi, eta, all_lanes(1.0 / p->class->length),
             weight_of(marked, p, SDR_LOST_I, p->class->weight_ij),
             weight_of(marked, p, SDR_LOST_J, p->class->weight_ji), force);
  for (int a = 0; a < n; ++a) {
    add_lanes(f[a] + p->i, p->count, force[a]);
    add_lanes(f[a] + p->j, p->count, -force[a]);
  }
}

/* ---- runs ------------------------------------------------------------------------------------ */

/* DO(marked, pairs) for all pairs of a run, whole lanes first. */
#define SDR_RUN_LANES(DO, marked)                                                                  \
  for (; pairs.at + SDR_WIDTH <= run->length; pairs.at += SDR_WIDTH) {                             \
    pairs.i = run->i0 + pairs.at;                                                                  \
    pairs.j = run->j0 + pairs.at;                                                                  \
    pairs.count = SDR_WIDTH;                                                                       \
    DO(marked)                                                                                     \
  }                                                                                                \
  if (pairs.at < run->length) {                                                                    \
    pairs.i = run->i0 + pairs.at;                                                                  \
    pairs.j = run->j0 + pairs.at;                                                                  \
    pairs.count = (int)(run->length - pairs.at);                                                   \
    DO(marked)                                                                                     \
  }

/* The same for the runs [first, end). */
#define SDR_ALL_RUNS(DO)                                                                           \
  for (int64_t r = first; r < end; ++r) {                                                          \
    const sdr_bond_run *run = &body->bonds->runs[r];                                               \
    sdr_pairs pairs = {.class = &body->bonds->classes[run->class_index],                           \
                       .flags = body->flags ? body->flags + run->slot : NULL};                     \
    if (body->run_flagged && body->run_flagged[r]) {                                               \
      SDR_RUN_LANES(DO, 1)                                                                         \
    } else {                                                                                       \
      SDR_RUN_LANES(DO, 0)                                                                         \
    }                                                                                              \
  }

SDR_INLINE void gather_runs(const int n, const int finite, const int sums,
                            const sdr_nonordinary_body *body, int64_t first, int64_t end,
                            double *const u[3])
{
#define SDR_DO(marked) gather_pairs(n, finite, sums, marked, body, &pairs, u);
  SDR_ALL_RUNS(SDR_DO)
#undef SDR_DO
}

SDR_INLINE void control_runs(const int n, const sdr_nonordinary_body *body, int64_t first,
                             int64_t end, double *const u[3])
{
#define SDR_DO(marked) control_pairs(n, marked, body, &pairs, u);
  SDR_ALL_RUNS(SDR_DO)
#undef SDR_DO
}

SDR_INLINE void force_runs(const int n, const int finite, const sdr_nonordinary_body *body,
                           int64_t first, int64_t end, double *const u[3], double *const f[3])
{
#define SDR_DO(marked) force_pairs(n, finite, marked, body, &pairs, u, f);
  SDR_ALL_RUNS(SDR_DO)
#undef SDR_DO
}

/* ---- bonds that break ------------------------------------------------------------------------ */

SDR_INLINE int found_in_run(const int n, const int marked, const sdr_nonordinary_body *body,
                            const sdr_bond_run *run, const double *limit, double *const u[3])
{
  const sdr_bond_class *class = &body->bonds->classes[run->class_index];
  const double *const limit_i = limit + run->i0, *const limit_j = limit + run->j0;
  const double xx = class->xi[0], xy = class->xi[1], xz = class->xi[2];
  const double *const xi = u[0] + run->i0, *const xj = u[0] + run->j0;
  const double *const yi = n > 1 ? u[1] + run->i0 : xi, *const yj = n > 1 ? u[1] + run->j0 : xj;
  const double *const zi = n > 2 ? u[2] + run->i0 : xi, *const zj = n > 2 ? u[2] + run->j0 : xj;
  const sdr_flags *const flags = marked ? body->flags + run->slot : NULL;
  int any = 0;
#pragma omp simd reduction(| : any)
  for (int k = 0; k < run->length; ++k) {
    const double ex = xj[k] - xi[k], ey = n > 1 ? yj[k] - yi[k] : 0.0;
    const double ez = n > 2 ? zj[k] - zi[k] : 0.0;
    double z = (2.0 * xx + ex) * ex;
    if (n > 1) z += (2.0 * xy + ey) * ey;
    if (n > 2) z += (2.0 * xz + ez) * ez;
    z *= class->inverse_square;
    int over_i = z > limit_i[k], over_j = z > limit_j[k];
    if (marked) {
      over_i = flags[k] & (SDR_LOST_I | SDR_PROTECTED) ? 0 : over_i;
      over_j = flags[k] & (SDR_LOST_J | SDR_PROTECTED) ? 0 : over_j;
    }
    any |= over_i | over_j;
  }
  return any;
}

SDR_INLINE void find_runs(const int n, const sdr_nonordinary_body *body, int64_t first, int64_t end,
                          double *const u[3], const double *limit, uint8_t *found)
{
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    found[r] = (uint8_t)(body->run_flagged && body->run_flagged[r]
                             ? found_in_run(n, 1, body, run, limit, u)
                             : found_in_run(n, 0, body, run, limit, u));
  }
}

#endif
