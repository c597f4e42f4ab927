/* Layers of fictitious points outside flat faces (theory sec. 6): uniform strain up to the surface,
   symmetry, and the books of energy and momentum. */
#include "support/scene_text.h"

static const char material[] = "material: {young: 200 GPa, density: 7850 kg/m^3}\n";
static const char ordinary[] =
    "material: {model: ordinary, young: 200 GPa, poisson: 0.2, density: 7850 kg/m^3}\n";

static const char nonordinary[] =
    "material: {model: nonordinary, young: 200 GPa, poisson: 0.2, density: 7850 kg/m^3}\n";

/* Largest force on a point of the body, over that of stress 200 MPa on the side of its cell. */
static double residual_of(const char *scene, const char *model)
{
  sdr_built built;
  scene_build(&built, "%s%stime: {end: 1 us}\n", scene, model);
  run_start(&built);
  const sdr_points *points = built.points;
  double *out = sdr_alloc((size_t)points->count, sizeof *out), most = 0.0, scale = 0.0;
  for (int32_t i = 0; i < points->count; ++i) {
    for (int a = 0; a < points->components; ++a) most = fmax(most, fabs(built.system->f[a][i]));
    scale = fmax(scale, 200e6 * points->volume[i] / points->spacing[i]);
    if (!sdr_in_body(points, i))
      for (int a = 0; a < points->components; ++a) assert_true(built.system->f[a][i] == 0.0);
  }
  sdr_free(out);
  sdr_built_destroy(&built);
  return most / scale;
}

static double residual(const char *scene)
{
  return residual_of(scene, material);
}

static void uniform_strain_between_mirrors_leaves_no_force_up_to_the_surface(void **state)
{
  (void)state;
  assert_at_most(
      residual("dimension: 1d\n"
               "points: {shape: {interval: {from: 0, to: 40 mm}}, spacing: 1 mm, align: cell}\n"
               "initial: {displacement: [0.001*x + 1e-4]}\n"
               "supports:\n"
               "- {on: left, layer: mirror, displacement: [0.001*x + 1e-4]}\n"
               "- {on: right, layer: mirror, displacement: [0.001*x + 1e-4]}\n"),
      1e-10);
  static const char *const plates[] = {"", ", refine: [{where: body, spacing: 0.5 mm}]"};
  static const char *const weights[] = {"constant", "partial_volume", "iso"};
  for (int refined = 0; refined < 2; ++refined)
    for (int w = 0; w < 3; ++w) {
      char text[2000];
      snprintf(text, sizeof text,
               "dimension: plane_stress\n"
               "points: {shape: {box: {from: [0, 0], to: [20 mm, 16 mm]}}, spacing: 1 mm, align: "
               "cell%s}\n"
               "family: {weight: %s}\n"
               "initial: {displacement: [0.001*x + 2e-4*y, 5e-4*y - 1e-4*x]}\n"
               "supports:\n"
               "- {on: left, layer: mirror, displacement: [0.001*x + 2e-4*y, 5e-4*y - 1e-4*x]}\n"
               "- {on: right, layer: mirror, displacement: [0.001*x + 2e-4*y, 5e-4*y - 1e-4*x]}\n"
               "- {on: top, layer: mirror, displacement: [0.001*x + 2e-4*y, 5e-4*y - 1e-4*x]}\n"
               "- {on: bottom, layer: mirror, displacement: [0.001*x + 2e-4*y, 5e-4*y - 1e-4*x]}\n",
               plates[refined], weights[w]);
      assert_at_most(residual(text), 1e-10);
      assert_at_most(residual_of(text, ordinary), 1e-10);
      if (w == 0 && !refined) assert_at_most(residual_of(text, nonordinary), 1e-10);
    }
}

static void uniform_strain_of_a_turned_plate_and_of_a_block_leaves_no_force(void **state)
{
  (void)state;
#define TURNED "displacement: [0.001*x + 2e-4*y, 5e-4*y - 1e-4*x]"
  assert_at_most(
      residual("dimension: plane_strain\n"
               "points: {shape: {box: {size: [14 mm, 12 mm], angle: 30 deg}}, spacing: 1 "
               "mm, align: cell, angle: 30 deg}\n"
               "initial: {" TURNED "}\n"
               "supports:\n"
               "- {on: left, layer: mirror, " TURNED "}\n"
               "- {on: right, layer: mirror, " TURNED "}\n"
               "- {on: top, layer: mirror, " TURNED "}\n"
               "- {on: bottom, layer: mirror, " TURNED "}\n"),
      1e-10);
#define SOLID "displacement: [0.001*x + 2e-4*y, 5e-4*y - 1e-4*z, 3e-4*x - 2e-4*z]"
  assert_at_most(
      residual(
          "dimension: 3d\n"
          "points: {shape: {box: {from: [0, 0, 0], to: [8 mm, 8 mm, 8 mm]}}, spacing: 1 mm, align: "
          "cell}\n"
          "horizon: 2 spacing\n"
          "initial: {" SOLID "}\n"
          "supports:\n"
          "- {on: left, layer: mirror, " SOLID "}\n"
          "- {on: right, layer: mirror, " SOLID "}\n"
          "- {on: top, layer: mirror, " SOLID "}\n"
          "- {on: bottom, layer: mirror, " SOLID "}\n"
          "- {on: front, layer: mirror, " SOLID "}\n"
          "- {on: back, layer: mirror, " SOLID "}\n"),
      1e-10);
}

