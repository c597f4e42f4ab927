/* Loops over the loose pairs of ordinary bodies: the points of a chunk are the lanes (lanes.h), and
   each adds to itself alone, in registers over all of its columns. */
#ifndef SDR_MECHANICS_ORDINARY_LOOSE_H
#define SDR_MECHANICS_ORDINARY_LOOSE_H

#include "mechanics/ordinary_loop.h"
#include "mechanics/records.h"

/* Some lanes of a chunk: where their points are named, and displacements and coefficients of these;
   `same`: all pairs have one weight. */
typedef struct {
  const sdr_ordinary *o;
  const int32_t *point;
  int same;
  sdr_lanes u[3], along, across;
} sdr_ordinary_own;

/* Pairs of a column: the present vector from point to point (of the reference shape if linear),
   xi^2 and 1/xi^2, stretch and r = 1 + stretch, and of the other ends what stands behind
   displacements in their records. */
typedef struct {
  sdr_lanes y[3], square, inverse, s, r, other[SDR_RECORD];
} sdr_ordinary_lanes;

SDR_INLINE void own_lanes(const int components, const int forces, const sdr_ordinary *o,
                          int64_t chunk, int lane, double *const u[3], sdr_ordinary_own *to)
{
  const sdr_loose *loose = &o->body.bonds->loose;
  to->o = o;
  to->point = loose->point + chunk * SDR_LANES + lane;
  to->same = loose->shared_weight != 0.0;
  for (int a = 0; a < components; ++a) to->u[a] = gather_lanes(u[a], to->point);
  if (!forces) return;
  to->along = gather_lanes(o->along, to->point);
  to->across = gather_lanes(o->across, to->point);
}

/* sdr_state_stretch_of */
SDR_INLINE void stretch_lanes(sdr_lanes z, sdr_ordinary_lanes *p)
{
  const sdr_lanes least = all_lanes(1e-18), now = 1.0 + z;
  p->r = root_lanes(where_above(now, least, now, least));
  const sdr_lanes rough = p->r - 1.0;
  p->s = rough + 0.5 * (z - rough * (rough + 2.0));
}

SDR_INLINE void pair_lanes(const int components, const int linear, const sdr_ordinary_own *own,
                           int64_t slot, sdr_ordinary_lanes *p)
{
  const sdr_loose *loose = &own->o->body.bonds->loose;
  sdr_lanes z = all_lanes(0.0);
  p->square = z;
  record_lanes(own->o->records, SDR_RECORD, loose->j + slot, p->other);
  for (int a = 0; a < components; ++a) {
    const sdr_lanes xi = load_lanes(loose->xi[a] + slot), eta = p->other[a] - own->u[a];
    p->y[a] = linear ? xi : xi + eta;
    p->square = fma_lanes(xi, xi, p->square);
    z = fma_lanes(linear ? xi : 2.0 * xi + eta, eta, z);
  }
  p->inverse = 1.0 / p->square;
  z *= p->inverse;
  if (linear) {
    p->s = z;
    p->r = all_lanes(1.0);
  } else {
    stretch_lanes(z, p);
  }
}

/* P and Q of a half over its weight, and P^2/Q. */
SDR_INLINE sdr_lanes loose_p(int printed, const sdr_ordinary_lanes *p)
{
  return printed ? all_lanes(1.0) : p->square;
}
SDR_INLINE sdr_lanes loose_q(int printed, const sdr_ordinary_lanes *p)
{
  return printed ? root_lanes(p->square) : p->square;
}
SDR_INLINE sdr_lanes loose_r(int printed, const sdr_ordinary_lanes *p)
{
  return printed ? 1.0 / root_lanes(p->square) : p->square;
}

/* ---- sums ------------------------------------------------------------------------------------ */

/* What flags there are: none, some, some where all points share one threshold (no gather). */
enum { SDR_LOOSE_UNFLAGGED, SDR_LOOSE_FLAGGED, SDR_LOOSE_SHARED };

typedef struct {
  sdr_lanes sum, square, lost;
  sdr_lanes_int fresh;
} sdr_ordinary_sum_lanes;

