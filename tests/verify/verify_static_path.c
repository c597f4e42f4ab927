/* Nonlinear statics: paths through peaks and breakage, their reactions and books, and what stops.
 */
#include "support/scene_text.h"

#define HEAD                                                                                       \
  "title: t\n"                                                                                     \
  "output: {snapshots: 0}\n"                                                                       \
  "dimension: plane_stress\n"

#define PLATE                                                                                      \
  HEAD "points: {shape: {box: {from: [0, 0], to: [40 mm, 20 mm]}}, spacing: 4 mm, align: cell}\n"

#define CONCRETE "material: {young: 30 GPa, density: 2400 kg/m^3, toughness: 50 J/m^2}\n"

/* A strip pulled at both ends; its middle is weak. */
#define STRIP                                                                                      \
  HEAD "points: {shape: {box: {from: [0, 0], to: [36 mm, 9 mm]}}, spacing: 1.5 mm, align: cell}\n" \
       "horizon: 2.015 spacing\n"                                                                  \
       "damage: {law: %s}\n"                                                                       \
       "materials:\n"                                                                              \
       "  - {name: strong, %s young: 30 GPa, density: 2400 kg/m^3, toughness: 200 J/m^2}\n"        \
       "  - {name: weak, where: {box: {from: [16.5 mm, 0], to: [19.5 mm, 9 mm]}}, young: 30 GPa, " \
       "%s density: 2400 kg/m^3, toughness: 20 J/m^2}\n"                                           \
       "supports:\n"                                                                               \
       "  - {name: wall, on: left, depth: 3 mm, displacement: [0, 0]}\n"                           \
       "  - {name: pull, on: right, depth: 3 mm, displacement: {x: 40 um*t/(1 s)}}\n"              \
       "time: {integrator: static, end: 1 s, step: 50 ms%s}\n"

/* What the forces on free points come to, over those of the supports. */
static double unbalanced(const sdr_built *run)
{
  const sdr_system *system = run->system;
  const sdr_prescribed *list = sdr_supports_list(run->supports);
  double free_sum = 0.0, held_sum = 0.0;
  system->model->ops->force(system->model, system->u, system->f);
  for (int32_t k = 0; k < sdr_supports_count(run->supports); ++k) {
    double *f = &system->f[list[k].component][list[k].point];
    if (!isnan(system->motion[k])) {
      *f += system->reaction[k];
      held_sum += system->reaction[k] * system->reaction[k];
    }
  }
  for (int a = 0; a < system->components; ++a)
    for (int32_t i = 0; i < system->count; ++i) free_sum += system->f[a][i] * system->f[a][i];
  return sqrt(free_sum / held_sum);
}

typedef struct {
  double peak, last;            /* N */
  double energy, work, viscous; /* J, at the end */
  double worst_residual;
} path;

/* All increments, with the force of support `pull` along x. */
static path follow(const sdr_built *run)
{
  path p = {0};
  sdr_energies energies;
  run_start(run);
  while (run->system->time < run->scene->time.end * (1.0 - 1e-12)) {
    run_step(run);
    p.last = sdr_system_reaction(run->system, 1, 0);
    p.peak = fmax(p.peak, p.last);
    p.worst_residual = fmax(p.worst_residual, unbalanced(run));
  }
  run->model->ops->energies(run->model, run->system->u, &energies);
  p.energy = energies.stored + energies.dissipated;
  p.work = run->system->external_work;
  p.viscous = run->system->viscous;
  return p;
}

static path follow_strip(sdr_built *run, const char *law, const char *model, const char *poisson,
                         const char *more)
{
  char first[200];
  snprintf(first, sizeof first, "%s %s", model, poisson);
  scene_build(run, STRIP, law, first, poisson, more);
  return follow(run);
}

/* ---- through the peak ------------------------------------------------------------------------ */

