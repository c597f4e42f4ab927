#include "geometry/shape.h"

#include "base/small.h"
#include "scene/import.h"

#include <math.h>

static void turn_about_middle(const sdr_shape *box, double angle, const double from[3],
                              double to[3])
{
  const double middle[2] = {0.5 * (box->low[0] + box->high[0]), 0.5 * (box->low[1] + box->high[1])};
  const double c = cos(angle), s = sin(angle);
  const double dx = from[0] - middle[0], dy = from[1] - middle[1];
  to[0] = middle[0] + c * dx - s * dy;
  to[1] = middle[1] + s * dx + c * dy;
  to[2] = from[2];
}

static void keep_place(const double from[3], double to[3])
{
  for (int c = 0; c < 3; ++c) to[c] = from[c];
}

void sdr_box_to_space(const sdr_shape *box, const double local[3], double x[3])
{
  if (box->angle == 0.0) { /* no rounding for boxes along the axes */
    keep_place(local, x);
  } else {
    turn_about_middle(box, box->angle, local, x);
  }
}

void sdr_box_to_local(const sdr_shape *box, const double x[3], double local[3])
{
  if (box->angle == 0.0) {
    keep_place(x, local);
  } else {
    turn_about_middle(box, -box->angle, x, local);
  }
}

double sdr_segment_distance(const double a[2], const double b[2], const double x[2])
{
  const double e[2] = {b[0] - a[0], b[1] - a[1]}, d[2] = {x[0] - a[0], x[1] - a[1]};
  const double length2 = e[0] * e[0] + e[1] * e[1];
  double s = length2 > 0.0 ? (d[0] * e[0] + d[1] * e[1]) / length2 : 0.0;
  s = fmin(1.0, fmax(0.0, s));
  return hypot(d[0] - s * e[0], d[1] - s * e[1]);
}

/* A side without extent (y and z of boxes in fewer dimensions) is a plane: it cannot shrink. */
static int within(double low, double high, double x, double tolerance)
{
  const double slack = high > low ? tolerance : fabs(tolerance);
  return x >= low - slack && x <= high + slack;
}

static int box_contains(const sdr_shape *box, const double x[3], double tolerance)
{
  double local[3];
  sdr_box_to_local(box, x, local);
  for (int c = 0; c < 3; ++c) {
    if (!within(box->low[c], box->high[c], local[c], tolerance)) return 0;
  }
  return 1;
}

/* inner = 0: no hole. */
static int ring_contains(const sdr_shape *shape, double r2, double tolerance)
{
  const double outer = shape->outer + tolerance, inner = shape->inner - tolerance;
  if (outer < 0.0 || r2 > outer * outer) return 0;
  return !(shape->inner > 0.0) || inner <= 0.0 || r2 >= inner * inner;
}

static int half_space_contains(const sdr_shape *shape, const double x[3], double tolerance)
{
  const double d[3] = {x[0] - shape->centre[0], x[1] - shape->centre[1], x[2] - shape->centre[2]};
  return sdr_dot3(d, shape->normal) <= tolerance * sdr_norm3(shape->normal);
}

static int polygon_contains(const sdr_shape *shape, const double x[3], double tolerance)
{
  double distance = HUGE_VAL;
  int inside = 0;
  for (int k = 0, last = shape->vertex_count - 1; k < shape->vertex_count; last = k++) {
    const double *a = &shape->vertices[2 * last], *b = &shape->vertices[2 * k];
    if ((a[1] > x[1]) != (b[1] > x[1])) {
      const double crossing = a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
      if (x[0] < crossing) inside = !inside;
    }
    distance = fmin(distance, sdr_segment_distance(a, b, x));
  }
  return tolerance < 0.0 ? inside && distance >= -tolerance : inside || distance <= tolerance;
}

static int combination_contains(const sdr_shape *shape, const double x[3], double tolerance)
{
  const int difference = shape->kind == SDR_DIFFERENCE;
  for (int k = 0; k < shape->part_count; ++k) {
    const int negated = difference && k > 0;
    const int in = sdr_shape_contains(&shape->parts[k], x, negated ? -tolerance : tolerance);
    if (shape->kind == SDR_UNION && in) return 1;
    if (shape->kind != SDR_UNION && in == negated) return 0;
  }
  return shape->kind != SDR_UNION;
}

