/* Which places a shape holds (design sec. 4: shapes are closed). */
#ifndef SDR_GEOMETRY_SHAPE_H
#define SDR_GEOMETRY_SHAPE_H

#include "scene/scene.h"

/* Shapes are closed with this tolerance, as a share of the spacing; distances that are meant to
   include a point of the lattice likewise. */
#define SDR_SHAPE_TOLERANCE 1e-9

/* 1 if x[3] (m) lies in the shape grown by `tolerance` (m; negative: shrunk). A difference keeps
   the boundary of what it takes away. shape NULL: 1. Two-dimensional shapes do not look at z. */
int sdr_shape_contains(const sdr_shape *shape, const double x[3], double tolerance);

/* A box around the shape, the smallest one for a primitive: low[3], high[3] in m; unbounded sides
   are +-INFINITY, an empty intersection has low > high. shape NULL: unbounded. */
void sdr_shape_bounds(const sdr_shape *shape, double low[3], double high[3]);

/* Turn a place between space and the axes of a box, about the box's middle; the same place for
   other boxes. Both arrays have 3 entries and may be one. */
void sdr_box_to_space(const sdr_shape *box, const double local[3], double x[3]);
void sdr_box_to_local(const sdr_shape *box, const double x[3], double local[3]);

/* Distance of (x, y) from the segment a-b in the plane, m. */
double sdr_segment_distance(const double a[2], const double b[2], const double x[2]);

#endif
