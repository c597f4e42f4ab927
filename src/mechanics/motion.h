/* The motion of points in a step of leapfrog. */
#ifndef SDR_MECHANICS_MOTION_H
#define SDR_MECHANICS_MOTION_H

#include <stdint.h>

typedef struct {
  /* v += dt f/mass, u += dt v for `count` values of one component. 1 if a new |v| is not below
     `fast` (or not a number), else 0. */
  int (*move)(int32_t count, double dt, double fast, const double *mass, const double *f, double *v,
              double *u);
} sdr_motion_kernels;

extern const sdr_motion_kernels sdr_motion_kernels_baseline;
#ifdef SDR_HAVE_X86_KERNELS
extern const sdr_motion_kernels sdr_motion_kernels_avx2, sdr_motion_kernels_avx512;
#endif

/* The kernels for the best instruction set that this processor and sdr_isa_limit allow. */
const sdr_motion_kernels *sdr_motion_kernels_best(void);

#endif
