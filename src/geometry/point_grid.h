/* Search among points: nearest, and all within a distance. */
#ifndef SDR_GEOMETRY_POINT_GRID_H
#define SDR_GEOMETRY_POINT_GRID_H

#include "nom/points.h"

typedef struct sdr_point_grid sdr_point_grid;

/* Sort the points of the body, or those of layers outside it as well, into cells as wide as the
   largest spacing. Borrows points. Owner: the caller. */
sdr_status sdr_point_grid_create(const sdr_points *points, sdr_point_grid **out);
sdr_status sdr_point_grid_create_all(const sdr_points *points, sdr_point_grid **out);
void sdr_point_grid_destroy(sdr_point_grid **grid); /* NULL-safe */

typedef void (*sdr_point_visitor)(void *context, int32_t point, double distance);

/* Visit the points within `radius` (m) of x[3], in a fixed order. */
void sdr_point_grid_within(const sdr_point_grid *grid, const double x[3], double radius,
                           sdr_point_visitor visit, void *context);

/* The point nearest to x[3]; of several that are as near up to 1e-9 of their spacing, the one
   generated first. -1 if none lies within two of its own spacings. */
int32_t sdr_point_grid_nearest(const sdr_point_grid *grid, const double x[3]);

#endif
