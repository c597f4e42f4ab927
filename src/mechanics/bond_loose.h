/* Forces of loose pairs. Both points of a pair compute it, with the same bits, so that each writes
   to itself alone; the eight points of a chunk are the lanes. Lengths themselves are taken by
   square root, not their ratio, so that one division gives the force (two with the variational law,
   whose history stores the stretch). A column's work is several loops with values handed on in the
   first-level cache: those with roots and divisions see nothing but doubles, since a compiler takes
   all of a loop in vectors half as wide where floats or whole numbers are among them, and wide ones
   take half as long. */
#ifndef SDR_MECHANICS_BOND_LOOSE_H
#define SDR_MECHANICS_BOND_LOOSE_H

#include "mechanics/bond_loop.h"
#include "mechanics/lanes.h"
#include "mechanics/records.h"

/* A column's pairs, one a lane: grown = l^2 - L^2 and both = L (L + l), so that the stretch is
   grown/both; l; the vector from point to point; C times weight and q of both ends, r (cohesive);
   the stretch that the history holds; what is left of the stiffness of laws without one. */
typedef struct {
  _Alignas(64) double grown[SDR_LANES], both[SDR_LANES], now[SDR_LANES], y[3][SDR_LANES];
  _Alignas(64) double ci[SDR_LANES], cj[SDR_LANES], qi[SDR_LANES], qj[SDR_LANES];
  _Alignas(64) double s[SDR_LANES], kept[SDR_LANES], left[SDR_LANES], rj[SDR_LANES];
} sdr_loose_pairs;

/* A chunk at work: the column at hand, displacements and constants of the lanes' points, and the
   sums of the lanes. Flags are collected lane by lane: as one number for all lanes gcc would leave
   the loop scalar. */
typedef struct {
  int64_t column;
  _Alignas(64) double u[3][SDR_LANES], c[SDR_LANES], q[SDR_LANES], r[SDR_LANES];
  _Alignas(64) double sum[3][SDR_LANES];
  _Alignas(64) sdr_flags fresh[SDR_LANES];
  float stretch[SDR_LANES]; /* histories that nobody keeps */
  sdr_flags flags[SDR_LANES];
} sdr_chunk;

/* Histories of a chunk's column, and where the present ones go. */
typedef struct {
  const float *stretch;
  float *new_stretch;
  const sdr_flags *flags;
  sdr_flags *new_flags;
} sdr_column;

SDR_INLINE sdr_column history_of_column(const int law, const sdr_bond_body *body, sdr_chunk *chunk)
{
  float *const stretch = sdr_law_softens(law) ? body->loose_stretch + chunk->column : NULL;
  sdr_flags *const flags = body->loose_flags ? body->loose_flags + chunk->column : NULL;
  return (sdr_column){stretch, body->commit ? stretch : chunk->stretch, flags,
                      body->commit ? flags : chunk->flags};
}

/* L^2 of a pair with the reference vector x, and l^2 - L^2 when its ends moved apart by e. */
typedef struct {
  double square, grown;
} sdr_loose_squares;

SDR_INLINE sdr_loose_squares loose_squares(const int components, double xx, double xy, double xz,
                                           double ex, double ey, double ez)
{
  sdr_loose_squares l = {xx * xx, (2.0 * xx + ex) * ex};
  if (components > 1) {
    l.grown = SDR_FMA_double(2.0 * xy + ey, ey, l.grown);
    l.square = SDR_FMA_double(xy, xy, l.square);
  }
  if (components > 2) {
    l.grown = SDR_FMA_double(2.0 * xz + ez, ez, l.grown);
    l.square = SDR_FMA_double(xz, xz, l.square);
  }
  return l;
}

