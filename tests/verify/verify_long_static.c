/* Problems of nonlinear statics as they stand: the L-panel through its peak, Lame's cylinder until
   it bursts. */
#include "support/figures.h"

static const char *const no_files[] = {"output.snapshots=0", NULL};

static void check(const char *problem, const char *variant, int accepted)
{
  figures f;
  figures_run(&f, problem, variant, no_files);
  figures_assert_accepted(&f, accepted);
  figures_free(&f);
}

static void the_l_panel_peaks_as_measured(void **state)
{
  (void)state;
  check("l_panel", NULL, 3);
  check("l_panel", "paper_toughness", 3);
  check("l_panel", "explicit", 2);
}

static void the_ring_bursts_under_both_laws(void **state)
{
  (void)state;
  check("lame_cylinder", NULL, 3);
  check("lame_cylinder", "burst", 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_l_panel_peaks_as_measured),
      cmocka_unit_test(the_ring_bursts_under_both_laws),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
