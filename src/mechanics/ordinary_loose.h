/* Loops over the loose pairs of ordinary bodies: the eight points of a chunk are the lanes, and
   each adds to itself alone. Columns without flags, where no stretch may set one, touch no flags.
 */
#ifndef SDR_MECHANICS_ORDINARY_LOOSE_H
#define SDR_MECHANICS_ORDINARY_LOOSE_H

#include "mechanics/ordinary_loop.h"

/* One slot: the present vector from point to point (of the reference shape if linear), xi^2 and
   1/xi^2, stretch and r = 1 + stretch. */
typedef struct {
  double y[3], square, inverse, s, r;
} sdr_ordinary_slot;

SDR_INLINE sdr_ordinary_slot slot_at(const int components, const int linear, const sdr_loose *loose,
                                     int64_t slot, int64_t i, double *const u[3])
{
  const int32_t j = loose->j[slot];
  sdr_ordinary_slot p = {.y = {0.0}};
  double z = 0.0;
  for (int a = 0; a < components; ++a) {
    const double xi = loose->xi[a][slot], eta = u[a][j] - u[a][i];
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

/* Flags of a slot as this pass sees them. */
SDR_INLINE sdr_flags loose_flags_of(const int use, const int flagged, const sdr_ordinary *o,
                                    int64_t slot, int64_t i, double s)
{
  const sdr_flags before = o->body.loose_flags[slot];
  const double *const q = o->body.threshold, one = o->weakest;
  if (!use) return before;
  if (flagged == SDR_LOOSE_SHARED) return grown_flags(before, s, one, one);
  return grown_flags(before, s, q[i], q[o->body.bonds->loose.j[slot]]);
}

/* A chunk at work: its first point, and the sums of its lanes. */
typedef struct {
  _Alignas(64) double sum[SDR_LANES], square[SDR_LANES], lost[SDR_LANES], force[3][SDR_LANES];
  _Alignas(64) sdr_flags fresh[SDR_LANES];
  int64_t point;
  double *const *u;
} sdr_ordinary_chunk;

SDR_INLINE void sums_of_column(const int components, const int squares, const int use,
                               const int flagged, const int linear, sdr_ordinary *o,
                               sdr_ordinary_chunk *chunk, int64_t column)
{
  const sdr_loose *loose = &o->body.bonds->loose;
  const int printed = o->form == SDR_FORM_MADENCI_OTERKUS;
  sdr_flags *const flags = flagged ? o->body.loose_flags + column : NULL;
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane, i = chunk->point + lane;
    const sdr_ordinary_slot pair = slot_at(components, linear, loose, slot, i, chunk->u);
    const double w = loose->weight_ij[slot], p = w * loose_p(printed, &pair);
    double s = pair.s;
    if (flagged) {
      const sdr_flags grown = loose_flags_of(use, flagged, o, slot, i, s);
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
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane;
    const sdr_ordinary_slot pair =
        slot_at(components, linear, loose, slot, chunk->point + lane, chunk->u);
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
    sdr_ordinary_chunk chunk = {.point = c * SDR_LANES, .u = u};
    for (int64_t column = slot[0]; column < slot[1]; column += SDR_LANES)
      sums_of_any(components, squares, use, flagged, linear, o, &chunk, column);
    sdr_flags fresh = 0;
    for (int lane = 0; lane < SDR_LANES; ++lane) {
      o->sum[chunk.point + lane] += chunk.sum[lane];
      if (squares) o->square[chunk.point + lane] += chunk.square[lane];
      if (o->lost) o->lost[chunk.point + lane] += chunk.lost[lane];
      fresh |= chunk.fresh[lane];
    }
    if (use && fresh & (SDR_FRESH_I | SDR_FRESH_J)) o->body.chunk_fresh[c] = 1;
  }
}

SDR_INLINE void force_of_column(const int components, const int flagged, const int linear,
                                const sdr_ordinary *o, sdr_ordinary_chunk *chunk, int64_t column)
{
  const sdr_loose *loose = &o->body.bonds->loose;
  const int printed = o->form == SDR_FORM_MADENCI_OTERKUS;
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane, i = chunk->point + lane;
    const int32_t j = loose->j[slot];
    const sdr_ordinary_slot pair = slot_at(components, linear, loose, slot, i, chunk->u);
    const double p = loose_p(printed, &pair), q = loose_q(printed, &pair) * pair.s;
    double hi = loose->weight_ij[slot] * (p * o->along[i] + q * o->across[i]);
    double hj = loose->weight_ji[slot] * (p * o->along[j] + q * o->across[j]);
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
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane, i = chunk->point + lane;
    const int32_t j = loose->j[slot];
    const sdr_ordinary_slot pair = slot_at(components, linear, loose, slot, i, chunk->u);
    const double along =
        same ? o->along[i] + o->along[j]
             : loose->weight_ij[slot] * o->along[i] + loose->weight_ji[slot] * o->along[j];
    const double across =
        same ? o->across[i] + o->across[j]
             : loose->weight_ij[slot] * o->across[i] + loose->weight_ji[slot] * o->across[j];
    double phi = (along + across * pair.s) / pair.r;
    if (same) phi = j == i ? 0.0 : phi * shared;
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
  const double sign = linear ? -1.0 : 1.0;
  for (int64_t c = first; c < end; ++c) {
    const int64_t *const slot = o->body.bonds->loose.chunk_slot + c;
    sdr_ordinary_chunk chunk = {.point = c * SDR_LANES, .u = u};
    for (int64_t column = slot[0]; column < slot[1]; column += SDR_LANES)
      force_of_any(components, flagged, linear, o, &chunk, column);
    for (int a = 0; a < components; ++a)
      for (int lane = 0; lane < SDR_LANES; ++lane)
        f[a][chunk.point + lane] += sign * chunk.force[a][lane];
  }
}

#endif
