/* The limited memory of steps and changes of the gradient. */
#include "support/cmocka_all.h"
#include "time/secant_pairs.h"

#include <math.h>

enum { SIZE = 6 };

/* H = identity: steepest descent to begin with. */
static sdr_status identity(void *context, const double *r, double *z)
{
  (void)context;
  for (int k = 0; k < SIZE; ++k) z[k] = r[k];
  return SDR_OK;
}

/* Gradient of 1/2 sum (k + 1) x_k^2 + 1/2 (sum x)^2. */
static void slope(const double *x, double *g)
{
  double sum = 0.0;
  for (int k = 0; k < SIZE; ++k) sum += x[k];
  for (int k = 0; k < SIZE; ++k) g[k] = (k + 1.0) * x[k] + sum;
}

static double dot(const double *x, const double *y)
{
  double sum = 0.0;
  for (int k = 0; k < SIZE; ++k) sum += x[k] * y[k];
  return sum;
}

static void without_pairs_the_direction_is_the_given_one(void **state)
{
  (void)state;
  sdr_secant_pairs *pairs = NULL;
  const double g[SIZE] = {1.0, -2.0, 3.0, 0.0, 5.0, 6.0};
  double d[SIZE];
  assert_int_equal(sdr_secant_pairs_create(SIZE, &pairs), SDR_OK);
  sdr_secant_pairs_clear(pairs, SIZE);
  sdr_secant_pairs_note(pairs, g, g);
  assert_int_equal(sdr_secant_pairs_known(pairs), 0);
  assert_int_equal(sdr_secant_pairs_descend(pairs, g, identity, NULL, d), SDR_OK);
  for (int k = 0; k < SIZE; ++k) assert_true(d[k] == -g[k]);
  sdr_secant_pairs_destroy(&pairs);
}

static void the_last_change_of_the_gradient_is_answered_with_its_step(void **state)
{
  (void)state;
  sdr_secant_pairs *pairs = NULL;
  double x[SIZE] = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0}, g[SIZE], before[SIZE], y[SIZE], d[SIZE];
  assert_int_equal(sdr_secant_pairs_create(SIZE, &pairs), SDR_OK);
  sdr_secant_pairs_clear(pairs, SIZE);
  for (int step = 0; step < 4; ++step) {
    for (int k = 0; k < SIZE; ++k) before[k] = x[k];
    slope(x, g);
    sdr_secant_pairs_note(pairs, x, g);
    for (int k = 0; k < SIZE; ++k) y[k] = -g[k];
    for (int k = 0; k < SIZE; ++k) x[k] -= 0.1 * g[k];
    slope(x, g);
    for (int k = 0; k < SIZE; ++k) y[k] += g[k];
  }
  sdr_secant_pairs_note(pairs, x, g);
  assert_int_equal(sdr_secant_pairs_known(pairs), 4);
  assert_int_equal(sdr_secant_pairs_descend(pairs, y, identity, NULL, d), SDR_OK);
  for (int k = 0; k < SIZE; ++k) assert_true(fabs(d[k] - (before[k] - x[k])) < 1e-14);
  sdr_secant_pairs_destroy(&pairs);
}

/* With exact searches a quadratic function of n variables takes n steps. */
static void a_quadratic_function_is_minimised_in_as_many_steps_as_it_has_variables(void **state)
{
  (void)state;
  sdr_secant_pairs *pairs = NULL;
  double x[SIZE] = {3.0, -1.0, 4.0, 1.0, -5.0, 9.0}, g[SIZE], d[SIZE], turned[SIZE];
  assert_int_equal(sdr_secant_pairs_create(SIZE, &pairs), SDR_OK);
  sdr_secant_pairs_clear(pairs, SIZE);
  for (int step = 0; step < SIZE; ++step) {
    slope(x, g);
    assert_true(sqrt(dot(g, g)) > 1e-9);
    sdr_secant_pairs_note(pairs, x, g);
    assert_int_equal(sdr_secant_pairs_descend(pairs, g, identity, NULL, d), SDR_OK);
    assert_true(dot(d, g) < 0.0);
    slope(d, turned);
    for (int k = 0; k < SIZE; ++k) x[k] -= dot(d, g) / dot(d, turned) * d[k];
  }
  slope(x, g);
  assert_true(sqrt(dot(g, g)) < 1e-12);
  sdr_secant_pairs_destroy(&pairs);
}

static void a_change_against_the_step_is_forgotten(void **state)
{
  (void)state;
  sdr_secant_pairs *pairs = NULL;
  const double x0[SIZE] = {0.0}, x1[SIZE] = {1.0}, g0[SIZE] = {5.0}, g1[SIZE] = {2.0};
  assert_int_equal(sdr_secant_pairs_create(SIZE, &pairs), SDR_OK);
  sdr_secant_pairs_clear(pairs, SIZE);
  sdr_secant_pairs_note(pairs, x0, g0);
  sdr_secant_pairs_note(pairs, x1, g1);
  assert_int_equal(sdr_secant_pairs_known(pairs), 0);
  sdr_secant_pairs_destroy(&pairs);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(without_pairs_the_direction_is_the_given_one),
      cmocka_unit_test(the_last_change_of_the_gradient_is_answered_with_its_step),
      cmocka_unit_test(a_quadratic_function_is_minimised_in_as_many_steps_as_it_has_variables),
      cmocka_unit_test(a_change_against_the_step_is_forgotten),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
