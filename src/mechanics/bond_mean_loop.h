/* Mean forces of bond-based bodies over a step from u0 to u1 (theory sec. 7), and their derivative,
   for histories in double. Per pair, y = xi + eta, s stretches, L = |xi|:

     F = g (y0 + y1) on i, -F on j,   g = (e(l1) - e(l0))/(l1^2 - l0^2)
                                        = sum over its directed bonds of w C mean/(2 L (2 + s0 +
   s1)) dF = [g I + h (y0 + y1) (x) y1] d(eta1),   h = dg/ds1/(L^2 (1 + s1))

   mean: damage/discrete_gradient.h. `components`, `law`, `each` (moduli a point), `marked` and
   `kept` are literals where the loops are instantiated (mean_kernels.c). */
#ifndef SDR_MECHANICS_BOND_MEAN_LOOP_H
#define SDR_MECHANICS_BOND_MEAN_LOOP_H

#include "damage/discrete_gradient.h"
#include "mechanics/bond_mean.h"
#include "mechanics/bond_precise.h"

/* A pair with its history: before = k, or a mark; flags of laws that keep bonds or lose them. */
typedef struct {
  double length, wi, wj; /* w C of both directed bonds */
  double qi, qj, ri, rj;
  double before;
  sdr_flags flags;
} sdr_mean_pair;

/* mean and slope of one directed bond; `lost`: its flag. */
SDR_INLINE sdr_mean_answer mean_answer(const int law, const int marked, double s0, double s1,
                                       double before, int lost, double q, double r)
{
  const sdr_mean_answer elastic = sdr_mean_elastic(s0, s1);
  if (!sdr_law_softens(law)) {
    const double left = lost ? 0.0 : 1.0;
    return (sdr_mean_answer){left * elastic.mean, left};
  }
  sdr_mean_answer answer = sdr_mean_of(law, s0, s1, before > 0.0 ? before : 0.0, q, r);
  if (marked) {
    const double left = before == (double)SDR_STRETCH_CUT ? 0.0 : 1.0;
    answer.mean = before < 0.0 ? left * elastic.mean : answer.mean;
    answer.slope = before < 0.0 ? left : answer.slope;
  }
  return answer;
}

typedef struct {
  double g, h;
} sdr_mean_factors;

/* Of a pair; a bond that is shorter than 1e-8 of its length has no direction: 0. */
SDR_INLINE sdr_mean_factors mean_of_pair(const int law, const int each, const int marked,
                                         const sdr_mean_pair *p, double s0, double s1)
{
  const sdr_mean_answer i =
      mean_answer(law, marked, s0, s1, p->before, p->flags & SDR_LOST_I, p->qi, p->ri);
  const sdr_mean_answer j =
      each || !sdr_law_softens(law)
          ? mean_answer(law, marked, s0, s1, p->before, p->flags & SDR_LOST_J, p->qj, p->rj)
          : i;
  const double sum = 2.0 + s0 + s1, by = sum > 1e-8 ? 1.0 / sum : 0.0;
  const double now = 1.0 + s1, half = 0.5 / p->length;
  const double mean = half * (p->wi * i.mean + p->wj * j.mean) * by;
  const double slope = half * (p->wi * i.slope + p->wj * j.slope) * by;
  const double turned = (slope - mean * by) / (p->length * p->length * now);
  return (sdr_mean_factors){mean, now > 1e-8 ? turned : 0.0};
}

SDR_INLINE double mean_stretch(const int components, sdr_precise_vector xi, sdr_precise_vector e,
                               double inverse_square)
{
  const double z = precise_growth(components, xi, e) * inverse_square;
  return z / (1.0 + precise_ratio(z));
}

/* ---- runs ------------------------------------------------------------------------------------ */

/* A block at both ends of the step: a moves from before to now. */
typedef struct {
  sdr_precise_block before, now;
  double *g, *h; /* where to keep them */
} sdr_mean_block;

SDR_INLINE sdr_mean_block mean_block(const int components, const sdr_bond_body *body,
                                     const sdr_bond_run *run, int32_t start,
                                     const sdr_mean_step *step)
{
  sdr_mean_block b = {.before = precise_block(components, body, run, start, step->u0),
                      .now = precise_block(components, body, run, start, step->u1)};
  if (step->run_g) {
    b.g = step->run_g + run->slot + start;
    b.h = step->run_h + run->slot + start;
  }
  return b;
}