/* The pairs of the chunk's column. `same`: all pairs have one weight. */
SDR_INLINE void pairs_of_column(const int components, const int law, const int each, const int same,
                                const sdr_bond_body *body, const sdr_chunk *chunk,
                                sdr_loose_pairs *p)
{
  _Alignas(64) double other[SDR_RECORD][SDR_LANES];
  const sdr_loose *loose = &body->bonds->loose;
  const int64_t column = chunk->column;
  const double *const xi[3] = {loose->xi[0] + column, loose->xi[components > 1] + column,
                               loose->xi[components > 2 ? 2 : 0] + column};
  const double *const wij = loose->weight_ij + column, *const wji = loose->weight_ji + column;
  const double c = body->stiffness, w = loose->shared_weight;
  gather_records(body->records, SDR_RECORD, loose->j + column, other);
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const double xx = xi[0][lane], xy = components > 1 ? xi[1][lane] : 0.0;
    const double xz = components > 2 ? xi[2][lane] : 0.0;
    const double ex = other[0][lane] - chunk->u[0][lane];
    const double ey = components > 1 ? other[1][lane] - chunk->u[1][lane] : 0.0;
    const double ez = components > 2 ? other[2][lane] - chunk->u[2][lane] : 0.0;
    const sdr_loose_squares l = loose_squares(components, xx, xy, xz, ex, ey, ez);
    const double present = l.square + l.grown, length = sqrt(l.square);
    /* l = 0: no direction; below rounding neither */
    const double now = sqrt(present > 1e-18 * l.square ? present : 1e-18 * l.square);
    const double both = length * (length + now);
    p->grown[lane] = l.grown;
    p->now[lane] = now;
    p->both[lane] = both;
    if (sdr_law_softens(law)) p->s[lane] = l.grown / both;
    p->y[0][lane] = xx + ex;
    p->y[1][lane] = xy + ey;
    p->y[2][lane] = xz + ez;
    p->ci[lane] = (same ? w : wij[lane]) * (each ? chunk->c[lane] : c);
    p->cj[lane] = (same ? w : wji[lane]) * (each ? other[components][lane] : c);
    if (components < 3) p->qj[lane] = other[(components + 1) % SDR_RECORD][lane];
  }
  if (!each) return;
  if (components == 3 && law != SDR_LAW_NONE)
    gather_points(body->threshold_at, loose->j + column, p->qj);
  if (law == SDR_LAW_COHESIVE) gather_points(body->decline_at, loose->j + column, p->rj);
}

/* Histories of a column that softens. */
SDR_INLINE void histories_of_column(const int marked, const sdr_column *history, sdr_loose_pairs *p)
{
  for (int lane = 0; lane < SDR_LANES; lane += SDR_WIDTH) {
    const sdr_lanes_float before = load_floats(history->stretch + lane);
    const sdr_lanes_float now = floats_of(load_lanes(p->s + lane));
    sdr_lanes_int keep = before > now; /* bits */
    if (marked) keep |= before < 0.0f;
    const sdr_lanes_float k =
        (sdr_lanes_float)some_ints(keep, (sdr_lanes_int)before, (sdr_lanes_int)now);
    memcpy(history->new_stretch + lane, &k, sizeof k);
    store_lanes(p->kept + lane, lanes_of_floats(k));
  }
}

#if SDR_WIDTH == 8 /* all of a column */
/* Halves that critical stretch breaks now. */
SDR_INLINE sdr_lanes_int broken_lanes(const int each, const sdr_bond_body *body,
                                      const sdr_chunk *chunk, const sdr_loose_pairs *p)
{
  const sdr_lanes grown = load_lanes(p->grown), both = load_lanes(p->both);
  const sdr_lanes qi = each ? load_lanes(chunk->q) : all_lanes(body->threshold);
  const sdr_lanes qj = each ? load_lanes(p->qj) : all_lanes(body->threshold);
  const sdr_lanes square = grown * grown, limit = both * both;
  const sdr_lanes_bits longer = grown > 0.0;
  return ints_of(longer &
                 (((square > qi * limit) & SDR_LOST_I) | ((square > qj * limit) & SDR_LOST_J)));
}

