/* nom: bonds as runs and as loose pairs hold every pair of the naive search once. */
#include "base/memory.h"
#include "base/parallel.h"
#include "nom/bonds.h"
#include "support/cmocka_all.h"
#include "support/every_pair.h"
#include "support/noise.h"

#include <math.h>
#include <string.h>

/* A lattice body: cells of a box that `keep` wants, turned by `angle`; jittered if jitter > 0. */
typedef struct {
  int components;
  int32_t size[3];
  double ratio, angle, jitter, spread;
  int (*keep)(const int32_t cell[3]);
  int force_loose;
} shape;

static void put_point(sdr_points *points, const shape *s, int32_t i, const int32_t cell[3],
                      uint64_t *seed)
{
  const double c = cos(s->angle), n = sin(s->angle);
  const double q[3] = {cell[0], cell[1], cell[2]};
  const double x[3] = {c * q[0] - n * q[1], n * q[0] + c * q[1], q[2]};
  for (int a = 0; a < s->components; ++a)
    points->x[a][i] = (s->components == 1 ? q[a] : x[a]) + s->jitter * noise(seed);
  points->spacing[i] = points->volume[i] = 1.0;
  points->horizon[i] = s->ratio * (1.0 + s->spread * noise(seed));
  if (points->cell) memcpy(points->cell + 3 * (size_t)i, cell, 3 * sizeof *cell);
}

static sdr_points *make_points(const shape *s)
{
  sdr_points *points;
  const int32_t all = s->size[0] * s->size[1] * s->size[2];
  assert_int_equal(sdr_points_create(all, s->components, s->jitter <= 0.0, &points), SDR_OK);
  if (s->components > 1) {
    points->axes[0][0] = points->axes[1][1] = cos(s->angle);
    points->axes[0][1] = sin(s->angle);
    points->axes[1][0] = -sin(s->angle);
  }
  points->lattice_spacing = 1.0;
  points->irregular = s->jitter > 0.0;
  uint64_t seed = 99;
  points->count = 0;
  for (int32_t z = 0; z < s->size[2]; ++z)
    for (int32_t y = 0; y < s->size[1]; ++y)
      for (int32_t x = 0; x < s->size[0]; ++x) {
        const int32_t cell[3] = {x, y, z};
        if (!s->keep || s->keep(cell)) put_point(points, s, points->count++, cell, &seed);
      }
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  return points;
}

/* ---- pairs ----------------------------------------------------------------------------------- */

static void check_bonds(const shape *s, int expect_runs)
{
  sdr_points *points = make_points(s);
  const sdr_bonds_how how = {.force_loose = s->force_loose};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(points, &how, &bonds), SDR_OK);
  pair_table t = every_pair(points);
  sdr_bonds_visit(bonds, points, check_slot, &t);
  assert_int_equal(t.visited, t.pairs);
  assert_int_equal(bonds->pairs, t.pairs);
  assert_int_equal(bonds->directed, t.directed);
  assert_int_equal(bonds->run_count > 0, expect_runs);
  assert_int_equal(bonds->loose_pairs, expect_runs ? 0 : t.pairs);
  sdr_free(t.mark);
  sdr_bonds_destroy(&bonds);
  sdr_points_destroy(&points);
}

/* Bonds of points with `bulk` flags: runs between two flagged points, all others loose. */
static void check_mixed(const shape *s)
{
  sdr_points *points = make_points(s);
  uint8_t *bulk = sdr_alloc((size_t)points->count, 1);
  for (int32_t i = 0; i < points->count; ++i) bulk[i] = i % 7 != 3 && i % 11 != 5;
  const sdr_bonds_how how = {.bulk = bulk};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(points, &how, &bonds), SDR_OK);
  pair_table t = every_pair(points);
  int64_t loose = 0, directed = 0;
  for (int32_t i = 0; i < points->count; ++i)
    for (int32_t j = i + 1; j < points->count; ++j)
      loose += *pair_entry(&t, i, j) && !(bulk[i] && bulk[j]);
  sdr_bonds_visit(bonds, points, check_slot, &t);
  for (int64_t r = 0; r < bonds->run_count; ++r)
    for (int32_t k = 0; k < bonds->runs[r].length; ++k, directed += 2)
      assert_true(bulk[bonds->runs[r].i0 + k] && bulk[bonds->runs[r].j0 + k]);
  assert_int_equal(t.visited, t.pairs);
  assert_int_equal(bonds->pairs, t.pairs);
  assert_int_equal(bonds->directed, t.directed);
  assert_int_equal(bonds->loose_pairs, loose);
  assert_int_equal(directed + 2 * loose, t.directed);
  sdr_free(t.mark);
  sdr_free(bulk);
  sdr_bonds_destroy(&bonds);
  sdr_points_destroy(&points);
}

