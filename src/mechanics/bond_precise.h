/* Forces and energies of bond-based bodies with histories in double, for implicit integrators: they
   never commit, and critical stretch keeps the bonds that its flags say, so that energy, force and
   tangent belong to each other. `components`, `law`, `each` (moduli a point) and `marked` are
   literals where the loops are instantiated (precise_kernels.c). */
#ifndef SDR_MECHANICS_BOND_PRECISE_H
#define SDR_MECHANICS_BOND_PRECISE_H

#include "damage/bond_law.h"
#include "mechanics/bond_body.h"
#include "mechanics/records.h"

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

/* Three numbers, not an array, which would keep loops from being vectorised. */
typedef struct {
  double x, y, z;
} sdr_precise_vector;

SDR_INLINE sdr_precise_vector precise_motion(const int components, const sdr_precise_block *b,
                                             int k)
{
  return (sdr_precise_vector){b->uj[0][k] - b->ui[0][k],
                              components > 1 ? b->uj[1][k] - b->ui[1][k] : 0.0,
                              components > 2 ? b->uj[2][k] - b->ui[2][k] : 0.0};
}

/* l^2 - |xi|^2 of a pair whose end moved by e relative to its start. */
SDR_INLINE double precise_growth(const int components, sdr_precise_vector xi, sdr_precise_vector e)
{
  double sum = (2.0 * xi.x + e.x) * e.x;
  if (components > 1) sum += (2.0 * xi.y + e.y) * e.y;
  if (components > 2) sum += (2.0 * xi.z + e.z) * e.z;
  return sum;
}

/* z = l^2/|xi|^2 - 1 of the same, from arrays. */
SDR_INLINE double precise_elongation(const int components, const double xi[3], const double e[3],
                                     double inverse_square)
{
  const sdr_precise_vector from = {xi[0], xi[1], xi[2]}, by = {e[0], e[1], e[2]};
  return precise_growth(components, from, by) * inverse_square;
}

/* l/|xi|, from z = l^2/|xi|^2 - 1. */
SDR_INLINE double precise_ratio(double z)
{
  const double square = 1.0 + z;
  return sqrt(square > 1e-18 ? square : 1e-18); /* l = 0 but for rounding: no direction, no force */
}

/* ---- runs ------------------------------------------------------------------------------------ */

