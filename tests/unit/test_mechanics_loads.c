/* mechanics: forces from outside. */
#include "mechanics/loads.h"
#include "base/memory.h"
#include "geometry/lattice.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const sdr_unit plain = {0}, pascal = {-1, 1, -2, 0}, newton = {1, 1, -2, 0},
                      density = {-2, 1, -2, 0};
static sdr_material body = {.name = "body"};
static const sdr_schedule always = {-1e30, 1e30, 0};

/* A scene of one shape with its points. */
typedef struct {
  sdr_scene scene;
  sdr_load load[3];
  sdr_points *points;
  sdr_loads *loads;
} bench;

static void set_up(bench *b, sdr_shape *shape, sdr_dimension dimension, double spacing)
{
  *b = (bench){.scene = {.dimension = dimension,
                         .points = {.shape = shape, .spacing = spacing, .thickness = 1},
                         .material_count = 1,
                         .material = &body,
                         .horizon_relative = 1}};
  b->scene.load = b->load;
  assert_int_equal(sdr_expression_create("2", plain, NULL, NULL, &b->scene.horizon), SDR_OK);
}

static sdr_expression *formula(const char *text, sdr_unit unit)
{
  sdr_expression *expression = NULL;
  if (sdr_expression_create(text, unit, NULL, NULL, &expression))
    fail_msg("%s", sdr_error_message());
  return expression;
}

static sdr_load *add_load(bench *b, sdr_load_kind kind, const char *face)
{
  sdr_load *load = &b->load[b->scene.load_count++];
  *load = (sdr_load){.kind = kind,
                     .schedule = always,
                     .origin = {"ring.yaml", 10 + b->scene.load_count, 5},
                     .on = {.origin = {"ring.yaml", 10 + b->scene.load_count, 20}}};
  snprintf(load->on.face, sizeof load->on.face, "%s", face);
  snprintf(load->on.text, sizeof load->on.text, "%s", face);
  return load;
}

static void create(bench *b)
{
  if (!b->points) {
    if (sdr_lattice_points(&b->scene, &b->points)) fail_msg("%s", sdr_error_message());
    assert_int_equal(sdr_points_arrange(b->points), SDR_OK);
  }
  if (sdr_loads_create(&b->scene, b->points, &b->loads)) fail_msg("%s", sdr_error_message());
}

static void tear_down(bench *b)
{
  sdr_loads_destroy(&b->loads);
  sdr_points_destroy(&b->points);
  sdr_expression_destroy(&b->scene.horizon);
  for (int k = 0; k < b->scene.load_count; ++k) {
    for (int c = 0; c < 3; ++c) sdr_expression_destroy(&b->load[k].value[c]);
  }
}

static double total(const bench *b, int component)
{
  double sum = 0.0;
  const double *force = sdr_loads_force(b->loads, component);
  for (int32_t k = 0; k < sdr_loads_count(b->loads); ++k) sum += force[k];
  return sum;
}

static void evaluate(bench *b, double t)
{
  if (sdr_loads_evaluate(b->loads, t)) fail_msg("%s", sdr_error_message());
}

static void assert_near(double value, double wanted, double tolerance)
{
  if (!(fabs(value - wanted) <= tolerance)) fail_msg("%.17g, wanted %.17g", value, wanted);
}

static void assert_refused(bench *b, const char *message)
{
  const size_t before = sdr_memory_now();
  assert_int_equal(sdr_loads_create(&b->scene, b->points, &b->loads), SDR_BAD_INPUT);
  assert_null(b->loads);
  assert_string_equal(sdr_error_message(), message);
  assert_int_equal(sdr_memory_now(), before);
}

