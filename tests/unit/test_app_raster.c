/* app: points turned into an image, and the colours and units around it. */
#include "app/plot_palette.h"
#include "app/plot_units.h"
#include "app/raster.h"
#include "support/cmocka_all.h"
#include "support/made_run.h"

static const made_run small_ring = {
    .dimension = 2, .cells = 40, .cracks = 5, .law = "variational", .frames = 3};

static void assert_close(double value, double expected, double tolerance)
{
  if (!(fabs(value - expected) <= tolerance)) print_error("%.17g is not %.17g\n", value, expected);
  assert_true(fabs(value - expected) <= tolerance);
}

typedef struct {
  sdr_cloud cloud;
  sdr_extent extent;
  sdr_raster raster;
  double *position[3];
  float *value;
} painted;

/* The made body with value 1 + index, painted `target` pixels wide. */
static painted paint(const made_run *run, int target)
{
  painted all = {0};
  made_points points = made_body(run);
  all.value = malloc((size_t)points.count * sizeof *all.value);
  for (int c = 0; c < 3; ++c) {
    all.position[c] = malloc((size_t)points.count * sizeof(double));
    for (int i = 0; i < points.count; ++i) all.position[c][i] = points.x[3 * i + c];
    all.cloud.position[c] = all.position[c];
  }
  for (int i = 0; i < points.count; ++i) all.value[i] = (float)(1 + i);
  all.cloud.count = points.count;
  all.cloud.dimension = run->dimension;
  free(points.x);
  assert_int_equal(sdr_raster_measure(&all.cloud, &all.extent), SDR_OK);
  const sdr_window window = sdr_raster_window(&all.extent, 1, target);
  assert_int_equal(sdr_raster_paint(&all.cloud, &all.extent, all.value, &window, &all.raster),
                   SDR_OK);
  return all;
}

static void wipe(painted *all)
{
  sdr_raster_clear(&all->raster);
  for (int c = 0; c < 3; ++c) free(all->position[c]);
  free(all->value);
}

static float pixel_at(const sdr_raster *raster, double x, double y)
{
  const sdr_window *w = &raster->window;
  const int column = (int)floor((x - w->left) / w->pixel),
            row = (int)floor((y - w->bottom) / w->pixel);
  return raster->value[(size_t)row * (size_t)w->width + (size_t)column];
}

static void each_cell_of_a_lattice_covers_the_same_whole_number_of_pixels(void **state)
{
  (void)state;
  painted all = paint(&small_ring, 300);
  const double across = all.extent.spacing / all.raster.window.pixel;
  assert_true(all.extent.lattice);
  assert_close(all.extent.spacing, 0.298 / 40, 1e-12);
  assert_close(across, round(across), 1e-9);
  int *pixels = calloc((size_t)all.cloud.count, sizeof *pixels);
  const size_t count = (size_t)all.raster.window.width * (size_t)all.raster.window.height;
  for (size_t k = 0; k < count; ++k)
    if (!isnan(all.raster.value[k])) ++pixels[(int)all.raster.value[k] - 1];
  for (int i = 0; i < all.cloud.count; ++i)
    assert_int_equal(pixels[i], (int)(round(across) * round(across)));
  free(pixels);
  wipe(&all);
}

/* Every pixel that is a spacing inside of the ring has a value, none that is one outside. */
static void check_ring_is_closed(const made_run *run)
{
  painted all = paint(run, 500);
  const sdr_window *w = &all.raster.window;
  const double h = 0.298 / run->cells;
  int holes = 0, spills = 0;
  for (int row = 0; row < w->height; ++row)
    for (int column = 0; column < w->width; ++column) {
      const double r =
          hypot(w->left + (column + 0.5) * w->pixel, w->bottom + (row + 0.5) * w->pixel);
      const int body = !isnan(all.raster.value[(size_t)row * (size_t)w->width + (size_t)column]);
      holes += !body && r > 0.081 + 1.5 * h && r < 0.149 - 1.5 * h;
      spills += body && (r < 0.081 - h || r > 0.149 + h);
    }
  assert_int_equal(holes, 0);
  assert_int_equal(spills, 0);
  assert_false(all.extent.lattice);
  wipe(&all);
}

static void turned_and_jittered_points_leave_no_hole_and_no_spill(void **state)
{
  (void)state;
  made_run run = small_ring;
  run.cells = 100;
  run.turn = 0.39;
  check_ring_is_closed(&run);
  run.jitter = 0.2;
  check_ring_is_closed(&run);
  run.turn = 0.0;
  check_ring_is_closed(&run);
}