/* Forces on the points i of a block into F. */
SDR_INLINE void precise_forces(const int components, const int law, const int each,
                               const int marked, const sdr_bond_body *body,
                               const sdr_precise_block *b, double F[3][SDR_PRECISE_BLOCK])
{
  const sdr_bond_class *class = b->class;
  const sdr_precise_vector xi = {class->xi[0], class->xi[1], class->xi[2]};
  const double square = class->inverse_square, wi = class->by_length_ij, wj = class->by_length_ji;
  double *const restrict fx = F[0], *const restrict fy = F[1], *const restrict fz = F[2];
#pragma omp simd
  for (int k = 0; k < b->count; ++k) {
    const sdr_precise_vector e = precise_motion(components, b, k);
    const double z = precise_growth(components, xi, e) * square;
    const double ratio = precise_ratio(z), s = z / (1.0 + ratio);
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
    fx[k] = phi * (xi.x + e.x);
    if (components > 1) fy[k] = phi * (xi.y + e.y);
    if (components > 2) fz[k] = phi * (xi.z + e.z);
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

/* History of a block: the largest stretch so far. Few bonds reach a new one, which z > k (2 + k)
   tells without a root; `slack` is more than rounding. Negative ones are marks. */
SDR_INLINE void precise_commit(const int components, const sdr_precise_block *b, double *history)
{
  const double slack = 1e-12;
  const sdr_bond_class *class = b->class;
  const sdr_precise_vector xi = {class->xi[0], class->xi[1], class->xi[2]};
  const double square = class->inverse_square;
  double most = 0.0;
#pragma omp simd reduction(max : most)
  for (int k = 0; k < b->count; ++k) {
    const double z = precise_growth(components, xi, precise_motion(components, b, k)) * square;
    const double over = z * (1.0 + slack) - history[k] * (2.0 + history[k]);
    most = most > over ? most : over;
  }
  if (!(most > 0.0)) return;
#pragma omp simd
  for (int k = 0; k < b->count; ++k) {
    const double z = precise_growth(components, xi, precise_motion(components, b, k)) * square;
    const double s = z / (1.0 + precise_ratio(z)), before = history[k];
    const double now = s > before ? s : before;
    history[k] = before < 0.0 ? before : now;
  }
}

SDR_INLINE void precise_commit_of_runs(const int components, const sdr_bond_body *body,
                                       int64_t first, int64_t end, double *const u[3])
{
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    for (int32_t start = 0; start < run->length; start += SDR_PRECISE_BLOCK) {
      const sdr_precise_block b = precise_block(components, body, run, start, u);
      precise_commit(components, &b, body->history + run->slot + start);
    }
  }
}

SDR_INLINE void precise_energies(const int components, const int law, const int each,
                                 const int marked, const sdr_bond_body *body,
                                 const sdr_precise_block *b, sdr_stripe_energies *sum)
{
  const sdr_bond_class *class = b->class;
  const sdr_precise_vector xi = {class->xi[0], class->xi[1], class->xi[2]};
  const double wi = class->weight_ij * class->length, wj = class->weight_ji * class->length;
  const double ni = wi > 0.0 ? 1.0 : 0.0, nj = wj > 0.0 ? 1.0 : 0.0; /* bond present */
  const double square = class->inverse_square;
  double stored = 0.0, dissipated = 0.0, most = sum->max_damage, broken = 0.0;
#pragma omp simd reduction(+ : stored, dissipated, broken) reduction(max : most)
  for (int k = 0; k < b->count; ++k) {
    const double z = precise_growth(components, xi, precise_motion(components, b, k)) * square;
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

/* One slot: a pair as the point of its lane sees it. Padding has weights of zero. */
typedef struct {
  sdr_precise_vector now;                     /* from i to j, as they are */
  double length, ratio, weight_ij, weight_ji; /* weights times C; no weight: no bond */
  sdr_bond_answer ij, ji;
  sdr_flags flags;
} sdr_precise_slot;

/* Where the slots of a chunk are found: by value, so that loops keep the pointers in registers. */
typedef struct {
  const int32_t *j;
  const double *x, *y, *z, *weight_ij, *weight_ji, *history;
  const double *ux, *uy, *uz;
  const double *c, *q, *r; /* a point; NULL: shared */
  const sdr_flags *flags;
  double shared_c, shared_q, shared_r;
} sdr_precise_loose;

SDR_INLINE sdr_precise_loose precise_loose(const sdr_bond_body *body, double *const u[3])
{
  const sdr_loose *loose = &body->bonds->loose;
  return (sdr_precise_loose){.j = loose->j,
                             .x = loose->xi[0],
                             .y = loose->xi[1],
                             .z = loose->xi[2],
                             .weight_ij = loose->weight_ij,
                             .weight_ji = loose->weight_ji,
                             .history = body->loose_history,
                             .ux = u[0],
                             .uy = u[1],
                             .uz = u[2],
                             .c = body->stiffness_at,
                             .q = body->threshold_at,
                             .r = body->decline_at,
                             .flags = body->loose_flags,
                             .shared_c = body->stiffness,
                             .shared_q = body->threshold,
                             .shared_r = body->decline};
}

/* Displacements and constants of a chunk's points. */
typedef struct {
  _Alignas(64) double x[SDR_LANES], y[SDR_LANES], z[SDR_LANES];
  _Alignas(64) double c[SDR_LANES], q[SDR_LANES], r[SDR_LANES];
} sdr_precise_own;

SDR_INLINE void precise_own(const int components, const int law, const int each,
                            const sdr_precise_loose in, const int32_t *point, sdr_precise_own *to)
{
  load_points(in.ux, point, to->x);
  if (components > 1) load_points(in.uy, point, to->y);
  if (components > 2) load_points(in.uz, point, to->z);
  if (!each) return;
  load_points(in.c, point, to->c);
  load_points(in.q, point, to->q);
  if (law == SDR_LAW_COHESIVE) load_points(in.r, point, to->r);
}

SDR_INLINE sdr_precise_slot precise_slot(const int components, const int law, const int each,
                                         const int flagged, const sdr_precise_loose in,
                                         const sdr_precise_own *own, int lane, int64_t slot)
{
  const int32_t j = in.j[slot];
  const sdr_precise_vector xi = {in.x[slot], components > 1 ? in.y[slot] : 0.0,
                                 components > 2 ? in.z[slot] : 0.0};
  const sdr_precise_vector e = {in.ux[j] - own->x[lane],
                                components > 1 ? in.uy[j] - own->y[lane] : 0.0,
                                components > 2 ? in.uz[j] - own->z[lane] : 0.0};
  const double square = xi.x * xi.x + xi.y * xi.y + xi.z * xi.z;
  const double z = precise_growth(components, xi, e) / square;
  const double ratio = precise_ratio(z), s = z / (1.0 + ratio);
  const int second = each && law == SDR_LAW_COHESIVE;
  const double qi = each ? own->q[lane] : in.shared_q, qj = each ? in.q[j] : in.shared_q;
  const double ri = second ? own->r[lane] : in.shared_r, rj = second ? in.r[j] : in.shared_r;
  const double before = sdr_law_softens(law) ? in.history[slot] : 0.0;
  const sdr_flags flags = flagged ? in.flags[slot] : 0;
  return (sdr_precise_slot){{xi.x + e.x, xi.y + e.y, xi.z + e.z},
                            sqrt(square),
                            ratio,
                            in.weight_ij[slot] * (each ? own->c[lane] : in.shared_c),
                            in.weight_ji[slot] * (each ? in.c[j] : in.shared_c),
                            precise_answer(law, 1, s, before, flags & SDR_LOST_I, qi, ri),
                            precise_answer(law, 1, s, before, flags & SDR_LOST_J, qj, rj),
                            flags};
}

/* A column of a chunk of eight points, one slot each. */
SDR_INLINE void precise_column(const int components, const int law, const int each,
                               const int flagged, const sdr_precise_loose in,
                               const sdr_precise_own *own, int64_t column, double sum[3][SDR_LANES])
{
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const sdr_precise_slot p =
        precise_slot(components, law, each, flagged, in, own, lane, column + lane);
    const double phi = (p.weight_ij * p.ij.force + p.weight_ji * p.ji.force) / (p.length * p.ratio);
    sum[0][lane] += phi * p.now.x;
    if (components > 1) sum[1][lane] += phi * p.now.y;
    if (components > 2) sum[2][lane] += phi * p.now.z;
  }
}

SDR_INLINE void precise_force_of_loose(const int components, const int law, const int each,
                                       const sdr_bond_body *body, int64_t first, int64_t end,
                                       double *const u[3], double *const f[3])
{
  const int64_t *const slot = body->bonds->loose.chunk_slot;
  const int flagged = !sdr_law_softens(law) && body->loose_flags;
  const sdr_precise_loose in = precise_loose(body, u);
  for (int64_t chunk = first; chunk < end; ++chunk) {
    const int32_t *const point = body->bonds->loose.point + chunk * SDR_LANES;
    _Alignas(64) double sum[3][SDR_LANES] = {{0.0}};
    sdr_precise_own own = {0};
    precise_own(components, law, each, in, point, &own);
    for (int64_t column = slot[chunk]; column < slot[chunk + 1]; column += SDR_LANES)
      if (flagged)
        precise_column(components, law, each, 1, in, &own, column, sum);
      else
        precise_column(components, law, each, 0, in, &own, column, sum);
    for (int a = 0; a < components; ++a) add_to_points(sum[a], point, f[a]);
  }
}

/* Each slot books the directed bond of its own lane. */
SDR_INLINE void precise_column_energies(const int components, const int law, const int each,
                                        const int flagged, const sdr_precise_loose in,
                                        const sdr_precise_own *own, int64_t column,
                                        sdr_stripe_energies *sum)
{
  double stored = 0.0, dissipated = 0.0, most = sum->max_damage, broken = 0.0;
#pragma omp simd reduction(+ : stored, dissipated, broken) reduction(max : most)
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const sdr_precise_slot p =
        precise_slot(components, law, each, flagged, in, own, lane, column + lane);
    const double weight = p.weight_ij * p.length;
    const double kept = 1.0 - (double)((p.flags & SDR_CUT) / SDR_CUT);
    const double present = weight > 0.0 ? kept : 0.0;
    const double damage = present * p.ij.damage;
    stored += weight * p.ij.stored;
    dissipated += weight * p.ij.dissipated;
    broken += damage > 0.5 ? 1.0 : 0.0;
    most = most > damage ? most : damage;
  }
  sum->stored += stored;
  sum->dissipated += dissipated;
  sum->broken += (int64_t)broken;
  sum->max_damage = most;
}

SDR_INLINE void precise_energies_of_loose(const int components, const int law, const int each,
                                          const sdr_bond_body *body, int64_t first, int64_t end,
                                          double *const u[3], sdr_stripe_energies *sum)
{
  const int64_t *const slot = body->bonds->loose.chunk_slot;
  const int flagged = !sdr_law_softens(law) && body->loose_flags;
  const sdr_precise_loose in = precise_loose(body, u);
  for (int64_t chunk = first; chunk < end; ++chunk) {
    sdr_precise_own own = {0};
    precise_own(components, law, each, in, body->bonds->loose.point + chunk * SDR_LANES, &own);
    for (int64_t column = slot[chunk]; column < slot[chunk + 1]; column += SDR_LANES)
      if (flagged)
        precise_column_energies(components, law, each, 1, in, &own, column, sum);
      else
        precise_column_energies(components, law, each, 0, in, &own, column, sum);
  }
}

#endif
