/* geometry: the points of a scene. */
#include "geometry/lattice.h"
#include "base/memory.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <string.h>

static const sdr_unit plain = {0}, metre = {.m = 1};
static sdr_material body = {.name = "body"};

static sdr_scene scene_of(sdr_shape *shape, sdr_dimension dimension, double spacing)
{
  sdr_scene scene = {.dimension = dimension,
                     .points = {.shape = shape,
                                .spacing = spacing,
                                .thickness = 1,
                                .origin = {"plate.yaml", 4, 3}},
                     .material_count = 1,
                     .material = &body,
                     .horizon_relative = 1,
                     .horizon_origin = {"plate.yaml", 7, 10}};
  assert_int_equal(sdr_expression_create("3.015", plain, NULL, NULL, &scene.horizon), SDR_OK);
  return scene;
}

static sdr_points *points_of(const sdr_scene *scene)
{
  sdr_points *points = NULL;
  if (sdr_lattice_points(scene, &points) != SDR_OK) fail_msg("%s", sdr_error_message());
  return points;
}

static int32_t count_and_destroy(sdr_scene *scene)
{
  sdr_points *points = points_of(scene);
  const int32_t count = points->count;
  sdr_points_destroy(&points);
  sdr_expression_destroy(&scene->horizon);
  return count;
}

static void assert_refused(sdr_scene *scene, const char *message)
{
  const size_t before = sdr_memory_now();
  sdr_points *points = NULL;
  assert_int_equal(sdr_lattice_points(scene, &points), SDR_BAD_INPUT);
  assert_null(points);
  assert_string_equal(sdr_error_message(), message);
  assert_int_equal(sdr_memory_now(), before);
}

static void assert_near(double value, double wanted, double tolerance)
{
  if (!(fabs(value - wanted) <= tolerance)) fail_msg("%.17g, wanted %.17g", value, wanted);
}

static void the_cylinder_of_the_paper_has_196556_points(void **state)
{
  (void)state;
  sdr_shape annulus = {.kind = SDR_ANNULUS, .inner = 0.081, .outer = 0.149};
  sdr_scene scene = scene_of(&annulus, SDR_PLANE_STRESS, 0.0005);
  assert_int_equal(count_and_destroy(&scene), 196556);
}

static void sites_on_the_surface_belong_to_the_shape(void **state)
{
  (void)state;
  /* Gauss's circle problem: 317 sites within 10 spacings, 13 and 29 within 2 and 3 */
  sdr_shape disc = {.kind = SDR_DISC, .outer = 0.01};
  sdr_scene scene = scene_of(&disc, SDR_PLANE_STRAIN, 0.001);
  assert_int_equal(count_and_destroy(&scene), 317);
  sdr_shape annulus = {.kind = SDR_ANNULUS, .inner = 2e-3, .outer = 3e-3};
  scene = scene_of(&annulus, SDR_PLANE_STRAIN, 0.001);
  assert_int_equal(count_and_destroy(&scene), 29 - 13 + 4); /* (+-2, 0), (0, +-2) stay */
  sdr_shape block = {.kind = SDR_BOX, .low = {0.1, 0.2, 0.3}, .high = {0.4, 0.6, 0.8}};
  scene = scene_of(&block, SDR_3D, 0.1);
  assert_int_equal(count_and_destroy(&scene), 4 * 5 * 6);
  sdr_shape bar = {.kind = SDR_BOX, .low = {-1, 0, 0}, .high = {1, 0, 0}};
  scene = scene_of(&bar, SDR_1D, 0.1);
  assert_int_equal(count_and_destroy(&scene), 21);
}

