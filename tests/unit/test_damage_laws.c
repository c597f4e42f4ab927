/* damage: the formulas of each law, one derived from the other. */
#include "damage/laws.h"
#include "support/cmocka_all.h"

#include <math.h>

/* e(s, d) = (1-d)^2 w + w_c d^2 with w = s^2/2, w_c = q/2. */
static double energy(double s, double d, double q)
{
  return 0.5 * ((1.0 - d) * (1.0 - d) * s * s + q * d * d);
}

static void assert_close(double value, double expected, double tolerance)
{
  if (!(fabs(value - expected) <= tolerance))
    fail_msg("%.15g, expected %.15g +- %g", value, expected, tolerance);
}

static void damage_minimises_the_energy(void **state)
{
  (void)state;
  const double q = 1e-4;
  for (int k = 1; k <= 40; ++k) {
    const double s = 1e-3 * k, d = 1.0 - sdr_variational_intact(s * s, q);
    const double least = energy(s, d, q);
    for (int step = -4; step <= 4; ++step)
      if (step != 0) assert_true(energy(s, d + 1e-4 * step, q) > least);
    /* w_c w/(w_c + w) */
    assert_close(least, 0.5 * q * s * s / (q + s * s), 1e-15 * q);
  }
}

static void tangent_is_the_slope_of_the_force_on_loading(void **state)
{
  (void)state;
  const double q = 1e-4, h = 1e-5;
  for (int k = 1; k <= 40; ++k) {
    const double s = 1e-3 * k;
    double f[4];
    for (int p = 0; p < 4; ++p) {
      const double at = s + h * (p < 2 ? p - 2 : p - 1),
                   intact = sdr_variational_intact(at * at, q);
      f[p] = intact * intact * at;
    }
    const double slope = (f[0] - 8.0 * f[1] + 8.0 * f[2] - f[3]) / (12.0 * h);
    assert_close(sdr_variational_tangent(s * s, q), slope, 1e-8);
  }
}

static void the_tangent_turns_negative_past_a_quarter_of_damage(void **state)
{
  (void)state;
  const double q = 1e-4; /* d = 1/4 at k^2 = q/3 */
  assert_true(sdr_variational_tangent(q / 3.0 * 0.999, q) > 0.0);
  assert_true(sdr_variational_tangent(q / 3.0 * 1.001, q) < 0.0);
  assert_close(sdr_variational_tangent(0.0, q), 1.0, 0.0);
}

static void critical_stretch_breaks_above_s0_only_in_tension(void **state)
{
  (void)state;
  assert_false(sdr_critical_breaks(0.00999999, 1e-4));
  assert_true(sdr_critical_breaks(0.01000001, 1e-4));
  assert_false(sdr_critical_breaks(-0.5, 1e-4));
  assert_false(sdr_critical_breaks(0.0, 0.0));
}

static void damage_of_marked_pairs_is_what_the_mark_says(void **state)
{
  (void)state;
  assert_close(sdr_variational_damage(SDR_STRETCH_CUT, 1e-4), 1.0, 0.0);
  assert_close(sdr_variational_damage(SDR_STRETCH_PROTECTED, 1e-4), 0.0, 0.0);
  assert_close(sdr_variational_damage(0.0f, 1e-4), 0.0, 0.0);
  assert_close(sdr_variational_damage(0.01f, 1e-4), 0.5, 1e-7);
  assert_close(sdr_flag_damage(SDR_LOST_I | SDR_FRESH_I, SDR_LOST_I), 1.0, 0.0);
  assert_close(sdr_flag_damage(SDR_LOST_I | SDR_FRESH_I, SDR_LOST_J), 0.0, 0.0);
  assert_close(sdr_flag_damage(SDR_PROTECTED, SDR_LOST_J), 0.0, 0.0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(damage_minimises_the_energy),
      cmocka_unit_test(tangent_is_the_slope_of_the_force_on_loading),
      cmocka_unit_test(the_tangent_turns_negative_past_a_quarter_of_damage),
      cmocka_unit_test(critical_stretch_breaks_above_s0_only_in_tension),
      cmocka_unit_test(damage_of_marked_pairs_is_what_the_mark_says),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
