#include "geometry/point_grid.h"

#include "base/memory.h"

#include <math.h>

struct sdr_point_grid {
  const sdr_points *points;
  double low[3], width, largest_spacing;
  int32_t cells[3];
  int32_t *first; /* per cell and one more: its part of `list` */
  int32_t *list;
};

static void measure(sdr_point_grid *grid)
{
  const sdr_points *points = grid->points;
  double extent[3] = {0.0};
  for (int c = 0; c < points->components; ++c) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int32_t i = 0; i < points->count; ++i) {
      low = fmin(low, points->x[c][i]);
      high = fmax(high, points->x[c][i]);
    }
    grid->low[c] = low;
    extent[c] = high - low;
  }
  for (int32_t i = 0; i < points->count; ++i) {
    grid->largest_spacing = fmax(grid->largest_spacing, points->spacing[i]);
  }
  /* scattered points: wider cells rather than many empty ones */
  double total = HUGE_VAL;
  grid->width = 0.5 * grid->largest_spacing;
  while (total > 4.0 * points->count + 64.0) {
    grid->width *= 2.0;
    total = 1.0;
    for (int c = 0; c < 3; ++c) total *= floor(extent[c] / grid->width) + 1.0;
  }
  for (int c = 0; c < 3; ++c) grid->cells[c] = (int32_t)(extent[c] / grid->width) + 1;
}

static int32_t clamped_cell(const sdr_point_grid *grid, int c, double x)
{
  const double cell = floor((x - grid->low[c]) / grid->width);
  return (int32_t)fmin(fmax(cell, 0.0), (double)(grid->cells[c] - 1));
}

static int32_t cell_of(const sdr_point_grid *grid, int32_t i)
{
  int32_t at[3] = {0};
  for (int c = 0; c < grid->points->components; ++c) {
    at[c] = clamped_cell(grid, c, grid->points->x[c][i]);
  }
  return at[0] + grid->cells[0] * (at[1] + grid->cells[1] * at[2]);
}

static sdr_status create(const sdr_points *points, int all, sdr_point_grid **out)
{
  sdr_point_grid *grid = sdr_alloc(1, sizeof *grid);
  if (!grid) return SDR_RUN_FAILED;
  grid->points = points;
  measure(grid);
  const int32_t cells = grid->cells[0] * grid->cells[1] * grid->cells[2];
  grid->first = sdr_alloc((size_t)cells + 1, sizeof *grid->first);
  grid->list = sdr_alloc((size_t)points->count, sizeof *grid->list);
  if (!grid->first || !grid->list) {
    sdr_point_grid_destroy(&grid);
    return SDR_RUN_FAILED;
  }
  for (int32_t i = 0; i < points->count; ++i)
    if (all || sdr_in_body(points, i)) ++grid->first[cell_of(grid, i)];
  for (int32_t k = 0; k < cells; ++k) grid->first[k + 1] += grid->first[k];
  for (int32_t i = points->count - 1; i >= 0; --i)
    if (all || sdr_in_body(points, i)) grid->list[--grid->first[cell_of(grid, i)]] = i;
  *out = grid;
  return SDR_OK;
}

sdr_status sdr_point_grid_create(const sdr_points *points, sdr_point_grid **out)
{
  return create(points, 0, out);
}

sdr_status sdr_point_grid_create_all(const sdr_points *points, sdr_point_grid **out)
{
  return create(points, 1, out);
}

void sdr_point_grid_destroy(sdr_point_grid **grid)
{
  if (!*grid) return;
  sdr_free((*grid)->first);
  sdr_free((*grid)->list);
  sdr_free(*grid);
  *grid = NULL;
}

static double distance_of(const sdr_points *points, int32_t i, const double x[3])
{
  double sum = 0.0;
  for (int c = 0; c < points->components; ++c) {
    const double d = points->x[c][i] - x[c];
    sum += d * d;
  }
  return sqrt(sum);
}

void sdr_point_grid_within(const sdr_point_grid *grid, const double x[3], double radius,
                           sdr_point_visitor visit, void *context)
{
  int32_t from[3] = {0}, to[3] = {0};
  for (int c = 0; c < grid->points->components; ++c) {
    from[c] = clamped_cell(grid, c, x[c] - radius);
    to[c] = clamped_cell(grid, c, x[c] + radius);
  }
  for (int32_t cz = from[2]; cz <= to[2]; ++cz) {
    for (int32_t cy = from[1]; cy <= to[1]; ++cy) {
      /* the cells of a row, and so their points, follow each other */
      const int32_t row = grid->cells[0] * (cy + grid->cells[1] * cz);
      const int32_t end = grid->first[row + to[0] + 1];
      for (int32_t k = grid->first[row + from[0]]; k < end; ++k) {
        const double distance = distance_of(grid->points, grid->list[k], x);
        if (distance <= radius) visit(context, grid->list[k], distance);
      }
    }
  }
}

typedef struct {
  const sdr_points *points;
  int32_t point;
  double distance;
  int64_t generated;
} nearest;

static void keep_nearest(void *context, int32_t point, double distance)
{
  nearest *best = context;
  if (distance >= best->distance) return;
  best->distance = distance;
  best->point = point;
}

static void keep_first_generated(void *context, int32_t point, double distance)
{
  nearest *best = context;
  (void)distance;
  const int32_t *order = best->points->generated;
  const int64_t generated = order ? order[point] : point;
  if (generated >= best->generated) return;
  best->generated = generated;
  best->point = point;
}

int32_t sdr_point_grid_nearest(const sdr_point_grid *grid, const double x[3])
{
  const sdr_points *points = grid->points;
  const double limit = 2.0 * grid->largest_spacing;
  nearest best = {points, -1, HUGE_VAL, INT64_MAX};
  for (double radius = 0.25 * limit; best.point < 0 && radius <= limit; radius *= 2.0) {
    sdr_point_grid_within(grid, x, radius, keep_nearest, &best);
  }
  if (best.point < 0) return -1;
  const double spacing = points->spacing[best.point];
  if (best.distance > 2.0 * spacing) return -1;
  sdr_point_grid_within(grid, x, best.distance + 1e-9 * spacing, keep_first_generated, &best);
  return best.point;
}