SDR_INLINE void mean_forces(const int components, const int law, const int each, const int marked,
                            const int kept, const sdr_bond_body *body, const sdr_mean_block *b,
                            double F[3][SDR_PRECISE_BLOCK])
{
  const sdr_bond_class *class = b->now.class;
  const sdr_precise_vector xi = {class->xi[0], class->xi[1], class->xi[2]};
  const double square = class->inverse_square;
  double *const restrict fx = F[0], *const restrict fy = F[1], *const restrict fz = F[2];
  double *const restrict kept_g = b->g, *const restrict kept_h = b->h;
#pragma omp simd
  for (int k = 0; k < b->now.count; ++k) {
    const sdr_precise_vector e0 = precise_motion(components, &b->before, k);
    const sdr_precise_vector e1 = precise_motion(components, &b->now, k);
    const sdr_precise_constants of = precise_constants(law, each, body, &b->now, k);
    const sdr_mean_pair pair = {.length = class->length,
                                .wi = class->weight_ij * of.ci,
                                .wj = class->weight_ji * of.cj,
                                .qi = of.qi,
                                .qj = of.qj,
                                .ri = of.ri,
                                .rj = of.rj,
                                .before = sdr_law_softens(law) ? b->now.history[k] : 0.0,
                                .flags = marked && !sdr_law_softens(law) ? b->now.flags[k] : 0};
    const sdr_mean_factors of_step =
        mean_of_pair(law, each, marked, &pair, mean_stretch(components, xi, e0, square),
                     mean_stretch(components, xi, e1, square));
    if (kept) {
      kept_g[k] = of_step.g;
      kept_h[k] = of_step.h;
    }
    fx[k] = of_step.g * (2.0 * xi.x + e0.x + e1.x);
    if (components > 1) fy[k] = of_step.g * (2.0 * xi.y + e0.y + e1.y);
    if (components > 2) fz[k] = of_step.g * (2.0 * xi.z + e0.z + e1.z);
  }
}

SDR_INLINE void mean_force_of_runs(const int components, const int law, const int each,
                                   const int kept, const sdr_bond_body *body, int64_t first,
                                   int64_t end, const sdr_mean_step *step)
{
  _Alignas(64) double F[3][SDR_PRECISE_BLOCK];
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    const int marked = law == SDR_LAW_CRITICAL_STRETCH || run_is_marked(body, r);
    for (int32_t start = 0; start < run->length; start += SDR_PRECISE_BLOCK) {
      const sdr_mean_block b = mean_block(components, body, run, start, step);
      if (marked)
        mean_forces(components, law, each, 1, kept, body, &b, F);
      else
        mean_forces(components, law, each, 0, kept, body, &b, F);
      precise_add(components, &b.now, F, step->out);
    }
  }
}

/* dF for d(eta1) = v, with g and h as they are kept. */
SDR_INLINE void mean_products(const int components, const sdr_mean_block *b,
                              const sdr_precise_block *v, double F[3][SDR_PRECISE_BLOCK])
{
  const sdr_bond_class *class = b->now.class;
  const sdr_precise_vector xi = {class->xi[0], class->xi[1], class->xi[2]};
  const double *const restrict g = b->g, *const restrict h = b->h;
  double *const restrict fx = F[0], *const restrict fy = F[1], *const restrict fz = F[2];
#pragma omp simd
  for (int k = 0; k < b->now.count; ++k) {
    const sdr_precise_vector e0 = precise_motion(components, &b->before, k);
    const sdr_precise_vector e1 = precise_motion(components, &b->now, k);
    const sdr_precise_vector dv = precise_motion(components, v, k);
    double along = (xi.x + e1.x) * dv.x;
    if (components > 1) along += (xi.y + e1.y) * dv.y;
    if (components > 2) along += (xi.z + e1.z) * dv.z;
    along *= h[k];
    fx[k] = -g[k] * dv.x - along * (2.0 * xi.x + e0.x + e1.x);
    if (components > 1) fy[k] = -g[k] * dv.y - along * (2.0 * xi.y + e0.y + e1.y);
    if (components > 2) fz[k] = -g[k] * dv.z - along * (2.0 * xi.z + e0.z + e1.z);
  }
}

SDR_INLINE void mean_times_of_runs(const int components, const sdr_bond_body *body, int64_t first,
                                   int64_t end, const sdr_mean_step *step)
{
  _Alignas(64) double F[3][SDR_PRECISE_BLOCK];
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    for (int32_t start = 0; start < run->length; start += SDR_PRECISE_BLOCK) {
      const sdr_mean_block b = mean_block(components, body, run, start, step);
      const sdr_precise_block v = precise_block(components, body, run, start, step->v);
      mean_products(components, &b, &v, F);
      precise_add(components, &b.now, F, step->out);
    }
  }
}

