/* Loops over the loose pairs of ordinary bodies: the eight points of a chunk are the lanes, and
   each adds to itself alone. Columns without flags, where no stretch may set one, touch no flags.
 */
#ifndef SDR_MECHANICS_ORDINARY_LOOSE_H
#define SDR_MECHANICS_ORDINARY_LOOSE_H

#include "mechanics/ordinary_loop.h"
#include "mechanics/records.h"

/* One slot: the present vector from point to point (of the reference shape if linear), xi^2 and
   1/xi^2, stretch and r = 1 + stretch. */
typedef struct {
  double y[3], square, inverse, s, r;
} sdr_ordinary_slot;

/* A chunk at work: its points, what they have, and the sums of its lanes. */
typedef struct {
  _Alignas(64) double sum[SDR_LANES], square[SDR_LANES], lost[SDR_LANES], force[3][SDR_LANES];
  _Alignas(64) double u[3][SDR_LANES], along[SDR_LANES], across[SDR_LANES];
  _Alignas(64) sdr_flags fresh[SDR_LANES];
  const int32_t *point;
} sdr_ordinary_chunk;

/* What a column's neighbours have: displacements, then the coefficients of forces that fit. */
typedef struct {
  _Alignas(64) double of[SDR_RECORD][SDR_LANES];
} sdr_ordinary_others;

SDR_INLINE sdr_ordinary_slot slot_at(const int components, const int linear, const sdr_loose *loose,
                                     int64_t slot, int lane, sdr_ordinary_chunk *chunk,
                                     sdr_ordinary_others *other)
{
  sdr_ordinary_slot p = {.y = {0.0}};
  double z = 0.0;
  for (int a = 0; a < components; ++a) {
    const double xi = loose->xi[a][slot], eta = other->of[a][lane] - chunk->u[a][lane];
    p.y[a] = linear ? xi : xi + eta;
    p.square += xi * xi;
    z += linear ? xi * eta : (2.0 * xi + eta) * eta;
  }
  p.inverse = 1.0 / p.square;
  z *= p.inverse;
  const sdr_state_stretch now = linear ? (sdr_state_stretch){z, 1.0} : sdr_state_stretch_of(z);
  p.s = now.s;
  p.r = now.r;
  return p;
}

/* P and Q of a half over its weight. */
SDR_INLINE double loose_p(int printed, const sdr_ordinary_slot *p)
{
  return printed ? 1.0 : p->square;
}
SDR_INLINE double loose_q(int printed, const sdr_ordinary_slot *p)
{
  return printed ? sqrt(p->square) : p->square;
}

/* P^2/Q likewise. */
SDR_INLINE double loose_r(int printed, const sdr_ordinary_slot *p)
{
  return printed ? 1.0 / sqrt(p->square) : p->square;
}

/* What flags there are: none, some, some where all points share one threshold (no gather). */
enum { SDR_LOOSE_UNFLAGGED, SDR_LOOSE_FLAGGED, SDR_LOOSE_SHARED };

/* Flags of a slot of point i as this pass sees them. */
SDR_INLINE sdr_flags loose_flags_of(const int use, const int flagged, const sdr_ordinary *o,
                                    int64_t slot, int32_t i, double s)
{
  const sdr_flags before = o->body.loose_flags[slot];
  const double *const q = o->body.threshold, one = o->weakest;
  if (!use) return before;
  if (flagged == SDR_LOOSE_SHARED) return grown_flags(before, s, one, one);
  return grown_flags(before, s, q[i], q[o->body.bonds->loose.j[slot]]);
}

SDR_INLINE void sums_of_column(const int components, const int squares, const int use,
                               const int flagged, const int linear, sdr_ordinary *o,
                               sdr_ordinary_chunk *chunk, int64_t column)
{
  const sdr_loose *loose = &o->body.bonds->loose;
  const int printed = o->form == SDR_FORM_MADENCI_OTERKUS;
  sdr_flags *const flags = flagged ? o->body.loose_flags + column : NULL;
  sdr_ordinary_others other;
  gather_records(o->records, SDR_RECORD, loose->j + column, other.of);
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane;
    const sdr_ordinary_slot pair = slot_at(components, linear, loose, slot, lane, chunk, &other);
    const double w = loose->weight_ij[slot], p = w * loose_p(printed, &pair);
    double s = pair.s;
    if (flagged) {
      const sdr_flags grown = loose_flags_of(use, flagged, o, slot, chunk->point[lane], s);
      s = grown & SDR_LOST_I ? 0.0 : s;
      const double r = w * loose_r(printed, &pair);
      chunk->lost[lane] += (grown & (SDR_LOST_I | SDR_CUT)) == SDR_LOST_I ? r : 0.0;
      if (use) flags[lane] = grown;
      chunk->fresh[lane] |= grown;
    }
    chunk->sum[lane] += p * s;
    if (squares) chunk->square[lane] += w * loose_q(printed, &pair) * s * s;
  }
}

