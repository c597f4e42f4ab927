/* geometry: faces cut into pieces. */
#include "geometry/face.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

typedef struct {
  double measure, normal[3], moment[3], flux; /* sums of dA, n dA, x dA, x.n dA */
  double low[3], high[3];
  long pieces;
  double largest;
} sums;

static void add(void *context, const sdr_piece *piece)
{
  sums *s = context;
  double length = 0.0;
  for (int c = 0; c < 3; ++c) {
    s->normal[c] += piece->normal[c] * piece->measure;
    s->moment[c] += piece->x[c] * piece->measure;
    s->flux += piece->x[c] * piece->normal[c] * piece->measure;
    length += piece->normal[c] * piece->normal[c];
    s->low[c] = s->pieces ? fmin(s->low[c], piece->x[c]) : piece->x[c];
    s->high[c] = s->pieces ? fmax(s->high[c], piece->x[c]) : piece->x[c];
  }
  assert_true(fabs(length - 1.0) < 1e-12);
  s->measure += piece->measure;
  s->largest = fmax(s->largest, piece->measure);
  ++s->pieces;
}

static sums cut(const sdr_shape *shape, const char *face, sdr_dimension dimension, double size)
{
  sums s = {0};
  assert_int_equal(sdr_face_pieces(shape, face, dimension, size, add, &s), SDR_OK);
  return s;
}

static void assert_near(double value, double wanted, double tolerance)
{
  if (!(fabs(value - wanted) <= tolerance)) fail_msg("%.17g, wanted %.17g", value, wanted);
}

static void circles_are_cut_into_exact_balanced_pieces(void **state)
{
  (void)state;
  const sdr_shape annulus = {.kind = SDR_ANNULUS, .inner = 0.081, .outer = 0.149};
  const sums inner = cut(&annulus, "inner", SDR_PLANE_STRESS, 0.0005 / 8);
  assert_int_equal(inner.pieces % 8, 0);
  assert_int_equal(inner.pieces, 8144); /* 2 pi 81 mm / (1/16 mm) = 8143.0, next multiple of 8 */
  assert_near(inner.measure, 2 * pi * 0.081, 1e-13);
  assert_near(inner.flux, -0.081 * 2 * pi * 0.081, 1e-14); /* normals point to the centre */
  for (int c = 0; c < 2; ++c) assert_near(inner.normal[c], 0.0, 1e-15);
  const sums outer = cut(&annulus, "outer", SDR_PLANE_STRESS, 0.001);
  assert_near(outer.flux, 0.149 * 2 * pi * 0.149, 1e-14);
}

typedef struct {
  double x[64][2];
  int count;
} places;

static void collect(void *context, const sdr_piece *piece)
{
  places *list = context;
  memcpy(list->x[list->count++], piece->x, 2 * sizeof(double));
}

static int has_place(const places *list, double x, double y)
{
  for (int k = 0; k < list->count; ++k) {
    if (list->x[k][0] == x && list->x[k][1] == y) return 1;
  }
  return 0;
}

static void pieces_of_a_circle_are_mirror_images_to_the_last_bit(void **state)
{
  (void)state;
  const sdr_shape disc = {.kind = SDR_DISC, .outer = 1};
  places list = {.count = 0};
  assert_int_equal(sdr_face_pieces(&disc, "rim", SDR_PLANE_STRAIN, 0.17, collect, &list), SDR_OK);
  assert_int_equal(list.count, 40); /* 2 pi / 0.17 = 36.96, next multiple of 8 */
  for (int k = 0; k < list.count; ++k) {
    const double x = list.x[k][0], y = list.x[k][1];
    assert_true(has_place(&list, -x, y) && has_place(&list, x, -y) && has_place(&list, y, x));
    if (k > 0) assert_true(atan2(y, x) > atan2(list.x[k - 1][1], list.x[k - 1][0]) || y < 0.0);
  }
}

