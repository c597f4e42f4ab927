/* One step of points under their forces, compiled once for each instruction set; the same bits in
   all of them. */
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

const sdr_motion_kernels SDR_JOIN(sdr_motion_kernels_, SDR_ISA) = {.move = move};
