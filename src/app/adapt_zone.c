#include "app/adapt_zone.h"

#include "base/memory.h"
#include "geometry/place.h"

#include <math.h>
#include <string.h>

/* Offsets between cells no farther apart than a distance. */
typedef struct {
  int count;
  int32_t *step; /* 3 an offset */
} ball;

struct sdr_adapt_zone {
  const sdr_scene *scene;
  const sdr_adapt_scene *how;
  double neighbours;         /* m */
  double ahead, far;         /* coarsest cells; far: with neighbours */
  int32_t low[3], extent[3]; /* of the coarsest cells */
  uint8_t *seed, *chosen;    /* a cell */
  int32_t *seeds;            /* cells with seeds */
  size_t cells;
  ball near_ball, far_ball;
};

static double length_of(sdr_length length, double horizon)
{
  return length.relative ? length.value * horizon : length.value;
}

/* The coarsest cell of a place on a row. */
static void cell_of(const sdr_points *points, const sdr_row *row, int32_t k, int32_t cell[3])
{
  memcpy(cell, row->cell, 3 * sizeof *cell);
  cell[points->row_axis] += k;
  for (int a = 0; a < 3; ++a) cell[a] >>= row->level; /* rounds down below 0 too */
}

static size_t index_of(const sdr_adapt_zone *zone, const int32_t cell[3])
{
  size_t index = 0;
  for (int a = 2; a >= 0; --a)
    index = index * (size_t)zone->extent[a] + (size_t)(cell[a] - zone->low[a]);
  return index;
}

static void find_extent(sdr_adapt_zone *zone, const sdr_points *points)
{
  int32_t high[3] = {INT32_MIN, INT32_MIN, INT32_MIN};
  for (int a = 0; a < 3; ++a) zone->low[a] = INT32_MAX;
  for (int r = 0; r < points->row_count; ++r)
    for (int end = 0; end < 2; ++end) {
      int32_t cell[3];
      cell_of(points, &points->rows[r], end * (points->rows[r].length - 1), cell);
      for (int a = 0; a < 3; ++a) {
        if (cell[a] < zone->low[a]) zone->low[a] = cell[a];
        if (cell[a] > high[a]) high[a] = cell[a];
      }
    }
  zone->cells = 1;
  for (int a = 0; a < 3; ++a) {
    zone->extent[a] = high[a] - zone->low[a] + 1;
    zone->cells *= (size_t)zone->extent[a];
  }
}

static sdr_status make_ball(int components, double cells, ball *out)
{
  const int32_t reach = (int32_t)floor(cells * (1.0 + 1e-9));
  const int32_t r[3] = {reach, components > 1 ? reach : 0, components > 2 ? reach : 0};
  const size_t most = (size_t)(2 * r[0] + 1) * (size_t)(2 * r[1] + 1) * (size_t)(2 * r[2] + 1);
  out->step = sdr_alloc(3 * most, sizeof *out->step);
  if (!out->step) return SDR_RUN_FAILED;
  for (int32_t z = -r[2]; z <= r[2]; ++z)
    for (int32_t y = -r[1]; y <= r[1]; ++y)
      for (int32_t x = -r[0]; x <= r[0]; ++x) {
        if ((double)x * x + (double)y * y + (double)z * z > cells * cells * (1.0 + 1e-9)) continue;
        int32_t *step = out->step + 3 * out->count++;
        step[0] = x;
        step[1] = y;
        step[2] = z;
      }
  return SDR_OK;
}

static sdr_status fill(sdr_adapt_zone *zone, const sdr_points *points)
{
  double horizon = 0.0; /* of the coarsest points */
  for (int32_t i = 0; i < points->count; ++i) horizon = fmax(horizon, points->horizon[i]);
  zone->neighbours = length_of(zone->how->neighbours, horizon);
  const double h = points->lattice_spacing;
  zone->ahead = length_of(zone->how->ahead, horizon) / h;
  zone->far = zone->neighbours / h + zone->ahead;
  find_extent(zone, points);
  zone->seed = sdr_alloc(zone->cells, 1);
  zone->chosen = sdr_alloc(zone->cells, 1);
  zone->seeds = sdr_alloc(3 * zone->cells, sizeof *zone->seeds);
  if (!zone->seed || !zone->chosen || !zone->seeds) return SDR_RUN_FAILED;
  SDR_TRY(make_ball(points->components, zone->neighbours / h, &zone->near_ball));
  return make_ball(points->components, zone->far, &zone->far_ball);
}

sdr_status sdr_adapt_zone_create(const sdr_scene *scene, const sdr_points *points,
                                 sdr_adapt_zone **out)
{
  sdr_adapt_zone *zone = sdr_alloc(1, sizeof *zone);
  if (!zone) return SDR_RUN_FAILED;
  zone->scene = scene;
  zone->how = scene->points.adapt;
  const sdr_status status = fill(zone, points);
  if (status == SDR_OK)
    *out = zone;
  else
    sdr_adapt_zone_destroy(&zone);
  return status;
}

void sdr_adapt_zone_destroy(sdr_adapt_zone **zone)
{
  sdr_adapt_zone *z = *zone;
  if (!z) return;
  sdr_free(z->seed);
  sdr_free(z->chosen);
  sdr_free(z->seeds);
  sdr_free(z->near_ball.step);
  sdr_free(z->far_ball.step);
  sdr_free(z);
  *zone = NULL;
}

