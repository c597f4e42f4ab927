/* Energy-momentum steps (theory sec. 7): energy, dissipated included, linear and angular momentum
   balance to the solver's tolerance at steps of any length. A step whose equations are not solved
   is cut into halves, which go through it one after the other, each with its own history. */
#include "base/memory.h"
#include "time/integrator.h"
#include "time/midpoint.h"

#include <math.h>
#include <string.h>

enum { MOST_LEVELS = 24, LEAST_PATIENCE = 2, MOST_PATIENCE = 64 };

typedef struct {
  sdr_implicit *implicit;
  sdr_midpoint *midpoint;
  double *force, *total;   /* over all components */
  int level;               /* the step goes in 2^level parts */
  int patience, waited;    /* parts that must succeed before longer ones are tried; that have */
  int constrained;         /* 1: there are supports or layers */
  sdr_solve_record before; /* what had been done when this began */
} work;

static void destroy(void *context)
{
  work *w = context;
  sdr_midpoint_destroy(&w->midpoint);
  sdr_implicit_destroy(&w->implicit);
  sdr_free(w->force);
  sdr_free(w->total);
  sdr_free(w);
}

static sdr_status create(sdr_system *system, work **out)
{
  work *w = sdr_alloc(1, sizeof *w);
  if (!w) return SDR_RUN_FAILED;
  const sdr_time_scene *how = system->how;
  const char *const solver = how && how->solver[0] ? how->solver : "auto";
  const double tolerance = how && how->tolerance > 0.0 ? how->tolerance : 1e-12;
  const size_t unknowns = (size_t)system->count * (size_t)system->components;
  w->patience = LEAST_PATIENCE;
  w->before = system->solve;
  w->constrained = sdr_supports_count(system->supports) > 0 || system->layers;
  w->force = sdr_alloc(unknowns, sizeof *w->force);
  w->total = sdr_alloc(unknowns, sizeof *w->total);
  sdr_status status = w->force && w->total ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) status = sdr_implicit_create(system, &w->implicit);
  if (status == SDR_OK) status = sdr_midpoint_create(w->implicit, solver, tolerance, &w->midpoint);
  if (status == SDR_OK)
    *out = w;
  else
    destroy(w);
  return status;
}

/* ---- forces at the system's time ------------------------------------------------------------- */

/* Loads of time t into the list that implicit steps read. */
static sdr_status take_loads(work *w, double t)
{
  sdr_implicit *implicit = w->implicit;
  const sdr_loads *loads = implicit->system->loads;
  const int m = implicit->system->components;
  SDR_TRY(sdr_loads_evaluate(implicit->system->loads, t));
  for (int32_t k = 0; k < sdr_loads_count(loads); ++k)
    for (int a = 0; a < m; ++a)
      implicit->load[sdr_loads_points(loads)[k] * m + a] = sdr_loads_force(loads, a)[k];
  return SDR_OK;
}

/* The system's f: what acts at its time; on components that constraints touch the mean of the step
   that led here, given in w->total. */
static sdr_status set_force(work *w)
{
  sdr_implicit *implicit = w->implicit;
  sdr_system *system = implicit->system;
  SDR_TRY(take_loads(w, system->time));
  sdr_implicit_gather(implicit, system->u, w->force);
  sdr_implicit_force(implicit, w->force, w->force);
  for (int32_t r = 0; r < implicit->unknowns; ++r)
    w->force[r] = implicit->held[r] ? w->total[r] : w->force[r] + implicit->load[r];
  sdr_implicit_scatter(implicit, w->force, system->f);
  return SDR_OK;
}

/* ---- start ----------------------------------------------------------------------------------- */

static sdr_status renew(sdr_system *system)
{
  work *w = NULL;
  SDR_TRY(create(system, &w));
  if (system->work) system->end_work(system->work);
  system->work = w;
  system->end_work = destroy;
  return SDR_OK;
}