static void a_pixel_off_the_lattice_shows_its_nearest_point(void **state)
{
  (void)state;
  made_run run = small_ring;
  run.turn = 0.39;
  painted all = paint(&run, 400);
  for (int i = 0; i < all.cloud.count; ++i)
    assert_int_equal(pixel_at(&all.raster, all.position[0][i], all.position[1][i]), 1 + i);
  wipe(&all);
}

static void the_spacing_does_not_depend_on_the_thickness(void **state)
{
  (void)state;
  painted all = paint(&small_ring, 100);
  double *volume = malloc((size_t)all.cloud.count * sizeof *volume);
  for (int i = 0; i < all.cloud.count; ++i) volume[i] = 1e3;
  all.cloud.volume = volume;
  sdr_extent extent;
  assert_int_equal(sdr_raster_measure(&all.cloud, &extent), SDR_OK);
  assert_close(extent.spacing, all.extent.spacing, 1e-15);
  assert_true(extent.lattice);
  free(volume);
  wipe(&all);
}

static void a_body_of_two_spacings_is_closed(void **state)
{
  (void)state;
  enum { N = 20, M = 40 };
  double x[N * N + M * M], y[N * N + M * M], z[N * N + M * M] = {0.0}, volume[N * N + M * M];
  float value[N * N + M * M];
  int count = 0;
  for (int k = 0; k < N * N; ++k, ++count) {
    x[count] = -N + k % N + 0.5;
    y[count] = k / N + 0.5;
    volume[count] = 2.0;
  }
  for (int k = 0; k < M * M; ++k, ++count) {
    x[count] = 0.5 * (k % M) + 0.25;
    y[count] = 0.5 * (double)(k / M) + 0.25;
    volume[count] = 0.5;
  }
  for (int i = 0; i < count; ++i) value[i] = x[i] < 0.0 ? 1.0F : 2.0F;
  const sdr_cloud cloud = {count, 2, {x, y, z}, volume};
  sdr_extent extent;
  sdr_raster raster;
  assert_int_equal(sdr_raster_measure(&cloud, &extent), SDR_OK);
  assert_close(extent.spacing, 0.5, 1e-12);
  const sdr_window window = sdr_raster_window(&extent, 1, 400);
  assert_int_equal(sdr_raster_paint(&cloud, &extent, value, &window, &raster), SDR_OK);
  for (double a = -N + 0.6; a < N - 0.6; a += 0.11)
    for (double b = 0.6; b < N - 0.6; b += 0.11) {
      const float seen = pixel_at(&raster, a, b);
      assert_true(seen > 0.0F);
      if (fabs(a) > 0.3) assert_true(seen == (a < 0.0 ? 1.0F : 2.0F));
    }
  sdr_raster_clear(&raster);
}

static void the_nearer_cube_hides_the_farther(void **state)
{
  (void)state;
  const made_run block = {.dimension = 3, .cells = 8, .law = "none", .frames = 1};
  painted all = paint(&block, 200);
  double plane[2], depth;
  /* the top face of a corner that the eye sees: x largest, y smallest, z largest */
  int nearest = 0;
  double best = -INFINITY;
  for (int i = 0; i < all.cloud.count; ++i) {
    const double at[3] = {all.position[0][i], all.position[1][i], all.position[2][i]};
    sdr_raster_project(at, 3, plane, &depth);
    if (depth > best) nearest = i;
    best = fmax(best, depth);
  }
  const double corner[3] = {all.position[0][nearest], all.position[1][nearest],
                            all.position[2][nearest]};
  sdr_raster_project(corner, 3, plane, &depth);
  assert_int_equal(pixel_at(&all.raster, plane[0], plane[1]), 1 + nearest);
  float shades = 0.0F;
  for (int k = 0; k < all.raster.window.width * all.raster.window.height; ++k)
    if (!isnan(all.raster.value[k])) shades = fmaxf(shades, 1.0F - all.raster.shade[k]);
  assert_true(shades > 0.1F);
  wipe(&all);
}

static void cells_smaller_than_pixels_show_the_largest_magnitude(void **state)
{
  (void)state;
  enum { N = 1000 };
  double *x = malloc(N * N * sizeof *x), *y = malloc(N * N * sizeof *y);
  float *value = calloc(N * N, sizeof *value);
  for (int k = 0; k < N * N; ++k) {
    x[k] = k % N;
    y[k] = (double)(k / N);
  }
  for (int k = 0; k < N; ++k) value[N * 500 + k] = -1.0F; /* a crack of one row */
  const sdr_cloud cloud = {N * N, 2, {x, y, y}, NULL};
  sdr_extent extent;
  sdr_raster raster;
  assert_int_equal(sdr_raster_measure(&cloud, &extent), SDR_OK);
  const sdr_window window = sdr_raster_window(&extent, 1, 100);
  assert_true(window.pixel > 3.0 && window.width < 400);
  assert_int_equal(sdr_raster_paint(&cloud, &extent, value, &window, &raster), SDR_OK);
  for (int k = 5; k < N - 5; ++k) assert_true(pixel_at(&raster, k, 500.0) == -1.0F);
  sdr_raster_clear(&raster);
  free(x);
  free(y);
  free(value);
}

