/* Parts of a Hessian (sdr_hessian_visitor) times a vector. */
#ifndef SDR_TESTS_ELEMENTS_H
#define SDR_TESTS_ELEMENTS_H

#include "mechanics/state_body.h" /* before body.h, whose type has the name of a parameter there */
#include "support/body.h"

typedef struct {
  int components;
  double *const *v, *const *out;
  double asymmetry, largest;
} elements;

static inline void elements_add(void *context, int count, const int32_t *point, const double *block)
{
  elements *all = context;
  const int n = all->components, size = n * count;
  for (int r = 0; r < size; ++r)
    for (int c = 0; c < size; ++c) {
      const double value = block[r * size + c];
      all->out[r % n][point[r / n]] += value * all->v[c % n][point[c / n]];
      all->asymmetry = fmax(all->asymmetry, fabs(value - block[c * size + r]));
      all->largest = fmax(all->largest, fabs(value));
    }
}

/* The secant stiffness of a body at rest is its tangent; at u it is symmetric, and no motion of a
   few, u among them, has a negative energy. The body must not be damaged yet. */
static inline void elements_check_secant(const sdr_points *points, sdr_model *model,
                                         double *const u[3])
{
  double *v[3], *rest[3], *exact[3], *out[3];
  double **const all[4] = {v, rest, exact, out};
  for (int k = 0; k < 4; ++k) vector_create(points, all[k]);
  vector_noise(points, 1.0, 33, v);
  elements secant = {points->components, v, out, 0.0, 0.0};
  assert_int_equal(model->ops->visit_secant(model, rest, elements_add, &secant), SDR_OK);
  assert_int_equal(model->ops->tangent_times(model, rest, v, exact), SDR_OK);
  assert_at_most(vector_difference(points, out, exact), 1e-12 * vector_largest(points, exact));
  assert_at_most(secant.asymmetry, 1e-13 * secant.largest);
  for (uint64_t trial = 0; trial < 4; ++trial) {
    vector_noise(points, 1.0, 40 + trial, v);
    if (trial == 0) vector_add(points, rest, 1.0, u, v);
    for (int a = 0; a < points->components; ++a)
      memset(out[a], 0, (size_t)points->count * sizeof(double));
    assert_int_equal(model->ops->visit_secant(model, u, elements_add, &secant), SDR_OK);
    assert_true(vector_dot(points, v, out) > 0.0);
  }
  for (int k = 0; k < 4; ++k) vector_destroy(all[k]);
}

#endif
