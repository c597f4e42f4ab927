/* mechanics: prescribed displacements and velocities. */
#include "mechanics/supports.h"
#include "base/memory.h"
#include "geometry/lattice.h"
#include "mechanics/schedule.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const sdr_unit plain = {0}, metre = {.m = 1}, speed = {.m = 1, .s = -1};
static sdr_material body = {.name = "body"};
static sdr_shape square = {.kind = SDR_BOX, .high = {4, 4, 0}};

typedef struct {
  sdr_scene scene;
  sdr_support_scene support[3];
  sdr_points *points;
  sdr_supports *supports;
  double values[64];
} bench;

/* The square [0, 4]^2 with 25 points. */
static void set_up(bench *b)
{
  *b = (bench){.scene = {.dimension = SDR_PLANE_STRESS,
                         .points = {.shape = &square, .spacing = 1, .thickness = 1},
                         .material_count = 1,
                         .material = &body,
                         .horizon_relative = 1}};
  b->scene.support = b->support;
  assert_int_equal(sdr_expression_create("2", plain, NULL, NULL, &b->scene.horizon), SDR_OK);
  if (sdr_lattice_points(&b->scene, &b->points)) fail_msg("%s", sdr_error_message());
  assert_int_equal(sdr_points_arrange(b->points), SDR_OK);
}

static sdr_support_scene *add_support(bench *b, const char *name, const char *face)
{
  sdr_support_scene *support = &b->support[b->scene.support_count++];
  *support = (sdr_support_scene){.schedule = {-HUGE_VAL, HUGE_VAL, 0},
                                 .depth = {0.5, 1},
                                 .origin = {"plate.yaml", 20 + b->scene.support_count, 5}};
  snprintf(support->name, sizeof support->name, "%s", name);
  snprintf(support->on.face, sizeof support->on.face, "%s", face);
  snprintf(support->on.text, sizeof support->on.text, "%s", face);
  return support;
}

static void prescribe(sdr_support_scene *support, int component, sdr_support_kind kind,
                      const char *text)
{
  support->kind[component] = kind;
  if (!text) return;
  const sdr_unit unit = kind == SDR_PRESCRIBED_VELOCITY ? speed : metre;
  sdr_expression **value = &support->value[component];
  if (sdr_expression_create(text, unit, NULL, NULL, value)) fail_msg("%s", sdr_error_message());
}

static void create(bench *b)
{
  if (sdr_supports_create(&b->scene, b->points, &b->supports)) fail_msg("%s", sdr_error_message());
  assert_true(sdr_supports_count(b->supports) <= 64);
}

static void evaluate(bench *b, double t)
{
  if (sdr_supports_values(b->supports, t, b->values)) fail_msg("%s", sdr_error_message());
}

static void tear_down(bench *b)
{
  sdr_supports_destroy(&b->supports);
  sdr_points_destroy(&b->points);
  sdr_expression_destroy(&b->scene.horizon);
  for (int k = 0; k < b->scene.support_count; ++k) {
    for (int c = 0; c < 3; ++c) sdr_expression_destroy(&b->support[k].value[c]);
  }
}

static void assert_near(double value, double wanted)
{
  if (!(fabs(value - wanted) <= 1e-14)) fail_msg("%.17g, wanted %.17g", value, wanted);
}

static void entries_come_by_point_then_component(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  sdr_support_scene *right = add_support(&b, "pull", "right"),
                    *left = add_support(&b, "hold", "left");
  prescribe(right, 1, SDR_PRESCRIBED_VELOCITY, "3 m/s");
  prescribe(left, 1, SDR_PRESCRIBED_DISPLACEMENT, NULL);
  prescribe(left, 0, SDR_PRESCRIBED_DISPLACEMENT, "2 m");
  create(&b);
  evaluate(&b, 0.0);
  assert_int_equal(sdr_supports_count(b.supports), 5 + 2 * 5);
  const sdr_prescribed *list = sdr_supports_list(b.supports);
  for (int k = 0; k < 15; ++k) {
    const int is_left = b.points->x[0][list[k].point] == 0.0;
    assert_true(is_left || b.points->x[0][list[k].point] == 4.0);
    assert_int_equal(list[k].support, is_left ? 1 : 0);
    assert_int_equal(list[k].is_velocity, is_left ? 0 : 1);
    assert_near(b.values[k], !is_left ? 3.0 : list[k].component == 0 ? 2.0 : 0.0);
    if (k == 0) continue;
    assert_true(list[k].point > list[k - 1].point ||
                (list[k].point == list[k - 1].point && list[k].component > list[k - 1].component));
  }
  tear_down(&b);
}

