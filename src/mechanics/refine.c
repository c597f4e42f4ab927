#include "mechanics/refine.h"

#include "base/memory.h"

void sdr_point_map_clear(sdr_point_map *map)
{
  sdr_free(map->parent);
  sdr_free(map->first_child);
  sdr_free(map->child);
  *map = (sdr_point_map){0};
}
