#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* What belongs to other integrators may stand there for a variant of the scene. */
static void allow_others(sdr_reading *rd, sdr_node *map)
{
  static const char *const keys[] = {"safety",
                                     "allow_unstable",
                                     "method",
                                     "order",
                                     "tolerance",
                                     "tolerance_displacement",
                                     "tolerance_velocity",
                                     "viscosity",
                                     NULL};
  for (int k = 0; keys[k]; ++k) sdr_read_allow(rd->reader, map, keys[k]);
}

static void refuse(sdr_reading *rd, const sdr_node *map, const char *key, const char *why)
{
  const sdr_node *node = sdr_node_find(map, key);
  sdr_read_error(rd->reader, node ? node->origin : map->origin, "%s", why);
}

/* A linear solution takes one step, as long as the run; `step` then says so with a warning, or with
   `auto` not at all. Without it, `step` is the first and longest increment. */
void sdr_read_static(sdr_reading *rd, sdr_node *map)
{
  static const char *const solvers[] = {"auto", "cholmod",    "klu",    "umfpack",
                                        "pcg",  "relaxation", "kinsol", NULL};
  sdr_reader *r = rd->reader;
  const sdr_scene *scene = rd->scene;
  sdr_time_scene *time = &rd->scene->time;
  const int damaged = scene->damage.law != SDR_LAW_NONE;
  int solver = 0;
  if (sdr_read_word(r, map, "solver", solvers, NULL, "auto", &solver))
    snprintf(time->solver, sizeof time->solver, "%s", solvers[solver]);
  sdr_read_flag(r, map, "linear", damaged ? "false" : "true", &time->linear);
  sdr_read_number(r, map, "end", SDR_ABOVE_ZERO(SDR_TIME), "1 s", &time->end);
  sdr_read_number_or(r, map, "step", "auto", NAN, SDR_ABOVE_ZERO(SDR_TIME),
                     time->linear ? SDR_OPTIONAL : "auto", &time->step);
  if (!time->linear)
    sdr_read_flag(r, map, "ends_at_collapse", SDR_OPTIONAL, &time->ends_at_collapse);
  else
    sdr_read_allow(r, map, "ends_at_collapse");
  allow_others(rd, map);
  if (time->linear && damaged)
    refuse(rd, map, "linear",
           "a linear static solution has no damage; leave damage out, or give linear: false");
  if (time->linear &&
      (strcmp(time->solver, "relaxation") == 0 || strcmp(time->solver, "kinsol") == 0))
    refuse(
        rd, map, "solver",
        "relaxation and kinsol find nonlinear equilibria; give linear: false, or another solver");
  if (scene->initial_count > 0)
    sdr_read_error(r, scene->initial[0].origin,
                   "a static solution has no state to start from; leave initial out");
}
