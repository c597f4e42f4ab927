/* geometry: searches among points, against a search over all of them. */
#include "geometry/point_grid.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <stdlib.h>

static double noise(uint64_t *seed)
{
  *seed = *seed * 6364136223846793005u + 1442695040888963407u;
  return (double)(*seed >> 11) / 9007199254740992.0;
}

static sdr_points *random_points(int32_t count, int components, uint64_t seed)
{
  sdr_points *points = NULL;
  assert_int_equal(sdr_points_create(count, components, 0, &points), SDR_OK);
  for (int32_t i = 0; i < count; ++i) {
    for (int c = 0; c < components; ++c) points->x[c][i] = noise(&seed);
    points->spacing[i] = 0.2 + 0.3 * noise(&seed);
  }
  return points;
}

static double distance(const sdr_points *points, int32_t i, const double x[3])
{
  double sum = 0.0;
  for (int c = 0; c < points->components; ++c) {
    sum += (points->x[c][i] - x[c]) * (points->x[c][i] - x[c]);
  }
  return sqrt(sum);
}

typedef struct {
  int visits, wrong;
  double radius;
} tally;

static void count(void *context, int32_t point, double away)
{
  tally *t = context;
  (void)point;
  ++t->visits;
  t->wrong += away > t->radius;
}

static void searches_agree_with_looking_at_every_point(void **state)
{
  (void)state;
  for (int components = 1; components <= 3; ++components) {
    sdr_points *points = random_points(500, components, 11u + (unsigned)components);
    sdr_point_grid *grid = NULL;
    uint64_t seed = 5;
    assert_int_equal(sdr_point_grid_create(points, &grid), SDR_OK);
    for (int k = 0; k < 300; ++k) {
      double x[3] = {0.0};
      for (int c = 0; c < components; ++c) x[c] = 2.0 * noise(&seed) - 0.5;
      int32_t best = 0;
      tally t = {.radius = 0.5 * noise(&seed)};
      int wanted = 0;
      for (int32_t i = 0; i < points->count; ++i) {
        if (distance(points, i, x) < distance(points, best, x)) best = i;
        wanted += distance(points, i, x) <= t.radius;
      }
      const int far = distance(points, best, x) > 2.0 * points->spacing[best];
      assert_int_equal(sdr_point_grid_nearest(grid, x), far ? -1 : best);
      sdr_point_grid_within(grid, x, t.radius, count, &t);
      assert_int_equal(t.visits, wanted);
      assert_int_equal(t.wrong, 0);
    }
    sdr_point_grid_destroy(&grid);
    sdr_points_destroy(&points);
  }
}

static void of_points_as_near_the_first_generated_is_taken(void **state)
{
  (void)state;
  sdr_points *points = NULL;
  sdr_point_grid *grid = NULL;
  assert_int_equal(sdr_points_create(4, 2, 0, &points), SDR_OK);
  const double corner[4][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
  for (int i = 0; i < 4; ++i) {
    points->x[0][i] = corner[i][0];
    points->x[1][i] = corner[i][1];
    points->spacing[i] = 1.0;
  }
  assert_int_equal(sdr_point_grid_create(points, &grid), SDR_OK);
  const double middle[3] = {0.5, 0.5 + 1e-10, 0}, edge[3] = {0.5 + 1e-10, 1.2, 0};
  const double clear[3] = {0.5 + 1e-8, 1.2, 0};
  assert_int_equal(sdr_point_grid_nearest(grid, middle), 0);
  assert_int_equal(sdr_point_grid_nearest(grid, edge), 2);
  assert_int_equal(sdr_point_grid_nearest(grid, clear), 3);
  int32_t order[4] = {3, 2, 1, 0};
  points->generated = order;
  assert_int_equal(sdr_point_grid_nearest(grid, middle), 3);
  points->generated = NULL;
  sdr_point_grid_destroy(&grid);
  sdr_points_destroy(&points);
}

static void points_beyond_two_spacings_are_not_met(void **state)
{
  (void)state;
  sdr_points *points = NULL;
  sdr_point_grid *grid = NULL;
  assert_int_equal(sdr_points_create(1, 1, 0, &points), SDR_OK);
  points->spacing[0] = 0.5;
  assert_int_equal(sdr_point_grid_create(points, &grid), SDR_OK);
  assert_int_equal(sdr_point_grid_nearest(grid, (double[3]){1.0, 0, 0}), 0);
  assert_int_equal(sdr_point_grid_nearest(grid, (double[3]){-1.001, 0, 0}), -1);
  assert_int_equal(sdr_point_grid_nearest(grid, (double[3]){1e30, 0, 0}), -1);
  sdr_point_grid_destroy(&grid);
  sdr_points_destroy(&points);
}

static void far_apart_points_need_no_memory_for_the_void(void **state)
{
  (void)state;
  sdr_points *points = NULL;
  sdr_point_grid *grid = NULL;
  assert_int_equal(sdr_points_create(2, 3, 0, &points), SDR_OK);
  for (int c = 0; c < 3; ++c) points->x[c][1] = 1e6;
  points->spacing[0] = points->spacing[1] = 1e-3;
  assert_int_equal(sdr_point_grid_create(points, &grid), SDR_OK);
  assert_int_equal(sdr_point_grid_nearest(grid, (double[3]){1e6, 1e6, 1e6 + 1e-3}), 1);
  sdr_point_grid_destroy(&grid);
  sdr_points_destroy(&points);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(searches_agree_with_looking_at_every_point),
      cmocka_unit_test(of_points_as_near_the_first_generated_is_taken),
      cmocka_unit_test(points_beyond_two_spacings_are_not_met),
      cmocka_unit_test(far_apart_points_need_no_memory_for_the_void),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
