/* Pieces are the components of the graph of sound pairs, found by union-find.

   Through-cracks of a ring, as one sees them in a picture of its damage: clusters of damaged points
   (joined by bonds) that reach from the inner to the outer surface. A branched crack is one, and so
   is one whose faces still hold together by a last ligament that has begun to tear.

   Sectors of a ring: what has come apart for good. A crack that branches, or leaves splinters
   behind, makes pieces that reach one surface only or none; they are debris, not sectors. So a
   SECTOR is a piece with a point within two spacings of the ring's smallest radius and one within
   two spacings of its largest. Between neighbouring sectors lies one cut, however much debris is in
   it: two sectors or more: as many cuts; one sector: 1 if it does not close around the centre, 0 if
   it does; none (the ring came apart along circles): 0. A piece closes around the centre if and
   only if it holds a cycle of pairs along which the angle turns by a full circle. The union-find
   carries for each point its angle relative to its root, summed along sound pairs (each turns by
   less than half a circle); a pair inside one tree closes a cycle, and the turn of that cycle is a
   multiple of 2 pi that the carried angles give. Cycles of a graph are sums of these, so no such
   pair with a turn means no cycle with one. */
#include "output/fragments.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* Trees over points. angle[i]: that of point i minus that of its parent; NULL if not asked for.
   closed[root]: the tree holds a cycle around the centre. */
typedef struct {
  const sdr_points *points; /* those of fictitious layers belong to no piece */
  int32_t *parent, *size;
  double *angle;
  const double *polar; /* angle of each point about the centre */
  unsigned char *closed;
  double threshold;
  const double *damage; /* of points; NULL: pairs below the threshold join, else points above it */
} forest;

/* Root of i; *turned becomes the angle of i minus that of its root. Then i and all above it hang
   at the root. */
static int32_t find(forest *trees, int32_t i, double *turned)
{
  double sum = 0.0;
  int32_t root = i;
  while (trees->parent[root] != root) {
    if (trees->angle) sum += trees->angle[root];
    root = trees->parent[root];
  }
  *turned = sum;
  while (trees->parent[i] != root && i != root) {
    const int32_t above = trees->parent[i];
    trees->parent[i] = root;
    if (trees->angle) {
      const double step = trees->angle[i];
      trees->angle[i] = sum;
      sum -= step;
    }
    i = above;
  }
  return root;
}

static double polar_step(const double *polar, int32_t i, int32_t j)
{
  return remainder(polar[j] - polar[i], 2.0 * M_PI);
}

static void join_pair(void *context, int32_t i, int32_t j, double damage)
{
  forest *trees = context;
  double turn_i, turn_j;
  const double *at = trees->damage;
  if (!sdr_in_body(trees->points, i) || !sdr_in_body(trees->points, j)) return;
  if (at ? !(at[i] >= trees->threshold && at[j] >= trees->threshold) : !(damage < trees->threshold))
    return;
  int32_t a = find(trees, i, &turn_i), b = find(trees, j, &turn_j);
  /* Angle of root b minus that of root a, by way of this pair. */
  double between = trees->angle ? turn_i + polar_step(trees->polar, i, j) - turn_j : 0.0;
  if (a == b) {
    if (trees->angle && fabs(between) > M_PI) trees->closed[a] = 1;
    return;
  }
  if (trees->size[a] < trees->size[b]) {
    const int32_t kept = a;
    a = b;
    b = kept;
    between = -between;
  }
  trees->parent[b] = a;
  trees->size[a] += trees->size[b];
  if (!trees->angle) return;
  trees->angle[b] = between;
  trees->closed[a] |= trees->closed[b];
}

static void forest_free(forest *trees)
{
  sdr_free(trees->parent);
  sdr_free(trees->size);
  sdr_free(trees->angle);
  sdr_free(trees->closed);
}

/* All pairs joined. polar NULL: without angles; damage: see forest. */
static sdr_status forest_grow(sdr_system *system, double threshold, const double *polar,
                              const double *damage, forest *trees)
{
  const size_t count = (size_t)system->count;
  *trees = (forest){
      .points = system->model->points, .polar = polar, .threshold = threshold, .damage = damage};
  trees->parent = sdr_alloc(count, sizeof *trees->parent);
  trees->size = sdr_alloc(count, sizeof *trees->size);
  if (polar) {
    trees->angle = sdr_alloc(count, sizeof *trees->angle);
    trees->closed = sdr_alloc(count, sizeof *trees->closed);
  }
  if (!trees->parent || !trees->size || (polar && (!trees->angle || !trees->closed))) {
    forest_free(trees);
    return SDR_RUN_FAILED;
  }
  for (int32_t i = 0; i < system->count; ++i) {
    trees->parent[i] = i;
    trees->size[i] = 1;
  }
  system->model->ops->visit_damage(system->model, system->u, join_pair, trees);
  return SDR_OK;
}

typedef struct {
  int32_t root, size, first;
} part;

static int by_falling_size(const void *left, const void *right)
{
  const part *a = left, *b = right;
  if (a->size != b->size) return a->size > b->size ? -1 : 1;
  return (a->first > b->first) - (a->first < b->first);
}

/* The parts in their final order: *count of them, each with its lowest point. `slot` is scratch of
   one number a point and holds, for each root, its part's rank at the end. */
