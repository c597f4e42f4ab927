#include "time/midpoint.h"

#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* ---- creation -------------------------------------------------------------------------------- */

void sdr_midpoint_destroy(sdr_midpoint **midpoint)
{
  sdr_midpoint *m = *midpoint;
  if (!m) return;
  sdr_step_solver_destroy(&m->solver);
  for (int a = 0; a < 3; ++a) sdr_free(m->u0[a]);
  sdr_free(m->start);
  sdr_free(m->velocity);
  sdr_free(m->way);
  sdr_free(m->before);
  sdr_free(m->last_way);
  sdr_free(m->internal);
  sdr_free(m->stiffness);
  sdr_free(m->residual);
  sdr_free(m->direction);
  sdr_free(m->trial);
  sdr_free(m->scratch);
  sdr_free(m);
  *midpoint = NULL;
}

static sdr_status alloc_vectors(sdr_midpoint *m)
{
  const sdr_system *system = m->implicit->system;
  const size_t padded = sdr_points_padded(system->model->points);
  double **const whole[] = {&m->start,     &m->velocity,  &m->way,     &m->before,
                            &m->last_way,  &m->internal,  &m->scratch, &m->residual,
                            &m->direction, &m->stiffness, &m->trial};
  for (int a = 0; a < system->components; ++a)
    if (!(m->u0[a] = sdr_alloc(padded, sizeof(double)))) return SDR_RUN_FAILED;
  for (size_t k = 0; k < sizeof whole / sizeof *whole; ++k)
    if (!(*whole[k] = sdr_alloc((size_t)m->implicit->unknowns, sizeof(double))))
      return SDR_RUN_FAILED;
  return SDR_OK;
}

/* The diagonal of the stiffness, with `start` still zero. */
static sdr_status find_stiffness(sdr_midpoint *m)
{
  const sdr_system *system = m->implicit->system;
  const size_t n = (size_t)system->components, count = (size_t)system->count;
  double *block = sdr_alloc(count * n * n, sizeof *block);
  if (!block) return SDR_RUN_FAILED;
  const sdr_status status = system->model->ops->tangent_diagonal(system->model, m->u0, block);
  for (size_t i = 0; status == SDR_OK && i < count; ++i)
    for (size_t a = 0; a < n; ++a) {
      const double own = block[(i * n + a) * n + a], mass = m->implicit->mass[i * n + a];
      m->stiffness[i * n + a] = own;
      if (mass > 0.0) m->most_stiffness = fmax(m->most_stiffness, own / mass);
    }
  sdr_free(block);
  return status;
}

sdr_status sdr_midpoint_create(sdr_implicit *implicit, const char *solver, double tolerance,
                               sdr_midpoint **out)
{
  sdr_midpoint *m = sdr_alloc(1, sizeof *m);
  if (!m) return SDR_RUN_FAILED;
  m->implicit = implicit;
  m->tolerance = tolerance;
  sdr_status status = alloc_vectors(m);
  if (status == SDR_OK) status = find_stiffness(m);
  if (status == SDR_OK) status = sdr_step_solver_create(implicit, solver, &m->solver);
  if (status == SDR_OK)
    *out = m;
  else
    sdr_midpoint_destroy(&m);
  return status;
}

/* ---- residual -------------------------------------------------------------------------------- */

/* What a state of the iteration leaves, over the free components. */
typedef struct {
  double size;  /* |residual| */
  double terms; /* sizes of its terms together */
  double floor; /* what rounding may leave of it */
} leftover;

/* The way of all components from that of the free ones, and the system's u. */
static void place(sdr_midpoint *m)
{
  const sdr_implicit *implicit = m->implicit;
  const sdr_constraints *c = &implicit->constraints;
  double *const u = m->scratch;
  if (c->free < c->unknowns) {
    for (int32_t k = 0; k < c->free; ++k)
      m->residual[k] = m->start[c->unknown[k]] + m->way[c->unknown[k]];
    sdr_constraints_expand(c, m->residual, u);
    for (int32_t k = 0; k < c->free; ++k) u[c->unknown[k]] = NAN; /* keeps its own way */
    for (int32_t r = 0; r < c->unknowns; ++r)
      if (!isnan(u[r])) m->way[r] = u[r] - m->start[r];
  }
  for (int32_t r = 0; r < c->unknowns; ++r) u[r] = m->start[r] + m->way[r];
  sdr_implicit_scatter(implicit, u, implicit->system->u);
}