static void depth_counts_in_spacings_or_metres_and_includes_its_end(void **state)
{
  (void)state;
  const struct {
    sdr_length depth;
    int columns;
  } cases[] = {{{1, 1}, 2}, {{0.999, 1}, 1}, {{2, 0}, 3}, {{0, 1}, 1}, {{10, 1}, 5}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
    bench b;
    set_up(&b);
    sdr_support_scene *left = add_support(&b, "hold", "left");
    left->depth = cases[k].depth;
    prescribe(left, 0, SDR_PRESCRIBED_DISPLACEMENT, NULL);
    create(&b);
    assert_int_equal(sdr_supports_count(b.supports), 5 * cases[k].columns);
    tear_down(&b);
  }
}

static void a_volume_supports_its_points_and_the_body_all(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  sdr_shape corner = {.kind = SDR_BOX, .low = {-1, -1, 0}, .high = {1, 1, 0}};
  sdr_support_scene *support = add_support(&b, "corner", "");
  support->on.shape = &corner;
  prescribe(support, 0, SDR_PRESCRIBED_DISPLACEMENT, NULL);
  create(&b);
  assert_int_equal(sdr_supports_count(b.supports), 4);
  sdr_supports_destroy(&b.supports);
  support->on.shape = NULL;
  create(&b);
  assert_int_equal(sdr_supports_count(b.supports), 25);
  tear_down(&b);
}

static void values_follow_ramp_and_schedule(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  sdr_support_scene *left = add_support(&b, "hold", "left");
  left->schedule = (sdr_schedule){1.0, 5.0, 2.0};
  prescribe(left, 0, SDR_PRESCRIBED_DISPLACEMENT, "8 m * t / (1 s)");
  create(&b);
  const double cases[][2] = {{1.0, 0}, {2.0, 8}, {3.0, 24}, {5.0, 40}, {5.0 + 1e-15, 40}};
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
    evaluate(&b, cases[k][0]);
    for (int i = 0; i < 5; ++i) assert_true(fabs(b.values[i] - cases[k][1]) < 1e-12);
  }
  const double outside[] = {0.0, 0.999, 5.001};
  for (int k = 0; k < 3; ++k) {
    evaluate(&b, outside[k]);
    for (int i = 0; i < 5; ++i) assert_true(isnan(b.values[i]));
  }
  tear_down(&b);
}

static void a_schedule_sets_in_from_its_start_or_from_zero(void **state)
{
  (void)state;
  const sdr_schedule at_once = {2, 3, 0}, from_zero = {-HUGE_VAL, HUGE_VAL, 4};
  assert_near(sdr_schedule_share(&at_once, 2.0), 1.0);
  assert_true(isnan(sdr_schedule_share(&at_once, 1.9)));
  assert_near(sdr_schedule_share(&from_zero, -1.0), 0.0);
  assert_near(sdr_schedule_share(&from_zero, 1.0), 0.25);
  assert_near(sdr_schedule_share(&from_zero, 9.0), 1.0);
  /* 1000 steps of 0.1 us end a little off 100 us */
  double t = 0.0;
  for (int k = 0; k < 1000; ++k) t += 1e-7;
  const sdr_schedule ends = {0, 1e-4, 0};
  assert_true(t != 1e-4);
  assert_near(sdr_schedule_share(&ends, t), 1.0);
  assert_true(sdr_schedule_over(&ends, t) && !sdr_schedule_over(&ends, 0.99e-4));
}