static void order_parts(forest *trees, int32_t points, part *parts, int32_t *slot, int32_t *count)
{
  double unused;
  int32_t found = 0;
  for (int32_t i = 0; i < points; ++i) slot[i] = -1;
  for (int32_t i = 0; i < points; ++i) {
    const int32_t root = find(trees, i, &unused);
    if (slot[root] >= 0 || !sdr_in_body(trees->points, i)) continue;
    slot[root] = found;
    parts[found++] = (part){root, trees->size[root], i};
  }
  qsort(parts, (size_t)found, sizeof *parts, by_falling_size);
  for (int32_t k = 0; k < found; ++k) slot[parts[k].root] = k;
  *count = found;
}

sdr_status sdr_fragments_find(sdr_system *system, double threshold, int32_t *piece,
                              sdr_fragments *out)
{
  forest trees;
  double unused;
  int32_t count = 0, single = 0;
  SDR_TRY(forest_grow(system, threshold, NULL, NULL, &trees));
  part *parts = sdr_alloc((size_t)system->count, sizeof *parts);
  int32_t *slot = sdr_alloc((size_t)system->count, sizeof *slot);
  sdr_status status = SDR_RUN_FAILED;
  if (!parts || !slot) goto done;
  order_parts(&trees, system->count, parts, slot, &count);
  for (int32_t i = 0; piece && i < system->count; ++i) piece[i] = slot[find(&trees, i, &unused)];
  for (int32_t k = 0; k < count; ++k) single += parts[k].size == 1;
  *out =
      (sdr_fragments){.count = count, .largest = count > 0 ? parts[0].size : 0, .single = single};
  status = SDR_OK;
done:
  sdr_free(slot);
  sdr_free(parts);
  forest_free(&trees);
  return status;
}

/* Where the points of a ring lie. */
typedef struct {
  double *radius, *polar;
  double inner, outer;
} ring;

static void ring_free(ring *r)
{
  sdr_free(r->radius);
  sdr_free(r->polar);
}

static sdr_status ring_measure(const sdr_points *points, const double centre[3], ring *r)
{
  *r = (ring){.inner = HUGE_VAL, .outer = 0.0};
  r->radius = sdr_alloc((size_t)points->count, sizeof *r->radius);
  r->polar = sdr_alloc((size_t)points->count, sizeof *r->polar);
  if (!r->radius || !r->polar) {
    ring_free(r);
    return SDR_RUN_FAILED;
  }
  for (int32_t i = 0; i < points->count; ++i) {
    const double x = points->x[0][i] - centre[0], y = points->x[1][i] - centre[1];
    r->radius[i] = hypot(x, y);
    r->polar[i] = atan2(y, x);
    r->inner = fmin(r->inner, r->radius[i]);
    r->outer = fmax(r->outer, r->radius[i]);
  }
  return SDR_OK;
}

/* touches: one byte a point out, for roots: 1 inner surface, 2 outer, 3 both. */
static void find_touching(forest *trees, const sdr_points *points, const ring *r,
                          unsigned char *touches)
{
  double unused;
  for (int32_t i = 0; i < points->count; ++i) {
    const double near = 2.0 * points->spacing[i] * (1.0 + 1e-9);
    const int32_t root = find(trees, i, &unused);
    if (r->radius[i] <= r->inner + near) touches[root] |= 1;
    if (r->radius[i] >= r->outer - near) touches[root] |= 2;
  }
}

/* By the rule above. */
static int32_t count_sectors(const forest *trees, const sdr_points *points,
                             const unsigned char *touches)
{
  int32_t sectors = 0, closed = 0;
  for (int32_t i = 0; i < points->count; ++i) {
    if (trees->parent[i] != i || touches[i] != 3) continue;
    ++sectors;
    closed += trees->closed[i];
  }
  return sectors == 1 && closed ? 0 : sectors;
}

static int32_t count_across(const forest *trees, const sdr_points *points,
                            const unsigned char *touches)
{
  int32_t across = 0;
  for (int32_t i = 0; i < points->count; ++i) across += trees->parent[i] == i && touches[i] == 3;
  return across;
}

/* Sectors (damage NULL) or through-cracks of a ring. */
static sdr_status count_in_ring(sdr_system *system, double threshold, const double *damage,
                                const double centre[3], int32_t *count)
{
  const sdr_points *points = system->model->points;
  ring r;
  forest trees;
  SDR_TRY(ring_measure(points, centre, &r));
  sdr_status status = forest_grow(system, threshold, damage ? NULL : r.polar, damage, &trees);
  if (status != SDR_OK) goto measured;
  unsigned char *touches = sdr_alloc((size_t)points->count, 1);
  if (touches) {
    find_touching(&trees, points, &r, touches);
    *count =
        damage ? count_across(&trees, points, touches) : count_sectors(&trees, points, touches);
  } else {
    status = SDR_RUN_FAILED;
  }
  sdr_free(touches);
  forest_free(&trees);
measured:
  ring_free(&r);
  return status;
}

sdr_status sdr_ring_sectors(sdr_system *system, double threshold, const double centre[3],
                            int32_t *count)
{
  *count = 0;
  if (system->components < 2) return SDR_OK;
  return count_in_ring(system, threshold, NULL, centre, count);
}

sdr_status sdr_through_cracks(sdr_system *system, double threshold, const double centre[3],
                              int32_t *count)
{
  *count = 0;
  if (system->components < 2) return SDR_OK;
  double *damage = sdr_alloc((size_t)system->count, sizeof *damage);
  if (!damage) return SDR_RUN_FAILED;
  sdr_status status = sdr_system_field(system, "damage", damage);
  if (status == SDR_OK) status = count_in_ring(system, threshold, damage, centre, count);
  sdr_free(damage);
  return status;
}
