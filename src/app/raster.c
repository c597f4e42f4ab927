#include "app/raster.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* The eye looks from `toward` at the body; rows of an orthonormal frame (isometric). */
static const double across[3] = {0.70710678118654752, 0.70710678118654752, 0.0};
static const double upward[3] = {-0.40824829046386302, 0.40824829046386302, 0.81649658092772603};
static const double toward[3] = {0.57735026918962576, -0.57735026918962576, 0.57735026918962576};
/* Light on the faces that the eye sees: those with normals +x, -y, +z. */
static const float face_shade[3] = {0.88F, 0.94F, 1.0F};

/* A pixel within `near` spacings of a point belongs to the body; one within `bridge` does if body
   lies on all four sides of it (a gap between jittered points). */
static const double near_enough = 0.75, bridge = 1.1;

static double dot(const double a[3], const double b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void sdr_raster_project(const double position[3], int dimension, double plane[2], double *depth)
{
  plane[0] = dimension == 3 ? dot(position, across) : position[0];
  plane[1] = dimension == 3 ? dot(position, upward) : position[1];
  *depth = dimension == 3 ? dot(position, toward) : 0.0;
}

static void point_at(const sdr_cloud *cloud, int32_t i, double x[3])
{
  for (int c = 0; c < 3; ++c) x[c] = c < cloud->dimension ? cloud->position[c][i] : 0.0;
}

/* ---- spacing ---- */

/* Points sorted into cubes of one size, for the neighbours' distances. */
typedef struct {
  double low[3], size;
  int cells[3];
  int32_t *start, *point;
} buckets;

static int bucket_coordinate(const buckets *grid, int c, double x)
{
  const int k = (int)((x - grid->low[c]) / grid->size);
  return k < 0 ? 0 : k >= grid->cells[c] ? grid->cells[c] - 1 : k;
}

static size_t bucket_of(const buckets *grid, const double x[3])
{
  size_t k = 0;
  for (int c = 2; c >= 0; --c)
    k = k * (size_t)grid->cells[c] + (size_t)bucket_coordinate(grid, c, x[c]);
  return k;
}

static void bucket_shape(const sdr_cloud *cloud, buckets *grid)
{
  double extent[3] = {0.0, 0.0, 0.0}, content = 1.0;
  int wide = 0;
  for (int c = 0; c < cloud->dimension; ++c) {
    double high = -INFINITY;
    grid->low[c] = INFINITY;
    for (int32_t i = 0; i < cloud->count; ++i) {
      grid->low[c] = fmin(grid->low[c], cloud->position[c][i]);
      high = fmax(high, cloud->position[c][i]);
    }
    extent[c] = high - grid->low[c];
    if (extent[c] > 0.0 && ++wide) content *= extent[c];
  }
  grid->size = wide ? pow(content / cloud->count, 1.0 / wide) : 1.0;
  for (int c = 0; c < 3; ++c) {
    const double cells = fmin(floor(extent[c] / grid->size) + 1.0, cloud->count);
    grid->cells[c] = (int)fmin(cells, 4096.0);
  }
  for (int c = 0; c < 3; ++c) grid->size = fmax(grid->size, extent[c] / grid->cells[c]);
}

static sdr_status fill_buckets(const sdr_cloud *cloud, buckets *grid)
{
  bucket_shape(cloud, grid);
  const size_t cells = (size_t)grid->cells[0] * (size_t)grid->cells[1] * (size_t)grid->cells[2];
  grid->start = sdr_alloc(cells + 1, sizeof(int32_t));
  grid->point = sdr_alloc((size_t)cloud->count, sizeof(int32_t));
  if (!grid->start || !grid->point) return SDR_RUN_FAILED;
  double x[3];
  for (int32_t i = 0; i < cloud->count; ++i) {
    point_at(cloud, i, x);
    ++grid->start[bucket_of(grid, x) + 1];
  }
  for (size_t k = 0; k < cells; ++k) grid->start[k + 1] += grid->start[k];
  for (int32_t i = cloud->count - 1; i >= 0; --i) {
    point_at(cloud, i, x);
    const size_t k = bucket_of(grid, x);
    grid->point[--grid->start[k + 1]] = i; /* from the end of bucket k down to its begin */
  }
  for (size_t k = 0; k < cells; ++k) grid->start[k] = grid->start[k + 1];
  grid->start[cells] = cloud->count;
  return SDR_OK;
}

static void keep_smallest(double *smallest, int count, double value)
{
  for (int k = 0; k < count; ++k) {
    if (value >= smallest[k]) continue;
    const double next = smallest[k];
    smallest[k] = value;
    value = next;
  }
}

/* Mean distance of the 2 dim nearest points (a lattice point's are all at the spacing); NAN if the
   buckets around hold fewer. */
static double neighbour_distance(const sdr_cloud *cloud, const buckets *grid, int32_t i)
{
  enum { REACH = 2 };
  double x[3], y[3], nearest[6];
  const int wanted = 2 * cloud->dimension;
  for (int k = 0; k < wanted; ++k) nearest[k] = INFINITY;
  int from[3], to[3];
  point_at(cloud, i, x);
  for (int c = 0; c < 3; ++c) {
    const int k = bucket_coordinate(grid, c, x[c]);
    from[c] = k > REACH ? k - REACH : 0;
    to[c] = k + REACH < grid->cells[c] ? k + REACH : grid->cells[c] - 1;
  }
  for (int k2 = from[2]; k2 <= to[2]; ++k2)
    for (int k1 = from[1]; k1 <= to[1]; ++k1) {
      const size_t row =
          ((size_t)k2 * (size_t)grid->cells[1] + (size_t)k1) * (size_t)grid->cells[0];
      for (int32_t p = grid->start[row + (size_t)from[0]]; p < grid->start[row + (size_t)to[0] + 1];
           ++p) {
        if (grid->point[p] == i) continue;
        point_at(cloud, grid->point[p], y);
        keep_smallest(nearest, wanted, hypot(hypot(y[0] - x[0], y[1] - x[1]), y[2] - x[2]));
      }
    }
  double sum = 0.0;
  for (int k = 0; k < wanted; ++k) sum += nearest[k];
  return isfinite(sum) ? sum / wanted : (double)NAN;
}

static int rising(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double median(double *values, int count)
{
  qsort(values, (size_t)count, sizeof *values, rising);
  return values[count / 2];
}

/* Medians over a sample of points: of the spacing (for a few scattered points the whole extent's
   share of one) and of the volume (0: not known). */
static void measure_sample(const sdr_cloud *cloud, const buckets *grid, sdr_extent *extent)
{
  enum { SAMPLE = 2001 };
  double distance[SAMPLE], volume[SAMPLE];
  int near_count = 0, volume_count = 0;
  const int32_t stride = cloud->count / SAMPLE + 1;
  for (int32_t i = 0; i < cloud->count; i += stride) {
    const double found = neighbour_distance(cloud, grid, i);
    if (found > 0.0) distance[near_count++] = found;
    if (cloud->volume) volume[volume_count++] = cloud->volume[i];
  }
  extent->spacing = near_count ? median(distance, near_count) : grid->size;
  extent->volume = volume_count ? median(volume, volume_count) : 0.0;
}

/* ---- extent ---- */

/* Every point's offset from the first one a whole number of spacings, and none a coarser one? */
static int on_a_lattice(const sdr_cloud *cloud, double spacing, double volume)
{
  for (int32_t i = 0; volume > 0.0 && i < cloud->count; ++i)
    if (cloud->volume[i] > 1.5 * volume) return 0;
  for (int c = 0; c < cloud->dimension; ++c)
    for (int32_t i = 0; i < cloud->count; ++i) {
      const double steps = (cloud->position[c][i] - cloud->position[c][0]) / spacing;
      if (!(fabs(steps - nearbyint(steps)) < 1e-3)) return 0;
    }
  return 1;
}

/* Spacing of one point, from its share of the median volume. */
static double own_spacing(const sdr_cloud *cloud, const sdr_extent *extent, int32_t i)
{
  if (extent->lattice || !(extent->volume > 0.0)) return extent->spacing;
  const double share = cloud->volume[i] / extent->volume;
  const double factor = cloud->dimension == 3 ? cbrt(share) : sqrt(share);
  return extent->spacing * (factor > 0.05 && factor < 20.0 ? factor : 1.0);
}

sdr_status sdr_raster_measure(const sdr_cloud *cloud, sdr_extent *out)
{
  buckets grid = {0};
  sdr_extent extent = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}, 0.0, 0.0, 0, 0};
  const sdr_status status = fill_buckets(cloud, &grid);
  if (status == SDR_OK) measure_sample(cloud, &grid, &extent);
  sdr_free(grid.start);
  sdr_free(grid.point);
  if (status != SDR_OK) return status;
  extent.lattice = on_a_lattice(cloud, extent.spacing, extent.volume);
  const double half = (cloud->dimension == 3 ? sqrt(0.5) : 0.5) * extent.spacing;
  for (int32_t i = 0; i < cloud->count; ++i) {
    double x[3], plane[2], depth;
    point_at(cloud, i, x);
    sdr_raster_project(x, cloud->dimension, plane, &depth);
    for (int c = 0; c < 2; ++c) {
      extent.low[c] = fmin(extent.low[c], plane[c] - half);
      extent.high[c] = fmax(extent.high[c], plane[c] + half);
    }
  }
  *out = extent;
  return SDR_OK;
}