static void points_come_with_x_fastest_and_know_their_cell(void **state)
{
  (void)state;
  sdr_shape block = {.kind = SDR_BOX, .low = {-1, 0, 0}, .high = {1, 1, 1}};
  sdr_scene scene = scene_of(&block, SDR_3D, 1);
  sdr_points *points = points_of(&scene);
  assert_int_equal(points->count, 12);
  for (int32_t i = 0; i < 12; ++i) {
    const int32_t cell[3] = {i % 3 - 1, i / 3 % 2, i / 6};
    for (int c = 0; c < 3; ++c) {
      assert_int_equal(points->cell[3 * i + c], cell[c]);
      assert_true(points->x[c][i] == cell[c]);
    }
    assert_true(points->volume[i] == 1.0 && points->spacing[i] == 1.0);
    assert_near(points->horizon[i], 3.015, 1e-15);
  }
  assert_true(points->lattice_spacing == 1.0 && points->axes[2][2] == 1.0);
  assert_null(points->level);
  sdr_points_destroy(&points);
  sdr_expression_destroy(&scene.horizon);
}

static void volumes_count_thickness_and_area(void **state)
{
  (void)state;
  const struct {
    sdr_dimension dimension;
    double volume;
  } cases[] = {{SDR_1D, 0.5 * 3}, {SDR_PLANE_STRESS, 0.25 * 3}, {SDR_3D, 0.125}};
  sdr_shape box = {.kind = SDR_BOX, .high = {1, 0, 0}};
  for (int k = 0; k < 3; ++k) {
    sdr_scene scene = scene_of(&box, cases[k].dimension, 0.5);
    scene.points.thickness = 3;
    sdr_points *points = points_of(&scene);
    assert_int_equal(points->count, 3);
    assert_near(points->volume[1], cases[k].volume, 1e-15);
    sdr_points_destroy(&points);
    sdr_expression_destroy(&scene.horizon);
  }
}

static void cells_may_be_centred_by_component(void **state)
{
  (void)state;
  sdr_shape box = {.kind = SDR_BOX, .high = {1, 1, 0}};
  sdr_scene scene = scene_of(&box, SDR_PLANE_STRESS, 0.25);
  scene.points.cell_centred[0] = 1;
  scene.points.lattice_origin[1] = 0.125;
  sdr_points *points = points_of(&scene);
  assert_int_equal(points->count, 4 * 4);
  assert_true(points->x[0][0] == 0.125 && points->x[1][0] == 0.125);
  assert_int_equal(points->cell[0], 0);
  sdr_points_destroy(&points);
  sdr_expression_destroy(&scene.horizon);
}

static void a_turned_lattice_fills_the_shape_to_its_corners(void **state)
{
  (void)state;
  /* lattice and box turned alike about the same point: the same points as without turning */
  const double angle = 0.3;
  sdr_shape box = {.kind = SDR_BOX, .low = {-1, -2, 0}, .high = {1, 2, 0}, .angle = angle};
  sdr_scene scene = scene_of(&box, SDR_PLANE_STRESS, 0.1);
  scene.points.angle = angle;
  sdr_points *points = points_of(&scene);
  assert_int_equal(points->count, 21 * 41);
  assert_near(points->axes[0][0], cos(angle), 1e-15);
  assert_near(points->axes[0][1], sin(angle), 1e-15);
  for (int32_t i = 0; i < points->count; ++i) {
    const double along = cos(angle) * points->x[0][i] + sin(angle) * points->x[1][i];
    assert_near(along, 0.1 * points->cell[3 * i], 1e-14);
  }
  sdr_points_destroy(&points);
  sdr_expression_destroy(&scene.horizon);
  box.angle = 0; /* about as many points as area / h^2 in any other direction */
  scene = scene_of(&box, SDR_PLANE_STRESS, 0.1);
  scene.points.angle = angle;
  const int32_t turned = count_and_destroy(&scene);
  assert_true(turned > 800 - 60 && turned < 800 + 60);
}

static sdr_refine halved(sdr_shape *where, double spacing)
{
  return (sdr_refine){.where = {.shape = where, .origin = {"plate.yaml", 5, 9}},
                      .spacing = spacing};
}

