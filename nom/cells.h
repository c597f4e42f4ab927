/* A grid of cells over points, to find who is near. */
#ifndef SDR_NOM_CELLS_H
#define SDR_NOM_CELLS_H

#include "nom/points.h"

typedef struct {
  double low[3], size; /* corner and edge of the cells, m */
  int32_t n[3];
  int64_t *first; /* n[0] n[1] n[2] + 1: cell c holds point[first[c]] .. point[first[c + 1] - 1] */
  int32_t *point; /* ascending within a cell */
} sdr_cells;

/* How many cells of edge `size` along each axis cover a box with these edges; returns their number
   in all, which may be more than fits an int. */
double sdr_cells_count(const double extent[3], double size, int32_t n[3]);

/* Sort the points into cells with edges of about `size` (m, > 0); enlarged where the grid would
   have more than about four cells a point. Owner: the caller. */
sdr_status sdr_cells_create(const sdr_points *points, double size, sdr_cells *out);
void sdr_cells_destroy(sdr_cells *cells);

/* Cell coordinate of a position, clamped to the grid. */
static inline int32_t sdr_cells_coordinate(const sdr_cells *cells, int a, double x)
{
  const double c = (x - cells->low[a]) / cells->size;
  return c <= 0.0 ? 0 : c >= cells->n[a] ? cells->n[a] - 1 : (int32_t)c;
}

#endif