static void formulas_see_the_reference_place(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  sdr_support_scene *left = add_support(&b, "hold", "left");
  prescribe(left, 0, SDR_PRESCRIBED_DISPLACEMENT, "y / 10");
  prescribe(left, 1, SDR_PRESCRIBED_VELOCITY, "y * t / (1 s^2)");
  create(&b);
  const sdr_prescribed *list = sdr_supports_list(b.supports);
  for (int step = 1; step <= 2; ++step) {
    evaluate(&b, step);
    for (int k = 0; k < 10; ++k) {
      const double y = b.points->x[1][list[k].point];
      assert_near(b.values[k], list[k].component == 0 ? 0.1 * y : y * step);
    }
  }
  tear_down(&b);
}

static void two_supports_for_one_component_are_refused(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  sdr_support_scene *left = add_support(&b, "hold", "left"), *top = add_support(&b, "pull", "top");
  prescribe(left, 0, SDR_PRESCRIBED_DISPLACEMENT, NULL);
  prescribe(top, 0, SDR_PRESCRIBED_VELOCITY, NULL);
  const size_t before = sdr_memory_now();
  assert_int_equal(sdr_supports_create(&b.scene, b.points, &b.supports), SDR_BAD_INPUT);
  assert_null(b.supports);
  assert_int_equal(sdr_memory_now(), before);
  assert_string_equal(sdr_error_message(),
                      "plate.yaml:22:5: support 'pull' prescribes the x component of the point at "
                      "x = 0 m, y = 4 m, and so does support 'hold' (plate.yaml:21:5) at the same "
                      "time; part their places or times");
  top->kind[0] = SDR_FREE; /* other components may share a point */
  prescribe(top, 1, SDR_PRESCRIBED_DISPLACEMENT, NULL);
  create(&b);
  assert_int_equal(sdr_supports_count(b.supports), 10);
  tear_down(&b);
}

static void one_support_may_take_over_where_another_ends(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  sdr_support_scene *late = add_support(&b, "late", "left"),
                    *early = add_support(&b, "early", "left");
  late->schedule.from = 2.0;
  early->schedule.until = 2.0;
  prescribe(late, 0, SDR_PRESCRIBED_DISPLACEMENT, "7 m");
  prescribe(early, 0, SDR_PRESCRIBED_DISPLACEMENT, "5 m");
  create(&b);
  assert_int_equal(sdr_supports_count(b.supports), 10);
  const double times[] = {1.0, 2.0, 3.0};
  for (int step = 0; step < 3; ++step) {
    evaluate(&b, times[step]);
    for (int k = 0; k < 10; ++k) {
      const int is_late = sdr_supports_list(b.supports)[k].support == 0;
      const int active = is_late ? step >= 1 : step == 0;
      assert_true(active ? b.values[k] == (is_late ? 7.0 : 5.0) : isnan(b.values[k]));
    }
  }
  sdr_supports_destroy(&b.supports);
  early->schedule.until = 2.1;
  assert_int_equal(sdr_supports_create(&b.scene, b.points, &b.supports), SDR_BAD_INPUT);
  tear_down(&b);
}

static void a_support_without_points_is_refused(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  create(&b);
  assert_int_equal(sdr_supports_count(b.supports), 0);
  evaluate(&b, 0.0);
  sdr_supports_destroy(&b.supports);
  sdr_shape away = {.kind = SDR_BOX, .low = {9, 9, 0}, .high = {10, 10, 0}};
  sdr_support_scene *support = add_support(&b, "grip", "");
  support->on.shape = &away;
  snprintf(support->on.text, sizeof support->on.text, "away");
  prescribe(support, 0, SDR_PRESCRIBED_DISPLACEMENT, NULL);
  assert_int_equal(sdr_supports_create(&b.scene, b.points, &b.supports), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "plate.yaml:21:5: support 'grip' meets no point: 'away' "
                                           "holds none; choose a place in the body");
  snprintf(support->on.face, sizeof support->on.face, "left");
  snprintf(support->on.text, sizeof support->on.text, "away.left");
  assert_int_equal(sdr_supports_create(&b.scene, b.points, &b.supports), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "plate.yaml:21:5: support 'grip' meets no point: 'away.left' holds none; "
                      "choose a place in the body or a larger depth");
  tear_down(&b);
}