sdr_window sdr_raster_window(const sdr_extent *extents, int count, int target)
{
  sdr_extent all = extents[0];
  for (int k = 1; k < count; ++k) {
    for (int c = 0; c < 2; ++c) {
      all.low[c] = fmin(all.low[c], extents[k].low[c]);
      all.high[c] = fmax(all.high[c], extents[k].high[c]);
    }
    all.spacing = fmin(all.spacing, extents[k].spacing);
  }
  const double size[2] = {all.high[0] - all.low[0], all.high[1] - all.low[1]};
  const double border = 0.03 * fmax(size[0], size[1]);
  const double cells = (fmax(size[0], size[1]) + 2.0 * border) / all.spacing;
  double per_cell = ceil(target / cells);
  if (per_cell * cells > 1.5 * target) per_cell = fmax(1.0, per_cell - 1.0);
  sdr_window window = {.pixel = all.spacing / per_cell};
  if (per_cell * cells > 3.0 * target) window.pixel = cells * all.spacing / (3.0 * target);
  int pixels[2];
  double corner[2];
  for (int c = 0; c < 2; ++c) {
    const double space = fmax(border, 0.5 * (0.25 * fmax(size[0], size[1]) - size[c]));
    const double extra = ceil(space / window.pixel);
    pixels[c] = (int)(ceil(size[c] / window.pixel - 1e-6) + 2.0 * extra);
    corner[c] = all.low[c] - extra * window.pixel;
  }
  window.width = pixels[0];
  window.height = pixels[1];
  window.left = corner[0];
  window.bottom = corner[1];
  return window;
}

