/* A body split in two has dissipated the toughness times horizon/ell, per area, whatever the
   lattice's direction: within its known 4.5 % at m = 3.015 (theory sec. 3). */
#include "damage/calibration.h"
#include "mechanics/bond_based.h"
#include "support/scene_text.h"

static const char *const strip =
    "dimension: plane_stress\n"
    "points:\n"
    "  shape: {box: {from: [-6 mm, 0], to: [6 mm, %g mm]}}\n"
    "  spacing: 1 mm\n"
    "  angle: %g deg\n"
    "  origin: [0.5 mm, 0]\n" /* a plane x = 0 passes between the rows of a straight lattice */
    "materials:\n"
    "  - {young: 70 GPa, density: 2500 kg/m^3, toughness: 100 J/m^2, scatter: {young: %g %%}}\n"
    "  - {name: right, where: {box: {from: [0, -1 m], to: [1 m, 1 m]}}, young: %g GPa,\n"
    "     density: 2500 kg/m^3, toughness: %g J/m^2, scatter: {young: %g %%}}\n"
    "damage: {law: %s%s}\n"
    "time: {end: 1 us}\n";

typedef struct {
  const char *law, *ell;
  double angle, scatter, young, toughness; /* of the right half: GPa, J/m^2 */
} split_how;

/* Open the plane x = 0 rigidly by `from` to `to` metres, each time `growth` as far as before. */
static void open_crack(const sdr_built *run, double from, double to, double growth)
{
  sdr_system *system = run->system;
  const double *x = run->points->x[0];
  double before = 0.0;
  for (double gap = from; gap < growth * to; gap *= growth) {
    for (int32_t i = 0; i < system->count; ++i) {
      system->u[0][i] = x[i] > 0.0 ? gap : 0.0;
      system->v[0][i] = x[i] > 0.0 ? gap - before : 0.0; /* a step of 1 s led here */
    }
    run->model->ops->force_commit(run->model, system->u, system->v, 1.0, system->f);
    before = gap;
  }
}

static double dissipated(const split_how *how, double length)
{
  sdr_built run;
  scene_build(&run, strip, length * 1e3, how->angle, how->scatter, how->young, how->toughness,
              how->scatter, how->law, how->ell);
  /* Bonds of critical stretch break between two steps, and take the product of both stretches; the
     variational law minds no step, but takes all only far beyond s_c. */
  if (strcmp(how->law, "variational") == 0)
    open_crack(&run, 1e-3, 1.0, 10.0);
  else
    open_crack(&run, 5e-7, 5e-4, 1.01);
  sdr_energies e;
  run.model->ops->energies(run.model, run.system->u, &e);
  assert_at_most(e.stored, 1e-4 * e.dissipated);
  sdr_built_destroy(&run);
  return e.dissipated;
}

/* Dissipated energy per area, J/m^2: the difference of two lengths is free of end effects. */
static double separation(const split_how *how)
{
  return (dissipated(how, 0.4) - dissipated(how, 0.1)) / 0.3;
}

/* What sdr_separation_energy says of the left half. */
static double predicted(const split_how *how)
{
  sdr_built run;
  scene_build(&run, strip, 20.0, how->angle, 0.0, how->young, how->toughness, 0.0, how->law,
              how->ell);
  const sdr_family *family = run.families->family;
  const double c = sdr_micromodulus(SDR_PLANE_STRESS, SDR_CALIBRATE_FAMILY, family, 70e9);
  const double q =
      sdr_critical_stretch_squared(SDR_PLANE_STRESS, SDR_CALIBRATE_FAMILY, family, 70e9, 100.0);
  const double share = run.scene->damage.law == SDR_LAW_VARIATIONAL && how->ell[0] ? 0.5 : 1.0;
  const double normal[3] = {1.0, 0.0, 0.0};
  double energy;
  assert_int_equal(sdr_separation_energy(run.families, family, c, q * share, normal, &energy),
                   SDR_OK);
  sdr_built_destroy(&run);
  return energy;
}

