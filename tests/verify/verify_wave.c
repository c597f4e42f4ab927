/* A wave through a strip of finer points (problem wave_plate), as far as it is quick: the uniform
   plate, and the first two crossings of the strip with the dual horizon and without. */
#include "support/figures.h"

/* Two crossings of the strip. */
static const char *const two_crossings[] = {"time.end=100 ms",
                                            "output.snapshots=0",
                                            "output.measures.error_650=null",
                                            "output.measures.error_990=null",
                                            "figures.error_650=null",
                                            "figures.error_990=null",
                                            NULL};

static void a_uniform_plate_carries_the_wave_as_in_the_paper(void **state)
{
  (void)state;
  figures f;
  figures_run(&f, "wave_plate", "A", (const char *const[]){"output.snapshots=0", NULL});
  figures_assert_accepted(&f, 7);
  figures_free(&f);
}

static void the_dual_horizon_lets_the_wave_through_the_strip(void **state)
{
  (void)state;
  static const char *const variants[] = {NULL, "C_cubic", "C_nonordinary"};
  for (int k = 0; k < 3; ++k) {
    figures f;
    figures_run(&f, "wave_plate", variants[k], two_crossings);
    figures_assert_accepted(&f, 5);
    figures_free(&f);
  }
}

static void without_it_momentum_comes_from_nowhere(void **state)
{
  (void)state;
  figures f;
  figures_run(&f, "wave_plate", "B", two_crossings);
  assert_true(figures_value(&f, "momentum") > 1e-2);
  assert_true(figures_value(&f, "error_100") > 0.1);
  assert_true(figures_value(&f, "energy_low") < -0.01);
  figures_free(&f);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_uniform_plate_carries_the_wave_as_in_the_paper),
      cmocka_unit_test(the_dual_horizon_lets_the_wave_through_the_strip),
      cmocka_unit_test(without_it_momentum_comes_from_nowhere),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
