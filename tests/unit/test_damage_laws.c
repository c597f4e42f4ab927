/* damage: the formulas of each law, one derived from the other. */
#include "damage/bond_law.h"
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

/* ---- all laws ----------------------------------------------------------------------------------
 */

/* Constants with s_c = 0.01 and, for cohesive, s_e = 0.002: a = 25, x_f = 48.5. */
static double constant_q(int law)
{
  return law == SDR_LAW_COHESIVE ? 0.002 : 1e-4;
}
static const double constant_r = 0.5 / (48.5 - 1.25);

static double whole_energy(int law, double s, double before)
{
  const sdr_bond_answer at = sdr_bond_law(law, s, before, constant_q(law), constant_r);
  return at.stored + at.dissipated;
}

/* Difference of fourth order of the energy (`of_force` 0) or the force. */
static double slope_of(int law, double s, double before, int of_force)
{
  static const double factor[4] = {1.0, -8.0, 8.0, -1.0};
  const double h = 2e-6;
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) {
    const double at = s + h * (k < 2 ? k - 2 : k - 1);
    const double value = of_force ? sdr_bond_law(law, at, before, constant_q(law), constant_r).force
                                  : whole_energy(law, at, before);
    sum += factor[k] * value / (12.0 * h);
  }
  return sum;
}

/* Stretches away from the kinks of all laws, at 0, s_c/sqrt 2, s_e, 1.25 s_e and 48.5 s_e. */
static const double stretches[] = {-0.03,  -0.001, 0.0011, 0.0019, 0.0021, 0.0024,
                                   0.0026, 0.006,  0.0072, 0.02,   0.09,   0.0975};
enum { STRETCHES = sizeof stretches / sizeof *stretches };

/* Force and tangent are derivatives of stored and dissipated energy, on loading, unloading and in
   compression. */
static void each_law_derives_from_its_energy(void **state)
{
  (void)state;
  static const double histories[] = {0.0, 0.0015, 0.0023, 0.0125, 0.2};
  for (int law = 0; law < SDR_LAW_COUNT; ++law)
    for (int b = 0; b < 5; ++b)
      for (int k = 0; k < STRETCHES; ++k) {
        const double s = stretches[k], q = constant_q(law);
        const sdr_bond_answer at = sdr_bond_law(law, s, histories[b], q, constant_r);
        assert_close(at.force, slope_of(law, s, histories[b], 0), 1e-8 * 0.01);
        assert_close(at.slope, slope_of(law, s, histories[b], 1), 1e-7);
        assert_true(at.damage >= 0.0 && at.damage <= 1.0);
        if (s < 0.0) assert_close(at.force, s, 0.0);
      }
}

/* The history only grows, so must damage and what is dissipated; what is left is (1-d)^2. */
static void damage_and_dissipation_never_shrink(void **state)
{
  (void)state;
  for (int law = 0; law < SDR_LAW_COUNT; ++law) {
    sdr_softening last = sdr_softening_of(law, 0.0, constant_q(law), constant_r);
    assert_close(last.left, 1.0, 0.0);
    assert_close(last.dissipated, 0.0, 0.0);
    for (int k = 1; k <= 1000; ++k) {
      const sdr_softening now = sdr_softening_of(law, 1e-4 * k, constant_q(law), constant_r);
      assert_true(now.damage >= last.damage && now.dissipated >= last.dissipated);
      assert_close(now.left, (1.0 - now.damage) * (1.0 - now.damage), 1e-14);
      last = now;
    }
    /* w_c over C |xi| is 5e-5; at 10 s_c the laws have taken so much of it */
    const double most = law == SDR_LAW_VARIATIONAL ? pow(100.0 / 101.0, 2.0)
                        : law == SDR_LAW_AT1       ? 1.0 - 1.0 / 200.0
                        : law == SDR_LAW_COHESIVE  ? 1.0
                                                   : 0.0;
    assert_close(last.dissipated, 5e-5 * most, 1e-16);
  }
}

static void a_lost_bond_answers_nothing(void **state)
{
  (void)state;
  const sdr_bond_answer lost = sdr_bond_lost();
  assert_close(lost.force, 0.0, 0.0);
  assert_close(lost.slope, 0.0, 0.0);
  assert_close(lost.stored + lost.dissipated, 0.0, 0.0);
  assert_close(lost.damage, 1.0, 0.0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(damage_minimises_the_energy),
      cmocka_unit_test(tangent_is_the_slope_of_the_force_on_loading),
      cmocka_unit_test(the_tangent_turns_negative_past_a_quarter_of_damage),
      cmocka_unit_test(critical_stretch_breaks_above_s0_only_in_tension),
      cmocka_unit_test(damage_of_marked_pairs_is_what_the_mark_says),
      cmocka_unit_test(each_law_derives_from_its_energy),
      cmocka_unit_test(damage_and_dissipation_never_shrink),
      cmocka_unit_test(a_lost_bond_answers_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
