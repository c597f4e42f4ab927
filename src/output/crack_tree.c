/* Points of a crack are sorted into bands by their distance from the notch; in each band those that
   lie beside each other make a node. A node hangs on the node of a lower band through which its
   first point was reached. Twigs shorter than the shortest arm are cut off. */
#include "output/crack_tree.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* Neighbours on a cube's diagonal (1.73 spacings) touch, those with one between them (2) do not. */
static const double touching = 1.8; /* spacings */

typedef struct {
  sdr_crack_node head;
  double weight;   /* points in it */
  double farthest; /* distance that its twigs reach */
  int64_t band;
  int32_t first;  /* its first entry */
  int32_t parent; /* -1: the notch */
  int32_t arm;    /* -1: not on one that counts */
  int32_t place;  /* in its arm */
} knot;

typedef struct {
  const sdr_crack_sites *sites;
  const sdr_crack_growth *growth;
  int32_t count; /* entries there are by then */
  double width;  /* of bands, m */
  int64_t *band;
  int32_t *entry_of; /* per site; -1 */
  int32_t *group;    /* per entry: an earlier one of its node, itself for the first */
  int32_t *knot_of;  /* per entry */
  knot *knots;       /* by band */
  int32_t knot_count;
  int32_t now; /* entry whose neighbours are visited */
} maker;

static int32_t root(maker *m, int32_t k)
{
  while (m->group[k] != k) k = m->group[k] = m->group[m->group[k]];
  return k;
}

static void join(void *context, int32_t site, double distance)
{
  maker *m = context;
  const double *spacing = m->sites->points->spacing;
  const int32_t other = m->entry_of[site];
  if (other < 0 || m->band[other] != m->band[m->now]) return;
  const double mean = 0.5 * (spacing[site] + spacing[m->growth->site[m->now]]);
  if (distance > touching * mean) return;
  const int32_t a = root(m, m->now), b = root(m, other);
  m->group[a > b ? a : b] = a > b ? b : a;
}

static void group_entries(maker *m)
{
  const sdr_points *points = m->sites->points;
  for (int32_t i = 0; i < points->count; ++i) m->entry_of[i] = -1;
  for (int32_t k = 0; k < m->count; ++k) {
    m->entry_of[m->growth->site[k]] = k;
    m->width = fmax(m->width, points->spacing[m->growth->site[k]]);
  }
  for (int32_t k = 0; k < m->count; ++k) {
    m->group[k] = k;
    m->band[k] = (int64_t)(m->growth->distance[k] / m->width);
  }
  for (m->now = 0; m->now < m->count; ++m->now) {
    double x[3] = {0.0};
    for (int c = 0; c < points->components; ++c) x[c] = points->x[c][m->growth->site[m->now]];
    sdr_point_grid_within(m->sites->grid, x, touching * m->width, join, m);
  }
}

static int by_band(const void *left, const void *right)
{
  const knot *a = left, *b = right;
  if (a->band != b->band) return a->band < b->band ? -1 : 1;
  return (a->first > b->first) - (a->first < b->first);
}

/* The first knot of a lower band on the way back to the notch. */
static int32_t find_parent(const maker *m, const knot *of)
{
  int32_t k = m->growth->before[of->first];
  while (k >= 0 && m->band[k] >= of->band) k = m->growth->before[k];
  return k < 0 ? -1 : m->knot_of[k];
}

static void fill_knots(maker *m)
{
  const sdr_points *points = m->sites->points;
  for (int32_t k = 0; k < m->count; ++k) {
    knot *of = &m->knots[m->knot_of[k] = m->knot_of[root(m, k)]];
    of->weight += 1.0;
    of->farthest = fmax(of->farthest, m->growth->distance[k]);
    for (int c = 0; c < points->components; ++c) of->head.x[c] += points->x[c][m->growth->site[k]];
  }
  for (int32_t n = 0; n < m->knot_count; ++n) {
    for (int c = 0; c < 3; ++c) m->knots[n].head.x[c] /= m->knots[n].weight;
    m->knots[n].parent = find_parent(m, &m->knots[n]);
  }
  /* What lies farther was reached through here, so not earlier. */
  for (int32_t n = m->knot_count - 1; n >= 0; --n) {
    const knot *of = &m->knots[n];
    if (of->parent < 0) continue;
    knot *parent = &m->knots[of->parent];
    parent->farthest = fmax(parent->farthest, of->farthest);
    parent->head.time = fmin(parent->head.time, of->head.time);
  }
}

static void make_knots(maker *m)
{
  group_entries(m);
  for (int32_t k = 0; k < m->count; ++k)
    if (m->group[k] == k)
      m->knots[m->knot_count++] =
          (knot){.head = {.time = m->growth->time[k], .distance = m->growth->distance[k]},
                 .band = m->band[k],
                 .first = k,
                 .arm = -1};
  qsort(m->knots, (size_t)m->knot_count, sizeof *m->knots, by_band);
  for (int32_t n = 0; n < m->knot_count; ++n) m->knot_of[m->knots[n].first] = n;
  fill_knots(m);
}

