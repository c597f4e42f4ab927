/* geometry: which places shapes hold, and the boxes around them. */
#include "geometry/shape.h"
#include "geometry/place.h"
#include "geometry/text.h"
#include "support/cmocka_all.h"

#include <math.h>

static int holds(const sdr_shape *shape, double x, double y, double z)
{
  return sdr_shape_contains(shape, (double[3]){x, y, z}, 1e-9);
}

static void assert_bounds(const sdr_shape *shape, double low_x, double high_x, double low_y,
                          double high_y)
{
  double low[3], high[3];
  sdr_shape_bounds(shape, low, high);
  assert_true(fabs(low[0] - low_x) < 1e-12 && fabs(high[0] - high_x) < 1e-12);
  assert_true(fabs(low[1] - low_y) < 1e-12 && fabs(high[1] - high_y) < 1e-12);
}

static void every_primitive_is_closed_within_the_tolerance(void **state)
{
  (void)state;
  const double corner[] = {0, 0, 2, 0, 0, 2};
  const sdr_shape shapes[] = {
      {.kind = SDR_BOX, .high = {1, 1, 0}},
      {.kind = SDR_DISC, .outer = 1},
      {.kind = SDR_ANNULUS, .inner = 0.5, .outer = 1},
      {.kind = SDR_SPHERE, .outer = 1},
      {.kind = SDR_CYLINDER, .outer = 1, .low = {0, 0, -1}, .high = {0, 0, 1}},
      {.kind = SDR_HALF_SPACE, .centre = {1, 0, 0}, .normal = {2, 0, 0}},
      {.kind = SDR_POLYGON, .vertex_count = 3, .vertices = (double *)corner},
  };
  for (size_t k = 0; k < sizeof shapes / sizeof shapes[0]; ++k) {
    /* the polygon's edge at y = 0, the others' surface at x = 1 */
    const int polygon = shapes[k].kind == SDR_POLYGON;
    const double outside = 5e-10, far = 2e-9;
    assert_true(holds(&shapes[k], polygon ? 0.7 : 1.0 + outside, polygon ? -outside : 0, 0));
    assert_false(holds(&shapes[k], polygon ? 0.7 : 1.0 + far, polygon ? -far : 0, 0));
  }
}

static void holes_of_ring_shapes_are_open(void **state)
{
  (void)state;
  const sdr_shape annulus = {.kind = SDR_ANNULUS, .inner = 0.5, .outer = 1, .centre = {2, 1, 0}};
  assert_true(holds(&annulus, 2.5, 1, 0));
  assert_false(holds(&annulus, 2.49, 1, 0));
  assert_false(holds(&annulus, 2, 1, 0));
  const sdr_shape shell = {.kind = SDR_SPHERE, .inner = 0.5, .outer = 1};
  assert_false(holds(&shell, 0.2, 0.2, 0.2));
  assert_true(holds(&shell, 0.3, 0.3, 0.3));
}

static void a_turned_box_holds_what_it_turns_over(void **state)
{
  (void)state;
  /* a square of side 2 about (1, 1), turned by 45 degrees, reaches sqrt 2 along x and y */
  const sdr_shape box = {.kind = SDR_BOX, .high = {2, 2, 0}, .angle = atan(1.0)};
  assert_true(holds(&box, 1 + sqrt(2.0), 1, 0));
  assert_false(holds(&box, 0.1, 0.1, 0));
  assert_bounds(&box, 1 - sqrt(2.0), 1 + sqrt(2.0), 1 - sqrt(2.0), 1 + sqrt(2.0));
}

static void a_polygon_may_be_concave_and_either_way_round(void **state)
{
  (void)state;
  double l_shape[] = {0, 0, 2, 0, 2, 1, 1, 1, 1, 2, 0, 2};
  sdr_shape polygon = {.kind = SDR_POLYGON, .vertex_count = 6, .vertices = l_shape};
  double back[12];
  for (int k = 0; k < 6; ++k) {
    back[2 * k] = l_shape[10 - 2 * k];
    back[2 * k + 1] = l_shape[11 - 2 * k];
  }
  for (int way = 0; way < 2; ++way) {
    assert_true(holds(&polygon, 0.5, 1.5, 0));
    assert_true(holds(&polygon, 1.5, 0.5, 0));
    assert_false(holds(&polygon, 1.5, 1.5, 0));
    assert_true(holds(&polygon, 1, 1, 0)); /* the inner corner */
    assert_bounds(&polygon, 0, 2, 0, 2);
    polygon.vertices = back;
  }
}

