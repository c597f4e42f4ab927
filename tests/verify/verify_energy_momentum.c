/* Energy-momentum steps: second order, and exact books of energy and momenta at any step, with
   damage, supports and loads. */
#include "support/scene_text.h"

/* ---- order ----------------------------------------------------------------------------------- */

/* Two masses of 1 kg on a spring of 1 N/m (half bonds): omega^2 = 2, small strains. */
static const char *const two_points =
    "dimension: 1d\n"
    "points: {shape: {interval: {from: 0 m, to: 1 m}}, spacing: 1 m}\n"
    "horizon: 1.01 spacing\n"
    "material: {young: 1 Pa, density: 1 kg/m^3}\n"
    "initial: {velocity: [\"1 m/s * (x < 0.5 m ? 1e-3 : -1e-3)\"]}\n"
    "time: {integrator: energy_momentum, step: %.17g s, end: 100 s}\n";

/* A midpoint step turns the phase by 2 atan(omega dt/2), at any dt. */
static void one_bond_swings_as_midpoint_steps_must(void **state)
{
  (void)state;
  static const double steps[] = {0.1, 1.0, 10.0};
  for (int k = 0; k < 3; ++k) {
    const double dt = steps[k], omega = sqrt(2.0), turn = 2.0 * atan(0.5 * omega * dt);
    sdr_built run;
    scene_build(&run, two_points, dt);
    run_start(&run);
    for (int n = 1; n <= 100; ++n) {
      run_step(&run);
      assert_near(run.system->u[0][0], 1e-3 / omega * sin(turn * n), 1e-12);
      assert_near(run.system->v[0][1], -1e-3 * cos(turn * n), 2e-12);
    }
    sdr_built_destroy(&run);
  }
}

static const char *const beating_plate =
    "dimension: plane_stress\n"
    "points: {shape: {box: {from: [0, 0], to: [20 mm, 10 mm]}}, spacing: 1 mm}\n"
    "material: {young: 70 GPa, density: 2500 kg/m^3}\n"
    "initial: {velocity: [\"3 m/s * cos(pi*x/(20 mm))\", \"-2 m/s * cos(pi*y/(10 mm))\"]}\n"
    "time: {integrator: energy_momentum, step: %.17g us, end: 100 us}\n";

/* u_x of all points at 6.4 us. */
static void final_motion(int halvings, double *u)
{
  sdr_built run;
  scene_build(&run, beating_plate, 0.1 / (1 << halvings));
  run_start(&run);
  for (int n = 0; n < 64 << halvings; ++n) run_step(&run);
  memcpy(u, run.system->u[0], (size_t)run.system->count * sizeof *u);
  sdr_built_destroy(&run);
}

static void a_smooth_elastic_body_converges_with_the_square_of_the_step(void **state)
{
  (void)state;
  enum { POINTS = 21 * 11, RUNS = 4 };
  static double u[RUNS][POINTS];
  double change[RUNS - 1] = {0.0};
  for (int k = 0; k < RUNS; ++k) final_motion(k, u[k]);
  for (int k = 0; k < RUNS - 1; ++k)
    for (int i = 0; i < POINTS; ++i) change[k] = hypot(change[k], u[k + 1][i] - u[k][i]);
  print_message("changes by halving the step: %.3g %.3g %.3g of %.3g\n", change[0], change[1],
                change[2], u[3][0]);
  assert_near(change[0] / change[1], 4.0, 0.2);
  assert_near(change[1] / change[2], 4.0, 0.1);
}

/* ---- books ----------------------------------------------------------------------------------- */

typedef struct {
  double energy, linear, angular; /* largest residuals, relative as in the summary */
  sdr_balance last;
} audit;

