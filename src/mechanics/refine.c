#include "mechanics/refine.h"

#include "base/memory.h"
#include "geometry/point_values.h"

#include <string.h>

void sdr_point_map_clear(sdr_point_map *map)
{
  sdr_free(map->parent);
  sdr_free(map->first_child);
  sdr_free(map->child);
  *map = (sdr_point_map){0};
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* The cell of each point, from the rows they stand in: 3 a point; NULL: out of memory. */
static int32_t *cells_of(const sdr_points *points)
{
  int32_t *cell = sdr_alloc(3 * sdr_points_padded(points), sizeof *cell);
  for (int r = 0; cell && r < points->row_count; ++r) {
    const sdr_row *row = &points->rows[r];
    for (int32_t k = 0; k < row->length; ++k) {
      int32_t *at = cell + 3 * (size_t)(row->first + k);
      memcpy(at, row->cell, sizeof row->cell);
      at[points->row_axis] += k;
    }
  }
  return cell;
}

/* ---- points ---------------------------------------------------------------------------------- */

typedef struct {
  const sdr_points *before;
  const uint8_t *split;
  int32_t *cell;   /* of the points before */
  int32_t *stored; /* point before by its place in the order of generation */
  int32_t *source; /* point before by the new order of generation */
  sdr_points *now;
} splitting;

static void copy_point(const splitting *s, int32_t from, int32_t to)
{
  const sdr_points *before = s->before;
  sdr_points *now = s->now;
  for (int a = 0; a < before->components; ++a) now->x[a][to] = before->x[a][from];
  now->volume[to] = before->volume[from];
  now->spacing[to] = before->spacing[from];
  now->material[to] = before->material[from];
  now->level[to] = before->level ? before->level[from] : 0;
  memcpy(now->cell + 3 * (size_t)to, s->cell + 3 * (size_t)from, 3 * sizeof(int32_t));
  s->source[to] = from;
}

static void make_child(const splitting *s, int32_t from, int child, int32_t to)
{
  sdr_points *now = s->now;
  const int components = now->components;
  const double h = s->before->spacing[from];
  copy_point(s, from, to);
  now->volume[to] /= 1 << components;
  now->spacing[to] = 0.5 * h;
  ++now->level[to];
  for (int a = 0; a < components; ++a) {
    const double step = child >> a & 1 ? 0.25 * h : -0.25 * h;
    for (int c = 0; c < components; ++c) now->x[c][to] += step * now->axes[a][c];
    int32_t *cell = &now->cell[3 * (size_t)to + (size_t)a];
    *cell = 2 * *cell + (child >> a & 1);
  }
}

static void make_points(const splitting *s)
{
  const sdr_points *before = s->before;
  int32_t to = 0;
  for (int32_t g = 0; g < before->count; ++g) {
    const int32_t i = s->stored[g];
    if (!s->split[i]) copy_point(s, i, to++);
    for (int child = 0; s->split[i] && child < 1 << before->components; ++child)
      make_child(s, i, child, to++);
  }
}

static sdr_status create_points(splitting *s)
{
  const sdr_points *before = s->before;
  int64_t count = before->count;
  for (int32_t i = 0; i < before->count; ++i)
    if (s->split[i]) count += (1 << before->components) - 1;
  if (count > INT32_MAX - 8)
    return sdr_fail(SDR_RUN_FAILED,
                    "refinement would make %lld points; at most %d are possible, so "
                    "raise points.adapt.damage or energy",
                    (long long)count, INT32_MAX - 8);
  SDR_TRY(sdr_points_create((int32_t)count, before->components, 1, &s->now));
  s->now->level = sdr_alloc(sdr_points_padded(s->now), 1);
  s->cell = cells_of(before);
  s->stored = sdr_alloc((size_t)before->count, sizeof *s->stored);
  s->source = sdr_alloc((size_t)count, sizeof *s->source);
  if (!s->now->level || !s->cell || !s->stored || !s->source) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < before->count; ++i)
    s->stored[before->generated ? before->generated[i] : i] = i;
  s->now->lattice_spacing = before->lattice_spacing;
  memcpy(s->now->axes, before->axes, sizeof before->axes);
  make_points(s);
  return SDR_OK;
}