static void pressure_in_a_ring_is_balanced_radial_and_complete(void **state)
{
  (void)state;
  bench b;
  sdr_shape ring = {.kind = SDR_ANNULUS, .inner = 0.081, .outer = 0.149};
  set_up(&b, &ring, SDR_PLANE_STRESS, 0.001);
  b.scene.points.thickness = 0.01;
  add_load(&b, SDR_PRESSURE, "inner")->value[0] = formula("400 MPa * exp(-t/(100 us))", pascal);
  create(&b);
  evaluate(&b, 50e-6);
  const double wanted = 400e6 * exp(-0.5) * 2 * pi * 0.081 * 0.01;
  const double *fx = sdr_loads_force(b.loads, 0), *fy = sdr_loads_force(b.loads, 1);
  double radial = 0.0, moment = 0.0;
  for (int32_t k = 0; k < sdr_loads_count(b.loads); ++k) {
    const int32_t i = sdr_loads_points(b.loads)[k];
    const double x = b.points->x[0][i], y = b.points->x[1][i], r = hypot(x, y);
    if (k > 0) assert_true(i > sdr_loads_points(b.loads)[k - 1]);
    assert_true(r < 0.081 + 0.001);
    assert_true(fx[k] * x + fy[k] * y > 0.0); /* the pressure widens the ring */
    radial += (fx[k] * x + fy[k] * y) / r;
    moment += x * fy[k] - y * fx[k];
  }
  assert_near(total(&b, 0), 0.0, 1e-10 * wanted);
  assert_near(total(&b, 1), 0.0, 1e-10 * wanted);
  /* the points lie within 0.4 degrees of their pieces' normals: 1 - cos = 2e-5 */
  assert_near(radial, wanted, 3e-5 * wanted);
  assert_true(radial < wanted);
  assert_near(moment, 0.0, 1e-6 * wanted * 0.081);
  tear_down(&b);
}

static void pressure_pushes_against_the_normal_with_exact_total(void **state)
{
  (void)state;
  const struct {
    sdr_dimension dimension;
    double thickness, area;
  } cases[] = {{SDR_1D, 0.5, 0.5}, {SDR_PLANE_STRAIN, 0.5, 2 * 0.5}, {SDR_3D, 0.5, 2 * 3}};
  for (int k = 0; k < 3; ++k) {
    bench b;
    sdr_shape box = {.kind = SDR_BOX, .high = {1, k > 0 ? 2 : 0, k > 1 ? 3 : 0}};
    set_up(&b, &box, cases[k].dimension, 0.25);
    b.scene.points.thickness = cases[k].thickness;
    add_load(&b, SDR_PRESSURE, "left")->value[0] = formula("10", pascal);
    create(&b);
    evaluate(&b, 0.0);
    assert_near(total(&b, 0), 10 * cases[k].area, 1e-11);
    for (int c = 1; c < sdr_components(cases[k].dimension); ++c) assert_near(total(&b, c), 0, 0);
    assert_int_equal(sdr_loads_count(b.loads), k == 0 ? 1 : k == 1 ? 9 : 9 * 13);
    tear_down(&b);
  }
}

static void ends_of_a_straight_edge_get_half_a_share(void **state)
{
  (void)state;
  bench b;
  sdr_shape box = {.kind = SDR_BOX, .high = {1, 1, 0}};
  set_up(&b, &box, SDR_PLANE_STRESS, 0.25);
  add_load(&b, SDR_TRACTION, "right")->value[1] = formula("8", pascal);
  create(&b);
  evaluate(&b, 0.0);
  assert_int_equal(sdr_loads_count(b.loads), 5);
  for (int32_t k = 0; k < 5; ++k) {
    const double y = b.points->x[1][sdr_loads_points(b.loads)[k]];
    assert_near(sdr_loads_force(b.loads, 1)[k], y == 0.0 || y == 1.0 ? 1.0 : 2.0, 1e-12);
    assert_near(sdr_loads_force(b.loads, 0)[k], 0.0, 0.0);
  }
  tear_down(&b);
}

