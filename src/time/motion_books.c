/* What loads, supports and layers bring from outside. */
#include "time/motion_internal.h"

#include <math.h>
#include <string.h>

int sdr_motion_driven(const sdr_motion *motion)
{
  const sdr_system *system = motion->implicit->system;
  return sdr_loads_count(system->loads) > 0 || sdr_supports_count(system->supports) > 0 ||
         system->layers != NULL;
}

/* Add a force on component a of point i that does work at `velocity` to the rates. */
static void add_force(const sdr_system *system, int32_t i, int a, double force, double velocity,
                      double rates[SDR_MOTION_RATES])
{
  double x[3] = {0.0};
  for (int c = 0; c < system->components; ++c)
    x[c] = system->model->points->x[c][i] + system->u[c][i];
  const int b = (a + 1) % 3, c = (a + 2) % 3;
  rates[0] += force * velocity;
  rates[1 + a] += force;
  rates[4 + b] += x[c] * force;
  rates[4 + c] -= x[b] * force;
}

static void add_loads(const sdr_motion *m, double rates[SDR_MOTION_RATES])
{
  const sdr_system *system = m->implicit->system;
  const int32_t *loaded = sdr_loads_points(system->loads);
  const uint8_t *prescribed = sdr_motion_constraints(m)->prescribed;
  for (int32_t k = 0; k < sdr_loads_count(system->loads); ++k)
    for (int a = 0; a < system->components; ++a) {
      if (prescribed[loaded[k] * system->components + a]) continue; /* the support bears it */
      add_force(system, loaded[k], a, sdr_loads_force(system->loads, a)[k], system->v[a][loaded[k]],
                rates);
    }
}

/* A support balances the model's force; what the prescribed mass takes up is a difference of
   states, but for the part of its moment that turns with it: d(x cross m v) = x cross F dt + v
   cross m v dt.
 */
static void add_supports(const sdr_motion *m, double rates[SDR_MOTION_RATES])
{
  const sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    const int a = list[k].component, b = (a + 1) % 3, c = (a + 2) % 3;
    const int32_t i = list[k].point;
    if (isnan(m->position[k])) continue;
    if (list[k].mean >= 0) {
      add_force(system, i, a, m->mean_pull[list[k].mean], system->v[a][i], rates);
      continue;
    }
    double v[3] = {0.0};
    for (int n = 0; n < system->components; ++n) v[n] = system->v[n][i];
    add_force(system, i, a, -system->f[a][i], m->rate[k], rates);
    rates[4 + b] -= system->mass[i] * v[c] * v[a];
    rates[4 + c] += system->mass[i] * v[b] * v[a];
  }
}

/* What layers hand on comes from outside, and so does what keeps them on their way. Where a support
   prescribes the point that is handed something, it bears that. */
static void add_layers(const sdr_motion *m, double rates[SDR_MOTION_RATES])
{
  const sdr_system *system = m->implicit->system;
  const int components = system->components;
  const int32_t *touched = sdr_layers_touched(system->layers);
  for (int32_t k = 0; k < sdr_layers_touched_count(system->layers); ++k)
    for (int a = 0; a < components; ++a) {
      const int32_t i = touched[k];
      const double change = system->f[a][i] - m->raw[k * components + a];
      add_force(system, i, a, change, system->v[a][i], rates);
    }
}

sdr_status sdr_motion_outside(sdr_motion *motion, double t, const double *w,
                              double rates[SDR_MOTION_RATES])
{
  sdr_system *system = motion->implicit->system;
  memset(rates, 0, SDR_MOTION_RATES * sizeof *rates);
  SDR_TRY(sdr_motion_find_rates(motion, t));
  sdr_motion_spread(motion, w, system->v);
  sdr_motion_put_velocities(motion);
  add_loads(motion, rates);
  add_supports(motion, rates);
  if (system->layers) add_layers(motion, rates);
  return SDR_OK;
}

/* What prescribed components hold of kinetic energy and momenta. */
void sdr_motion_sum_held(const sdr_motion *m, double sum[SDR_MOTION_RATES])
{
  const sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  memset(sum, 0, SDR_MOTION_RATES * sizeof *sum);
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    if (isnan(m->position[k]) || list[k].mean >= 0) continue;
    const double p = system->mass[list[k].point] * m->rate[k];
    add_force(system, list[k].point, list[k].component, p, 0.5 * m->rate[k], sum);
  }
}

/* Into the system's books. */
void sdr_motion_book(sdr_system *system, const double change[SDR_MOTION_RATES])
{
  system->external_work += change[0];
  for (int a = 0; a < 3; ++a) {
    system->impulse[a] += change[1 + a];
    system->angular_impulse[a] += change[4 + a];
  }
}

void sdr_motion_sum_body(sdr_system *system, double sum[SDR_MOTION_RATES])
{
  sdr_balance balance;
  sdr_system_balance(system, &balance);
  sum[0] = balance.kinetic + balance.model.stored + balance.model.dissipated;
  for (int a = 0; a < 3; ++a) {
    sum[1 + a] = balance.momentum[a];
    sum[4 + a] = balance.angular[a];
  }
}
