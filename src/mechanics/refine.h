/* Points that split into children while a run goes on (000 sec. 5.3). A point of spacing h becomes
   2^n children of half its spacing, 1/2^n of its volume, h/4 off along each axis of the lattice;
   its mass stays to the last bit. They keep its material. */
#ifndef SDR_MECHANICS_REFINE_H
#define SDR_MECHANICS_REFINE_H

#include "nom/points.h"
#include "scene/scene.h"

/* Which point became which, in storage order before and after: a point that did not split is its
   own only child. */
typedef struct {
  int32_t before, now;  /* how many points there were and are */
  int32_t *parent;      /* now: index before */
  int32_t *first_child; /* before + 1: children of p are child[first_child[p]] .. */
  int32_t *child;       /* now: indices now, in the order of generation within a parent */
} sdr_point_map;

/* Split the points p with split[p] != 0 (arranged, of a lattice or of nested ones): *out gets the
   new points, arranged, in the order of generation in which children stand in their parent's place;
   a function of that order and of the split points alone, however they came about. Horizons are the
   scene's at the new places and spacings. Owner of *out and *map: the caller. */
sdr_status sdr_split_points(const sdr_scene *scene, const sdr_points *before, const uint8_t *split,
                            sdr_points **out, sdr_point_map *map);
void sdr_point_map_clear(sdr_point_map *map);

/* Two maps after each other: out leads from before `first` to after `second`. */
sdr_status sdr_point_map_join(const sdr_point_map *first, const sdr_point_map *second,
                              sdr_point_map *out);

static inline int sdr_splits(const sdr_point_map *map, int32_t parent)
{
  return map->first_child[parent + 1] - map->first_child[parent] > 1;
}

/* 1 if point i (now) came out of a parent that split. */
static inline int sdr_is_child(const sdr_point_map *map, int32_t i)
{
  return sdr_splits(map, map->parent[i]);
}

#endif