static void a_formula_that_is_not_finite_names_the_support(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  sdr_support_scene *left = add_support(&b, "hold", "left");
  prescribe(left, 1, SDR_PRESCRIBED_DISPLACEMENT, "1 m * (1 m) / y");
  assert_int_equal(sdr_supports_create(&b.scene, b.points, &b.supports), SDR_BAD_INPUT);
  const char *start = "plate.yaml:21:5: support 'hold', y component: ";
  assert_memory_equal(sdr_error_message(), start, strlen(start));
  tear_down(&b);
}

static void running_out_of_memory_is_reported_and_leaks_nothing(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  prescribe(add_support(&b, "hold", "left"), 0, SDR_PRESCRIBED_DISPLACEMENT, NULL);
  const size_t before = sdr_memory_now();
  sdr_status status = SDR_RUN_FAILED;
  for (long allowed = 0; status != SDR_OK; ++allowed) {
    sdr_memory_fail_after(allowed);
    status = sdr_supports_create(&b.scene, b.points, &b.supports);
    sdr_memory_fail_after(-1);
    assert_true(status == SDR_OK || (status == SDR_RUN_FAILED && !b.supports));
    sdr_supports_destroy(&b.supports);
    assert_int_equal(sdr_memory_now(), before);
    assert_true(allowed < 20);
  }
  tear_down(&b);
}

/* Each component of a support with `mean` is one mean of all its points. */
static void means_are_numbered_by_support_and_component(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  sdr_support_scene *right = add_support(&b, "pull", "right"),
                    *left = add_support(&b, "hold", "left");
  prescribe(right, 0, SDR_PRESCRIBED_DISPLACEMENT, "3 m/s*t");
  prescribe(right, 1, SDR_PRESCRIBED_VELOCITY, "2 m/s");
  prescribe(left, 0, SDR_PRESCRIBED_DISPLACEMENT, NULL);
  right->mean = 1;
  create(&b);
  evaluate(&b, 2.0);
  assert_int_equal(sdr_supports_means(b.supports), 2);
  const sdr_prescribed *list = sdr_supports_list(b.supports);
  for (int32_t k = 0; k < sdr_supports_count(b.supports); ++k) {
    assert_int_equal(list[k].mean, list[k].support == 0 ? list[k].component : -1);
    if (list[k].mean == 0) assert_near(b.values[k], 6.0);
  }
  tear_down(&b);
}

static void a_mean_has_no_place(void **state)
{
  (void)state;
  bench b;
  set_up(&b);
  sdr_support_scene *right = add_support(&b, "pull", "right");
  prescribe(right, 1, SDR_PRESCRIBED_DISPLACEMENT, "2 + x");
  right->mean = 1;
  assert_int_equal(sdr_supports_create(&b.scene, b.points, &b.supports), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "plate.yaml:21:5: support 'pull' prescribes a mean, which has no place: let "
                      "its y component be a number or a formula of t");
  tear_down(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(entries_come_by_point_then_component),
      cmocka_unit_test(depth_counts_in_spacings_or_metres_and_includes_its_end),
      cmocka_unit_test(a_volume_supports_its_points_and_the_body_all),
      cmocka_unit_test(values_follow_ramp_and_schedule),
      cmocka_unit_test(a_schedule_sets_in_from_its_start_or_from_zero),
      cmocka_unit_test(formulas_see_the_reference_place),
      cmocka_unit_test(two_supports_for_one_component_are_refused),
      cmocka_unit_test(one_support_may_take_over_where_another_ends),
      cmocka_unit_test(a_support_without_points_is_refused),
      cmocka_unit_test(a_formula_that_is_not_finite_names_the_support),
      cmocka_unit_test(means_are_numbered_by_support_and_component),
      cmocka_unit_test(a_mean_has_no_place),
      cmocka_unit_test(running_out_of_memory_is_reported_and_leaks_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
