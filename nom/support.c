#include "nom/support.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "nom/cells.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { BLOCK = 256 }; /* points a task */

static const double tie = 1e-9; /* relative, of squared distances: counts as equal */

/* One search; every support is in the end all points within a distance. */
typedef struct {
  const sdr_cloud *cloud;
  const sdr_cells *cells;
  const int32_t *wanted;  /* nearest points that i wants; NULL: `nearest` for all */
  int32_t nearest;        /* 0: limit[i] is given */
  const sdr_support *old; /* whose rows those with wanted[i] = 0 keep; NULL: none */
  double *limit;          /* square of the largest distance inside */
  int64_t *row;
  int32_t *column; /* NULL: only count, into row[i + 1] */
} search;

sdr_point_name sdr_point_named(const sdr_cloud *cloud, int32_t i)
{
  sdr_point_name name;
  double x[3] = {0.0};
  for (int a = 0; a < cloud->components; ++a) x[a] = cloud->x[a][i];
  if (cloud->components == 1)
    snprintf(name.text, sizeof name.text, "point %d at (%.9g)", (int)i, x[0]);
  else if (cloud->components == 2)
    snprintf(name.text, sizeof name.text, "point %d at (%.9g, %.9g)", (int)i, x[0], x[1]);
  else
    snprintf(name.text, sizeof name.text, "point %d at (%.9g, %.9g, %.9g)", (int)i, x[0], x[1],
             x[2]);
  return name;
}

static double distance_squared(const sdr_cloud *cloud, int32_t i, int32_t j)
{
  double square = 0.0;
  for (int a = 0; a < cloud->components; ++a) {
    const double d = cloud->x[a][j] - cloud->x[a][i];
    square += d * d;
  }
  return square;
}

static int keeps_old(const search *s, int32_t i)
{
  return s->old && s->wanted[i] <= 0;
}

/* ---- distance of the k-th nearest point ------------------------------------------------------ */

/* The `wanted` smallest squared distances so far, ascending. */
typedef struct {
  int32_t wanted, found;
  double square[SDR_MOST_NEAREST];
} nearest_so_far;

static void offer(nearest_so_far *near, double square)
{
  if (near->found == near->wanted && square >= near->square[near->found - 1]) return;
  int32_t at = near->found < near->wanted ? near->found++ : near->found - 1;
  for (; at > 0 && near->square[at - 1] > square; --at) near->square[at] = near->square[at - 1];
  near->square[at] = square;
}

static void offer_cell(const search *s, int32_t i, const int32_t c[3], nearest_so_far *near)
{
  const sdr_cells *cells = s->cells;
  for (int a = 0; a < 3; ++a)
    if (c[a] < 0 || c[a] >= cells->n[a]) return;
  const int64_t cell = ((int64_t)c[2] * cells->n[1] + c[1]) * cells->n[0] + c[0];
  for (int64_t k = cells->first[cell]; k < cells->first[cell + 1]; ++k)
    if (cells->point[k] != i) offer(near, distance_squared(s->cloud, i, cells->point[k]));
}

/* The cells that are exactly `ring` away from `own` along some axis. */
static void offer_ring(const search *s, int32_t i, const int32_t own[3], int32_t ring,
                       nearest_so_far *near)
{
  const int d = s->cloud->components;
  const int32_t ry = d > 1 ? ring : 0, rz = d > 2 ? ring : 0;
  for (int32_t z = -rz; z <= rz; ++z)
    for (int32_t y = -ry; y <= ry; ++y) {
      const int whole =
          ring == 0 || (d > 2 && (z == -ring || z == ring)) || (d > 1 && (y == -ring || y == ring));
      for (int32_t x = -ring; x <= ring; x += whole ? 1 : 2 * ring) {
        const int32_t c[3] = {own[0] + x, own[1] + y, own[2] + z};
        offer_cell(s, i, c, near);
      }
    }
}

