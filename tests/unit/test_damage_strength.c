/* damage: strength of homogeneous bodies, and the constants of the law cohesive (theory sec. 4). */
#include "damage/bond_law.h"
#include "damage/calibration.h"
#include "damage/strength.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <string.h>

static void assert_close(double value, double expected, double tolerance)
{
  if (!(fabs(value - expected) <= tolerance))
    fail_msg("%.15g, expected %.15g +- %g", value, expected, tolerance);
}

/* The family of a lattice with spacing 1 mm. */
static sdr_families *lattice_family(int components, sdr_points **points)
{
  const double h = 1e-3;
  assert_int_equal(sdr_points_create(2, components, 1, points), SDR_OK);
  (*points)->lattice_spacing = h;
  for (int32_t i = 0; i < 2; ++i) {
    (*points)->x[0][i] = h * i;
    (*points)->cell[3 * i] = i;
    (*points)->spacing[i] = h;
    (*points)->volume[i] = pow(h, components);
    (*points)->horizon[i] = 3.015 * h;
  }
  assert_int_equal(sdr_points_arrange(*points), SDR_OK);
  sdr_families *families;
  assert_int_equal(sdr_families_create(*points, &(sdr_families_how){0}, &families), SDR_OK);
  return families;
}

/* Strength over E s along an angle, and the strain there over s; E = 1. */
static double strength_at(const sdr_families *families, sdr_dimension dimension, int law,
                          double degrees, double *strain)
{
  const double s = 1e-4, angle = degrees * 3.14159265358979323846 / 180.0;
  const sdr_strength_law how = {
      law, sdr_micromodulus(dimension, SDR_CALIBRATE_FAMILY, families->family, 1.0),
      law == SDR_LAW_COHESIVE ? s : s * s, 0.02};
  const double n[3] = {cos(angle), sin(angle), 0.0};
  double stress;
  assert_int_equal(sdr_strength_along(families, families->family, &how, n, &stress, strain),
                   SDR_OK);
  *strain /= s;
  return stress / s;
}

/* All bonds of a bar stretch alike, so it is as strong as one bond: peaks of 9/(16 sqrt 3),
   1/sqrt 2 and 1. */
static void a_bar_is_as_strong_as_its_bonds(void **state)
{
  (void)state;
  sdr_points *points;
  sdr_families *families = lattice_family(1, &points);
  double strain;
  assert_close(strength_at(families, SDR_1D, SDR_LAW_VARIATIONAL, 0.0, &strain),
               9.0 / 16.0 / sqrt(3.0), 1e-8);
  assert_close(strain, 1.0 / sqrt(3.0), 1e-3);
  assert_close(strength_at(families, SDR_1D, SDR_LAW_AT1, 0.0, &strain), sqrt(0.5), 1e-4);
  assert_close(strength_at(families, SDR_1D, SDR_LAW_COHESIVE, 0.0, &strain), 1.0, 1e-4);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

/* Theory sec. 4: 0.403 E s_c at a strain of 0.749 s_c in an isotropic body. Families of irregular
   points count as such. */
static void an_isotropic_plane_body_has_the_strength_of_theory(void **state)
{
  (void)state;
  sdr_points *points;
  sdr_families *families = lattice_family(2, &points);
  double strain;
  families->family->source = SDR_MOMENTS_MEAN;
  for (int degrees = 0; degrees <= 90; degrees += 15) {
    assert_close(strength_at(families, SDR_PLANE_STRESS, SDR_LAW_VARIATIONAL, degrees, &strain),
                 0.403, 5e-4);
    assert_close(strain, 0.749, 2e-3);
  }
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

/* A lattice has the strength of its directions: turned by 90 degrees it is the same. At 0 and 45
   degrees the bonds along the pull yield first, all else being elastic: at a strain of s_e. */
static void a_lattice_has_its_strength_in_each_direction(void **state)
{
  (void)state;
  sdr_points *points;
  sdr_families *families = lattice_family(2, &points);
  double strain, other;
  for (int degrees = 0; degrees <= 45; degrees += 15)
    assert_close(strength_at(families, SDR_PLANE_STRESS, SDR_LAW_COHESIVE, degrees, &strain),
                 strength_at(families, SDR_PLANE_STRESS, SDR_LAW_COHESIVE, 90.0 - degrees, &other),
                 1e-4);
  const sdr_family *family = families->family;
  const double c = sdr_micromodulus(SDR_PLANE_STRESS, SDR_CALIBRATE_FAMILY, family, 1.0);
  const double c11 = c * family->quartic[0], c12 = c * family->quartic[2];
  assert_close(strength_at(families, SDR_PLANE_STRESS, SDR_LAW_COHESIVE, 0.0, &strain),
               c11 - c12 * c12 / c11, 1e-4); /* stress of unit strain, free across: 1.0226 */
  assert_close(strain, 1.0, 1e-4);
  sdr_strength_range range;
  const sdr_strength_law law = {SDR_LAW_COHESIVE, c, 1e-4, 0.02};
  assert_int_equal(sdr_strength_over_directions(families, family, &law, &range), SDR_OK);
  assert_true(range.least < range.mean && range.mean < range.most);
  assert_close(range.least, 0.977e-4, 1e-7);
  assert_close(range.most, 1.083e-4, 1e-7);
  double beta;
  assert_int_equal(sdr_cohesive_beta(families, family, c, 1.0, &beta), SDR_OK);
  assert_close(beta, 1.022, 1e-3);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

/* A bond torn takes the whole of C |xi| s_c^2/2, and yields where the body reaches its strength. */
static void cohesive_constants_keep_strength_and_toughness(void **state)
{
  (void)state;
  double s_e, decline;
  assert_int_equal(sdr_cohesive_constants(0.03, 25e9, 4e-8, 2.5e6, 1.25, &s_e, &decline), SDR_OK);
  assert_close(s_e, 8e-5, 1e-20);
  const sdr_softening torn = sdr_softening_cohesive(1.0, s_e, decline);
  assert_close(torn.left, 0.0, 0.0);
  assert_close(torn.dissipated, 0.5 * 4e-8, 1e-20);
}

/* a = 1.375 there: nothing of the second line is left. */
static void a_horizon_too_large_for_both_is_refused_with_the_limit(void **state)
{
  (void)state;
  double s_e = -1.0, decline = -1.0;
  const double squared = 1.374 * 8e-5 * 8e-5;
  assert_int_equal(sdr_cohesive_constants(0.03, 25e9, squared, 2.5e6, 1.25, &s_e, &decline),
                   SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "the horizon 30 mm is too large for the law cohesive with this strength and "
                      "toughness; at most 29.98 mm meets both");
  assert_close(s_e, -1.0, 0.0);
  assert_int_equal(
      sdr_cohesive_constants(0.03, 25e9, squared * 1.376 / 1.374, 2.5e6, 1.25, &s_e, &decline),
      SDR_OK);
  assert_true(isfinite(decline) && decline > 0.0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_bar_is_as_strong_as_its_bonds),
      cmocka_unit_test(an_isotropic_plane_body_has_the_strength_of_theory),
      cmocka_unit_test(a_lattice_has_its_strength_in_each_direction),
      cmocka_unit_test(cohesive_constants_keep_strength_and_toughness),
      cmocka_unit_test(a_horizon_too_large_for_both_is_refused_with_the_limit),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
