/* The mapping `time` of energy_momentum. */
#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* What belongs to other integrators may stand there for a variant of the scene. */
static void allow_others(sdr_reading *rd, sdr_node *map)
{
  static const char *const keys[] = {
      "method",    "order",  "linear",        "tolerance_displacement", "tolerance_velocity",
      "viscosity", "safety", "allow_unstable"};
  for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k) sdr_read_allow(rd->reader, map, keys[k]);
}

void sdr_read_energy_momentum(sdr_reading *rd, sdr_node *map)
{
  static const char *const solvers[] = {"auto", "bicgstab", "stale", "umfpack", "klu", NULL};
  sdr_reader *r = rd->reader;
  sdr_time_scene *time = &rd->scene->time;
  int solver = 0;
  sdr_read_number_or(r, map, "step", "auto", NAN, SDR_ABOVE_ZERO(SDR_TIME), "auto", &time->step);
  sdr_read_number(r, map, "end", SDR_ABOVE_ZERO(SDR_TIME), NULL, &time->end);
  if (sdr_read_word(r, map, "solver", solvers, NULL, "auto", &solver))
    snprintf(time->solver, sizeof time->solver, "%s", solvers[solver]);
  sdr_read_number(r, map, "tolerance", (sdr_quantity){SDR_PLAIN, 1e-15, 0.1, 0, 0}, "1e-12",
                  &time->tolerance);
  allow_others(rd, map);
  if (rd->scene->model == SDR_BOND_BASED) return;
  const sdr_node *node = sdr_node_find(map, "integrator");
  sdr_read_error(r, node ? node->origin : map->origin,
                 "energy_momentum needs a bond-based body: a model '%s' has no mean force of a "
                 "step; take leapfrog, cvode or ida",
                 sdr_model_words[rd->scene->model]);
}