static void faces_of_a_box_by_dimension(void **state)
{
  (void)state;
  const sdr_shape bar = {.kind = SDR_BOX, .low = {1, 0, 0}, .high = {3, 0, 0}};
  const sums left = cut(&bar, "left", SDR_1D, 0.1), right = cut(&bar, "right", SDR_1D, 0.1);
  assert_true(left.pieces == 1 && left.measure == 1.0 && left.normal[0] == -1.0 &&
              left.moment[0] == 1.0);
  assert_true(right.normal[0] == 1.0 && right.moment[0] == 3.0);

  const sdr_shape plate = {.kind = SDR_BOX, .low = {1, 2, 0}, .high = {3, 5, 0}};
  const sums top = cut(&plate, "top", SDR_PLANE_STRESS, 0.1);
  assert_int_equal(top.pieces, 20);
  assert_near(top.measure, 2.0, 1e-14);
  assert_near(top.normal[1], 2.0, 1e-14);
  assert_near(top.moment[0], 2.0 * 2.0, 1e-13);
  assert_true(top.low[1] == 5.0 && top.high[1] == 5.0);

  const sdr_shape block = {.kind = SDR_BOX, .low = {0, 0, 0}, .high = {1, 2, 3}};
  const struct {
    const char *face;
    double area, flux;
  } faces[] = {{"left", 6, 0}, {"right", 6, 6}, {"bottom", 3, 0},
               {"top", 3, 6},  {"back", 2, 0},  {"front", 2, 6}};
  for (int k = 0; k < 6; ++k) {
    const sums s = cut(&block, faces[k].face, SDR_3D, 0.07);
    assert_near(s.measure, faces[k].area, 1e-11);
    assert_near(s.flux, faces[k].flux, 1e-11); /* face plane's x.n times its area */
    assert_true(s.largest <= 0.07 * 0.07);
  }
}

static void a_turned_box_turns_its_faces_and_normals(void **state)
{
  (void)state;
  const sdr_shape box = {.kind = SDR_BOX, .low = {0, 0, 0}, .high = {4, 2, 0}, .angle = pi / 6};
  const sums right = cut(&box, "right", SDR_PLANE_STRESS, 0.1);
  assert_near(right.normal[0], 2.0 * cos(pi / 6), 1e-13);
  assert_near(right.normal[1], 2.0 * sin(pi / 6), 1e-13);
  assert_near(right.moment[0] / right.measure, 2.0 + 2.0 * cos(pi / 6), 1e-13);
  assert_near(right.moment[1] / right.measure, 1.0 + 2.0 * sin(pi / 6), 1e-13);
  const double x[3] = {2.0 + 3.0 * cos(pi / 6), 1.0 + 3.0 * sin(pi / 6), 0.0};
  assert_near(sdr_face_distance(&box, "right", SDR_PLANE_STRESS, x), 1.0, 1e-13);
}

static void a_polygons_rim_closes_and_points_outwards(void **state)
{
  (void)state;
  double vertices[] = {0, 0, 2, 0, 2, 1, 1, 1, 1, 2, 0, 2};
  sdr_shape polygon = {.kind = SDR_POLYGON, .vertex_count = 6, .vertices = vertices};
  const sums s = cut(&polygon, "rim", SDR_PLANE_STRESS, 0.03);
  assert_near(s.measure, 8.0, 1e-12);
  assert_near(s.flux, 2.0 * 3.0, 1e-12); /* twice the area, by the divergence theorem */
  double clockwise[] = {0, 0, 0, 1, 1, 0};
  polygon = (sdr_shape){.kind = SDR_POLYGON, .vertex_count = 3, .vertices = clockwise};
  assert_near(cut(&polygon, "rim", SDR_PLANE_STRESS, 0.1).flux, 2.0 * 0.5, 1e-13);
}

