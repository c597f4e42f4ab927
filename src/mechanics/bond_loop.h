/* The loops over bonds, written once. `components`, `law`, `each` (moduli a point) and `marked` are
   literals where these functions are instantiated (bond_kernels.c), so that nothing of what a scene
   does not need is left in the loop. */
#ifndef SDR_MECHANICS_BOND_LOOP_H
#define SDR_MECHANICS_BOND_LOOP_H

#include "damage/bond_law.h"
#include "mechanics/bond_body.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SDR_INLINE static inline __attribute__((always_inline))

enum {
  SDR_BLOCK = 256, /* pairs a block: its forces wait in the first-level cache */
  SDR_BAND = 5,    /* most runs whose forces are added up together */
  SDR_SHIFT = 8,   /* points by which they may begin and end apart from the first of them */
  SDR_MARGIN = 2 * SDR_SHIFT
};

/* a b + c, rounded once where the processor can; the same way in every variant of a loop, so that
   leaving something out changes no bit. */
#if defined __FP_FAST_FMA || defined __FMA__
#define SDR_FMA_double(a, b, c) __builtin_fma(a, b, c)
#define SDR_FMA_float(a, b, c) __builtin_fmaf(a, b, c)
#else
#define SDR_FMA_double(a, b, c) ((a) * (b) + (c))
#define SDR_FMA_float(a, b, c) ((a) * (b) + (c))
#endif

/* A block of a run's pairs: pointers to the first pair's points and slot. */
typedef struct {
  const sdr_bond_class *class;
  const double *ui[3], *uj[3];
  int64_t i, j;
  const int32_t *place_i[3], *place_j[3]; /* mixed */
  const double *ci_double, *cj_double, *qi_double, *qj_double;
  const double *ri, *rj; /* second constant of a law, where points have their own */
  const float *ci_float, *cj_float, *qi_float, *qj_float; /* mixed */
  float *stretch;
  sdr_flags *flags;
  float *new_stretch;   /* where the present history goes: to `stretch`, or nowhere */
  sdr_flags *new_flags; /* likewise */
  double limit;         /* critical stretch: z = (l/|xi|)^2 - 1 up to which no bond breaks */
  int count;
} sdr_block;

SDR_INLINE void mixed_block_at(const int components, const sdr_bond_body *body, int64_t i,
                               int64_t j, sdr_block *block)
{
  for (int a = 0; a < components; ++a) {
    block->place_i[a] = body->place[a] + i;
    block->place_j[a] = body->place[a] + j;
  }
  if (!body->relative_stiffness) return;
  block->ci_float = body->relative_stiffness + i;
  block->cj_float = body->relative_stiffness + j;
  block->qi_float = body->float_threshold + i;
  block->qj_float = body->float_threshold + j;
}

/* The pairs of a run with i in [from, end), at most SDR_BLOCK; their count is <= 0 if there are
   none. */
SDR_INLINE sdr_block block_at(const int components, const sdr_bond_body *body,
                              const sdr_bond_run *run, int32_t from, int32_t end,
                              double *const u[3])
{
  const int32_t start = from > run->i0 ? from - run->i0 : 0, behind = end - run->i0;
  const int64_t i = run->i0 + start, j = run->j0 + start, slot = run->slot + start;
  sdr_block block = {.class = &body->bonds->classes[run->class_index], .i = i, .j = j};
  block.count = (run->length < behind ? run->length : behind) - start;
  for (int a = 0; a < components; ++a) {
    block.ui[a] = u[a] + i;
    block.uj[a] = u[a] + j;
  }
  if (body->stiffness_at) {
    block.ci_double = body->stiffness_at + i;
    block.cj_double = body->stiffness_at + j;
    block.qi_double = body->threshold_at + i;
    block.qj_double = body->threshold_at + j;
  }
  if (body->decline_at) {
    block.ri = body->decline_at + i;
    block.rj = body->decline_at + j;
  }
  if (body->mixed) mixed_block_at(components, body, i, j, &block);
  if (body->stretch) block.stretch = body->stretch + slot;
  if (body->flags) block.flags = body->flags + slot;
  return block;
}

