/* The linear static solution: closed forms, equilibrium, books, and what has no solution. */
#include "support/scene_text.h"

#define HEAD                                                                                       \
  "title: t\n"                                                                                     \
  "output: {snapshots: 0}\n"                                                                       \
  "material: {young: 70 GPa, density: 2500 kg/m^3}\n"

#define PLATE                                                                                      \
  HEAD "dimension: plane_stress\n"                                                                 \
       "points: {shape: {box: {from: [0, 0], to: [40 mm, 20 mm]}}, spacing: 1 mm, align: cell}\n"

static void solve(const sdr_built *run)
{
  run_start(run);
  run_step(run);
}

static double *copy_of(const sdr_built *run, double *const v[3])
{
  const size_t count = (size_t)run->system->count, m = (size_t)run->system->components;
  double *copy = sdr_alloc(count * m, sizeof *copy);
  for (size_t a = 0; a < m; ++a) memcpy(copy + a * count, v[a], count * sizeof *copy);
  return copy;
}

/* Neighbours only: springs in a row, each with E A/dx. */
static void a_bar_under_an_end_load_stretches_as_springs_in_a_row(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run,
              HEAD "dimension: 1d\n"
                   "points: {shape: {interval: {from: 0, to: 1 m}}, spacing: 10 mm, area: 2 m^2}\n"
                   "horizon: 1.015 spacing\n"
                   "loads: [{point: {at: [1 m], value: [3 kN]}}]\n"
                   "supports: [{on: left, depth: 0.1 spacing, displacement: {x: 1 um}}]\n"
                   "time: {integrator: static}\n");
  solve(&run);
  assert_int_equal(run.points->count, 101);
  for (int32_t i = 0; i < 101; ++i)
    assert_near(run.system->u[0][i], 1e-6 + 3e3 * run.points->x[0][i] / (70e9 * 2.0), 1e-18);
  assert_near(run.system->reaction[0], -3e3, 3e-7);
  assert_near(run.system->time, 1.0, 0.0);
  assert_int_equal(run.system->step, 1);
  sdr_built_destroy(&run);
}

/* Far from its ends a nonlocal bar has the strain of a local one. */
static void a_nonlocal_bar_has_the_exact_strain_inside(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, HEAD "dimension: 1d\n"
                         "points: {shape: {interval: {from: 0, to: 1 m}}, spacing: 5 mm}\n"
                         "loads: [{point: {at: [1 m], value: [3 kN]}}]\n"
                         "supports: [{on: left, depth: 3 spacing, displacement: {x: 0}}]\n"
                         "time: {integrator: static}\n");
  solve(&run);
  const double *u = run.system->u[0];
  for (int32_t i = 80; i < 120; ++i) assert_near((u[i + 1] - u[i]) / 5e-3, 3e3 / 70e9, 1e-18);
  sdr_built_destroy(&run);
}

/* On a lattice a uniform gradient is in equilibrium: it spreads from a prescribed border, wider
   than the horizon. */
static void check_patch(const char *dimension, const char *whole, const char *inner,
                        const char *displacement)
{
  sdr_built run;
  scene_build(&run,
              HEAD "dimension: %s\n"
                   "points: {shape: %s, spacing: 1.5 mm, align: cell}\n"
                   "regions: {border: {difference: [%s, %s]}}\n"
                   "supports: [{on: border, displacement: %s}]\n"
                   "time: {integrator: static}\n",
              dimension, whole, whole, inner, displacement);
  solve(&run);
  const sdr_points *points = run.points;
  double worst = 0.0, most = 0.0, largest = 0.0;
  for (int32_t i = 0; i < points->count; ++i) {
    const double x = points->x[0][i], y = points->components > 1 ? points->x[1][i] : 0.0;
    const double z = points->components > 2 ? points->x[2][i] : 0.0;
    const double exact[3] = {1e-4 * x + 2e-4 * y - 3e-4 * z, -3e-4 * x + 2e-4 * y,
                             1e-4 * x - 2e-4 * z};
    for (int a = 0; a < points->components; ++a) {
      worst = fmax(worst, fabs(run.system->u[a][i] - exact[a]));
      most = fmax(most, fabs(exact[a]));
    }
  }
  for (int32_t k = 0; k < sdr_supports_count(run.supports); ++k)
    largest = fmax(largest, fabs(run.system->reaction[k]));
  print_message("%s: %d of %d components free, error %.1e\n", dimension,
                (int)run.system->solve.unknowns, (int)(points->count * points->components),
                worst / most);
  assert_true(run.system->solve.unknowns > 10);
  assert_true(largest > 0.0);
  assert_at_most(worst, 1e-12 * most);
  sdr_built_destroy(&run);
}