/* ---- painting ---- */

/* One point on its way to the image. */
typedef struct {
  double plane[2], depth; /* m */
  double spacing;         /* m: its own */
  float value;
} spot;

/* Pixels from..to (both included, inside the window) whose centres lie within `reach` of `at`. */
static void pixel_range(double at, double reach, double corner, double pixel, int count, int *from,
                        int *to)
{
  const double low = ceil((at - reach - corner) / pixel - 0.5 - 1e-6);
  const double high = floor((at + reach - corner) / pixel - 0.5 + 1e-6);
  *from = low > 0.0 ? (int)fmin(low, count) : 0;
  *to = high < count - 1 ? (int)fmax(high, -1.0) : count - 1;
}

/* Rank of a spot at an offset from its centre (smaller wins, INFINITY: not there), and its shade:
   in the plane the distance in spacings, of squares on a lattice; in space the depth of the cube's
   face. */
static double plane_rank(const spot *point, const sdr_extent *extent, double dx, double dy)
{
  if (extent->lattice)
    return fmax(fabs(dx), fabs(dy)) <= 0.500001 * point->spacing ? hypot(dx, dy) / point->spacing
                                                                 : (double)INFINITY;
  const double distance =
      (extent->squares ? fmax(fabs(dx), fabs(dy)) : hypot(dx, dy)) / point->spacing;
  return distance <= bridge ? distance : (double)INFINITY;
}

static double cube_rank(const spot *point, double dx, double dy, float *shade)
{
  const double half = 0.5001 * point->spacing;
  double leave = INFINITY, enter = -INFINITY;
  int face = 0;
  for (int c = 0; c < 3; ++c) {
    const double x = dx * across[c] + dy * upward[c];
    const double one = (half - x) / toward[c], other = (-half - x) / toward[c];
    enter = fmax(enter, fmin(one, other));
    if (fmax(one, other) < leave) {
      leave = fmax(one, other);
      face = c;
    }
  }
  if (enter > leave) return INFINITY;
  *shade = face_shade[face];
  return -(point->depth + leave);
}

typedef struct {
  const sdr_extent *extent;
  int dimension;
  sdr_raster *raster;
  float *rank; /* of what a pixel shows */
} canvas;

static void paint_spot(const canvas *on, const spot *point)
{
  const sdr_window *window = &on->raster->window;
  const double reach = (on->extent->lattice ? 0.5 : bridge) * point->spacing;
  int from[2], to[2];
  const double spread = on->dimension == 3 ? 0.85 * point->spacing : reach;
  pixel_range(point->plane[0], spread, window->left, window->pixel, window->width, &from[0],
              &to[0]);
  pixel_range(point->plane[1], spread, window->bottom, window->pixel, window->height, &from[1],
              &to[1]);
  for (int row = from[1]; row <= to[1]; ++row)
    for (int column = from[0]; column <= to[0]; ++column) {
      const double dx = window->left + (column + 0.5) * window->pixel - point->plane[0];
      const double dy = window->bottom + (row + 0.5) * window->pixel - point->plane[1];
      float shade = 1.0F;
      const double rank = on->dimension == 3 ? cube_rank(point, dx, dy, &shade)
                                             : plane_rank(point, on->extent, dx, dy);
      const size_t k = (size_t)row * (size_t)window->width + (size_t)column;
      if (!((float)rank < on->rank[k])) continue;
      on->rank[k] = (float)rank;
      on->raster->value[k] = point->value;
      on->raster->shade[k] = shade;
    }
}

