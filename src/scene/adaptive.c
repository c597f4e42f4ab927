/* The mapping `time` of integrators that choose their steps: cvode and ida. */
#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void sdr_allow_adaptive(sdr_reading *rd, sdr_node *map)
{
  static const char *const keys[] = {
      "method",   "order", "solver", "tolerance", "tolerance_displacement", "tolerance_velocity",
      "viscosity"};
  for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k) sdr_read_allow(rd->reader, map, keys[k]);
}

static void read_tolerances(sdr_reading *rd, sdr_node *map)
{
  sdr_reader *r = rd->reader;
  sdr_time_scene *time = &rd->scene->time;
  const sdr_unit velocity = {1, 0, -1, 0};
  sdr_read_number(r, map, "tolerance", (sdr_quantity){SDR_PLAIN, 1e-14, 0.1, 0, 0}, "1e-5",
                  &time->tolerance);
  sdr_read_number_or(r, map, "tolerance_displacement", "auto", NAN, SDR_ABOVE_ZERO(SDR_LENGTH),
                     "auto", &time->tolerance_displacement);
  sdr_read_number_or(r, map, "tolerance_velocity", "auto", NAN, SDR_ABOVE_ZERO(velocity), "auto",
                     &time->tolerance_velocity);
}

/* Steps of a method that controls its error; `step` is the longest. */
void sdr_read_adaptive(sdr_reading *rd, sdr_node *map)
{
  static const char *const methods[] = {"bdf", "adams", NULL};
  static const char *const solvers[] = {"auto", "pcg", "stale", "cholmod", "klu", "umfpack", NULL};
  sdr_reader *r = rd->reader;
  sdr_time_scene *time = &rd->scene->time;
  const int is_cvode = strcmp(time->integrator, "cvode") == 0;
  int solver = 0;
  int64_t order = 0;
  if (is_cvode)
    sdr_read_word(r, map, "method", methods, NULL, "bdf", &time->adams);
  else
    sdr_read_allow(r, map, "method");
  if (sdr_read_word(r, map, "solver", solvers, NULL, "auto", &solver))
    snprintf(time->solver, sizeof time->solver, "%s", solvers[solver]);
  /* BDF beyond order 2 excites what swings undamped */
  const char *usual = time->adams ? "12" : is_cvode ? "2" : "5";
  if (sdr_read_integer(r, map, "order", 1, time->adams ? 12 : 5, usual, &order))
    time->order = (int)order;
  read_tolerances(rd, map);
  sdr_read_number(r, map, "end", SDR_ABOVE_ZERO(SDR_TIME), NULL, &time->end);
  sdr_read_number_or(r, map, "step", "auto", NAN, SDR_ABOVE_ZERO(SDR_TIME), "auto", &time->step);
  if (is_cvode)
    sdr_read_allow(r, map, "viscosity");
  else
    sdr_read_number(r, map, "viscosity", (sdr_quantity){SDR_TIME, 0, INFINITY, 0, 0}, "0 s",
                    &time->viscosity);
  sdr_read_allow(r, map, "safety");
  sdr_read_allow(r, map, "allow_unstable");
}

void sdr_check_masses(sdr_reading *rd)
{
  const sdr_scene *scene = rd->scene;
  const char *integrator = scene->time.integrator;
  if (strcmp(integrator, "ida") == 0 || strcmp(integrator, "static") == 0) return;
  for (int m = 0; m < scene->material_count; ++m)
    if (scene->material[m].density == 0.0)
      sdr_read_error(
          rd->reader, scene->material[m].origin,
          "a density of 0 leaves points without mass, which only the integrators ida and "
          "static can move; the integrator here is %s",
          integrator);
}
