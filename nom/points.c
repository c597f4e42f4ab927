#include "nom/points.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
  STRIPES = 64,      /* as many as this, if the body is thick enough */
  SHORT_ROW = 32,    /* rows shorter than this are not worth a stripe axis of their own */
  SLAB_OF_ROWS = 64, /* points of a row within a slab when rows run along the stripe axis */
  LONG_ROW = 512     /* longer rows are cut, so that the rows within a horizon stay in cache */
};

size_t sdr_points_padded(const sdr_points *points)
{
  const size_t total = (size_t)points->count + (size_t)points->ghosts;
  return (total + 31) / 16 * 16;
}

sdr_status sdr_points_create(int32_t count, int components, int lattice, sdr_points **out)
{
  sdr_points *points = sdr_alloc(1, sizeof *points);
  if (!points) return SDR_RUN_FAILED;
  points->count = count;
  points->components = components;
  const size_t padded = sdr_points_padded(points);
  int failed = 0;
  for (int a = 0; a < components; ++a)
    failed |= !(points->x[a] = sdr_alloc(padded, sizeof(double)));
  failed |= !(points->volume = sdr_alloc(padded, sizeof(double)));
  failed |= !(points->spacing = sdr_alloc(padded, sizeof(double)));
  failed |= !(points->horizon = sdr_alloc(padded, sizeof(double)));
  failed |= !(points->material = sdr_alloc(padded, sizeof(uint8_t)));
  if (lattice) failed |= !(points->cell = sdr_alloc(3 * padded, sizeof(int32_t)));
  for (int a = 0; a < 3; ++a) points->axes[a][a] = 1.0;
  if (failed) {
    sdr_points_destroy(&points);
    return SDR_RUN_FAILED;
  }
  *out = points;
  return SDR_OK;
}

void sdr_points_destroy(sdr_points **points)
{
  sdr_points *p = *points;
  if (!p) return;
  for (int a = 0; a < 3; ++a) sdr_free(p->x[a]);
  sdr_free(p->volume);
  sdr_free(p->spacing);
  sdr_free(p->horizon);
  sdr_free(p->material);
  sdr_free(p->level);
  sdr_free(p->layer);
  sdr_free(p->generated);
  sdr_free(p->cell);
  sdr_free(p->rows);
  sdr_free(p->stripe_first);
  sdr_free(p);
  *points = NULL;
}

/* ---- storage order --------------------------------------------------------------------------- */

/* `part` first: on lattices the slab and in it the level. */
typedef struct {
  uint64_t key;
  uint32_t part;
  int32_t point;
} keyed;

static int by_key(const void *a, const void *b)
{
  const keyed *left = a, *right = b;
  if (left->part != right->part) return left->part < right->part ? -1 : 1;
  if (left->key != right->key) return left->key < right->key ? -1 : 1;
  return left->point < right->point ? -1 : left->point > right->point;
}

/* How lattices are laid out: slabs of `thickness` cells of level 0 across stripe_axis, rows along
   row_axis. low and extent are in cells of level 0. */
typedef struct {
  int stripe_axis, row_axis, other_axis, levels;
  int32_t low[3], extent[3], thickness, slabs;
} layout;

static int level_of(const sdr_points *points, int32_t i)
{
  return points->level ? points->level[i] : 0;
}

/* The cell of level 0 that a coordinate at `level` lies in. */
static int32_t ancestor(int32_t c, int level)
{
  const int64_t size = (int64_t)1 << level, from = c;
  return (int32_t)((from >= 0 ? from : from - size + 1) / size);
}

static void lattice_extent(const sdr_points *points, layout *how)
{
  int32_t high[3] = {INT32_MIN, INT32_MIN, INT32_MIN};
  for (int a = 0; a < 3; ++a) how->low[a] = INT32_MAX;
  for (int32_t i = 0; i < points->count; ++i)
    for (int a = 0; a < 3; ++a) {
      const int level = a < points->components ? level_of(points, i) : 0;
      const int32_t c = ancestor(points->cell[3 * (size_t)i + (size_t)a], level);
      if (c < how->low[a]) how->low[a] = c;
      if (c > high[a]) high[a] = c;
    }
  for (int a = 0; a < 3; ++a) how->extent[a] = high[a] - how->low[a] + 1;
}

/* Cells of level 0 that a bond between points of one level spans at most; sets how->levels. */
static int32_t longest_reach(const sdr_points *points, layout *how)
{
  int32_t longest = 0;
  double known = 0.0; /* the horizon last looked at, and its level */
  int known_level = -1;
  for (int32_t i = 0; i < points->count; ++i) {
    const int level = level_of(points, i);
    if (level == known_level && points->horizon[i] <= known) continue;
    known = points->horizon[i];
    known_level = level;
    const double size = ldexp(points->lattice_spacing, -level);
    const int32_t steps = (int32_t)floor(known / size * (1.0 + 1e-9));
    const int32_t reach = ancestor(steps + (1 << level) - 1, level);
    if (reach > longest) longest = reach;
    if (level >= how->levels) how->levels = level + 1;
  }
  return longest;
}

