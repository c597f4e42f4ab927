/* nom: supports by radius and by count against looking at all pairs. */
#include "base/parallel.h"
#include "nom/support.h"
#include "support/grid.h"

#include <stdlib.h>
#include <string.h>

static double square_between(const sdr_cloud *cloud, int32_t i, int32_t j)
{
  double square = 0.0;
  for (int a = 0; a < cloud->components; ++a) square += pow(cloud->x[a][j] - cloud->x[a][i], 2.0);
  return square;
}

static int rising(const void *a, const void *b)
{
  const double left = *(const double *)a, right = *(const double *)b;
  return (left > right) - (left < right);
}

/* Row i holds exactly the other points within `limit` (squared, ties in), ascending. */
static void expect_within(const sdr_support *s, int32_t i, double limit)
{
  int64_t k = s->row[i];
  for (int32_t j = 0; j < s->cloud.count; ++j) {
    if (j == i || square_between(&s->cloud, i, j) > limit * (1.0 + 0.5e-9)) continue;
    assert_true(k < s->row[i + 1]);
    assert_int_equal(s->column[k], j);
    ++k;
  }
  assert_int_equal(k, s->row[i + 1]);
}

static void expect_nearest(const sdr_support *s, int32_t i, int nearest)
{
  double *square = sdr_alloc((size_t)s->cloud.count, sizeof *square);
  for (int32_t j = 0; j < s->cloud.count; ++j) square[j] = square_between(&s->cloud, i, j);
  qsort(square, (size_t)s->cloud.count, sizeof *square, rising);
  expect_within(s, i, square[nearest]); /* square[0] is the point's own */
  int64_t held = s->row[i + 1] - s->row[i];
  assert_true(held >= nearest);
  assert_near(s->radius[i], sqrt(square[held]), 1e-12);
  sdr_free(square);
}

/* A cloud that is dense at one end, so that cells hold few or many points. */
static void crowd(grid *g)
{
  for (int32_t i = 0; i < g->count; ++i)
    for (int a = 0; a < g->components; ++a) g->x[a][i] = pow(g->x[a][i] + 0.01, 3.0);
}

static void cells_find_the_nearest_that_all_pairs_find(void **state)
{
  (void)state;
  const int cells[3] = {400, 22, 8};
  for (int d = 1; d <= 3; ++d)
    for (int form = 0; form < 3; ++form) {
      grid g;
      grid_create(d, cells[d - 1], form == 0 ? 0.0 : 0.4, 1.0, &g);
      if (form == 2) crowd(&g);
      for (int nearest = 1; nearest < 40; nearest += 13) {
        sdr_support s;
        assert_int_equal(sdr_support_by_count(&g.cloud, nearest, &s), SDR_OK);
        for (int32_t i = 0; i < g.count; i += 7) expect_nearest(&s, i, nearest);
        sdr_support_destroy(&s);
      }
      grid_destroy(&g);
    }
}

static void cells_find_all_within_radii_that_differ(void **state)
{
  (void)state;
  const int cells[3] = {300, 20, 8};
  for (int d = 1; d <= 3; ++d) {
    grid g;
    sdr_support s;
    uint64_t seed = 11;
    grid_create(d, cells[d - 1], 0.3, 1.0, &g);
    double *radius = sdr_alloc((size_t)g.count, sizeof *radius);
    for (int32_t i = 0; i < g.count; ++i) radius[i] = (2.2 + 2.0 * noise(&seed)) / g.cells;
    assert_int_equal(sdr_support_by_radius(&g.cloud, radius, &s), SDR_OK);
    for (int32_t i = 0; i < g.count; ++i) {
      expect_within(&s, i, radius[i] * radius[i]);
      assert_true(s.radius[i] == radius[i]);
    }
    sdr_support_destroy(&s);
    sdr_free(radius);
    grid_destroy(&g);
  }
}

