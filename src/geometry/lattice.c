#include "geometry/lattice.h"

#include "base/memory.h"
#include "geometry/layer_points.h"
#include "geometry/place.h"
#include "geometry/point_values.h"
#include "geometry/shape.h"
#include "geometry/text.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_rng.h>
#include <math.h>

enum { MAX_LEVELS = 10, FIRST_SPANS = 1024 };

static const int64_t most_points = INT32_MAX - 8; /* 2^31 - 9: indices of padded arrays fit */
static const double most_cell = 1e9;

/* The lattice: site (i, j, k) lies at origin + sum over a of axes[a] h (i_a + offset_a). */
typedef struct {
  int components;
  double h, origin[3], axes[3][3], offset[3];
} frame;

/* Consecutive sites of a row that lie in the shape. */
typedef struct {
  int32_t cell[3], length;
} span;

typedef struct {
  span *list;
  int64_t count, capacity, sites;
} spans;

static void set_frame(const sdr_scene *scene, frame *f)
{
  const sdr_points_scene *points = &scene->points;
  *f = (frame){.components = sdr_components(scene->dimension), .h = points->spacing};
  for (int c = 0; c < 3; ++c) {
    f->axes[c][c] = 1.0;
    if (c >= f->components) continue;
    f->origin[c] = points->lattice_origin[c];
    f->offset[c] = points->cell_centred[c] ? 0.5 : 0.0;
  }
  if (points->angle != 0.0 && f->components > 1) {
    f->axes[0][0] = f->axes[1][1] = cos(points->angle);
    f->axes[0][1] = sin(points->angle);
    f->axes[1][0] = -f->axes[0][1];
  }
}

static void site_place(const frame *f, const double cell[3], double x[3])
{
  double q[3] = {0.0};
  for (int a = 0; a < f->components; ++a) q[a] = f->h * (cell[a] + f->offset[a]);
  for (int c = 0; c < 3; ++c) {
    x[c] = f->origin[c] + (f->axes[0][c] * q[0] + f->axes[1][c] * q[1] + f->axes[2][c] * q[2]);
  }
}

/* First and last cell per component that the bounds of the shape can hold; last < first: none. */
static void cell_range(const frame *f, const double low[3], const double high[3], double first[3],
                       double last[3])
{
  for (int a = 0; a < 3; ++a) first[a] = last[a] = 0.0;
  for (int a = 0; a < f->components; ++a) {
    double least = 0.0, most = 0.0;
    for (int c = 0; c < f->components; ++c) {
      const double e = f->axes[a][c] / f->h;
      if (e == 0.0) continue;
      least += e * ((e > 0.0 ? low : high)[c] - f->origin[c]);
      most += e * ((e > 0.0 ? high : low)[c] - f->origin[c]);
    }
    first[a] = ceil(least - f->offset[a] - 1e-6);
    last[a] = floor(most - f->offset[a] + 1e-6);
  }
}

static sdr_status add_span(spans *s, span one)
{
  if (s->count == s->capacity) {
    const int64_t capacity = s->capacity ? 2 * s->capacity : FIRST_SPANS;
    span *grown = sdr_realloc(s->list, (size_t)capacity, sizeof *grown);
    if (!grown) return SDR_RUN_FAILED;
    s->list = grown;
    s->capacity = capacity;
  }
  s->list[s->count++] = one;
  s->sites += one.length;
  return SDR_OK;
}

static sdr_status scan_row(const frame *f, const sdr_shape *shape, const double first[3],
                           const double last[3], double j, double k, spans *s)
{
  const double tolerance = SDR_SHAPE_TOLERANCE * f->h;
  span open = {{0, (int32_t)j, (int32_t)k}, 0};
  for (double i = first[0]; i <= last[0]; i += 1.0) {
    const double cell[3] = {i, j, k};
    double x[3];
    site_place(f, cell, x);
    if (sdr_shape_contains(shape, x, tolerance)) {
      if (open.length == 0) open.cell[0] = (int32_t)i;
      ++open.length;
    } else if (open.length > 0) {
      SDR_TRY(add_span(s, open));
      open.length = 0;
    }
  }
  return open.length > 0 ? add_span(s, open) : SDR_OK;
}

static sdr_status too_many(const sdr_scene *scene, double about)
{
  char spacing[SDR_LENGTH_TEXT];
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: spacing %s gives about %.2g points; at most %lld are possible, so take a "
                  "larger spacing or a smaller shape",
                  sdr_origin_text(scene->points.origin),
                  sdr_length_text(scene->points.spacing, spacing), about, (long long)most_points);
}