static void check_softening(const path *p)
{
  assert_true(p->last > 0.0 && p->last < 0.5 * p->peak);
  assert_true(p->worst_residual < 2e-6);
  assert_true(fabs(p->energy + p->viscous - p->work) < 5e-3 * p->energy);
}

static void a_strip_softens_past_its_peak_in_balance(void **state)
{
  (void)state;
  sdr_built run;
  const path p = follow_strip(&run, "variational", "", "", "");
  check_softening(&p);
  assert_true(run.system->solve.accepted >= 20);
  assert_true(run.system->solve.newton > run.system->solve.accepted);
  sdr_built_destroy(&run);
}

static void relaxation_finds_the_same_path(void **state)
{
  (void)state;
  sdr_built run;
  const path newton = follow_strip(&run, "variational", "", "", "");
  sdr_built_destroy(&run);
  const path other = follow_strip(&run, "variational", "", "", ", solver: relaxation");
  assert_string_equal(run.system->solve.name, "relaxation");
  sdr_built_destroy(&run);
  assert_near(other.peak, newton.peak, 1e-4 * newton.peak);
  assert_near(other.last, newton.last, 1e-3 * newton.peak);
  assert_near(other.energy, newton.energy, 1e-3 * newton.energy);
}

static void state_based_strips_soften_too(void **state)
{
  (void)state;
  static const char *const models[] = {"model: ordinary,", "model: nonordinary,"};
  for (int k = 0; k < 2; ++k) {
    sdr_built run;
    const path p = follow_strip(&run, "variational", models[k], "poisson: 0.2,", "");
    assert_true(p.last < 0.7 * p.peak);
    assert_true(p.worst_residual < 2e-6);
    assert_true(fabs(p.energy + p.viscous - p.work) < 5e-3 * p.energy);
    sdr_built_destroy(&run);
  }
}

/* ---- critical stretch ------------------------------------------------------------------------ */

/* Bonds break until none is overstretched; what that sets free is viscous. */
static void critical_stretch_breaks_the_most_overstretched_first(void **state)
{
  (void)state;
  sdr_built run;
  const path p = follow_strip(&run, "critical_stretch", "", "", "");
  assert_true(p.last < 0.05 * p.peak);
  assert_true(p.viscous > 0.0);
  assert_true(fabs(p.energy + p.viscous - p.work) < 1e-3 * p.work);
  assert_int_equal(run.model->ops->break_most(run.model, run.system->u, 0.98), 0);
  sdr_built_destroy(&run);
}

static void state_based_strips_break_by_stretch_too(void **state)
{
  (void)state;
  static const char *const models[] = {"model: ordinary,", "model: nonordinary,"};
  for (int k = 0; k < 2; ++k) {
    sdr_built run;
    const path p = follow_strip(&run, "critical_stretch", models[k], "poisson: 0.2,", "");
    assert_true(p.last < 0.05 * p.peak);
    assert_true(p.viscous > 0.0);
    assert_true(fabs(p.energy + p.viscous - p.work) < 1e-3 * p.work);
    assert_int_equal(run.model->ops->break_most(run.model, run.system->u, 0.98), 0);
    sdr_built_destroy(&run);
  }
}

/* ---- means ----------------------------------------------------------------------------------- */

