/* nom: influence functions by name. */
#include "nom/influence.h"
#include "support/grid.h"

static void every_function_has_a_name_that_finds_it(void **state)
{
  (void)state;
  const char *const names[SDR_INFLUENCES] = {"constant", "1/r",   "1/r^2",
                                             "linear",   "cubic", "gaussian"};
  for (int k = 0; k < SDR_INFLUENCES; ++k) {
    sdr_influence found = SDR_INFLUENCES;
    assert_string_equal(sdr_influence_name((sdr_influence)k), names[k]);
    assert_int_equal(sdr_influence_named(names[k], &found), 1);
    assert_int_equal(found, k);
  }
}

static void an_unknown_name_finds_nothing(void **state)
{
  (void)state;
  sdr_influence found = SDR_INFLUENCE_CUBIC;
  assert_int_equal(sdr_influence_named("quartic", &found), 0);
  assert_int_equal(sdr_influence_named("", &found), 0);
  assert_int_equal(found, SDR_INFLUENCE_CUBIC);
  assert_null(sdr_influence_name(SDR_INFLUENCES));
}

static void they_take_the_values_of_their_formulas(void **state)
{
  (void)state;
  const double quarter[SDR_INFLUENCES] = {
      1.0, 4.0, 16.0, 0.75, 1.0 - 3.0 / 16.0 + 2.0 / 64.0, exp(-0.625 * 0.625)};
  for (int k = 0; k < SDR_INFLUENCES; ++k)
    assert_near(sdr_influence_at((sdr_influence)k, 0.25), quarter[k], 1e-15);
}

static void none_is_negative_and_those_that_end_at_h_stay_zero(void **state)
{
  (void)state;
  for (int k = 0; k < SDR_INFLUENCES; ++k)
    for (double q = 0.01; q < 2.0; q += 0.01)
      assert_true(sdr_influence_at((sdr_influence)k, q) >= 0.0);
  assert_true(sdr_influence_at(SDR_INFLUENCE_LINEAR, 1.0) == 0.0);
  assert_true(sdr_influence_at(SDR_INFLUENCE_CUBIC, 1.5) == 0.0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_function_has_a_name_that_finds_it),
      cmocka_unit_test(an_unknown_name_finds_nothing),
      cmocka_unit_test(they_take_the_values_of_their_formulas),
      cmocka_unit_test(none_is_negative_and_those_that_end_at_h_stay_zero),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