/* Points of layers follow the body. */
static void follow(work *w)
{
  const sdr_implicit *implicit = w->implicit;
  const sdr_constraints *c = &implicit->constraints;
  sdr_system *system = implicit->system;
  if (!system->layers) return;
  sdr_implicit_gather(implicit, system->u, w->force);
  for (int32_t k = 0; k < c->free; ++k) w->total[k] = w->force[c->unknown[k]];
  sdr_constraints_expand(c, w->total, w->force);
  sdr_implicit_scatter(implicit, w->force, system->u);
  memset(w->total, 0, (size_t)c->unknowns * sizeof *w->total);
}

static sdr_status start(sdr_system *system, double dt)
{
  const sdr_model_ops *ops = system->model->ops;
  if (!ops->mean_keep)
    return sdr_fail(SDR_BAD_INPUT,
                    "energy_momentum needs a bond-based body: %s bodies have no mean force of a "
                    "step; take leapfrog or cvode",
                    ops->name);
  SDR_TRY(sdr_system_start(system, dt));
  system->velocity_offset = 0.0;
  SDR_TRY(renew(system));
  follow(system->work);
  ops->commit(system->model, system->u);
  return set_force(system->work);
}

static sdr_status restart(sdr_system *system, double dt)
{
  (void)dt;
  return renew(system);
}

/* ---- books ----------------------------------------------------------------------------------- */

/* Prescribed components take on the step's velocity at its start: a jump, whose impulse and work
   come from outside. */
static void book_jumps(work *w)
{
  const sdr_implicit *implicit = w->implicit;
  sdr_system *system = implicit->system;
  const int m = system->components;
  double *const *x = system->model->points->x;
  for (int32_t r = 0; r < implicit->unknowns; ++r) {
    const int32_t i = r / m;
    const int a = r % m;
    if (!implicit->constraints.prescribed[r] || implicit->mass[r] <= 0.0) continue;
    const double old = system->v[a][i], new = w->midpoint->velocity[r];
    const double impulse = implicit->mass[r] * (new - old);
    system->external_work += 0.5 * impulse * (new + old);
    system->impulse[a] += impulse;
    for (int b = 0; b < m; ++b) { /* e_b times y_b cross e_a impulse */
      if (b == a) continue;
      const int c = 3 - a - b;
      const double sign = (b + 1) % 3 == a ? 1.0 : -1.0;
      system->angular_impulse[c] += sign * (x[b][i] + w->midpoint->start[i * m + b]) * impulse;
    }
  }
}

/* v1 and mass times the step's mean acceleration, from `from` (v0). */
static void accelerations(work *w, double h, const double *from)
{
  const sdr_midpoint *p = w->midpoint;
  for (int32_t r = 0; r < w->implicit->unknowns; ++r) {
    const double end = 2.0 * p->way[r] / h - p->velocity[r];
    w->total[r] = w->implicit->mass[r] * (end - from[r]) / h;
  }
}

static void book_step(work *w, double h)
{
  sdr_midpoint *p = w->midpoint;
  if (w->constrained) book_jumps(w);
  accelerations(w, h, p->velocity);
  sdr_implicit_outside(w->implicit, p->internal, w->total, w->force);
  sdr_implicit_book(w->implicit, p->way, w->force, w->force, h);
  if (!w->constrained) return;
  /* reactions hold what the jump needed too, spread over the step */
  sdr_implicit_gather(w->implicit, w->implicit->system->v, p->scratch);
  accelerations(w, h, p->scratch);
  sdr_implicit_outside(w->implicit, p->internal, w->total, w->force);
}

static void set_velocities(work *w, double h)
{
  const sdr_midpoint *p = w->midpoint;
  sdr_system *system = w->implicit->system;
  for (int32_t i = 0; i < system->count; ++i)
    for (int a = 0; a < system->components; ++a) {
      const int32_t r = i * system->components + a;
      const int follows = w->constrained && w->implicit->mass[r] <= 0.0;
      system->v[a][i] = follows ? p->way[r] / h : 2.0 * p->way[r] / h - p->velocity[r];
    }
}

