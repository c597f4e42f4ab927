/* The passes over loose pairs: a chunk's eight points are the lanes. Each point sums what its own
   directed states give it, so pass A and A2 look at one side; forces take both. */
#ifndef SDR_MECHANICS_NONORDINARY_LOOSE_H
#define SDR_MECHANICS_NONORDINARY_LOOSE_H

#include "mechanics/nonordinary_loop.h"

/* xi, eta and the weights of the lanes' pairs; a lost half weighs nothing. */
typedef struct {
  const int32_t *j;
  sdr_lanes xi[3], eta[3], by_length, wi, wj;
} sdr_loose_lanes;

SDR_INLINE void loose_lanes(const int n, const int marked, const sdr_nonordinary_body *body,
                            int64_t i, int64_t slot, double *const u[3], sdr_loose_lanes *to)
{
  const sdr_loose *loose = &body->bonds->loose;
  to->j = loose->j + slot;
  to->wi = load_lanes(loose->weight_ij + slot, SDR_WIDTH);
  to->wj = load_lanes(loose->weight_ji + slot, SDR_WIDTH);
  sdr_lanes square = all_lanes(0.0);
  for (int a = 0; a < n; ++a) {
    to->xi[a] = load_lanes(loose->xi[a] + slot, SDR_WIDTH);
    to->eta[a] = gather_lanes(u[a], to->j) - load_lanes(u[a] + i, SDR_WIDTH);
    square += to->xi[a] * to->xi[a];
  }
  to->by_length = all_lanes(1.0) / root_lanes(square);
  for (int l = 0; marked && l < SDR_WIDTH; ++l) {
    const sdr_flags flags = body->loose_flags[slot + l];
    if (flags & SDR_LOST_I) to->wi[l] = 0.0;
    if (flags & SDR_LOST_J) to->wj[l] = 0.0;
  }
}

SDR_INLINE void gather_column(const int n, const int finite, const int sums, const int marked,
                              const sdr_nonordinary_body *body, int64_t i, int64_t slot,
                              double *const u[3])
{
  sdr_loose_lanes p;
  loose_lanes(n, marked, body, i, slot, u, &p);
  add_moments(n, finite, sums, body, i, SDR_WIDTH, p.eta, p.xi, p.by_length, p.wi);
}

SDR_INLINE void control_column(const int n, const int marked, const sdr_nonordinary_body *body,
                               int64_t i, int64_t slot, double *const u[3])
{
  sdr_loose_lanes p;
  sdr_lanes g[9];
  sdr_residual r;
  loose_lanes(n, marked, body, i, slot, u, &p);
  load_all(n * n, body->gradient, i, SDR_WIDTH, g);
  residual_of(n, g, p.xi, p.eta, &r);
  add_control(n, body, i, SDR_WIDTH, &r, all_lanes(1.0) / r.square, p.wi, p.xi);
}

/* bearing_at for the points index[lane]. */
SDR_INLINE void gathered_bearing(const int n, const int finite, const sdr_nonordinary_body *body,
                                 const int32_t *index, sdr_bearing *at)
{
  for (int k = 0; k < n * n; ++k) at->a[k] = gather_lanes(body->bearing[k], index);
  for (int a = 0; a < n; ++a)
    for (int b = finite ? 0 : a; b < n; ++b)
      at->g[n * a + b] = gather_lanes(body->gradient[n * a + b], index);
  at->soft = gather_lanes(body->soft, index);
  at->stiff = gather_lanes(body->stiff, index);
}

SDR_INLINE void force_column(const int n, const int finite, const int marked,
                             const sdr_nonordinary_body *body, int64_t i, int64_t slot,
                             double *const u[3], double *const f[3])
{
  sdr_loose_lanes p;
  sdr_bearing own, other;
  sdr_lanes force[3];
  loose_lanes(n, marked, body, i, slot, u, &p);
  bearing_at(n, finite, body, i, SDR_WIDTH, &own);
  gathered_bearing(n, finite, body, p.j, &other);
  pair_force(n, finite, &own, &other, p.xi, p.eta, p.by_length, p.wi, p.wj, force);
  for (int a = 0; a < n; ++a) add_lanes(f[a] + i, SDR_WIDTH, force[a]);
}

/* DO(marked, i, slot) for the points i and slots of all lanes of chunks [first, end). */
#define SDR_ALL_CHUNKS(DO)                                                                         \
  for (int64_t chunk = first; chunk < end; ++chunk) {                                              \
    const int64_t *const column = body->bonds->loose.chunk_slot + chunk;                           \
    for (int64_t at = column[0]; at < column[1]; at += SDR_LANES)                                  \
      for (int lane = 0; lane < SDR_LANES; lane += SDR_WIDTH) {                                    \
        const int64_t i = chunk * SDR_LANES + lane, slot = at + lane;                              \
        if (body->loose_flagged) {                                                                 \
          DO(1)                                                                                    \
        } else {                                                                                   \
          DO(0)                                                                                    \
        }                                                                                          \
      }                                                                                            \
  }

SDR_INLINE void gather_chunks(const int n, const int finite, const int sums,
                              const sdr_nonordinary_body *body, int64_t first, int64_t end,
                              double *const u[3])
{
#define SDR_DO(marked) gather_column(n, finite, sums, marked, body, i, slot, u);
  SDR_ALL_CHUNKS(SDR_DO)
#undef SDR_DO
}

SDR_INLINE void control_chunks(const int n, const sdr_nonordinary_body *body, int64_t first,
                               int64_t end, double *const u[3])
{
#define SDR_DO(marked) control_column(n, marked, body, i, slot, u);
  SDR_ALL_CHUNKS(SDR_DO)
#undef SDR_DO
}

SDR_INLINE void force_chunks(const int n, const int finite, const sdr_nonordinary_body *body,
                             int64_t first, int64_t end, double *const u[3], double *const f[3])
{
#define SDR_DO(marked) force_column(n, finite, marked, body, i, slot, u, f);
  SDR_ALL_CHUNKS(SDR_DO)
#undef SDR_DO
}

/* ---- bonds that break ------------------------------------------------------------------------ */

SDR_INLINE void find_chunks(const int n, const sdr_nonordinary_body *body, int64_t first,
                            int64_t end, double *const u[3], const double *limit, uint8_t *found)
{
  for (int64_t chunk = first; chunk < end; ++chunk) {
    const int64_t *const column = body->bonds->loose.chunk_slot + chunk;
    int any = 0;
    for (int64_t at = column[0]; at < column[1]; at += SDR_LANES)
      for (int lane = 0; lane < SDR_LANES; lane += SDR_WIDTH) {
        const int64_t i = chunk * SDR_LANES + lane;
        sdr_loose_lanes p;
        loose_lanes(n, 0, body, i, at + lane, u, &p);
        sdr_lanes z = all_lanes(0.0);
        for (int a = 0; a < n; ++a) z += (2.0 * p.xi[a] + p.eta[a]) * p.eta[a];
        z *= p.by_length * p.by_length;
        for (int l = 0; l < SDR_WIDTH; ++l) {
          const sdr_flags flags = body->loose_flags[at + lane + l];
          any |= !(flags & (SDR_LOST_I | SDR_PROTECTED)) && z[l] > limit[i + l];
          any |= !(flags & (SDR_LOST_J | SDR_PROTECTED)) && z[l] > limit[p.j[l]];
        }
      }
    found[chunk] = (uint8_t)any;
  }
}

#endif
