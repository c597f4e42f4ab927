/* Split non-ordinary bodies dissipate their toughness, whatever the direction of the cut (theory
   sec. 11). */
#include "support/nonordinary.h"
#include "support/split.h"
#include "support/torn.h"

#include <math.h>

static double separation(const nonordinary_how *how, double tilt)
{
  nonordinary_how longer = *how;
  split plan = split_plan(&longer.shape, tilt);
  nonordinary b = nonordinary_create(&longer);
  const double taken = split_dissipated(&plan, b.shape.points, b.shape.model) / b.toughness[0];
  nonordinary_destroy(&b);
  return taken;
}

static void a_split_body_dissipates_the_toughness_at_0_and_22_5_and_45_degrees(void **state)
{
  (void)state;
  for (int k = 0; k < 2; ++k)
    for (int angle = 0; angle < 3; ++angle) {
      const nonordinary_how how = {
          .shape = {.dimension = k ? SDR_3D : SDR_PLANE_STRESS, .law = SDR_LAW_VARIATIONAL}};
      const double taken = separation(&how, angle * 3.14159265358979323846 / 8.0);
      print_message("%d-D, %g degrees: %.4f\n", 2 + k, 22.5 * angle, taken);
      assert_near(taken, 1.0, 0.05);
    }
}

/* s0 is found by splitting full families with all that breaking bonds bring about; small strains
   stand for all laws. Bonds break here up to 1.5 % late. */
static void critical_stretch_takes_the_toughness_in_any_direction(void **state)
{
  (void)state;
  static const double poisson[5] = {0.1, 0.4, 0.25, 0.25, 0.25};
  static const sdr_elasticity laws[5] = {SDR_LINEAR, SDR_LINEAR, SDR_NEO_HOOKEAN, SDR_LINEAR,
                                         SDR_SAINT_VENANT_KIRCHHOFF};
  for (int k = 0; k < 5; ++k)
    for (int angle = 0; angle < 3; ++angle) {
      const nonordinary_how how = {.shape = {.dimension = k == 3   ? SDR_3D
                                                          : k == 2 ? SDR_PLANE_STRAIN
                                                                   : SDR_PLANE_STRESS,
                                             .law = SDR_LAW_CRITICAL_STRETCH,
                                             .ratio = k == 4 ? 4.015 : 3.015,
                                             .force_loose = k == 1},
                                   .elasticity = laws[k],
                                   .poisson = poisson[k],
                                   .strain = 0.001};
      const double taken = separation(&how, angle * 3.14159265358979323846 / 8.0);
      print_message("%d, %g degrees: %.4f\n", k, 22.5 * angle, taken);
      assert_near(taken, 1.0, 0.05);
    }
}

static void jittered_points_take_the_toughness_too(void **state)
{
  (void)state;
  const nonordinary_how how = {
      .shape = {.dimension = SDR_PLANE_STRESS, .law = SDR_LAW_CRITICAL_STRETCH, .jitter = 0.3},
      .strain = 0.001};
  const double taken = separation(&how, 0.0);
  print_message("jittered: %.4f\n", taken);
  assert_near(taken, 1.0, 0.05);
}

/* ---- torn to pieces ---------------------------------------------------------------------------
 */

static nonordinary_how torn_of(int k)
{
  static const sdr_elasticity laws[4] = {SDR_LINEAR, SDR_SAINT_VENANT_KIRCHHOFF, SDR_LINEAR,
                                         SDR_NEO_HOOKEAN};
  return (nonordinary_how){.shape = {.dimension = k == 2 ? SDR_3D : SDR_PLANE_STRESS,
                                     .cells = {k == 2 ? 7 : 24, k == 2 ? 8 : 18, 7},
                                     .ratio = k == 2 ? 2.2 : 3.015,
                                     .law = SDR_LAW_CRITICAL_STRETCH,
                                     .force_loose = k == 1},
                           .elasticity = laws[k],
                           .strain = 0.004};
}

/* What is left of a family may store more than the whole did: then it keeps its bonds. */
static void a_lost_bond_never_raises_the_energy_of_a_point(void **state)
{
  (void)state;
  for (int k = 0; k < 4; ++k) {
    const nonordinary_how how = torn_of(k);
    lose_at_random(nonordinary_create(&how).shape, 0.003 * body_spacing);
  }
}

/* The moduli of a torn family fade where its shape tensor does: the stable step of what is left
   stays above the step that the whole body takes, 0.9 of its limit. */
static void a_body_torn_to_pieces_at_the_default_step_keeps_its_books(void **state)
{
  (void)state;
  for (int k = 0; k < 4; ++k) {
    const nonordinary_how how = torn_of(k);
    const torn end = tear(nonordinary_create(&how).shape, k == 2 ? 20000.0 : 5000.0, 0.1, 150);
    assert_true(end.broken > 0.1 && end.taken > 0.2);
    assert_at_most(end.fall, 0.0);
    assert_at_most(end.imbalance, 1e-3);
    assert_true(end.limit > 0.9);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_split_body_dissipates_the_toughness_at_0_and_22_5_and_45_degrees),
      cmocka_unit_test(critical_stretch_takes_the_toughness_in_any_direction),
      cmocka_unit_test(jittered_points_take_the_toughness_too),
      cmocka_unit_test(a_lost_bond_never_raises_the_energy_of_a_point),
      cmocka_unit_test(a_body_torn_to_pieces_at_the_default_step_keeps_its_books),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
