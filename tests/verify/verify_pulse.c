/* A pulse crosses a zone of finer points (problem pulse_plate): with the dual horizon as in a bar,
   without it weakened, with an echo and with momentum from nowhere. */
#include "support/figures.h"

/* Until the crest is in the zone, in longer steps than the problem's. */
static const char *const to_the_zone[] = {"time.end=3.4 ms", "time.step=10 us",
                                          "output.snapshots=0", NULL};
/* Until an echo is at the free end again. */
static const char *const to_the_echo[] = {"time.end=7.5 ms", "time.step=10 us",
                                          "output.snapshots=0", NULL};

static void the_dual_horizon_lets_the_pulse_pass(void **state)
{
  (void)state;
  figures f;
  figures_run(&f, "pulse_plate", NULL, to_the_zone);
  figures_assert_accepted(&f, 3);
  figures_free(&f);
}

/* The section's mean obeys the bar's equation; single points of a wide plate do not quite. */
static void the_papers_corrections_let_it_pass_too(void **state)
{
  (void)state;
  figures f;
  figures_run(&f, "pulse_plate", "paper_weights", to_the_zone);
  figures_assert_accepted(&f, 2);
  figures_free(&f);
}

static void without_it_the_pulse_is_weakened_and_sends_an_echo(void **state)
{
  (void)state;
  figures dual, own;
  figures_run(&dual, "pulse_plate", NULL, to_the_echo);
  figures_run(&own, "pulse_plate", "traditional", to_the_echo);
  assert_true(figures_value(&own, "peak") < 1.8);
  assert_true(figures_value(&own, "echo") > 0.5);
  assert_true(figures_value(&dual, "echo") < 0.1);
  assert_true(figures_value(&own, "momentum") > 0.1);
  figures_free(&dual);
  figures_free(&own);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_dual_horizon_lets_the_pulse_pass),
      cmocka_unit_test(the_papers_corrections_let_it_pass_too),
      cmocka_unit_test(without_it_the_pulse_is_weakened_and_sends_an_echo),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
