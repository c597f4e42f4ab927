/* Leapfrog: second order with smooth laws, exact momenta, supports in the books. */
#include "support/scene_text.h"

/* ---- closed forms ---------------------------------------------------------------------------- */

static const char *const two_points =
    "dimension: 1d\n"
    "points: {shape: {interval: {from: 0 m, to: 1 m}}, spacing: 1 m}\n"
    "horizon: 1.01 spacing\n"
    "material: {young: 1 Pa, density: 1 kg/m^3}\n"
    "initial: {velocity: [\"1 m/s * (x < 0.5 m ? 0.1 : -0.1)\"]}\n"
    "time: {step: %.17g s, end: 100 s}\n";

/* Two masses of 1 kg on a spring of 1 N/m: omega^2 = 2. Leapfrog's own solution turns at omega'
   with sin(omega' dt/2) = omega dt/2, which is exact to rounding. */
static void one_bond_swings_as_leapfrog_must(void **state)
{
  (void)state;
  const double dt = 0.3, omega = sqrt(2.0), turn = 2.0 / dt * asin(0.5 * omega * dt);
  sdr_built run;
  scene_build(&run, two_points, dt);
  run_start(&run);
  /* u_1 = dt v_0 as the force starts from zero: amplitude from the first step */
  const double amplitude = 0.1 * dt / sin(turn * dt);
  for (int n = 1; n <= 200; ++n) {
    run_step(&run);
    const double expected = amplitude * sin(turn * n * dt);
    assert_near(run.system->u[0][0], expected, 1e-12);
    assert_near(run.system->u[0][1], -expected, 1e-12);
  }
  sdr_built_destroy(&run);
}

/* Against the exact oscillation the error of the phase falls by 4. */
static void one_bond_converges_to_its_closed_form(void **state)
{
  (void)state;
  double error[3];
  for (int k = 0; k < 3; ++k) {
    const double dt = 0.1 / (1 << k), omega = sqrt(2.0);
    sdr_built run;
    scene_build(&run, two_points, dt);
    run_start(&run);
    error[k] = 0.0;
    for (int n = 1; n * dt < 10.0; ++n) {
      run_step(&run);
      const double exact = 0.1 / omega * sin(omega * n * dt);
      error[k] = fmax(error[k], fabs(run.system->u[0][0] - exact));
    }
    sdr_built_destroy(&run);
  }
  assert_near(error[0] / error[1], 4.0, 0.1);
  assert_near(error[1] / error[2], 4.0, 0.1);
}

static void a_free_body_flies_straight(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, "dimension: plane_strain\n"
                    "points: {shape: {disc: {radius: 20 mm}}, spacing: 1 mm}\n"
                    "material: {young: 1 GPa, density: 1000 kg/m^3, toughness: 10 J/m^2}\n"
                    "damage: {law: variational}\n"
                    "initial: {velocity: [3 m/s, -4 m/s]}\n"
                    "time: {step: 0.2 us, end: 40 us}\n");
  run_start(&run);
  for (int n = 0; n < 200; ++n) run_step(&run);
  sdr_balance balance;
  sdr_system_balance(run.system, &balance);
  for (int32_t i = 0; i < run.system->count; ++i) {
    assert_near(run.system->u[0][i], 3.0 * run.system->time, 1e-16);
    assert_near(run.system->u[1][i], -4.0 * run.system->time, 1e-16);
  }
  const double mass = 1000.0 * 1e-6 * run.system->count; /* thickness 1 m */
  assert_near(balance.kinetic, 0.5 * mass * 25.0, 1e-11 * balance.kinetic);
  assert_near(balance.momentum[0], 3.0 * mass, 1e-11 * mass);
  assert_at_most(balance.model.stored, 1e-20 * balance.kinetic);
  sdr_built_destroy(&run);
}

/* ---- order ----------------------------------------------------------------------------------- */