static double norm(int32_t n, const double *x)
{
  double sum = 0.0;
  for (int32_t k = 0; k < n; ++k) sum += x[k] * x[k];
  return sqrt(sum);
}

/* Rounding is that of the way and of what it would be without forces, with the inertia; and that of
   displacements, whose differences stretch some tens of bonds a point, with the stiffness. */
static leftover sum_up(sdr_midpoint *m, double h, double inertia)
{
  const sdr_implicit *implicit = m->implicit;
  const sdr_constraints *c = &implicit->constraints;
  double kick = 0.0, force = 0.0, load = 0.0, round = 0.0;
  for (int32_t r = 0; r < c->unknowns; ++r) {
    const double mass = inertia * implicit->mass[r], straight = h * m->velocity[r];
    const double own = mass * (m->way[r] - straight);
    const double most = mass * (fabs(m->way[r]) + fabs(straight)) +
                        0.2 * m->stiffness[r] * fabs(m->start[r] + m->way[r]);
    m->scratch[r] = m->internal[r] + implicit->load[r] - own;
    if (implicit->held[r]) continue;
    kick += own * own;
    force += m->internal[r] * m->internal[r];
    load += implicit->load[r] * implicit->load[r];
    round += most * most;
  }
  sdr_constraints_project(c, m->scratch, m->residual);
  return (leftover){norm(c->free, m->residual), sqrt(kick) + sqrt(force) + sqrt(load),
                    DBL_EPSILON * sqrt(round)};
}

static sdr_status evaluate(sdr_midpoint *m, double h, leftover *left)
{
  const sdr_implicit *implicit = m->implicit;
  sdr_system *system = implicit->system;
  place(m);
  SDR_TRY(system->model->ops->mean_keep(system->model, m->u0, system->u, system->f));
  sdr_implicit_gather(implicit, system->f, m->internal);
  *left = sum_up(m, h, 2.0 / (h * h));
  return SDR_OK;
}

static int is_small(const sdr_midpoint *m, const leftover *left)
{
  return left->size <= m->tolerance * left->terms || left->size <= left->floor;
}

/* ---- first guess ----------------------------------------------------------------------------- */

typedef enum { AS_BEFORE, STRAIGHT, SAME_WAY, GUESSES } guess;

/* w = h v0 + h^2/2 (acceleration of the step before), h v0, or the way of the step before. */
static void take_guess(sdr_midpoint *m, guess which, double h)
{
  const int32_t n = m->implicit->unknowns;
  const double ratio = m->last_h > 0.0 ? h / m->last_h : 0.0;
  for (int32_t r = 0; r < n; ++r) {
    const double straight = h * m->velocity[r];
    if (which == SAME_WAY)
      m->way[r] = ratio * m->last_way[r];
    else if (which == AS_BEFORE && m->last_h > 0.0)
      m->way[r] = straight + 0.5 * ratio * h * (m->velocity[r] - m->before[r]);
    else
      m->way[r] = straight;
  }
}

/* The best of them; others than the first only where that is bad. */
static sdr_status choose_guess(sdr_midpoint *m, double h, leftover *left)
{
  guess best = AS_BEFORE, which = AS_BEFORE;
  take_guess(m, best, h);
  SDR_TRY(evaluate(m, h, left));
  if (left->size < 0.1 * left->terms || m->last_h <= 0.0) return SDR_OK;
  for (which = STRAIGHT; which < GUESSES; ++which) {
    leftover other;
    take_guess(m, which, h);
    SDR_TRY(evaluate(m, h, &other));
    if (!(other.size < left->size) && isfinite(left->size)) continue;
    best = which;
    *left = other;
  }
  if (best == GUESSES - 1) return SDR_OK;
  take_guess(m, best, h);
  return evaluate(m, h, left);
}

/* ---- Newton ---------------------------------------------------------------------------------- */

enum { MOST_NEWTON = 15, MOST_HALVINGS = 3, MOST_RISES = 1, FEW_NEWTON = 6, ROUNDING = 20 };

static sdr_status go_part(sdr_midpoint *m, double h, double part, leftover *left)
{
  const sdr_constraints *c = &m->implicit->constraints;
  for (int32_t k = 0; k < c->free; ++k)
    m->way[c->unknown[k]] = m->trial[k] + part * m->direction[k];
  return evaluate(m, h, left);
}

/* Go along the direction, a part of it where the whole does not lessen the residual; the whole if
   no part does, since bonds may stand at a kink, where the residual is no measure (*rises counts).
 */