static void combinations_follow_set_rules_and_differences_stay_closed(void **state)
{
  (void)state;
  sdr_shape parts[2] = {{.kind = SDR_BOX, .low = {-2, -2, 0}, .high = {2, 2, 0}},
                        {.kind = SDR_DISC, .outer = 1, .centre = {2, 0, 0}}};
  sdr_shape both = {.kind = SDR_DIFFERENCE, .part_count = 2, .parts = parts};
  assert_true(holds(&both, 1, 0, 0)); /* on the rim of what was taken away */
  assert_false(holds(&both, 1.01, 0, 0));
  assert_bounds(&both, -2, 2, -2, 2);
  both.kind = SDR_UNION;
  assert_true(holds(&both, 2.9, 0, 0));
  assert_bounds(&both, -2, 3, -2, 2);
  both.kind = SDR_INTERSECTION;
  assert_true(holds(&both, 1.5, 0, 0));
  assert_false(holds(&both, 0.5, 0, 0));
  assert_false(holds(&both, 2.5, 0, 0));
  assert_bounds(&both, 1, 2, -1, 1);
}

static void what_a_nested_difference_gives_back_is_inside(void **state)
{
  (void)state;
  sdr_shape ring[2] = {{.kind = SDR_DISC, .outer = 2}, {.kind = SDR_DISC, .outer = 1}};
  sdr_shape parts[2] = {{.kind = SDR_DISC, .outer = 3},
                        {.kind = SDR_DIFFERENCE, .part_count = 2, .parts = ring}};
  const sdr_shape whole = {.kind = SDR_DIFFERENCE, .part_count = 2, .parts = parts};
  assert_true(holds(&whole, 0.5, 0, 0) && holds(&whole, 2.5, 0, 0));
  assert_false(holds(&whole, 1.5, 0, 0));
  assert_true(holds(&whole, 1, 0, 0) && holds(&whole, 2, 0, 0)); /* both rims stay */
}

static void half_spaces_bound_boxes_only_along_the_axes(void **state)
{
  (void)state;
  double low[3], high[3];
  sdr_shape half = {.kind = SDR_HALF_SPACE, .centre = {1, 2, 3}, .normal = {0, -1, 0}};
  sdr_shape_bounds(&half, low, high);
  assert_true(low[1] == 2.0 && isinf(high[1]) && isinf(low[0]));
  half.normal[0] = 0.1;
  sdr_shape_bounds(&half, low, high);
  assert_true(isinf(low[1]));
}

static void a_place_is_a_volume_or_a_layer_under_a_face(void **state)
{
  (void)state;
  sdr_shape disc = {.kind = SDR_DISC, .outer = 1}, box = {.kind = SDR_BOX, .high = {1, 1, 0}};
  sdr_scene scene = {.dimension = SDR_PLANE_STRESS, .points = {.shape = &disc}};
  sdr_place place = {.shape = NULL};
  const double outside[3] = {5, 5, 0}, rim[3] = {0.8, 0, 0};
  assert_true(sdr_place_holds(&scene, &place, outside, 0.1, 0.1)); /* the whole body: any point */
  place.shape = &box;
  assert_false(sdr_place_holds(&scene, &place, outside, 0.1, 0.1));
  assert_true(sdr_place_holds(&scene, &place, rim, 0.1, 0.1));
  place = (sdr_place){.face = "rim"}; /* of the body */
  assert_ptr_equal(sdr_place_shape(&scene, &place), &disc);
  assert_true(sdr_place_holds(&scene, &place, rim, 0.1, 0.2));
  assert_false(sdr_place_holds(&scene, &place, rim, 0.1, 0.19));
}

static void lengths_are_written_in_units_that_read_well(void **state)
{
  (void)state;
  char text[SDR_PLACE_TEXT];
  assert_string_equal(sdr_length_text(0.0005, text), "0.5 mm");
  assert_string_equal(sdr_length_text(1.0, text), "1 m");
  assert_string_equal(sdr_length_text(-0.25, text), "-250 mm");
  assert_string_equal(sdr_length_text(3e-6, text), "3 um");
  assert_string_equal(sdr_length_text(2e-9, text), "2 nm");
  assert_string_equal(sdr_length_text(0.0, text), "0 m");
  assert_string_equal(sdr_place_text((double[3]){0.001, 0.25, 2}, 3, text),
                      "x = 1 mm, y = 250 mm, z = 2 m");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_primitive_is_closed_within_the_tolerance),
      cmocka_unit_test(holes_of_ring_shapes_are_open),
      cmocka_unit_test(a_turned_box_holds_what_it_turns_over),
      cmocka_unit_test(a_polygon_may_be_concave_and_either_way_round),
      cmocka_unit_test(combinations_follow_set_rules_and_differences_stay_closed),
      cmocka_unit_test(what_a_nested_difference_gives_back_is_inside),
      cmocka_unit_test(half_spaces_bound_boxes_only_along_the_axes),
      cmocka_unit_test(a_place_is_a_volume_or_a_layer_under_a_face),
      cmocka_unit_test(lengths_are_written_in_units_that_read_well),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