static void round_bodies_have_exact_areas_and_volumes(void **state)
{
  (void)state;
  const sdr_shape ball = {.kind = SDR_SPHERE, .inner = 1, .outer = 2};
  const sums outer = cut(&ball, "outer", SDR_3D, 0.05), inner = cut(&ball, "inner", SDR_3D, 0.05);
  assert_near(outer.measure, 16 * pi, 1e-9);
  assert_near(outer.flux, 2 * 16 * pi, 1e-9);
  assert_near(inner.flux, -4 * pi, 1e-9);
  for (int c = 0; c < 3; ++c) assert_near(outer.normal[c], 0.0, 1e-11);
  assert_true(outer.largest <= 0.05 * 0.05 * 1.001);

  const sdr_shape tube = {
      .kind = SDR_CYLINDER, .inner = 1, .outer = 2, .low = {0, 0, -1}, .high = {0, 0, 3}};
  assert_near(cut(&tube, "outer", SDR_3D, 0.05).measure, 4 * pi * 4, 1e-9);
  assert_near(cut(&tube, "inner", SDR_3D, 0.05).flux, -2 * pi * 4, 1e-9);
  assert_near(cut(&tube, "top", SDR_3D, 0.05).measure, 3 * pi, 1e-10);
  assert_near(cut(&tube, "top", SDR_3D, 0.05).flux, 3 * 3 * pi, 1e-10);
  assert_near(cut(&tube, "bottom", SDR_3D, 0.05).flux, 3 * pi, 1e-10);
  const sums ends = cut(&tube, "ends", SDR_3D, 0.05);
  assert_near(ends.measure, 6 * pi, 1e-10);
  assert_near(ends.normal[2], 0.0, 1e-11);
}

static void the_rim_of_a_hole_points_into_the_hole(void **state)
{
  (void)state;
  sdr_shape parts[2] = {{.kind = SDR_BOX, .low = {-2, -2, 0}, .high = {2, 2, 0}},
                        {.kind = SDR_DISC, .outer = 1}};
  const sdr_shape plate = {.kind = SDR_DIFFERENCE, .part_count = 2, .parts = parts};
  const sums rim = cut(&plate, "rim", SDR_PLANE_STRESS, 0.01);
  assert_near(rim.measure, 2 * pi, 1e-12);
  assert_near(rim.flux, -2 * pi, 1e-12);
}

static void only_the_surface_of_a_combination_is_visited(void **state)
{
  (void)state;
  /* a notch: half of the disc lies in the box; the box's right edge loses the disc's diameter */
  sdr_shape parts[2] = {{.kind = SDR_BOX, .low = {-2, -2, 0}, .high = {2, 2, 0}},
                        {.kind = SDR_DISC, .outer = 1, .centre = {2, 0, 0}}};
  const sdr_shape plate = {.kind = SDR_DIFFERENCE, .part_count = 2, .parts = parts};
  assert_near(cut(&plate, "rim", SDR_PLANE_STRESS, 0.01).measure, pi, 1e-12);
  assert_near(cut(&plate, "right", SDR_PLANE_STRESS, 0.01).measure, 2.0, 1e-12);
}

