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

/* A symmetric positive definite matrix of n <= 3 rows, row major with 3 to a row, becomes its
   inverse; 0 if it is not positive, and then it is as it was. */
static inline int sdr_invert_positive(double *a, int n)
{
  double l[9] = {0.0}, inverse[9] = {0.0};
  for (int r = 0; r < n; ++r)
    for (int c = 0; c <= r; ++c) {
      double sum = a[3 * r + c];
      for (int k = 0; k < c; ++k) sum -= l[3 * r + k] * l[3 * c + k];
      if (c < r)
        l[3 * r + c] = sum / l[3 * c + c];
      else if (!(sum > 0.0))
        return 0;
      else
        l[3 * r + r] = sqrt(sum);
    }
  for (int c = 0; c < n; ++c) { /* columns of L^-1 */
    for (int r = c; r < n; ++r) {
      double sum = r == c ? 1.0 : 0.0;
      for (int k = c; k < r; ++k) sum -= l[3 * r + k] * inverse[3 * k + c];
      inverse[3 * r + c] = sum / l[3 * r + r];
    }
  }
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      a[3 * r + c] = 0.0;
      for (int k = 0; k < n; ++k) a[3 * r + c] += inverse[3 * k + r] * inverse[3 * k + c];
    }
  return 1;
}

#endif