static layout choose_layout(const sdr_points *points)
{
  layout how = {0};
  lattice_extent(points, &how);
  const int32_t reach = longest_reach(points, &how);

  int stripe = 0;
  for (int a = 1; a < points->components; ++a)
    if (how.extent[a] >= how.extent[stripe]) stripe = a;
  int row = stripe == 0 ? points->components - 1 : 0;
  for (int a = 0; a < points->components; ++a)
    if (a != stripe && how.extent[a] > how.extent[row]) row = a;
  if (how.extent[row] < SHORT_ROW) row = stripe;
  how.stripe_axis = stripe;
  how.row_axis = row;
  how.other_axis = row == stripe ? (stripe + 1) % 3 : 3 - stripe - row;

  how.thickness = (how.extent[stripe] + STRIPES - 1) / STRIPES;
  if (row == stripe && how.thickness < SLAB_OF_ROWS) how.thickness = SLAB_OF_ROWS;
  if (how.thickness < reach) how.thickness = reach;
  if (how.thickness < 1) how.thickness = 1;
  how.slabs = (how.extent[stripe] + how.thickness - 1) / how.thickness;
  return how;
}

static int32_t slab_of(const layout *how, const int32_t *cell, int level)
{
  const int s = how->stripe_axis;
  return (ancestor(cell[s], level) - how->low[s]) / how->thickness;
}

/* Order: slab, level, then the plane across the stripe axis, then the other axis, then along the
   row. */
static keyed lattice_key(const layout *how, const sdr_points *points, int32_t i)
{
  const int32_t *cell = points->cell + 3 * (size_t)i;
  const int level = level_of(points, i);
  uint64_t c[3], n[3];
  for (int a = 0; a < 3; ++a) {
    const int shift = a < points->components ? level : 0;
    c[a] = (uint64_t)(cell[a] - how->low[a] * ((int64_t)1 << shift));
    n[a] = (uint64_t)how->extent[a] << shift;
  }
  const int s = how->stripe_axis, r = how->row_axis, o = how->other_axis;
  const int across = r != s ? s : 3 - r - o; /* the third axis */
  return (keyed){.key = (c[across] * n[o] + c[o]) * n[r] + c[r],
                 .part = (uint32_t)(slab_of(how, cell, level) * how->levels + level),
                 .point = i};
}

/* Spread the low 21 bits of v to every third bit. */
static uint64_t every_third_bit(uint64_t v)
{
  v &= 0x1fffff;
  v = (v | v << 32) & 0x1f00000000ffffULL;
  v = (v | v << 16) & 0x1f0000ff0000ffULL;
  v = (v | v << 8) & 0x100f00f00f00f00fULL;
  v = (v | v << 4) & 0x10c30c30c30c30c3ULL;
  return (v | v << 2) & 0x1249249249249249ULL;
}

/* Z-order over a grid of 2^21 cells a side. */
static void curve_keys(const sdr_points *points, keyed *order)
{
  double low[3], size = 0.0;
  for (int a = 0; a < points->components; ++a) {
    double high = low[a] = points->x[a][0];
    for (int32_t i = 1; i < points->count; ++i) {
      low[a] = fmin(low[a], points->x[a][i]);
      high = fmax(high, points->x[a][i]);
    }
    size = fmax(size, high - low[a]);
  }
  const double scale = size > 0.0 ? 2097151.0 / size : 0.0;
  for (int32_t i = 0; i < points->count; ++i) {
    uint64_t key = 0;
    for (int a = 0; a < points->components; ++a)
      key |= every_third_bit((uint64_t)((points->x[a][i] - low[a]) * scale)) << a;
    order[i] = (keyed){.key = key, .point = i};
  }
}

static int in_order(const keyed *order, int32_t count)
{
  for (int32_t i = 1; i < count; ++i)
    if (by_key(&order[i - 1], &order[i]) > 0) return 0;
  return 1;
}

static void permute(void *array, size_t size, const keyed *order, int32_t count, void *scratch)
{
  if (!array) return;
  char *from = array, *to = scratch;
  for (int32_t i = 0; i < count; ++i)
    memcpy(to + (size_t)i * size, from + (size_t)order[i].point * size, size);
  memcpy(from, to, (size_t)count * size);
}

static sdr_status sort_points(sdr_points *points, keyed *order)
{
  if (in_order(order, points->count)) return SDR_OK;
  qsort(order, (size_t)points->count, sizeof *order, by_key);
  void *scratch = sdr_alloc((size_t)points->count, 3 * sizeof(double));
  points->generated = sdr_alloc(sdr_points_padded(points), sizeof(int32_t));
  if (!scratch || !points->generated) {
    sdr_free(scratch);
    return SDR_RUN_FAILED;
  }
  for (int a = 0; a < 3; ++a) permute(points->x[a], sizeof(double), order, points->count, scratch);
  permute(points->volume, sizeof(double), order, points->count, scratch);
  permute(points->spacing, sizeof(double), order, points->count, scratch);
  permute(points->horizon, sizeof(double), order, points->count, scratch);
  permute(points->material, sizeof(uint8_t), order, points->count, scratch);
  permute(points->level, sizeof(uint8_t), order, points->count, scratch);
  permute(points->layer, sizeof(uint8_t), order, points->count, scratch);
  permute(points->cell, 3 * sizeof(int32_t), order, points->count, scratch);
  for (int32_t i = 0; i < points->count; ++i) points->generated[i] = order[i].point;
  sdr_free(scratch);
  return SDR_OK;
}