/* ---- steps ----------------------------------------------------------------------------------- */

/* From the system's time to `end`; *done = 0 if that is too far. */
static sdr_status go_to(work *w, double end, int *done)
{
  sdr_system *system = w->implicit->system;
  const double begin = system->time, h = end - begin;
  int renumbered = 0;
  if (w->constrained) SDR_TRY(sdr_implicit_move(w->implicit, end, &renumbered));
  SDR_TRY(take_loads(w, begin + 0.5 * h));
  SDR_TRY(sdr_midpoint_solve(w->midpoint, h, renumbered, done));
  if (!*done) return SDR_OK;
  book_step(w, h);
  set_velocities(w, h);
  system->model->ops->commit(system->model, system->u);
  system->time = end;
  sdr_implicit_accept(w->implicit);
  sdr_midpoint_accept(w->midpoint, h);
  return SDR_OK;
}

static sdr_status give_up(const work *w, double h)
{
  const sdr_system *system = w->implicit->system;
  const sdr_points *points = system->model->points;
  const int32_t i = w->midpoint->worst / system->components;
  return sdr_fail(SDR_RUN_FAILED,
                  "energy_momentum found no way from t = %.6g s even in steps of %.2g s: forces at "
                  "(%g, %g, %g) m are out of balance by %.1e of all of them; look at the loads and "
                  "the damage there, or take a larger time.tolerance (it is %.1e)",
                  system->time, h, points->x[0][i], points->components > 1 ? points->x[1][i] : 0.0,
                  points->components > 2 ? points->x[2][i] : 0.0, w->midpoint->reached,
                  w->midpoint->tolerance);
}

static void report(const work *w)
{
  sdr_solve_record *solve = &w->implicit->system->solve;
  const sdr_step_solver_report r = sdr_step_solver_report_of(w->midpoint->solver);
  solve->name = r.name;
  solve->unknowns = w->implicit->free;
  solve->nonzeros = r.nonzeros;
  solve->newton = w->before.newton + w->midpoint->newton;
  solve->iterations = w->before.iterations + r.iterations;
  solve->factorisations = w->before.factorisations + r.factorisations;
  solve->bytes = fmax(w->before.bytes, r.bytes);
  solve->residual = w->midpoint->reached;
  solve->factor_seconds = w->before.factor_seconds + r.prepare_s;
  solve->solve_seconds = w->before.solve_seconds + r.solve_s;
}

/* A part of the step has been gone: try longer ones after a while. */
static void lengthen(work *w, int64_t *part)
{
  ++*part;
  ++w->implicit->system->solve.accepted;
  if (w->level == 0 || ++w->waited < w->patience || *part % 2 != 0) return;
  --w->level;
  *part /= 2;
  w->waited = 0;
}

/* It was too long. One that was tried after a while was tried too soon. */
static void shorten(work *w, int64_t *part)
{
  ++w->implicit->system->solve.cuts;
  w->patience = w->waited == 0 && w->patience < MOST_PATIENCE ? 2 * w->patience : w->patience;
  w->waited = 0;
  ++w->level;
  *part *= 2;
}

static sdr_status step(sdr_system *system, double dt)
{
  work *w = system->work;
  int64_t part = 0; /* of 2^level */
  while (part < (int64_t)1 << w->level) {
    const double share = (double)(part + 1) / (double)((int64_t)1 << w->level);
    int done;
    SDR_TRY(go_to(w, ((double)system->step + share) * dt, &done));
    if (!done && w->level == MOST_LEVELS) return give_up(w, ldexp(dt, -w->level));
    if (done)
      lengthen(w, &part);
    else
      shorten(w, &part);
  }
  ++system->step;
  system->time = (double)system->step * dt;
  report(w);
  return set_force(w);
}

const sdr_integrator sdr_energy_momentum = {
    .name = "energy_momentum",
    .doc = "implicit, second order, balances energy and momenta at steps of any length",
    .start = start,
    .step = step,
    .restart = restart,
    .reach = 5.0};
