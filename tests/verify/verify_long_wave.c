/* Every variant of the problem wave_plate to its end, and the order of its energy balance. */
#include "support/figures.h"

static const char *const no_pictures[] = {"output.snapshots=0", NULL};

static void every_variant_of_the_wave_is_within_its_ranges(void **state)
{
  (void)state;
  static const char *const variants[] = {NULL,      "A_iso",         "C_iso",        "A_cubic",
                                         "C_cubic", "A_nonordinary", "C_nonordinary"};
  for (int k = 0; k < 7; ++k) {
    figures f;
    figures_run(&f, "wave_plate", variants[k], no_pictures);
    figures_assert_accepted(&f, 7);
    figures_free(&f);
  }
}

static void without_the_dual_horizon_the_wave_is_lost(void **state)
{
  (void)state;
  figures f;
  figures_run(&f, "wave_plate", "B", no_pictures);
  figures_assert_accepted(&f, 2); /* error at 650 above 0.5, momentum above 0.01 */
  figures_free(&f);
}

static void half_the_step_leaves_a_quarter_of_the_imbalance(void **state)
{
  (void)state;
  static const char *const half[] = {"output.snapshots=0", "time.step=0.25 ms", NULL};
  figures whole, finer;
  figures_run(&whole, "wave_plate", "A", no_pictures);
  figures_run(&finer, "wave_plate", "A", half);
  const double ratio = figures_value(&whole, "energy_low") / figures_value(&finer, "energy_low");
  assert_true(ratio > 3.5 && ratio < 4.5);
  figures_free(&whole);
  figures_free(&finer);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_variant_of_the_wave_is_within_its_ranges),
      cmocka_unit_test(without_the_dual_horizon_the_wave_is_lost),
      cmocka_unit_test(half_the_step_leaves_a_quarter_of_the_imbalance),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
