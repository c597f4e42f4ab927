/* The passes over loose pairs: a chunk's eight points are the lanes. Each point sums what its own
   directed states give it, so pass A and A2 look at one side; forces take both. */
#ifndef SDR_MECHANICS_NONORDINARY_LOOSE_H
#define SDR_MECHANICS_NONORDINARY_LOOSE_H

#include "mechanics/nonordinary_loop.h"

#include <math.h>

/* xi, eta and the weights of a lane's pair; a lost half weighs nothing. */
typedef struct {
  double xi[3], eta[3], normal[3], length, wij, wji;
} sdr_lane;

SDR_INLINE sdr_lane lane_at(const int n, const int marked, const sdr_nonordinary_body *body,
                            int64_t i, int64_t slot, double *const u[3])
{
  const sdr_loose *loose = &body->bonds->loose;
  const int64_t j = loose->j[slot];
  sdr_lane lane = {.wij = loose->weight_ij[slot], .wji = loose->weight_ji[slot]};
  double square = 0.0;
  for (int a = 0; a < n; ++a) {
    lane.xi[a] = loose->xi[a][slot];
    lane.eta[a] = u[a][j] - u[a][i];
    square += lane.xi[a] * lane.xi[a];
  }
  lane.length = sqrt(square);
  for (int a = 0; a < n; ++a) lane.normal[a] = lane.xi[a] / lane.length;
  if (marked) {
    const sdr_flags flags = body->loose_flags[slot];
    lane.wij = flags & SDR_LOST_I ? 0.0 : lane.wij;
    lane.wji = flags & SDR_LOST_J ? 0.0 : lane.wji;
  }
  return lane;
}

/* ---- pass A ---------------------------------------------------------------------------------- */

SDR_INLINE void gather_chunk(const int n, const int finite, const int sums, const int marked,
                             const sdr_nonordinary_body *body, int64_t chunk, double *const u[3])
{
  const int64_t *const slot = body->bonds->loose.chunk_slot + chunk, point = chunk * SDR_LANES;
  const sdr_sums s = sums_at(n, body, point);
  for (int64_t column = slot[0]; column < slot[1]; column += SDR_LANES) {
#pragma omp simd
    for (int k = 0; k < SDR_LANES; ++k) {
      const sdr_lane p = lane_at(n, marked, body, point + k, column + k, u);
      const sdr_moments f = moments_of(n, p.xi, p.length, p.wij);
      double along = 0.0, square = 0.0;
      for (int a = 0; a < n; ++a) {
        along += p.eta[a] * p.normal[a];
        square += p.eta[a] * p.eta[a];
        for (int b = 0; b < n; ++b) s.m[n * a + b][k] += f.m[b] * p.eta[a];
      }
      for (int a = 0; !finite && a < kept_of_normal(n); ++a) s.q[a][k] += f.q[a] * along;
      if (sums && !finite) {
        s.square[k] += f.w * square;
        s.along[k] += f.w * (along * along);
      }
    }
  }
}

SDR_INLINE void gather_chunks(const int n, const int finite, const int sums,
                              const sdr_nonordinary_body *body, int64_t first, int64_t end,
                              double *const u[3])
{
  for (int64_t chunk = first; chunk < end; ++chunk)
    if (body->loose_flagged)
      gather_chunk(n, finite, sums, 1, body, chunk, u);
    else
      gather_chunk(n, finite, sums, 0, body, chunk, u);
}

/* ---- pass A2 --------------------------------------------------------------------------------- */

SDR_INLINE void control_chunk(const int n, const int marked, const sdr_nonordinary_body *body,
                              int64_t chunk, double *const u[3])
{
  const int64_t *const slot = body->bonds->loose.chunk_slot + chunk, point = chunk * SDR_LANES;
  const sdr_side side = side_at(n, body, point);
  for (int64_t column = slot[0]; column < slot[1]; column += SDR_LANES) {
#pragma omp simd
    for (int k = 0; k < SDR_LANES; ++k) {
      const sdr_lane p = lane_at(n, marked, body, point + k, column + k, u);
      const sdr_residual r = residual_of(n, side.g, k, p.xi, p.eta);
      add_control(n, &r, 1.0 / r.square, p.wij, p.xi, side.s, side.square, side.along, k);
    }
  }
}

