/* Points, edges or triangles sorted so that the one nearest to a place is found quickly. */
#ifndef SDR_SCENE_TREE_H
#define SDR_SCENE_TREE_H

#include "scene/store.h"

#include <stdint.h>

typedef struct sdr_tree {
  int corners; /* of a piece: 1 point, 2 edge, 3 triangle */
  int32_t count;
  double *piece;  /* 3 * corners a piece, m, sorted */
  double *normal; /* 3 a piece, unit vectors; NULL: none were given */
  int32_t *label; /* of each piece: its index in the order given */
  double *box;    /* 6 a node: low[3], high[3]; the children of node n are 2 n + 1 and 2 n + 2 */
} sdr_tree;

/* Sort `count` pieces (>= 1), copied from piece (3 * corners a piece) and normal (3 a piece, or
   NULL). The tree belongs to the store. */
sdr_status sdr_tree_create(sdr_store *store, int corners, int32_t count, const double *piece,
                           const double *normal, sdr_tree **out);

/* Distance of x[3] from the nearest piece, m; its place in the sorted order goes to *nearest (may
   be NULL). Of several as near, the first in the sorted order. */
double sdr_tree_nearest(const sdr_tree *tree, const double x[3], int32_t *nearest);

#endif