/* One row of the pair's tangent, g e_r + h (y0 + y1)_r y1, into F. */
SDR_INLINE void mean_row(const int components, const int row, const sdr_mean_block *b,
                         double F[3][SDR_PRECISE_BLOCK])
{
  const sdr_bond_class *class = b->now.class;
  const sdr_precise_vector xi = {class->xi[0], class->xi[1], class->xi[2]};
  const double *const restrict g = b->g, *const restrict h = b->h;
  double *const restrict fx = F[0], *const restrict fy = F[1], *const restrict fz = F[2];
#pragma omp simd
  for (int k = 0; k < b->now.count; ++k) {
    const sdr_precise_vector e0 = precise_motion(components, &b->before, k);
    const sdr_precise_vector e1 = precise_motion(components, &b->now, k);
    const double sum = row == 0   ? 2.0 * xi.x + e0.x + e1.x
                       : row == 1 ? 2.0 * xi.y + e0.y + e1.y
                                  : 2.0 * xi.z + e0.z + e1.z;
    const double along = h[k] * sum;
    fx[k] = (row == 0 ? g[k] : 0.0) + along * (xi.x + e1.x);
    if (components > 1) fy[k] = (row == 1 ? g[k] : 0.0) + along * (xi.y + e1.y);
    if (components > 2) fz[k] = (row == 2 ? g[k] : 0.0) + along * (xi.z + e1.z);
  }
}

/* To both points: the block of either is the same. */
SDR_INLINE void mean_add_row(const int components, const sdr_mean_block *b,
                             double F[3][SDR_PRECISE_BLOCK], double *const *row)
{
  for (int a = 0; a < components; ++a) {
    double *const i = row[a] + b->now.i, *const j = row[a] + b->now.j;
    const double *const value = F[a];
#pragma omp simd
    for (int k = 0; k < b->now.count; ++k) i[k] += value[k];
#pragma omp simd
    for (int k = 0; k < b->now.count; ++k) j[k] += value[k];
  }
}

SDR_INLINE void mean_diagonal_of_runs(const int components, const sdr_bond_body *body,
                                      int64_t first, int64_t end, const sdr_mean_step *step)
{
  _Alignas(64) double F[3][SDR_PRECISE_BLOCK];
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    for (int32_t start = 0; start < run->length; start += SDR_PRECISE_BLOCK) {
      const sdr_mean_block b = mean_block(components, body, run, start, step);
      for (int row = 0; row < components; ++row) {
        mean_row(components, row, &b, F);
        mean_add_row(components, &b, F, step->out + row * components);
      }
    }
  }
}

/* ---- loose pairs ----------------------------------------------------------------------------- */

/* What a chunk's points read of themselves: u0, u1 and v, and constants. */
typedef struct {
  _Alignas(64) double u0[3][SDR_LANES], u1[3][SDR_LANES], v[3][SDR_LANES];
  _Alignas(64) double c[SDR_LANES], q[SDR_LANES], r[SDR_LANES];
} sdr_mean_own;

SDR_INLINE void mean_own(const int components, const int law, const int each, const int times,
                         const sdr_bond_body *body, const int32_t *point, const sdr_mean_step *step,
                         sdr_mean_own *to)
{
  for (int a = 0; a < components; ++a) {
    load_points(step->u0[a], point, to->u0[a]);
    load_points(step->u1[a], point, to->u1[a]);
    if (times) load_points(step->v[a], point, to->v[a]);
  }
  if (!each || times) return;
  load_points(body->stiffness_at, point, to->c);
  load_points(body->threshold_at, point, to->q);
  if (law == SDR_LAW_COHESIVE) load_points(body->decline_at, point, to->r);
}

SDR_INLINE sdr_precise_vector loose_motion(const int components, double *const u[3],
                                           double own[3][SDR_LANES], int lane, int32_t j)
{
  return (sdr_precise_vector){u[0][j] - own[0][lane], components > 1 ? u[1][j] - own[1][lane] : 0.0,
                              components > 2 ? u[2][j] - own[2][lane] : 0.0};
}

SDR_INLINE sdr_precise_vector loose_bond(const int components, const sdr_loose *loose, int64_t slot)
{
  return (sdr_precise_vector){loose->xi[0][slot], components > 1 ? loose->xi[1][slot] : 0.0,
                              components > 2 ? loose->xi[2][slot] : 0.0};
}