/* ---- rows and stripes ------------------------------------------------------------------------ */

/* 1 if point i goes on the row that point i - 1 is on and that already holds `length` points. */
static int same_row(const sdr_points *points, const layout *how, int32_t i, int32_t length)
{
  const int32_t *before = points->cell + 3 * (size_t)(i - 1), *here = before + 3;
  const int level = level_of(points, i);
  if (length >= LONG_ROW || level_of(points, i - 1) != level) return 0;
  if (points->horizon[i] != points->horizon[i - 1]) return 0;
  for (int a = 0; a < 3; ++a)
    if (here[a] - before[a] != (a == how->row_axis)) return 0;
  return slab_of(how, here, level) == slab_of(how, before, level);
}

static int make_rows(const sdr_points *points, const layout *how, sdr_row *rows)
{
  int count = 0;
  int32_t length = 0;
  for (int32_t i = 0; i < points->count; ++i) {
    if (i > 0 && same_row(points, how, i, length)) {
      ++length;
      if (rows) ++rows[count - 1].length;
      continue;
    }
    length = 1;
    if (rows) {
      rows[count].first = i;
      rows[count].length = 1;
      rows[count].level = level_of(points, i);
      memcpy(rows[count].cell, points->cell + 3 * (size_t)i, sizeof rows[count].cell);
    }
    ++count;
  }
  return count;
}

static sdr_status lattice_stripes(sdr_points *points, const layout *how)
{
  points->row_axis = how->row_axis;
  points->row_count = make_rows(points, how, NULL);
  points->rows = sdr_alloc((size_t)points->row_count, sizeof *points->rows);
  points->stripe_first = sdr_alloc((size_t)how->slabs + 1, sizeof *points->stripe_first);
  if (!points->rows || !points->stripe_first) return SDR_RUN_FAILED;
  make_rows(points, how, points->rows);
  points->stripe_count = how->slabs;
  int32_t i = 0;
  for (int32_t s = 0; s < how->slabs; ++s) {
    points->stripe_first[s] = i;
    while (i < points->count &&
           slab_of(how, points->cell + 3 * (size_t)i, level_of(points, i)) == s)
      ++i;
  }
  points->stripe_first[how->slabs] = points->count;
  return SDR_OK;
}

/* Without a lattice no run joins stripes: equal shares, each a multiple of 8 points. */
static sdr_status even_stripes(sdr_points *points)
{
  const int32_t share = ((points->count + STRIPES - 1) / STRIPES + 7) / 8 * 8;
  points->stripe_count = (points->count + share - 1) / share;
  points->stripe_first = sdr_alloc((size_t)points->stripe_count + 1, sizeof *points->stripe_first);
  if (!points->stripe_first) return SDR_RUN_FAILED;
  for (int s = 0; s < points->stripe_count; ++s) points->stripe_first[s] = s * share;
  points->stripe_first[points->stripe_count] = points->count;
  return SDR_OK;
}

sdr_status sdr_points_arrange(sdr_points *points)
{
  keyed *order = sdr_alloc((size_t)points->count, sizeof *order);
  if (!order) return SDR_RUN_FAILED;
  layout how = {0};
  if (points->cell) {
    how = choose_layout(points);
    for (int32_t i = 0; i < points->count; ++i) order[i] = lattice_key(&how, points, i);
  } else {
    curve_keys(points, order);
  }
  sdr_status status = sort_points(points, order);
  sdr_free(order);
  if (status != SDR_OK) return status;
  status = points->cell ? lattice_stripes(points, &how) : even_stripes(points);
  sdr_free(points->cell);
  points->cell = NULL;
  return status;
}

int32_t sdr_points_nearest(const sdr_points *points, const double at[3])
{
  int32_t best = 0, best_rank = 0;
  double best_distance = INFINITY;
  for (int32_t i = 0; i < points->count; ++i) {
    double distance = 0.0;
    if (!sdr_in_body(points, i)) continue;
    for (int a = 0; a < points->components; ++a) {
      const double d = points->x[a][i] - at[a];
      distance += d * d;
    }
    const double tie = 1e-9 * points->spacing[i] * points->spacing[i];
    const int32_t rank = points->generated ? points->generated[i] : i;
    if (distance < best_distance - tie || (distance < best_distance + tie && rank < best_rank)) {
      best = i;
      best_rank = rank;
      best_distance = distance;
    }
  }
  return best;
}