/* Largest imbalance of the 4 mm cylinder up to 40 us with the step halved `halvings` times. */
static double cylinder_imbalance(const char *law, int halvings)
{
  char step[64], damage[64];
  snprintf(step, sizeof step, "time.step=%.17g us", 0.8 / (1 << halvings));
  snprintf(damage, sizeof damage, "damage.law=%s", law);
  const char *const sets[] = {step, damage, NULL};
  sdr_built run;
  problem_build(&run, "thick_cylinder", "coarse_4mm", sets);
  const double worst = run_imbalance(&run, 40e-6, 0.8e-6);
  sdr_built_destroy(&run);
  return worst;
}

static void imbalance_falls_by_four(const char *law)
{
  double worst[4];
  for (int k = 0; k < 4; ++k) worst[k] = cylinder_imbalance(law, k);
  print_message("%s: imbalance %.3g %.3g %.3g %.3g\n", law, worst[0], worst[1], worst[2], worst[3]);
  for (int k = 0; k < 3; ++k) assert_near(worst[k] / worst[k + 1], 4.0, 0.6);
}

static void imbalance_falls_by_four_per_halving_with_variational_damage(void **state)
{
  (void)state;
  imbalance_falls_by_four("variational");
}

static void imbalance_falls_by_four_per_halving_of_an_elastic_body(void **state)
{
  (void)state;
  imbalance_falls_by_four("none");
}

static void critical_stretch_keeps_the_books_by_the_product_form(void **state)
{
  (void)state;
  static const char *const sets[] = {"points.spacing=2 mm", "time.step=0.2 us", NULL};
  sdr_built run;
  problem_build(&run, "thick_cylinder", "critical_stretch_half", sets);
  const double worst = run_imbalance(&run, 100e-6, 2e-6);
  sdr_balance balance;
  sdr_system_balance(run.system, &balance);
  print_message("critical stretch: imbalance %.3g, dissipated %.3g of the energy\n", worst,
                balance.model.dissipated / balance_energy(&balance));
  assert_true(balance.model.broken > 1000);
  assert_at_most(worst, 1e-3);
  sdr_built_destroy(&run);
}

/* ---- momenta --------------------------------------------------------------------------------- */

static void check_momenta(const sdr_built *run, int steps)
{
  const sdr_system *system = run->system;
  sdr_balance first, now;
  run_start(run);
  sdr_system_balance(run->system, &first);
  double scale = 0.0, turning = 0.0;
  for (int n = 1; n <= steps; ++n) {
    run_step(run);
    if (n % 10 != 0) continue;
    sdr_system_balance(run->system, &now);
    scale = fmax(scale, now.momentum_scale);
    turning = fmax(turning, now.angular_scale);
    for (int a = 0; a < 3; ++a) {
      assert_near(now.momentum[a] - first.momentum[a], system->impulse[a], 1e-12 * scale);
      assert_near(now.angular[a] - first.angular[a], system->angular_impulse[a], 1e-12 * turning);
    }
  }
  assert_true(now.model.max_damage > 0.1);
}

static void momenta_change_by_the_impulse_of_loads_and_supports(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run,
              "dimension: plane_stress\n"
              "points: {shape: {box: {from: [1 mm, 2 mm], to: [41 mm, 22 mm]}}, spacing: 1 mm}\n"
              "material: {young: 70 GPa, density: 2500 kg/m^3, toughness: 5 J/m^2,\n"
              "  scatter: {young: 10 %%}}\n"
              "damage: {law: variational}\n"
              "cracks: [{segment: {from: [20.4 mm, 0], to: [20.4 mm, 10.4 mm]}}]\n"
              "loads:\n"
              "  - traction: {on: right, value: [5 MPa, 2 MPa * sin(t/(3 us))]}\n"
              "  - body: {value: [0, -1e7 N/m^3]}\n"
              "  - point: {at: [10 mm, 22 mm], value: [0, 40 kN], from: 2 us, until: 9 us}\n"
              "supports:\n"
              "  - {on: left, depth: 3 spacing, velocity: {x: -2 m/s}, displacement: {y: 0}}\n"
              "time: {step: 0.1 us, end: 30 us}\n");
  check_momenta(&run, 300);
  sdr_built_destroy(&run);
}