static void a_layer_shares_each_piece_equally(void **state)
{
  (void)state;
  bench b;
  sdr_shape bar = {.kind = SDR_BOX, .high = {1, 0, 0}};
  set_up(&b, &bar, SDR_1D, 0.25);
  sdr_load *load = add_load(&b, SDR_TRACTION, "right");
  load->value[0] = formula("6", pascal);
  load->spread_layer = 1;
  create(&b);
  evaluate(&b, 0.0);
  assert_int_equal(sdr_loads_count(b.loads), 2); /* at the face and one spacing behind it */
  assert_near(sdr_loads_force(b.loads, 0)[0], 3.0, 1e-14);
  assert_near(sdr_loads_force(b.loads, 0)[1], 3.0, 1e-14);
  tear_down(&b);

  sdr_shape box = {.kind = SDR_BOX, .high = {1, 1, 0}};
  set_up(&b, &box, SDR_PLANE_STRESS, 0.125);
  load = add_load(&b, SDR_TRACTION, "right");
  load->value[0] = formula("6", pascal);
  load->spread_layer = 1;
  create(&b);
  evaluate(&b, 0.0);
  assert_near(total(&b, 0), 6.0, 1e-12);
  /* a piece lies between two points of the surface and a little farther from those behind */
  assert_int_equal(sdr_loads_count(b.loads), 9);
  for (int k = 0; k < 9; ++k) {
    assert_near(sdr_loads_force(b.loads, 0)[k], k == 0 || k == 8 ? 6.0 / 16 : 6.0 / 8, 1e-12);
  }
  tear_down(&b);
}

/* The same pressure written as f(x), f(t) and f(x, t) takes three ways through the code. */
static void formulas_of_place_and_time_agree(void **state)
{
  (void)state;
  static const char *const texts[3] = {"3 Pa * y / (1 m)", "3 Pa * t / (1 s)",
                                       "3 Pa * y * t / (1 m) / (1 s)"};
  sdr_shape box = {.kind = SDR_BOX, .high = {1, 2, 0}};
  for (int k = 0; k < 3; ++k) {
    bench b;
    set_up(&b, &box, SDR_PLANE_STRESS, 0.25);
    add_load(&b, SDR_PRESSURE, "left")->value[0] = formula(texts[k], pascal);
    create(&b);
    for (int step = 1; step <= 2; ++step) {
      evaluate(&b, 4.0 * step);
      /* integral of y over 0..2 is 2; of 1 it is 2 */
      const double wanted = k == 0 ? 6.0 : 24.0 * step;
      assert_near(total(&b, 0), wanted, 1e-10);
    }
    if (k != 1) {
      const int32_t last = sdr_loads_count(b.loads) - 1; /* at y = 2: the top half cell */
      const double scale = k == 0 ? 1.0 : 8.0;
      assert_near(sdr_loads_force(b.loads, 0)[last], scale * 3 * 0.125 * (2 - 0.0625), 1e-10);
    }
    tear_down(&b);
  }
}

static void body_forces_weigh_the_volume(void **state)
{
  (void)state;
  bench b;
  sdr_shape box = {.kind = SDR_BOX, .high = {1, 1, 0}};
  sdr_shape half = {.kind = SDR_BOX, .low = {0, 0.6, 0}, .high = {1, 1, 0}};
  set_up(&b, &box, SDR_PLANE_STRESS, 0.25);
  b.scene.points.thickness = 2;
  add_load(&b, SDR_BODY_FORCE, "")->value[1] = formula("-7", density);
  sdr_load *upper = add_load(&b, SDR_BODY_FORCE, "");
  upper->value[0] = formula("1 N/m^3 * x / (1 m)", density);
  upper->on.shape = &half;
  create(&b);
  evaluate(&b, 0.0);
  assert_int_equal(sdr_loads_count(b.loads), 25);
  assert_near(total(&b, 1), -7 * 25 * 0.0625 * 2, 1e-12);
  assert_near(total(&b, 0), 2 * 2.5 * 0.0625 * 2, 1e-12); /* two rows, x sums to 2.5 in each */
  tear_down(&b);
}

static void a_point_force_goes_to_the_nearest_point(void **state)
{
  (void)state;
  bench b;
  sdr_shape box = {.kind = SDR_BOX, .high = {1, 1, 1}};
  set_up(&b, &box, SDR_3D, 0.25);
  sdr_load *load = add_load(&b, SDR_POINT_FORCE, "");
  const double at[3] = {0.26, 0.5, 1.1};
  memcpy(load->at, at, sizeof at);
  load->value[2] = formula("5 N * t / (1 s)", newton);
  create(&b);
  evaluate(&b, 2.0);
  assert_int_equal(sdr_loads_count(b.loads), 1);
  const int32_t i = sdr_loads_points(b.loads)[0];
  assert_true(b.points->x[0][i] == 0.25 && b.points->x[1][i] == 0.5 && b.points->x[2][i] == 1.0);
  assert_near(sdr_loads_force(b.loads, 2)[0], 10.0, 1e-14);
  assert_near(sdr_loads_force(b.loads, 0)[0], 0.0, 0.0);
  tear_down(&b);
}

