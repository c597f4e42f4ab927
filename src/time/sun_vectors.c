/* The operations on vectors that cost the most, as loops that compilers turn into vector code: the
   library's own are not optimised on some systems, and its norms take a call of a function for each
   entry. */
#include "time/sun_vectors.h"

#include <math.h>
#include <nvector/nvector_serial.h>

static realtype squares(N_Vector x, N_Vector w)
{
  const sunindextype n = NV_LENGTH_S(x);
  const realtype *a = NV_DATA_S(x), *b = NV_DATA_S(w);
  realtype sum = 0.0;
#pragma omp simd reduction(+ : sum)
  for (sunindextype k = 0; k < n; ++k) sum += (a[k] * b[k]) * (a[k] * b[k]);
  return sum;
}

static realtype norm(N_Vector x, N_Vector w)
{
  return sqrt(squares(x, w) / (realtype)NV_LENGTH_S(x));
}

static void sum_of_two(realtype a, N_Vector x, realtype b, N_Vector y, N_Vector z)
{
  const sunindextype n = NV_LENGTH_S(x);
  const realtype *p = NV_DATA_S(x), *q = NV_DATA_S(y);
  realtype *r = NV_DATA_S(z);
#pragma omp simd
  for (sunindextype k = 0; k < n; ++k) r[k] = a * p[k] + b * q[k];
}

static void constant(realtype c, N_Vector z)
{
  const sunindextype n = NV_LENGTH_S(z);
  realtype *r = NV_DATA_S(z);
#pragma omp simd
  for (sunindextype k = 0; k < n; ++k) r[k] = c;
}

static void scaled(realtype c, N_Vector x, N_Vector z)
{
  const sunindextype n = NV_LENGTH_S(z);
  const realtype *p = NV_DATA_S(x);
  realtype *r = NV_DATA_S(z);
#pragma omp simd
  for (sunindextype k = 0; k < n; ++k) r[k] = c * p[k];
}

static int scale_each(int count, realtype *c, N_Vector *x, N_Vector *z)
{
  for (int v = 0; v < count; ++v) scaled(c[v], x[v], z[v]);
  return 0;
}

static int sum_each(int count, realtype a, N_Vector *x, realtype b, N_Vector *y, N_Vector *z)
{
  for (int v = 0; v < count; ++v) sum_of_two(a, x[v], b, y[v], z[v]);
  return 0;
}

/* y += the sum of a few, in blocks that stay in the cache. */
static int combine(int count, realtype *c, N_Vector *x, N_Vector z)
{
  enum { BLOCK = 512 };
  const sunindextype n = NV_LENGTH_S(z);
  realtype *r = NV_DATA_S(z), sum[BLOCK];
  for (sunindextype from = 0; from < n; from += BLOCK) {
    const sunindextype length = n - from < BLOCK ? n - from : BLOCK;
    const realtype *first = NV_DATA_S(x[0]) + from;
#pragma omp simd
    for (sunindextype k = 0; k < length; ++k) sum[k] = c[0] * first[k];
    for (int v = 1; v < count; ++v) {
      const realtype *p = NV_DATA_S(x[v]) + from, factor = c[v];
#pragma omp simd
      for (sunindextype k = 0; k < length; ++k) sum[k] += factor * p[k];
    }
#pragma omp simd
    for (sunindextype k = 0; k < length; ++k) r[from + k] = sum[k];
  }
  return 0;
}

static int add_multiples(int count, realtype *a, N_Vector x, N_Vector *y, N_Vector *z)
{
  const sunindextype n = NV_LENGTH_S(x);
  const realtype *p = NV_DATA_S(x);
  for (int v = 0; v < count; ++v) {
    const realtype *q = NV_DATA_S(y[v]), factor = a[v];
    realtype *r = NV_DATA_S(z[v]);
#pragma omp simd
    for (sunindextype k = 0; k < n; ++k) r[k] = factor * p[k] + q[k];
  }
  return 0;
}

void sdr_sun_quicken(void *vector)
{
  N_Vector v = vector;
  N_VEnableFusedOps_Serial(v, SUNTRUE);
  v->ops->nvwrmsnorm = norm;
  v->ops->nvwsqrsumlocal = squares;
  v->ops->nvlinearsum = sum_of_two;
  v->ops->nvconst = constant;
  v->ops->nvscale = scaled;
  v->ops->nvscalevectorarray = scale_each;
  v->ops->nvlinearsumvectorarray = sum_each;
  v->ops->nvlinearcombination = combine;
  v->ops->nvscaleaddmulti = add_multiples;
}