static void all_that_tie_for_the_last_place_are_in(void **state)
{
  (void)state;
  grid g;
  sdr_support s;
  grid_create(2, 10, 0.0, 1.0, &g);
  const int32_t middle = 5 * 11 + 5, corner = 0;
  const int asked[] = {1, 4, 5, 9, 14, 21, 22}, held[] = {4, 4, 8, 12, 20, 24, 24};
  const int at_corner[] = {2, 5, 5, 10, 14, 21, 22};
  for (int k = 0; k < 7; ++k) {
    assert_int_equal(sdr_support_by_count(&g.cloud, asked[k], &s), SDR_OK);
    assert_int_equal(s.row[middle + 1] - s.row[middle], held[k]);
    assert_true(s.row[corner + 1] - s.row[corner] >= asked[k]);
    if (k < 3) assert_int_equal(s.row[corner + 1] - s.row[corner], at_corner[k]);
    sdr_support_destroy(&s);
  }
  grid_destroy(&g);
}

static void the_order_of_the_points_does_not_matter(void **state)
{
  (void)state;
  grid g, turned;
  sdr_support s, t;
  grid_create(2, 12, 0.2, 1.0, &g);
  grid_create(2, 12, 0.2, 1.0, &turned);
  for (int a = 0; a < 2; ++a)
    for (int32_t i = 0; i < g.count; ++i) turned.x[a][g.count - 1 - i] = g.x[a][i];
  assert_int_equal(sdr_support_by_count(&g.cloud, 8, &s), SDR_OK);
  assert_int_equal(sdr_support_by_count(&turned.cloud, 8, &t), SDR_OK);
  for (int32_t i = 0; i < g.count; ++i) {
    const int32_t o = g.count - 1 - i;
    const int64_t held = s.row[i + 1] - s.row[i];
    assert_int_equal(held, t.row[o + 1] - t.row[o]);
    for (int64_t k = 0; k < held; ++k)
      assert_int_equal(s.column[s.row[i] + k], g.count - 1 - t.column[t.row[o + 1] - 1 - k]);
  }
  sdr_support_destroy(&s);
  sdr_support_destroy(&t);
  grid_destroy(&g);
  grid_destroy(&turned);
}

static void points_on_a_line_in_space_have_supports(void **state)
{
  (void)state;
  double x[50], zero[50] = {0.0}, other[50];
  for (int i = 0; i < 50; ++i) {
    x[i] = i;
    other[i] = 1e-9 * i;
  }
  const sdr_cloud cloud = {3, 50, {zero, x, other}, NULL};
  sdr_support s;
  assert_int_equal(sdr_support_by_count(&cloud, 4, &s), SDR_OK);
  for (int32_t i = 0; i < 50; ++i) expect_nearest(&s, i, 4);
  sdr_support_destroy(&s);
}

static void only_those_that_ask_grow(void **state)
{
  (void)state;
  grid g;
  sdr_support s;
  grid_create(2, 12, 0.3, 1.0, &g);
  assert_int_equal(sdr_support_by_count(&g.cloud, 6, &s), SDR_OK);
  int32_t *wanted = sdr_alloc((size_t)g.count, sizeof *wanted);
  wanted[3] = 20;
  wanted[77] = 1000000;
  assert_int_equal(sdr_support_enlarge(&s, wanted), SDR_OK);
  for (int32_t i = 0; i < g.count; ++i)
    expect_nearest(&s, i, i == 3 ? 20 : i == 77 ? g.count - 1 : 6);
  sdr_free(wanted);
  sdr_support_destroy(&s);
  grid_destroy(&g);
}

static void horizon_sets_become_supports(void **state)
{
  (void)state;
  sdr_points *points;
  assert_int_equal(sdr_points_create(60, 2, 0, &points), SDR_OK);
  uint64_t seed = 3;
  for (int32_t i = 0; i < 60; ++i) {
    for (int a = 0; a < 2; ++a) points->x[a][i] = noise(&seed);
    points->horizon[i] = 0.4 + 0.1 * noise(&seed);
    points->volume[i] = points->spacing[i] = 0.1;
  }
  points->irregular = 1;
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  sdr_neighbourhood near;
  sdr_support s;
  const sdr_cloud cloud = sdr_cloud_of(points);
  assert_int_equal(sdr_neighbourhood_create(points, &near), SDR_OK);
  assert_int_equal(sdr_support_of_neighbourhood(&cloud, points->horizon, &near, &s), SDR_OK);
  for (int32_t i = 0; i < 60; ++i) {
    expect_within(&s, i, points->horizon[i] * points->horizon[i]);
    assert_true(s.radius[i] == points->horizon[i]);
  }
  assert_ptr_equal(s.cloud.volume, points->volume);
  sdr_support_destroy(&s);
  sdr_neighbourhood_destroy(&near);
  sdr_points_destroy(&points);
}