static audit audited(const sdr_built *run, int steps)
{
  const sdr_system *system = run->system;
  sdr_balance first;
  audit a = {0};
  double most = 0.0, scale = 0.0, turning = 0.0;
  run_start(run);
  sdr_system_balance(run->system, &first);
  for (int n = 1; n <= steps; ++n) {
    run_step(run);
    sdr_system_balance(run->system, &a.last);
    most = fmax(most, balance_energy(&a.last));
    scale = fmax(scale, a.last.momentum_scale);
    turning = fmax(turning, a.last.angular_scale);
    const double off = balance_energy(&a.last) - balance_energy(&first) - system->external_work;
    a.energy = fmax(a.energy, fabs(off) / most);
    for (int c = 0; c < 3; ++c) {
      const double p = a.last.momentum[c] - first.momentum[c] - system->impulse[c];
      const double l = a.last.angular[c] - first.angular[c] - system->angular_impulse[c];
      a.linear = fmax(a.linear, fabs(p) / scale);
      a.angular = fmax(a.angular, fabs(l) / turning);
    }
  }
  return a;
}

static void assert_balanced(const audit *a, double limit)
{
  print_message("energy %.2g, momentum %.2g, spin %.2g; damage %.3f, %lld broken\n", a->energy,
                a->linear, a->angular, a->last.model.max_damage, (long long)a->last.model.broken);
  assert_at_most(a->energy, limit);
  assert_at_most(a->linear, limit);
  assert_at_most(a->angular, limit);
}

static const char *const torn_plate =
    "dimension: plane_stress\n"
    "points: {shape: {box: {from: [1 mm, 2 mm], to: [31 mm, 16 mm]}}, spacing: 1 mm%s}\n"
    "material: {young: 70 GPa, density: 2500 kg/m^3, toughness: 5 J/m^2,\n"
    "  strength: 8 MPa,\n"
    "  scatter: {young: 10 %%}}\n"
    "damage: {law: %s}\n"
    "cracks: [{segment: {from: [15.4 mm, 0], to: [15.4 mm, 8.4 mm]}}]\n"
    "loads:\n"
    "  - traction: {on: right, value: [5 MPa, 2 MPa * sin(t/(3 us))]}\n"
    "  - body: {value: [0, -1e7 N/m^3]}\n"
    "  - point: {at: [10 mm, 16 mm], value: [0, 40 kN], from: 2 us, until: 9 us}\n"
    "supports:\n"
    "  - {on: left, depth: 3 spacing, velocity: {x: -2 m/s}, displacement: {y: 1e-5 m * sin(t/(9 "
    "us))}}\n"
    "time: {integrator: energy_momentum, solver: %s, step: %s us, end: 1 ms}\n";

/* The explicit limit is 0.36 us. */
static void books_balance_with_loads_supports_and_damage_at_any_step(void **state)
{
  (void)state;
  static const char *const steps[] = {"0.02", "0.2", "1", "10"};
  for (int k = 0; k < 4; ++k) {
    sdr_built run;
    scene_build(&run, torn_plate, "", "variational", "auto", steps[k]);
    const audit a = audited(&run, k == 0 ? 60 : 20);
    assert_true(a.last.model.max_damage > (k == 0 ? 0.01 : 0.3));
    assert_balanced(&a, 1e-11);
    sdr_built_destroy(&run);
  }
}

static void bonds_that_break_leave_the_books_exact(void **state)
{
  (void)state;
  static const char *const points[] = {"", ", jitter: {share: 20 %}"};
  for (int k = 0; k < 2; ++k) {
    sdr_built run;
    scene_build(&run, torn_plate, points[k], "critical_stretch", "auto", "0.5");
    const audit a = audited(&run, 25);
    assert_true(a.last.model.broken > 20);
    assert_balanced(&a, 1e-11);
    sdr_built_destroy(&run);
  }
}

static void softening_of_any_law_leaves_the_books_exact(void **state)
{
  (void)state;
  static const char *const laws[] = {"at1", "cohesive"};
  for (int k = 0; k < 2; ++k) {
    sdr_built run;
    scene_build(&run, torn_plate, "", laws[k], "auto", "1");
    const audit a = audited(&run, 15);
    assert_true(a.last.model.max_damage > 0.5);
    assert_balanced(&a, 1e-11);
    sdr_built_destroy(&run);
  }
}