/* Square of the distance of the k-th nearest point, enlarged by the tie. */
static double limit_of(const search *s, int32_t i, int32_t wanted)
{
  nearest_so_far near = {.wanted = wanted};
  const sdr_cells *cells = s->cells;
  int32_t own[3] = {0}, most = 0;
  for (int a = 0; a < s->cloud->components; ++a) {
    own[a] = sdr_cells_coordinate(cells, a, s->cloud->x[a][i]);
    most = cells->n[a] > most ? cells->n[a] : most;
  }
  for (int32_t ring = 0; ring <= most; ++ring) {
    offer_ring(s, i, own, ring, &near);
    const double sure = ring * cells->size; /* nothing nearer is left outside */
    if (near.found == wanted && near.square[wanted - 1] <= sure * sure) break;
  }
  return near.square[wanted - 1] * (1.0 + tie);
}

static void limit_block(void *context, int block)
{
  const search *s = context;
  const int32_t first = block * BLOCK;
  const int32_t end = first + BLOCK < s->cloud->count ? first + BLOCK : s->cloud->count;
  for (int32_t i = first; i < end; ++i)
    if (!keeps_old(s, i)) s->limit[i] = limit_of(s, i, s->wanted ? s->wanted[i] : s->nearest);
}

/* ---- all points within a distance ------------------------------------------------------------ */

static void sort_ascending(int32_t *values, int64_t count)
{
  for (int64_t k = 1; k < count; ++k) {
    const int32_t value = values[k];
    int64_t at = k;
    for (; at > 0 && values[at - 1] > value; --at) values[at] = values[at - 1];
    values[at] = value;
  }
}

static int64_t search_cell(const search *s, int32_t i, int64_t cell, int32_t *column)
{
  int64_t found = 0;
  for (int64_t k = s->cells->first[cell]; k < s->cells->first[cell + 1]; ++k) {
    const int32_t j = s->cells->point[k];
    if (j == i || distance_squared(s->cloud, i, j) > s->limit[i]) continue;
    if (column) column[found] = j;
    ++found;
  }
  return found;
}

static int64_t search_point(const search *s, int32_t i, int32_t *column)
{
  const sdr_cells *cells = s->cells;
  int32_t low[3] = {0}, high[3] = {0};
  const double reach = sqrt(s->limit[i]) * (1.0 + tie);
  for (int a = 0; a < s->cloud->components; ++a) {
    low[a] = sdr_cells_coordinate(cells, a, s->cloud->x[a][i] - reach);
    high[a] = sdr_cells_coordinate(cells, a, s->cloud->x[a][i] + reach);
  }
  int64_t found = 0;
  for (int64_t z = low[2]; z <= high[2]; ++z)
    for (int64_t y = low[1]; y <= high[1]; ++y)
      for (int64_t x = low[0]; x <= high[0]; ++x)
        found += search_cell(s, i, (z * cells->n[1] + y) * cells->n[0] + x,
                             column ? column + found : NULL);
  if (column) sort_ascending(column, found);
  return found;
}

static void keep_point(const search *s, int32_t i)
{
  const int64_t first = s->old->row[i], count = s->old->row[i + 1] - first;
  if (s->column)
    memcpy(s->column + s->row[i], s->old->column + first, (size_t)count * sizeof *s->column);
  else
    s->row[i + 1] = count;
}

static void search_block(void *context, int block)
{
  const search *s = context;
  const int32_t first = block * BLOCK;
  const int32_t end = first + BLOCK < s->cloud->count ? first + BLOCK : s->cloud->count;
  for (int32_t i = first; i < end; ++i)
    if (keeps_old(s, i))
      keep_point(s, i);
    else if (s->column)
      search_point(s, i, s->column + s->row[i]);
    else
      s->row[i + 1] = search_point(s, i, NULL);
}

/* ---- the whole ------------------------------------------------------------------------------- */

static sdr_status check_cloud(const sdr_cloud *cloud)
{
  if (cloud->components < 1 || cloud->components > 3)
    return sdr_fail(SDR_BAD_INPUT, "supports exist in 1, 2 and 3 dimensions, not in %d",
                    cloud->components);
  if (cloud->count < 1) return sdr_fail(SDR_BAD_INPUT, "supports need points, and there are none");
  for (int32_t i = 0; i < cloud->count; ++i)
    for (int a = 0; a < cloud->components; ++a)
      if (!isfinite(cloud->x[a][i]))
        return sdr_fail(SDR_BAD_INPUT, "%s: a position must be a finite number",
                        sdr_point_named(cloud, i).text);
  return SDR_OK;
}