static void any_number_of_threads_finds_the_same(void **state)
{
  (void)state;
  const int threads = sdr_threads();
  grid g;
  sdr_support one, three;
  grid_create(2, 40, 0.3, 1.0, &g);
  sdr_set_threads(1);
  assert_int_equal(sdr_support_by_count(&g.cloud, 14, &one), SDR_OK);
  sdr_set_threads(3);
  assert_int_equal(sdr_support_by_count(&g.cloud, 14, &three), SDR_OK);
  sdr_set_threads(threads);
  const size_t entries = (size_t)one.row[g.count];
  assert_memory_equal(one.row, three.row, ((size_t)g.count + 1) * sizeof *one.row);
  assert_memory_equal(one.column, three.column, entries * sizeof *one.column);
  assert_memory_equal(one.radius, three.radius, (size_t)g.count * sizeof *one.radius);
  sdr_support_destroy(&one);
  sdr_support_destroy(&three);
  grid_destroy(&g);
}

static void wrong_input_is_named(void **state)
{
  (void)state;
  double x[4] = {0.0, 1.0, 2.0, 1.0}, y[4] = {0.0, 0.5, 0.0, 0.5}, r[4] = {1.5, 1.5, 0.0, 1.5};
  sdr_cloud cloud = {2, 4, {x, y, NULL}, NULL};
  sdr_support s;
  assert_int_equal(sdr_support_by_count(&cloud, 3, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "point 1 at (1, 0.5) and point 3 coincide: remove one of them");
  assert_int_equal(sdr_support_by_count(&cloud, 4, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "supports of 4 nearest points need at least 5 points, and there are 4");
  assert_int_equal(sdr_support_by_count(&cloud, 0, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "a support of 0 nearest points: give 1 to 1000");
  assert_int_equal(sdr_support_by_radius(&cloud, r, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "point 2 at (2, 0): the radius of a support must be positive, not 0");
  x[2] = NAN;
  assert_int_equal(sdr_support_by_count(&cloud, 3, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "point 2 at (nan, 0): a position must be a finite number");
  cloud.count = 0;
  assert_int_equal(sdr_support_by_count(&cloud, 3, &s), SDR_BAD_INPUT);
  cloud.components = 4;
  assert_int_equal(sdr_support_by_count(&cloud, 3, &s), SDR_BAD_INPUT);
}

static void no_memory_leaves_nothing_behind(void **state)
{
  (void)state;
  grid g;
  grid_create(2, 6, 0.2, 1.0, &g);
  const size_t before = sdr_memory_now();
  sdr_support s = {0};
  int32_t wanted[49] = {[4] = 30};
  sdr_status status = SDR_RUN_FAILED;
  long passed = 0;
  for (; status != SDR_OK && passed < 50; ++passed) {
    sdr_memory_fail_after(passed);
    status = sdr_support_by_count(&g.cloud, 6, &s);
    sdr_memory_fail_after(-1);
    assert_true(status == SDR_OK || sdr_memory_now() == before);
  }
  assert_true(passed > 4 && status == SDR_OK);
  const size_t held = sdr_memory_now();
  sdr_memory_fail_after(3);
  assert_int_equal(sdr_support_enlarge(&s, wanted), SDR_RUN_FAILED);
  sdr_memory_fail_after(-1);
  assert_int_equal(sdr_memory_now(), held);
  expect_nearest(&s, 4, 6);
  sdr_support_destroy(&s);
  grid_destroy(&g);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cells_find_the_nearest_that_all_pairs_find),
      cmocka_unit_test(cells_find_all_within_radii_that_differ),
      cmocka_unit_test(all_that_tie_for_the_last_place_are_in),
      cmocka_unit_test(the_order_of_the_points_does_not_matter),
      cmocka_unit_test(points_on_a_line_in_space_have_supports),
      cmocka_unit_test(only_those_that_ask_grow),
      cmocka_unit_test(horizon_sets_become_supports),
      cmocka_unit_test(any_number_of_threads_finds_the_same),
      cmocka_unit_test(wrong_input_is_named),
      cmocka_unit_test(no_memory_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
