/* Logarithms and exponentials of lanes beside those of the C library. */
#include "mechanics/lanes_log.h"

#include "support/cmocka_all.h"

enum { COUNT = 4000 };

/* |got - right| in units of the last place of `right`. */
static double units_off(double got, double right)
{
  const double unit = nextafter(fabs(right), (double)INFINITY) - fabs(right);
  return fabs(got - right) / unit;
}

static double worst_log(double low, double high)
{
  double worst = 0.0;
  for (int k = 0; k < COUNT; ++k) {
    const double x = low + (high - low) * k / (COUNT - 1);
    const sdr_lanes got = log1p_lanes(all_lanes(x));
    for (int lane = 0; lane < SDR_WIDTH; ++lane)
      worst = fmax(worst, units_off(got[lane], log1p(x)));
  }
  return worst;
}

static double worst_exp(double low, double high)
{
  double worst = 0.0;
  for (int k = 0; k < COUNT; ++k) {
    const double x = low + (high - low) * k / (COUNT - 1);
    const sdr_lanes got = expm1_lanes(all_lanes(x));
    for (int lane = 0; lane < SDR_WIDTH; ++lane)
      worst = fmax(worst, units_off(got[lane], expm1(x)));
  }
  return worst;
}

static void logarithms_are_within_two_units_of_the_last_place(void **state)
{
  (void)state;
  assert_true(worst_log(-1e-300, 1e-300) == 0.0);
  assert_true(worst_log(-1e-12, 1e-12) <= 2.0);
  assert_true(worst_log(-0.3, 0.4) <= 2.0);
  assert_true(worst_log(-0.95, 9.0) <= 2.0);
  assert_true(worst_log(1e3, 1e9) <= 2.0);
}

static void exponentials_are_within_two_units_of_the_last_place(void **state)
{
  (void)state;
  assert_true(worst_exp(-1e-300, 1e-300) == 0.0);
  assert_true(worst_exp(-1e-12, 1e-12) <= 2.0);
  assert_true(worst_exp(-0.3, 0.3) <= 2.0);
  assert_true(worst_exp(-5.0, 5.0) <= 2.0);
  assert_true(worst_exp(-690.0, 690.0) <= 2.0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(logarithms_are_within_two_units_of_the_last_place),
      cmocka_unit_test(exponentials_are_within_two_units_of_the_last_place)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