static void a_face_needs_extent_and_one_owner(void **state)
{
  (void)state;
  sdr_shape parts[2] = {{.kind = SDR_DISC, .outer = 1}, {.kind = SDR_DISC, .outer = 0.5}};
  const sdr_shape ring = {.kind = SDR_DIFFERENCE, .part_count = 2, .parts = parts};
  const sdr_shape box = {.kind = SDR_BOX, .high = {1, 1, 0}};
  const sdr_shape full = {.kind = SDR_CYLINDER, .outer = 1, .high = {0, 0, 1}};
  assert_false(sdr_shape_has_face(&ring, "rim"));
  assert_true(sdr_shape_has_face(&box, "top"));
  assert_false(sdr_shape_has_face(&box, "front"));
  assert_false(sdr_shape_has_face(&full, "inner"));
  assert_false(sdr_shape_has_face(NULL, "left"));
  sums s = {0};
  assert_int_equal(sdr_face_pieces(&ring, "rim", SDR_PLANE_STRESS, 0.1, add, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "2 parts have a face 'rim'; make the meant part a region "
                      "and write REGION.rim");
  assert_int_equal(sdr_face_pieces(&box, "front", SDR_PLANE_STRESS, 0.1, add, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "no face 'front'; the faces here are: left, right, bottom, top");
  assert_int_equal(sdr_face_pieces(&box, "top", SDR_PLANE_STRESS, 0.0, add, &s), SDR_BAD_INPUT);
  assert_int_equal(s.pieces, 0);
}

static void faces_are_listed_once_each(void **state)
{
  (void)state;
  char text[128];
  sdr_shape parts[3] = {{.kind = SDR_CYLINDER, .outer = 1, .high = {0, 0, 1}},
                        {.kind = SDR_SPHERE, .inner = 1, .outer = 2},
                        {.kind = SDR_HALF_SPACE, .normal = {1, 0, 0}}};
  const sdr_shape whole = {.kind = SDR_UNION, .part_count = 3, .parts = parts};
  assert_string_equal(sdr_shape_faces(&whole, text, sizeof text),
                      "outer, bottom, top, ends, inner");
  assert_string_equal(sdr_shape_faces(&parts[2], text, sizeof text), "none");
}

static void distances_are_from_the_bounded_face(void **state)
{
  (void)state;
  const double beside[3] = {4, 5, 0}, above[3] = {0, 3, 0};
  const sdr_shape box = {.kind = SDR_BOX, .high = {1, 1, 0}};
  assert_near(sdr_face_distance(&box, "top", SDR_PLANE_STRESS, beside), 5.0, 1e-14);
  assert_near(sdr_face_distance(&box, "left", SDR_1D, beside), 4.0, 1e-14);
  const sdr_shape annulus = {.kind = SDR_ANNULUS, .inner = 1, .outer = 2};
  assert_near(sdr_face_distance(&annulus, "inner", SDR_PLANE_STRESS, above), 2.0, 1e-14);
  assert_near(sdr_face_distance(&annulus, "outer", SDR_PLANE_STRESS, above), 1.0, 1e-14);
  const sdr_shape tube = {
      .kind = SDR_CYLINDER, .inner = 1, .outer = 2, .low = {0, 0, 0}, .high = {0, 0, 1}};
  const double over[3] = {0, 6, 4};
  assert_near(sdr_face_distance(&tube, "outer", SDR_3D, over), 5.0, 1e-14);
  assert_near(sdr_face_distance(&tube, "top", SDR_3D, over), 5.0, 1e-14);
  assert_near(sdr_face_distance(&tube, "bottom", SDR_3D, (double[3]){0, 0.25, 2}), hypot(0.75, 2.0),
              1e-14);
  assert_near(sdr_face_distance(&tube, "ends", SDR_3D, (double[3]){1.5, 0, 0.25}), 0.25, 1e-14);
  double vertices[] = {0, 0, 1, 0, 0, 1};
  const sdr_shape polygon = {.kind = SDR_POLYGON, .vertex_count = 3, .vertices = vertices};
  assert_near(sdr_face_distance(&polygon, "rim", SDR_PLANE_STRESS, (double[3]){1, 1, 0}), sqrt(0.5),
              1e-14);
  const sdr_shape ball = {.kind = SDR_SPHERE, .outer = 2};
  assert_near(sdr_face_distance(&ball, "outer", SDR_3D, (double[3]){0, 0, 5}), 3.0, 1e-14);
  assert_true(isinf(sdr_face_distance(&ball, "rim", SDR_3D, over)));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(circles_are_cut_into_exact_balanced_pieces),
      cmocka_unit_test(pieces_of_a_circle_are_mirror_images_to_the_last_bit),
      cmocka_unit_test(faces_of_a_box_by_dimension),
      cmocka_unit_test(a_turned_box_turns_its_faces_and_normals),
      cmocka_unit_test(a_polygons_rim_closes_and_points_outwards),
      cmocka_unit_test(round_bodies_have_exact_areas_and_volumes),
      cmocka_unit_test(the_rim_of_a_hole_points_into_the_hole),
      cmocka_unit_test(only_the_surface_of_a_combination_is_visited),
      cmocka_unit_test(a_face_needs_extent_and_one_owner),
      cmocka_unit_test(faces_are_listed_once_each),
      cmocka_unit_test(distances_are_from_the_bounded_face),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
