/* Slopes of energies and forces by differences, for bodies all of whose bonds are stretched. */
#ifndef SDR_TESTS_SLOPES_H
#define SDR_TESTS_SLOPES_H

#include "support/body.h"

/* All bonds stretch by 0.009 to 0.023 at factor 1, of the same sign everywhere. */
static inline void slopes_stretch(const body *b, double factor, uint64_t seed, double *const u[3])
{
  const double gradient[9] = {0.020, 0.003, 0.000, 0.001, 0.012, 0.001, 0.000, -0.001, 0.016};
  double *extra[3], scaled[9];
  for (int c = 0; c < 9; ++c) scaled[c] = factor * gradient[c];
  vector_create(b->points, extra);
  vector_noise(b->points, 4e-4 * body_spacing, seed, extra);
  vector_linear(b->points, scaled, u);
  vector_add(b->points, u, 1.0, extra, u);
  vector_destroy(extra);
}

static inline double slopes_energy(const body *b, double *const u[3])
{
  sdr_energies e;
  b->model->ops->energies(b->model, u, &e);
  return e.stored + e.dissipated;
}

/* d energy/d u_ia by differences of fourth order with steps of h. */
static inline double slopes_of_energy(const body *b, double *const u[3], int a, int32_t i, double h)
{
  const double there = u[a][i];
  double e[4];
  for (int k = 0; k < 4; ++k) {
    u[a][i] = there + h * (k < 2 ? k - 2 : k - 1);
    e[k] = slopes_energy(b, u);
  }
  u[a][i] = there;
  return (e[0] - 8.0 * e[1] + 8.0 * e[2] - e[3]) / (12.0 * h);
}

/* column = -df/du_ia by differences of fourth order. */
static inline void slopes_of_force(const body *b, double *const u[3], int a, int32_t i, double h,
                                   double *const column[3])
{
  static const double factor[4] = {1.0, -8.0, 8.0, -1.0};
  const double there = u[a][i];
  double *f[3];
  vector_create(b->points, f);
  for (int c = 0; c < b->points->components; ++c)
    memset(column[c], 0, (size_t)b->points->count * sizeof(double));
  for (int k = 0; k < 4; ++k) {
    u[a][i] = there + h * (k < 2 ? k - 2 : k - 1);
    b->model->ops->force(b->model, u, f);
    vector_add(b->points, column, -factor[k] / (12.0 * h), f, column);
  }
  u[a][i] = there;
  vector_destroy(f);
}

#endif