static void a_uniform_gradient_spreads_from_the_border_of_a_lattice(void **state)
{
  (void)state;
  check_patch("1d", "{interval: {from: 0, to: 30 mm}}", "{interval: {from: 5.5 mm, to: 24.5 mm}}",
              "{x: 1e-4*x}");
  for (int strain = 0; strain < 2; ++strain)
    check_patch(strain ? "plane_strain" : "plane_stress",
                "{box: {from: [0, 0], to: [30 mm, 30 mm]}}",
                "{box: {from: [5.5 mm, 5.5 mm], to: [24.5 mm, 24.5 mm]}}",
                "{x: 1e-4*x+2e-4*y, y: -3e-4*x+2e-4*y}");
  check_patch("3d", "{box: {from: [0, 0, 0], to: [18 mm, 18 mm, 18 mm]}}",
              "{box: {from: [5.5 mm, 5.5 mm, 5.5 mm], to: [12.5 mm, 12.5 mm, 12.5 mm]}}",
              "{x: 1e-4*x+2e-4*y-3e-4*z, y: -3e-4*x+2e-4*y, z: 1e-4*x-2e-4*z}");
}

/* ---- equilibrium and books ------------------------------------------------------------------- */

/* A plate held at the left, pressed at the right, pulled at the top, with a body force. */
static void build_loaded(sdr_built *run, const char *jitter, double megapascals, const char *more)
{
  scene_build(run,
              HEAD "dimension: plane_stress\n"
                   "points:\n"
                   "  shape: {box: {from: [0, 0], to: [40 mm, 20 mm]}}\n"
                   "  spacing: 1 mm\n"
                   "  align: cell\n"
                   "  jitter: {share: %s, seed: 3}\n"
                   "loads:\n"
                   "  - pressure: {on: right, value: %g MPa}\n"
                   "  - traction: {on: top, value: [%g MPa, %g MPa * x/(40 mm)]}\n"
                   "  - body: {value: [0, %g N/m^3]}\n"
                   "supports: [{on: left, depth: 2 spacing, displacement: {x: 0, y: 0}}]\n"
                   "time: {%s}\n",
              jitter, megapascals, 0.2 * megapascals, 0.5 * megapascals, -1e7 * megapascals, more);
}

/* Sums of forces and torques: loads and reactions; their sizes. */
static void check_equilibrium(const sdr_built *run)
{
  const sdr_system *system = run->system;
  const sdr_prescribed *list = sdr_supports_list(run->supports);
  double sum[3] = {0.0}, size[3] = {0.0};
  for (int32_t k = 0; k < sdr_loads_count(run->loads); ++k) {
    const int32_t i = sdr_loads_points(run->loads)[k];
    const double x = run->points->x[0][i], y = run->points->x[1][i];
    const double fx = sdr_loads_force(run->loads, 0)[k], fy = sdr_loads_force(run->loads, 1)[k];
    const double add[3] = {fx, fy, x * fy - y * fx};
    for (int c = 0; c < 3; ++c) {
      sum[c] += add[c];
      size[c] += fabs(add[c]);
    }
  }
  for (int32_t k = 0; k < sdr_supports_count(run->supports); ++k) {
    const double x = run->points->x[0][list[k].point], y = run->points->x[1][list[k].point];
    const int a = list[k].component;
    sum[a] += system->reaction[k];
    sum[2] += (a == 0 ? -y : x) * system->reaction[k];
  }
  for (int c = 0; c < 3; ++c) {
    assert_true(size[c] > 0.0);
    assert_at_most(fabs(sum[c]) / size[c], 1e-10);
  }
}

