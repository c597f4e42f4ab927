/* Non-ordinary bodies torn apart violently, at the step that a scene gets by itself: what is left
   stays within it, energies never rise from nothing, and linear bodies keep their books to
   rounding; and what large families and solids dissipate that a plane splits (theory sec. 11). */
#include "support/nonordinary.h"
#include "support/split.h"
#include "support/torn.h"

static nonordinary_how torn_of(int solid, sdr_elasticity elasticity, double poisson)
{
  return (nonordinary_how){.shape = {.dimension = solid ? SDR_3D : SDR_PLANE_STRESS,
                                     .cells = {solid ? 9 : 30, solid ? 9 : 24, 9},
                                     .ratio = solid ? 2.2 : 3.015,
                                     .law = SDR_LAW_CRITICAL_STRETCH},
                           .elasticity = elasticity,
                           .poisson = poisson,
                           .strain = 0.004};
}

static void tear_one(const nonordinary_how *how, double rate, double spread)
{
  const torn end = tear(nonordinary_create(how).shape, rate, spread, 400);
  assert_true(end.broken > 0.1 && end.taken > 0.05);
  assert_at_most(end.fall, 0.0);
  assert_true(end.limit > 0.9);
  assert_at_most(end.imbalance, how->elasticity == SDR_LINEAR ? 1e-12 : 1e-2);
}

/* Rates from what breaks a third of the bonds to what leaves dust. */
static void violently_torn_bodies_stay_within_their_first_step(void **state)
{
  (void)state;
  static const sdr_elasticity laws[3] = {SDR_LINEAR, SDR_SAINT_VENANT_KIRCHHOFF, SDR_NEO_HOOKEAN};
  static const double rate[3] = {4000.0, 8000.0, 30000.0}, spread[3] = {0.3, 2.0, 0.5};
  for (int solid = 0; solid < 2; ++solid)
    for (int law = 0; law < (solid ? 1 : 3); ++law)
      for (int k = solid; k < 3; ++k)
        for (int nu = 0; nu < 2; ++nu) {
          const nonordinary_how how = torn_of(solid, laws[law], nu ? 0.1 : 0.33);
          tear_one(&how, rate[k], spread[k]);
        }
}

static double separation(const nonordinary_how *how, double tilt)
{
  nonordinary_how longer = *how;
  split plan = split_plan(&longer.shape, tilt);
  nonordinary b = nonordinary_create(&longer);
  const double taken = split_dissipated(&plan, b.shape.points, b.shape.model) / b.toughness[0];
  nonordinary_destroy(&b);
  return taken;
}

static void split_solids_and_large_families_dissipate_the_toughness(void **state)
{
  (void)state;
  for (int k = 0; k < 2; ++k)
    for (int angle = 0; angle < 3; ++angle) {
      const nonordinary_how how = {.shape = {.dimension = k ? SDR_3D : SDR_PLANE_STRESS,
                                             .law = SDR_LAW_CRITICAL_STRETCH,
                                             .ratio = k ? 3.015 : 4.015},
                                   .elasticity = k ? SDR_LINEAR : SDR_SAINT_VENANT_KIRCHHOFF,
                                   .poisson = 0.25,
                                   .strain = 0.001};
      const double taken = separation(&how, angle * 3.14159265358979323846 / 8.0);
      print_message("%d, %g degrees: %.4f\n", k, 22.5 * angle, taken);
      assert_near(taken, 1.0, 0.05);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(violently_torn_bodies_stay_within_their_first_step),
      cmocka_unit_test(split_solids_and_large_families_dissipate_the_toughness),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
