/* A linear displacement field leaves no force on points far from surfaces: every model and weight,
 * on uniform lattices (theory sec. 5). */
#include "support/scene_text.h"

static const char *const weights[] = {"constant",
                                      "inverse",
                                      "inverse_square",
                                      "linear",
                                      "cubic",
                                      "gaussian",
                                      "partial_volume",
                                      "iso",
                                      "surface_iso",
                                      "madenci_oterkus",
                                      "[cubic, partial_volume, iso]",
                                      "[gaussian, partial_volume, surface_iso]",
                                      "[inverse, partial_volume, madenci_oterkus]"};
enum { WEIGHTS = sizeof weights / sizeof *weights };

static const double spacing = 1e-3, young = 70e9, strain = 1e-4;

static const char scene[] =
    "dimension: %s\n"
    "points: {shape: %s, spacing: 1 mm%s}\n"
    "horizon: %g spacing\n"
    "family: {weight: %s}\n"
    "material: {model: %s, young: 70 GPa, poisson: 0.3, density: 2700 kg/m^3}\n"
    "time: {step: 0.01 us, end: 1 us}\n";

/* Shear, rotation and stretch at once. */
static void set_linear(const sdr_built *built)
{
  static const double gradient[3][3] = {{1.0, 0.7, -0.2}, {-0.4, 0.5, 0.3}, {0.1, 0.6, -0.8}};
  const sdr_points *points = built->points;
  const int n = points->components;
  for (int32_t i = 0; i < points->count; ++i)
    for (int a = 0; a < n; ++a) {
      double u = 0.0;
      for (int b = 0; b < n; ++b) u += strain * gradient[a][b] * points->x[b][i];
      built->system->u[a][i] = u;
    }
}

/* 1 if no surface of the box is within two horizons; three with factors of madenci_oterkus in
   state-based bodies, where a force depends on neighbours' neighbours and these on theirs. */
static int is_inner(const sdr_built *built, int32_t i, const double half[3])
{
  const int far = built->families->axial && built->scene->model != SDR_BOND_BASED;
  const double reach = (far ? 3.0 : 2.0) * built->points->horizon[i];
  for (int a = 0; a < built->points->components; ++a)
    if (fabs(built->points->x[a][i]) > half[a] - reach) return 0;
  return 1;
}

/* Largest force on inner points over E strain spacing^2 thickness. */
static double residual(const sdr_built *built, const double half[3], int *inner)
{
  const sdr_points *points = built->points;
  const double scale = young * strain * points->volume[0] / spacing;
  double worst = 0.0;
  *inner = 0;
  built->model->ops->force(built->model, built->system->u, built->system->f);
  for (int32_t i = 0; i < points->count; ++i) {
    if (!is_inner(built, i, half)) continue;
    ++*inner;
    for (int a = 0; a < points->components; ++a)
      worst = fmax(worst, fabs(built->system->f[a][i]) / scale);
  }
  return worst;
}

static void check_model(const char *model)
{
  static const struct {
    const char *dimension, *shape, *angle;
    double ratio, half[3];
  } boxes[] = {
      {"plane_stress", "{box: {size: [28 mm, 24 mm]}}", ", angle: 0 deg", 3.015, {14e-3, 12e-3}},
      {"plane_strain", "{disc: {radius: 15 mm}}", ", angle: 20 deg", 2.5, {10e-3, 10e-3}},
      {"3d", "{box: {size: [17 mm, 16 mm, 17 mm]}}", "", 2.1, {8.5e-3, 8e-3, 8.5e-3}}};
  for (int box = 0; box < 3; ++box)
    for (int w = 0; w < WEIGHTS; w += box == 2 ? 3 : 1) { /* 3-D takes long: some of them */
      sdr_built built;
      int inner;
      scene_build(&built, scene, boxes[box].dimension, boxes[box].shape, boxes[box].angle,
                  boxes[box].ratio, weights[w], model);
      set_linear(&built);
      const double worst = residual(&built, boxes[box].half, &inner);
      assert_true(inner > 8);
      if (!(worst < 1e-10))
        fail_msg("%s, %s, %s: residual %.3g", model, boxes[box].dimension, weights[w], worst);
      sdr_built_destroy(&built);
    }
}

static void a_linear_field_leaves_no_force_in_a_bond_based_body(void **state)
{
  (void)state;
  check_model("bond_based");
}

static void a_linear_field_leaves_no_force_in_an_ordinary_body(void **state)
{
  (void)state;
  check_model("ordinary");
}

static void a_linear_field_leaves_no_force_in_a_non_ordinary_body(void **state)
{
  (void)state;
  check_model("nonordinary");
}

static void a_linear_field_leaves_no_force_in_a_non_ordinary_body_of_finite_strain(void **state)
{
  (void)state;
  check_model("nonordinary, elasticity: neo_hookean");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_linear_field_leaves_no_force_in_a_bond_based_body),
      cmocka_unit_test(a_linear_field_leaves_no_force_in_an_ordinary_body),
      cmocka_unit_test(a_linear_field_leaves_no_force_in_a_non_ordinary_body),
      cmocka_unit_test(a_linear_field_leaves_no_force_in_a_non_ordinary_body_of_finite_strain),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