static void reactions_balance_the_loads_with_every_solver(void **state)
{
  (void)state;
  static const char *const solvers[] = {"cholmod", "klu", "umfpack", "pcg", "auto"};
  static const char *const jitters[] = {"0", "20 %"};
  for (int j = 0; j < 2; ++j) {
    double *first = NULL;
    for (int k = 0; k < 5; ++k) {
      sdr_built run;
      char more[64];
      snprintf(more, sizeof more, "integrator: static, solver: %s, end: 2 ms", solvers[k]);
      build_loaded(&run, jitters[j], 50.0, more);
      solve(&run);
      check_equilibrium(&run);
      assert_at_most(run.system->solve.residual, 1e-11);
      assert_string_equal(run.system->solve.name, k < 4 ? solvers[k] : "cholmod");
      assert_int_equal(run.system->solve.unknowns, 2 * (40 * 20 - 2 * 20));
      assert_near(run.system->time, 2e-3, 0.0);
      double *u = copy_of(&run, run.system->u), most = 0.0;
      const size_t size = 2 * (size_t)run.system->count;
      for (size_t i = 0; i < size; ++i) most = fmax(most, fabs(u[i]));
      for (size_t i = 0; first && i < size; ++i) assert_near(u[i], first[i], 1e-9 * most);
      for (int a = 0; a < 2; ++a)
        for (int32_t i = 0; i < run.system->count; ++i) {
          assert_near(run.system->v[a][i], 0.0, 0.0);
          assert_near(run.system->f[a][i], 0.0, 1e-6); /* 1 MN pulls */
        }
      if (first)
        sdr_free(u);
      else
        first = u;
      sdr_built_destroy(&run);
    }
    sdr_free(first);
  }
}

/* Energy stored by the bent body less the work done, over that energy. */
static double imbalance_at(double megapascals)
{
  sdr_built run;
  sdr_balance balance;
  build_loaded(&run, "0", megapascals, "integrator: static");
  run_start(&run);
  sdr_system_balance(run.system, &balance);
  assert_near(balance_energy(&balance), 0.0, 0.0);
  run_step(&run);
  sdr_system_balance(run.system, &balance);
  const double energy = balance_energy(&balance);
  const double imbalance = (energy - run.system->external_work) / energy;
  assert_true(energy > 0.0);
  print_message("%g MPa: imbalance %.2e, nonlinearity %.2e\n", megapascals, imbalance,
                run.system->solve.nonlinearity);
  sdr_built_destroy(&run);
  return fabs(imbalance);
}

/* The energy is that of the bent body, the solution linear: they part in proportion to strain. */
static void work_and_energy_agree_as_strain_vanishes(void **state)
{
  (void)state;
  const double large = imbalance_at(1.0), small = imbalance_at(0.01);
  assert_near(large / small, 100.0, 5.0);
  assert_at_most(imbalance_at(1e-6), 1e-8);
}

/* Nothing but prescribed motion: the reactions do the work. */
static void prescribed_motion_does_the_work_of_its_reactions(void **state)
{
  (void)state;
  sdr_built run;
  sdr_balance balance;
  scene_build(&run, PLATE "supports:\n"
                          "  - {on: left, displacement: {x: 0, y: 0}}\n"
                          "  - {on: right, displacement: {x: 1 nm, y: 2 nm}, ramp: 2 s}\n"
                          "time: {integrator: static}\n");
  solve(&run);
  sdr_system_balance(run.system, &balance);
  const sdr_prescribed *list = sdr_supports_list(run.supports);
  double work = 0.0;
  for (int32_t k = 0; k < sdr_supports_count(run.supports); ++k) {
    const double motion = list[k].support == 0 ? 0.0 : list[k].component == 0 ? 0.5e-9 : 1e-9;
    assert_near(run.system->u[list[k].component][list[k].point], motion, 0.0); /* half the ramp */
    work += 0.5 * run.system->reaction[k] * motion;
  }
  assert_true(work > 0.0);
  assert_near(run.system->external_work, work, 1e-12 * work);
  assert_near(balance_energy(&balance), work, 1e-6 * work);
  sdr_built_destroy(&run);
}