int sdr_shape_contains(const sdr_shape *shape, const double x[3], double tolerance)
{
  if (!shape) return 1;
  const double dx = x[0] - shape->centre[0], dy = x[1] - shape->centre[1];
  const double dz = x[2] - shape->centre[2];
  switch (shape->kind) {
  case SDR_BOX:
    return box_contains(shape, x, tolerance);
  case SDR_DISC:
  case SDR_ANNULUS:
    return ring_contains(shape, dx * dx + dy * dy, tolerance);
  case SDR_SPHERE:
    return ring_contains(shape, dx * dx + dy * dy + dz * dz, tolerance);
  case SDR_CYLINDER:
    return within(shape->low[2], shape->high[2], x[2], tolerance) &&
           ring_contains(shape, dx * dx + dy * dy, tolerance);
  case SDR_HALF_SPACE:
    return half_space_contains(shape, x, tolerance);
  case SDR_POLYGON:
    return polygon_contains(shape, x, tolerance);
  case SDR_GROUP:
    return sdr_import_holds(shape->group, x);
  case SDR_FACETS:
    return sdr_tree_nearest(shape->group->facets, x, NULL) <= tolerance;
  case SDR_UNION:
  case SDR_INTERSECTION:
  case SDR_DIFFERENCE:
    break;
  }
  return combination_contains(shape, x, tolerance);
}

static void unbounded(double low[3], double high[3])
{
  for (int c = 0; c < 3; ++c) {
    low[c] = -HUGE_VAL;
    high[c] = HUGE_VAL;
  }
}

static void include(const double x[3], int components, double low[3], double high[3])
{
  for (int c = 0; c < components; ++c) {
    low[c] = fmin(low[c], x[c]);
    high[c] = fmax(high[c], x[c]);
  }
}

static void box_bounds(const sdr_shape *box, double low[3], double high[3])
{
  for (int c = 0; c < 3; ++c) {
    low[c] = box->low[c];
    high[c] = box->high[c];
  }
  if (box->angle == 0.0) return;
  low[0] = low[1] = HUGE_VAL;
  high[0] = high[1] = -HUGE_VAL;
  for (int k = 0; k < 4; ++k) {
    const double corner[3] = {k & 1 ? box->high[0] : box->low[0],
                              k & 2 ? box->high[1] : box->low[1], 0.0};
    double x[3];
    sdr_box_to_space(box, corner, x);
    include(x, 2, low, high);
  }
}

static void ball_bounds(const sdr_shape *shape, int components, double low[3], double high[3])
{
  unbounded(low, high);
  for (int c = 0; c < components; ++c) {
    low[c] = shape->centre[c] - shape->outer;
    high[c] = shape->centre[c] + shape->outer;
  }
}

/* Bounded on one side if the normal lies along an axis. */
static void half_space_bounds(const sdr_shape *shape, double low[3], double high[3])
{
  unbounded(low, high);
  for (int c = 0; c < 3; ++c) {
    const int along = shape->normal[(c + 1) % 3] == 0.0 && shape->normal[(c + 2) % 3] == 0.0;
    if (along && shape->normal[c] > 0.0) high[c] = shape->centre[c];
    if (along && shape->normal[c] < 0.0) low[c] = shape->centre[c];
  }
}

static void polygon_bounds(const sdr_shape *shape, double low[3], double high[3])
{
  unbounded(low, high);
  low[0] = low[1] = HUGE_VAL;
  high[0] = high[1] = -HUGE_VAL;
  for (int k = 0; k < shape->vertex_count; ++k) include(&shape->vertices[2 * k], 2, low, high);
}

static void combination_bounds(const sdr_shape *shape, double low[3], double high[3])
{
  sdr_shape_bounds(&shape->parts[0], low, high);
  if (shape->kind == SDR_DIFFERENCE) return;
  for (int k = 1; k < shape->part_count; ++k) {
    double part_low[3], part_high[3];
    sdr_shape_bounds(&shape->parts[k], part_low, part_high);
    for (int c = 0; c < 3; ++c) {
      const int either = shape->kind == SDR_UNION;
      low[c] = either ? fmin(low[c], part_low[c]) : fmax(low[c], part_low[c]);
      high[c] = either ? fmax(high[c], part_high[c]) : fmin(high[c], part_high[c]);
    }
  }
}

void sdr_shape_bounds(const sdr_shape *shape, double low[3], double high[3])
{
  if (!shape) {
    unbounded(low, high);
    return;
  }
  switch (shape->kind) {
  case SDR_BOX:
    box_bounds(shape, low, high);
    return;
  case SDR_DISC:
  case SDR_ANNULUS:
    ball_bounds(shape, 2, low, high);
    return;
  case SDR_SPHERE:
    ball_bounds(shape, 3, low, high);
    return;
  case SDR_CYLINDER:
    ball_bounds(shape, 2, low, high);
    low[2] = shape->low[2];
    high[2] = shape->high[2];
    return;
  case SDR_HALF_SPACE:
    half_space_bounds(shape, low, high);
    return;
  case SDR_POLYGON:
    polygon_bounds(shape, low, high);
    return;
  case SDR_GROUP:
  case SDR_FACETS:
    unbounded(low, high);
    return;
  case SDR_UNION:
  case SDR_INTERSECTION:
  case SDR_DIFFERENCE:
    combination_bounds(shape, low, high);
    return;
  }
}
