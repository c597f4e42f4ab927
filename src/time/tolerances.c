#include "time/tolerances.h"

#include <math.h>

enum { MOMENTS = 32 };

/* The largest |v| of the start, and what the body's own forces give. */
static double scale_of_start(sdr_system *system, double half_step)
{
  double most = 0.0;
  system->model->ops->force(system->model, system->u, system->f);
  for (int a = 0; a < system->components; ++a)
    for (int32_t i = 0; i < system->count; ++i) {
      if (!sdr_in_body(system->model->points, i)) continue;
      most = fmax(most, fabs(system->v[a][i]));
      if (system->mass[i] > 0.0)
        most = fmax(most, fabs(system->f[a][i]) / system->mass[i] * half_step);
    }
  return most;
}

static sdr_status scale_of_loads(sdr_system *system, double t, double half_step, double *most)
{
  const int32_t *points = sdr_loads_points(system->loads);
  SDR_TRY(sdr_loads_evaluate(system->loads, t));
  for (int32_t k = 0; k < sdr_loads_count(system->loads); ++k)
    for (int a = 0; a < system->components; ++a) {
      const double mass = system->mass[points[k]];
      const double force = fabs(sdr_loads_force(system->loads, a)[k]);
      if (mass > 0.0) *most = fmax(*most, force / mass * half_step);
    }
  return SDR_OK;
}

/* Velocities, and differences of displacements over `since`. */
static sdr_status scale_of_supports(sdr_system *system, double t, double since, double *most)
{
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  SDR_TRY(sdr_supports_values(system->supports, t, system->motion));
  SDR_TRY(sdr_supports_values(system->supports, t - since, system->next_motion));
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    const double now = system->motion[k], before = system->next_motion[k];
    if (isnan(now)) continue;
    if (list[k].is_velocity)
      *most = fmax(*most, fabs(now));
    else if (!isnan(before))
      *most = fmax(*most, fabs(now - before) / since);
  }
  return SDR_OK;
}

sdr_status sdr_tolerances_choose(sdr_system *system, double stable_step, sdr_tolerances *out)
{
  const sdr_time_scene *how = system->how;
  if (isnan(stable_step)) stable_step = 0.1 * how->end;
  const double half_step = 0.5 * stable_step, apart = how->end / MOMENTS;
  double velocity = scale_of_start(system, half_step);
  for (int n = 0; n <= MOMENTS; ++n) {
    SDR_TRY(scale_of_loads(system, n * apart, half_step, &velocity));
    if (n > 0) SDR_TRY(scale_of_supports(system, n * apart, apart, &velocity));
  }
  velocity = fmax(velocity, 1e-9 * system->model->points->horizon[0] / stable_step);
  *out = (sdr_tolerances){.relative = how->tolerance,
                          .displacement = how->tolerance_displacement,
                          .velocity = how->tolerance_velocity};
  if (isnan(out->velocity)) out->velocity = how->tolerance * velocity;
  if (isnan(out->displacement)) out->displacement = how->tolerance * velocity * 1.5 * stable_step;
  return SDR_OK;
}