static void refinement_halves_cells_and_keeps_the_volume(void **state)
{
  (void)state;
  sdr_shape box = {.kind = SDR_BOX, .high = {4, 4, 0}};
  sdr_shape half = {.kind = SDR_BOX, .high = {2, 4, 0}};
  sdr_shape corner = {.kind = SDR_BOX, .high = {1, 1, 0}};
  sdr_refine refine[2] = {halved(&half, 0.5), halved(&corner, 0.125)};
  sdr_scene scene = scene_of(&box, SDR_PLANE_STRESS, 1);
  scene.points.cell_centred[0] = scene.points.cell_centred[1] = 1;
  scene.points.refine_count = 2;
  scene.points.refine = refine;
  sdr_points *points = points_of(&scene);
  /* 8 coarse, 7 cells of 4 children, 1 of 64 */
  assert_int_equal(points->count, 8 + 7 * 4 + 64);
  int32_t of_level[4] = {0};
  double volume = 0.0, low = 1.0;
  for (int32_t i = 0; i < points->count; ++i) {
    ++of_level[points->level[i]];
    volume += points->volume[i];
    low = fmin(low, points->x[0][i]);
    assert_near(points->spacing[i], ldexp(1.0, -points->level[i]), 0.0);
    assert_near(points->horizon[i], 3.015 * points->spacing[i], 1e-15);
    for (int c = 0; c < 2; ++c) /* cells of every level begin at one corner */
      assert_true(points->x[c][i] == (points->cell[3 * i + c] + 0.5) * points->spacing[i]);
  }
  assert_true(of_level[0] == 8 && of_level[1] == 28 && of_level[2] == 0 && of_level[3] == 64);
  assert_near(volume, 16.0, 1e-13);
  assert_near(low, 0.0625, 0.0); /* children sit in the middle of their cells */
  sdr_points_destroy(&points);
  sdr_expression_destroy(&scene.horizon);
}

static void a_deeper_place_inside_children_goes_on_from_there(void **state)
{
  (void)state;
  sdr_shape bar = {.kind = SDR_BOX, .high = {1, 0, 0}};
  sdr_shape near_child = {.kind = SDR_BOX, .low = {0.2, 0, 0}, .high = {0.3, 0, 0}};
  sdr_refine refine[2] = {halved(&bar, 0.5), halved(&near_child, 0.25)};
  sdr_scene scene = scene_of(&bar, SDR_1D, 1);
  scene.points.cell_centred[0] = 1;
  scene.points.refine_count = 2;
  scene.points.refine = refine;
  sdr_points *points = points_of(&scene);
  /* cell 0..1 -> children at 1/4 and 3/4; the first one lies in the deeper place */
  const double wanted[3] = {0.125, 0.375, 0.75};
  assert_int_equal(points->count, 3);
  for (int i = 0; i < 3; ++i) assert_true(points->x[0][i] == wanted[i]);
  sdr_points_destroy(&points);
  sdr_expression_destroy(&scene.horizon);
}

static void jitter_is_bounded_seeded_and_drawn_in_order(void **state)
{
  (void)state;
  sdr_shape box = {.kind = SDR_BOX, .high = {20, 20, 0}};
  sdr_scene scene = scene_of(&box, SDR_PLANE_STRESS, 1);
  sdr_points *sets[3], *exact = points_of(&scene);
  scene.points.jitter = 0.2;
  for (int k = 0; k < 3; ++k) {
    scene.points.jitter_seed = k == 2 ? 8 : 7;
    sets[k] = points_of(&scene);
    assert_null(sets[k]->cell);
  }
  double largest = 0.0;
  int same = 0;
  for (int32_t i = 0; i < exact->count; ++i) {
    for (int c = 0; c < 2; ++c) {
      const double moved = fabs(sets[0]->x[c][i] - exact->x[c][i]);
      largest = fmax(largest, moved);
      assert_true(sets[0]->x[c][i] == sets[1]->x[c][i]);
      same += sets[0]->x[c][i] == sets[2]->x[c][i];
    }
  }
  assert_true(largest <= 0.2 + 1e-12 && largest > 0.19); /* 882 draws */
  assert_true(same < 3);
  for (int k = 0; k < 3; ++k) sdr_points_destroy(&sets[k]);
  sdr_points_destroy(&exact);
  sdr_expression_destroy(&scene.horizon);
}

