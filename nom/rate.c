#include "nom/rate.h"

#include "base/memory.h"
#include "base/parallel.h"

#include <math.h>

enum { BLOCK = 256 }; /* points a task */

typedef struct {
  const sdr_support *support;
  sdr_influence influence;
  const double *const *y, *const *v;
  double *out;
  int32_t *bad; /* by block: first point without a gradient, or -1 */
} rate;

/* velocity = sum w V (v_j - v_i) (x) xi, shape = sum w V (y_j - y_i) (x) xi. */
static void sums_of(const rate *s, int32_t i, double velocity[3][3], double shape[3][3])
{
  const sdr_cloud *cloud = &s->support->cloud;
  const int d = cloud->components;
  for (int64_t k = s->support->row[i]; k < s->support->row[i + 1]; ++k) {
    const int32_t j = s->support->column[k];
    double xi[3], square = 0.0;
    for (int a = 0; a < d; ++a) {
      xi[a] = cloud->x[a][j] - cloud->x[a][i];
      square += xi[a] * xi[a];
    }
    const double w = sdr_influence_at(s->influence, sqrt(square) / s->support->radius[i]) *
                     (cloud->volume ? cloud->volume[j] : 1.0);
    for (int a = 0; a < d; ++a)
      for (int b = 0; b < d; ++b) {
        velocity[a][b] += w * (s->v[a][j] - s->v[a][i]) * xi[b];
        shape[a][b] += w * (s->y[a][j] - s->y[a][i]) * xi[b];
      }
  }
}

/* Cofactors of m; the determinant. */
static double cofactors(const double m[3][3], double c[3][3])
{
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const int a1 = (a + 1) % 3, a2 = (a + 2) % 3, b1 = (b + 1) % 3, b2 = (b + 2) % 3;
      c[a][b] = m[a1][b1] * m[a2][b2] - m[a1][b2] * m[a2][b1];
    }
  return m[0][0] * c[0][0] + m[0][1] * c[0][1] + m[0][2] * c[0][2];
}

static int gradient_at(const rate *s, int32_t i, double out[9])
{
  const int d = s->support->cloud.components;
  double velocity[3][3] = {{0.0}}, shape[3][3] = {{0.0}}, cofactor[3][3], size = 0.0;
  sums_of(s, i, velocity, shape);
  for (int a = 0; a < d; ++a)
    for (int b = 0; b < d; ++b) size = fmax(size, fabs(shape[a][b]));
  if (!(size > 0.0) || !isfinite(size)) return 0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      shape[a][b] = a < d && b < d ? shape[a][b] / size : a == b ? 1.0 : 0.0;
  const double determinant = cofactors((const double(*)[3])shape, cofactor);
  if (!(fabs(determinant) > 1e-12)) return 0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      double sum = 0.0;
      for (int c = 0; c < 3; ++c) sum += velocity[a][c] * cofactor[b][c];
      out[3 * a + b] = sum / (determinant * size);
    }
  return 1;
}

static void rate_block(void *context, int block)
{
  const rate *s = context;
  const int32_t count = s->support->cloud.count, first = block * BLOCK;
  const int32_t end = first + BLOCK < count ? first + BLOCK : count;
  s->bad[block] = -1;
  for (int32_t i = first; i < end; ++i)
    if (!gradient_at(s, i, s->out + 9 * (size_t)i) && s->bad[block] < 0) s->bad[block] = i;
}

sdr_status sdr_rate_gradient(const sdr_support *support, sdr_influence influence,
                             const double *const y[3], const double *const v[3], double *out)
{
  const int blocks = (support->cloud.count + BLOCK - 1) / BLOCK;
  int32_t *bad = sdr_alloc((size_t)blocks, sizeof *bad);
  if (!bad) return SDR_RUN_FAILED;
  rate s = {support, influence, y, v, out, bad};
  sdr_parallel_for(0, blocks, 1, rate_block, &s);
  int32_t first = -1;
  for (int b = 0; b < blocks && first < 0; ++b) first = bad[b];
  sdr_free(bad);
  if (first < 0) return SDR_OK;
  return sdr_fail(SDR_RUN_FAILED,
                  "%s: its %d neighbours have collapsed in their present places, so no velocity "
                  "gradient exists there",
                  sdr_point_named(&support->cloud, first).text,
                  (int)(support->row[first + 1] - support->row[first]));
}
