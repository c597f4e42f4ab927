/* nom: bonds of nested lattices lie on runs within a level and are loose across levels. */
#include "base/memory.h"
#include "nom/bonds.h"
#include "support/cmocka_all.h"

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

/* ---- the naive search ------------------------------------------------------------------------ */

enum { IN_I = 1, IN_J = 2, FOUND = 4 };

typedef struct {
  const sdr_points *points;
  char *mark; /* count x count, for i < j */
  int64_t pairs, directed, visited, across;
} table;

static char *entry(const table *t, int32_t i, int32_t j)
{
  const int32_t low = i < j ? i : j, high = i < j ? j : i;
  return t->mark + (size_t)low * (size_t)t->points->count + (size_t)high;
}

static table naive(const sdr_points *points)
{
  const size_t n = (size_t)points->count;
  table t = {.points = points, .mark = sdr_alloc(n * n, 1)};
  for (int32_t i = 0; i < points->count; ++i)
    for (int32_t j = i + 1; j < points->count; ++j) {
      double square = 0.0;
      for (int a = 0; a < points->components; ++a) {
        const double d = points->x[a][j] - points->x[a][i];
        square += d * d;
      }
      const double distance = sqrt(square) * (1.0 - 0.5e-9);
      const int ij = distance <= points->horizon[i], ji = distance <= points->horizon[j];
      *entry(&t, i, j) = (char)((ij ? IN_I : 0) | (ji ? IN_J : 0));
      t.pairs += ij || ji;
      t.directed += ij + ji;
      t.across += (ij || ji) && points->level[i] != points->level[j];
    }
  return t;
}

static void check_slot(void *context, const sdr_pair *pair)
{
  table *t = context;
  const sdr_points *points = t->points;
  char *mark = entry(t, pair->i, pair->j);
  const int ij = (*mark & (pair->i < pair->j ? IN_I : IN_J)) != 0;
  const int ji = (*mark & (pair->i < pair->j ? IN_J : IN_I)) != 0;
  assert_true(ij || ji);
  assert_true(pair->weight_ij == (ij ? 1.0 : 0.0) && pair->weight_ji == (ji ? 1.0 : 0.0));
  if (!pair->loose) assert_int_equal(points->level[pair->i], points->level[pair->j]);
  double square = 0.0;
  for (int a = 0; a < points->components; ++a) {
    const double xi = points->x[a][pair->j] - points->x[a][pair->i];
    assert_true(fabs(pair->xi[a] - xi) < 1e-12);
    square += xi * xi;
  }
  assert_true(fabs(pair->length - sqrt(square)) < 1e-12);
  if (!pair->primary) return;
  assert_false(*mark & FOUND);
  *mark |= FOUND;
  ++t->visited;
}

static void bonds_of_nested_lattices_hold_each_pair_once(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int levels = 0; levels < 2; ++levels) {
      sdr_points *points = make_points(&shapes[k]);
      const sdr_bonds_how how = {.levels = levels};
      sdr_bonds *bonds;
      assert_int_equal(sdr_bonds_create(points, &how, &bonds), SDR_OK);
      table t = naive(points);
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
    table t = naive(points);
    assert_int_equal(bonds->loose_pairs, t.across);
    sdr_free(t.mark);
    sdr_bonds_destroy(&bonds);
    sdr_points_destroy(&points);
  }
}

static int stripe_of(const sdr_points *points, int32_t i)
{
  int s = 0;
  while (points->stripe_first[s + 1] <= i) ++s;
  return s;
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
    for (int s = 0; s < points->stripe_count; ++s)
      for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r) {
        const sdr_bond_run *run = &bonds->runs[r];
        const int i = stripe_of(points, run->i0), j = stripe_of(points, run->j0);
        assert_true((i == s && j == s) || (i == s && j == s + 1) || (i == s + 1 && j == s));
        assert_int_equal(stripe_of(points, run->i0 + run->length - 1), i);
        assert_int_equal(stripe_of(points, run->j0 + run->length - 1), j);
      }
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
  const sdr_bonds_how how = {.levels = 1};
  const size_t before = sdr_memory_now();
  sdr_bonds *bonds = NULL;
  long fails = 0;
  for (; fails < 200; ++fails) {
    sdr_memory_fail_after(fails);
    const sdr_status status = sdr_bonds_create(points, &how, &bonds);
    sdr_memory_fail_after(-1);
    if (status == SDR_OK) break;
    assert_int_equal(status, SDR_RUN_FAILED);
    assert_int_equal(sdr_memory_now(), before);
  }
  assert_true(fails > 10 && fails < 200);
  sdr_bonds_destroy(&bonds);
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
