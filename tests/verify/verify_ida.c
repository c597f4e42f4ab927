/* IDA: the same motion as CVODES, supports as algebraic rows, bodies without mass. */
#include "support/copied_run.h"

static const char *const ring =
    "dimension: plane_stress\n"
    "points: {shape: {annulus: {inner: 81 mm, outer: 149 mm}}, spacing: 10 mm}\n"
    "material: {young: 210 GPa, density: 7850 kg/m^3, toughness: 2e4 J/m^2}\n"
    "damage: {law: variational, ell: 2 horizon}\n"
    "loads: [{pressure: {on: inner, value: 400 MPa * exp(-t/(100 us)), until: 30.3 us}}]\n"
    "time: {integrator: %s, end: 40 us}\n";

static void a_breaking_ring_moves_as_by_cvode(void **state)
{
  (void)state;
  sdr_built ida, cvode;
  scene_build(&ida, ring, "ida, tolerance: 1e-5");
  scene_build(&cvode, ring, "cvode, tolerance: 1e-6");
  assert_at_most(run_to_end(&ida, 5e-6), 1e-3);
  assert_at_most(run_to_end(&cvode, 5e-6), 1e-3);
  assert_at_most(apart(ida.system, cvode.system), 1e-3);
  assert_at_most(ida.system->method.residual, 1e-3);
  sdr_built_destroy(&ida);
  sdr_built_destroy(&cvode);
}

static void a_resumed_run_has_the_bits_of_one_that_went_on(void **state)
{
  (void)state;
  char scene[600];
  snprintf(scene, sizeof scene, ring, "ida, tolerance: 1e-4, solver: cholmod");
  assert_resumes(scene, 22e-6, 32e-6);
}

/* ---- without mass ---------------------------------------------------------------------------- */

static const char *const strip =
    "dimension: 1d\n"
    "points: {shape: {interval: {from: 0 m, to: 10 m}}, spacing: 1 m}\n"
    "horizon: 1.01 spacing\n"
    "material: {young: 1 Pa, density: 0 kg/m^3, toughness: %s}\n"
    "damage: {law: %s}\n"
    "supports:\n"
    "  - {on: left, displacement: {x: 0}}\n"
    "  - {on: right, displacement: {x: \"1 m * t/(1 s)\"}}\n"
    "time: {integrator: ida, end: 1 s, tolerance: 1e-7, viscosity: %s, solver: %s}\n";

/* Two points are held at each end, within a spacing of it; the eight bonds between share the way.
   Force 1 N/m of half a bond each way, energy 8 times 1/2 0.125^2. */
static void a_strip_without_mass_is_in_equilibrium_all_the_time(void **state)
{
  (void)state;
  static const char *const solvers[] = {"cholmod", "pcg"};
  static const char *const viscosities[] = {"0 s", "1e-6 s"};
  for (int k = 0; k < 2; ++k) {
    sdr_built run;
    sdr_balance end;
    scene_build(&run, strip, "1 J/m^2", "none", viscosities[k], solvers[k]);
    assert_at_most(run_to_end(&run, 0.1), 1e-5);
    sdr_system_balance(run.system, &end);
    for (int32_t i = 2; i < 10; ++i)
      assert_near(run.system->u[0][i] - run.system->u[0][i - 1], 0.125, 1e-5);
    assert_near(end.model.stored, 0.0625, 1e-6);
    assert_near(end.model.stored + run.system->viscous, run.system->external_work, 1e-7);
    assert_near(end.kinetic, 0.0, 0.0);
    sdr_built_destroy(&run);
  }
}

/* A weak place tears; what it gives back at once goes into the viscosity of the rest. */
static void a_strip_that_snaps_is_followed_with_viscosity(void **state)
{
  (void)state;
  sdr_built run;
  sdr_balance end;
  scene_build(&run, strip, "\"1e-3 J/m^2\"", "variational", "1e-4 s", "auto");
  assert_at_most(run_to_end(&run, 0.05), 5e-3);
  sdr_system_balance(run.system, &end);
  assert_true(end.model.max_damage > 0.5);
  assert_true(run.system->viscous >= 0.0);
  sdr_built_destroy(&run);
}

static void a_density_of_zero_is_for_ida_and_statics_only(void **state)
{
  (void)state;
  sdr_built run;
  assert_int_equal(scene_try(&run, "dimension: 1d\n"
                                   "points: {shape: {interval: {from: 0 m, to: 9 m}}, "
                                   "spacing: 1 m}\n"
                                   "material: {young: 1 Pa, density: 0 kg/m^3}\n"
                                   "time: {integrator: cvode, end: 1 s}\n"),
                   SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), "only the integrators ida and static can move"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_breaking_ring_moves_as_by_cvode),
      cmocka_unit_test(a_resumed_run_has_the_bits_of_one_that_went_on),
      cmocka_unit_test(a_strip_without_mass_is_in_equilibrium_all_the_time),
      cmocka_unit_test(a_strip_that_snaps_is_followed_with_viscosity),
      cmocka_unit_test(a_density_of_zero_is_for_ida_and_statics_only)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