/* Points that coincide have no bond vector; at i < j. */
static sdr_status check_apart(const sdr_cloud *cloud, const sdr_support *support)
{
  for (int32_t i = 0; i < cloud->count; ++i)
    for (int64_t k = support->row[i]; k < support->row[i + 1]; ++k)
      if (distance_squared(cloud, i, support->column[k]) == 0.0)
        return sdr_fail(SDR_BAD_INPUT, "%s and point %d coincide: remove one of them",
                        sdr_point_named(cloud, i).text, (int)support->column[k]);
  return SDR_OK;
}

/* A cell about as large as what two points take, if they are spread evenly. */
static double even_spacing(const sdr_cloud *cloud)
{
  double measure = 1.0;
  int across = 0;
  for (int a = 0; a < cloud->components; ++a) {
    double low = cloud->x[a][0], high = low;
    for (int32_t i = 1; i < cloud->count; ++i) {
      low = fmin(low, cloud->x[a][i]);
      high = fmax(high, cloud->x[a][i]);
    }
    if (high > low) {
      measure *= high - low;
      ++across;
    }
  }
  return across ? pow(2.0 * measure / cloud->count, 1.0 / across) : 1.0;
}

/* Farthest of each searched support sets its h_i. */
static void set_radii(const search *s, sdr_support *made)
{
  for (int32_t i = 0; i < s->cloud->count; ++i) {
    if (keeps_old(s, i)) {
      made->radius[i] = s->old->radius[i];
      continue;
    }
    double farthest = 0.0;
    for (int64_t k = made->row[i]; k < made->row[i + 1]; ++k)
      farthest = fmax(farthest, distance_squared(s->cloud, i, made->column[k]));
    made->radius[i] = sqrt(farthest);
  }
}

/* Run a search whose cloud and way are set; `size` is the cells' (m). made->radius is allocated. */
static sdr_status run_search(search *s, double size, sdr_support *made)
{
  sdr_points view = {.count = s->cloud->count, .components = s->cloud->components};
  for (int a = 0; a < s->cloud->components; ++a) view.x[a] = (double *)s->cloud->x[a];
  sdr_cells cells = {0};
  SDR_TRY(sdr_cells_create(&view, size, &cells));
  s->cells = &cells;
  const size_t count = (size_t)s->cloud->count;
  const int blocks = (s->cloud->count + BLOCK - 1) / BLOCK;
  sdr_status status = SDR_RUN_FAILED;
  s->row = made->row = sdr_alloc(count + 1, sizeof *made->row);
  if (!made->row) goto cleanup;
  if (s->nearest > 0 || s->wanted) sdr_parallel_for(0, blocks, 1, limit_block, s);
  sdr_parallel_for(0, blocks, 1, search_block, s);
  for (size_t i = 0; i < count; ++i) made->row[i + 1] += made->row[i];
  s->column = made->column = sdr_alloc((size_t)made->row[count], sizeof *made->column);
  if (!made->column) goto cleanup;
  sdr_parallel_for(0, blocks, 1, search_block, s);
  status = check_apart(s->cloud, made);
cleanup:
  s->cells = NULL;
  sdr_cells_destroy(&cells);
  return status;
}

/* Build a support; radius (NULL: by count) gives the limits. */
static sdr_status build(search *s, const double *radius, double size, sdr_support *out)
{
  const size_t count = (size_t)s->cloud->count;
  sdr_support made = {.cloud = *s->cloud};
  sdr_status status = SDR_RUN_FAILED;
  made.radius = sdr_alloc(count, sizeof *made.radius);
  s->limit = sdr_alloc(count, sizeof *s->limit);
  if (!made.radius || !s->limit) goto cleanup;
  if (radius)
    for (size_t i = 0; i < count; ++i) {
      made.radius[i] = radius[i];
      s->limit[i] = radius[i] * radius[i] * (1.0 + tie);
    }
  status = run_search(s, size, &made);
  if (status != SDR_OK) goto cleanup;
  if (!radius) set_radii(s, &made);
  *out = made;
  made = (sdr_support){0};
cleanup:
  sdr_free(s->limit);
  sdr_support_destroy(&made);
  return status;
}