static void a_spinning_disc_keeps_its_angular_momentum(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run,
              "dimension: plane_stress\n"
              "points: {shape: {disc: {radius: 15 mm}}, spacing: 1 mm, jitter: {share: 20 %%}}\n"
              "material: {young: 3 GPa, density: 1200 kg/m^3, toughness: 20 J/m^2}\n"
              "damage: {law: critical_stretch}\n"
              "initial: {velocity: [-2e4 /s * y, 2e4 /s * x]}\n"
              "time: {step: 0.1 us, end: 60 us}\n");
  check_momenta(&run, 600);
  assert_near(run.system->angular_impulse[2], 0.0, 0.0);
  sdr_built_destroy(&run);
}

static void a_spinning_block_keeps_its_angular_momentum_in_3d(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, "dimension: 3d\n"
                    "points: {shape: {box: {size: [12 mm, 8 mm, 6 mm]}}, spacing: 1 mm}\n"
                    "horizon: 2.01 spacing\n"
                    "material: {young: 3 GPa, density: 1200 kg/m^3, toughness: 20 J/m^2}\n"
                    "damage: {law: variational}\n"
                    "initial: {velocity: [-3e4 /s * y, 3e4 /s * (x - z), 3e4 /s * y]}\n"
                    "time: {step: 0.1 us, end: 30 us}\n");
  check_momenta(&run, 300);
  sdr_built_destroy(&run);
}

/* ---- supports -------------------------------------------------------------------------------- */

static const char *const pulled_bar =
    "dimension: 1d\n"
    "points: {shape: {interval: {from: 0 mm, to: 100 mm}}, spacing: 1 mm, area: 2 cm^2}\n"
    "material: {young: 200 GPa, density: 8000 kg/m^3}\n"
    "supports:\n"
    "  - {name: held, on: left, depth: 3 spacing, displacement: [0 m]}\n"
    "  - {name: pulled, on: right, depth: 3 spacing, %s: [\"%s\"]}\n"
    "time: {step: %.17g us, end: 4000 us}\n";

static double total_reaction(const sdr_system *system, int support)
{
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  double sum = 0.0;
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    if (list[k].support == support) sum += system->reaction[k];
  return sum;
}

/* Force through the bar's middle: E A times the strain there, exactly so by family sums. */
static void a_slowly_pulled_bar_reacts_with_e_a_eps(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, pulled_bar, "displacement", "0.1 mm * (t < 2 ms ? sin(pi*t/(4 ms))^2 : 1)",
              0.16);
  run_start(&run);
  double pulled = 0.0, held = 0.0, strain = 0.0;
  int count = 0;
  while (run.system->time < 2.8e-3) {
    run_step(&run);
    if (run.system->time < 2.2e-3) continue;
    pulled += total_reaction(run.system, 1);
    held += total_reaction(run.system, 0);
    strain += (run.system->u[0][60] - run.system->u[0][40]) / 0.020;
    ++count;
  }
  const double force = 200e9 * 2e-4 * strain / count;
  print_message("reaction/(E A eps) - 1: %.2g\n", pulled / count / force - 1.0);
  assert_near(pulled / count, force, 1e-3 * force);
  assert_near(held / count, -force, 1e-3 * force);
  /* 0.1 mm over the 94 mm between the held layers and about half a spacing at each end */
  assert_near(force, 200e9 * 2e-4 * 0.1 / 95.0, 0.005 * force);
  sdr_built_destroy(&run);
}

static void the_work_of_supports_is_in_the_books_to_second_order(void **state)
{
  (void)state;
  static const char *const motion[][2] = {{"displacement", "0.05 mm * sin(t/(10 us))^2"},
                                          {"velocity", "1 m/s * sin(t/(9 us))"}};
  for (int k = 0; k < 2; ++k) {
    double worst[3];
    for (int halvings = 0; halvings < 3; ++halvings) {
      sdr_built run;
      scene_build(&run, pulled_bar, motion[k][0], motion[k][1], 0.16 / (1 << halvings));
      worst[halvings] = run_imbalance(&run, 80e-6, 0.16e-6);
      assert_true(fabs(run.system->external_work) > 0.0);
      sdr_built_destroy(&run);
    }
    print_message("%s: imbalance %.3g %.3g %.3g\n", motion[k][0], worst[0], worst[1], worst[2]);
    assert_near(worst[0] / worst[1], 4.0, 0.6);
    assert_near(worst[1] / worst[2], 4.0, 0.6);
  }
}

