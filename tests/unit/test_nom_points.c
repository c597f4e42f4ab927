/* nom: storage order, rows and stripes of points. */
#include "base/memory.h"
#include "nom/points.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <string.h>

/* A lattice in an order of generation that is not the order of storage; every value of a point can
   be told from its cell. */
static sdr_points *scrambled(const int32_t size[3], int components, double horizon)
{
  const int32_t count = size[0] * size[1] * size[2];
  sdr_points *points;
  assert_int_equal(sdr_points_create(count, components, 1, &points), SDR_OK);
  points->lattice_spacing = 0.5;
  for (int32_t k = 0; k < count; ++k) {
    const int32_t i = (int32_t)((int64_t)k * 7919 % count); /* 7919 is prime */
    const int32_t cell[3] = {k % size[0] - 5, k / size[0] % size[1] + 3, k / size[0] / size[1]};
    memcpy(points->cell + 3 * (size_t)i, cell, sizeof cell);
    for (int a = 0; a < components; ++a) points->x[a][i] = 0.5 * cell[a];
    points->volume[i] = 1.0 + i;
    points->spacing[i] = 0.5;
    points->horizon[i] = horizon;
    points->material[i] = (uint8_t)(i % 251);
  }
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  return points;
}

static const int32_t sizes[][3] = {{97, 1, 1},   {40, 50, 1}, {1300, 3, 1}, {3, 1300, 1},
                                   {20, 20, 20}, {5, 200, 4}, {4, 5, 200},  {200, 4, 5}};
static const int dimension_of[] = {1, 2, 2, 2, 3, 3, 3, 3};
enum { SIZES = sizeof dimension_of / sizeof *dimension_of };

static void values_move_with_their_points(void **state)
{
  (void)state;
  for (int k = 0; k < SIZES; ++k) {
    sdr_points *points = scrambled(sizes[k], dimension_of[k], 1.6);
    char *seen = sdr_alloc((size_t)points->count, 1);
    assert_non_null(points->generated);
    for (int32_t i = 0; i < points->count; ++i) {
      const int32_t g = points->generated[i];
      assert_false(seen[g]);
      seen[g] = 1;
      assert_true(points->volume[i] == 1.0 + g);
      assert_int_equal(points->material[i], g % 251);
    }
    assert_null(points->cell);
    sdr_free(seen);
    sdr_points_destroy(&points);
  }
}

static void rows_hold_every_point_once_along_their_axis(void **state)
{
  (void)state;
  for (int k = 0; k < SIZES; ++k) {
    sdr_points *points = scrambled(sizes[k], dimension_of[k], 1.6);
    int32_t next = 0;
    for (int r = 0; r < points->row_count; ++r) {
      const sdr_row *row = &points->rows[r];
      assert_int_equal(row->first, next);
      for (int32_t p = 0; p < row->length; ++p)
        for (int a = 0; a < points->components; ++a) {
          const double cell = row->cell[a] + (a == points->row_axis ? p : 0);
          assert_true(points->x[a][row->first + p] == 0.5 * cell);
        }
      next += row->length;
    }
    assert_int_equal(next, points->count);
    sdr_points_destroy(&points);
  }
}

static void stripes_hold_whole_rows_and_every_point(void **state)
{
  (void)state;
  for (int k = 0; k < SIZES; ++k) {
    sdr_points *points = scrambled(sizes[k], dimension_of[k], 1.6);
    assert_int_equal(points->stripe_first[0], 0);
    assert_int_equal(points->stripe_first[points->stripe_count], points->count);
    int s = 0;
    for (int r = 0; r < points->row_count; ++r) {
      while (points->rows[r].first >= points->stripe_first[s + 1]) ++s;
      assert_true(points->rows[r].first + points->rows[r].length <= points->stripe_first[s + 1]);
    }
    assert_true(points->stripe_count >= 1 && points->stripe_count <= 64);
    sdr_points_destroy(&points);
  }
}

