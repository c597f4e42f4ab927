/* Dijkstra's search with labels (time, distance) in lexicographic order: the time at which a point
   joins is the latest arrival on its way from the notch, made as early as can be; the distance is
   the shortest through points that joined before it. */
#include "output/crack_growth.h"

#include "base/memory.h"

#include <math.h>

typedef struct {
  double time, distance;
  int32_t site;
} label;

/* Labels in a heap, better ones upwards; outdated ones are passed over when they come up. */
typedef struct {
  const sdr_crack_sites *sites;
  double lag;
  label *heap;
  int32_t size, room;
  label *best;       /* of each site so far; time HUGE_VAL: none */
  int32_t *entry;    /* of each site that has joined; -1 */
  int32_t *from;     /* of each site: the nearest entry so far */
  double *nearest;   /* m, how near */
  label now;         /* that has just joined */
  int32_t now_entry; /* as that entry */
  sdr_status status;
} search;

static int is_before(const label *a, const label *b)
{
  if (a->time < b->time || b->time < a->time) return a->time < b->time;
  if (a->distance < b->distance || b->distance < a->distance) return a->distance < b->distance;
  return a->site < b->site;
}

static void push(search *s, label added)
{
  if (s->size == s->room) {
    const int32_t room = 2 * s->room + 256;
    label *grown = sdr_realloc(s->heap, (size_t)room, sizeof *grown);
    if (!grown) {
      s->status = SDR_RUN_FAILED;
      return;
    }
    s->heap = grown;
    s->room = room;
  }
  int32_t k = s->size++;
  while (k > 0 && is_before(&added, &s->heap[(k - 1) / 2])) {
    s->heap[k] = s->heap[(k - 1) / 2];
    k = (k - 1) / 2;
  }
  s->heap[k] = added;
}

static label pop(search *s)
{
  const label first = s->heap[0], moved = s->heap[--s->size];
  int32_t k = 0;
  for (int32_t child = 1; child < s->size; child = 2 * k + 1) {
    if (child + 1 < s->size && is_before(&s->heap[child + 1], &s->heap[child])) ++child;
    if (!is_before(&s->heap[child], &moved)) break;
    s->heap[k] = s->heap[child];
    k = child;
  }
  s->heap[k] = moved;
  return first;
}

static void offer(search *s, int32_t site, double time, double distance)
{
  const label offered = {time, distance, site};
  if (time - s->sites->arrival[site] > s->lag || !is_before(&offered, &s->best[site])) return;
  s->best[site] = offered;
  push(s, offered);
}

/* A site beside the one that has just joined. */
static void reach(void *context, int32_t site, double length)
{
  search *s = context;
  if (s->entry[site] >= 0 || length > s->sites->points->horizon[site]) return;
  const double way = s->now.distance + length;
  if (length < s->nearest[site] * (1.0 - 1e-9)) {
    s->nearest[site] = length;
    s->from[site] = s->now_entry;
  }
  offer(s, site, fmax(s->now.time, s->sites->arrival[site]), way);
}

static void start_at(void *context, int32_t site, double distance)
{
  search *s = context;
  if (distance <= 2.0 * s->sites->points->horizon[site])
    offer(s, site, s->sites->arrival[site], distance);
}

static double largest(const double *values, int32_t count)
{
  double most = 0.0;
  for (int32_t k = 0; k < count; ++k) most = fmax(most, values[k]);
  return most;
}

static void spread(search *s, const double start[3], sdr_crack_growth *out)
{
  const sdr_points *points = s->sites->points;
  const double horizon = largest(points->horizon, points->count);
  sdr_point_grid_within(s->sites->grid, start, 2.0 * horizon, start_at, s);
  while (s->size > 0 && s->status == SDR_OK) {
    double x[3] = {0.0};
    s->now = pop(s);
    const int32_t site = s->now.site;
    if (s->entry[site] >= 0) continue;
    s->now_entry = s->entry[site] = out->count;
    out->site[out->count] = site;
    out->before[out->count] = s->from[site];
    out->time[out->count] = s->now.time;
    out->distance[out->count++] = s->now.distance;
    for (int c = 0; c < points->components; ++c) x[c] = points->x[c][site];
    sdr_point_grid_within(s->sites->grid, x, horizon, reach, s);
  }
}

static int make_room(search *s, sdr_crack_growth *out)
{
  const size_t count = (size_t)s->sites->points->count;
  s->best = sdr_alloc(count, sizeof *s->best);
  s->entry = sdr_alloc(count, sizeof *s->entry);
  s->from = sdr_alloc(count, sizeof *s->from);
  s->nearest = sdr_alloc(count, sizeof *s->nearest);
  out->site = sdr_alloc(count, sizeof *out->site);
  out->before = sdr_alloc(count, sizeof *out->before);
  out->time = sdr_alloc(count, sizeof *out->time);
  out->distance = sdr_alloc(count, sizeof *out->distance);
  return s->best && s->entry && s->from && s->nearest && out->site && out->before && out->time &&
         out->distance;
}

sdr_status sdr_crack_grow(const sdr_crack_sites *sites, const double start[3], double lag,
                          sdr_crack_growth *out)
{
  search s = {.sites = sites, .lag = lag};
  sdr_crack_growth grown = {0};
  if (make_room(&s, &grown)) {
    for (int32_t i = 0; i < sites->points->count; ++i) {
      s.best[i] = (label){(double)HUGE_VAL, (double)HUGE_VAL, i};
      s.entry[i] = s.from[i] = -1;
      s.nearest[i] = (double)HUGE_VAL;
    }
    spread(&s, start, &grown);
  } else {
    s.status = SDR_RUN_FAILED;
  }
  sdr_free(s.heap);
  sdr_free(s.best);
  sdr_free(s.entry);
  sdr_free(s.from);
  sdr_free(s.nearest);
  if (s.status == SDR_OK)
    *out = grown;
  else
    sdr_crack_growth_clear(&grown);
  return s.status;
}

void sdr_crack_growth_clear(sdr_crack_growth *growth)
{
  sdr_free(growth->site);
  sdr_free(growth->before);
  sdr_free(growth->time);
  sdr_free(growth->distance);
  *growth = (sdr_crack_growth){0};
}