/* grown_flags */
SDR_INLINE sdr_lanes_int grown_lanes(const int flagged, const sdr_ordinary_own *own, int64_t slot,
                                     sdr_lanes s, sdr_lanes_int before)
{
  const sdr_ordinary *o = own->o;
  const int32_t *const j = o->body.bonds->loose.j + slot;
  sdr_lanes qi = all_lanes(o->weakest), qj = qi;
  if (flagged == SDR_LOOSE_FLAGGED) {
    qi = gather_lanes(o->body.threshold, own->point);
    qj = gather_lanes(o->body.threshold, j);
  }
  const sdr_lanes_bits longer = s > 0.0;
  const sdr_lanes_bits broken =
      longer & (((s * s > qi) & SDR_LOST_I) | ((s * s > qj) & SDR_LOST_J));
  const sdr_lanes_int lost = ints_of(broken) & ~before;
  return some_ints((before & SDR_PROTECTED) != 0, before, before | lost | lost << 2);
}

/* Halves that are gone count no more; *s: stretches of those that are left. */
SDR_INLINE void sift_lanes(const int use, const int flagged, const sdr_ordinary_own *own,
                           int64_t slot, sdr_lanes r, sdr_lanes *s, sdr_ordinary_sum_lanes *to)
{
  sdr_flags *const flags = own->o->body.loose_flags + slot;
  const sdr_lanes_int before = load_ints(flags);
  const sdr_lanes_int after = use ? grown_lanes(flagged, own, slot, *s, before) : before;
  if (!any_ints(after)) return;
  const sdr_lanes zero = all_lanes(0.0);
  const sdr_lanes_bits gone = bits_of_ints((after & SDR_LOST_I) != 0);
  const sdr_lanes_bits torn = bits_of_ints((after & (SDR_LOST_I | SDR_CUT)) == SDR_LOST_I);
  *s = where_set(gone, zero, *s);
  to->lost += where_set(torn, r, zero);
  if (use) memcpy(flags, &after, sizeof after);
  to->fresh |= after;
}

SDR_INLINE sdr_ordinary_sum_lanes sums_of_lanes(const int components, const int squares,
                                                const int use, const int flagged, const int linear,
                                                const int printed, const sdr_ordinary_own *own,
                                                const int64_t column[2], int lane)
{
  const sdr_loose *loose = &own->o->body.bonds->loose;
  sdr_ordinary_sum_lanes to = {0};
  for (int64_t slot = column[0] + lane; slot < column[1]; slot += SDR_LANES) {
    sdr_ordinary_lanes p;
    pair_lanes(components, linear, own, slot, &p);
    /* padding has no stretch, so its weight does not matter */
    const sdr_lanes w =
        own->same ? all_lanes(loose->shared_weight) : load_lanes(loose->weight_ij + slot);
    sdr_lanes s = p.s;
    if (flagged) sift_lanes(use, flagged, own, slot, w * loose_r(printed, &p), &s, &to);
    to.sum = fma_lanes(w * loose_p(printed, &p), s, to.sum);
    if (squares) to.square = fma_lanes(w * loose_q(printed, &p), s * s, to.square);
  }
  return to;
}

/* array[point] += lane after lane, since lanes may repeat a point. */
SDR_INLINE void add_lanes(sdr_lanes v, const int32_t *point, double *array)
{
  for (int lane = 0; lane < SDR_WIDTH; ++lane) array[point[lane]] += v[lane];
}

SDR_INLINE void sums_of_loose(const int components, const int squares, const int use,
                              const int flagged, const int linear, sdr_ordinary *o, int64_t first,
                              int64_t end, double *const u[3])
{
  const int printed = o->form == SDR_FORM_MADENCI_OTERKUS;
  for (int64_t c = first; c < end; ++c)
    for (int lane = 0; lane < SDR_LANES; lane += SDR_WIDTH) {
      const int64_t *const column = o->body.bonds->loose.chunk_slot + c;
      sdr_ordinary_own own;
      sdr_ordinary_sum_lanes to;
      own_lanes(components, 0, o, c, lane, u, &own);
      if (printed)
        to = sums_of_lanes(components, squares, use, flagged, linear, 1, &own, column, lane);
      else
        to = sums_of_lanes(components, squares, use, flagged, linear, 0, &own, column, lane);
      add_lanes(to.sum, own.point, o->sum);
      if (squares) add_lanes(to.square, own.point, o->square);
      if (o->lost) add_lanes(to.lost, own.point, o->lost);
      if (use && any_ints(to.fresh & (SDR_FRESH_I | SDR_FRESH_J))) o->body.chunk_fresh[c] = 1;
    }
}

