/* Forces of loose pairs. Both points of a pair compute it, with the same bits, so that each writes
   to itself alone; the eight points of a chunk are the lanes. Lengths themselves are taken by
   square root, not their ratio, so that one division gives the force (two with the variational law,
   whose history stores the stretch). */
#ifndef SDR_MECHANICS_BOND_LOOSE_H
#define SDR_MECHANICS_BOND_LOOSE_H

#include "mechanics/bond_loop.h"
#include "mechanics/records.h"

/* A pair: grown = l^2 - L^2 and both = L (L + l), so that the stretch is grown/both; l; C and q of
   its points, C times weight. */
typedef struct {
  double grown, both, now, ci, cj, qi, qj;
} sdr_loose_pair;

/* Force over the vector from point to point, variational law; *grown: its history. */
SDR_INLINE double loose_variational(const int each, const int marked, const sdr_loose_pair *p,
                                    float before, float *grown)
{
  const double s = p->grown / p->both, whole = p->ci + p->cj;
  const float k = *grown = grown_stretch_double(marked, before, s);
  const double kept = (double)k;
  const double a = SDR_FMA_double(kept, kept, p->qi);
  const double b = each ? SDR_FMA_double(kept, kept, p->qj) : 1.0;
  const double all = 1.0 / (p->now * (a * b)), by_ab = p->now * all;
  const double intact_i = p->qi * b * by_ab, intact_j = each ? p->qj * a * by_ab : intact_i;
  const double soft = p->ci * (intact_i * intact_i) + p->cj * (intact_j * intact_j);
  return stiffness_left_double(marked, s, k, soft, whole) * s * (a * b * all);
}

/* The same for any law that softens; r: its second constant at both points. */
SDR_INLINE double loose_softened(const int law, const int marked, const sdr_loose_pair *p,
                                 double ri, double rj, float before, float *grown)
{
  const double s = p->grown / p->both;
  const float k = *grown = grown_stretch_double(marked, before, s);
  const double kept = k > 0.0f ? (double)k : 0.0;
  const double soft = p->ci * sdr_softening_of(law, kept, p->qi, ri).left +
                      p->cj * sdr_softening_of(law, kept, p->qj, rj).left;
  return stiffness_left_double(marked, s, k, soft, p->ci + p->cj) * s / p->now;
}

/* What critical stretch leaves of the pair's stiffness; *grown: its flags. */
SDR_INLINE double loose_critical(const int marked, const sdr_loose_pair *p, sdr_flags before,
                                 sdr_flags *grown)
{
  const double square = p->grown * p->grown, limit = p->both * p->both;
  const sdr_flags broken = (p->grown > 0.0 && square > p->qi * limit ? SDR_LOST_I : 0) |
                           (p->grown > 0.0 && square > p->qj * limit ? SDR_LOST_J : 0);
  const sdr_flags lost = broken & ~before;
  sdr_flags after = before | lost | lost << 2;
  if (marked) after = before & SDR_PROTECTED ? before : after;
  *grown = after;
  return (after & SDR_LOST_I ? 0.0 : p->ci) + (after & SDR_LOST_J ? 0.0 : p->cj);
}

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

/* One column of a chunk: a slot of each of its points. `same`: all pairs have one weight. */
SDR_INLINE void force_of_column(const int components, const int law, const int each,
                                const int marked, const int same, const sdr_bond_body *body,
                                sdr_chunk *chunk)
{
  _Alignas(64) double other[SDR_RECORD][SDR_LANES];
  const int64_t column = chunk->column;
  const sdr_loose *loose = &body->bonds->loose;
  const int32_t *const restrict neighbour = loose->j + column;
  const double c = body->stiffness, q = body->threshold;
  const sdr_column kept = history_of_column(law, body, chunk);
  gather_records(body->records, SDR_RECORD, neighbour, other);
#pragma omp simd
  for (int lane = 0; lane < SDR_LANES; ++lane) {
    const int64_t slot = column + lane;
    const int32_t j = neighbour[lane];
    const double xx = loose->xi[0][slot];
    const double xy = components > 1 ? loose->xi[1][slot] : 0.0;
    const double xz = components > 2 ? loose->xi[2][slot] : 0.0;
    const double ex = other[0][lane] - chunk->u[0][lane];
    const double ey = components > 1 ? other[1][lane] - chunk->u[1][lane] : 0.0;
    const double ez = components > 2 ? other[2][lane] - chunk->u[2][lane] : 0.0;
    const sdr_loose_squares l = loose_squares(components, xx, xy, xz, ex, ey, ez);
    const double grown = l.grown, square = l.square;
    const double present = square + grown, length = sqrt(square);
    /* l = 0: no direction; below rounding neither */
    const double now = sqrt(present > 1e-18 * square ? present : 1e-18 * square);
    const double wij = same ? loose->shared_weight : loose->weight_ij[slot];
    const double wji = same ? loose->shared_weight : loose->weight_ji[slot];
    const sdr_loose_pair pair = {grown,
                                 length * (length + now),
                                 now,
                                 wij * (each ? chunk->c[lane] : c),
                                 wji * (each ? other[components][lane] : c),
                                 each ? chunk->q[lane] : q,
                                 !each            ? q
                                 : components < 3 ? other[(components + 1) % SDR_RECORD][lane]
                                                  : body->threshold_at[j]};
    double phi = 0.0;
    if (law == SDR_LAW_VARIATIONAL) {
      phi = loose_variational(each, marked, &pair, kept.stretch[lane], &kept.new_stretch[lane]);
    } else if (sdr_law_softens(law)) {
      const int second = each && law == SDR_LAW_COHESIVE;
      const double ri = second ? chunk->r[lane] : body->decline;
      const double rj = second ? body->decline_at[j] : body->decline;
      phi = loose_softened(law, marked, &pair, ri, rj, kept.stretch[lane], &kept.new_stretch[lane]);
    } else {
      double left = pair.ci + pair.cj;
      if (law == SDR_LAW_CRITICAL_STRETCH) {
        sdr_flags grown_flags = 0;
        left = loose_critical(marked, &pair, kept.flags[lane], &grown_flags);
        kept.new_flags[lane] = grown_flags;
        chunk->fresh[lane] |= grown_flags;
      } else if (marked) {
        left = kept.flags[lane] & SDR_CUT ? 0.0 : left;
      }
      phi = left * grown / (pair.both * now);
    }
    chunk->sum[0][lane] = SDR_FMA_double(phi, xx + ex, chunk->sum[0][lane]);
    if (components > 1) chunk->sum[1][lane] = SDR_FMA_double(phi, xy + ey, chunk->sum[1][lane]);
    if (components > 2) chunk->sum[2][lane] = SDR_FMA_double(phi, xz + ez, chunk->sum[2][lane]);
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