static void one_point_and_points_in_one_place_are_drawn(void **state)
{
  (void)state;
  const double x[3] = {0.5, 0.5, 0.5}, zero[3] = {0.0, 0.0, 0.0};
  const float value[3] = {1.0F, 1.0F, 1.0F};
  for (int count = 1; count <= 3; count += 2) {
    const sdr_cloud cloud = {count, 2, {x, zero, zero}, NULL};
    sdr_extent extent;
    sdr_raster raster;
    assert_int_equal(sdr_raster_measure(&cloud, &extent), SDR_OK);
    const sdr_window window = sdr_raster_window(&extent, 1, 50);
    assert_int_equal(sdr_raster_paint(&cloud, &extent, value, &window, &raster), SDR_OK);
    assert_true(pixel_at(&raster, 0.5, 0.0) == 1.0F);
    sdr_raster_clear(&raster);
  }
}

static void points_without_a_finite_value_stay_empty(void **state)
{
  (void)state;
  painted all = paint(&small_ring, 100);
  const sdr_window window = all.raster.window;
  sdr_raster_clear(&all.raster);
  all.value[7] = NAN;
  all.value[9] = INFINITY;
  assert_int_equal(sdr_raster_paint(&all.cloud, &all.extent, all.value, &window, &all.raster),
                   SDR_OK);
  assert_true(isnan(pixel_at(&all.raster, all.position[0][7], all.position[1][7])));
  assert_true(isnan(pixel_at(&all.raster, all.position[0][9], all.position[1][9])));
  assert_int_equal(pixel_at(&all.raster, all.position[0][8], all.position[1][8]), 9);
  wipe(&all);
}

/* ---- units and colours ---- */

static void numbers_get_the_prefix_that_makes_them_readable(void **state)
{
  (void)state;
  static const struct {
    double value;
    const char *unit, *text;
  } cases[] = {{43.6e-6, "s", "43.6 us"}, {1e-3, "m", "1 mm"},
               {0.0, "J", "0 J"},         {-12345.0, "J", "-12.35 kJ"},
               {999.96, "Pa", "1000 Pa"}, {2.5, "", "2.5"},
               {NAN, "J", "-"},           {1e30, "J", "1e+30 J"}};
  char text[64];
  for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
    sdr_quantity(cases[k].value, cases[k].unit, 4, text, sizeof text);
    assert_string_equal(text, cases[k].text);
  }
  sdr_time_text(1.5e-3, text, sizeof text);
  assert_string_equal(text, "1500 µs");
  sdr_axis_label("strain xx", "", sdr_prefix_for(2e-4), text, sizeof text);
  assert_string_equal(text, "strain xx (10⁻⁶)");
}

static double lightness(const unsigned char rgb[3])
{
  return 0.2126 * pow(rgb[0], 2.2) + 0.7152 * pow(rgb[1], 2.2) + 0.0722 * pow(rgb[2], 2.2);
}

static void damage_darkens_all_along_its_scale(void **state)
{
  (void)state;
  unsigned char rgb[3];
  double before = INFINITY;
  for (int k = 0; k <= 100; ++k) {
    sdr_palette_colour(&sdr_palette_damage, k / 100.0, rgb);
    assert_true(lightness(rgb) < before);
    before = lightness(rgb);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_cell_of_a_lattice_covers_the_same_whole_number_of_pixels),
      cmocka_unit_test(turned_and_jittered_points_leave_no_hole_and_no_spill),
      cmocka_unit_test(a_pixel_off_the_lattice_shows_its_nearest_point),
      cmocka_unit_test(the_spacing_does_not_depend_on_the_thickness),
      cmocka_unit_test(a_body_of_two_spacings_is_closed),
      cmocka_unit_test(the_nearer_cube_hides_the_farther),
      cmocka_unit_test(cells_smaller_than_pixels_show_the_largest_magnitude),
      cmocka_unit_test(one_point_and_points_in_one_place_are_drawn),
      cmocka_unit_test(points_without_a_finite_value_stay_empty),
      cmocka_unit_test(numbers_get_the_prefix_that_makes_them_readable),
      cmocka_unit_test(damage_darkens_all_along_its_scale),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
