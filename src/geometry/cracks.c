#include "geometry/cracks.h"

#include "base/small.h"
#include "geometry/shape.h"

#include <math.h>

/* Where a bond may be: the box around it, grown by the tolerance. */
typedef struct {
  double low[3], high[3];
} box;

/* Whether the box around two places meets another, in the first `components`. */
static int meets(const box *around, const double a[3], const double b[3], int components)
{
  for (int c = 0; c < components; ++c) {
    if (fmax(a[c], b[c]) < around->low[c] || fmin(a[c], b[c]) > around->high[c]) return 0;
  }
  return 1;
}

static double side(const double a[3], const double b[3], const double x[3])
{
  return (b[0] - a[0]) * (x[1] - a[1]) - (b[1] - a[1]) * (x[0] - a[0]);
}

/* Proper crossings by sides, touching and overlap by the distance of the ends. */
static int segments_meet(const double a[3], const double b[3], const double c[3], const double d[3],
                         double tolerance)
{
  const double ca = side(c, d, a), cb = side(c, d, b), ac = side(a, b, c), ad = side(a, b, d);
  if (((ca > 0.0 && cb < 0.0) || (ca < 0.0 && cb > 0.0)) &&
      ((ac > 0.0 && ad < 0.0) || (ac < 0.0 && ad > 0.0))) {
    return 1;
  }
  return sdr_segment_distance(c, d, a) <= tolerance || sdr_segment_distance(c, d, b) <= tolerance ||
         sdr_segment_distance(a, b, c) <= tolerance || sdr_segment_distance(a, b, d) <= tolerance;
}

static int polyline_cuts(const sdr_crack *crack, sdr_dimension dimension, const box *around,
                         const double a[3], const double b[3], double tolerance)
{
  const double *v = crack->vertices;
  if (dimension == SDR_1D) {
    for (int k = 0; k < crack->point_count; ++k) {
      if (meets(around, v + 3 * k, v + 3 * k, 1)) return 1;
    }
    return 0;
  }
  for (int k = 0; k + 1 < crack->point_count; ++k, v += 3) {
    if (meets(around, v, v + 3, 2) && segments_meet(a, b, v, v + 3, tolerance)) return 1;
  }
  return 0;
}

/* A plane patch: a disc (radius > 0) or the rectangle corner + s e[0] + t e[1], 0 <= s, t <= 1. */
typedef struct {
  double middle[3], normal[3]; /* unit */
  double radius;
  double corner[3], e[2][3], length[2];
} patch;

static void subtract(const double a[3], const double b[3], double c[3])
{
  for (int k = 0; k < 3; ++k) c[k] = a[k] - b[k];
}

static void scale_to_unit(double v[3])
{
  const double length = sdr_norm3(v);
  for (int k = 0; k < 3 && length > 0.0; ++k) v[k] /= length;
}

static void disc_patch(const sdr_crack *crack, patch *p)
{
  for (int c = 0; c < 3; ++c) {
    p->middle[c] = crack->vertices[c];
    p->normal[c] = crack->normal[c];
  }
  p->radius = crack->radius;
  scale_to_unit(p->normal);
}

/* The corner with the angle nearest to a right one lies between the other two. */
static int middle_corner(const double *v)
{
  int best = 0;
  double least = HUGE_VAL;
  for (int k = 0; k < 3; ++k) {
    double e[3], g[3];
    subtract(v + 3 * ((k + 1) % 3), v + 3 * k, e);
    subtract(v + 3 * ((k + 2) % 3), v + 3 * k, g);
    const double off = fabs(sdr_dot3(e, g)) / (sdr_norm3(e) * sdr_norm3(g));
    if (off < least) {
      least = off;
      best = k;
    }
  }
  return best;
}

static void rectangle_patch(const sdr_crack *crack, patch *p)
{
  const double *v = crack->vertices;
  const int k = middle_corner(v);
  subtract(v + 3 * ((k + 1) % 3), v + 3 * k, p->e[0]);
  subtract(v + 3 * ((k + 2) % 3), v + 3 * k, p->e[1]);
  sdr_cross3(p->e[0], p->e[1], p->normal);
  scale_to_unit(p->normal);
  for (int c = 0; c < 3; ++c) {
    p->corner[c] = v[3 * k + c];
    p->middle[c] = p->corner[c];
  }
  for (int s = 0; s < 2; ++s) {
    p->length[s] = sdr_norm3(p->e[s]);
    scale_to_unit(p->e[s]);
  }
  p->radius = 0.0;
}

static double distance_to_segment(const double x[3], const double a[3], const double b[3])
{
  double e[3], d[3];
  subtract(b, a, e);
  subtract(x, a, d);
  const double length2 = sdr_dot3(e, e);
  const double s = length2 > 0.0 ? fmin(1.0, fmax(0.0, sdr_dot3(d, e) / length2)) : 0.0;
  for (int c = 0; c < 3; ++c) d[c] -= s * e[c];
  return sdr_norm3(d);
}