SDR_INLINE void control_chunks(const int n, const sdr_nonordinary_body *body, int64_t first,
                               int64_t end, double *const u[3])
{
  for (int64_t chunk = first; chunk < end; ++chunk)
    if (body->loose_flagged)
      control_chunk(n, 1, body, chunk, u);
    else
      control_chunk(n, 0, body, chunk, u);
}

/* ---- pass B ---------------------------------------------------------------------------------- */

/* Force per W of the directed state of point k of `at`. */
SDR_INLINE void state_of(const int n, const int finite, const sdr_bearing *at, int64_t k,
                         const sdr_lane *p, double *force)
{
  for (int a = 0; a < n; ++a) {
    force[a] = at->soft[k] * p->eta[a];
    for (int b = 0; b < n; ++b) force[a] += at->a[n * a + b][k] * p->xi[b];
  }
  if (finite) {
    const sdr_residual r = residual_of(n, at->g, k, p->xi, p->eta);
    const double c = at->stiff[k] * (r.along / r.square);
    for (int a = 0; a < n; ++a) force[a] += c * r.f[a];
  } else {
    double along = 0.0;
    for (int a = 0; a < n; ++a) along += p->eta[a] * p->normal[a];
    const double c = normal_of_linear(n, at, k, along, p->xi, p->normal);
    for (int a = 0; a < n; ++a) force[a] += c * p->normal[a];
  }
}

SDR_INLINE void force_chunk(const int n, const int finite, const int marked,
                            const sdr_nonordinary_body *body, int64_t chunk, double *const u[3],
                            double *const f[3])
{
  const int64_t *const slot = body->bonds->loose.chunk_slot + chunk, point = chunk * SDR_LANES;
  const sdr_bearing all = bearing_at(n, body, 0);
  const int32_t *const neighbour = body->bonds->loose.j;
  _Alignas(64) double sum[3][SDR_LANES] = {{0.0}};
  for (int64_t column = slot[0]; column < slot[1]; column += SDR_LANES) {
#pragma omp simd
    for (int k = 0; k < SDR_LANES; ++k) {
      const sdr_lane p = lane_at(n, marked, body, point + k, column + k, u);
      double own[3], other[3];
      state_of(n, finite, &all, point + k, &p, own);
      state_of(n, finite, &all, neighbour[column + k], &p, other);
      for (int a = 0; a < n; ++a) sum[a][k] += p.wij * own[a] + p.wji * other[a];
    }
  }
  for (int a = 0; a < n; ++a)
    for (int k = 0; k < SDR_LANES; ++k) f[a][point + k] += sum[a][k];
}

SDR_INLINE void force_chunks(const int n, const int finite, const sdr_nonordinary_body *body,
                             int64_t first, int64_t end, double *const u[3], double *const f[3])
{
  for (int64_t chunk = first; chunk < end; ++chunk)
    if (body->loose_flagged)
      force_chunk(n, finite, 1, body, chunk, u, f);
    else
      force_chunk(n, finite, 0, body, chunk, u, f);
}

/* ---- bonds that break ------------------------------------------------------------------------ */

SDR_INLINE void find_chunks(const int n, const sdr_nonordinary_body *body, int64_t first,
                            int64_t end, double *const u[3], const double *limit, uint8_t *found)
{
  for (int64_t chunk = first; chunk < end; ++chunk) {
    const int64_t *const slot = body->bonds->loose.chunk_slot + chunk;
    const int64_t point = chunk * SDR_LANES;
    int any = 0;
    for (int64_t column = slot[0]; column < slot[1]; column += SDR_LANES) {
#pragma omp simd reduction(| : any)
      for (int k = 0; k < SDR_LANES; ++k) {
        const sdr_lane p = lane_at(n, 0, body, point + k, column + k, u);
        const sdr_flags flags = body->loose_flags[column + k];
        double z = 0.0;
        for (int a = 0; a < n; ++a) z += (2.0 * p.xi[a] + p.eta[a]) * p.eta[a];
        z /= p.length * p.length;
        const int over_i = flags & (SDR_LOST_I | SDR_PROTECTED) ? 0 : z > limit[point + k];
        const int over_j =
            flags & (SDR_LOST_J | SDR_PROTECTED) ? 0 : z > limit[body->bonds->loose.j[column + k]];
        any |= over_i | over_j;
      }
    }
    found[chunk] = (uint8_t)any;
  }
}

#endif