/* The traction's strain is that of linear elasticity, so what remains is of the order of the
   strain. 225 GPa 1e-8 and 75 GPa 1e-8: uniaxial strain; shear 75 GPa. */
static void a_uniform_stress_between_traction_layers_leaves_no_force(void **state)
{
  (void)state;
  assert_at_most(
      residual("dimension: 1d\n"
               "points: {shape: {interval: {from: 0, to: 40 mm}}, spacing: 1 mm, align: cell}\n"
               "initial: {displacement: [1e-8*x]}\n"
               "supports: [{on: left, layer: mirror, displacement: [0]}]\n"
               "loads: [{traction: {on: right, layer: fictitious, value: [2 kPa]}}]\n"),
      1e-10);
  static const char plate[] =
      "dimension: plane_stress\n"
      "points: {shape: {box: {from: [0, 0], to: [20 mm, 16 mm]}}, spacing: 1 mm, align: cell}\n"
      "family: {weight: iso}\n"
      "initial: {displacement: [1e-8*x + 1e-8*y, 2e-8*y]}\n"
      "supports: [{on: left, layer: mirror, displacement: [1e-8*x + 1e-8*y, 2e-8*y]}]\n"
      "loads:\n"
      "- traction: {on: right, layer: fictitious, value: [3.75 kPa, 0.75 kPa]}\n"
      "- traction: {on: top, layer: fictitious, value: [0.75 kPa, 5.25 kPa]}\n"
      "- traction: {on: bottom, layer: fictitious, value: [-0.75 kPa, -5.25 kPa]}\n";
  static const char *const models[] = {
      "material: {young: 200 GPa, density: 7850 kg/m^3}\n",
      "material: {model: ordinary, young: 200 GPa, poisson: 1/3, density: 7850 kg/m^3}\n",
      "material: {model: nonordinary, young: 200 GPa, poisson: 1/3, density: 7850 kg/m^3}\n"};
  for (int m = 0; m < 3; ++m) assert_at_most(residual_of(plate, models[m]), 1e-10);
}

/* ---- motion ---------------------------------------------------------------------------------- */

static const char moving[] =
    "dimension: plane_stress\n"
    "points: {shape: {box: {from: [0, 0], to: [20 mm, 12 mm]}}, spacing: 1 mm, align: "
    "cell}\n"
    "horizon: 3.015 spacing\n"
    "initial: {velocity: [\"10*sin(150*x)\", \"-8*cos(200*y)\"]}\n"
    "supports:\n"
    "- {on: left, layer: mirror, displacement: [\"1e-5*sin(2e5*t)^2\", "
    "\"1e-3*x*(1 - cos(1e5*t))\"]}\n"
    "- {on: top, layer: mirror, displacement: {y: \"2e-6*sin(1e5*t)\"}}\n";

static void the_energy_of_a_body_with_a_moving_mirror_balances_to_second_order(void **state)
{
  (void)state;
  double imbalance[3];
  for (int k = 0; k < 3; ++k) {
    sdr_built built;
    scene_build(&built, "%s%stime: {end: 40 us, step: %.6g us}\n", moving, material,
                0.1 / (1 << k));
    imbalance[k] = run_imbalance(&built, 40e-6, 0.8e-6);
    sdr_built_destroy(&built);
  }
  assert_at_most(imbalance[0], 3e-3);
  assert_near(log2(imbalance[0] / imbalance[1]), 2.0, 0.2);
  assert_near(log2(imbalance[1] / imbalance[2]), 2.0, 0.2);
}

static void check_momentum(const char *scene)
{
  sdr_built built;
  sdr_balance start, now;
  scene_build(&built, "%s%stime: {end: 40 us, step: 0.2 us}\n", scene, material);
  run_start(&built);
  sdr_system_balance(built.system, &start);
  for (int n = 0; n < 200; ++n) run_step(&built);
  sdr_system_balance(built.system, &now);
  double moved = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double gained = now.momentum[c] - start.momentum[c];
    assert_near(gained, built.system->impulse[c], 1e-11 * now.momentum_scale);
    assert_near(now.angular[c] - start.angular[c], built.system->angular_impulse[c],
                1e-11 * now.angular_scale);
    moved = fmax(moved, fabs(gained));
  }
  assert_true(moved > 0.01 * now.momentum_scale);
  sdr_built_destroy(&built);
}