static void check_own_slot(void *context, const sdr_pair *pair)
{
  assert_true(pair->weight_ij > 0.0); /* j is in H_i, or i knows nothing of j */
  check_slot(context, pair);
}

static void check_one_sided(const shape *s)
{
  sdr_points *points = make_points(s);
  const sdr_bonds_how how = {.one_sided = 1};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(points, &how, &bonds), SDR_OK);
  pair_table t = every_pair(points);
  sdr_bonds_visit(bonds, points, check_own_slot, &t);
  assert_int_equal(t.visited, t.pairs);
  assert_int_equal(bonds->pairs, t.pairs);
  assert_int_equal(bonds->directed, t.directed);
  sdr_free(t.mark);
  sdr_bonds_destroy(&bonds);
  sdr_points_destroy(&points);
}

static int in_annulus(const int32_t cell[3])
{
  const double r = hypot(cell[0] - 22, cell[1] - 22);
  return r >= 11.0 && r <= 22.0;
}

static int in_shell(const int32_t cell[3])
{
  const double r = hypot(hypot(cell[0] - 6, cell[1] - 6), cell[2] - 6);
  return r >= 3.0 && r <= 6.2;
}

static int in_comb(const int32_t cell[3])
{
  return cell[1] < 3 || cell[0] % 7 < 4;
}

static int every_other_row_missing(const int32_t cell[3])
{
  return cell[1] % 5 != 2 && (cell[0] + cell[1]) % 11 != 0;
}

static const shape lattices[] = {
    {1, {2, 1, 1}, 1.0, 0.0, 0.0, 0.0, NULL, 0},
    {1, {3000, 1, 1}, 3.015, 0.0, 0.0, 0.0, NULL, 0},
    {2, {40, 33, 1}, 3.015, 0.0, 0.0, 0.0, NULL, 0},
    {2, {33, 40, 1}, 3.0, 0.3, 0.0, 0.0, NULL, 0},
    {2, {1400, 2, 1}, 4.1, 0.0, 0.0, 0.0, NULL, 0}, /* rows beyond 512 */
    {2, {2, 1400, 1}, 4.1, 0.785398163397448, 0.0, 0.0, NULL, 0},
    {2, {700, 4, 1}, 2.0, 0.1, 0.0, 0.0, every_other_row_missing, 0},
    {2, {4, 700, 1}, 3.015, 0.0, 0.0, 0.0, NULL, 0},
    {2, {45, 45, 1}, 3.01, 0.0, 0.0, 0.0, in_annulus, 0},
    {2, {50, 30, 1}, 5.1, 0.0, 0.0, 0.0, in_comb, 0},
    {2, {30, 50, 1}, 3.015, 0.0, 0.0, 0.0, every_other_row_missing, 0},
    {3, {13, 13, 13}, 3.015, 0.0, 0.0, 0.0, in_shell, 0},
    {3, {10, 11, 12}, 2.01, 0.2, 0.0, 0.0, NULL, 0},
    {3, {300, 3, 2}, 3.015, 0.0, 0.0, 0.0, NULL, 0},
    {3, {2, 300, 3}, 3.015, 0.0, 0.0, 0.0, NULL, 0},
    {3, {3, 2, 300}, 3.015, 0.0, 0.0, 0.0, NULL, 0},
    {3, {40, 35, 1}, 2.5, 0.0, 0.0, 0.0, NULL, 0},
    {3, {1, 35, 40}, 2.5, 0.0, 0.0, 0.0, NULL, 0},
};
enum { LATTICES = sizeof lattices / sizeof *lattices };

static void runs_of_a_lattice_hold_each_pair_once(void **state)
{
  (void)state;
  for (int k = 0; k < LATTICES; ++k) check_bonds(&lattices[k], 1);
}

static void loose_pairs_of_a_lattice_hold_each_pair_once(void **state)
{
  (void)state;
  for (int k = 0; k < LATTICES; k += 2) {
    shape s = lattices[k];
    s.force_loose = 1;
    check_bonds(&s, 0);
  }
}

static void jittered_points_with_varying_horizons_have_dual_flags(void **state)
{
  (void)state;
  const shape shapes[] = {{1, {400, 1, 1}, 2.5, 0.0, 0.4, 0.5, NULL, 0},
                          {2, {25, 24, 1}, 2.5, 0.0, 0.4, 0.5, NULL, 0},
                          {2, {300, 3, 1}, 4.0, 0.0, 0.3, 0.7, NULL, 0},
                          {3, {8, 9, 7}, 2.1, 0.0, 0.4, 0.4, NULL, 0}};
  for (int k = 0; k < 4; ++k) check_bonds(&shapes[k], 0);
}