/* Of a column that does not soften: what is left of the stiffness. */
SDR_INLINE void flags_of_column(const int law, const int each, const int marked,
                                const sdr_bond_body *body, const sdr_column *history,
                                sdr_chunk *chunk, sdr_loose_pairs *p)
{
  const int critical = law == SDR_LAW_CRITICAL_STRETCH;
  const sdr_lanes_int before = load_ints(history->flags);
  sdr_lanes_int after = before;
  if (critical) {
    const sdr_lanes_int lost = broken_lanes(each, body, chunk, p) & ~before;
    after = before | lost | lost << 2;
    if (marked) after = some_ints((before & SDR_PROTECTED) != 0, before, after);
    const sdr_lanes_int all = load_ints(chunk->fresh) | after;
    memcpy(history->new_flags, &after, sizeof after);
    memcpy(chunk->fresh, &all, sizeof all);
  }
  const sdr_lanes_bits flags = bits_of_ints(after);
  const int i = critical ? SDR_LOST_I : SDR_CUT, j = critical ? SDR_LOST_J : SDR_CUT;
  const sdr_lanes zero = all_lanes(0.0);
  const sdr_lanes ci = where_set((flags & i) == 0, load_lanes(p->ci), zero);
  const sdr_lanes cj = where_set((flags & j) == 0, load_lanes(p->cj), zero);
  store_lanes(p->left, ci + cj);
}
#else
/* The same, left to the compiler: its vectors are narrow anyway. */
SDR_INLINE void flags_of_column(const int law, const int each, const int marked,
                                const sdr_bond_body *body, const sdr_column *history,
                                sdr_chunk *chunk, sdr_loose_pairs *p)
{
  const int critical = law == SDR_LAW_CRITICAL_STRETCH;
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const sdr_flags before = history->flags[lane];
    sdr_flags after = before;
    if (critical) {
      const double grown = p->grown[lane], square = grown * grown;
      const double limit = p->both[lane] * p->both[lane];
      const double qi = each ? chunk->q[lane] : body->threshold;
      const double qj = each ? p->qj[lane] : body->threshold;
      const sdr_flags broken = (grown > 0.0 && square > qi * limit ? SDR_LOST_I : 0) |
                               (grown > 0.0 && square > qj * limit ? SDR_LOST_J : 0);
      const sdr_flags lost = broken & ~before;
      after = before | lost | lost << 2;
      if (marked) after = before & SDR_PROTECTED ? before : after;
      history->new_flags[lane] = after;
      chunk->fresh[lane] |= after;
    }
    p->left[lane] = (after & (critical ? SDR_LOST_I : SDR_CUT) ? 0.0 : p->ci[lane]) +
                    (after & (critical ? SDR_LOST_J : SDR_CUT) ? 0.0 : p->cj[lane]);
  }
}
#endif

/* Of a pair that softens: its stiffness, `soft` where it is stretched, and what marks make of it.
 */
SDR_INLINE double loose_stiffness(const int marked, double s, double kept, double soft,
                                  double whole)
{
  double left = s > 0.0 ? soft : whole;
  if (marked) {
    left = kept == (double)SDR_STRETCH_PROTECTED ? whole : left;
    left = kept == (double)SDR_STRETCH_CUT ? 0.0 : left;
  }
  return left;
}