static void every_solver_finds_the_same_steps(void **state)
{
  (void)state;
  static const char *const solvers[] = {"bicgstab", "stale", "umfpack", "klu"};
  double u[4] = {0.0};
  for (int k = 0; k < 4; ++k) {
    sdr_built run;
    scene_build(&run, torn_plate, "", "variational", solvers[k], "0.5");
    run_start(&run);
    for (int n = 0; n < 8; ++n) run_step(&run);
    u[k] = run.system->u[1][200];
    assert_string_equal(run.system->solve.name, solvers[k]);
    assert_near(u[k], u[0], 1e-11 * fabs(u[0]));
    sdr_built_destroy(&run);
  }
}

/* ---- spin ------------------------------------------------------------------------------------ */

static void a_spinning_disc_that_cracks_keeps_its_spin_and_energy(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run,
              "dimension: plane_stress\n"
              "points: {shape: {disc: {radius: 12 mm}}, spacing: 1 mm, jitter: {share: 20 %%}}\n"
              "material: {young: 3 GPa, density: 1200 kg/m^3, toughness: 20 J/m^2}\n"
              "damage: {law: variational}\n"
              "cracks: [{segment: {from: [0.3 mm, 0.2 mm], to: [7 mm, 0.2 mm]}}]\n"
              "initial: {velocity: [-1e4 /s * y, 1e4 /s * x]}\n"
              "time: {integrator: energy_momentum, step: 3 us, end: 600 us}\n");
  const audit a = audited(&run, 60);
  assert_true(a.last.model.max_damage > 0.5);
  assert_balanced(&a, 1e-11);
  assert_true(run.system->external_work == 0.0);
  sdr_built_destroy(&run);
}

/* A quarter turn in one step: the body stays in one piece and unstrained as far as steps of this
   size can, and spin and energy do not notice. */
static void a_block_turns_by_large_angles_in_3d(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, "dimension: 3d\n"
                    "points: {shape: {box: {size: [6 mm, 4 mm, 3 mm]}}, spacing: 1 mm}\n"
                    "horizon: 2.01 spacing\n"
                    "material: {young: 3 GPa, density: 1200 kg/m^3}\n"
                    "initial: {velocity: [-3e3 /s * y, 3e3 /s * (x - z), 3e3 /s * y]}\n"
                    "time: {integrator: energy_momentum, step: 100 us, end: 1 ms}\n");
  const audit a = audited(&run, 10);
  assert_balanced(&a, 1e-11);
  sdr_built_destroy(&run);
}

/* ---- steps that are too long ----------------------------------------------------------------- */

static void steps_that_are_too_long_are_cut_and_counted(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, torn_plate, "", "variational", "auto", "10");
  const audit a = audited(&run, 5);
  const sdr_solve_record *solve = &run.system->solve;
  print_message("%lld accepted, %lld cuts\n", (long long)solve->accepted, (long long)solve->cuts);
  assert_true(solve->cuts > 0);
  assert_true(solve->accepted > 5);
  assert_near(run.system->time, 50e-6, 1e-18);
  assert_int_equal(run.system->step, 5);
  assert_balanced(&a, 1e-11);
  sdr_built_destroy(&run);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(one_bond_swings_as_midpoint_steps_must),
      cmocka_unit_test(a_smooth_elastic_body_converges_with_the_square_of_the_step),
      cmocka_unit_test(books_balance_with_loads_supports_and_damage_at_any_step),
      cmocka_unit_test(bonds_that_break_leave_the_books_exact),
      cmocka_unit_test(softening_of_any_law_leaves_the_books_exact),
      cmocka_unit_test(every_solver_finds_the_same_steps),
      cmocka_unit_test(a_spinning_disc_that_cracks_keeps_its_spin_and_energy),
      cmocka_unit_test(a_block_turns_by_large_angles_in_3d),
      cmocka_unit_test(steps_that_are_too_long_are_cut_and_counted)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