/* ---- maps ------------------------------------------------------------------------------------ */

static sdr_status alloc_map(int32_t before, int32_t now, sdr_point_map *map)
{
  *map = (sdr_point_map){.before = before, .now = now};
  map->parent = sdr_alloc((size_t)now, sizeof *map->parent);
  map->first_child = sdr_alloc((size_t)before + 1, sizeof *map->first_child);
  map->child = sdr_alloc((size_t)now, sizeof *map->child);
  return map->parent && map->first_child && map->child ? SDR_OK : SDR_RUN_FAILED;
}

/* Children from parents; they are met in the order given, NULL: as stored. */
static sdr_status list_children(sdr_point_map *map, const int32_t *order)
{
  int32_t *cursor = sdr_alloc((size_t)map->before, sizeof *cursor);
  if (!cursor) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < map->now; ++i) ++map->first_child[map->parent[i] + 1];
  for (int32_t p = 0; p < map->before; ++p) {
    map->first_child[p + 1] += map->first_child[p];
    cursor[p] = map->first_child[p];
  }
  for (int32_t k = 0; k < map->now; ++k) {
    const int32_t i = order ? order[k] : k;
    map->child[cursor[map->parent[i]]++] = i;
  }
  sdr_free(cursor);
  return SDR_OK;
}

static sdr_status make_map(const splitting *s, sdr_point_map *map)
{
  const sdr_points *now = s->now;
  int32_t *order = sdr_alloc((size_t)now->count, sizeof *order); /* stored by generation */
  if (!order) return SDR_RUN_FAILED;
  sdr_status status = alloc_map(s->before->count, now->count, map);
  for (int32_t i = 0; status == SDR_OK && i < now->count; ++i) {
    const int32_t g = now->generated ? now->generated[i] : i;
    map->parent[i] = s->source[g];
    order[g] = i;
  }
  if (status == SDR_OK) status = list_children(map, order);
  sdr_free(order);
  return status;
}

sdr_status sdr_point_map_join(const sdr_point_map *first, const sdr_point_map *second,
                              sdr_point_map *out)
{
  sdr_point_map map;
  sdr_status status = alloc_map(first->before, second->now, &map);
  int32_t *order = sdr_alloc((size_t)second->now, sizeof *order);
  if (!order) status = SDR_RUN_FAILED;
  if (status == SDR_OK) {
    int32_t next = 0; /* children stand in the order of generation within each */
    for (int32_t k = 0; k < first->now; ++k) {
      const int32_t p = first->child[k];
      for (int32_t c = second->first_child[p]; c < second->first_child[p + 1]; ++c) {
        order[next++] = second->child[c];
        map.parent[second->child[c]] = first->parent[p];
      }
    }
    status = list_children(&map, order);
  }
  sdr_free(order);
  if (status == SDR_OK)
    *out = map;
  else
    sdr_point_map_clear(&map);
  return status;
}

sdr_status sdr_split_points(const sdr_scene *scene, const sdr_points *before, const uint8_t *split,
                            sdr_points **out, sdr_point_map *map)
{
  splitting s = {.before = before, .split = split};
  sdr_point_map made = {0};
  sdr_status status = create_points(&s);
  if (status == SDR_OK) status = sdr_points_set_horizon(scene, s.now);
  if (status == SDR_OK) status = sdr_points_arrange(s.now);
  if (status == SDR_OK) status = make_map(&s, &made);
  sdr_free(s.cell);
  sdr_free(s.stored);
  sdr_free(s.source);
  if (status != SDR_OK) {
    sdr_points_destroy(&s.now);
    sdr_point_map_clear(&made);
    return status;
  }
  *out = s.now;
  *map = made;
  return SDR_OK;
}
