/* nom: horizon sets by cells against looking at all pairs. */
#include "base/memory.h"
#include "base/parallel.h"
#include "nom/cells.h"
#include "nom/neighbourhood.h"
#include "support/cmocka_all.h"
#include "support/noise.h"

#include <math.h>

/* `count` points in a box with the given edges; horizons between `least` and `most`. */
static sdr_points *cloud(int32_t count, int components, const double edge[3], double least,
                         double most, uint64_t seed)
{
  sdr_points *points;
  assert_int_equal(sdr_points_create(count, components, 0, &points), SDR_OK);
  for (int32_t i = 0; i < count; ++i) {
    for (int a = 0; a < components; ++a) points->x[a][i] = edge[a] * (0.5 * noise(&seed) + 0.2);
    points->horizon[i] = least + (most - least) * (0.5 + 0.5 * noise(&seed));
    points->spacing[i] = points->volume[i] = 1.0;
  }
  points->irregular = 1;
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  return points;
}

/* Without the pairs that `held` says runs hold; NULL: all. */
static void compare_beside(sdr_points *points, const sdr_lattice_groups *held)
{
  sdr_neighbourhood near;
  assert_int_equal(sdr_neighbourhood_beside(points, held, &near), SDR_OK);
  for (int32_t i = 0; i < points->count; ++i) {
    int64_t k = near.row[i];
    for (int32_t j = 0; j < points->count; ++j) {
      double square = 0.0;
      for (int a = 0; a < points->components; ++a)
        square += pow(points->x[a][j] - points->x[a][i], 2.0);
      if (held && sdr_on_run(held, i, j)) continue;
      if (j == i || sqrt(square) > points->horizon[i] * (1.0 + 0.5e-9)) continue;
      assert_true(k < near.row[i + 1]);
      assert_int_equal(near.column[k], j);
      ++k;
    }
    assert_int_equal(k, near.row[i + 1]);
  }
  sdr_neighbourhood_destroy(&near);
  sdr_points_destroy(&points);
}

static void compare_with_all_pairs(sdr_points *points)
{
  compare_beside(points, NULL);
}

/* Halves of a box of one group each, with a few points of no group and a few of the border. */
static void pairs_that_runs_hold_are_left_out(void **state)
{
  (void)state;
  const double cube[3] = {10.0, 10.0, 10.0};
  for (int components = 1; components <= 3; ++components) {
    uint8_t group[600], border[600];
    sdr_points *points = cloud(600, components, cube, 0.3, 2.0, 9);
    for (int32_t i = 0; i < points->count; ++i) {
      group[i] = i % 97 == 0 ? 0 : points->x[0][i] < 2.0 ? 1 : 2;
      border[i] = i % 61 == 0;
    }
    const sdr_lattice_groups halves = {.of_point = group},
                             bordered = {.of_point = group, .border = border};
    compare_beside(points, &halves);
    compare_beside(cloud(600, components, cube, 0.3, 2.0, 9), &bordered);
  }
}

static void cells_find_what_all_pairs_find(void **state)
{
  (void)state;
  const double cube[3] = {10.0, 10.0, 10.0}, needle[3] = {1000.0, 1.0, 1.0};
  const double sheet[3] = {40.0, 0.1, 30.0};
  for (int components = 1; components <= 3; ++components) {
    compare_with_all_pairs(cloud(700, components, cube, 0.5, 2.0, 3));
    compare_with_all_pairs(cloud(300, components, cube, 0.02, 9.0, 4));
    compare_with_all_pairs(cloud(500, components, needle, 0.3, 12.0, 5));
    compare_with_all_pairs(cloud(600, components, sheet, 1.0, 3.0, 6));
    compare_with_all_pairs(cloud(40, components, cube, 50.0, 60.0, 7)); /* all of all */
    compare_with_all_pairs(cloud(40, components, cube, 1e-6, 1e-6, 8)); /* none of any */
  }
}

static void one_point_has_no_neighbour(void **state)
{
  (void)state;
  const double cube[3] = {1.0, 1.0, 1.0};
  compare_with_all_pairs(cloud(1, 2, cube, 1.0, 1.0, 9));
}

static void a_neighbour_on_the_edge_of_the_horizon_counts_as_inside(void **state)
{
  (void)state;
  sdr_points *points;
  assert_int_equal(sdr_points_create(3, 1, 0, &points), SDR_OK);
  const double x[3] = {0.0, 0.3, 0.3 * (2.0 + 1e-6)}; /* the last just beyond */
  for (int i = 0; i < 3; ++i) {
    points->x[0][i] = x[i];
    points->horizon[i] = 0.3;
    points->spacing[i] = points->volume[i] = 0.3;
  }
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  sdr_neighbourhood near;
  assert_int_equal(sdr_neighbourhood_create(points, &near), SDR_OK);
  assert_int_equal(near.row[3], 2);
  assert_int_equal(near.column[0], 1);
  assert_int_equal(near.column[1], 0);
  sdr_neighbourhood_destroy(&near);
  sdr_points_destroy(&points);
}

static void cells_hold_every_point_once(void **state)
{
  (void)state;
  const double edge[3] = {7.0, 5.0, 3.0};
  sdr_points *points = cloud(500, 3, edge, 1.0, 1.0, 12);
  sdr_cells cells;
  char seen[500] = {0};
  assert_int_equal(sdr_cells_create(points, 0.9, &cells), SDR_OK);
  const int64_t count = (int64_t)cells.n[0] * cells.n[1] * cells.n[2];
  assert_int_equal(cells.first[0], 0);
  assert_int_equal(cells.first[count], 500);
  for (int64_t k = 0; k < 500; ++k) {
    assert_false(seen[cells.point[k]]);
    seen[cells.point[k]] = 1;
  }
  sdr_cells_destroy(&cells);
  sdr_points_destroy(&points);
}

static void every_failing_allocation_is_reported(void **state)
{
  (void)state;
  const double cube[3] = {4.0, 4.0, 4.0};
  sdr_points *points = cloud(60, 2, cube, 1.0, 2.0, 13);
  sdr_neighbourhood near = {0};
  const size_t before = sdr_memory_now();
  long fails = 0;
  sdr_status status = SDR_RUN_FAILED;
  for (; status != SDR_OK && fails < 100; ++fails) {
    sdr_memory_fail_after(fails);
    status = sdr_neighbourhood_create(points, &near);
    sdr_memory_fail_after(-1);
    if (status == SDR_OK) break;
    assert_int_equal(status, SDR_RUN_FAILED);
    assert_null(near.row);
    assert_int_equal(sdr_memory_now(), before);
  }
  assert_true(fails >= 4);
  sdr_neighbourhood_destroy(&near);
  sdr_points_destroy(&points);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pairs_that_runs_hold_are_left_out),
      cmocka_unit_test(cells_find_what_all_pairs_find),
      cmocka_unit_test(one_point_has_no_neighbour),
      cmocka_unit_test(a_neighbour_on_the_edge_of_the_horizon_counts_as_inside),
      cmocka_unit_test(cells_hold_every_point_once),
      cmocka_unit_test(every_failing_allocation_is_reported),
  };
  sdr_set_threads(2);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