static void loads_add_up_and_follow_their_schedules(void **state)
{
  (void)state;
  bench b;
  sdr_shape bar = {.kind = SDR_BOX, .high = {1, 0, 0}};
  set_up(&b, &bar, SDR_1D, 0.25);
  sdr_load *first = add_load(&b, SDR_TRACTION, "right"),
           *second = add_load(&b, SDR_TRACTION, "right");
  first->value[0] = formula("10", pascal);
  first->schedule = (sdr_schedule){1.0, 3.0, 0.5};
  second->value[0] = formula("100", pascal);
  second->schedule = (sdr_schedule){-HUGE_VAL, HUGE_VAL, 4.0}; /* a ramp from t = 0 */
  create(&b);
  assert_near(sdr_loads_force(b.loads, 0)[0], 0.0, 0.0);
  const double cases[][2] = {{0.0, 0},       {1.0, 25},       {1.25, 31.25 + 5}, {1.5, 37.5 + 10},
                             {3.0, 75 + 10}, {3.001, 75.025}, {4.0, 100},        {9.0, 100}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
    evaluate(&b, cases[k][0]);
    assert_near(sdr_loads_force(b.loads, 0)[0], cases[k][1], 1e-12);
  }
  tear_down(&b);
}

static void a_hole_named_as_a_region_is_pushed_open_too(void **state)
{
  (void)state;
  bench b;
  sdr_shape parts[2] = {{.kind = SDR_BOX, .low = {-2, -2, 0}, .high = {2, 2, 0}},
                        {.kind = SDR_DISC, .outer = 1}};
  sdr_shape plate = {.kind = SDR_DIFFERENCE, .part_count = 2, .parts = parts};
  sdr_shape hole = parts[1];
  for (int way = 0; way < 2; ++way) {
    set_up(&b, &plate, SDR_PLANE_STRESS, 0.1);
    sdr_load *load = add_load(&b, SDR_PRESSURE, "rim");
    load->value[0] = formula("1", pascal);
    if (way == 1) load->on.shape = &hole;
    create(&b);
    evaluate(&b, 0.0);
    double radial = 0.0;
    for (int32_t k = 0; k < sdr_loads_count(b.loads); ++k) {
      const int32_t i = sdr_loads_points(b.loads)[k];
      const double x = b.points->x[0][i], y = b.points->x[1][i];
      radial +=
          (sdr_loads_force(b.loads, 0)[k] * x + sdr_loads_force(b.loads, 1)[k] * y) / hypot(x, y);
    }
    assert_near(radial, 2 * pi, 0.01);
    tear_down(&b);
  }
}

static void refined_faces_are_loaded_at_every_fine_point(void **state)
{
  (void)state;
  bench b;
  sdr_shape box = {.kind = SDR_BOX, .high = {1, 1, 0}};
  sdr_shape strip = {.kind = SDR_BOX, .high = {0.25, 1, 0}};
  sdr_refine refine = {.where = {.shape = &strip}, .spacing = 0.25 / 16};
  set_up(&b, &box, SDR_PLANE_STRESS, 0.25);
  b.scene.points.cell_centred[0] = b.scene.points.cell_centred[1] = 1;
  b.scene.points.refine_count = 1;
  b.scene.points.refine = &refine;
  add_load(&b, SDR_TRACTION, "left")->value[0] = formula("1", pascal);
  create(&b);
  evaluate(&b, 0.0);
  assert_int_equal(sdr_loads_count(b.loads), 64);
  for (int k = 0; k < 64; ++k) assert_near(sdr_loads_force(b.loads, 0)[k], 1.0 / 64, 1e-13);
  tear_down(&b);
}

