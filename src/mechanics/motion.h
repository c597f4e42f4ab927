/* The motion of points in a step of leapfrog, and displacements as whole numbers. */
#ifndef SDR_MECHANICS_MOTION_H
#define SDR_MECHANICS_MOTION_H

#include <stdint.h>

/* Of values: the least, the largest, and (of the other values beside them) the largest amount. */
typedef struct {
  double low, high, largest;
} sdr_spread;

typedef struct {
  /* v += dt f/mass, u += dt v for `count` values of one component. 1 if a new |v| is not below
     `fast` (or not a number), else 0. */
  int (*move)(int32_t count, double dt, double fast, const double *mass, const double *f, double *v,
              double *u);
  /* place[k] = u[k] times `scale`, rounded to whole numbers, modulo 2^32, for amounts below 2^51;
     out: least and largest v, largest |u|. */
  void (*split)(int32_t count, double scale, const double *u, const double *v, int32_t *place,
                sdr_spread *out);
} sdr_motion_kernels;

extern const sdr_motion_kernels sdr_motion_kernels_baseline;
#ifdef SDR_HAVE_X86_KERNELS
extern const sdr_motion_kernels sdr_motion_kernels_avx2, sdr_motion_kernels_avx512;
#endif

/* The kernels for the best instruction set that this processor and sdr_isa_limit allow. */
const sdr_motion_kernels *sdr_motion_kernels_best(void);

#endif
