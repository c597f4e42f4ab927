/* CVODES: converges with its tolerance, agrees with leapfrog through fracture, keeps its books,
   lands on events, and takes damage in with accepted steps only. */
#include "support/copied_run.h"

/* ---- tolerance ------------------------------------------------------------------------------- */

/* Two masses of 1 kg on a spring of 1 N/m: omega^2 = 2. Largest error over 10 s, of 0.07 m. */
static double error_of_two_points(const char *method, double tolerance)
{
  const double omega = sqrt(2.0);
  double worst = 0.0;
  sdr_built run;
  scene_build(&run,
              "dimension: 1d\n"
              "points: {shape: {interval: {from: 0 m, to: 1 m}}, spacing: 1 m}\n"
              "horizon: 1.01 spacing\n"
              "material: {young: 1 Pa, density: 1 kg/m^3}\n"
              "initial: {velocity: [\"1 m/s * (x < 0.5 m ? 0.1 : -0.1)\"]}\n"
              "time: {integrator: cvode, method: %s, tolerance: %g, end: 10 s}\n",
              method, tolerance);
  run_start(&run);
  while (run.system->time < 10.0) {
    run_step(&run);
    const double exact = 0.1 / omega * sin(omega * run.system->time);
    worst = fmax(worst, fabs(run.system->u[0][0] - exact));
  }
  sdr_built_destroy(&run);
  return worst;
}

/* The error of a run is up to some hundred times that of its steps. */
static void the_error_follows_the_tolerance(void **state)
{
  (void)state;
  static const char *const methods[] = {"bdf, order: 5", "adams"};
  for (int m = 0; m < 2; ++m)
    for (int k = 4; k <= 8; k += 2) {
      const double tolerance = pow(10.0, -k);
      const double error = error_of_two_points(methods[m], tolerance) / 0.07;
      if (!(error > 0.05 * tolerance && error < 300.0 * tolerance))
        fail_msg("%s at %g: error %g", methods[m], tolerance, error);
    }
}

/* ---- a ring that breaks ---------------------------------------------------------------------- */

static const char *const ring =
    "dimension: plane_stress\n"
    "points: {shape: {annulus: {inner: 81 mm, outer: 149 mm}}, spacing: 10 mm}\n"
    "material: {young: 210 GPa, density: 7850 kg/m^3, toughness: 2e4 J/m^2}\n"
    "damage: {law: variational, ell: 2 horizon}\n"
    "loads: [{pressure: {on: inner, value: 400 MPa * exp(-t/(100 us)), until: 30.3 us}}]\n"
    "time: {%s, end: 40 us}\n";

static void follow(sdr_built *run, const char *how)
{
  scene_build(run, ring, how);
  assert_at_most(run_to_end(run, 5e-6), 1e-3);
}

static void a_breaking_ring_is_that_of_leapfrog_at_a_tiny_step(void **state)
{
  (void)state;
  sdr_built tiny, run;
  scene_build(&tiny, ring, "step: 0.01 us");
  run_start(&tiny);
  while (tiny.system->step < 4000) run_step(&tiny);
  static const char *const methods[] = {"integrator: cvode, tolerance: 1e-6, order: 5",
                                        "integrator: cvode, tolerance: 1e-6, method: adams"};
  sdr_balance expected, balance;
  sdr_system_balance(tiny.system, &expected);
  for (int m = 0; m < 2; ++m) {
    follow(&run, methods[m]);
    sdr_system_balance(run.system, &balance);
    assert_at_most(apart(run.system, tiny.system), 1e-4);
    assert_near(balance.model.dissipated, expected.model.dissipated,
                1e-3 * expected.model.dissipated);
    assert_true(expected.model.dissipated > 0.1 * expected.model.stored);
    sdr_built_destroy(&run);
  }
  sdr_built_destroy(&tiny);
}

static void every_linear_solver_finds_the_same_motion(void **state)
{
  (void)state;
  static const char *const solvers[] = {"stale", "cholmod", "klu", "umfpack"};
  sdr_built usual, run;
  follow(&usual, "integrator: cvode, tolerance: 1e-4");
  for (int k = 0; k < 4; ++k) {
    char how[80];
    snprintf(how, sizeof how, "integrator: cvode, tolerance: 1e-4, solver: %s", solvers[k]);
    follow(&run, how);
    assert_string_equal(run.system->method.solver, solvers[k]);
    assert_true(run.system->method.factors > 0 || k == 0); /* stale: blocks do here */
    assert_at_most(apart(run.system, usual.system), 5e-3);
    sdr_built_destroy(&run);
  }
  assert_string_equal(usual.system->method.solver, "pcg");
  sdr_built_destroy(&usual);
}

static void the_end_of_a_load_and_of_the_run_are_ends_of_steps(void **state)
{
  (void)state;
  sdr_built run;
  int landed = 0;
  scene_build(&run, ring, "integrator: cvode");
  run_start(&run);
  while (run.system->time < 40e-6) {
    run_step(&run);
    landed += run.system->time == 30.3e-6;
  }
  assert_int_equal(landed, 1);
  assert_true(run.system->time == 40e-6);
  sdr_built_destroy(&run);
}

/* ---- history --------------------------------------------------------------------------------- */

static const sdr_model_ops *sound;
static sdr_model_ops hasty;

/* The mistake that a step must not make: whatever it tries becomes history. */
static void force_that_commits(sdr_model *model, double *const u[3], double *const f[3])
{
  sound->commit(model, u);
  sound->force(model, u, f);
}