/* What the history k of a block's pair has left of its bond i -> j, or j -> i. */
SDR_INLINE sdr_softening block_softening(const int law, const int each, const sdr_bond_body *body,
                                         const sdr_block *block, int k, const int of_j, double kept)
{
  const int second = each && law == SDR_LAW_COHESIVE;
  const double q = !each ? body->threshold : of_j ? block->qj_double[k] : block->qi_double[k];
  const double r = !second ? body->decline : of_j ? block->rj[k] : block->ri[k];
  return sdr_softening_of(law, kept, q, r);
}

/* The block that begins with the pair `start` of a run. */
SDR_INLINE sdr_block run_block(const int components, const sdr_bond_body *body,
                               const sdr_bond_run *run, int32_t start, double *const u[3])
{
  const int32_t from = run->i0 + start, rest = run->length - start;
  return block_at(components, body, run, from, from + (rest < SDR_BLOCK ? rest : SDR_BLOCK), u);
}

/* Runs [run, run_end) of a band, with i in [from, end); `last`: where the band's points i end;
   `runs_end`: where all runs at hand do. */
typedef struct {
  int64_t run, run_end, runs_end;
  int32_t from, end, last;
} sdr_band_piece;

/* 1 if two runs begin and end so near each other on both sides that their forces may be added up
   together. */
SDR_INLINE int run_joins(const sdr_bond_run *a, const sdr_bond_run *b)
{
  const int32_t i = a->i0 - b->i0, j = a->j0 - b->j0, longer = a->length - b->length;
  return abs(i) <= SDR_SHIFT && abs(j) <= SDR_SHIFT && abs(i + longer) <= SDR_SHIFT &&
         abs(j + longer) <= SDR_SHIFT;
}

/* The band that begins with piece->run: sets run_end (at most what it is), from and last. */
SDR_INLINE void find_band(const sdr_bond_run *runs, sdr_band_piece *piece)
{
  const sdr_bond_run *const first = &runs[piece->run];
  int64_t r = piece->run + 1;
  int32_t last = first->i0 + first->length;
  piece->from = first->i0;
  for (; r < piece->run_end && r - piece->run < SDR_BAND && run_joins(&runs[r], first); ++r) {
    const int32_t end = runs[r].i0 + runs[r].length;
    if (runs[r].i0 < piece->from) piece->from = runs[r].i0;
    if (end > last) last = end;
  }
  piece->run_end = r;
  piece->last = last;
}

/* Have the history of a run's pairs with i in [from, end) on its way to the first-level cache: each
   block is too short for the processor to see that it will want more. */
SDR_INLINE void fetch_history(const int law, const sdr_bond_body *body, int64_t r, int32_t from,
                              int32_t end)
{
  const sdr_bond_run *run = &body->bonds->runs[r];
  const int32_t start = from > run->i0 ? from - run->i0 : 0, behind = end - run->i0;
  const int32_t last = run->length < behind ? run->length : behind;
  if (law == SDR_LAW_NONE || (law == SDR_LAW_CRITICAL_STRETCH && !body->run_flagged[r])) return;
  const char *const history =
      law == SDR_LAW_CRITICAL_STRETCH ? (const char *)body->flags : (const char *)body->stretch;
  for (int32_t k = start; k < last; k += 16) __builtin_prefetch(history + 4 * (run->slot + k), 1);
}

/* The history that is wanted after the piece's run r; the list of runs ends at `end`. */
SDR_INLINE void fetch_next(const int law, const sdr_bond_body *body, const sdr_band_piece *piece,
                           int64_t r, int64_t end)
{
  const int64_t next = piece->run_end;
  if (r + 1 < next) {
    fetch_history(law, body, r + 1, piece->from, piece->end);
  } else if (piece->end < piece->last) {
    fetch_history(law, body, piece->run, piece->end, piece->end + SDR_BLOCK);
  } else if (next < end) {
    const int32_t from = body->bonds->runs[next].i0;
    fetch_history(law, body, next, from, from + SDR_BLOCK);
  }
}

