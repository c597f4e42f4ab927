/* geometry: which bonds pre-cracks cut. */
#include "geometry/cracks.h"
#include "support/cmocka_all.h"

#include <math.h>

static sdr_scene scene_with(sdr_dimension dimension, sdr_crack *crack)
{
  return (sdr_scene){.dimension = dimension, .crack_count = 1, .crack = crack};
}

static int cut(const sdr_scene *scene, double ax, double ay, double az, double bx, double by,
               double bz)
{
  const double a[3] = {ax, ay, az}, b[3] = {bx, by, bz};
  const int answer = sdr_cracks_cut(scene, a, b, 1e-9);
  assert_int_equal(sdr_cracks_cut(scene, b, a, 1e-9), answer);
  if (answer) assert_true(sdr_cracks_near(scene, a, b, 1e-9));
  return answer;
}

static int cut2(const sdr_scene *scene, double ax, double ay, double bx, double by)
{
  return cut(scene, ax, ay, 0, bx, by, 0);
}

static void a_segment_cuts_what_crosses_touches_or_lies_on_it(void **state)
{
  (void)state;
  double vertices[] = {0, 0, 0, 2, 0, 0};
  sdr_crack crack = {.point_count = 2, .vertices = vertices};
  const sdr_scene scene = scene_with(SDR_PLANE_STRESS, &crack);
  assert_true(cut2(&scene, 1, -1, 1.5, 1));        /* crosses */
  assert_true(cut2(&scene, 1, 0, 1, 1));           /* starts on it */
  assert_true(cut2(&scene, 2, -1, 2, 1));          /* through its tip */
  assert_true(cut2(&scene, 1, 5e-10, 1, 1));       /* within the tolerance */
  assert_true(cut2(&scene, 0.5, 0, 0.7, 0));       /* inside it */
  assert_true(cut2(&scene, -1, 0, 0.5, 0));        /* overlaps along the line */
  assert_true(cut2(&scene, -1, 0, 3, 0));          /* covers it */
  assert_false(cut2(&scene, 2.001, -1, 2.001, 1)); /* passes the tip */
  assert_false(cut2(&scene, 1, 2e-9, 1, 1));       /* just above */
  assert_false(cut2(&scene, 3, 0, 4, 0));          /* on its line, beyond */
  assert_false(cut2(&scene, 1.5, 1, 3, -0.9));     /* boxes meet, lines cross beyond the tip */
}

static void a_polyline_cuts_with_each_of_its_segments(void **state)
{
  (void)state;
  double vertices[] = {0, 0, 0, 1, 0, 0, 1, 1, 0};
  sdr_crack crack = {.point_count = 3, .vertices = vertices};
  const sdr_scene scene = scene_with(SDR_PLANE_STRAIN, &crack);
  assert_true(cut2(&scene, 0.5, -0.1, 0.5, 0.1));
  assert_true(cut2(&scene, 0.9, 0.5, 1.1, 0.5));
  assert_true(cut2(&scene, 0.9, 0.1, 1.1, -0.1)); /* through the corner */
  assert_false(cut2(&scene, 0.2, 0.5, 0.8, 0.9)); /* no closing segment */
}

static void every_crack_of_the_scene_counts(void **state)
{
  (void)state;
  double first[] = {0, 0, 0, 1, 0, 0}, second[] = {0, 5, 0, 1, 5, 0};
  sdr_crack cracks[2] = {{.point_count = 2, .vertices = first},
                         {.point_count = 2, .vertices = second}};
  sdr_scene scene = {.dimension = SDR_PLANE_STRESS, .crack_count = 2, .crack = cracks};
  assert_true(cut2(&scene, 0.5, 4.9, 0.5, 5.1));
  scene.crack_count = 1;
  assert_false(cut2(&scene, 0.5, 4.9, 0.5, 5.1));
}

static void in_one_dimension_a_point_cuts(void **state)
{
  (void)state;
  double vertices[] = {1, 0, 0};
  sdr_crack crack = {.point_count = 1, .vertices = vertices};
  const sdr_scene scene = scene_with(SDR_1D, &crack);
  assert_true(cut2(&scene, 0.5, 0, 1.5, 0));
  assert_true(cut2(&scene, 1, 0, 1.5, 0));
  assert_false(cut2(&scene, 1.1, 0, 1.5, 0));
}