/* ---- rest ------------------------------------------------------------------------------------ */

/* Largest velocity over `steps` steps of leapfrog from the displacement u (NULL: zero). */
static double largest_velocity(double megapascals, const double *u, int steps)
{
  sdr_built run;
  double most = 0.0;
  build_loaded(&run, "0", megapascals, "integrator: leapfrog, end: 1 s");
  const size_t count = (size_t)run.system->count;
  for (size_t a = 0; u && a < 2; ++a) memcpy(run.system->u[a], u + a * count, count * sizeof *u);
  run_start(&run);
  for (int n = 0; n < steps; ++n) {
    run_step(&run);
    most = fmax(most, vector_largest(run.points, run.system->v));
  }
  sdr_built_destroy(&run);
  return most;
}

static void leapfrog_rests_in_the_static_solution(void **state)
{
  (void)state;
  sdr_built run;
  const double load = 1e-4; /* MPa: strains of 1e-9, so that what is not linear is rounding */
  build_loaded(&run, "0", load, "integrator: static");
  solve(&run);
  double *u = copy_of(&run, run.system->u);
  const double bent = run.system->solve.nonlinearity;
  sdr_built_destroy(&run);
  const double loose = largest_velocity(load, NULL, 300), held = largest_velocity(load, u, 300);
  print_message("velocity %.2e m/s from rest, %.2e from the static solution (nonlinearity %.1e)\n",
                loose, held, bent);
  assert_true(loose > 0.0);
  assert_at_most(held, 3e-7 * loose);
  sdr_free(u);
}

/* ---- fictitious layers ----------------------------------------------------------------------- */

/* Mirrors are planes of symmetry at two sides, a traction pulls at the others: uniform strain up to
   every surface. The stiffness is not symmetric. */
static void layers_carry_a_uniform_stress_up_to_the_surfaces(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, PLATE "supports:\n"
                          "  - {on: left, layer: mirror, displacement: {x: 0}}\n"
                          "  - {on: bottom, layer: mirror, displacement: {y: 1 um}}\n"
                          "loads:\n"
                          "  - traction: {on: right, layer: fictitious, value: [2 MPa, 0]}\n"
                          "  - traction: {on: top, layer: fictitious, value: [0, 1 MPa]}\n"
                          "family: {weight: iso}\n"
                          "time: {integrator: static}\n");
  solve(&run);
  assert_string_equal(run.system->solve.name, "umfpack");
  const double nu = 1.0 / 3.0, exx = (2e6 - nu * 1e6) / 70e9, eyy = (1e6 - nu * 2e6) / 70e9;
  double worst = 0.0;
  for (int32_t i = 0; i < run.points->count; ++i) {
    worst = fmax(worst, fabs(run.system->u[0][i] - exx * run.points->x[0][i]));
    worst = fmax(worst, fabs(run.system->u[1][i] - 1e-6 - eyy * run.points->x[1][i]));
    for (int a = 0; a < 2; ++a) assert_near(run.system->f[a][i], 0.0, 1e-6);
  }
  assert_at_most(worst, 1e-10 * exx * 0.04);
  /* points in the corner of two layers belong to one of them */
  assert_near(sdr_layers_reaction(run.layers, 0, 0), -2e6 * 0.02, 0.03 * 2e6 * 0.02);
  assert_near(sdr_layers_reaction(run.layers, 1, 1), -1e6 * 0.04, 0.03 * 1e6 * 0.04);
  sdr_built_destroy(&run);
}