static sdr_status check_radii(const sdr_cloud *cloud, const double *radius, double *smallest)
{
  *smallest = radius[0];
  for (int32_t i = 0; i < cloud->count; ++i) {
    if (!(radius[i] > 0.0) || !isfinite(radius[i]))
      return sdr_fail(SDR_BAD_INPUT, "%s: the radius of a support must be positive, not %g",
                      sdr_point_named(cloud, i).text, radius[i]);
    *smallest = fmin(*smallest, radius[i]);
  }
  return SDR_OK;
}

sdr_status sdr_support_by_radius(const sdr_cloud *cloud, const double *radius, sdr_support *out)
{
  double smallest;
  SDR_TRY(check_cloud(cloud));
  SDR_TRY(check_radii(cloud, radius, &smallest));
  search s = {.cloud = cloud};
  return build(&s, radius, smallest, out);
}

sdr_status sdr_support_by_count(const sdr_cloud *cloud, int nearest, sdr_support *out)
{
  SDR_TRY(check_cloud(cloud));
  if (nearest < 1 || nearest > SDR_MOST_NEAREST)
    return sdr_fail(SDR_BAD_INPUT, "a support of %d nearest points: give 1 to %d", nearest,
                    SDR_MOST_NEAREST);
  if (nearest >= cloud->count)
    return sdr_fail(SDR_BAD_INPUT,
                    "supports of %d nearest points need at least %d points, and there are %d",
                    nearest, nearest + 1, (int)cloud->count);
  search s = {.cloud = cloud, .nearest = nearest};
  return build(&s, NULL, even_spacing(cloud), out);
}

sdr_status sdr_support_enlarge(sdr_support *support, const int32_t *wanted)
{
  const int32_t count = support->cloud.count;
  const int32_t most = count - 1 < SDR_MOST_NEAREST ? count - 1 : SDR_MOST_NEAREST;
  int32_t *clamped = sdr_alloc((size_t)count, sizeof *clamped);
  if (!clamped) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < count; ++i) clamped[i] = wanted[i] < most ? wanted[i] : most;
  search s = {.cloud = &support->cloud, .wanted = clamped, .old = support};
  sdr_support grown = {0};
  const sdr_status status = build(&s, NULL, even_spacing(&support->cloud), &grown);
  sdr_free(clamped);
  if (status != SDR_OK) return status;
  sdr_support_destroy(support);
  *support = grown;
  return SDR_OK;
}

sdr_status sdr_support_of_neighbourhood(const sdr_cloud *cloud, const double *horizon,
                                        const sdr_neighbourhood *near, sdr_support *out)
{
  double smallest;
  SDR_TRY(check_cloud(cloud));
  SDR_TRY(check_radii(cloud, horizon, &smallest));
  const size_t count = (size_t)cloud->count, entries = (size_t)near->row[count];
  sdr_support made = {.cloud = *cloud};
  sdr_status status = SDR_RUN_FAILED;
  made.row = sdr_alloc(count + 1, sizeof *made.row);
  made.column = sdr_alloc(entries, sizeof *made.column);
  made.radius = sdr_alloc(count, sizeof *made.radius);
  if (!made.row || !made.column || !made.radius) goto cleanup;
  memcpy(made.row, near->row, (count + 1) * sizeof *made.row);
  memcpy(made.column, near->column, entries * sizeof *made.column);
  memcpy(made.radius, horizon, count * sizeof *made.radius);
  status = check_apart(cloud, &made);
  if (status != SDR_OK) goto cleanup;
  *out = made;
  made = (sdr_support){0};
cleanup:
  sdr_support_destroy(&made);
  return status;
}

void sdr_support_destroy(sdr_support *support)
{
  sdr_free(support->row);
  sdr_free(support->column);
  sdr_free(support->radius);
  *support = (sdr_support){0};
}