/* Pairs of a block and those after them up to a whole line of slots, which are nobody's. */
SDR_INLINE int whole_lines(const sdr_block *block)
{
  return (block->count + 15) / 16 * 16;
}

/* 1 if a bond of the block was lost and is not booked. */
SDR_INLINE int fresh_in(const sdr_block *block)
{
  sdr_flags fresh = 0;
#pragma omp simd reduction(| : fresh)
  for (int k = 0; k < block->count; ++k) fresh |= block->flags[k];
  return (fresh & (SDR_FRESH_I | SDR_FRESH_J)) != 0;
}

/* What the pairs of a class share: reference vector, 1/xi^2, weights over length. */
typedef struct {
  double xi[3], inverse_square, wij, wji;
} sdr_terms_double;

SDR_INLINE sdr_terms_double terms_of_double(const sdr_bond_body *body, const sdr_bond_class *class)
{
  (void)body;
  return (sdr_terms_double){{class->xi[0], class->xi[1], class->xi[2]},
                            class->inverse_square,
                            class->by_length_ij,
                            class->by_length_ji};
}

SDR_INLINE sdr_terms_float terms_of_float(const sdr_bond_body *body, const sdr_bond_class *class)
{
  return body->float_terms[class - body->bonds->classes];
}

#define SDR_REAL double
#define SDR_MEND(of, phi) (phi)
#define SDR_BITS(body, components, F, count) 0
#define SDR_WHOLE double
#define SDR_WIDE(sum) (sum)
#define SDR_NAMED(name) name##_double
#define SDR_SQRT sqrt
#define SDR_SMALLEST 1e-18
#define SDR_ABS fabs
#define SDR_FMA SDR_FMA_double
#define SDR_SUM(unit, sum, f) ((unit) * (sum) + (f))
#define SDR_FORCE_UNIT(body) ((void)(body), 1.0)
#define SDR_SHARED_STIFFNESS(body) ((body)->stiffness)
#define SDR_DIFFERENCE(a) (block->uj[a][k] - block->ui[a][k])
#include "mechanics/bond_force.h"
#undef SDR_REAL
#undef SDR_MEND
#undef SDR_BITS
#undef SDR_WHOLE
#undef SDR_WIDE
#undef SDR_NAMED
#undef SDR_SQRT
#undef SDR_SMALLEST
#undef SDR_ABS
#undef SDR_FMA
#undef SDR_FORCE_UNIT
#undef SDR_SHARED_STIFFNESS
#undef SDR_DIFFERENCE

#include "mechanics/bond_whole.h"

/* A pair's factor with what rounding took from its class's stiffness. */
SDR_INLINE float mended(float rest, float phi)
{
  return SDR_FMA_float(phi, rest, phi);
}

/* Lengths in whole units of body->length_unit, forces in those of body->force_unit, as
   bond_mixed.c chooses them. A pair's force is C w (unit/|xi|) (s/r) ((xi + eta)/unit). */
#define SDR_REAL float
#define SDR_MEND(of, phi) mended((of).rest, phi)
#define SDR_BITS(body, components, F, count) ((body)->watch ? bits_of(components, F, count) : 0)
#define SDR_WHOLE int32_t
#define SDR_WIDE(sum) ((double)(sum))
#define SDR_NAMED(name) name##_float
#define SDR_SQRT sqrtf
#define SDR_SMALLEST 1e-9f
#define SDR_ABS fabsf
#define SDR_FMA SDR_FMA_float
#define SDR_FORCE_UNIT(body) ((body)->force_unit)
#define SDR_SHARED_STIFFNESS(body) ((void)(body), 1.0)
#define SDR_DIFFERENCE(a)                                                                          \
  ((float)(int32_t)((uint32_t)block->place_j[a][k] - (uint32_t)block->place_i[a][k]))