static void pairs_of_points_that_are_not_bulk_are_loose_beside_the_runs(void **state)
{
  (void)state;
  for (int k = 0; k < LATTICES; ++k) check_mixed(&lattices[k]);
}

static void one_sided_bonds_have_a_slot_in_the_rows_of_their_owners_only(void **state)
{
  (void)state;
  const shape shapes[] = {{1, {400, 1, 1}, 2.5, 0.0, 0.4, 0.5, NULL, 0},
                          {2, {25, 24, 1}, 2.5, 0.0, 0.4, 0.5, NULL, 0},
                          {3, {8, 9, 7}, 2.1, 0.0, 0.4, 0.4, NULL, 0}};
  for (int k = 0; k < 3; ++k) check_one_sided(&shapes[k]);
}

/* A lattice whose horizons differ has no runs, but every pair. */
static void a_lattice_with_varying_horizons_is_loose(void **state)
{
  (void)state;
  const shape s = {2, {30, 20, 1}, 3.0, 0.0, 0.0, 0.3, NULL, 0};
  check_bonds(&s, 0);
}

/* ---- stripes --------------------------------------------------------------------------------- */

static void every_run_joins_a_stripe_to_itself_or_the_next(void **state)
{
  (void)state;
  for (int k = 0; k < LATTICES; ++k) {
    sdr_points *points = make_points(&lattices[k]);
    const sdr_bonds_how how = {0};
    sdr_bonds *bonds;
    assert_int_equal(sdr_bonds_create(points, &how, &bonds), SDR_OK);
    check_stripes_of_runs(points, bonds);
    int64_t end = 0;
    for (int64_t r = 0; r < bonds->run_count; ++r) {
      const sdr_bond_run *run = &bonds->runs[r];
      assert_true(run->length > 0 && run->slot >= end);
      end = run->slot + run->length;
    }
    assert_int_equal(bonds->stripe_run[points->stripe_count], bonds->run_count);
    assert_true(end <= bonds->run_slots);
    sdr_bonds_destroy(&bonds);
    sdr_points_destroy(&points);
  }
}

static void rows_are_long_where_the_body_is(void **state)
{
  (void)state;
  sdr_points *points = make_points(&(shape){2, {400, 300, 1}, 3.015, 0.0, 0.0, 0.0, NULL, 0});
  const sdr_bonds_how how = {0};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(points, &how, &bonds), SDR_OK);
  assert_true(bonds->pairs / bonds->run_count > 150); /* pairs a run */
  assert_true(points->stripe_count > 32);
  sdr_bonds_destroy(&bonds);
  sdr_points_destroy(&points);
}

/* ---- failures -------------------------------------------------------------------------------- */

static void a_body_without_a_bond_is_refused(void **state)
{
  (void)state;
  for (int loose = 0; loose < 2; ++loose) {
    sdr_points *points = make_points(&(shape){2, {5, 5, 1}, 0.5, 0.0, 0.0, 0.0, NULL, loose});
    const sdr_bonds_how how = {.force_loose = loose};
    sdr_bonds *bonds = NULL;
    assert_int_equal(sdr_bonds_create(points, &how, &bonds), SDR_BAD_INPUT);
    assert_null(bonds);
    assert_string_equal(sdr_error_message(),
                        "no two points are within a horizon of each other, so the body has no "
                        "bond; enlarge the horizon or the body");
    sdr_points_destroy(&points);
  }
}

static void every_failing_allocation_is_reported(void **state)
{
  (void)state;
  for (int loose = 0; loose < 2; ++loose) {
    sdr_points *points = make_points(&(shape){2, {9, 9, 1}, 2.5, 0.0, 0.0, 0.0, NULL, loose});
    const long fails = count_failing_allocations(points, &(sdr_bonds_how){.force_loose = loose});
    assert_true(fails > 6 && fails < 100);
    sdr_points_destroy(&points);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(runs_of_a_lattice_hold_each_pair_once),
      cmocka_unit_test(loose_pairs_of_a_lattice_hold_each_pair_once),
      cmocka_unit_test(jittered_points_with_varying_horizons_have_dual_flags),
      cmocka_unit_test(pairs_of_points_that_are_not_bulk_are_loose_beside_the_runs),
      cmocka_unit_test(one_sided_bonds_have_a_slot_in_the_rows_of_their_owners_only),
      cmocka_unit_test(a_lattice_with_varying_horizons_is_loose),
      cmocka_unit_test(every_run_joins_a_stripe_to_itself_or_the_next),
      cmocka_unit_test(rows_are_long_where_the_body_is),
      cmocka_unit_test(a_body_without_a_bond_is_refused),
      cmocka_unit_test(every_failing_allocation_is_reported),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
