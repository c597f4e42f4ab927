/* Points that split into children while a run goes on (000 sec. 5.3). */
#ifndef SDR_MECHANICS_REFINE_H
#define SDR_MECHANICS_REFINE_H

#include "nom/points.h"

/* Which point became which, in storage order before and after: a point that did not split is its
   own only child. */
typedef struct {
  int32_t before, now;  /* how many points there were and are */
  int32_t *parent;      /* now: index before */
  int32_t *first_child; /* before + 1: children of p are child[first_child[p]] .. */
  int32_t *child;       /* now: indices now, in the order of generation within a parent */
} sdr_point_map;

void sdr_point_map_clear(sdr_point_map *map);

/* 1 if point i (now) came out of a parent that split. */
static inline int sdr_is_child(const sdr_point_map *map, int32_t i)
{
  const int32_t p = map->parent[i];
  return map->first_child[p + 1] - map->first_child[p] > 1;
}

#endif
