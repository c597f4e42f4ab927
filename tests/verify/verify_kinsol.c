/* KINSOL, which solves for equilibrium without minimising an energy, beside the minimisation. */
#include "support/scene_text.h"

typedef struct {
  double peak, last, dissipated; /* force at the moved end, N; J */
} path;

/* A bar that is pulled until its weak middle has softened. */
static path pull(const char *solver, double end)
{
  path p = {0};
  sdr_built run;
  sdr_energies energies;
  scene_build(&run,
              "title: t\n"
              "dimension: plane_stress\n"
              "points: {shape: {box: {from: [0, 0], to: [24 mm, 6 mm]}}, spacing: 1.5 mm, align: "
              "cell}\n"
              "horizon: 2.015 spacing\n"
              "damage: {law: variational}\n"
              "materials:\n"
              "  - {name: strong, young: 30 GPa, density: 2400 kg/m^3, toughness: 200 J/m^2}\n"
              "  - {name: weak, where: {box: {from: [10.5 mm, 0], to: [13.5 mm, 6 mm]}}, young: 30 "
              "GPa, density: 2400 kg/m^3, toughness: 20 J/m^2}\n"
              "supports:\n"
              "  - {name: wall, on: left, depth: 3 mm, displacement: [0, 0]}\n"
              "  - {name: pull, on: right, depth: 3 mm, displacement: {x: 30 um*t/(1 s)}}\n"
              "output: {snapshots: 0}\n"
              "time: {integrator: static, end: %g s, step: 25 ms, solver: %s}\n",
              end, solver);
  run_start(&run);
  while (run.system->time < end - 1e-12) {
    run_step(&run);
    p.last = sdr_system_reaction(run.system, 1, 0);
    p.peak = fmax(p.peak, p.last);
  }
  if (strcmp(solver, "auto") != 0) assert_string_equal(run.system->solve.name, solver);
  run.model->ops->energies(run.model, run.system->u, &energies);
  p.dissipated = energies.dissipated;
  sdr_built_destroy(&run);
  return p;
}

/* Past the peak too, where motion helps Newton's method over what is no minimum; on that way a
   little less is dissipated. */
static void kinsol_comes_to_the_same_peak_and_end(void **state)
{
  (void)state;
  const path least = pull("auto", 0.5), other = pull("kinsol", 0.5);
  assert_near(other.peak, least.peak, 1e-6 * least.peak);
  assert_near(other.last, least.last, 1e-5 * least.last);
  assert_near(other.dissipated, least.dissipated, 0.02 * least.dissipated);
}

static void a_linear_solution_has_no_use_for_kinsol(void **state)
{
  (void)state;
  sdr_built run;
  assert_int_equal(scene_try(&run, "title: t\n"
                                   "dimension: 1d\n"
                                   "points: {shape: {interval: {from: 0 m, to: 9 m}}, spacing: 1 "
                                   "m}\n"
                                   "material: {young: 1 Pa, density: 1 kg/m^3}\n"
                                   "supports: [{on: left, displacement: {x: 0}}]\n"
                                   "time: {integrator: static, linear: true, solver: kinsol}\n"),
                   SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), "relaxation and kinsol find nonlinear equilibria"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(kinsol_comes_to_the_same_peak_and_end),
                                     cmocka_unit_test(a_linear_solution_has_no_use_for_kinsol)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
