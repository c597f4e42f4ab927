#include "nom/lattice_runs.h"

#include "base/memory.h"
#include "nom/stencil.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The rows of one group, sorted by the lattice line they lie on to find a row's partners. */
typedef struct {
  const sdr_points *points;
  int across[2];              /* the two axes across the rows */
  int count;                  /* rows */
  const sdr_row **in_storage; /* as they are stored */
  const sdr_row **sorted;
  const int32_t *stripe; /* of each row, by its index in points->rows */
} row_index;

static int compare_line(const sdr_row *row, const int32_t line[2], const int across[2])
{
  for (int a = 1; a >= 0; --a)
    if (row->cell[across[a]] != line[a]) return row->cell[across[a]] < line[a] ? -1 : 1;
  return 0;
}

/* By line, then along it; `context` is the row_index. */
static int by_line(const void *left, const void *right, void *context)
{
  const row_index *index = context;
  const sdr_row *a = *(const sdr_row *const *)left, *b = *(const sdr_row *const *)right;
  const int32_t line[2] = {b->cell[index->across[0]], b->cell[index->across[1]]};
  const int order = compare_line(a, line, index->across);
  const int axis = index->points->row_axis;
  return order != 0 ? order : a->cell[axis] < b->cell[axis] ? -1 : a->cell[axis] > b->cell[axis];
}

/* The rows of group `group`. */
static sdr_status index_rows(const sdr_points *points, const sdr_lattice_groups *groups, int group,
                             const int32_t *stripe, row_index *index)
{
  static const int across[3][2] = {{1, 2}, {0, 2}, {0, 1}};
  const size_t most = (size_t)points->row_count;
  index->points = points;
  index->stripe = stripe;
  memcpy(index->across, across[points->row_axis], sizeof index->across);
  index->in_storage = sdr_alloc(most, sizeof *index->in_storage);
  index->sorted = sdr_alloc(most, sizeof *index->sorted);
  if (!index->in_storage || !index->sorted) return SDR_RUN_FAILED;
  for (int r = 0; r < points->row_count; ++r)
    if (groups->of_row[r] == group + 1) index->in_storage[index->count++] = &points->rows[r];
  memcpy(index->sorted, index->in_storage, (size_t)index->count * sizeof *index->sorted);
  qsort_r(index->sorted, (size_t)index->count, sizeof *index->sorted, by_line, index);
  return SDR_OK;
}