#include "mechanics/bond_force.h"

/* The most that the places of a bond's ends differ in one component. */
SDR_INLINE int32_t apart_of_runs(const int components, const sdr_bond_body *body, int64_t first,
                                 int64_t end)
{
  int32_t most = 0;
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    for (int a = 0; a < components; ++a) {
      const int32_t *const from = body->place[a] + run->i0, *const to = body->place[a] + run->j0;
#pragma omp simd reduction(max : most)
      for (int32_t k = 0; k < run->length; ++k) {
        const int32_t apart = amount_bits((int32_t)((uint32_t)to[k] - (uint32_t)from[k]));
        most = apart > most ? apart : most;
      }
    }
  }
  return most;
}

/* ---- the reference tangent, for the stable step ---------------------------------------------- */

/* f_i -= F, f_j += F, one side after the other, since a run along its own row overlaps itself. */
SDR_INLINE void add_times(const int components, const sdr_block *block, double F[3][SDR_BLOCK],
                          double *const f[3])
{
  for (int a = 0; a < components; ++a) {
    double *const fi = f[a] + block->i, *const fj = f[a] + block->j;
    const double *const force = F[a];
#pragma omp simd
    for (int k = 0; k < block->count; ++k) fi[k] -= force[k];
#pragma omp simd
    for (int k = 0; k < block->count; ++k) fj[k] += force[k];
  }
}

/* Opposite sign of a force: K v = -df. */
SDR_INLINE void reference_of_runs(const int components, const int each, const sdr_bond_body *body,
                                  int64_t first, int64_t end, double *const v[3],
                                  double *const f[3])
{
  _Alignas(64) double F[3][SDR_BLOCK];
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    const sdr_bond_class *class = &body->bonds->classes[run->class_index];
    const double cube = class->length * class->length * class->length;
    const double wij = class->weight_ij / cube, wji = class->weight_ji / cube;
    const double xx = class->xi[0], xy = class->xi[1], xz = class->xi[2];
    for (int32_t start = 0; start < run->length; start += SDR_BLOCK) {
      const sdr_block b = run_block(components, body, run, start, v);
#pragma omp simd
      for (int k = 0; k < b.count; ++k) {
        double along = xx * (b.uj[0][k] - b.ui[0][k]);
        if (components > 1) along += xy * (b.uj[1][k] - b.ui[1][k]);
        if (components > 2) along += xz * (b.uj[2][k] - b.ui[2][k]);
        const double stiffness =
            each ? wij * b.ci_double[k] + wji * b.cj_double[k] : (wij + wji) * body->stiffness;
        F[0][k] = stiffness * along * xx;
        if (components > 1) F[1][k] = stiffness * along * xy;
        if (components > 2) F[2][k] = stiffness * along * xz;
      }
      add_times(components, &b, F, f);
    }
  }
}

/* ---- energies -------------------------------------------------------------------------------- */

/* Energies of one directed bond with elastic energy `half` s^2, half = 1/2 w C |xi|. */
typedef struct {
  double stored, dissipated, damage;
} sdr_directed_energy;

/* `intact`: 1 - d. */
SDR_INLINE sdr_directed_energy variational_energy(const int marked, double half, double s, float k,
                                                  double q, double intact)
{
  const double damage = 1.0 - intact, left = s > 0.0 ? intact * intact : 1.0;
  sdr_directed_energy e = {half * left * s * s, half * q * damage * damage, damage};
  if (marked) {
    e.stored = k == SDR_STRETCH_CUT ? 0.0 : k == SDR_STRETCH_PROTECTED ? half * s * s : e.stored;
    e.dissipated = k < 0.0f ? 0.0 : e.dissipated;
    e.damage = k < 0.0f ? 0.0 : e.damage;
  }
  return e;
}

