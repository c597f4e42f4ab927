#include "scene/tree.h"

#include "base/memory.h"
#include "base/small.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAF = 8 }; /* pieces in a node that is not split */

/* ---- building -------------------------------------------------------------------------------- */

/* A piece to be sorted, by its middle along one axis. */
typedef struct {
  double middle[3];
  int32_t index;
} entry;

typedef struct {
  sdr_tree *tree;
  const double *piece;
  entry *entries;
} builder;

static int by_axis(const void *left, const void *right, void *axis)
{
  const entry *a = left, *b = right;
  const double x = a->middle[*(const int *)axis], y = b->middle[*(const int *)axis];
  if (x != y) return x < y ? -1 : 1;
  return a->index < b->index ? -1 : a->index > b->index;
}

static void bound(const builder *b, int32_t first, int32_t last, double box[6])
{
  for (int c = 0; c < 3; ++c) {
    box[c] = HUGE_VAL;
    box[3 + c] = -HUGE_VAL;
  }
  for (int32_t k = first; k < last; ++k) {
    const double *x = b->piece + (size_t)(3 * b->tree->corners) * (size_t)b->entries[k].index;
    for (int n = 0; n < 3 * b->tree->corners; ++n) {
      box[n % 3] = fmin(box[n % 3], x[n]);
      box[3 + n % 3] = fmax(box[3 + n % 3], x[n]);
    }
  }
}

static int longest_side(const double box[6])
{
  int axis = 0;
  for (int c = 1; c < 3; ++c)
    if (box[3 + c] - box[c] > box[3 + axis] - box[axis]) axis = c;
  return axis;
}

/* Both halves of first..last of a node; a node's range follows from its place in the tree. */
static int32_t middle_of(int32_t first, int32_t last)
{
  return first + (last - first) / 2;
}

static void sort_node(const builder *b, size_t node, int32_t first, int32_t last)
{
  double *box = b->tree->box + 6 * node;
  bound(b, first, last, box);
  if (last - first <= LEAF) return;
  int axis = longest_side(box);
  qsort_r(b->entries + first, (size_t)(last - first), sizeof *b->entries, by_axis, &axis);
  const int32_t middle = middle_of(first, last);
  sort_node(b, 2 * node + 1, first, middle);
  sort_node(b, 2 * node + 2, middle, last);
}

static size_t nodes_for(int32_t count)
{
  size_t nodes = 1;
  for (int32_t part = count; part > LEAF; part -= part / 2) nodes = 2 * nodes + 1;
  return nodes;
}

static sdr_status allocate(sdr_store *store, int with_normals, sdr_tree *tree)
{
  const size_t count = (size_t)tree->count;
  tree->piece = sdr_store_alloc(store, count, 3 * (size_t)tree->corners * sizeof *tree->piece);
  tree->label = sdr_store_alloc(store, count, sizeof *tree->label);
  tree->box = sdr_store_alloc(store, nodes_for(tree->count), 6 * sizeof *tree->box);
  if (with_normals) tree->normal = sdr_store_alloc(store, count, 3 * sizeof *tree->normal);
  const int whole = tree->piece && tree->label && tree->box && (tree->normal || !with_normals);
  return whole ? SDR_OK : SDR_RUN_FAILED;
}

static void set_entries(const builder *b)
{
  const int corners = b->tree->corners;
  for (int32_t k = 0; k < b->tree->count; ++k) {
    b->entries[k].index = k;
    for (int n = 0; n < 3 * corners; ++n)
      b->entries[k].middle[n % 3] += b->piece[(size_t)(3 * corners) * (size_t)k + (size_t)n];
  }
}

sdr_status sdr_tree_create(sdr_store *store, int corners, int32_t count, const double *piece,
                           const double *normal, sdr_tree **out)
{
  sdr_tree *tree = sdr_store_alloc(store, 1, sizeof *tree);
  if (!tree) return SDR_RUN_FAILED;
  tree->corners = corners;
  tree->count = count;
  SDR_TRY(allocate(store, normal != NULL, tree));
  const builder b = {tree, piece, sdr_alloc((size_t)count, sizeof *b.entries)};
  if (!b.entries) return SDR_RUN_FAILED;
  set_entries(&b);
  sort_node(&b, 0, 0, count);
  const size_t size = 3 * (size_t)corners;
  for (size_t k = 0; k < (size_t)count; ++k) {
    const size_t from = (size_t)b.entries[k].index;
    tree->label[k] = b.entries[k].index;
    memcpy(tree->piece + size * k, piece + size * from, size * sizeof *piece);
    if (normal) memcpy(tree->normal + 3 * k, normal + 3 * from, 3 * sizeof *normal);
  }
  sdr_free(b.entries);
  *out = tree;
  return SDR_OK;
}

