/* KINSOL, which solves for equilibrium without minimising an energy, beside the minimisation. */
#include "support/scene_text.h"

/* A bar that is pulled until its weak middle has softened; peak force at the moved end, N, and what
   is dissipated, J. */
static void pull(const char *solver, double end, double *peak, double *dissipated)
{
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
  *peak = 0.0;
  while (run.system->time < end - 1e-12) {
    run_step(&run);
    *peak = fmax(*peak, sdr_system_reaction(run.system, 1, 0));
  }
  if (strcmp(solver, "auto") != 0) assert_string_equal(run.system->solve.name, solver);
  run.model->ops->energies(run.model, run.system->u, &energies);
  *dissipated = energies.dissipated;
  sdr_built_destroy(&run);
}

/* At the peak the path branches: the minimisation goes to where damage localises most, KINSOL to
   the equilibrium that its Newton steps meet, which takes 3 % more. */
static void kinsol_finds_the_same_peak_and_an_equilibrium_beyond(void **state)
{
  (void)state;
  double peak, dissipated, other_peak, other_dissipated;
  pull("auto", 0.5, &peak, &dissipated);
  pull("kinsol", 0.5, &other_peak, &other_dissipated);
  assert_near(other_peak, peak, 1e-6 * peak);
  assert_true(other_dissipated >= dissipated && other_dissipated < 1.05 * dissipated);
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
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(kinsol_finds_the_same_peak_and_an_equilibrium_beyond),
      cmocka_unit_test(a_linear_solution_has_no_use_for_kinsol)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