/* The same of any law that softens; `soft`: of the history k. */
SDR_INLINE sdr_directed_energy softened_energy(const int marked, double half, double s, float k,
                                               sdr_softening soft)
{
  const double left = s > 0.0 ? soft.left : 1.0;
  sdr_directed_energy e = {half * left * s * s, 2.0 * half * soft.dissipated, soft.damage};
  if (marked) {
    e.stored = k == SDR_STRETCH_CUT ? 0.0 : k == SDR_STRETCH_PROTECTED ? half * s * s : e.stored;
    e.dissipated = k < 0.0f ? 0.0 : e.dissipated;
    e.damage = k < 0.0f ? 0.0 : e.damage;
  }
  return e;
}

SDR_INLINE sdr_directed_energy flag_energy(double half, double s, sdr_flags flags, int lost)
{
  const int gone = flags & lost;
  return (sdr_directed_energy){gone ? 0.0 : half * s * s, 0.0,
                               gone && !(flags & SDR_CUT) ? 1.0 : 0.0};
}

SDR_INLINE void energies_of_block(const int components, const int law, const int each,
                                  const int marked, const sdr_bond_body *body, const sdr_block *b,
                                  const sdr_bond_class *class, sdr_stripe_energies *sum)
{
  const sdr_terms_double of = terms_of_double(body, class);
  const double wij = 0.5 * class->weight_ij * class->length;
  const double wji = 0.5 * class->weight_ji * class->length;
  const double ni = wij > 0.0 ? 1.0 : 0.0, nj = wji > 0.0 ? 1.0 : 0.0; /* bond present */
  double stored = 0.0, dissipated = 0.0, most = sum->max_damage, broken = 0.0;
#pragma omp simd reduction(+ : stored, dissipated, broken) reduction(max : most)
  for (int k = 0; k < b->count; ++k) {
    const double s = stretch_of_double(pair_elongation_double(components, &of, b, k)).s;
    const double hi = wij * (each ? b->ci_double[k] : body->stiffness);
    const double hj = wji * (each ? b->cj_double[k] : body->stiffness);
    const double qi = each ? b->qi_double[k] : body->threshold,
                 qj = each ? b->qj_double[k] : body->threshold;
    sdr_directed_energy i = {hi * s * s, 0.0, 0.0}, j = {hj * s * s, 0.0, 0.0};
    if (law == SDR_LAW_VARIATIONAL) {
      const float grown = grown_stretch_double(marked, b->stretch[k], s);
      const double kk = (double)grown * (double)grown, a = kk + qi, c = kk + qj;
      const double both = 1.0 / (a * c);
      i = variational_energy(marked, hi, s, grown, qi, qi * c * both);
      j = variational_energy(marked, hj, s, grown, qj, qj * a * both);
    } else if (sdr_law_softens(law)) {
      const float grown = grown_stretch_double(marked, b->stretch[k], s);
      const double kept = grown > 0.0f ? (double)grown : 0.0;
      i = softened_energy(marked, hi, s, grown, block_softening(law, each, body, b, k, 0, kept));
      j = softened_energy(marked, hj, s, grown, block_softening(law, each, body, b, k, 1, kept));
    } else if (law == SDR_LAW_CRITICAL_STRETCH || marked) {
      /* critical_stretch breaks in commit: the energies are those of the present bonds */
      i = flag_energy(hi, s, b->flags[k], SDR_LOST_I);
      j = flag_energy(hj, s, b->flags[k], SDR_LOST_J);
    }
    stored += i.stored + j.stored;
    dissipated += i.dissipated + j.dissipated;
    broken += (i.damage > 0.5 ? ni : 0.0) + (j.damage > 0.5 ? nj : 0.0);
    const double larger = ni * i.damage > nj * j.damage ? ni * i.damage : nj * j.damage;
    most = most > larger ? most : larger;
  }
  sum->stored += stored;
  sum->dissipated += dissipated;
  sum->broken += (int64_t)broken;
  sum->max_damage = most;
}

