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

/* Inverse of a 3 x 3 matrix, row major; returns the determinant, if it is 0 the inverse is none. */
static inline double sdr_invert3(const double m[9], double inverse[9])
{
  double det = 0.0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const int a1 = (a + 1) % 3, a2 = (a + 2) % 3, b1 = (b + 1) % 3, b2 = (b + 2) % 3;
      inverse[3 * b + a] = m[3 * a1 + b1] * m[3 * a2 + b2] - m[3 * a1 + b2] * m[3 * a2 + b1];
    }
  for (int b = 0; b < 3; ++b) det += m[b] * inverse[3 * b];
  for (int c = 0; c < 9; ++c) inverse[c] /= det != 0.0 ? det : 1.0;
  return det;
}

#endif