static void mirrors_that_stretch_a_plate_do_the_work_it_stores(void **state)
{
  (void)state;
  sdr_built run;
  sdr_balance balance;
  scene_build(&run, PLATE "supports:\n"
                          "  - {on: left, layer: mirror, displacement: {x: 0, y: 0}}\n"
                          "  - {on: right, layer: mirror, displacement: {x: 1 nm, y: 0}}\n"
                          "time: {integrator: static}\n");
  solve(&run);
  assert_string_equal(run.system->solve.name, "cholmod");
  sdr_system_balance(run.system, &balance);
  const double work = 0.5 * 1e-9 * sdr_layers_reaction(run.layers, 1, 0);
  assert_true(work > 0.0);
  assert_near(run.system->external_work, work, 1e-10 * work);
  assert_near(balance_energy(&balance), work, 1e-6 * work);
  sdr_built_destroy(&run);
}

/* ---- what has no solution -------------------------------------------------------------------- */

static void check_failure(sdr_status status, const char *begins, const char *ends,
                          const char *scene)
{
  sdr_built run;
  scene_build(&run, "%s", scene);
  run_start(&run);
  assert_int_equal(run.integrator->step(run.system, run.step), status);
  const char *message = sdr_error_message();
  const size_t length = strlen(message), tail = strlen(ends);
  if (strncmp(message, begins, strlen(begins)) != 0 || length < tail ||
      strcmp(message + length - tail, ends) != 0)
    fail_msg("%s", message);
  sdr_built_destroy(&run);
}

#define FREELY "the stiffness is singular: the point at x = "
#define HOLD "; give supports that keep the body, and every part of it, from moving and turning"

static void a_body_that_nothing_holds_is_refused(void **state)
{
  (void)state;
  static const char *const times = "time: {integrator: static, solver: pcg}\n";
  char scene[1000];
  snprintf(scene, sizeof scene, "%ssupports: [{on: left, displacement: {x: 0}}]\n%s", PLATE, times);
  check_failure(SDR_BAD_INPUT,
                "nothing keeps the body from moving along y; prescribe that component of some of "
                "its points (supports)",
                "", scene);
  snprintf(
      scene, sizeof scene,
      "%ssupports: [{on: {disc: {centre: [5.5 mm, 5.5 mm], radius: 0.1 mm}}, displacement: {x: "
      "0, y: 0}}]\n%s",
      PLATE, times);
  check_failure(SDR_BAD_INPUT,
                "nothing keeps the body from turning; prescribe components of points some way "
                "apart (supports)",
                "", scene);
}

/* Rollers along two sides hold a plate, and so do three along its edges. */
static void three_prescribed_components_hold_a_plate(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, PLATE
              "supports:\n"
              "  - {on: {disc: {centre: [0.5 mm, 0.5 mm], radius: 0.1 mm}}, displacement: {x: 0, "
              "y: 0}}\n"
              "  - {on: {disc: {centre: [39.5 mm, 0.5 mm], radius: 0.1 mm}}, displacement: {y: "
              "0}}\n"
              "loads: [{pressure: {on: right, value: 1 MPa}}]\n"
              "time: {integrator: static}\n");
  solve(&run);
  assert_int_equal(run.system->solve.unknowns, 1600 - 3);
  sdr_built_destroy(&run);
}

/* A cut through the whole plate: its right half hangs on nothing. */
static void a_part_that_is_cut_off_is_named_with_a_point_of_its_own(void **state)
{
  (void)state;
  static const char *const solvers[] = {"cholmod", "umfpack", "klu", "auto"};
  for (int k = 0; k < 5; ++k) { /* at last many points, whose zero pivot is far above 1e-16 */
    sdr_built run;
    double x = 0.0;
    scene_build(&run,
                HEAD "dimension: plane_stress\n"
                     "points: {shape: {box: {from: [0, 0], to: [40 mm, 20 mm]}}, spacing: %s mm, "
                     "align: cell}\n"
                     "cracks: [{segment: {from: [20 mm, -1 mm], to: [20 mm, 21 mm]}}]\n"
                     "supports: [{on: left, displacement: {x: 0, y: 0}}]\n"
                     "loads: [{pressure: {on: right, value: 1 MPa}}]\n"
                     "time: {integrator: static, solver: %s}\n",
                k < 4 ? "1" : "0.2", solvers[k % 4]);
    run_start(&run);
    assert_int_equal(run.integrator->step(run.system, run.step), SDR_RUN_FAILED);
    const char *message = sdr_error_message();
    if (sscanf(message, FREELY "%lf mm", &x) != 1) fail_msg("%s: %s", solvers[k], message);
    assert_true(x > 20.0 && x < 40.0);
    assert_string_equal(message + strlen(message) - strlen(HOLD), HOLD);
    sdr_built_destroy(&run);
  }
}