static const double angles[] = {0.0, 22.5, 45.0};

static void each_angle(split_how how, double expected)
{
  for (int k = 0; k < 3; ++k) {
    how.angle = angles[k];
    const double energy = separation(&how);
    print_message("%s%s at %g degrees: %.4f of %g J/m^2\n", how.law, how.ell, how.angle,
                  energy / expected, expected);
    assert_near(energy / expected, 1.0, 0.045);
    if (how.toughness != 100.0) continue;
    assert_near(energy, predicted(&how), 0.01 * expected);
  }
}

static void variational_takes_the_toughness_with_ell_of_one_horizon(void **state)
{
  (void)state;
  each_angle((split_how){"variational", "", 0.0, 0.0, 70.0, 100.0}, 100.0);
}

static void variational_takes_half_the_toughness_with_ell_of_two_horizons(void **state)
{
  (void)state;
  each_angle((split_how){"variational", ", ell: 2 horizon", 0.0, 0.0, 70.0, 100.0}, 50.0);
}

static void critical_stretch_takes_the_toughness(void **state)
{
  (void)state;
  each_angle((split_how){"critical_stretch", "", 0.0, 0.0, 70.0, 100.0}, 100.0);
}

static void scatter_of_the_modulus_changes_nothing(void **state)
{
  (void)state;
  each_angle((split_how){"variational", "", 0.0, 5.0, 70.0, 100.0}, 100.0);
  each_angle((split_how){"critical_stretch", "", 0.0, 5.0, 70.0, 100.0}, 100.0);
}

/* Every bond across has half of its energy from each side. */
static void an_interface_takes_the_mean_of_both_materials(void **state)
{
  (void)state;
  each_angle((split_how){"variational", "", 0.0, 0.0, 7.0, 400.0}, 250.0);
  each_angle((split_how){"critical_stretch", "", 0.0, 0.0, 7.0, 400.0}, 250.0);
}

/* Over all directions: theory sec. 3 has 0.960 to 1.013 in 2-D and 0.972 to 1.021 in 3-D. */
static void over_all_directions_a_cut_takes_what_theory_says(void **state)
{
  (void)state;
  for (int d = 0; d < 2; ++d) {
    const body_how how = {.dimension = d ? SDR_3D : SDR_PLANE_STRESS,
                          .cells = {7, 7, d ? 7 : 1},
                          .law = SDR_LAW_CRITICAL_STRETCH};
    body b = body_create(&how);
    double least = INFINITY, most = 0.0;
    for (int p = 0; p <= 90; ++p)
      for (int t = d ? 0 : 45; t <= 45; ++t) {
        const double polar = d ? t * 1.0 * 3.14159265358979 / 90.0 : 3.14159265358979 / 2.0;
        const double round = p * 3.14159265358979 / 180.0;
        const double normal[3] = {sin(polar) * cos(round), sin(polar) * sin(round), cos(polar)};
        double energy;
        assert_int_equal(sdr_separation_energy(b.families, b.families->family,
                                               body_micromodulus(&b, 0), body_threshold(&b, 0),
                                               normal, &energy),
                         SDR_OK);
        least = fmin(least, energy / b.toughness[0]);
        most = fmax(most, energy / b.toughness[0]);
      }
    print_message("%d-D: %.4f to %.4f\n", d + 2, least, most);
    assert_near(least, d ? 0.972 : 0.960, 0.0015);
    assert_near(most, d ? 1.021 : 1.013, 0.0015);
    body_destroy(&b);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(variational_takes_the_toughness_with_ell_of_one_horizon),
      cmocka_unit_test(variational_takes_half_the_toughness_with_ell_of_two_horizons),
      cmocka_unit_test(critical_stretch_takes_the_toughness),
      cmocka_unit_test(scatter_of_the_modulus_changes_nothing),
      cmocka_unit_test(an_interface_takes_the_mean_of_both_materials),
      cmocka_unit_test(over_all_directions_a_cut_takes_what_theory_says),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