static sdr_status go(sdr_midpoint *m, double h, leftover *left, int *rises)
{
  const sdr_constraints *c = &m->implicit->constraints;
  const double before = left->size;
  double part = 1.0;
  for (int32_t k = 0; k < c->free; ++k) m->trial[k] = m->way[c->unknown[k]];
  for (int n = 0; n <= MOST_HALVINGS; ++n, part *= 0.5) {
    SDR_TRY(go_part(m, h, part, left));
    if (left->size < (1.0 - 1e-3 * part) * before || is_small(m, left)) return SDR_OK;
  }
  SDR_TRY(go_part(m, h, 1.0, left));
  if (left->size <= ROUNDING * left->floor) left->floor = left->size; /* rounding is all there is */
  ++*rises;
  return SDR_OK;
}

/* How exactly the next direction is worth finding. */
static double aim(const sdr_midpoint *m, const leftover *left)
{
  const double share = left->size / left->terms;
  const double enough = 0.05 * fmax(m->tolerance, left->floor / left->terms) / share;
  return fmin(0.5, fmax(enough, fmin(0.01, share)));
}

static void note_worst(sdr_midpoint *m)
{
  const sdr_constraints *c = &m->implicit->constraints;
  double most = -1.0;
  for (int32_t k = 0; k < c->free; ++k)
    if (!(fabs(m->residual[k]) <= most)) {
      most = fabs(m->residual[k]);
      m->worst = c->unknown[k];
    }
}

/* 1 if a shorter step is likely cheaper than going on. */
static int is_hopeless(const sdr_midpoint *m, const leftover *left, double first, int rises)
{
  return !isfinite(left->size) || rises > MOST_RISES || m->last_newton == MOST_NEWTON ||
         left->size > 10.0 * first || (m->last_newton > FEW_NEWTON && left->size > 1e-3 * first);
}

static sdr_status iterate(sdr_midpoint *m, double h, int renumbered, int *converged)
{
  sdr_system *system = m->implicit->system;
  leftover left;
  const double inertia = 2.0 / (h * h);
  int rises = 0;
  m->last_newton = 0;
  SDR_TRY(choose_guess(m, h, &left));
  const double first = left.size;
  while (!(*converged = is_small(m, &left)) && !is_hopeless(m, &left, first, rises)) {
    double reached = 1.0;
    SDR_TRY(sdr_step_solver_prepare(m->solver, renumbered, m->u0, system->u, inertia,
                                    1.0 + m->most_stiffness / inertia));
    SDR_TRY(sdr_step_solver_solve(m->solver, aim(m, &left), m->residual, m->direction, &reached));
    renumbered = 0;
    ++m->newton;
    ++m->last_newton;
    if (!(reached < 0.9)) break;
    SDR_TRY(go(m, h, &left, &rises));
  }
  m->reached = left.size / left.terms;
  if (!*converged) note_worst(m);
  return SDR_OK;
}

/* Prescribed components go through the step at constant speed. */
static void set_velocities(sdr_midpoint *m, double h)
{
  const sdr_implicit *implicit = m->implicit;
  const sdr_constraints *c = &implicit->constraints;
  sdr_implicit_gather(implicit, implicit->system->v, m->velocity);
  for (int32_t r = 0; r < c->unknowns; ++r)
    if (c->prescribed[r]) m->velocity[r] = (c->offset[r] - m->start[r]) / h;
}

sdr_status sdr_midpoint_solve(sdr_midpoint *m, double h, int renumbered, int *converged)
{
  const sdr_system *system = m->implicit->system;
  const size_t bytes = (size_t)system->count * sizeof(double);
  sdr_implicit_gather(m->implicit, system->u, m->start);
  for (int a = 0; a < system->components; ++a) memcpy(m->u0[a], system->u[a], bytes);
  set_velocities(m, h);
  SDR_TRY(iterate(m, h, renumbered, converged));
  if (*converged) return SDR_OK;
  for (int a = 0; a < system->components; ++a) memcpy(system->u[a], m->u0[a], bytes);
  return SDR_OK;
}

void sdr_midpoint_accept(sdr_midpoint *m, double h)
{
  const size_t bytes = (size_t)m->implicit->unknowns * sizeof(double);
  memcpy(m->before, m->velocity, bytes);
  memcpy(m->last_way, m->way, bytes);
  m->last_h = h;
}