/* ---- blow-up --------------------------------------------------------------------------------- */

static const char *const free_plate =
    "dimension: plane_stress\n"
    "points: {shape: {box: {from: [0, 0], to: [30 mm, 20 mm]}}, spacing: 1 mm}\n"
    "material: {young: 70 GPa, density: 2500 kg/m^3}\n"
    "initial: {velocity: [1e-6 m/s * (x > 17 mm), 1e-6 m/s * (y > 9 mm)]}\n"
    "time: {step: %s, end: 1 s, safety: 1, allow_unstable: true}\n";

static double largest_speed(const sdr_system *system)
{
  return vector_largest(system->model->points, system->v);
}

static void just_below_the_limit_a_run_stays_bounded_just_above_it_blows_up(void **state)
{
  (void)state;
  sdr_built run;
  char step[64];
  scene_build(&run, free_plate, "auto");
  const double limit = run.stable_step;
  sdr_built_destroy(&run);

  snprintf(step, sizeof step, "%.17g s", 0.99 * limit);
  scene_build(&run, free_plate, step);
  run_start(&run);
  for (int n = 0; n < 3000; ++n) run_step(&run);
  assert_at_most(largest_speed(run.system), 1e-4);
  sdr_built_destroy(&run);

  snprintf(step, sizeof step, "%.17g s", 1.02 * limit);
  scene_build(&run, free_plate, step);
  assert_non_null(strstr(run.warning, "above the stability limit"));
  run_start(&run);
  sdr_status status = SDR_OK;
  int n = 0;
  for (; n < 3000 && status == SDR_OK; ++n) status = run.integrator->step(run.system, run.step);
  assert_int_equal(status, SDR_RUN_FAILED);
  char expected[128];
  snprintf(expected, sizeof expected, "the run blew up at t = %.6g s (step %d): the point at (",
           run.system->time, n);
  assert_non_null(strstr(sdr_error_message(), expected));
  assert_non_null(strstr(sdr_error_message(), "would move by a horizon or more in one step"));
  sdr_built_destroy(&run);
}

static void a_step_above_the_limit_is_refused_with_the_limit(void **state)
{
  (void)state;
  sdr_built run;
  assert_int_equal(scene_try(&run, two_points, 1.5), SDR_BAD_INPUT); /* limit 2/sqrt 2 */
  assert_non_null(strstr(sdr_error_message(), "above the stability limit 1.414e+06 us"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(one_bond_swings_as_leapfrog_must),
      cmocka_unit_test(one_bond_converges_to_its_closed_form),
      cmocka_unit_test(a_free_body_flies_straight),
      cmocka_unit_test(imbalance_falls_by_four_per_halving_with_variational_damage),
      cmocka_unit_test(imbalance_falls_by_four_per_halving_of_an_elastic_body),
      cmocka_unit_test(critical_stretch_keeps_the_books_by_the_product_form),
      cmocka_unit_test(momenta_change_by_the_impulse_of_loads_and_supports),
      cmocka_unit_test(a_spinning_disc_keeps_its_angular_momentum),
      cmocka_unit_test(a_spinning_block_keeps_its_angular_momentum_in_3d),
      cmocka_unit_test(a_slowly_pulled_bar_reacts_with_e_a_eps),
      cmocka_unit_test(the_work_of_supports_is_in_the_books_to_second_order),
      cmocka_unit_test(just_below_the_limit_a_run_stays_bounded_just_above_it_blows_up),
      cmocka_unit_test(a_step_above_the_limit_is_refused_with_the_limit),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
