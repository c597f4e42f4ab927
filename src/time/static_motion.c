/* Where statics has no answer nearby the body moves to one: the trapezoidal rule on M a = f - c M
   v,

     a1 = 4/dt^2 (u1 - u0 - dt v0) - a0,   v1 = 2/dt (u1 - u0) - v0,

   whose u1 is a minimum of the energy of equilibrium.h with springs of 4 M/dt^2 + 2 c M/dt. Of a
   linear body its energy balances exactly: damping takes dt c M |(v0 + v1)/2|^2. Steps that do not
   balance are cut. c is about critical for the slowest oscillation of the body. */
#include "time/static.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

enum { MOST_STEPS = 1000 };

/* Of the largest energy: what a step may miss in its balance; what a body near its equilibrium
   still has to lose. */
static const double most_imbalance = 1e-4, near_rest = 1e-3;

typedef struct {
  sdr_static_work *w;
  double *v, *a, *pull, *target, *total; /* an unknown each */
  double *v1, *a1;
  double damping;            /* 1/s */
  double dt, least, longest; /* s */
  double kinetic;            /* J */
} motion;

static void motion_free(motion *m)
{
  sdr_free(m->v);
  sdr_free(m->a);
  sdr_free(m->v1);
  sdr_free(m->a1);
  sdr_free(m->pull);
  sdr_free(m->target);
  sdr_free(m->total);
}

/* The time in which the stiffest point answers: least sqrt(m/k). */
static double fastest(const sdr_static_work *w)
{
  const sdr_csr *k = sdr_tangent_matrix(w->equilibrium->tangent);
  double least = INFINITY;
  for (int32_t r = 0; r < k->rows; ++r)
    for (int64_t p = k->row[r]; p < k->row[r + 1]; ++p)
      if (k->column[p] == r && k->value[p] > 0.0 && w->implicit->mass[r] > 0.0)
        least = fmin(least, sqrt(w->implicit->mass[r] / k->value[p]));
  return least;
}

/* A support that lets go leaves its points out of balance. */
static void set_first_acceleration(motion *m)
{
  sdr_static_work *w = m->w;
  const sdr_implicit *implicit = w->implicit;
  sdr_implicit_force(w->implicit, w->u, w->equilibrium->internal);
  for (int32_t r = 0; r < implicit->unknowns; ++r)
    if (!implicit->held[r] && implicit->mass[r] > 0.0)
      m->a[r] = (w->equilibrium->internal[r] + implicit->load[r]) / implicit->mass[r];
}

static sdr_status motion_create(sdr_static_work *w, motion *m)
{
  const sdr_system *system = w->implicit->system;
  const size_t unknowns = (size_t)w->implicit->unknowns;
  *m = (motion){.w = w};
  double **const arrays[] = {&m->v, &m->a, &m->v1, &m->a1, &m->pull, &m->target, &m->total};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; ++k)
    if (!(*arrays[k] = sdr_alloc(unknowns, sizeof(double)))) return SDR_RUN_FAILED;
  SDR_TRY(sdr_tangent_update(w->equilibrium->tangent, NULL, w->equilibrium->still));
  const double unit = fastest(w);
  const double across = pow((double)system->count, 1.0 / system->components);
  m->damping = 2.0 / (across * unit);
  m->dt = 4.0 * unit;
  m->least = 1e-3 * unit;
  m->longest = fmax(0.5 / m->damping, m->dt);
  set_first_acceleration(m);
  return SDR_OK;
}

/* Springs for a step of length dt. */
static void set_springs(motion *m)
{
  const double dt = m->dt, inertia = 4.0 / (dt * dt), drag = 2.0 * m->damping / dt;
  for (int32_t r = 0; r < m->w->implicit->unknowns; ++r) {
    const double u = m->w->u[r], whole = inertia + drag;
    m->pull[r] = m->w->implicit->mass[r] * whole;
    m->target[r] =
        u +
        (inertia * (dt * m->v[r] + 0.25 * dt * dt * m->a[r]) + drag * 0.5 * dt * m->v[r]) / whole;
  }
  m->w->equilibrium->pull = m->pull;
  m->w->equilibrium->target = m->target;
  m->w->equilibrium->factored = 0;
}