static void momentum_and_angular_momentum_close_with_the_layers_impulse(void **state)
{
  (void)state;
  check_momentum(moving);
  check_momentum(
      "dimension: plane_stress\n"
      "points: {shape: {box: {from: [0, 0], to: [20 mm, 12 mm]}}, spacing: 1 mm, align: cell}\n"
      "loads:\n"
      "- traction: {on: right, layer: fictitious, value: [\"40e6*sin(1e5*t)\", 10 MPa], "
      "ramp: 5 us}\n"
      "supports: [{on: left, layer: mirror, displacement: [0, 0]}]\n");
}

static void a_held_mirror_does_no_work(void **state)
{
  (void)state;
  sdr_built built;
  scene_build(
      &built,
      "dimension: plane_stress\n"
      "points: {shape: {box: {from: [0, 0], to: [20 mm, 12 mm]}}, spacing: 1 mm, align: cell}\n"
      "initial: {velocity: [\"10*sin(150*x)\", \"-8*sin(150*x)*sin(200*y)\"]}\n"
      "supports: [{on: left, layer: mirror, displacement: [0, 0]}, {on: bottom, layer: "
      "mirror, displacement: {y: 0}}]\n%stime: {end: 100 us, step: 0.1 us}\n",
      material);
  assert_at_most(run_imbalance(&built, 100e-6, 1e-6), 5e-3);
  sdr_balance now;
  sdr_system_balance(built.system, &now);
  assert_at_most(fabs(built.system->external_work), 1e-12 * balance_energy(&now));
  sdr_built_destroy(&built);
}

/* Displacement of the point nearest to (x, y). */
static double at(const sdr_built *built, double x, double y, int component)
{
  const double place[3] = {x, y, 0.0};
  return built->system->u[component][sdr_points_nearest(built->points, place)];
}

static void half_a_body_on_a_mirror_moves_like_the_whole(void **state)
{
  (void)state;
  static const char *const text =
      "dimension: plane_stress\n"
      "points: {shape: {box: {from: [%s, 0], to: [16 mm, 12 mm]}}, spacing: 1 mm, align: cell}\n"
      "material: {young: 70 GPa, density: 2500 kg/m^3, toughness: 100 J/m^2}\n"
      "damage: {law: variational}\n"
      "initial: {velocity: [\"100*sin(400*x)\", \"-80*cos(300*x)*y/0.01\"]}\n"
      "%stime: {end: 20 us, step: 0.1 us}\n";
  sdr_built half, whole;
  scene_build(&half, text, "0", "supports: [{on: left, layer: mirror, displacement: {x: 0}}]\n");
  scene_build(&whole, text, "-16 mm", "");
  run_start(&half);
  run_start(&whole);
  for (int n = 0; n < 200; ++n) {
    run_step(&half);
    run_step(&whole);
  }
  for (double x = 0.5e-3; x < 16e-3; x += 1e-3)
    for (double y = 0.5e-3; y < 12e-3; y += 1e-3)
      for (int c = 0; c < 2; ++c) assert_near(at(&half, x, y, c), at(&whole, x, y, c), 1e-9);
  sdr_balance half_now, whole_now;
  sdr_system_balance(half.system, &half_now);
  sdr_system_balance(whole.system, &whole_now);
  assert_near(half_now.kinetic, 0.5 * whole_now.kinetic, 1e-6 * whole_now.kinetic);
  assert_near(half_now.model.stored, 0.5 * whole_now.model.stored, 1e-6 * whole_now.model.stored);
  assert_near(half_now.model.dissipated, 0.5 * whole_now.model.dissipated,
              1e-6 * whole_now.model.dissipated);
  assert_true(half_now.model.max_damage > 0.1);
  sdr_built_destroy(&half);
  sdr_built_destroy(&whole);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(uniform_strain_between_mirrors_leaves_no_force_up_to_the_surface),
      cmocka_unit_test(uniform_strain_of_a_turned_plate_and_of_a_block_leaves_no_force),
      cmocka_unit_test(a_uniform_stress_between_traction_layers_leaves_no_force),
      cmocka_unit_test(the_energy_of_a_body_with_a_moving_mirror_balances_to_second_order),
      cmocka_unit_test(momentum_and_angular_momentum_close_with_the_layers_impulse),
      cmocka_unit_test(a_held_mirror_does_no_work),
      cmocka_unit_test(half_a_body_on_a_mirror_moves_like_the_whole),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