static void check_mean(const char *time, double tolerance)
{
  sdr_built run;
  scene_build(&run,
              PLATE CONCRETE "supports:\n"
                             "  - {name: wall, on: left, displacement: [0, 0]}\n"
                             "  - {name: pull, on: right, mean: true, displacement: {x: 1 um, y: 2 "
                             "um*t/(1 ms)}}\n"
                             "time: {end: 1 ms, %s}\n",
              time);
  run_start(&run);
  while (run.system->time < 1e-3 * (1.0 - 1e-12)) run_step(&run);
  const sdr_prescribed *list = sdr_supports_list(run.supports);
  double pull[2] = {0.0}, wall[2] = {0.0}, each[2] = {0.0};
  for (int32_t k = 0; k < sdr_supports_count(run.supports); ++k) {
    const int a = list[k].component;
    if (list[k].mean < 0) {
      wall[a] += run.system->reaction[k];
      continue;
    }
    if (each[a] != 0.0) assert_near(run.system->reaction[k], each[a], 1e-6 * fabs(each[a]));
    each[a] = run.system->reaction[k];
    pull[a] += each[a];
  }
  assert_near(sdr_system_mean(run.system, 0, run.system->u), 1e-6, 1e-12);
  assert_near(sdr_system_mean(run.system, 1, run.system->u), 2e-6 * run.system->time / 1e-3, 1e-12);
  for (int a = 0; a < 2; ++a)
    if (tolerance > 0.0) assert_near(pull[a], -wall[a], tolerance * fabs(pull[a]));
  if (tolerance > 0.0) assert_true(pull[0] > 0.0 && pull[1] > 0.0);
  sdr_built_destroy(&run);
}

static void a_mean_is_kept_and_pulls_each_of_its_points_alike(void **state)
{
  (void)state;
  check_mean("integrator: static", 1e-9);
  check_mean("integrator: static, linear: false", 1e-5);
  check_mean("integrator: leapfrog", 0.0);
}

/* A mean of all points ties each to every other one; the factor must not be filled by that. Held
   along x by its mean alone, beside held by a strip on the left, which hinders its contraction a
   little. */
static void a_mean_of_the_whole_body_is_kept_at_the_cost_of_none(void **state)
{
  (void)state;
  static const char *const holds[] = {"  - {on: plate, mean: true, displacement: {x: 0}}\n",
                                      "  - {on: left, depth: 4 mm, displacement: {x: 0}}\n"};
  double bytes[2], energy[2], newton[2];
  for (int k = 0; k < 2; ++k) {
    sdr_built run;
    sdr_energies energies;
    scene_build(&run,
                HEAD
                "points: {shape: {box: {from: [0, 0], to: [60 mm, 40 mm]}}, spacing: 2 mm, align: "
                "cell}\n" CONCRETE "damage: {law: variational}\n"
                "regions: {plate: {box: {from: [0, 0], to: [60 mm, 40 mm]}}}\n"
                "supports:\n"
                "  - {on: plate.bottom, depth: 6 mm, displacement: {y: 0}}\n"
                "  - {on: plate.top, depth: 6 mm, displacement: {y: 6 um*t/(1 s)}}\n"
                "%s"
                "time: {integrator: static, linear: false, end: 1 s, step: 250 ms}\n",
                holds[k]);
    run_start(&run);
    while (run.system->time < 1.0 - 1e-12) run_step(&run);
    run.model->ops->energies(run.model, run.system->u, &energies);
    energy[k] = energies.stored + energies.dissipated;
    bytes[k] = run.system->solve.bytes;
    newton[k] = (double)run.system->solve.newton;
    if (k == 0) assert_near(sdr_system_mean(run.system, 0, run.system->u), 0.0, 1e-15);
    sdr_built_destroy(&run);
  }
  assert_true(energy[0] < energy[1]); /* it may contract on both sides */
  assert_true(energy[0] > 0.9 * energy[1]);
  assert_true(bytes[0] < 1.3 * bytes[1]);
  assert_true(newton[0] < 1.5 * newton[1] + 4.0);
}

/* ---- no answer nearby ------------------------------------------------------------------------ */

/* A support lets go: the body swings, damped, to where it is at rest. */
static void motion_takes_the_body_where_statics_cannot(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, PLATE CONCRETE
              "supports:\n"
              "  - {name: wall, on: left, displacement: [0, 0]}\n"
              "  - {name: pull, on: right, displacement: {x: 1 um*t/(1 s)}, until: 0.5 s}\n"
              "time: {integrator: static, linear: false, end: 1 s, step: 250 ms}\n");
  run_start(&run);
  while (run.system->time < 1.0 - 1e-12) run_step(&run);
  sdr_energies energies;
  run.model->ops->energies(run.model, run.system->u, &energies);
  assert_int_equal(run.system->solve.fallbacks, 1);
  assert_true(run.system->external_work > 0.0);
  assert_near(run.system->viscous, run.system->external_work, 1e-2 * run.system->external_work);
  assert_true(energies.stored < 1e-6 * run.system->external_work);
  sdr_built_destroy(&run);
}