static void the_last_material_at_a_point_wins(void **state)
{
  (void)state;
  sdr_shape bar = {.kind = SDR_BOX, .high = {4, 0, 0}};
  sdr_shape right = {.kind = SDR_BOX, .low = {2, 0, 0}, .high = {4, 0, 0}};
  sdr_shape tip = {.kind = SDR_BOX, .low = {4, 0, 0}, .high = {5, 0, 0}};
  sdr_material materials[3] = {{.name = "a"},
                               {.name = "b", .where = {.shape = &right}},
                               {.name = "c", .where = {.shape = &tip}}};
  sdr_scene scene = scene_of(&bar, SDR_1D, 1);
  scene.material = materials;
  scene.material_count = 3;
  sdr_points *points = points_of(&scene);
  const uint8_t wanted[5] = {0, 0, 1, 1, 2};
  assert_memory_equal(points->material, wanted, 5);
  sdr_points_destroy(&points);

  materials[2].where.shape = &right; /* c now covers b */
  materials[1].origin = (sdr_origin){"plate.yaml", 20, 5};
  assert_refused(&scene, "plate.yaml:20:5: material 'b' has no point: its place holds none, or "
                         "later materials cover it; mend the place or leave the material out");
  sdr_expression_destroy(&scene.horizon);
}

static void horizons_may_vary_in_space(void **state)
{
  (void)state;
  sdr_shape bar = {.kind = SDR_BOX, .high = {4, 0, 0}};
  sdr_scene scene = scene_of(&bar, SDR_1D, 1);
  sdr_expression_destroy(&scene.horizon);
  assert_int_equal(sdr_expression_create("2 m + x/2", metre, NULL, NULL, &scene.horizon), SDR_OK);
  scene.horizon_relative = 0;
  sdr_points *points = points_of(&scene);
  for (int i = 0; i < 5; ++i) assert_near(points->horizon[i], 2 + 0.5 * i, 1e-15);
  sdr_points_destroy(&points);
  sdr_expression_destroy(&scene.horizon);
  assert_int_equal(sdr_expression_create("1.5 m - x/3", metre, NULL, NULL, &scene.horizon), SDR_OK);
  assert_refused(&scene, "plate.yaml:7:10: horizon 833.333 mm is below the spacing 1 m at "
                         "x = 2 m, so no bond exists; give at least 1 spacing");
  sdr_expression_destroy(&scene.horizon);
}

static void a_horizon_below_the_spacing_is_refused(void **state)
{
  (void)state;
  sdr_shape disc = {.kind = SDR_DISC, .outer = 0.01};
  sdr_scene scene = scene_of(&disc, SDR_PLANE_STRESS, 0.001);
  sdr_expression_destroy(&scene.horizon);
  assert_int_equal(sdr_expression_create("0.5 mm", metre, NULL, NULL, &scene.horizon), SDR_OK);
  scene.horizon_relative = 0;
  assert_refused(&scene, "plate.yaml:7:10: horizon 0.5 mm is below the spacing 1 mm, so no bond "
                         "exists; give at least 1 spacing");
  sdr_expression_destroy(&scene.horizon);
  assert_int_equal(sdr_expression_create("1 mm", metre, NULL, NULL, &scene.horizon), SDR_OK);
  assert_int_equal(count_and_destroy(&scene), 317); /* one spacing is enough */
}

static void shapes_without_points_and_with_too_many_are_refused(void **state)
{
  (void)state;
  sdr_shape disc = {.kind = SDR_DISC, .outer = 0.0004, .centre = {0.0005, 0.0005, 0}};
  sdr_scene scene = scene_of(&disc, SDR_PLANE_STRESS, 0.001);
  assert_refused(&scene, "plate.yaml:4:3: the shape holds no lattice point at spacing 1 mm; take a "
                         "smaller spacing, a larger shape or another alignment of the lattice");
  disc.outer = 1;
  scene.points.spacing = 1e-9;
  sdr_points *points = NULL;
  assert_int_equal(sdr_lattice_points(&scene, &points), SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), "plate.yaml:4:3: spacing 1 nm gives about 3.1e+18 "
                                              "points; at most 2147483639 are possible"));
  sdr_shape half = {.kind = SDR_HALF_SPACE, .normal = {1, 0, 0}};
  scene.points.shape = &half;
  assert_refused(&scene, "plate.yaml:4:3: the shape of the points is not bounded; intersect it "
                         "with a box");
  sdr_expression_destroy(&scene.horizon);
}