/* First sorted row on the line that ends at or after `start`; index->count if none. */
static int find_partner(const row_index *index, const int32_t line[2], int32_t start)
{
  const int axis = index->points->row_axis;
  int low = 0, high = index->count;
  while (low < high) {
    const int middle = low + (high - low) / 2;
    const sdr_row *row = index->sorted[middle];
    const int order = compare_line(row, line, index->across);
    if (order < 0 || (order == 0 && row->cell[axis] + row->length - 1 < start))
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

typedef struct {
  row_index index;
  sdr_stencil stencil;
  int first_class; /* of the classes of this group */
  int *order;      /* stencil steps of the half that is lexicographically positive, by line */
  const sdr_lattice_groups *ragged; /* if pairs of a row may have to be loose; else NULL */
  sdr_bonds *bonds;
  int64_t *cursor; /* next free run of each stripe; NULL while counting into stripe_run[s + 1] */
} run_builder;

static void add_run(const run_builder *build, int class_index, const sdr_row *row,
                    const sdr_row *partner, int32_t from, int32_t length, int32_t shift)
{
  const row_index *index = &build->index;
  const sdr_row *rows = index->points->rows;
  const int32_t si = index->stripe[row - rows], sj = index->stripe[partner - rows];
  const int32_t owner = si < sj ? si : sj;
  if (!build->cursor) {
    ++build->bonds->stripe_run[owner + 1];
    build->bonds->pairs += length;
    return;
  }
  const int axis = index->points->row_axis;
  build->bonds->runs[build->cursor[owner]++] =
      (sdr_bond_run){.class_index = build->first_class + class_index,
                     .i0 = row->first + (from - row->cell[axis]),
                     .j0 = partner->first + (from + shift - partner->cell[axis]),
                     .length = length};
}

/* The pairs from `from` to `to` along the row, without those that must be loose. */
static void add_bulk_runs(const run_builder *build, int class_index, const sdr_row *row,
                          const sdr_row *partner, int32_t from, int32_t to, int32_t shift)
{
  if (from >= to) return;
  if (!build->ragged) {
    add_run(build, class_index, row, partner, from, to - from, shift);
    return;
  }
  const int axis = build->index.points->row_axis;
  const int32_t i = row->first - row->cell[axis];
  const int32_t j = partner->first - partner->cell[axis] + shift;
  for (int32_t start = from; start < to;) {
    int32_t end = start;
    while (end < to && sdr_on_run(build->ragged, i + end, j + end)) ++end;
    if (end > start) add_run(build, class_index, row, partner, start, end - start, shift);
    start = end + 1;
  }
}

/* Classes that lead from a row to the same lattice line, by their shift along it: places
   [first, end) of run_builder.order. */
typedef struct {
  int first, end;
} line_classes;

/* All runs of one row to the rows on one line: partner by partner, so that runs between the same
   two rows follow each other (the kernels add their forces up together). */
static void runs_to_line(const run_builder *build, line_classes line, const sdr_row *row)
{
  const row_index *index = &build->index;
  const sdr_stencil *stencil = &build->stencil;
  const int axis = index->points->row_axis, *const order = build->order;
  const int32_t *least = stencil->step + 3 * order[line.first];
  const int32_t *most = stencil->step + 3 * order[line.end - 1];
  const int32_t at[2] = {row->cell[index->across[0]] + least[index->across[0]],
                         row->cell[index->across[1]] + least[index->across[1]]};
  const int32_t start = row->cell[axis], end = start + row->length;
  for (int p = find_partner(index, at, start + least[axis]); p < index->count; ++p) {
    const sdr_row *partner = index->sorted[p];
    const int32_t first = partner->cell[axis], last = first + partner->length;
    if (compare_line(partner, at, index->across) != 0 || first - most[axis] >= end) break;
    for (int c = line.first; c < line.end; ++c) {
      const int32_t shift = stencil->step[3 * order[c] + axis];
      const int32_t from = start > first - shift ? start : first - shift;
      const int32_t to = end < last - shift ? end : last - shift;
      add_bulk_runs(build, order[c] - stencil->count / 2, row, partner, from, to, shift);
    }
  }
}

/* By line, then by the shift along it; `context` is the run_builder. */
static int by_class_line(const void *left, const void *right, void *context)
{
  const run_builder *build = context;
  const int32_t *a = build->stencil.step + 3 * *(const int *)left;
  const int32_t *b = build->stencil.step + 3 * *(const int *)right;
  const int *across = build->index.across, axis = build->index.points->row_axis;
  for (int k = 1; k >= 0; --k)
    if (a[across[k]] != b[across[k]]) return a[across[k]] < b[across[k]] ? -1 : 1;
  return a[axis] < b[axis] ? -1 : a[axis] > b[axis];
}

static int same_line(const run_builder *build, int left, int right)
{
  const int32_t *a = build->stencil.step + 3 * left, *b = build->stencil.step + 3 * right;
  const int *across = build->index.across;
  return a[across[0]] == b[across[0]] && a[across[1]] == b[across[1]];
}

static void each_row_and_class(const run_builder *build)
{
  const int count = build->stencil.count - build->stencil.count / 2;
  for (int r = 0; r < build->index.count; ++r)
    for (line_classes line = {0, 1}; line.first < count; line.first = line.end++) {
      while (line.end < count && same_line(build, build->order[line.first], build->order[line.end]))
        ++line.end;
      runs_to_line(build, line, build->index.in_storage[r]);
    }
}

/* The classes of a group, from its first_class on. */
static void make_classes(const run_builder *build, double spacing)
{
  const sdr_points *points = build->index.points;
  const int first = build->stencil.count / 2;
  for (int c = first; c < build->stencil.count; ++c) {
    const int32_t *step = build->stencil.step + 3 * c;
    sdr_bond_class *class = &build->bonds->classes[build->first_class + c - first];
    double square = 0.0;
    for (int a = 0; a < 3; ++a) {
      square += (double)step[a] * step[a];
      for (int b = 0; b < points->components; ++b)
        class->xi[b] += spacing * step[a] * points->axes[a][b];
    }
    class->length = spacing * sqrt(square);
    class->inverse_square = 1.0 / (class->length * class->length);
  }
}

/* The weights of each class, asked of any of its pairs. */
static void weigh_classes(const sdr_points *points, const sdr_bonds_how *how, sdr_bonds *bonds)
{
  char *done = sdr_alloc((size_t)bonds->class_count, 1);
  for (int64_t r = 0; r < bonds->run_count; ++r) {
    const sdr_bond_run *run = &bonds->runs[r];
    sdr_bond_class *class = &bonds->classes[run->class_index];
    if (done && done[run->class_index]) continue;
    if (done) done[run->class_index] = 1;
    const double volumes = points->volume[run->i0] * points->volume[run->j0];
    const double back[3] = {-class->xi[0], -class->xi[1], -class->xi[2]};
    const double b_ij = how->weight ? how->weight(how->context, run->i0, run->j0, class->xi) : 1.0;
    const double b_ji = how->weight ? how->weight(how->context, run->j0, run->i0, back) : 1.0;
    class->weight_ij = volumes * b_ij;
    class->weight_ji = volumes * b_ji;
    class->by_length_ij = class->weight_ij / class->length;
    class->by_length_ji = class->weight_ji / class->length;
  }
  sdr_free(done);
}

/* Slots of a run start on a cache line and fill whole ones, since kernels work in whole vectors of
   up to 16 pairs. Runs longer than 240 end with at least 15 slots that are nobody's: kernels cut
   those into pieces, the second of which may begin at any pair. */
static void number_slots(sdr_bonds *bonds)
{
  int64_t slot = 0;
  for (int64_t r = 0; r < bonds->run_count; ++r) {
    bonds->runs[r].slot = slot;
    const int32_t length = bonds->runs[r].length;
    slot += (length > 240 ? length + 30 : length + 15) / 16 * 16;
  }
  bonds->run_slots = slot;
}

static sdr_status order_classes(run_builder *build)
{
  const int first = build->stencil.count / 2, count = build->stencil.count - first;
  build->order = sdr_alloc((size_t)count, sizeof *build->order);
  if (!build->order) return SDR_RUN_FAILED;
  for (int c = 0; c < count; ++c) build->order[c] = first + c;
  qsort_r(build->order, (size_t)count, sizeof *build->order, by_class_line, build);
  return SDR_OK;
}

/* All groups at work, and what they share. */
typedef struct {
  const sdr_points *points;
  const sdr_lattice_groups *groups;
  sdr_bonds *bonds;
  run_builder *builders; /* a group */
  int32_t *stripe;       /* of each row */
  int64_t *cursor;
} all_runs;

static sdr_status find_stripes(all_runs *all)
{
  const sdr_points *points = all->points;
  all->stripe = sdr_alloc((size_t)points->row_count, sizeof *all->stripe);
  if (!all->stripe) return SDR_RUN_FAILED;
  int32_t stripe = 0;
  for (int r = 0; r < points->row_count; ++r) {
    while (points->rows[r].first >= points->stripe_first[stripe + 1]) ++stripe;
    all->stripe[r] = stripe;
  }
  return SDR_OK;
}

static sdr_status start_group(all_runs *all, int g)
{
  const sdr_lattice_group *group = &all->groups->group[g];
  run_builder *build = &all->builders[g];
  build->bonds = all->bonds;
  build->ragged = all->groups->ragged ? all->groups : NULL;
  build->first_class = all->bonds->class_count;
  SDR_TRY(index_rows(all->points, all->groups, g, all->stripe, &build->index));
  SDR_TRY(
      sdr_stencil_create(all->points->components, group->spacing, group->horizon, &build->stencil));
  all->bonds->class_count += build->stencil.count - build->stencil.count / 2;
  return order_classes(build);
}

static sdr_status start_groups(all_runs *all)
{
  const int count = all->groups->count;
  all->builders = sdr_alloc((size_t)count, sizeof *all->builders);
  if (!all->builders) return SDR_RUN_FAILED;
  SDR_TRY(find_stripes(all));
  for (int g = 0; g < count; ++g) SDR_TRY(start_group(all, g));
  all->bonds->classes = sdr_alloc((size_t)all->bonds->class_count, sizeof *all->bonds->classes);
  if (!all->bonds->classes) return SDR_RUN_FAILED;
  for (int g = 0; g < count; ++g) make_classes(&all->builders[g], all->groups->group[g].spacing);
  return SDR_OK;
}

static sdr_status place_runs(all_runs *all)
{
  sdr_bonds *bonds = all->bonds;
  const int stripes = all->points->stripe_count, count = all->groups->count;
  for (int g = 0; g < count; ++g) each_row_and_class(&all->builders[g]); /* counts */
  for (int s = 0; s < stripes; ++s) bonds->stripe_run[s + 1] += bonds->stripe_run[s];
  bonds->run_count = bonds->stripe_run[stripes];
  bonds->runs = sdr_alloc((size_t)bonds->run_count, sizeof *bonds->runs);
  all->cursor = sdr_alloc((size_t)stripes, sizeof *all->cursor);
  if (!bonds->runs || !all->cursor) return SDR_RUN_FAILED;
  memcpy(all->cursor, bonds->stripe_run, (size_t)stripes * sizeof *all->cursor);
  for (int g = 0; g < count; ++g) {
    all->builders[g].cursor = all->cursor;
    each_row_and_class(&all->builders[g]);
  }
  bonds->directed = 2 * bonds->pairs;
  return SDR_OK;
}

static void destroy_groups(all_runs *all)
{
  for (int g = 0; all->builders && g < all->groups->count; ++g) {
    run_builder *build = &all->builders[g];
    sdr_free(build->order);
    sdr_free(build->index.in_storage);
    sdr_free(build->index.sorted);
    sdr_stencil_destroy(&build->stencil);
  }
  sdr_free(all->builders);
  sdr_free(all->cursor);
  sdr_free(all->stripe);
}

sdr_status sdr_lattice_runs(const sdr_points *points, const sdr_bonds_how *how,
                            const sdr_lattice_groups *groups, sdr_bonds *bonds)
{
  all_runs all = {.points = points, .groups = groups, .bonds = bonds};
  sdr_status status = start_groups(&all);
  if (status == SDR_OK) status = place_runs(&all);
  if (status == SDR_OK) {
    weigh_classes(points, how, bonds);
    number_slots(bonds);
  }
  destroy_groups(&all);
  return status;
}
