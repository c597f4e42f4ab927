/* Which runs and chunks have bonds that critical stretch breaks; `n` is a literal where they are
   inlined. */
#ifndef SDR_MECHANICS_NONORDINARY_FIND_H
#define SDR_MECHANICS_NONORDINARY_FIND_H

#include "mechanics/nonordinary_loop.h"

SDR_INLINE int found_in_run(const int n, const int marked, const sdr_nonordinary_body *body,
                            const sdr_bond_run *run, const double *limit, double *const u[3])
{
  const sdr_bond_class *class = &body->bonds->classes[run->class_index];
  const double *const limit_i = limit + run->i0, *const limit_j = limit + run->j0;
  const double xx = class->xi[0], xy = class->xi[1], xz = class->xi[2];
  const double *const xi = u[0] + run->i0, *const xj = u[0] + run->j0;
  const double *const yi = n > 1 ? u[1] + run->i0 : xi, *const yj = n > 1 ? u[1] + run->j0 : xj;
  const double *const zi = n > 2 ? u[2] + run->i0 : xi, *const zj = n > 2 ? u[2] + run->j0 : xj;
  const sdr_flags *const flags = marked ? body->flags + run->slot : NULL;
  int any = 0;
#pragma omp simd reduction(| : any)
  for (int k = 0; k < run->length; ++k) {
    const double ex = xj[k] - xi[k], ey = n > 1 ? yj[k] - yi[k] : 0.0;
    const double ez = n > 2 ? zj[k] - zi[k] : 0.0;
    double z = (2.0 * xx + ex) * ex;
    if (n > 1) z += (2.0 * xy + ey) * ey;
    if (n > 2) z += (2.0 * xz + ez) * ez;
    z *= class->inverse_square;
    int over_i = z > limit_i[k], over_j = z > limit_j[k];
    if (marked) {
      over_i = flags[k] & (SDR_LOST_I | SDR_PROTECTED) ? 0 : over_i;
      over_j = flags[k] & (SDR_LOST_J | SDR_PROTECTED) ? 0 : over_j;
    }
    any |= over_i | over_j;
  }
  return any;
}

SDR_INLINE void find_runs(const int n, const sdr_nonordinary_body *body, int64_t first, int64_t end,
                          double *const u[3], const double *limit, uint8_t *found)
{
  for (int64_t r = first; r < end; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    found[r] = (uint8_t)(body->run_flagged && body->run_flagged[r]
                             ? found_in_run(n, 1, body, run, limit, u)
                             : found_in_run(n, 0, body, run, limit, u));
  }
}

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
        sdr_lanes z = all_lanes(0.0), other[3] = {z, z, z};
        const int32_t *const j = body->bonds->loose.j + at + lane;
        for (int a = 0; a < n; ++a) other[a] = gather_lanes(u[a], j);
        loose_lanes_of(n, body, i, at + lane, u, other, &p);
        for (int a = 0; a < n; ++a) z += (2.0 * p.xi[a] + p.eta[a]) * p.eta[a];
        z *= p.by_square;
        const sdr_lanes_int flags = load_ints(body->loose_flags + at + lane);
        const sdr_lanes_int far_i = ints_of(z > load_lanes(limit + i));
        const sdr_lanes_int far_j = ints_of(z > gather_lanes(limit, j));
        any |= any_ints((far_i & ((flags & (SDR_LOST_I | SDR_PROTECTED)) == 0)) |
                        (far_j & ((flags & (SDR_LOST_J | SDR_PROTECTED)) == 0)));
      }
    found[chunk] = (uint8_t)any;
  }
}

#endif