SDR_INLINE void energies_of_runs(const int components, const int law, const int each,
                                 const sdr_bond_body *body, int64_t first, int64_t end,
                                 double *const u[3], sdr_stripe_energies *sum)
{
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    const sdr_bond_class *class = &body->bonds->classes[run->class_index];
    const int marked = body->run_marked && body->run_marked[r];
    for (int32_t start = 0; start < run->length; start += SDR_BLOCK) {
      const sdr_block block = run_block(components, body, run, start, u);
      if (marked)
        energies_of_block(components, law, each, 1, body, &block, class, sum);
      else
        energies_of_block(components, law, each, 0, body, &block, class, sum);
    }
  }
}

/* ---- damage of points ------------------------------------------------------------------------ */

/* Add a block's d_ij V_j to i and d_ji V_i to j, over bonds that are there. */
SDR_INLINE void damage_of_block(const int components, const int law, const int each,
                                const sdr_bond_body *body, const sdr_block *b,
                                const sdr_bond_class *class, const double *vi, const double *vj,
                                double F[3][SDR_BLOCK])
{
  const sdr_terms_double of = terms_of_double(body, class);
  const double ni = class->weight_ij > 0.0 ? 1.0 : 0.0, nj = class->weight_ji > 0.0 ? 1.0 : 0.0;
#pragma omp simd
  for (int k = 0; k < b->count; ++k) {
    double di = 0.0, dj = 0.0;
    if (law == SDR_LAW_VARIATIONAL) {
      const double z = pair_elongation_double(components, &of, b, k);
      const float grown = grown_stretch_double(1, b->stretch[k], stretch_of_double(z).s);
      const double kk = grown > 0.0f ? (double)grown * (double)grown : 0.0;
      const double cut = grown == SDR_STRETCH_CUT ? 1.0 : 0.0;
      di = kk / (kk + (each ? b->qi_double[k] : body->threshold)) + cut;
      dj = kk / (kk + (each ? b->qj_double[k] : body->threshold)) + cut;
    } else if (sdr_law_softens(law)) {
      const double z = pair_elongation_double(components, &of, b, k);
      const float grown = grown_stretch_double(1, b->stretch[k], stretch_of_double(z).s);
      const double kept = grown > 0.0f ? (double)grown : 0.0;
      const double cut = grown == SDR_STRETCH_CUT ? 1.0 : 0.0;
      di = block_softening(law, each, body, b, k, 0, kept).damage + cut;
      dj = block_softening(law, each, body, b, k, 1, kept).damage + cut;
    } else {
      di = b->flags[k] & SDR_LOST_I ? 1.0 : 0.0;
      dj = b->flags[k] & SDR_LOST_J ? 1.0 : 0.0;
    }
    F[0][k] = ni * di * vj[k];
    F[1][k] = nj * dj * vi[k];
  }
}

SDR_INLINE void damage_of_runs(const int components, const int law, const int each,
                               const sdr_bond_body *body, int64_t first, int64_t end,
                               double *const u[3], double *sum)
{
  const double *const volume = body->points->volume;
  _Alignas(64) double F[3][SDR_BLOCK];
  if (!sdr_law_softens(law) && !body->flags) return;
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    const sdr_bond_class *class = &body->bonds->classes[run->class_index];
    for (int32_t start = 0; start < run->length; start += SDR_BLOCK) {
      const sdr_block b = run_block(components, body, run, start, u);
      const int64_t i = run->i0 + start, j = run->j0 + start;
      damage_of_block(components, law, each, body, &b, class, volume + i, volume + j, F);
#pragma omp simd
      for (int k = 0; k < b.count; ++k) sum[i + k] += F[0][k];
#pragma omp simd
      for (int k = 0; k < b.count; ++k) sum[j + k] += F[1][k];
    }
  }
}

#endif