/* 1 if a slot of the column has a flag. */
SDR_INLINE int column_flagged(const sdr_ordinary *o, int64_t column)
{
  const sdr_flags *const flags = o->body.loose_flags + column;
  sdr_flags all = 0;
#pragma omp simd reduction(| : all)
  for (int lane = 0; lane < SDR_LANES; ++lane) all |= flags[lane];
  return all != 0;
}

/* A column without flags; returns 1 and adds nothing where a bond may break. `same`: all pairs have
   one weight; that of padding does not matter, since it has no stretch. */
SDR_INLINE int sums_of_clean(const int components, const int squares, const int use,
                             const int linear, const int same, const sdr_ordinary *o,
                             sdr_ordinary_chunk *chunk, int64_t column)
{
  _Alignas(64) double sum[SDR_LANES], square[SDR_LANES], most[SDR_LANES];
  const sdr_loose *loose = &o->body.bonds->loose;
  const double shared = loose->shared_weight, weakest = o->weakest;
  sdr_ordinary_others other;
  gather_records(o->records, SDR_RECORD, loose->j + column, other.of);
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane;
    const sdr_ordinary_slot pair = slot_at(components, linear, loose, slot, lane, chunk, &other);
    const double w = same ? shared : loose->weight_ij[slot], p = w * pair.square;
    sum[lane] = p * pair.s;
    square[lane] = squares ? p * pair.s * pair.s : 0.0;
    most[lane] = pair.s > 0.0 ? pair.s * pair.s : 0.0;
  }
  if (use) {
    int any = 0;
#pragma omp simd reduction(| : any)
    for (int lane = 0; lane < SDR_LANES; ++lane) any |= most[lane] > weakest;
    if (any) return 1;
  }
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    chunk->sum[lane] += sum[lane];
    if (squares) chunk->square[lane] += square[lane];
  }
  return 0;
}

SDR_INLINE void sums_of_any(const int components, const int squares, const int use,
                            const int flagged, const int linear, sdr_ordinary *o,
                            sdr_ordinary_chunk *chunk, int64_t column)
{
  int left = o->form == SDR_FORM_MADENCI_OTERKUS || (flagged && column_flagged(o, column));
  if (!left && o->body.bonds->loose.shared_weight != 0.0)
    left = sums_of_clean(components, squares, use, linear, 1, o, chunk, column);
  else if (!left)
    left = sums_of_clean(components, squares, use, linear, 0, o, chunk, column);
  if (left) sums_of_column(components, squares, use, flagged, linear, o, chunk, column);
}

SDR_INLINE void sums_of_loose(const int components, const int squares, const int use,
                              const int flagged, const int linear, sdr_ordinary *o, int64_t first,
                              int64_t end, double *const u[3])
{
  for (int64_t c = first; c < end; ++c) {
    const int64_t *const slot = o->body.bonds->loose.chunk_slot + c;
    sdr_ordinary_chunk chunk = {.point = o->body.bonds->loose.point + c * SDR_LANES};
    for (int a = 0; a < components; ++a) load_points(u[a], chunk.point, chunk.u[a]);
    for (int64_t column = slot[0]; column < slot[1]; column += SDR_LANES)
      sums_of_any(components, squares, use, flagged, linear, o, &chunk, column);
    sdr_flags fresh = 0;
    add_to_points(chunk.sum, chunk.point, o->sum);
    if (squares) add_to_points(chunk.square, chunk.point, o->square);
    if (o->lost) add_to_points(chunk.lost, chunk.point, o->lost);
    for (int lane = 0; lane < SDR_LANES; ++lane) fresh |= chunk.fresh[lane];
    if (use && fresh & (SDR_FRESH_I | SDR_FRESH_J)) o->body.chunk_fresh[c] = 1;
  }
}