static void a_disc_cuts_inside_its_radius(void **state)
{
  (void)state;
  double centre[] = {0, 0, 1};
  sdr_crack crack = {.kind = SDR_CRACK_DISC, .vertices = centre, .radius = 1, .normal = {0, 0, 3}};
  const sdr_scene scene = scene_with(SDR_3D, &crack);
  assert_true(cut(&scene, 0.5, 0.5, 0, 0.6, 0.5, 2));
  assert_true(cut(&scene, 1, 0, 0, 1, 0, 2));          /* through the rim */
  assert_true(cut(&scene, 0.2, 0.2, 1, 0.2, 0.2, 2));  /* starts on it */
  assert_true(cut(&scene, -3, 0.5, 1, 3, 0.5, 1));     /* lies in its plane, across */
  assert_false(cut(&scene, -3, 1.5, 1, 3, 1.5, 1));    /* lies in its plane, beside */
  assert_false(cut(&scene, 0.8, 0.8, 0, 0.8, 0.8, 2)); /* in the box of the disc, outside of it */
  assert_false(cut(&scene, 0, 0, 1.1, 0, 0, 2));
  assert_false(cut(&scene, 0, 0, 0, 3, 0, 1.2)); /* crosses the plane far outside */
}

static void a_slanted_disc_is_near_only_where_it_reaches(void **state)
{
  (void)state;
  double centre[] = {0, 0, 0};
  const double s = sqrt(0.5);
  sdr_crack crack = {.kind = SDR_CRACK_DISC, .vertices = centre, .radius = 1, .normal = {s, 0, s}};
  const sdr_scene scene = scene_with(SDR_3D, &crack);
  assert_true(cut(&scene, 0.5, 0, -0.6, 0.5, 0, -0.4)); /* its plane is z = -x */
  assert_false(cut(&scene, 0.5, 0, 0.4, 0.5, 0, 0.6));
  const double low[3] = {-2, -2, 0.7}, high[3] = {2, 2, 1}, beyond[3] = {-2, -2, 0.71};
  assert_true(sdr_cracks_near(&scene, low, high, 1e-9)); /* it reaches up to sqrt(1/2) = 0.707 */
  assert_false(sdr_cracks_near(&scene, beyond, high, 1e-9));
}

static void a_rectangle_cuts_between_its_corners_in_any_order(void **state)
{
  (void)state;
  /* corners (0,0), (2,0), (2,1), (0,1) at z = 0; three of them, the right angle at each place */
  double orders[3][9] = {
      {0, 0, 0, 2, 0, 0, 0, 1, 0}, {0, 0, 0, 2, 0, 0, 2, 1, 0}, {0, 1, 0, 2, 0, 0, 2, 1, 0}};
  for (int k = 0; k < 3; ++k) {
    sdr_crack crack = {.kind = SDR_CRACK_RECTANGLE, .vertices = orders[k]};
    const sdr_scene scene = scene_with(SDR_3D, &crack);
    assert_true(cut(&scene, 0.1, 0.1, -1, 0.1, 0.1, 1));
    assert_true(cut(&scene, 1.9, 0.9, -1, 1.9, 0.9, 1));
    assert_true(cut(&scene, 0.1, 0.9, -1, 0.1, 0.9, 1));
    assert_true(cut(&scene, 2, 1, -1, 2, 1, 1));     /* through a corner */
    assert_true(cut(&scene, -1, 0.5, 0, 3, 0.5, 0)); /* in its plane, across */
    assert_false(cut(&scene, -1, 1.5, 0, 3, 1.5, 0));
    assert_false(cut(&scene, -1, 0.5, 0, -0.5, 0.5, 0));
    assert_false(cut(&scene, 2.01, 0.5, -1, 2.01, 0.5, 1));
    assert_false(cut(&scene, 1, 0.5, 0.1, 1, 0.5, 1));
    const double low[3] = {2.1, 0, -1}, high[3] = {3, 1, 1};
    assert_false(sdr_cracks_near(&scene, low, high, 1e-9));
  }
}

static void far_regions_may_be_skipped(void **state)
{
  (void)state;
  double vertices[] = {0, 0, 0, 1, 0, 0, 1, 3, 0};
  sdr_crack crack = {.point_count = 3, .vertices = vertices};
  const sdr_scene scene = scene_with(SDR_PLANE_STRESS, &crack), none = {.crack_count = 0};
  const double corner[3] = {0, 2, 0}, high[3] = {0.5, 3, 0}, edge[3] = {1, 3, 0};
  assert_false(sdr_cracks_near(&scene, corner, high, 1e-9)); /* within the polyline's box */
  assert_true(sdr_cracks_near(&scene, corner, edge, 1e-9));
  assert_false(sdr_cracks_near(&none, corner, edge, 1e-9));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_segment_cuts_what_crosses_touches_or_lies_on_it),
      cmocka_unit_test(a_polyline_cuts_with_each_of_its_segments),
      cmocka_unit_test(every_crack_of_the_scene_counts),
      cmocka_unit_test(in_one_dimension_a_point_cuts),
      cmocka_unit_test(a_disc_cuts_inside_its_radius),
      cmocka_unit_test(a_slanted_disc_is_near_only_where_it_reaches),
      cmocka_unit_test(a_rectangle_cuts_between_its_corners_in_any_order),
      cmocka_unit_test(far_regions_may_be_skipped),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