static void an_empty_intersection_holds_no_point(void **state)
{
  (void)state;
  sdr_shape parts[2] = {{.kind = SDR_DISC, .outer = 1},
                        {.kind = SDR_DISC, .outer = 1, .centre = {5, 0, 0}}};
  sdr_shape both = {.kind = SDR_INTERSECTION, .part_count = 2, .parts = parts};
  sdr_scene scene = scene_of(&both, SDR_PLANE_STRESS, 0.1);
  sdr_points *points = NULL;
  assert_int_equal(sdr_lattice_points(&scene, &points), SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), "holds no lattice point"));
  sdr_expression_destroy(&scene.horizon);
}

static void a_refined_spacing_must_be_a_halving(void **state)
{
  (void)state;
  sdr_shape disc = {.kind = SDR_DISC, .outer = 0.01};
  sdr_refine refine = halved(&disc, 0.0003);
  sdr_scene scene = scene_of(&disc, SDR_PLANE_STRESS, 0.001);
  scene.points.refine_count = 1;
  scene.points.refine = &refine;
  assert_refused(&scene, "plate.yaml:5:9: refined spacing 0.3 mm is not the spacing 1 mm halved 1 "
                         "to 10 times; the nearest is 0.25 mm");
  refine.spacing = 0.001;
  assert_refused(&scene, "plate.yaml:5:9: refined spacing 1 mm is not the spacing 1 mm halved 1 to "
                         "10 times; the nearest is 0.5 mm");
  sdr_expression_destroy(&scene.horizon);
}

static void running_out_of_memory_is_reported_and_leaks_nothing(void **state)
{
  (void)state;
  sdr_shape disc = {.kind = SDR_DISC, .outer = 0.01};
  sdr_refine refine = halved(&disc, 0.0005);
  sdr_scene scene = scene_of(&disc, SDR_PLANE_STRESS, 0.001);
  scene.points.refine_count = 1;
  scene.points.refine = &refine;
  const size_t before = sdr_memory_now();
  sdr_status status = SDR_RUN_FAILED;
  for (long allowed = 0; status != SDR_OK; ++allowed) {
    sdr_points *points = NULL;
    sdr_memory_fail_after(allowed);
    status = sdr_lattice_points(&scene, &points);
    sdr_memory_fail_after(-1);
    assert_true(status == SDR_OK || (status == SDR_RUN_FAILED && !points));
    sdr_points_destroy(&points);
    assert_int_equal(sdr_memory_now(), before);
    assert_true(allowed < 40);
  }
  sdr_expression_destroy(&scene.horizon);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_cylinder_of_the_paper_has_196556_points),
      cmocka_unit_test(sites_on_the_surface_belong_to_the_shape),
      cmocka_unit_test(points_come_with_x_fastest_and_know_their_cell),
      cmocka_unit_test(volumes_count_thickness_and_area),
      cmocka_unit_test(cells_may_be_centred_by_component),
      cmocka_unit_test(a_turned_lattice_fills_the_shape_to_its_corners),
      cmocka_unit_test(refinement_halves_cells_and_keeps_the_volume),
      cmocka_unit_test(a_deeper_place_inside_children_goes_on_from_there),
      cmocka_unit_test(jitter_is_bounded_seeded_and_drawn_in_order),
      cmocka_unit_test(the_last_material_at_a_point_wins),
      cmocka_unit_test(horizons_may_vary_in_space),
      cmocka_unit_test(a_horizon_below_the_spacing_is_refused),
      cmocka_unit_test(shapes_without_points_and_with_too_many_are_refused),
      cmocka_unit_test(an_empty_intersection_holds_no_point),
      cmocka_unit_test(a_refined_spacing_must_be_a_halving),
      cmocka_unit_test(running_out_of_memory_is_reported_and_leaks_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
