/* One step of points under their forces, and displacements as whole numbers; compiled once for each
   instruction set; the same bits in all of them. */
#include "mechanics/motion.h"

#include <math.h>

#ifndef SDR_ISA
#define SDR_ISA baseline
#endif
#define SDR_JOIN_(a, b) a##b
#define SDR_JOIN(a, b) SDR_JOIN_(a, b)

static int move(int32_t count, double dt, double fast, const double *restrict mass,
                const double *restrict f, double *restrict v, double *restrict u)
{
  double suspects = 0.0;
#pragma omp simd reduction(+ : suspects)
  for (int32_t i = 0; i < count; ++i) {
    const double moved = v[i] + dt * f[i] / mass[i];
    v[i] = moved;
    u[i] += dt * moved;
    suspects += fabs(moved) < fast ? 0.0 : 1.0;
  }
  return suspects > 0.0;
}

static void split(int32_t count, double scale, const double *restrict u, const double *restrict v,
                  int32_t *restrict place, sdr_spread *out)
{
  const double whole = 6755399441055744.0; /* 1.5 2^52: what is added to it loses its fraction */
  double low = v[0], high = v[0], largest = 0.0;
#pragma omp simd reduction(min : low) reduction(max : high, largest)
  for (int32_t i = 0; i < count; ++i) {
    const double moved = fabs(u[i]);
    union {
      double number;
      uint64_t bits;
    } sum = {.number = u[i] * scale + whole};
    place[i] = (int32_t)(uint32_t)sum.bits;
    low = v[i] < low ? v[i] : low;
    high = v[i] > high ? v[i] : high;
    largest = moved > largest ? moved : largest;
  }
  *out = (sdr_spread){low, high, largest};
}

const sdr_motion_kernels SDR_JOIN(sdr_motion_kernels_, SDR_ISA) = {.move = move, .split = split};