/* ---- forces ---------------------------------------------------------------------------------- */

/* Force over the vector from point to point. */
SDR_INLINE sdr_lanes phi_lanes(const int components, const int flagged, const int printed,
                               const sdr_ordinary_own *own, int64_t slot,
                               const sdr_ordinary_lanes *p)
{
  const sdr_ordinary *o = own->o;
  const sdr_loose *loose = &o->body.bonds->loose;
  const sdr_lanes zero = all_lanes(0.0);
  const sdr_lanes along = p->other[components];
  const sdr_lanes across = components < 3 ? p->other[(components + 1) % SDR_RECORD]
                                          : gather_lanes(o->across, loose->j + slot);
  if (!flagged && !printed && own->same) { /* padding is its own neighbour */
    const sdr_lanes both = fma_lanes(own->across + across, p->s, own->along + along);
    const sdr_lanes_int alone = load_ints(loose->j + slot) == load_ints(own->point);
    return where_set(bits_of_ints(alone), zero, loose->shared_weight * both / p->r);
  }
  const sdr_lanes q = printed ? loose_q(1, p) * p->s * p->inverse : p->s;
  const sdr_lanes one = printed ? p->inverse : all_lanes(1.0);
  sdr_lanes hi = load_lanes(loose->weight_ij + slot) * fma_lanes(own->across, q, own->along * one);
  sdr_lanes hj = load_lanes(loose->weight_ji + slot) * fma_lanes(across, q, along * one);
  if (flagged) {
    const sdr_lanes_int flags = load_ints(o->body.loose_flags + slot);
    hi = where_set(bits_of_ints((flags & SDR_LOST_I) != 0), zero, hi);
    hj = where_set(bits_of_ints((flags & SDR_LOST_J) != 0), zero, hj);
  }
  return (hi + hj) / p->r;
}

SDR_INLINE void force_of_lanes(const int components, const int flagged, const int linear,
                               const int printed, const sdr_ordinary_own *own,
                               const int64_t column[2], int lane, sdr_lanes out[3])
{
  sdr_lanes force[3] = {all_lanes(0.0), all_lanes(0.0), all_lanes(0.0)};
  for (int64_t slot = column[0] + lane; slot < column[1]; slot += SDR_LANES) {
    sdr_ordinary_lanes p;
    pair_lanes(components, linear, own, slot, &p);
    const sdr_lanes phi = phi_lanes(components, flagged, printed, own, slot, &p);
    for (int a = 0; a < components; ++a) force[a] = fma_lanes(phi, p.y[a], force[a]);
  }
  for (int a = 0; a < components; ++a) out[a] = linear ? -force[a] : force[a];
}

SDR_INLINE void force_of_loose(const int components, const int flagged, const int linear,
                               const sdr_ordinary *o, int64_t first, int64_t end,
                               double *const u[3], double *const f[3])
{
  const int printed = o->form == SDR_FORM_MADENCI_OTERKUS;
  for (int64_t c = first; c < end; ++c)
    for (int lane = 0; lane < SDR_LANES; lane += SDR_WIDTH) {
      const int64_t *const column = o->body.bonds->loose.chunk_slot + c;
      sdr_ordinary_own own;
      sdr_lanes force[3];
      own_lanes(components, 1, o, c, lane, u, &own);
      if (printed)
        force_of_lanes(components, flagged, linear, 1, &own, column, lane, force);
      else
        force_of_lanes(components, flagged, linear, 0, &own, column, lane, force);
      for (int a = 0; a < components; ++a) add_lanes(force[a], own.point, f[a]);
    }
}

#endif