static void a_load_that_nothing_carries_stops_the_run(void **state)
{
  (void)state;
  sdr_built run;
  scene_build(&run, PLATE CONCRETE "damage: {law: variational}\n"
                                   "supports: [{on: left, displacement: [0, 0]}]\n"
                                   "loads: [{traction: {on: right, value: [100 MPa*t/(1 s), 0]}}]\n"
                                   "time: {integrator: static, end: 1 s, step: 100 ms}\n");
  run_start(&run);
  sdr_status status = SDR_OK;
  while (status == SDR_OK && run.system->time < 1.0 - 1e-12)
    status = run.integrator->step(run.system, run.step);
  assert_int_equal(status, SDR_RUN_FAILED);
  const char *message = sdr_error_message();
  assert_non_null(strstr(message, "no equilibrium was found at t = "));
  assert_non_null(strstr(message, " increments: the point at x = "));
  assert_non_null(strstr(message, "prescribe displacements (or their mean) in place of loads that "
                                  "nothing can carry any more"));
  sdr_built_destroy(&run);
}

/* Points of layers are slaved and without mass: what moves them does the work, and its sum is the
   reaction of their support. */
static void moving_mirrors_do_the_work_that_the_body_stores(void **state)
{
  (void)state;
  static const char *const times[] = {"integrator: static, linear: false, end: 1 s, step: 0.25 s",
                                      "integrator: energy_momentum, end: 1 s, step: 10 ms"};
  for (size_t k = 0; k < sizeof times / sizeof *times; ++k) {
    sdr_built run;
    sdr_balance balance;
    scene_build(&run,
                HEAD "points: {shape: {box: {from: [0, 0], to: [20 mm, 10 mm]}}, spacing: 1 mm, "
                     "align: cell}\n"
                     "material: {young: 1 GPa, density: 1e9 kg/m^3}\n"
                     "supports:\n"
                     "  - {on: left, layer: mirror, displacement: {x: 0}}\n"
                     "  - {on: right, layer: mirror, displacement: {x: 1 um*t/(1 s)}}\n"
                     "  - {on: bottom, layer: mirror, displacement: {y: 0}}\n"
                     "time: {%s}\n",
                times[k]);
    run_start(&run);
    while (run.system->time < 1.0 - 1e-9) run_step(&run);
    sdr_system_balance(run.system, &balance);
    const double energy = balance_energy(&balance);
    assert_true(energy > 1e-5);
    assert_true(fabs(energy - run.system->external_work) < 2e-6 * energy);
    assert_true(sdr_system_reaction(run.system, 1, 0) > 100.0);
    if (k > 0) /* statics has no velocities */
      assert_true(fabs(balance.momentum[0] - run.system->impulse[0]) <
                  1e-9 * balance.momentum_scale);
    sdr_built_destroy(&run);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_strip_softens_past_its_peak_in_balance),
      cmocka_unit_test(relaxation_finds_the_same_path),
      cmocka_unit_test(state_based_strips_soften_too),
      cmocka_unit_test(critical_stretch_breaks_the_most_overstretched_first),
      cmocka_unit_test(state_based_strips_break_by_stretch_too),
      cmocka_unit_test(a_mean_is_kept_and_pulls_each_of_its_points_alike),
      cmocka_unit_test(a_mean_of_the_whole_body_is_kept_at_the_cost_of_none),
      cmocka_unit_test(moving_mirrors_do_the_work_that_the_body_stores),
      cmocka_unit_test(motion_takes_the_body_where_statics_cannot),
      cmocka_unit_test(a_load_that_nothing_carries_stops_the_run),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