/* ---- searching ------------------------------------------------------------------------------- */

static double distance2(const double a[3], const double b[3])
{
  double sum = 0.0;
  for (int c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

static double edge_distance2(const double *a, const double *b, const double x[3])
{
  double along = 0.0, length2 = distance2(a, b), foot[3];
  for (int c = 0; c < 3; ++c) along += (x[c] - a[c]) * (b[c] - a[c]);
  const double s = length2 > 0.0 ? fmin(1.0, fmax(0.0, along / length2)) : 0.0;
  for (int c = 0; c < 3; ++c) foot[c] = a[c] + s * (b[c] - a[c]);
  return distance2(foot, x);
}

/* The foot of x on the plane if it lies inside all three edges, else the nearest edge's. */
static double triangle_distance2(const double *t, const double x[3])
{
  double e[3], f[3], d[3], n[3], inside[3];
  for (int c = 0; c < 3; ++c) {
    e[c] = t[3 + c] - t[c];
    f[c] = t[6 + c] - t[c];
    d[c] = x[c] - t[c];
  }
  sdr_cross3(e, f, n);
  const double n2 = sdr_dot3(n, n), height = sdr_dot3(n, d);
  sdr_cross3(e, d, inside); /* on the side of e where the triangle lies */
  const double third = sdr_dot3(inside, n);
  sdr_cross3(d, f, inside);
  const double second = sdr_dot3(inside, n);
  if (n2 > 0.0 && second >= 0.0 && third >= 0.0 && second + third <= n2)
    return height * height / n2;
  return fmin(edge_distance2(t, t + 3, x),
              fmin(edge_distance2(t + 3, t + 6, x), edge_distance2(t + 6, t, x)));
}

static double piece_distance2(const sdr_tree *tree, int32_t k, const double x[3])
{
  const double *piece = tree->piece + (size_t)(3 * tree->corners) * (size_t)k;
  if (tree->corners == 1) return distance2(piece, x);
  if (tree->corners == 2) return edge_distance2(piece, piece + 3, x);
  return triangle_distance2(piece, x);
}

static double box_distance2(const double box[6], const double x[3])
{
  double sum = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double d = fmax(0.0, fmax(box[c] - x[c], x[c] - box[3 + c]));
    sum += d * d;
  }
  return sum;
}

typedef struct {
  const sdr_tree *tree;
  const double *x;
  double best2;
  int32_t nearest;
} search;

static void search_node(search *s, size_t node, int32_t first, int32_t last)
{
  if (box_distance2(s->tree->box + 6 * node, s->x) > s->best2) return;
  if (last - first > LEAF) {
    const int32_t middle = middle_of(first, last);
    const double *left = s->tree->box + 6 * (2 * node + 1), *right = left + 6;
    const int turned = box_distance2(right, s->x) < box_distance2(left, s->x);
    if (turned) search_node(s, 2 * node + 2, middle, last);
    search_node(s, 2 * node + 1, first, middle);
    if (!turned) search_node(s, 2 * node + 2, middle, last);
    return;
  }
  for (int32_t k = first; k < last; ++k) {
    const double d2 = piece_distance2(s->tree, k, s->x);
    if (d2 > s->best2 || (d2 == s->best2 && s->nearest >= 0 && s->nearest < k)) continue;
    s->best2 = d2;
    s->nearest = k;
  }
}

double sdr_tree_nearest(const sdr_tree *tree, const double x[3], int32_t *nearest)
{
  search s = {tree, x, HUGE_VAL, -1};
  search_node(&s, 0, 0, tree->count);
  if (nearest) *nearest = s.nearest;
  return sqrt(s.best2);
}