/* A strip 300 times as long as high bends as a beam, soft but not singular: its tip sinks by
   4 q L^3/(E h^2), L from the held points, and by a fifth more as six rows within two horizons are
   softer than a beam. */
static void a_slender_strip_is_not_taken_for_singular(void **state)
{
  (void)state;
  static const char *const solvers[] = {"cholmod", "umfpack", "klu"};
  for (int k = 0; k < 3; ++k) {
    sdr_built run;
    scene_build(&run,
                HEAD "dimension: plane_stress\n"
                     "points: {shape: {box: {from: [0, 0], to: [1.8 m, 6 mm]}}, spacing: 1 mm, "
                     "align: cell}\n"
                     "family: {weight: surface_iso}\n"
                     "supports: [{on: left, displacement: {x: 0, y: 0}}]\n"
                     "loads: [{traction: {on: right, value: [0, -1 Pa]}}]\n"
                     "time: {integrator: static, solver: %s}\n",
                solvers[k]);
    solve(&run);
    const double sag = 4.0 * pow(1.799, 3.0) / (0.006 * 0.006 * 70e9);
    assert_near(vector_largest(run.points, run.system->u) / sag, 1.2, 0.05);
    sdr_built_destroy(&run);
  }
}

/* Cut off and pulled away: no state of rest for pcg to find. */
static void pcg_says_that_a_part_is_not_held(void **state)
{
  (void)state;
  check_failure(SDR_RUN_FAILED, "the body has no static solution: ", HOLD,
                PLATE "cracks: [{segment: {from: [20 mm, -1 mm], to: [20 mm, 21 mm]}}]\n"
                      "supports: [{on: left, displacement: {x: 0, y: 0}}]\n"
                      "loads: [{pressure: {on: right, value: 1 MPa}}]\n"
                      "time: {integrator: static, solver: pcg}\n");
}

static void a_prescribed_velocity_is_refused(void **state)
{
  (void)state;
  check_failure(SDR_BAD_INPUT,
                "a support prescribes a velocity at the point at x = 0.5 mm, y = 0.5 mm, but "
                "nothing moves in a static solution; give its displacement at time.end",
                "",
                PLATE "supports: [{on: left, displacement: {y: 0}, velocity: {x: 1 m/s}}]\n"
                      "time: {integrator: static}\n");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_bar_under_an_end_load_stretches_as_springs_in_a_row),
      cmocka_unit_test(a_nonlocal_bar_has_the_exact_strain_inside),
      cmocka_unit_test(a_uniform_gradient_spreads_from_the_border_of_a_lattice),
      cmocka_unit_test(reactions_balance_the_loads_with_every_solver),
      cmocka_unit_test(work_and_energy_agree_as_strain_vanishes),
      cmocka_unit_test(prescribed_motion_does_the_work_of_its_reactions),
      cmocka_unit_test(leapfrog_rests_in_the_static_solution),
      cmocka_unit_test(layers_carry_a_uniform_stress_up_to_the_surfaces),
      cmocka_unit_test(mirrors_that_stretch_a_plate_do_the_work_it_stores),
      cmocka_unit_test(a_body_that_nothing_holds_is_refused),
      cmocka_unit_test(three_prescribed_components_hold_a_plate),
      cmocka_unit_test(a_part_that_is_cut_off_is_named_with_a_point_of_its_own),
      cmocka_unit_test(a_slender_strip_is_not_taken_for_singular),
      cmocka_unit_test(pcg_says_that_a_part_is_not_held),
      cmocka_unit_test(a_prescribed_velocity_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
