/* Supports: for every point the neighbours that its nonlocal operators see (theory, "Nonlocal
   operators"). They are directed, as horizon sets are, but know nothing of bonds: any cloud of
   positions will do. */
#ifndef SDR_NOM_SUPPORT_H
#define SDR_NOM_SUPPORT_H

#include "nom/neighbourhood.h"
#include "nom/points.h"

/* A view of points: borrowed arrays of `count` values. */
typedef struct {
  int components;       /* 1, 2 or 3 */
  int32_t count;        /* points */
  const double *x[3];   /* positions; unused components NULL */
  const double *volume; /* NULL: all 1 */
} sdr_cloud;

static inline sdr_cloud sdr_cloud_of(const sdr_points *points)
{
  return (sdr_cloud){points->components,
                     points->count,
                     {points->x[0], points->x[1], points->x[2]},
                     points->volume};
}

typedef struct {
  sdr_cloud cloud;
  int64_t *row; /* count + 1 */
  int32_t
      *column;    /* support of i: column[row[i]] .. column[row[i + 1] - 1], ascending, without i */
  double *radius; /* h_i, the length that weights and monomials of i are scaled by */
} sdr_support;

/* All points within radius[i] of i (one value a point; those at exactly that distance count), and
   h_i = radius[i]. A support may be empty. SDR_BAD_INPUT if a radius is not positive or two
   points coincide. The cloud's arrays are borrowed for as long as the support lives.
   Owner: the caller, as of all that follow. */
sdr_status sdr_support_by_radius(const sdr_cloud *cloud, const double *radius, sdr_support *out);

enum { SDR_MOST_NEAREST = 1000 }; /* in a support by count */

/* The `nearest` nearest points of each, and all that are as far as the last of them: such a set
   does not depend on the points' order and is symmetric on a lattice. h_i is the distance of the
   farthest, so weights that vanish at h (linear, cubic) do not see those. SDR_BAD_INPUT if there
   are too few points or two coincide. */
sdr_status sdr_support_by_count(const sdr_cloud *cloud, int nearest, sdr_support *out);

/* The horizon sets of a neighbourhood, with h_i = horizon[i]; copied. */
sdr_status sdr_support_of_neighbourhood(const sdr_cloud *cloud, const double *horizon,
                                        const sdr_neighbourhood *near, sdr_support *out);

/* Replace the support of every point i that has wanted[i] > 0 by its wanted[i] nearest points (as
   sdr_support_by_count; clamped to all points and SDR_MOST_NEAREST); the others keep theirs.
   Unchanged on failure. */
sdr_status sdr_support_enlarge(sdr_support *support, const int32_t *wanted);

void sdr_support_destroy(sdr_support *support);

/* "point 12 at (0.5, 0.25)", for messages. */
typedef struct {
  char text[120];
} sdr_point_name;
sdr_point_name sdr_point_named(const sdr_cloud *cloud, int32_t i);

#endif