/* Force over the vector from point to point of a lane's pair. */
SDR_INLINE double loose_factor(const int law, const int each, const int marked,
                               const sdr_bond_body *body, const sdr_chunk *chunk,
                               const sdr_loose_pairs *p, int lane)
{
  const double ci = p->ci[lane], cj = p->cj[lane], s = p->s[lane], now = p->now[lane];
  const double qi = each ? chunk->q[lane] : body->threshold;
  const double qj = each ? p->qj[lane] : body->threshold, kept = p->kept[lane];
  if (law == SDR_LAW_VARIATIONAL) {
    const double a = SDR_FMA_double(kept, kept, qi);
    const double b = each ? SDR_FMA_double(kept, kept, qj) : 1.0;
    const double all = 1.0 / (now * (a * b)), by_ab = now * all;
    const double intact_i = qi * b * by_ab, intact_j = each ? qj * a * by_ab : intact_i;
    const double soft = ci * (intact_i * intact_i) + cj * (intact_j * intact_j);
    return loose_stiffness(marked, s, kept, soft, ci + cj) * s * (a * b * all);
  }
  if (sdr_law_softens(law)) {
    const int second = each && law == SDR_LAW_COHESIVE;
    const double k = kept > 0.0 ? kept : 0.0;
    const double ri = second ? chunk->r[lane] : body->decline;
    const double rj = second ? p->rj[lane] : body->decline;
    const double soft =
        ci * sdr_softening_of(law, k, qi, ri).left + cj * sdr_softening_of(law, k, qj, rj).left;
    return loose_stiffness(marked, s, kept, soft, ci + cj) * s / now;
  }
  const double left = law == SDR_LAW_NONE && !marked ? ci + cj : p->left[lane];
  return left * p->grown[lane] / (p->both[lane] * now);
}

/* One column of a chunk: a slot of each of its points. */
SDR_INLINE void force_of_column(const int components, const int law, const int each,
                                const int marked, const int same, const sdr_bond_body *body,
                                sdr_chunk *chunk)
{
  sdr_loose_pairs p;
  const sdr_column history = history_of_column(law, body, chunk);
  pairs_of_column(components, law, each, same, body, chunk, &p);
  if (sdr_law_softens(law))
    histories_of_column(marked, &history, &p);
  else if (law == SDR_LAW_CRITICAL_STRETCH || marked)
    flags_of_column(law, each, marked, body, &history, chunk, &p);
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const double phi = loose_factor(law, each, marked, body, chunk, &p, lane);
    for (int a = 0; a < components; ++a)
      chunk->sum[a][lane] = SDR_FMA_double(phi, p.y[a][lane], chunk->sum[a][lane]);
  }
}

SDR_INLINE void load_chunk(const int components, const int law, const int each,
                           const sdr_bond_body *body, const int32_t *point, double *const u[3],
                           sdr_chunk *to)
{
  for (int a = 0; a < components; ++a) load_points(u[a], point, to->u[a]);
  if (!each) return;
  load_points(body->stiffness_at, point, to->c);
  load_points(body->threshold_at, point, to->q);
  if (law == SDR_LAW_COHESIVE) load_points(body->decline_at, point, to->r);
}

SDR_INLINE void force_of_chunk(const int components, const int law, const int each,
                               const sdr_bond_body *body, int64_t chunk, double *const u[3],
                               double *const f[3])
{
  const sdr_loose *loose = &body->bonds->loose;
  const int32_t *const point = loose->point + chunk * SDR_LANES;
  const int64_t end = loose->chunk_slot[chunk + 1];
  const int same = loose->shared_weight != 0.0;
  sdr_chunk work = {.column = loose->chunk_slot[chunk]};
  load_chunk(components, law, each, body, point, u, &work);
  for (; work.column < end; work.column += SDR_LANES)
    if (body->loose_marked)
      force_of_column(components, law, each, 1, 0, body, &work);
    else if (same)
      force_of_column(components, law, each, 0, 1, body, &work);
    else
      force_of_column(components, law, each, 0, 0, body, &work);
  for (int a = 0; a < components; ++a) add_to_points(work.sum[a], point, f[a]);
  if (law != SDR_LAW_CRITICAL_STRETCH || !body->commit) return;
  for (int lane = 0; lane < SDR_LANES; ++lane)
    if (work.fresh[lane] & (SDR_FRESH_I | SDR_FRESH_J)) body->chunk_fresh[chunk] = 1;
}

SDR_INLINE void force_of_loose(const int components, const int law, const int each,
                               const sdr_bond_body *body, int64_t first, int64_t end,
                               double *const u[3], double *const f[3])
{
  for (int64_t chunk = first; chunk < end; ++chunk)
    force_of_chunk(components, law, each, body, chunk, u, f);
}

#endif
