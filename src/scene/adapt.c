/* The mapping `points.adapt`: where and when points split while a run goes on. */
#include "scene/sections.h"

#include <math.h>
#include <string.h>

static void read_where(sdr_reading *rd, sdr_node *map, sdr_adapt_scene *adapt)
{
  adapt->anywhere = !sdr_read_has(rd->reader, map, "where");
  if (!adapt->anywhere) sdr_read_place(rd, map, "where", SDR_VOLUME_PLACE, NULL, &adapt->where);
}

void sdr_read_adapt(sdr_reading *rd, sdr_node *points)
{
  sdr_reader *r = rd->reader;
  if (!sdr_read_has(r, points, "adapt")) return;
  sdr_node *map = sdr_read_map(r, points, "adapt", NULL);
  sdr_adapt_scene *adapt = map ? sdr_store_alloc(r->store, 1, sizeof *adapt) : NULL;
  int64_t levels = 1;
  if (!map) return;
  if (!adapt) {
    sdr_read_fatal(r, SDR_RUN_FAILED);
    return;
  }
  if (sdr_node_find(rd->root, "equation"))
    sdr_read_error(r, map->key_origin, "points.adapt: points of an equation do not split");
  rd->scene->points.adapt = adapt;
  adapt->origin = map->key_origin;
  read_where(rd, map, adapt);
  if (sdr_read_integer(r, map, "levels", 1, 6, "1", &levels)) adapt->levels = (int)levels;
  sdr_read_number_or(r, map, "damage", "none", INFINITY, (sdr_quantity){SDR_PLAIN, 0, 1, 0, 1},
                     "2 %", &adapt->damage);
  sdr_read_number_or(r, map, "energy", "none", INFINITY, SDR_ABOVE_ZERO(SDR_STRESS), "none",
                     &adapt->energy);
  sdr_read_length(r, map, "neighbours", "horizon", SDR_FROM_ZERO(SDR_LENGTH), "1 horizon",
                  &adapt->neighbours);
  sdr_read_length(r, map, "ahead", "horizon", SDR_FROM_ZERO(SDR_LENGTH), "1 horizon",
                  &adapt->ahead);
  sdr_read_number_or(r, map, "every", "auto", NAN, SDR_ABOVE_ZERO(SDR_TIME), "auto", &adapt->every);
  if (isinf(adapt->damage) && isinf(adapt->energy))
    sdr_read_error(r, map->origin,
                   "points.adapt has neither damage nor energy, so no point ever splits; give one");
  sdr_read_done(r, map);
}

static int has_layers(const sdr_scene *scene)
{
  for (int k = 0; k < scene->load_count; ++k)
    if (scene->load[k].layer != SDR_NO_LAYER) return 1;
  for (int k = 0; k < scene->support_count; ++k)
    if (scene->support[k].layer != SDR_NO_LAYER) return 1;
  return 0;
}

void sdr_check_adapt(sdr_reading *rd)
{
  const sdr_scene *scene = rd->scene;
  const sdr_adapt_scene *adapt = scene->points.adapt;
  if (!adapt) return;
  const char *why = NULL;
  if (scene->model != SDR_BOND_BASED)
    why = "only points of bond_based bodies can split; take material.model: bond_based";
  else if (scene->time.integrator[0] && strcmp(scene->time.integrator, "leapfrog") != 0)
    why = "only leapfrog can go on after points have split; take time.integrator: leapfrog";
  else if (scene->points.jitter > 0.0)
    why = "jittered points cannot split; leave points.jitter out";
  else if (scene->mixed)
    why = "bodies whose points split are computed in double precision; take precision: double";
  else if (scene->contact.on)
    why = "pieces whose points split cannot touch yet; leave contact or points.adapt out";
  else if (has_layers(scene))
    why = "points that layers follow cannot split; take loads and supports without layers";
  else if (sdr_is_lawless(rd) && isinf(adapt->energy))
    why = "without a damage law no damage grows, so no point ever splits; give adapt.energy";
  if (why) sdr_read_error(rd->reader, adapt->origin, "points.adapt: %s", why);
}
