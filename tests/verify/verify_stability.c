/* Bodies pushed to where formulas lose their meaning: bonds of length zero, bonds turned round,
   other units, places far from the origin. */
#include "support/cmocka_all.h"

#include "app/build.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void build(const char *text, sdr_built *out)
{
  char path[] = "/tmp/sunder_stability_XXXXXX";
  const int file = mkstemp(path);
  assert_true(file >= 0 && write(file, text, strlen(text)) == (ssize_t)strlen(text));
  close(file);
  const sdr_status status = sdr_build(path, NULL, 0, NULL, out);
  unlink(path);
  if (status != SDR_OK) fail_msg("%s", sdr_error_message());
}

/* ---- strains --------------------------------------------------------------------------------- */

static const char *const models[] = {
    "material: {young: 210 GPa, density: 7850 kg/m^3}\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3}\nprecision: mixed\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3}\nfamily: {weight: surface_iso}\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3, toughness: 1e4 J/m^2}\n"
    "damage: {law: variational}\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3, toughness: 1e4 J/m^2}\n"
    "damage: {law: critical_stretch}\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3, toughness: 1e4 J/m^2}\n"
    "damage: {law: at1}\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3, model: ordinary, poisson: 0.3}\n",
    "material: {young: 210 GPa, density: 7850 kg/m^3, model: nonordinary, poisson: 0.3}\n"};
enum { MODELS = sizeof models / sizeof *models };

static void build_strained(const char *model, double strain, sdr_built *out)
{
  char text[1200];
  snprintf(text, sizeof text,
           "dimension: plane_stress\n"
           "points: {shape: {box: {size: [12 mm, 9 mm]}}, spacing: 1 mm, align: cell}\n%s"
           "initial: {displacement: [\"%.17g*x\", 0]}\n"
           "time: {step: auto, safety: 0.3, end: 5 us}\noutput: {snapshots: 0}\n",
           model, strain);
  build(text, out);
}

static double largest_force(const char *model, double strain)
{
  sdr_built run;
  double most = 0.0;
  build_strained(model, strain, &run);
  assert_int_equal(run.integrator->start(run.system, run.step), SDR_OK);
  for (int32_t i = 0; i < run.system->count; ++i)
    for (int c = 0; c < 2; ++c) {
      assert_true(isfinite(run.system->f[c][i]));
      most = fmax(most, fabs(run.system->f[c][i]));
    }
  sdr_built_destroy(&run);
  return most;
}

/* At a strain of -1 the ends of all bonds along x are in one place, but for what rounding leaves;
   the force that such a direction gets is no larger than beside it. */
static void a_bond_of_length_zero_pushes_no_harder_than_a_short_one(void **state)
{
  (void)state;
  for (size_t m = 0; m < MODELS; ++m) {
    const double near = largest_force(models[m], -0.999), there = largest_force(models[m], -1.0);
    if (!(there < 3.0 * near)) fail_msg("%s%g N, beside it %g N", models[m], there, near);
  }
}

static double energy_of(sdr_built *run)
{
  sdr_balance balance;
  sdr_system_balance(run->system, &balance);
  return balance.kinetic + balance.model.stored + balance.model.dissipated;
}

static void bodies_strained_to_double_length_or_turned_inside_out_keep_their_energy(void **state)
{
  (void)state;
  static const double strains[] = {1.0, -0.5, -1.5, -2.5};
  for (size_t m = 0; m < MODELS; ++m)
    for (size_t k = 0; k < sizeof strains / sizeof *strains; ++k) {
      sdr_built run;
      build_strained(models[m], strains[k], &run);
      assert_int_equal(run.integrator->start(run.system, run.step), SDR_OK);
      const double start = energy_of(&run);
      for (int step = 0; step < 40; ++step)
        assert_int_equal(run.integrator->step(run.system, run.step), SDR_OK);
      const double off = fabs(energy_of(&run) / start - 1.0);
      if (!(off < 0.03)) fail_msg("%sstrain %g: %g of the energy", models[m], strains[k], off);
      sdr_built_destroy(&run);
    }
}

/* ---- units and places ------------------------------------------------------------------------ */

typedef struct {
  double length, time, mass, away;
} measure;

/* Energies over the unit of energy, and two displacements over that of length, after 60 steps. */
static void run_ring(const measure *in, double out[5])
{
  char text[1600];
  sdr_built run;
  sdr_balance balance;
  const double l = in->length, t = in->time, stress = in->mass / (l * t * t);
  const double energy = in->mass * l * l / (t * t);
  snprintf(text, sizeof text,
           "dimension: plane_stress\n"
           "points: {shape: {annulus: {inner: %.17g, outer: %.17g, centre: [%.17g, 0]}}, spacing: "
           "%.17g, origin: [%.17g, 0], thickness: %.17g}\n"
           "material: {young: %.17g, density: %.17g, toughness: %.17g}\n"
           "damage: {law: variational}\n"
           "loads: [{pressure: {on: inner, value: \"%.17g Pa*exp(-t/(%.17g s))\"}}]\n"
           "time: {step: %.17g, end: %.17g}\noutput: {snapshots: 0}\n",
           0.081 * l, 0.149 * l, in->away, 0.008 * l, in->away, l, 210e9 * stress,
           7850 * in->mass / (l * l * l), 2e4 * in->mass / (t * t), 4e8 * stress, 1e-4 * t,
           1e-6 * t, 60e-6 * t);
  build(text, &run);
  assert_int_equal(run.integrator->start(run.system, run.step), SDR_OK);
  for (int step = 0; step < 60; ++step)
    assert_int_equal(run.integrator->step(run.system, run.step), SDR_OK);
  sdr_system_balance(run.system, &balance);
  out[0] = balance.kinetic / energy;
  out[1] = balance.model.stored / energy;
  out[2] = balance.model.dissipated / energy;
  out[3] = run.system->u[0][7] / l;
  out[4] = run.system->u[1][run.system->count / 3] / l;
  sdr_built_destroy(&run);
}

static void expect_same_ring(const measure *in, const double base[5], double most)
{
  double out[5];
  run_ring(in, out);
  assert_true(base[2] > 0.0);
  for (int k = 0; k < 5; ++k)
    if (!(fabs(out[k] - base[k]) <= most * fabs(base[k])))
      fail_msg("number %d: %.17g, not %.17g", k, out[k], base[k]);
}

static void other_units_give_the_same_answer(void **state)
{
  (void)state;
  static const measure units[] = {{1e12, 1, 1, 0},  {1e-12, 1, 1, 0}, {1, 1e12, 1, 0},
                                  {1, 1e-12, 1, 0}, {1, 1, 1e12, 0},  {1, 1, 1e-12, 0}};
  const measure si = {1, 1, 1, 0};
  double base[5];
  run_ring(&si, base);
  for (size_t k = 0; k < sizeof units / sizeof *units; ++k)
    expect_same_ring(&units[k], base, 1e-10);
}

/* Bonds are told by the lattice and displacements count from the points' own places, so nothing is
   lost where coordinates have seven digits less. */
static void a_body_far_from_the_origin_moves_as_one_there(void **state)
{
  (void)state;
  const measure there = {1, 1, 1, 0}, far = {1, 1, 1, 1e6};
  double base[5];
  run_ring(&there, base);
  expect_same_ring(&far, base, 1e-10);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_bond_of_length_zero_pushes_no_harder_than_a_short_one),
      cmocka_unit_test(bodies_strained_to_double_length_or_turned_inside_out_keep_their_energy),
      cmocka_unit_test(other_units_give_the_same_answer),
      cmocka_unit_test(a_body_far_from_the_origin_moves_as_one_there),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