/* The child of a knot (-1: the notch) that reaches farthest; -1: it has none. */
static int32_t find_heir(const maker *m, int32_t of)
{
  int32_t best = -1;
  for (int32_t n = of + 1; n < m->knot_count; ++n)
    if (m->knots[n].parent == of && (best < 0 || m->knots[n].farthest > m->knots[best].farthest))
      best = n;
  return best;
}

static int32_t put_on_arm(knot *of, int32_t arm, sdr_crack_tree *tree)
{
  of->arm = arm;
  of->place = tree->arm[arm].count++;
  return arm;
}

/* Give the children of a knot (-1: the notch) their arms: the heir goes on, others that reach far
   enough begin new ones. */
static void pass_on(maker *m, int32_t of, double shortest, sdr_crack_tree *tree)
{
  const int32_t heir = find_heir(m, of), arm = of < 0 ? -1 : m->knots[of].arm;
  const double from = of < 0 ? 0.0 : m->knots[of].head.distance;
  if (heir < 0 || (of >= 0 && arm < 0)) return;
  if (of < 0) tree->arm[tree->arm_count++] = (sdr_crack_arm){.parent = -1, .left_at = -1};
  put_on_arm(&m->knots[heir], of < 0 ? 0 : arm, tree);
  for (int32_t n = of + 1; n < m->knot_count; ++n) {
    knot *child = &m->knots[n];
    if (child->parent != of || n == heir || child->farthest - from < shortest) continue;
    tree->arm[tree->arm_count] =
        (sdr_crack_arm){.parent = arm, .left_at = of < 0 ? -1 : m->knots[of].place};
    put_on_arm(child, tree->arm_count++, tree);
  }
}

/* Move the knots of arms into the tree; left_at turns from a place in the parent to a node. */
static void lay_out(const maker *m, sdr_crack_tree *tree)
{
  for (int32_t a = 0; a < tree->arm_count; ++a) {
    tree->arm[a].first = tree->node_count;
    tree->node_count += tree->arm[a].count;
    if (tree->arm[a].parent >= 0) tree->arm[a].left_at += tree->arm[tree->arm[a].parent].first;
  }
  for (int32_t n = 0; n < m->knot_count; ++n)
    if (m->knots[n].arm >= 0)
      tree->node[tree->arm[m->knots[n].arm].first + m->knots[n].place] = m->knots[n].head;
}

static int make_room(maker *m, sdr_crack_tree *tree)
{
  const size_t count = (size_t)m->count;
  m->band = sdr_alloc(count, sizeof *m->band);
  m->group = sdr_alloc(count, sizeof *m->group);
  m->knot_of = sdr_alloc(count, sizeof *m->knot_of);
  m->knots = sdr_alloc(count, sizeof *m->knots);
  m->entry_of = sdr_alloc((size_t)m->sites->points->count, sizeof *m->entry_of);
  tree->node = sdr_alloc(count, sizeof *tree->node);
  tree->arm = sdr_alloc(count, sizeof *tree->arm);
  return m->band && m->group && m->knot_of && m->knots && m->entry_of && tree->node && tree->arm;
}

sdr_status sdr_crack_branch(const sdr_crack_sites *sites, const sdr_crack_growth *growth,
                            double until, double shortest, sdr_crack_tree *out)
{
  maker m = {.sites = sites, .growth = growth};
  sdr_crack_tree tree = {0};
  while (m.count < growth->count && growth->time[m.count] <= until) ++m.count;
  const int have_room = make_room(&m, &tree);
  if (have_room) {
    make_knots(&m);
    for (int32_t n = -1; n < m.knot_count; ++n) pass_on(&m, n, shortest, &tree);
    lay_out(&m, &tree);
  }
  sdr_free(m.band);
  sdr_free(m.group);
  sdr_free(m.knot_of);
  sdr_free(m.knots);
  sdr_free(m.entry_of);
  if (have_room)
    *out = tree;
  else
    sdr_crack_tree_clear(&tree);
  return have_room ? SDR_OK : SDR_RUN_FAILED;
}

void sdr_crack_tree_clear(sdr_crack_tree *tree)
{
  sdr_free(tree->node);
  sdr_free(tree->arm);
  *tree = (sdr_crack_tree){0};
}

int32_t sdr_crack_path(const sdr_crack_tree *tree, int32_t arm, sdr_crack_node *path)
{
  const sdr_crack_arm *own = &tree->arm[arm];
  int32_t count = 0;
  if (own->parent >= 0) {
    const int32_t before = own->left_at - tree->arm[own->parent].first + 1;
    count = sdr_crack_path(tree, own->parent, path);
    count -= tree->arm[own->parent].count - before;
  }
  for (int32_t k = 0; k < own->count; ++k) path[count++] = tree->node[own->first + k];
  return count;
}

double sdr_crack_length(const sdr_crack_tree *tree)
{
  double sum = 0.0;
  for (int32_t a = 0; a < tree->arm_count; ++a) {
    const sdr_crack_arm *arm = &tree->arm[a];
    const double from = arm->left_at < 0 ? 0.0 : tree->node[arm->left_at].distance;
    sum += tree->node[arm->first + arm->count - 1].distance - from;
  }
  return sum;
}