double sdr_adapt_zone_reach(const sdr_adapt_zone *zone)
{
  return zone->neighbours;
}

/* Cells with a point over a threshold; returns how many. */
static size_t find_seeds(sdr_adapt_zone *zone, const sdr_points *points, const double *energy,
                         const double *damage)
{
  size_t count = 0;
  memset(zone->seed, 0, zone->cells);
  for (int r = 0; r < points->row_count; ++r) {
    const sdr_row *row = &points->rows[r];
    for (int32_t k = 0; k < row->length; ++k) {
      const int32_t i = row->first + k;
      if (!(energy[i] > zone->how->energy) && !(damage[i] > zone->how->damage)) continue;
      int32_t *cell = zone->seeds + 3 * count;
      cell_of(points, row, k, cell);
      uint8_t *seed = &zone->seed[index_of(zone, cell)];
      count += !*seed;
      *seed = 1;
    }
  }
  return count;
}

/* The index of a cell beside another; 0: it lies outside. */
static int beside(const sdr_adapt_zone *zone, const int32_t cell[3], const int32_t step[3],
                  size_t *index)
{
  int32_t at[3];
  for (int a = 0; a < 3; ++a) {
    at[a] = cell[a] + step[a];
    if (at[a] < zone->low[a] || at[a] >= zone->low[a] + zone->extent[a]) return 0;
  }
  *index = index_of(zone, at);
  return 1;
}

static void mark_ball(sdr_adapt_zone *zone, const int32_t cell[3], const ball *over)
{
  size_t index;
  for (int k = 0; k < over->count; ++k)
    if (beside(zone, cell, over->step + 3 * k, &index)) zone->chosen[index] = 1;
}

static void spread(sdr_adapt_zone *zone, size_t seeds, const ball *over)
{
  memset(zone->chosen, 0, zone->cells);
  for (size_t s = 0; s < seeds; ++s) mark_ball(zone, zone->seeds + 3 * s, over);
}

/* Where damage goes from a seed: away from the mean place of those around it. Along a crack that is
   the seed itself; at a tip, with `far` of the crack behind it, it is nearly half as far off.
   Returns 0 and no direction below sqrt(1/8) of it. */
static int heads_on(const sdr_adapt_zone *zone, const int32_t cell[3], double way[3])
{
  int64_t sum[3] = {0}, count = 0;
  double square = 0.0;
  size_t index;
  for (int k = 0; k < zone->far_ball.count; ++k) {
    const int32_t *step = zone->far_ball.step + 3 * k;
    if (!beside(zone, cell, step, &index) || !zone->seed[index]) continue;
    for (int a = 0; a < 3; ++a) sum[a] += step[a];
    ++count;
  }
  for (int a = 0; a < 3; ++a) {
    way[a] = -(double)sum[a] / (double)count; /* the seed is one */
    square += way[a] * way[a];
  }
  if (!(8.0 * square > zone->far * zone->far)) return 0;
  for (int a = 0; a < 3; ++a) way[a] /= sqrt(square);
  return 1;
}

/* Choose what is within `neighbours` of the ways on from tips; in all directions, and farther,
   where there is none. */
static void spread_ahead(sdr_adapt_zone *zone, size_t seeds)
{
  int tips = 0;
  double way[3];
  for (size_t s = 0; s < seeds; ++s) {
    const int32_t *cell = zone->seeds + 3 * s;
    if (!heads_on(zone, cell, way)) continue;
    tips = 1;
    for (double on = fmin(1.0, zone->ahead); on <= zone->ahead && on > 0.0; on += 1.0) {
      int32_t at[3];
      for (int a = 0; a < 3; ++a) at[a] = cell[a] + (int32_t)lround(on * way[a]);
      mark_ball(zone, at, &zone->near_ball);
    }
  }
  if (!tips) spread(zone, seeds, &zone->far_ball);
}

static int may_split(const sdr_adapt_zone *zone, const sdr_points *points, const sdr_row *row,
                     int32_t i)
{
  double x[3] = {0.0};
  if (row->level >= zone->how->levels) return 0;
  if (zone->how->anywhere) return 1;
  for (int a = 0; a < points->components; ++a) x[a] = points->x[a][i];
  return sdr_place_holds(zone->scene, &zone->how->where, x, points->spacing[i], points->spacing[i]);
}

/* Points that may split in chosen cells: count, and mark if `split`. */
static int32_t pick(const sdr_adapt_zone *zone, const sdr_points *points, uint8_t *split)
{
  int32_t count = 0;
  for (int r = 0; r < points->row_count; ++r) {
    const sdr_row *row = &points->rows[r];
    for (int32_t k = 0; k < row->length; ++k) {
      int32_t cell[3];
      cell_of(points, row, k, cell);
      if (!zone->chosen[index_of(zone, cell)] || !may_split(zone, points, row, row->first + k))
        continue;
      ++count;
      if (split) split[row->first + k] = 1;
    }
  }
  return count;
}

int32_t sdr_adapt_zone_choose(sdr_adapt_zone *zone, const sdr_points *points, const double *energy,
                              const double *damage, uint8_t *split)
{
  memset(split, 0, (size_t)points->count);
  const size_t seeds = find_seeds(zone, points, energy, damage);
  if (seeds == 0) return 0;
  spread(zone, seeds, &zone->near_ball);
  if (pick(zone, points, NULL) == 0) return 0;
  spread_ahead(zone, seeds);
  return pick(zone, points, split);
}