static void loads_without_points_are_refused(void **state)
{
  (void)state;
  bench b;
  sdr_shape box = {.kind = SDR_BOX, .high = {1, 1, 0}};
  sdr_shape away = {.kind = SDR_BOX, .low = {3, 0, 0}, .high = {4, 1, 0}};
  set_up(&b, &box, SDR_PLANE_STRESS, 0.25);
  create(&b);
  assert_int_equal(sdr_loads_count(b.loads), 0);
  evaluate(&b, 0.0);
  sdr_loads_destroy(&b.loads);

  sdr_load *load = add_load(&b, SDR_PRESSURE, "left");
  load->on.shape = &away;
  snprintf(load->on.text, sizeof load->on.text, "away.left");
  assert_refused(&b, "ring.yaml:11:5: the pressure on 'away.left' meets no point at x = 3 m, "
                     "y = 15.625 mm: the face lies more than 2 spacings from every point there; "
                     "load a face of the body");
  load->on.face[0] = '\0';
  snprintf(load->on.text, sizeof load->on.text, "away");
  assert_refused(&b, "ring.yaml:11:20: a pressure acts on a face, and 'away' is a volume; its "
                     "faces are: left, right, bottom, top");
  snprintf(load->on.face, sizeof load->on.face, "rim");
  assert_refused(&b, "ring.yaml:11:20: pressure: no face 'rim'; the faces here are: left, right, "
                     "bottom, top");
  load->kind = SDR_BODY_FORCE;
  load->on.face[0] = '\0';
  assert_refused(&b, "ring.yaml:11:5: the body force on 'away' meets no point; choose a place in "
                     "the body");
  load->kind = SDR_POINT_FORCE;
  load->at[0] = 3;
  assert_refused(&b, "ring.yaml:11:5: the point force at x = 3 m, y = 0 m meets no point: none "
                     "lies within 2 spacings");
  tear_down(&b);
}

static void a_formula_that_is_not_finite_names_the_load(void **state)
{
  (void)state;
  bench b;
  sdr_shape bar = {.kind = SDR_BOX, .high = {1, 0, 0}};
  set_up(&b, &bar, SDR_1D, 0.25);
  add_load(&b, SDR_PRESSURE, "left")->value[0] = formula("1 Pa * (1 s) / (t - 2 s)", pascal);
  create(&b);
  assert_int_equal(sdr_loads_evaluate(b.loads, 1.0), SDR_OK);
  assert_int_equal(sdr_loads_evaluate(b.loads, 2.0), SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), "ring.yaml:11:5: pressure: "));
  tear_down(&b);
}

static void running_out_of_memory_is_reported_and_leaks_nothing(void **state)
{
  (void)state;
  bench b;
  sdr_shape ring = {.kind = SDR_ANNULUS, .inner = 1, .outer = 2};
  set_up(&b, &ring, SDR_PLANE_STRESS, 0.1);
  create(&b);
  sdr_loads_destroy(&b.loads);
  add_load(&b, SDR_PRESSURE, "inner")->value[0] = formula("1 Pa * x * t / (1 m) / (1 s)", pascal);
  const size_t before = sdr_memory_now();
  sdr_status status = SDR_RUN_FAILED;
  for (long allowed = 0; status != SDR_OK; ++allowed) {
    sdr_memory_fail_after(allowed);
    status = sdr_loads_create(&b.scene, b.points, &b.loads);
    sdr_memory_fail_after(-1);
    assert_true(status == SDR_OK || (status == SDR_RUN_FAILED && !b.loads));
    sdr_loads_destroy(&b.loads);
    assert_int_equal(sdr_memory_now(), before);
    assert_true(allowed < 40);
  }
  tear_down(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pressure_in_a_ring_is_balanced_radial_and_complete),
      cmocka_unit_test(pressure_pushes_against_the_normal_with_exact_total),
      cmocka_unit_test(ends_of_a_straight_edge_get_half_a_share),
      cmocka_unit_test(a_layer_shares_each_piece_equally),
      cmocka_unit_test(formulas_of_place_and_time_agree),
      cmocka_unit_test(body_forces_weigh_the_volume),
      cmocka_unit_test(a_point_force_goes_to_the_nearest_point),
      cmocka_unit_test(loads_add_up_and_follow_their_schedules),
      cmocka_unit_test(a_hole_named_as_a_region_is_pushed_open_too),
      cmocka_unit_test(refined_faces_are_loaded_at_every_fine_point),
      cmocka_unit_test(loads_without_points_are_refused),
      cmocka_unit_test(a_formula_that_is_not_finite_names_the_load),
      cmocka_unit_test(running_out_of_memory_is_reported_and_leaks_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
