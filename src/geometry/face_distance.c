/* How far a place is from a face. */
#include "base/small.h"
#include "geometry/face_internal.h"
#include "geometry/shape.h"
#include "scene/import.h"

#include <math.h>

/* Distance from the annulus inner <= r <= outer at height z = 0, seen from radius r and height z;
   a side has inner = outer and reaches from z = low to high. */
static double round_distance(double r, double z, double inner, double outer, double low,
                             double high)
{
  const double dr = fmax(0.0, fmax(inner - r, r - outer));
  const double dz = fmax(0.0, fmax(low - z, z - high));
  return hypot(dr, dz);
}

static double cylinder_distance(const sdr_found_face *from, const double x[3])
{
  const sdr_shape *shape = from->shape;
  const double low = shape->low[2], high = shape->high[2];
  const double r = hypot(x[0] - shape->centre[0], x[1] - shape->centre[1]);
  if (from->index == ROUND_INNER || from->index == ROUND_OUTER) {
    const double radius = from->index == ROUND_INNER ? shape->inner : shape->outer;
    return round_distance(r, x[2], radius, radius, low, high);
  }
  const double bottom = round_distance(r, x[2], shape->inner, shape->outer, low, low);
  const double top = round_distance(r, x[2], shape->inner, shape->outer, high, high);
  if (from->index == ROUND_BOTTOM) return bottom;
  return from->index == ROUND_TOP ? top : fmin(bottom, top);
}

static double box_distance(const sdr_found_face *from, int components, const double x[3])
{
  const sdr_shape *box = from->shape;
  const int across = from->index / 2;
  double local[3], d[3] = {0.0};
  sdr_box_to_local(box, x, local);
  for (int c = 0; c < components; ++c) {
    d[c] = fmax(0.0, fmax(box->low[c] - local[c], local[c] - box->high[c]));
  }
  d[across] = local[across] - (from->index % 2 ? box->high[across] : box->low[across]);
  return sdr_norm3(d);
}

static double polygon_distance(const sdr_shape *polygon, const double x[3])
{
  double distance = HUGE_VAL;
  for (int k = 0, last = polygon->vertex_count - 1; k < polygon->vertex_count; last = k++) {
    const double *a = &polygon->vertices[2 * last], *b = &polygon->vertices[2 * k];
    distance = fmin(distance, sdr_segment_distance(a, b, x));
  }
  return distance;
}

double sdr_face_distance(const sdr_shape *shape, const char *name, sdr_dimension dimension,
                         const double x[3])
{
  sdr_found_face from;
  if (!shape || sdr_face_find(shape, name, 0, &from) != 1) return HUGE_VAL;
  const sdr_shape *own = from.shape;
  const double d[3] = {x[0] - own->centre[0], x[1] - own->centre[1], x[2] - own->centre[2]};
  const double radius = from.index == ROUND_INNER ? own->inner : own->outer;
  switch (own->kind) {
  case SDR_BOX:
    return box_distance(&from, sdr_components(dimension), x);
  case SDR_DISC:
    return fabs(hypot(d[0], d[1]) - own->outer);
  case SDR_ANNULUS:
    return fabs(hypot(d[0], d[1]) - radius);
  case SDR_SPHERE:
    return fabs(sdr_norm3(d) - radius);
  case SDR_CYLINDER:
    return cylinder_distance(&from, x);
  case SDR_POLYGON:
    return polygon_distance(own, x);
  case SDR_FACETS:
    return sdr_tree_nearest(own->group->facets, x, NULL);
  default:
    return HUGE_VAL;
  }
}
