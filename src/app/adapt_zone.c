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
  double neighbours;            /* m */
  int32_t low[3], extent[3];    /* of the coarsest cells */
  uint8_t *seed, *within, *far; /* a cell */
  int32_t *seeds;               /* cells with seeds */
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
  const double far = zone->neighbours + length_of(zone->how->ahead, horizon);
  find_extent(zone, points);
  zone->seed = sdr_alloc(zone->cells, 1);
  zone->within = sdr_alloc(zone->cells, 1);
  zone->far = sdr_alloc(zone->cells, 1);
  zone->seeds = sdr_alloc(3 * zone->cells, sizeof *zone->seeds);
  if (!zone->seed || !zone->within || !zone->far || !zone->seeds) return SDR_RUN_FAILED;
  SDR_TRY(make_ball(points->components, zone->neighbours / h, &zone->near_ball));
  return make_ball(points->components, far / h, &zone->far_ball);
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
  sdr_free(z->within);
  sdr_free(z->far);
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

static void spread(const sdr_adapt_zone *zone, size_t seeds, const ball *over, uint8_t *out)
{
  memset(out, 0, zone->cells);
  for (size_t s = 0; s < seeds; ++s)
    for (int k = 0; k < over->count; ++k) {
      int32_t cell[3];
      int inside = 1;
      for (int a = 0; a < 3; ++a) {
        cell[a] = zone->seeds[3 * s + (size_t)a] + over->step[3 * k + a];
        inside &= cell[a] >= zone->low[a] && cell[a] < zone->low[a] + zone->extent[a];
      }
      if (inside) out[index_of(zone, cell)] = 1;
    }
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
static int32_t pick(const sdr_adapt_zone *zone, const sdr_points *points, const uint8_t *chosen,
                    uint8_t *split)
{
  int32_t count = 0;
  for (int r = 0; r < points->row_count; ++r) {
    const sdr_row *row = &points->rows[r];
    for (int32_t k = 0; k < row->length; ++k) {
      int32_t cell[3];
      cell_of(points, row, k, cell);
      if (!chosen[index_of(zone, cell)] || !may_split(zone, points, row, row->first + k)) continue;
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
  spread(zone, seeds, &zone->near_ball, zone->within);
  if (pick(zone, points, zone->within, NULL) == 0) return 0;
  spread(zone, seeds, &zone->far_ball, zone->far);
  return pick(zone, points, zone->far, split);
}