SDR_INLINE void mean_column(const int components, const int law, const int each, const int kept,
                            const sdr_bond_body *body, sdr_mean_own *own, int64_t column,
                            const sdr_mean_step *step, double sum[3][SDR_LANES])
{
  const sdr_loose *loose = &body->bonds->loose;
  const int flagged = !sdr_law_softens(law) && body->loose_flags;
  const int second = each && law == SDR_LAW_COHESIVE;
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane;
    const int32_t j = loose->j[slot];
    const sdr_precise_vector xi = loose_bond(components, loose, slot);
    const sdr_precise_vector e0 = loose_motion(components, step->u0, own->u0, lane, j);
    const sdr_precise_vector e1 = loose_motion(components, step->u1, own->u1, lane, j);
    const double square = xi.x * xi.x + xi.y * xi.y + xi.z * xi.z;
    const sdr_mean_pair pair = {
        .length = sqrt(square),
        .wi = loose->weight_ij[slot] * (each ? own->c[lane] : body->stiffness),
        .wj = loose->weight_ji[slot] * (each ? body->stiffness_at[j] : body->stiffness),
        .qi = each ? own->q[lane] : body->threshold,
        .qj = each ? body->threshold_at[j] : body->threshold,
        .ri = second ? own->r[lane] : body->decline,
        .rj = second ? body->decline_at[j] : body->decline,
        .before = sdr_law_softens(law) ? body->loose_history[slot] : 0.0,
        .flags = flagged ? body->loose_flags[slot] : 0};
    const sdr_mean_factors of_step =
        mean_of_pair(law, each, 1, &pair, mean_stretch(components, xi, e0, 1.0 / square),
                     mean_stretch(components, xi, e1, 1.0 / square));
    if (kept) {
      step->loose_g[slot] = of_step.g;
      step->loose_h[slot] = of_step.h;
    }
    sum[0][lane] += of_step.g * (2.0 * xi.x + e0.x + e1.x);
    if (components > 1) sum[1][lane] += of_step.g * (2.0 * xi.y + e0.y + e1.y);
    if (components > 2) sum[2][lane] += of_step.g * (2.0 * xi.z + e0.z + e1.z);
  }
}

SDR_INLINE void product_column(const int components, const sdr_bond_body *body, sdr_mean_own *own,
                               int64_t column, const sdr_mean_step *step, double sum[3][SDR_LANES])
{
  const sdr_loose *loose = &body->bonds->loose;
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane;
    const int32_t j = loose->j[slot];
    const sdr_precise_vector xi = loose_bond(components, loose, slot);
    const sdr_precise_vector e0 = loose_motion(components, step->u0, own->u0, lane, j);
    const sdr_precise_vector e1 = loose_motion(components, step->u1, own->u1, lane, j);
    const sdr_precise_vector dv = loose_motion(components, step->v, own->v, lane, j);
    const double g = step->loose_g[slot];
    double along = (xi.x + e1.x) * dv.x;
    if (components > 1) along += (xi.y + e1.y) * dv.y;
    if (components > 2) along += (xi.z + e1.z) * dv.z;
    along *= step->loose_h[slot];
    sum[0][lane] -= g * dv.x + along * (2.0 * xi.x + e0.x + e1.x);
    if (components > 1) sum[1][lane] -= g * dv.y + along * (2.0 * xi.y + e0.y + e1.y);
    if (components > 2) sum[2][lane] -= g * dv.z + along * (2.0 * xi.z + e0.z + e1.z);
  }
}

/* `times`: product with the tangent that is kept, else mean force. */
SDR_INLINE void mean_of_loose(const int components, const int law, const int each, const int kept,
                              const int times, const sdr_bond_body *body, int64_t first,
                              int64_t end, const sdr_mean_step *step)
{
  const int64_t *const slot = body->bonds->loose.chunk_slot;
  for (int64_t chunk = first; chunk < end; ++chunk) {
    const int32_t *const point = body->bonds->loose.point + chunk * SDR_LANES;
    _Alignas(64) double sum[3][SDR_LANES] = {{0.0}};
    sdr_mean_own own = {0};
    mean_own(components, law, each, times, body, point, step, &own);
    for (int64_t column = slot[chunk]; column < slot[chunk + 1]; column += SDR_LANES)
      if (times)
        product_column(components, body, &own, column, step, sum);
      else
        mean_column(components, law, each, kept, body, &own, column, step, sum);
    for (int a = 0; a < components; ++a) add_to_points(sum[a], point, step->out[a]);
  }
}

#endif
