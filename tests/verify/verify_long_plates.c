/* The plates of paper 004 (problems tension_plate and plate_vibration) as they stand, against
   finite elements. */
#include "support/figures.h"

static const char *const no_files[] = {"output.snapshots=0", "output.probes=[]", NULL};

static void check(const char *problem, const char *variant, int accepted)
{
  figures f;
  figures_run(&f, problem, variant, no_files);
  figures_assert_accepted(&f, accepted);
  figures_free(&f);
}

static void plates_under_tension_bend_as_finite_elements_do(void **state)
{
  (void)state;
  check("tension_plate", NULL, 3);
  check("tension_plate", "nonordinary_2", 3);
}

static void plates_let_go_vibrate_as_finite_elements_do(void **state)
{
  (void)state;
  check("plate_vibration", NULL, 3);
  check("plate_vibration", "nonordinary_2", 3);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(plates_under_tension_bend_as_finite_elements_do),
      cmocka_unit_test(plates_let_go_vibrate_as_finite_elements_do),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
