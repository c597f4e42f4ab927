/* nom: bonds of nested lattices lie on runs within a level and are loose across levels. */
#include "base/memory.h"
#include "nom/bonds.h"
#include "support/cmocka_all.h"
#include "support/every_pair.h"

#include <math.h>
#include <string.h>

/* A box of cells that `level_of` refines; horizons are ratio spacings or, if `fixed`, ratio. */
typedef struct {
  int components;
  int32_t size[3];
  double ratio, angle;
  int fixed;
  int (*level_of)(const int32_t cell[3]);
} graded;

static void put(sdr_points *points, const graded *g, const int32_t cell[3], int level)
{
  const int32_t i = points->count++;
  const double h = ldexp(1.0, -level), c = cos(g->angle), n = sin(g->angle);
  double q[3] = {0.0};
  for (int a = 0; a < g->components; ++a) q[a] = (cell[a] + 0.5) * h;
  const double x[3] = {c * q[0] - n * q[1], n * q[0] + c * q[1], q[2]};
  for (int a = 0; a < g->components; ++a) points->x[a][i] = g->components == 1 ? q[a] : x[a];
  points->spacing[i] = h;
  points->volume[i] = 1.0;
  points->horizon[i] = g->ratio * (g->fixed ? 1.0 : h);
  points->level[i] = (uint8_t)level;
  memcpy(points->cell + 3 * (size_t)i, cell, 3 * sizeof *cell);
}

static void put_cell(sdr_points *points, const graded *g, const int32_t cell[3], int level,
                     int wanted)
{
  if (level == wanted) {
    put(points, g, cell, level);
    return;
  }
  for (int k = 0; k < 1 << g->components; ++k) {
    int32_t child[3] = {0};
    for (int a = 0; a < g->components; ++a) child[a] = 2 * cell[a] + (k >> a & 1);
    put_cell(points, g, child, level + 1, wanted);
  }
}

static sdr_points *make_points(const graded *g)
{
  sdr_points *points;
  const int32_t cells = g->size[0] * g->size[1] * g->size[2], most = cells << 2 * g->components;
  assert_int_equal(sdr_points_create(most, g->components, 1, &points), SDR_OK);
  points->level = sdr_alloc(sdr_points_padded(points), 1);
  points->lattice_spacing = 1.0;
  if (g->components > 1) {
    points->axes[0][0] = points->axes[1][1] = cos(g->angle);
    points->axes[0][1] = sin(g->angle);
    points->axes[1][0] = -sin(g->angle);
  }
  points->count = 0;
  for (int32_t k = 0; k < cells; ++k) { /* from below zero on */
    const int32_t cell[3] = {k % g->size[0] - 3,
                             g->components > 1 ? k / g->size[0] % g->size[1] - 5 : 0,
                             g->components > 2 ? k / g->size[0] / g->size[1] - 1 : 0};
    put_cell(points, g, cell, 0, g->level_of(cell));
  }
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  return points;
}

static int in_the_middle(const int32_t cell[3])
{
  return cell[0] > 2 && cell[0] < 11 && cell[1] > -2 && cell[1] < 9;
}

static int twice_within_once(const int32_t cell[3])
{
  return in_the_middle(cell) + (cell[0] > 5 && cell[0] < 8 && cell[1] > 0);
}

/* Many patches, some next to points two levels up. */
static int patches(const int32_t cell[3])
{
  return (cell[0] + 30) % 7 < 3 && (cell[1] + 30) % 5 < 2 ? 1 + (cell[0] % 2 != 0) : 0;
}

static int one_in_nine(const int32_t cell[3])
{
  return cell[0] % 3 == 0 && cell[1] % 3 == 0;
}

