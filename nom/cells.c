#include "nom/cells.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

double sdr_cells_count(const double extent[3], double size, int32_t n[3])
{
  double cells = 1.0;
  for (int a = 0; a < 3; ++a) {
    const double along = fmin(floor(extent[a] / size) + 1.0, 2e9);
    n[a] = (int32_t)along;
    cells *= along;
  }
  return cells;
}

static int64_t cell_of(const sdr_cells *cells, const sdr_points *points, int32_t i)
{
  int64_t c[3] = {0};
  for (int a = 0; a < points->components; ++a)
    c[a] = sdr_cells_coordinate(cells, a, points->x[a][i]);
  return (c[2] * cells->n[1] + c[1]) * cells->n[0] + c[0];
}

sdr_status sdr_cells_create(const sdr_points *points, double size, sdr_cells *out)
{
  sdr_cells cells = {.size = size};
  double extent[3] = {0.0};
  for (int a = 0; a < points->components; ++a) {
    double low = points->x[a][0], high = low;
    for (int32_t i = 1; i < points->count; ++i) {
      low = fmin(low, points->x[a][i]);
      high = fmax(high, points->x[a][i]);
    }
    cells.low[a] = low;
    extent[a] = high - low;
  }
  while (sdr_cells_count(extent, cells.size, cells.n) > 4.0 * points->count + 64.0)
    cells.size *= 1.5;

  const size_t count = (size_t)cells.n[0] * (size_t)cells.n[1] * (size_t)cells.n[2];
  cells.first = sdr_alloc(count + 2, sizeof *cells.first);
  cells.point = sdr_alloc((size_t)points->count, sizeof *cells.point);
  if (!cells.first || !cells.point) {
    sdr_cells_destroy(&cells);
    return SDR_RUN_FAILED;
  }
  /* Counting sort; first[c + 2] counts, then first[c + 1] is the cursor that ends at first[c + 1].
   */
  for (int32_t i = 0; i < points->count; ++i) ++cells.first[cell_of(&cells, points, i) + 2];
  for (size_t c = 2; c < count + 2; ++c) cells.first[c] += cells.first[c - 1];
  for (int32_t i = 0; i < points->count; ++i)
    cells.point[cells.first[cell_of(&cells, points, i) + 1]++] = i;
  *out = cells;
  return SDR_OK;
}

void sdr_cells_destroy(sdr_cells *cells)
{
  sdr_free(cells->first);
  sdr_free(cells->point);
  memset(cells, 0, sizeof *cells);
}