/* Of w->tried: velocities and accelerations, total force, kinetic energy and what damping takes.
   Prescribed components move in the first step only, without inertia. */
static void look_ahead(motion *m, double *kinetic, double *drag)
{
  const double dt = m->dt;
  const double *mass = m->w->implicit->mass;
  *kinetic = *drag = 0.0;
  for (int32_t r = 0; r < m->w->implicit->unknowns; ++r) {
    const double way = m->w->tried[r] - m->w->u[r];
    if (m->w->implicit->constraints.prescribed[r]) continue;
    m->v1[r] = 2.0 / dt * way - m->v[r];
    m->a1[r] = 4.0 / (dt * dt) * (way - dt * m->v[r]) - m->a[r];
    m->total[r] = mass[r] * (m->a1[r] + m->damping * m->v1[r]);
    *kinetic += 0.5 * mass[r] * m->v1[r] * m->v1[r];
    *drag += 0.5 * m->damping * mass[r] * (m->v[r] + m->v1[r]) * way;
  }
}

static void accept(motion *m, double kinetic, double drag)
{
  sdr_static_work *w = m->w;
  sdr_system *system = w->implicit->system;
  const size_t bytes = (size_t)w->implicit->unknowns * sizeof *m->v;
  sdr_static_take(w, m->total, 0.0);
  system->model->ops->commit(system->model, system->u);
  system->viscous += drag;
  memcpy(m->v, m->v1, bytes);
  memcpy(m->a, m->a1, bytes);
  m->kinetic = kinetic;
}

/* One step; *done = 0 if none was short enough. */
static sdr_status one_step(motion *m, int *done)
{
  sdr_static_work *w = m->w;
  sdr_newton_report report;
  for (*done = 0; !*done && m->dt > m->least;) {
    double kinetic, drag;
    set_springs(m);
    SDR_TRY(sdr_newton_predict(w->newton, w->u, w->tried));
    SDR_TRY(sdr_newton_solve(w->newton, w->tried, &report));
    look_ahead(m, &kinetic, &drag);
    const double excess = sdr_static_excess(w, m->total) + kinetic - m->kinetic + drag;
    *done = report.converged && fabs(excess) <= most_imbalance * w->largest;
    if (*done)
      accept(m, kinetic, drag);
    else
      m->dt *= 0.5;
    if (*done && report.steps <= 6) m->dt = fmin(1.5 * m->dt, m->longest);
  }
  return SDR_OK;
}

/* Is there an equilibrium next to where the body has come? What still separates it from there is
   lost to damping too. */
static sdr_status settle(motion *m, int *rested)
{
  sdr_static_work *w = m->w;
  sdr_newton_report report;
  w->equilibrium->pull = w->equilibrium->target = NULL;
  w->equilibrium->factored = 0;
  memcpy(w->tried, w->u, (size_t)w->implicit->unknowns * sizeof *w->u);
  SDR_TRY(w->method->solve(w->state, w->tried, &report));
  const double excess = report.converged ? sdr_static_excess(w, NULL) : (double)INFINITY;
  *rested = m->kinetic + fabs(excess) <= near_rest * w->largest;
  if (!*rested) return SDR_OK;
  sdr_static_take(w, NULL, 0.0);
  w->implicit->system->viscous += m->kinetic - excess;
  return SDR_OK;
}

static sdr_status run(motion *m, int *rested)
{
  int done = 1;
  *rested = 0;
  for (int k = 0, next = 5; k < MOST_STEPS && done && !*rested; ++k) {
    SDR_TRY(one_step(m, &done));
    if (!done || k < next || m->kinetic > near_rest * m->w->largest) continue;
    SDR_TRY(settle(m, rested));
    next = 2 * k;
  }
  return SDR_OK;
}

sdr_status sdr_static_move(sdr_static_work *work, int *rested)
{
  motion m;
  sdr_status status = motion_create(work, &m);
  work->equilibrium->careful = 1;
  if (status == SDR_OK) status = run(&m, rested);
  work->equilibrium->pull = work->equilibrium->target = NULL;
  work->equilibrium->factored = work->equilibrium->careful = 0;
  motion_free(&m);
  return status;
}
