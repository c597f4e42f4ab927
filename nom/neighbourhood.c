#include "nom/neighbourhood.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "nom/cells.h"

#include <math.h>

enum { BLOCK = 1024 }; /* points a task */

typedef struct {
  const sdr_points *points;
  const sdr_cells *cells;
  const sdr_lattice_groups *held; /* their pairs are left out; NULL: none */
  uint8_t *group; /* a cell: of all its points, none of them at a border; 0: they differ */
  int64_t *row;
  int32_t *column; /* NULL: only count, into row[i + 1] */
} search;

static void sort_ascending(int32_t *values, int64_t count)
{
  for (int64_t k = 1; k < count; ++k) {
    const int32_t value = values[k];
    int64_t at = k;
    for (; at > 0 && values[at - 1] > value; --at) values[at] = values[at - 1];
    values[at] = value;
  }
}

/* Neighbours of i among the points of one cell. */
static int64_t search_cell(const search *s, int32_t i, int64_t cell, int32_t *column)
{
  int64_t found = 0;
  for (int64_t k = s->cells->first[cell]; k < s->cells->first[cell + 1]; ++k) {
    const int32_t j = s->cells->point[k];
    if (j == i || (s->held && sdr_on_run(s->held, i, j))) continue;
    if (!sdr_in_horizon(s->points, i, sdr_distance_squared(s->points, i, j))) continue;
    if (column) column[found] = j;
    ++found;
  }
  return found;
}

static int64_t search_point(const search *s, int32_t i, int32_t *column)
{
  const sdr_cells *cells = s->cells;
  const int own = s->held ? s->held->of_point[i] : 0;
  int32_t low[3] = {0}, high[3] = {0};
  const double reach = s->points->horizon[i] * (1.0 + 1e-9);
  for (int a = 0; a < s->points->components; ++a) {
    low[a] = sdr_cells_coordinate(cells, a, s->points->x[a][i] - reach);
    high[a] = sdr_cells_coordinate(cells, a, s->points->x[a][i] + reach);
  }
  int64_t found = 0;
  for (int64_t z = low[2]; z <= high[2]; ++z)
    for (int64_t y = low[1]; y <= high[1]; ++y)
      for (int64_t x = low[0]; x <= high[0]; ++x) {
        const int64_t cell = (z * cells->n[1] + y) * cells->n[0] + x;
        if (own == 0 || s->group[cell] != own)
          found += search_cell(s, i, cell, column ? column + found : NULL);
      }
  if (column) sort_ascending(column, found);
  return found;
}

static void search_block(void *context, int block)
{
  const search *s = context;
  const int32_t first = block * BLOCK;
  const int32_t end = first + BLOCK < s->points->count ? first + BLOCK : s->points->count;
  for (int32_t i = first; i < end; ++i)
    if (s->column && s->row[i + 1] > s->row[i])
      search_point(s, i, s->column + s->row[i]);
    else if (!s->column)
      s->row[i + 1] = search_point(s, i, NULL);
}

/* Cells as large as the smallest horizon: few of a search's candidates lie outside, and a point
   with a large horizon among small ones just looks at more cells. */
static double smallest_horizon(const sdr_points *points)
{
  double smallest = points->horizon[0];
  for (int32_t i = 1; i < points->count; ++i) smallest = fmin(smallest, points->horizon[i]);
  return smallest;
}

static int group_of_cell(const sdr_lattice_groups *held, const sdr_cells *cells, size_t cell)
{
  int group = 0;
  for (int64_t k = cells->first[cell]; k < cells->first[cell + 1]; ++k) {
    const int32_t i = cells->point[k];
    const int own = held->border && held->border[i] ? 0 : held->of_point[i];
    if (own == 0 || (group != 0 && own != group)) return 0;
    group = own;
  }
  return group;
}

static sdr_status find_groups(search *s)
{
  const int32_t *n = s->cells->n;
  const size_t count = (size_t)n[0] * (size_t)n[1] * (size_t)n[2];
  if (!s->held) return SDR_OK;
  s->group = sdr_alloc(count, 1);
  if (!s->group) return SDR_RUN_FAILED;
  for (size_t cell = 0; cell < count; ++cell)
    s->group[cell] = (uint8_t)group_of_cell(s->held, s->cells, cell);
  return SDR_OK;
}

sdr_status sdr_neighbourhood_create(const sdr_points *points, sdr_neighbourhood *out)
{
  return sdr_neighbourhood_beside(points, NULL, out);
}

sdr_status sdr_neighbourhood_beside(const sdr_points *points, const sdr_lattice_groups *held,
                                    sdr_neighbourhood *out)
{
  sdr_cells cells = {0};
  SDR_TRY(sdr_cells_create(points, smallest_horizon(points), &cells));
  sdr_neighbourhood made = {0};
  sdr_status status = SDR_RUN_FAILED;
  search s = {.points = points, .cells = &cells, .held = held};
  s.row = made.row = sdr_alloc((size_t)points->count + 1, sizeof *made.row);
  if (!made.row || find_groups(&s) != SDR_OK) goto cleanup;
  const int blocks = (points->count + BLOCK - 1) / BLOCK;
  sdr_parallel_for(0, blocks, 1, search_block, &s);
  for (int32_t i = 0; i < points->count; ++i) made.row[i + 1] += made.row[i];
  s.column = made.column = sdr_alloc((size_t)made.row[points->count], sizeof *made.column);
  if (!made.column) goto cleanup;
  sdr_parallel_for(0, blocks, 1, search_block, &s);
  *out = made;
  made = (sdr_neighbourhood){0};
  status = SDR_OK;
cleanup:
  sdr_free(s.group);
  sdr_neighbourhood_destroy(&made);
  sdr_cells_destroy(&cells);
  return status;
}

void sdr_neighbourhood_destroy(sdr_neighbourhood *neighbourhood)
{
  sdr_free(neighbourhood->row);
  sdr_free(neighbourhood->column);
  *neighbourhood = (sdr_neighbourhood){0};
}