static const graded shapes[] = {
    {1, {200, 1, 1}, 3.015, 0.0, 0, twice_within_once},
    {1, {200, 1, 1}, 2.6, 0.0, 1, patches},
    {2, {20, 18, 1}, 3.015, 0.0, 0, in_the_middle},
    {2, {18, 20, 1}, 3.015, 0.4, 0, twice_within_once},
    {2, {40, 12, 1}, 3.0, 0.0, 0, patches},
    {2, {12, 40, 1}, 2.6, 0.0, 1, in_the_middle},
    {2, {36, 40, 1}, 2.015, 0.0, 0, one_in_nine},
    {2, {42, 34, 1}, 2.6, 0.1, 1, patches},
    {3, {12, 10, 3}, 2.015, 0.0, 0, in_the_middle},
    {3, {3, 10, 36}, 2.6, 0.0, 0, one_in_nine},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

/* ---- bonds ----------------------------------------------------------------------------------- */

static void bonds_of_nested_lattices_hold_each_pair_once(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int levels = 0; levels < 2; ++levels) {
      sdr_points *points = make_points(&shapes[k]);
      const sdr_bonds_how how = {.levels = levels};
      sdr_bonds *bonds;
      assert_int_equal(sdr_bonds_create(points, &how, &bonds), SDR_OK);
      pair_table t = every_pair(points);
      sdr_bonds_visit(bonds, points, check_slot, &t);
      assert_int_equal(t.visited, t.pairs);
      assert_int_equal(bonds->pairs, t.pairs);
      assert_int_equal(bonds->directed, t.directed);
      assert_int_equal(bonds->run_count > 0, levels);
      assert_true(bonds->loose_pairs >= t.across);
      sdr_free(t.mark);
      sdr_bonds_destroy(&bonds);
      sdr_points_destroy(&points);
    }
}

/* In a body of large patches hardly more pairs are loose than those across levels. */
static void pairs_within_a_level_lie_on_runs(void **state)
{
  (void)state;
  for (int k = 2; k < 4; ++k) {
    sdr_points *points = make_points(&shapes[k]);
    const sdr_bonds_how how = {.levels = 1};
    sdr_bonds *bonds;
    assert_int_equal(sdr_bonds_create(points, &how, &bonds), SDR_OK);
    pair_table t = every_pair(points);
    assert_int_equal(bonds->loose_pairs, t.across);
    sdr_free(t.mark);
    sdr_bonds_destroy(&bonds);
    sdr_points_destroy(&points);
  }
}

static void runs_of_every_level_join_a_stripe_to_itself_or_the_next(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    sdr_points *points = make_points(&shapes[k]);
    const sdr_bonds_how how = {.levels = 1};
    sdr_bonds *bonds;
    assert_int_equal(sdr_bonds_create(points, &how, &bonds), SDR_OK);
    if (shapes[k].size[0] > 32 && shapes[k].size[1] > 32) assert_true(points->stripe_count > 4);
    check_stripes_of_runs(points, bonds);
    sdr_bonds_destroy(&bonds);
    sdr_points_destroy(&points);
  }
}

static void rows_are_of_one_level(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    sdr_points *points = make_points(&shapes[k]);
    int32_t next = 0;
    for (int r = 0; r < points->row_count; ++r) {
      const sdr_row *row = &points->rows[r];
      assert_int_equal(row->first, next);
      next += row->length;
      for (int32_t i = row->first; i < next; ++i) {
        double q[3] = {0.0}, x[3] = {0.0};
        assert_int_equal(points->level[i], row->level);
        for (int a = 0; a < points->components; ++a)
          q[a] = (row->cell[a] + (a == points->row_axis ? i - row->first : 0) + 0.5) *
                 points->spacing[i];
        for (int a = 0; a < points->components; ++a)
          for (int c = 0; c < points->components; ++c) x[c] += points->axes[a][c] * q[a];
        for (int c = 0; c < points->components; ++c)
          assert_true(fabs(points->x[c][i] - x[c]) < 1e-12);
      }
    }
    assert_int_equal(next, points->count);
    sdr_points_destroy(&points);
  }
}

static void every_failing_allocation_is_reported(void **state)
{
  (void)state;
  sdr_points *points = make_points(&shapes[6]);
  const long fails = count_failing_allocations(points, &(sdr_bonds_how){.levels = 1});
  assert_true(fails > 10 && fails < 200);
  sdr_points_destroy(&points);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(bonds_of_nested_lattices_hold_each_pair_once),
      cmocka_unit_test(pairs_within_a_level_lie_on_runs),
      cmocka_unit_test(runs_of_every_level_join_a_stripe_to_itself_or_the_next),
      cmocka_unit_test(rows_are_of_one_level),
      cmocka_unit_test(every_failing_allocation_is_reported),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
