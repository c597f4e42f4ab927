/* CVODES and IDA: a prescribed mean of a support's points. */
#include "support/copied_run.h"

static const char *const plate =
    "dimension: plane_stress\n"
    "points: {shape: {box: {from: [0, 0], to: [60 mm, 20 mm]}}, spacing: 4 mm, align: cell}\n"
    "material: {young: 210 GPa, density: %s}\n"
    "supports:\n"
    "  - {name: wall, on: left, displacement: {x: 0, y: 0}, depth: 8 mm}\n"
    "  - {name: pull, on: right, mean: true, depth: 4 mm, %s}\n"
    "time: {integrator: %s}\n";

#define BOTH "displacement: {x: \"50 um * sin(t/(30 us))^2\", y: \"20 um * sin(t/(20 us))^2\"}"

/* Of the points of mean 0: the largest difference from the first one's motion, m. */
static double spread_of(const sdr_system *system)
{
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  double least = INFINITY, most = -INFINITY;
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    if (list[k].mean == 0) {
      least = fmin(least, system->u[0][list[k].point]);
      most = fmax(most, system->u[0][list[k].point]);
    }
  return most - least;
}

static void the_mean_is_kept_and_all_else_moves_as_by_leapfrog(void **state)
{
  (void)state;
  static const char *const ways[] = {
      "cvode, tolerance: 1e-6", "cvode, tolerance: 1e-6, solver: klu",
      "cvode, tolerance: 1e-6, method: adams", "ida, tolerance: 1e-6",
      "ida, tolerance: 1e-6, solver: cholmod"};
  const double end = 40e-6;
  sdr_built tiny, run;
  scene_build(&tiny, plate, "7850 kg/m^3", BOTH, "leapfrog, step: 0.02 us, end: 40 us");
  run_start(&tiny);
  while (tiny.system->step < 2000) run_step(&tiny);
  assert_true(spread_of(tiny.system) > 1e-6); /* the points move against each other */
  for (int w = 0; w < 5; ++w) {
    char how[100];
    snprintf(how, sizeof how, "%s, end: 40 us", ways[w]);
    scene_build(&run, plate, "7850 kg/m^3", BOTH, how);
    assert_at_most(run_to_end(&run, 5e-6), 3e-5);
    const sdr_system *s = run.system;
    assert_near(sdr_system_mean(s, 0, s->u), 50e-6 * pow(sin(end / 30e-6), 2), 1e-15);
    assert_near(sdr_system_mean(s, 1, s->u), 20e-6 * pow(sin(end / 20e-6), 2), 1e-15);
    assert_near(sdr_system_mean(s, 1, s->v), sin(end / 10e-6), 1e-6);
    assert_at_most(apart(s, tiny.system), 3e-4);
    assert_near(s->external_work, tiny.system->external_work, 1e-4 * s->external_work);
    const double pull = sdr_system_reaction(tiny.system, 1, 0);
    assert_near(sdr_system_reaction(s, 1, 0), pull, 1e-3 * fabs(pull));
    sdr_built_destroy(&run);
  }
  sdr_built_destroy(&tiny);
}

/* A velocity from the start and let go: momentum is what the supports gave. */
static void a_mean_velocity_that_lets_go_is_booked(void **state)
{
  (void)state;
  static const char *const ways[] = {"cvode", "ida"};
  for (int w = 0; w < 2; ++w) {
    char how[100];
    sdr_built run;
    sdr_balance end;
    snprintf(how, sizeof how, "%s, tolerance: 1e-6, end: 30 us", ways[w]);
    scene_build(&run, plate, "7850 kg/m^3", "velocity: {x: 2 m/s}, from: 5 us, until: 20 us", how);
    assert_at_most(run_to_end(&run, 6e-6), 3e-5);
    sdr_system_balance(run.system, &end);
    assert_near(end.momentum[0], run.system->impulse[0], 1e-5 * end.momentum_scale);
    assert_near(end.angular[2], run.system->angular_impulse[2], 1e-5 * end.angular_scale);
    assert_true(end.kinetic > 0.0 && sdr_system_reaction(run.system, 1, 0) == 0.0);
    sdr_built_destroy(&run);
  }
}

/* Slowly, without mass: the linear static answer, and the same force. */
static void a_body_without_mass_follows_its_mean_in_equilibrium(void **state)
{
  (void)state;
  sdr_built slow, still;
  const char *const pull = "displacement: {x: \"0.1 um * t/(1 s)\"}";
  scene_build(&still, plate, "7850 kg/m^3", pull, "static, end: 1 s");
  scene_build(&slow, plate, "0 kg/m^3", pull,
              "ida, tolerance: 1e-6, viscosity: 1e-6 s, end: 1 s, solver: cholmod");
  run_start(&still);
  run_step(&still);
  assert_at_most(run_to_end(&slow, 0.1), 1e-4);
  assert_at_most(apart(slow.system, still.system), 1e-4);
  const double force = sdr_system_reaction(still.system, 1, 0);
  assert_near(sdr_system_reaction(slow.system, 1, 0), force, 1e-4 * fabs(force));
  assert_near(slow.system->external_work, still.system->external_work,
              1e-3 * still.system->external_work);
  sdr_built_destroy(&slow);
  sdr_built_destroy(&still);
}

static void a_mean_of_points_without_mass_needs_viscosity(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, plate, "0 kg/m^3", "displacement: {x: \"0.1 um * t/(1 s)\"}", "ida, end: 1 s");
  assert_int_equal(run.integrator->start(run.system, run.step), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "a support prescribes the mean over points of which that at x = 58 mm, y = "
                      "2 mm has no mass; give all of them one, or none and time.viscosity");
  sdr_built_destroy(&run);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_mean_is_kept_and_all_else_moves_as_by_leapfrog),
      cmocka_unit_test(a_mean_velocity_that_lets_go_is_booked),
      cmocka_unit_test(a_body_without_mass_follows_its_mean_in_equilibrium),
      cmocka_unit_test(a_mean_of_points_without_mass_needs_viscosity)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