/* Sites in the shape, guessed from a coarse grid of samples over the cells' range. */
static double estimate_sites(const frame *f, const sdr_shape *shape, const double first[3],
                             const double last[3])
{
  static const int samples[4] = {1, 4096, 128, 32};
  const int n = samples[f->components];
  double sites = 1.0, inside = 0.0, tried = 0.0;
  for (int a = 0; a < f->components; ++a) sites *= last[a] - first[a] + 1.0;
  for (int k = 0; k < (f->components > 2 ? n : 1); ++k) {
    for (int j = 0; j < (f->components > 1 ? n : 1); ++j) {
      for (int i = 0; i < n; ++i) {
        const int at[3] = {i, j, k};
        double cell[3] = {0.0}, x[3];
        for (int a = 0; a < f->components; ++a) {
          cell[a] = first[a] + (last[a] - first[a]) * (at[a] + 0.5) / n;
        }
        site_place(f, cell, x);
        inside += sdr_shape_contains(shape, x, 0.0);
        tried += 1.0;
      }
    }
  }
  return sites * inside / tried;
}

static sdr_status check_range(const sdr_scene *scene, const frame *f, const double first[3],
                              const double last[3])
{
  for (int a = 0; a < f->components; ++a) {
    if (!isfinite(first[a]) || !isfinite(last[a])) {
      return sdr_fail(SDR_BAD_INPUT,
                      "%s: the shape of the points is not bounded; intersect it with a box",
                      sdr_origin_text(scene->points.origin));
    }
  }
  double boxed = 1.0;
  int far = 0;
  for (int a = 0; a < f->components; ++a) {
    boxed *= fmax(0.0, last[a] - first[a] + 1.0);
    far |= fabs(first[a]) > most_cell || fabs(last[a]) > most_cell;
  }
  if (!(boxed > 0.0)) return SDR_OK;
  const double about = estimate_sites(f, scene->points.shape, first, last);
  if (about > 1.1 * (double)most_points) return too_many(scene, about);
  if (far || boxed > 256.0 * (double)most_points) return too_many(scene, fmax(about, boxed));
  return SDR_OK;
}

static sdr_status scan(const sdr_scene *scene, const frame *f, spans *s)
{
  double low[3], high[3], first[3], last[3];
  sdr_shape_bounds(scene->points.shape, low, high);
  cell_range(f, low, high, first, last);
  SDR_TRY(check_range(scene, f, first, last));
  for (double k = first[2]; k <= last[2]; k += 1.0) {
    for (double j = first[1]; j <= last[1]; j += 1.0) {
      SDR_TRY(scan_row(f, scene->points.shape, first, last, j, k, s));
      if (s->sites > most_points) return too_many(scene, (double)s->sites);
    }
  }
  if (s->sites > 0) return SDR_OK;
  char spacing[SDR_LENGTH_TEXT];
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: the shape holds no lattice point at spacing %s; take a smaller spacing, a "
                  "larger shape or another alignment of the lattice",
                  sdr_origin_text(scene->points.origin), sdr_length_text(f->h, spacing));
}

/* Puts points where they go, or counts them only (points NULL). */
typedef struct {
  const sdr_scene *scene;
  const frame *frame;
  const int *refine_level; /* per entry of the scene's refine list */
  sdr_points *points;
  int64_t count;
} filler;

static void put(filler *fill, const double x[3], const int32_t at[3], double size, int level)
{
  const int64_t i = fill->count++;
  sdr_points *points = fill->points;
  if (!points) return;
  const int components = points->components;
  for (int c = 0; c < components; ++c) points->x[c][i] = x[c];
  points->spacing[i] = size;
  points->volume[i] = size * (components > 1 ? size : 1.0) *
                      (components > 2 ? size : fill->scene->points.thickness);
  if (points->level) points->level[i] = (uint8_t)level;
  for (int c = 0; points->cell && c < 3; ++c) points->cell[3 * i + c] = at[c];
}

static int wanted_level(const filler *fill, const double x[3], double size)
{
  int level = 0;
  for (int k = 0; k < fill->scene->points.refine_count; ++k) {
    const sdr_place *where = &fill->scene->points.refine[k].where;
    if (fill->refine_level[k] > level && sdr_place_holds(fill->scene, where, x, size, size)) {
      level = fill->refine_level[k];
    }
  }
  return level;
}

/* The cell `at` or, in order (z slowest), its children; `wanted` is the least level it must have.
 */
static void put_cell(filler *fill, const double x[3], const int32_t at[3], int level, int wanted)
{
  const frame *f = fill->frame;
  const double size = ldexp(f->h, -level);
  const int asked = wanted_level(fill, x, size);
  if (asked > wanted) wanted = asked;
  if (level >= wanted || fill->count > most_points) {
    put(fill, x, at, size, level);
    return;
  }
  for (int child = 0; child < 1 << f->components; ++child) {
    double place[3] = {x[0], x[1], x[2]};
    int32_t cell[3] = {at[0], at[1], at[2]};
    for (int a = 0; a < f->components; ++a) {
      cell[a] = 2 * at[a] + (child >> a & 1);
      const double step = child >> a & 1 ? 0.25 * size : -0.25 * size;
      for (int c = 0; c < 3; ++c) place[c] += step * f->axes[a][c];
    }
    put_cell(fill, place, cell, level + 1, wanted);
  }
}

