/* Small dense helpers in 1, 2 and 3 dimensions, inline. */
#ifndef SDR_BASE_SMALL_H
#define SDR_BASE_SMALL_H

#include <math.h>

static inline double sdr_dot3(const double a[3], const double b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double sdr_norm3(const double a[3])
{
  return sqrt(sdr_dot3(a, a));
}

static inline void sdr_cross3(const double a[3], const double b[3], double c[3])
{
  c[0] = a[1] * b[2] - a[2] * b[1];
  c[1] = a[2] * b[0] - a[0] * b[2];
  c[2] = a[0] * b[1] - a[1] * b[0];
}

#endif
