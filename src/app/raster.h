/* Points with values turned into an image: a plane body seen from above, a solid one obliquely. */
#ifndef SDR_APP_RASTER_H
#define SDR_APP_RASTER_H

#include "base/status.h"

#include <stdint.h>

/* Borrowed arrays of `count` numbers. */
typedef struct {
  int32_t count;
  int dimension;             /* 2 or 3 */
  const double *position[3]; /* m */
  const double *volume;      /* NULL: all alike; only its ratios count (several spacings) */
} sdr_cloud;

/* How a cloud lies on the picture plane. */
typedef struct {
  double low[2], high[2]; /* m, cells included */
  double spacing, volume; /* of the median point: m, and as the cloud's (0: not known) */
  int lattice;            /* 1: one axis-parallel lattice, whose cells are drawn as squares */
  int squares;            /* 1: points moved off such a lattice, still drawn as squares */
} sdr_extent;

/* The window of an image: pixel (0, 0) is at the lower left. */
typedef struct {
  int width, height;
  double left, bottom; /* m: outer corner of that pixel */
  double pixel;        /* m: its side */
} sdr_window;

/* value: of the point that fills the pixel, NAN where there is none; row after row from the
   bottom. shade: 1 for a face in full light, less for others (3-D). */
typedef struct {
  sdr_window window;
  float *value, *shade;
} sdr_raster;

/* On the picture plane: in 2-D the components as they are, in 3-D seen isometrically with x to the
   lower right, y to the upper right and z up. depth: larger is nearer. */
void sdr_raster_project(const double position[3], int dimension, double plane[2], double *depth);

/* Extent and spacing; the spacing comes from the neighbours' distances (so that the thickness of a
   plane body does not matter). count >= 1. Fails only for want of memory. */
sdr_status sdr_raster_measure(const sdr_cloud *cloud, sdr_extent *out);

/* A window around all `count` extents, about `target` pixels wide or high, whichever is larger
   (up to half as many more): with a whole number of pixels to a cell of the finest one, so that
   its lattice shows no moire, unless cells are smaller than pixels; no side is shorter than a
   quarter of the other. */
sdr_window sdr_raster_window(const sdr_extent *extents, int count, int target);

/* Paint: a pixel takes the nearest point (in spacings) that is near enough for a closed body; in
   3-D the cube nearest to the eye. Where several points fall into one pixel the largest magnitude
   shows. Points whose value is not finite are left out. The caller clears *out. */
sdr_status sdr_raster_paint(const sdr_cloud *cloud, const sdr_extent *extent, const float *value,
                            const sdr_window *window, sdr_raster *out);
void sdr_raster_clear(sdr_raster *raster);

#endif