static const char *const one_bond =
    "dimension: 1d\n"
    "points: {shape: {interval: {from: 0 m, to: 1 m}}, spacing: 1 m}\n"
    "horizon: 1.01 spacing\n"
    "material: {young: 1 Pa, density: 1 kg/m^3, toughness: 0.01 J/m^2}\n"
    "damage: {law: variational}\n"
    "initial: {velocity: [\"1 m/s * (x < 0.5 m ? -0.05 : 0.05)\"]}\n"
    "time: {integrator: cvode, order: 5, tolerance: 5e-4, step: 2 s, end: 20 s}\n";

/* 1 if the history after the run is that of a body which was shown the accepted states only. */
static int history_is_of_accepted_states(int wrongly)
{
  sdr_built run, shadow;
  sdr_state_block blocks[SDR_STATE_BLOCKS], expected[SDR_STATE_BLOCKS];
  int count = 0, same = 1;
  scene_build(&run, "%s", one_bond);
  scene_build(&shadow, "%s", one_bond);
  sound = run.model->ops;
  hasty = *sound;
  hasty.force = force_that_commits;
  if (wrongly) run.model->ops = &hasty;
  run_start(&run);
  while (run.system->time < 20.0) {
    run_step(&run);
    sound->commit(shadow.model, run.system->u);
  }
  assert_true(run.system->method.error_failures > 3);
  sound->state(run.model, blocks, &count);
  sound->state(shadow.model, expected, &count);
  for (int b = 0; b < count; ++b)
    if (strstr(blocks[b].name, "history"))
      same &= memcmp(blocks[b].data, expected[b].data, blocks[b].bytes) == 0;
  run.model->ops = sound;
  sdr_built_destroy(&run);
  sdr_built_destroy(&shadow);
  return same;
}

static void trials_and_rejected_steps_leave_no_damage(void **state)
{
  (void)state;
  assert_true(history_is_of_accepted_states(0));
  assert_false(history_is_of_accepted_states(1));
}

static void a_resumed_run_has_the_bits_of_one_that_went_on(void **state)
{
  (void)state;
  char scene[600];
  snprintf(scene, sizeof scene, ring, "integrator: cvode, tolerance: 1e-4");
  assert_resumes(scene, 22e-6, 40e-6);
  snprintf(scene, sizeof scene, ring, "integrator: cvode, method: adams, tolerance: 1e-4");
  assert_resumes(scene, 30.3e-6, 40e-6); /* at an event */
}

/* ---- supports -------------------------------------------------------------------------------- */

static const char *const plate =
    "dimension: plane_stress\n"
    "points: {shape: {box: {from: [0, 0], to: [60 mm, 20 mm]}}, spacing: 4 mm}\n"
    "material: {model: %s, young: 210 GPa, poisson: 0.3, density: 7850 kg/m^3}\n"
    "supports:\n"
    "  - {on: left, displacement: {x: 0, y: \"10 um * sin(t/(5 us))^2\"}, depth: 8 mm}\n"
    "  - {on: right, velocity: {x: \"2 m/s * cos(t/(8 us))\"}, depth: 8 mm, until: 20 us}\n"
    "time: {integrator: %s, tolerance: 1e-7, end: 30 us}\n";

/* Energy, momentum and moment that moving supports bring, and one that lets go. */
static void moving_supports_are_booked(void **state)
{
  (void)state;
  static const char *const cases[][2] = {
      {"bond_based", "cvode"}, {"bond_based", "cvode, method: adams"}, {"bond_based", "ida"},
      {"ordinary", "cvode"},   {"nonordinary", "cvode, order: 5"},     {"nonordinary", "ida"}};
  for (int k = 0; k < 6; ++k) {
    sdr_built run;
    sdr_balance end;
    scene_build(&run, plate, cases[k][0], cases[k][1]);
    assert_at_most(run_to_end(&run, 1e-6), 1e-5);
    sdr_system_balance(run.system, &end);
    /* the start has the momentum of the right end: booked as none */
    double start = 0.0;
    for (int32_t i = 0; i < run.system->count; ++i)
      if (run.points->x[0][i] > 0.052) start += 2.0 * run.system->mass[i];
    assert_near(end.momentum[0] - run.system->impulse[0], start, 1e-5 * end.momentum_scale);
    assert_near(end.momentum[1] - run.system->impulse[1], 0.0, 1e-5 * end.momentum_scale);
    sdr_built_destroy(&run);
  }
}

static void a_support_moves_as_it_is_told(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, plate, "bond_based", "cvode");
  run_start(&run);
  while (run.system->time < 20e-6) run_step(&run);
  const double t = run.system->time;
  for (int32_t i = 0; i < run.system->count; ++i) {
    if (run.points->x[0][i] < 0.008) {
      assert_near(run.system->u[1][i], 10e-6 * pow(sin(t / 5e-6), 2), 1e-15);
      assert_near(run.system->v[1][i], 2.0 * sin(2 * t / 5e-6), 1e-6);
    }
    if (run.points->x[0][i] > 0.052)
      assert_near(run.system->u[0][i], 2.0 * 8e-6 * sin(t / 8e-6), 1e-10);
  }
  sdr_built_destroy(&run);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_error_follows_the_tolerance),
      cmocka_unit_test(a_breaking_ring_is_that_of_leapfrog_at_a_tiny_step),
      cmocka_unit_test(every_linear_solver_finds_the_same_motion),
      cmocka_unit_test(the_end_of_a_load_and_of_the_run_are_ends_of_steps),
      cmocka_unit_test(trials_and_rejected_steps_leave_no_damage),
      cmocka_unit_test(a_resumed_run_has_the_bits_of_one_that_went_on),
      cmocka_unit_test(moving_supports_are_booked),
      cmocka_unit_test(a_support_moves_as_it_is_told)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