SDR_INLINE double other_along(const int components, const sdr_ordinary_others *other, int lane)
{
  return other->of[components][lane];
}
SDR_INLINE double other_across(const int components, const sdr_ordinary *o,
                               const sdr_ordinary_others *other, int lane, int32_t j)
{
  return components < 3 ? other->of[(components + 1) % SDR_RECORD][lane] : o->across[j];
}

SDR_INLINE void force_of_column(const int components, const int flagged, const int linear,
                                const sdr_ordinary *o, sdr_ordinary_chunk *chunk, int64_t column)
{
  const sdr_loose *loose = &o->body.bonds->loose;
  const int printed = o->form == SDR_FORM_MADENCI_OTERKUS;
  sdr_ordinary_others other;
  gather_records(o->records, SDR_RECORD, loose->j + column, other.of);
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane;
    const sdr_ordinary_slot pair = slot_at(components, linear, loose, slot, lane, chunk, &other);
    const double p = loose_p(printed, &pair), q = loose_q(printed, &pair) * pair.s;
    double hi = loose->weight_ij[slot] * (p * chunk->along[lane] + q * chunk->across[lane]);
    double hj =
        loose->weight_ji[slot] * (p * other_along(components, &other, lane) +
                                  q * other_across(components, o, &other, lane, loose->j[slot]));
    if (flagged) {
      const sdr_flags flags = o->body.loose_flags[slot];
      hi = flags & SDR_LOST_I ? 0.0 : hi;
      hj = flags & SDR_LOST_J ? 0.0 : hj;
    }
    const double phi = (hi + hj) * pair.inverse / pair.r;
    for (int a = 0; a < components; ++a) chunk->force[a][lane] += phi * pair.y[a];
  }
}

/* A column without flags. Padding, which has no weight, is its own neighbour. */
SDR_INLINE void force_of_clean(const int components, const int linear, const int same,
                               const sdr_ordinary *o, sdr_ordinary_chunk *chunk, int64_t column)
{
  const sdr_loose *loose = &o->body.bonds->loose;
  const double shared = loose->shared_weight;
  sdr_ordinary_others other;
  gather_records(o->records, SDR_RECORD, loose->j + column, other.of);
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane;
    const int32_t j = loose->j[slot];
    const sdr_ordinary_slot pair = slot_at(components, linear, loose, slot, lane, chunk, &other);
    const double along_j = other_along(components, &other, lane);
    const double across_j = other_across(components, o, &other, lane, j);
    const double wi = same ? 1.0 : loose->weight_ij[slot], wj = same ? 1.0 : loose->weight_ji[slot];
    const double along = wi * chunk->along[lane] + wj * along_j;
    const double across = wi * chunk->across[lane] + wj * across_j;
    double phi = (along + across * pair.s) / pair.r;
    if (same) phi = j == chunk->point[lane] ? 0.0 : phi * shared;
    for (int a = 0; a < components; ++a) chunk->force[a][lane] += phi * pair.y[a];
  }
}

SDR_INLINE void force_of_any(const int components, const int flagged, const int linear,
                             const sdr_ordinary *o, sdr_ordinary_chunk *chunk, int64_t column)
{
  if (o->form == SDR_FORM_MADENCI_OTERKUS || (flagged && column_flagged(o, column)))
    force_of_column(components, flagged, linear, o, chunk, column);
  else if (o->body.bonds->loose.shared_weight != 0.0)
    force_of_clean(components, linear, 1, o, chunk, column);
  else
    force_of_clean(components, linear, 0, o, chunk, column);
}

SDR_INLINE void force_of_loose(const int components, const int flagged, const int linear,
                               const sdr_ordinary *o, int64_t first, int64_t end,
                               double *const u[3], double *const f[3])
{
  for (int64_t c = first; c < end; ++c) {
    const int64_t *const slot = o->body.bonds->loose.chunk_slot + c;
    sdr_ordinary_chunk chunk = {.point = o->body.bonds->loose.point + c * SDR_LANES};
    for (int a = 0; a < components; ++a) load_points(u[a], chunk.point, chunk.u[a]);
    load_points(o->along, chunk.point, chunk.along);
    load_points(o->across, chunk.point, chunk.across);
    for (int64_t column = slot[0]; column < slot[1]; column += SDR_LANES)
      force_of_any(components, flagged, linear, o, &chunk, column);
    for (int a = 0; a < components; ++a) {
      for (int lane = 0; linear && lane < SDR_LANES; ++lane) chunk.force[a][lane] *= -1.0;
      add_to_points(chunk.force[a], chunk.point, f[a]);
    }
  }
}

#endif