/* Cells smaller than pixels: the pixel that holds the point, the largest magnitude shows. */
static void paint_pixel(const canvas *on, const spot *point)
{
  const sdr_window *window = &on->raster->window;
  const double column = floor((point->plane[0] - window->left) / window->pixel);
  const double row = floor((point->plane[1] - window->bottom) / window->pixel);
  if (column < 0.0 || row < 0.0 || column >= window->width || row >= window->height) return;
  const size_t k = (size_t)row * (size_t)window->width + (size_t)column;
  if (fabsf(point->value) <= fabsf(on->raster->value[k])) return;
  on->raster->value[k] = point->value;
  on->rank[k] = 0.0F;
}

static void paint_points(const canvas *on, const sdr_cloud *cloud, const float *value)
{
  const int fine = cloud->dimension == 2 && on->raster->window.pixel > 1.001 * on->extent->spacing;
  for (int32_t i = 0; i < cloud->count; ++i) {
    if (!isfinite(value[i])) continue;
    double x[3];
    spot point = {.value = value[i], .spacing = own_spacing(cloud, on->extent, i)};
    point_at(cloud, i, x);
    sdr_raster_project(x, cloud->dimension, point.plane, &point.depth);
    if (fine)
      paint_pixel(on, &point);
    else
      paint_spot(on, &point);
  }
}

/* A square's own half side, with a hair for those that still touch. */
static float surely_body(const sdr_extent *extent)
{
  return extent->squares ? 0.52F : (float)near_enough;
}

/* Does a pixel that certainly belongs to the body lie within `reach` pixels in this direction? */
static int body_beside(const canvas *on, int column, int row, int right, int up, int reach)
{
  const sdr_window *window = &on->raster->window;
  for (int k = 1; k <= reach; ++k) {
    const int c = column + k * right, r = row + k * up;
    if (c < 0 || r < 0 || c >= window->width || r >= window->height) return 0;
    if (on->rank[(size_t)r * (size_t)window->width + (size_t)c] <= surely_body(on->extent))
      return 1;
  }
  return 0;
}

/* Whether a pixel beyond what certainly is body closes a gap in it: between jittered points one
   with body on all four sides, between squares that were moved apart one that is near and has it on
   two opposite ones. */
static int closes_gap(const canvas *on, int column, int row, float rank)
{
  const int reach = (int)ceil(1.2 * on->extent->spacing / on->raster->window.pixel);
  const int level =
      body_beside(on, column, row, 1, 0, reach) && body_beside(on, column, row, -1, 0, reach);
  const int upright =
      body_beside(on, column, row, 0, 1, reach) && body_beside(on, column, row, 0, -1, reach);
  if (on->extent->squares) return rank <= (float)near_enough && (level || upright);
  return level && upright;
}

/* Points off a lattice were painted up to `bridge`: take the rim off again, keep closed gaps. */
static void trim(const canvas *on)
{
  const sdr_window *window = &on->raster->window;
  for (int row = 0; row < window->height; ++row)
    for (int column = 0; column < window->width; ++column) {
      const size_t k = (size_t)row * (size_t)window->width + (size_t)column;
      if (on->rank[k] <= surely_body(on->extent) || !isfinite(on->rank[k])) continue;
      if (!closes_gap(on, column, row, on->rank[k])) on->raster->value[k] = NAN;
    }
}

sdr_status sdr_raster_paint(const sdr_cloud *cloud, const sdr_extent *extent, const float *value,
                            const sdr_window *window, sdr_raster *out)
{
  const size_t count = (size_t)window->width * (size_t)window->height;
  sdr_raster raster = {*window, sdr_alloc(count, sizeof(float)), sdr_alloc(count, sizeof(float))};
  float *rank = sdr_alloc(count, sizeof(float));
  if (!raster.value || !raster.shade || !rank) {
    sdr_raster_clear(&raster);
    sdr_free(rank);
    return SDR_RUN_FAILED;
  }
  for (size_t k = 0; k < count; ++k) {
    raster.value[k] = NAN;
    raster.shade[k] = 1.0F;
    rank[k] = INFINITY;
  }
  const canvas on = {extent, cloud->dimension, &raster, rank};
  paint_points(&on, cloud, value);
  if (cloud->dimension == 2 && !extent->lattice) trim(&on);
  sdr_free(rank);
  *out = raster;
  return SDR_OK;
}

void sdr_raster_clear(sdr_raster *raster)
{
  sdr_free(raster->value);
  sdr_free(raster->shade);
  *raster = (sdr_raster){0};
}