/* Whether the part of a-b in the patch's plane touches the patch: the segment is clipped by the
   two pairs of parallel edges. */
static int rectangle_touched(const patch *p, const double a[3], const double b[3], double tolerance)
{
  double from = 0.0, to = 1.0, da[3], db[3];
  subtract(a, p->corner, da);
  subtract(b, p->corner, db);
  for (int s = 0; s < 2; ++s) {
    const double low = -tolerance, high = p->length[s] + tolerance;
    const double start = sdr_dot3(da, p->e[s]), step = sdr_dot3(db, p->e[s]) - start;
    if (fabs(step) <= 1e-15 * p->length[s]) {
      if (start < low || start > high) return 0;
      continue;
    }
    const double t0 = (low - start) / step, t1 = (high - start) / step;
    from = fmax(from, fmin(t0, t1));
    to = fmin(to, fmax(t0, t1));
  }
  return from <= to;
}

static int patch_cuts(const patch *p, const double a[3], const double b[3], double tolerance)
{
  double d[3], start[3], end[3];
  subtract(a, p->middle, d);
  const double ha = sdr_dot3(d, p->normal);
  subtract(b, p->middle, d);
  const double hb = sdr_dot3(d, p->normal);
  if (fmin(ha, hb) > tolerance || fmax(ha, hb) < -tolerance) return 0;
  /* the part of the bond within the tolerance of the plane, and at least the crossing itself */
  double from = 0.0, to = 1.0;
  if (fabs(hb - ha) > 2.0 * tolerance) {
    const double t0 = (-tolerance - ha) / (hb - ha), t1 = (tolerance - ha) / (hb - ha);
    from = fmax(0.0, fmin(t0, t1));
    to = fmin(1.0, fmax(t0, t1));
  }
  for (int c = 0; c < 3; ++c) {
    start[c] = a[c] + from * (b[c] - a[c]);
    end[c] = a[c] + to * (b[c] - a[c]);
  }
  if (p->radius > 0.0) return distance_to_segment(p->middle, start, end) <= p->radius + tolerance;
  return rectangle_touched(p, start, end, tolerance);
}

static void crack_patch(const sdr_crack *crack, patch *p)
{
  if (crack->kind == SDR_CRACK_DISC) {
    disc_patch(crack, p);
  } else {
    rectangle_patch(crack, p);
  }
}

static void patch_bounds(const patch *p, double low[3], double high[3])
{
  for (int c = 0; c < 3; ++c) {
    double below = 0.0, above = 0.0;
    if (p->radius > 0.0) {
      above = p->radius * sqrt(fmax(0.0, 1.0 - p->normal[c] * p->normal[c]));
      below = -above;
    }
    for (int s = 0; s < 2 && !(p->radius > 0.0); ++s) {
      below += fmin(0.0, p->e[s][c] * p->length[s]);
      above += fmax(0.0, p->e[s][c] * p->length[s]);
    }
    low[c] = p->middle[c] + below;
    high[c] = p->middle[c] + above;
  }
}

static int crack_near(const sdr_crack *crack, sdr_dimension dimension, const box *around)
{
  const double *v = crack->vertices;
  if (crack->kind != SDR_CRACK_POLYLINE) {
    patch p;
    double low[3], high[3];
    crack_patch(crack, &p);
    patch_bounds(&p, low, high);
    return meets(around, low, high, 3);
  }
  const int components = dimension == SDR_1D ? 1 : 2;
  const int next = crack->point_count > 1 && dimension != SDR_1D ? 1 : 0;
  for (int k = 0; k + next < crack->point_count; ++k) {
    if (meets(around, v + 3 * k, v + 3 * (k + next), components)) return 1;
  }
  return 0;
}

static box grown_box(const double a[3], const double b[3], double tolerance)
{
  box around;
  for (int c = 0; c < 3; ++c) {
    around.low[c] = fmin(a[c], b[c]) - tolerance;
    around.high[c] = fmax(a[c], b[c]) + tolerance;
  }
  return around;
}

int sdr_cracks_cut(const sdr_scene *scene, const double a[3], const double b[3], double tolerance)
{
  const box around = grown_box(a, b, tolerance);
  for (int k = 0; k < scene->crack_count; ++k) {
    const sdr_crack *crack = &scene->crack[k];
    if (crack->kind == SDR_CRACK_POLYLINE) {
      if (polyline_cuts(crack, scene->dimension, &around, a, b, tolerance)) return 1;
      continue;
    }
    patch p;
    crack_patch(crack, &p);
    if (patch_cuts(&p, a, b, tolerance)) return 1;
  }
  return 0;
}

int sdr_cracks_near(const sdr_scene *scene, const double low[3], const double high[3],
                    double tolerance)
{
  const box around = grown_box(low, high, tolerance);
  for (int k = 0; k < scene->crack_count; ++k) {
    if (crack_near(&scene->crack[k], scene->dimension, &around)) return 1;
  }
  return 0;
}
