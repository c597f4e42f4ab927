/* time: the stability limit against closed forms and dense eigenvalues. */
#include "support/still_body.h"
#include "time/stable_step.h"

#include <gsl/gsl_eigen.h>

/* Never high (but by rounding), low by at most 0.5 %. */
static void assert_limit(double limit, double exact)
{
  assert_at_most(limit, exact * (1.0 + 1e-9));
  assert_true(limit >= exact * (1.0 - 0.005));
}

/* A chain of equal masses and springs: omega = 2 sqrt(k/m) cos(pi/(2 N)). */
static void a_chain_has_the_closed_forms_limit(void **state)
{
  (void)state;
  static const int32_t counts[] = {2, 3, 7, 100, 2000};
  for (int k = 0; k < 5; ++k)
    for (int loose = 0; loose < 2; ++loose) {
      const body_how how = {
          .dimension = SDR_1D, .cells = {counts[k]}, .ratio = 1.01, .force_loose = loose};
      still_body s;
      double limit;
      still_create(&how, &s);
      const double speed = sqrt(body_young / still_density[0]); /* sqrt(k/m) dx */
      const double omega =
          2.0 * speed / body_spacing * cos(3.14159265358979323846 / (2.0 * counts[k]));
      assert_int_equal(sdr_stable_step(s.system, &limit), SDR_OK);
      assert_limit(limit, 2.0 / omega);
      if (counts[k] < 4) assert_near(limit, 2.0 / omega, 1e-9 * limit);
      still_destroy(&s);
    }
}

static double *column_of(const still_body *s, size_t unknown)
{
  const sdr_points *points = s->body.points;
  const size_t n = (size_t)points->count;
  double *v[3], *out[3], *column = sdr_alloc(n * 3, sizeof *column);
  vector_create(points, v);
  vector_create(points, out);
  v[unknown / n][unknown % n] = 1.0;
  s->body.model->ops->reference_times(s->body.model, v, out);
  for (int a = 0; a < points->components; ++a)
    memcpy(column + (size_t)a * n, out[a], n * sizeof *column);
  vector_destroy(v);
  vector_destroy(out);
  return column;
}

/* omega_max from all eigenvalues of M^-1/2 K M^-1/2. */
static double dense_omega(const still_body *s)
{
  const size_t n = (size_t)s->body.points->count;
  const size_t unknowns = n * (size_t)s->body.points->components;
  gsl_matrix *k = gsl_matrix_alloc(unknowns, unknowns);
  gsl_vector *values = gsl_vector_alloc(unknowns);
  gsl_eigen_symm_workspace *work = gsl_eigen_symm_alloc(unknowns);
  for (size_t c = 0; c < unknowns; ++c) {
    double *column = column_of(s, c);
    for (size_t r = 0; r < unknowns; ++r)
      gsl_matrix_set(k, r, c, column[r] / sqrt(s->system->mass[r % n] * s->system->mass[c % n]));
    sdr_free(column);
  }
  gsl_eigen_symm(k, values, work);
  const double largest = gsl_vector_max(values);
  gsl_matrix_free(k);
  gsl_vector_free(values);
  gsl_eigen_symm_free(work);
  return sqrt(largest);
}

static const body_how shapes[] = {
    {.dimension = SDR_1D, .cells = {50}, .scatter = 0.4},
    {.dimension = SDR_PLANE_STRESS, .cells = {12, 10}},
    {.dimension = SDR_PLANE_STRESS, .cells = {12, 10}, .scatter = 0.2, .two_materials = 1},
    {.dimension = SDR_PLANE_STRAIN, .cells = {11, 11}, .jitter = 0.3, .horizon_spread = 0.4},
    {.dimension = SDR_3D, .cells = {5, 4, 5}, .ratio = 2.01},
    {.dimension = SDR_3D, .cells = {4, 4, 4}, .jitter = 0.2, .horizon_spread = 0.2},
};

static void the_limit_is_that_of_the_dense_eigenvalues(void **state)
{
  (void)state;
  for (int k = 0; k < 6; ++k) {
    still_body s;
    double limit;
    still_create(&shapes[k], &s);
    assert_int_equal(sdr_stable_step(s.system, &limit), SDR_OK);
    assert_limit(limit, 2.0 / dense_omega(&s));
    still_destroy(&s);
  }
}

/* Gershgorin's bound is low by 1.67 in the plane (theory sec. 7); the true limit is asked for. */
static void the_limit_is_not_gershgorins(void **state)
{
  (void)state;
  const body_how how = {.dimension = SDR_PLANE_STRESS, .cells = {40, 40}};
  still_body s;
  double limit;
  still_create(&how, &s);
  assert_int_equal(sdr_stable_step(s.system, &limit), SDR_OK);
  const sdr_family *family = s.body.families->family;
  /* 2 sum k/m: twice the pair's stiffness 2 C V/|xi| over the whole family, per volume */
  double sum = 0.0;
  for (int y = -3; y <= 3; ++y)
    for (int x = -3; x <= 3; ++x)
      if ((x || y) && hypot(x, y) < 3.015) sum += 1.0 / (hypot(x, y) * body_spacing);
  const double c = body_micromodulus(&s.body, 0);
  const double omega2 = 2.0 * 2.0 * c * sum * family->volume / still_density[0];
  assert_near(limit / (2.0 / sqrt(omega2)), 1.67, 0.02);
  still_destroy(&s);
}

static void a_failing_allocation_is_reported(void **state)
{
  (void)state;
  still_body s;
  still_create(&shapes[1], &s);
  const size_t before = sdr_memory_now();
  for (long k = 0; k < 5; ++k) {
    double limit = -1.0;
    sdr_memory_fail_after(k);
    const sdr_status status = sdr_stable_step(s.system, &limit);
    sdr_memory_fail_after(-1);
    assert_int_equal(status, SDR_RUN_FAILED);
    assert_near(limit, -1.0, 0.0);
    assert_int_equal(sdr_memory_now(), before);
  }
  still_destroy(&s);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_chain_has_the_closed_forms_limit),
      cmocka_unit_test(the_limit_is_that_of_the_dense_eigenvalues),
      cmocka_unit_test(the_limit_is_not_gershgorins),
      cmocka_unit_test(a_failing_allocation_is_reported),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
