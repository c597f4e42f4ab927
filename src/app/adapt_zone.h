/* Which points of an adaptive body split, by cells of its coarsest lattice. */
#ifndef SDR_APP_ADAPT_ZONE_H
#define SDR_APP_ADAPT_ZONE_H

#include "nom/points.h"
#include "scene/scene.h"

typedef struct sdr_adapt_zone sdr_adapt_zone;

/* The cells of the points that a run begins with (arranged, of a lattice or nested ones). Borrows
   the scene. Owner: the caller. */
sdr_status sdr_adapt_zone_create(const sdr_scene *scene, const sdr_points *points,
                                 sdr_adapt_zone **out);
void sdr_adapt_zone_destroy(sdr_adapt_zone **zone); /* NULL-safe */

/* split[i] = 1 for the points that must split now, by the energy per volume and the damage of each;
   returns how many. A point over a threshold is a seed. If some point that may split (its level and
   place allow it) lies within `neighbours` of a seed, all that may there do, and within that of the
   way, `ahead` long, that damage takes on from each tip; without a tip all within `neighbours` +
   `ahead`. Else none. Distances are those between the middles of coarsest cells. */
int32_t sdr_adapt_zone_choose(sdr_adapt_zone *zone, const sdr_points *points, const double *energy,
                              const double *damage, uint8_t *split);

/* m: `neighbours` */
double sdr_adapt_zone_reach(const sdr_adapt_zone *zone);

#endif