static void fill_all(filler *fill, const spans *s)
{
  const frame *f = fill->frame;
  for (int64_t n = 0; n < s->count; ++n) {
    const span *row = &s->list[n];
    for (int32_t i = 0; i < row->length; ++i) {
      const int32_t at[3] = {row->cell[0] + i, row->cell[1], row->cell[2]};
      const double cell[3] = {at[0], at[1], at[2]};
      double x[3];
      site_place(f, cell, x);
      if (fill->scene->points.refine_count == 0) {
        put(fill, x, at, f->h, 0);
      } else {
        put_cell(fill, x, at, 0, 0);
      }
    }
  }
}

static sdr_status refine_levels(const sdr_scene *scene, int *levels)
{
  const double coarse = scene->points.spacing;
  for (int k = 0; k < scene->points.refine_count; ++k) {
    const double halvings = log2(coarse / scene->points.refine[k].spacing);
    const double whole = round(halvings);
    if (whole >= 1.0 && whole <= MAX_LEVELS && fabs(halvings - whole) < 1e-6) {
      levels[k] = (int)whole;
      continue;
    }
    char asked[SDR_LENGTH_TEXT], from[SDR_LENGTH_TEXT], near[SDR_LENGTH_TEXT];
    const double best = coarse / exp2(fmin(MAX_LEVELS, fmax(1.0, whole)));
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: refined spacing %s is not the spacing %s halved 1 to %d times; the "
                    "nearest is %s",
                    sdr_origin_text(scene->points.refine[k].where.origin),
                    sdr_length_text(scene->points.refine[k].spacing, asked),
                    sdr_length_text(coarse, from), MAX_LEVELS, sdr_length_text(best, near));
  }
  return SDR_OK;
}

/* 1 for a point on the surface, or beside it, where those stay. */
static int stays(const sdr_scene *scene, const sdr_points *points, int32_t i)
{
  double x[3] = {0.0};
  if (!scene->points.jitter_inside) return 0;
  for (int c = 0; c < points->components; ++c) x[c] = points->x[c][i];
  return !sdr_shape_contains(scene->points.shape, x, -0.25 * points->spacing[i]);
}

static sdr_status move_randomly(const sdr_scene *scene, sdr_points *points)
{
  gsl_set_error_handler_off(); /* its own one aborts */
  gsl_rng *random = gsl_rng_alloc(gsl_rng_mt19937);
  if (!random) return sdr_fail(SDR_RUN_FAILED, "out of memory: random numbers");
  gsl_rng_set(random, (unsigned long)scene->points.jitter_seed);
  points->irregular = 1;
  for (int32_t i = 0; i < points->count; ++i) {
    const double jitter = stays(scene, points, i) ? 0.0 : scene->points.jitter;
    for (int c = 0; c < points->components; ++c) {
      const double share = jitter * (2.0 * gsl_rng_uniform(random) - 1.0);
      points->x[c][i] += share * points->spacing[i];
    }
  }
  gsl_rng_free(random);
  return SDR_OK;
}

static sdr_status create_points(filler *fill, const spans *s)
{
  const sdr_points_scene *wanted = &fill->scene->points;
  const int refined = wanted->refine_count > 0, lattice = wanted->jitter == 0.0;
  fill->count = s->sites;
  if (refined) {
    fill->count = 0;
    fill_all(fill, s);
  }
  if (fill->count > most_points) return too_many(fill->scene, (double)fill->count);
  sdr_points *points = NULL;
  SDR_TRY(sdr_points_create((int32_t)fill->count, fill->frame->components, lattice, &points));
  fill->points = points;
  fill->count = 0;
  if (refined && !(points->level = sdr_alloc(sdr_points_padded(points), 1))) return SDR_RUN_FAILED;
  fill_all(fill, s);
  points->lattice_spacing = fill->frame->h;
  for (int a = 0; a < 3; ++a) {
    for (int c = 0; c < 3; ++c) points->axes[a][c] = fill->frame->axes[a][c];
  }
  return wanted->jitter != 0.0 ? move_randomly(fill->scene, points) : SDR_OK;
}

sdr_status sdr_lattice_points(const sdr_scene *scene, sdr_points **out)
{
  frame f;
  spans s = {0};
  int *levels = sdr_alloc((size_t)scene->points.refine_count, sizeof *levels);
  if (!levels) return SDR_RUN_FAILED;
  set_frame(scene, &f);
  filler fill = {.scene = scene, .frame = &f, .refine_level = levels};
  sdr_status status = refine_levels(scene, levels);
  if (status == SDR_OK) status = scan(scene, &f, &s);
  if (status == SDR_OK) status = create_points(&fill, &s);
  if (status == SDR_OK) status = sdr_points_set_horizon(scene, fill.points);
  if (status == SDR_OK) status = sdr_points_set_material(scene, fill.points);
  if (status == SDR_OK) status = sdr_layer_points(scene, &fill.points);
  if (status == SDR_OK) {
    *out = fill.points;
  } else {
    sdr_points_destroy(&fill.points);
  }
  sdr_free(s.list);
  sdr_free(levels);
  return status;
}
