/* Leapfrog (velocity Verlet): v(n+1/2) = v(n-1/2) + dt a(n), u(n+1) = u(n) + dt v(n+1/2). The
   system keeps the velocity of half a step ago; at the system's time it is v + dt/2 a. */
#include "base/parallel.h"
#include "mechanics/motion.h"
#include "time/integrator.h"

#include <math.h>

/* From u and v at the system's time. */
static sdr_status begin(sdr_system *system, double dt)
{
  system->velocity_offset = 0.0;
  SDR_TRY(sdr_system_force(system, 0.0, dt, 0.5 * dt));
  for (int a = 0; a < system->components; ++a)
    for (int32_t i = 0; i < system->count; ++i)
      system->v[a][i] -= 0.5 * dt * system->f[a][i] / system->mass[i];
  system->velocity_offset = -0.5 * dt;
  return SDR_OK;
}

static sdr_status start(sdr_system *system, double dt)
{
  SDR_TRY(sdr_system_start(system, dt));
  return begin(system, dt);
}

typedef struct {
  const sdr_system *system;
  const sdr_motion_kernels *kernels;
  double dt;
  int failed[256]; /* a stripe: 1 if a point of it flew off */
} move_call;

/* No point of a sound run moves by a horizon in one step; one that is not a number fails as well.
 */
static int flew_off(const sdr_system *system, int32_t i, double dt)
{
  double square = 0.0;
  for (int a = 0; a < system->components; ++a) {
    const double way = dt * system->v[a][i];
    square += way * way;
  }
  const double horizon = system->model->points->horizon[i];
  return !(square < horizon * horizon);
}

static void move_stripe(void *context, int s)
{
  move_call *call = context;
  const sdr_system *system = call->system;
  const sdr_points *points = system->model->points;
  const double dt = call->dt, *const mass = system->mass;
  const int32_t first = points->stripe_first[s], end = points->stripe_first[s + 1];
  const double far = points->horizon[first] / dt;
  int suspect = 0;
  for (int a = 0; a < system->components; ++a)
    suspect |= call->kernels->move(end - first, dt, 0.5 * far, mass + first, system->f[a] + first,
                                   system->v[a] + first, system->u[a] + first);
  for (int32_t i = first; suspect && i < end; ++i)
    if (flew_off(system, i, dt)) call->failed[s] = 1;
}

static sdr_status report_blow_up(const sdr_system *system, const move_call *call)
{
  const sdr_points *points = system->model->points;
  for (int s = 0; s < points->stripe_count; ++s)
    for (int32_t i = points->stripe_first[s]; call->failed[s] && i < points->stripe_first[s + 1];
         ++i) {
      if (!flew_off(system, i, call->dt)) continue;
      return sdr_fail(
          SDR_RUN_FAILED,
          "the run blew up at t = %.6g s (step %lld): the point at (%g, %g, %g) m would "
          "move by a horizon or more in one step; take a smaller time.step, or look at "
          "the loads there",
          system->time, (long long)system->step, points->x[0][i],
          points->components > 1 ? points->x[1][i] : 0.0,
          points->components > 2 ? points->x[2][i] : 0.0);
    }
  return SDR_OK;
}

static sdr_status step(sdr_system *system, double dt)
{
  move_call call = {.system = system, .kernels = sdr_motion_kernels_best(), .dt = dt};
  sdr_parallel_for(0, system->model->points->stripe_count, 1, move_stripe, &call);
  ++system->step;
  system->time = system->time_since + (double)(system->step - system->step_since) * dt;
  SDR_TRY(report_blow_up(system, &call));
  return sdr_system_force(system, dt, dt, dt);
}

static sdr_status restart(sdr_system *system, double dt)
{
  (void)dt;
  return system->contact ? sdr_contact_restart(system->contact, system->u) : SDR_OK;
}

const sdr_integrator sdr_leapfrog = {
    .name = "leapfrog",
    .doc = "explicit, second order, conserves momenta exactly; for waves and fracture",
    .start = start,
    .begin = begin,
    .step = step,
    .restart = restart,
    .is_explicit = 1};