static void points_in_order_keep_it(void **state)
{
  (void)state;
  sdr_points *points;
  assert_int_equal(sdr_points_create(50, 1, 1, &points), SDR_OK);
  points->lattice_spacing = 1.0;
  for (int32_t i = 0; i < 50; ++i) {
    points->cell[3 * i] = i;
    points->x[0][i] = i;
    points->horizon[i] = 2.0;
  }
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  assert_null(points->generated);
  for (int32_t i = 0; i < 50; ++i) assert_true(points->x[0][i] == i);
  sdr_points_destroy(&points);
}

static void near_points_without_a_lattice_are_stored_near(void **state)
{
  (void)state;
  const int32_t count = 64 * 64;
  sdr_points *points;
  assert_int_equal(sdr_points_create(count, 2, 0, &points), SDR_OK);
  for (int32_t k = 0; k < count; ++k) {
    const int32_t i = (int32_t)((int64_t)k * 7919 % count);
    points->x[0][i] = k % 64;
    points->x[1][i] = k / 64;
    points->horizon[i] = 3.0;
    points->volume[i] = i;
  }
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  double way = 0.0;
  for (int32_t i = 1; i < count; ++i)
    way += hypot(points->x[0][i] - points->x[0][i - 1], points->x[1][i] - points->x[1][i - 1]);
  assert_true(way / count < 2.0); /* at random it would be 33 */
  for (int32_t i = 0; i < count; ++i) assert_true(points->volume[i] == points->generated[i]);
  for (int s = 0; s < points->stripe_count; ++s) assert_int_equal(points->stripe_first[s] % 8, 0);
  sdr_points_destroy(&points);
}

static void the_nearest_of_equals_is_the_first_generated(void **state)
{
  (void)state;
  const int32_t size[3] = {7, 7, 1};
  sdr_points *points = scrambled(size, 2, 1.6);
  const double between[3] = {0.25, 2.75, 0.0}; /* the middle of four */
  const int32_t best = sdr_points_nearest(points, between);
  for (int32_t i = 0; i < points->count; ++i) {
    const double far = hypot(points->x[0][i] - between[0], points->x[1][i] - between[1]);
    if (far < 0.36) assert_true(points->generated[best] <= points->generated[i]);
  }
  assert_true(hypot(points->x[0][best] - 0.25, points->x[1][best] - 2.75) < 0.36);
  sdr_points_destroy(&points);
}

static void arrays_are_padded_for_whole_vectors(void **state)
{
  (void)state;
  for (int32_t count = 1; count < 40; ++count) {
    const sdr_points points = {.count = count};
    const size_t padded = sdr_points_padded(&points);
    assert_int_equal(padded % 8, 0);
    assert_true(padded >= (size_t)count + 8);
  }
}

static void every_failing_allocation_is_reported(void **state)
{
  (void)state;
  const size_t before = sdr_memory_now();
  long fails = 0;
  for (; fails < 50; ++fails) {
    sdr_points *points = NULL;
    sdr_memory_fail_after(fails);
    sdr_status status = sdr_points_create(30, 2, 1, &points);
    for (int32_t i = 0; i < 30 && status == SDR_OK; ++i) {
      points->cell[3 * i] = 29 - i;
      points->horizon[i] = 1.0;
    }
    if (status == SDR_OK) {
      points->lattice_spacing = 1.0;
      status = sdr_points_arrange(points);
    }
    sdr_memory_fail_after(-1);
    sdr_points_destroy(&points);
    assert_int_equal(sdr_memory_now(), before);
    if (status == SDR_OK) break;
    assert_int_equal(status, SDR_RUN_FAILED);
  }
  assert_true(fails > 8 && fails < 50);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(values_move_with_their_points),
      cmocka_unit_test(rows_hold_every_point_once_along_their_axis),
      cmocka_unit_test(stripes_hold_whole_rows_and_every_point),
      cmocka_unit_test(points_in_order_keep_it),
      cmocka_unit_test(near_points_without_a_lattice_are_stored_near),
      cmocka_unit_test(the_nearest_of_equals_is_the_first_generated),
      cmocka_unit_test(arrays_are_padded_for_whole_vectors),
      cmocka_unit_test(every_failing_allocation_is_reported),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
