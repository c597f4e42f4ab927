/* All pairs of a body, found naively, to hold its bonds against. */
#ifndef SDR_TESTS_EVERY_PAIR_H
#define SDR_TESTS_EVERY_PAIR_H

#include "base/memory.h"
#include "nom/bonds.h"
#include "support/cmocka_all.h"

#include <math.h>

enum { IN_I = 1, IN_J = 2, FOUND = 4 };

/* across: pairs of points of different levels. */
typedef struct {
  const sdr_points *points;
  char *mark; /* count x count, for i < j */
  int64_t pairs, directed, visited, across;
} pair_table;

static inline char *pair_entry(const pair_table *t, int32_t i, int32_t j)
{
  const int32_t low = i < j ? i : j, high = i < j ? j : i;
  return t->mark + (size_t)low * (size_t)t->points->count + (size_t)high;
}

static inline double pair_distance(const sdr_points *points, int32_t i, int32_t j)
{
  double square = 0.0;
  for (int a = 0; a < points->components; ++a) {
    const double d = points->x[a][j] - points->x[a][i];
    square += d * d;
  }
  return sqrt(square);
}

/* The caller frees `mark`. */
static inline pair_table every_pair(const sdr_points *points)
{
  const size_t n = (size_t)points->count;
  pair_table t = {.points = points, .mark = sdr_alloc(n * n, 1)};
  for (int32_t i = 0; i < points->count; ++i)
    for (int32_t j = i + 1; j < points->count; ++j) {
      const double distance = pair_distance(points, i, j) * (1.0 - 0.5e-9);
      const int ij = distance <= points->horizon[i], ji = distance <= points->horizon[j];
      *pair_entry(&t, i, j) = (char)((ij ? IN_I : 0) | (ji ? IN_J : 0));
      t.pairs += ij || ji;
      t.directed += ij + ji;
      t.across += (ij || ji) && points->level && points->level[i] != points->level[j];
    }
  return t;
}

/* For sdr_bonds_visit with a table: the slot is of a pair of the table, with its flags and vector,
   and the only first one. */
static inline void check_slot(void *context, const sdr_pair *pair)
{
  pair_table *t = context;
  const sdr_points *points = t->points;
  char *mark = pair_entry(t, pair->i, pair->j);
  const int ij = (*mark & (pair->i < pair->j ? IN_I : IN_J)) != 0;
  const int ji = (*mark & (pair->i < pair->j ? IN_J : IN_I)) != 0;
  assert_true(ij || ji);
  assert_true(pair->weight_ij == (ij ? 1.0 : 0.0) && pair->weight_ji == (ji ? 1.0 : 0.0));
  if (!pair->loose && points->level)
    assert_int_equal(points->level[pair->i], points->level[pair->j]);
  for (int a = 0; a < points->components; ++a) {
    const double xi = points->x[a][pair->j] - points->x[a][pair->i];
    assert_true(fabs(pair->xi[a] - xi) < 1e-12);
  }
  assert_true(fabs(pair->length - pair_distance(points, pair->i, pair->j)) < 1e-12);
  if (!pair->primary) return;
  assert_false(*mark & FOUND);
  *mark |= FOUND;
  ++t->visited;
}

static inline int stripe_of(const sdr_points *points, int32_t i)
{
  int s = 0;
  while (points->stripe_first[s + 1] <= i) ++s;
  return s;
}

/* Each run joins its stripe to itself or to the next, whole. */
static inline void check_stripes_of_runs(const sdr_points *points, const sdr_bonds *bonds)
{
  for (int s = 0; s < points->stripe_count; ++s)
    for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r) {
      const sdr_bond_run *run = &bonds->runs[r];
      const int32_t last = run->length - 1;
      const int i = stripe_of(points, run->i0), j = stripe_of(points, run->j0);
      assert_true((i == s || i == s + 1) && (j == s || j == s + 1));
      assert_true(i == s || j == s);
      assert_int_equal(stripe_of(points, run->i0 + last), i);
      assert_int_equal(stripe_of(points, run->j0 + last), j);
    }
}

/* Bonds are made with ever more allocations before one that fails: each failure is told and leaves
   nothing behind. How many there are. */
static inline long count_failing_allocations(const sdr_points *points, const sdr_bonds_how *how)
{
  const size_t before = sdr_memory_now();
  sdr_bonds *bonds = NULL;
  long fails = 0;
  for (; fails < 200; ++fails) {
    sdr_memory_fail_after(fails);
    const sdr_status status = sdr_bonds_create(points, how, &bonds);
    sdr_memory_fail_after(-1);
    if (status == SDR_OK) break;
    assert_int_equal(status, SDR_RUN_FAILED);
    assert_null(bonds);
    assert_int_equal(sdr_memory_now(), before);
  }
  sdr_bonds_destroy(&bonds);
  return fails;
}

#endif
