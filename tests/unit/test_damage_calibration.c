/* damage: constants of a bond from engineering ones (theory sec. 3). */
#include "damage/calibration.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static void assert_close(double value, double expected, double tolerance)
{
  if (!(fabs(value - expected) <= tolerance))
    fail_msg("%.15g, expected %.15g +- %g", value, expected, tolerance);
}

/* The family of a lattice with spacing 1 mm, thickness or area 2. */
static sdr_families *lattice_family(int components, double ratio, sdr_points **points)
{
  const double h = 1e-3;
  assert_int_equal(sdr_points_create(2, components, 1, points), SDR_OK);
  (*points)->lattice_spacing = h;
  for (int32_t i = 0; i < 2; ++i) {
    (*points)->x[0][i] = h * i;
    (*points)->cell[3 * i] = i;
    (*points)->spacing[i] = h;
    (*points)->volume[i] = pow(h, components) * (components < 3 ? 2.0 : 1.0);
    (*points)->horizon[i] = ratio * h;
  }
  assert_int_equal(sdr_points_arrange(*points), SDR_OK);
  sdr_families *families;
  assert_int_equal(sdr_families_create(*points, &(sdr_families_how){0}, &families), SDR_OK);
  return families;
}

static const sdr_dimension dimensions[] = {SDR_1D, SDR_PLANE_STRESS, SDR_PLANE_STRAIN, SDR_3D};

static void poisson_ratios_are_the_laws_own(void **state)
{
  (void)state;
  assert_close(sdr_bond_poisson(SDR_1D), 0.0, 0.0);
  assert_close(sdr_bond_poisson(SDR_PLANE_STRESS), 1.0 / 3.0, 1e-16);
  assert_close(sdr_bond_poisson(SDR_PLANE_STRAIN), 0.25, 0.0);
  assert_close(sdr_bond_poisson(SDR_3D), 0.25, 0.0);
}

/* The table of theory sec. 3 with nu put in, for E = 1, thickness or area 2, Gc = 1. */
static void printed_constants_are_those_of_the_table(void **state)
{
  (void)state;
  for (int k = 0; k < 4; ++k) {
    sdr_points *points;
    sdr_families *families = lattice_family(sdr_components(dimensions[k]), 3.0, &points);
    const double d = 3e-3;
    const double micromodulus[4] = {1.0 / (2.0 * d * d), 4.5 / (pi * 2.0 * d * d * d),
                                    4.8 / (pi * 2.0 * d * d * d), 6.0 / (pi * d * d * d * d)};
    const double s02[4] = {3.0 / d, 4.0 * pi / (9.0 * d), 5.0 * pi / (12.0 * d), 5.0 / (6.0 * d)};
    const double c = sdr_micromodulus(dimensions[k], SDR_CALIBRATE_PRINTED, families->family, 1.0);
    const double s = sdr_critical_stretch_squared(dimensions[k], SDR_CALIBRATE_PRINTED,
                                                  families->family, 1.0, 1.0);
    assert_close(c, micromodulus[k], 1e-14 * c);
    assert_close(s, s02[k], 1e-14 * s);
    sdr_families_destroy(&families);
    sdr_points_destroy(&points);
  }
}

/* With a horizon of many spacings family sums become the printed integrals; what is left is of the
   order of the lattice's count of points in a ball. */
static void family_sums_tend_to_the_printed_constants(void **state)
{
  (void)state;
  for (int k = 0; k < 4; ++k) {
    sdr_points *points;
    const double ratio = k == 3 ? 25.0 : 60.0;
    sdr_families *families = lattice_family(sdr_components(dimensions[k]), ratio, &points);
    const sdr_family *family = families->family;
    const double c = sdr_micromodulus(dimensions[k], SDR_CALIBRATE_FAMILY, family, 1.0);
    const double printed = sdr_micromodulus(dimensions[k], SDR_CALIBRATE_PRINTED, family, 1.0);
    const double s =
        sdr_critical_stretch_squared(dimensions[k], SDR_CALIBRATE_FAMILY, family, 1.0, 1.0);
    const double s_printed =
        sdr_critical_stretch_squared(dimensions[k], SDR_CALIBRATE_PRINTED, family, 1.0, 1.0);
    assert_close(c / printed, 1.0, k == 0 ? 0.02 : 0.005);
    assert_close(s / s_printed, 1.0, k == 0 ? 0.02 : 0.005);
    sdr_families_destroy(&families);
    sdr_points_destroy(&points);
  }
}

static void stiffness_and_toughness_scale_as_they_must(void **state)
{
  (void)state;
  sdr_points *points;
  sdr_families *families = lattice_family(2, 3.015, &points);
  const sdr_family *f = families->family;
  for (int kind = SDR_CALIBRATE_FAMILY; kind <= SDR_CALIBRATE_PRINTED; ++kind) {
    const sdr_calibration_kind how = (sdr_calibration_kind)kind;
    const double c = sdr_micromodulus(SDR_PLANE_STRESS, how, f, 7.0);
    assert_close(sdr_micromodulus(SDR_PLANE_STRESS, how, f, 21.0), 3.0 * c, 1e-14 * c);
    const double s = sdr_critical_stretch_squared(SDR_PLANE_STRESS, how, f, 7.0, 2.0);
    assert_close(sdr_critical_stretch_squared(SDR_PLANE_STRESS, how, f, 14.0, 6.0), 1.5 * s,
                 1e-14 * s);
  }
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

/* A bond along x of length k crosses a plane x = const in k of its places: sum over the rows. */
static void separation_energy_of_a_chain_is_counted_by_hand(void **state)
{
  (void)state;
  sdr_points *points;
  sdr_families *families = lattice_family(1, 3.0, &points);
  const sdr_family *f = families->family;
  const double h = 1e-3, v = f->volume, normal[3] = {1.0, 0.0, 0.0};
  double by_hand = 0.0, energy;
  for (int k = 1; k <= 3; ++k) /* k pairs of length k h, two directed bonds each, per area 2 */
    by_hand += k * 2.0 * (0.5 * 5.0 * k * h * 0.01) * v * v / 2.0;
  assert_int_equal(sdr_separation_energy(families, f, 5.0, 0.01, normal, &energy), SDR_OK);
  assert_close(energy, by_hand, 1e-14 * by_hand);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(poisson_ratios_are_the_laws_own),
      cmocka_unit_test(printed_constants_are_those_of_the_table),
      cmocka_unit_test(family_sums_tend_to_the_printed_constants),
      cmocka_unit_test(stiffness_and_toughness_scale_as_they_must),
      cmocka_unit_test(separation_energy_of_a_chain_is_counted_by_hand),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
