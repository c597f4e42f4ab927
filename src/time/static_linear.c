/* The linear static solution (theory sec. 7): one tangent K at u = 0, one factorisation. With the
   motion u = a + B q of supports and layers at the end of the run and the loads f there,

     P^T K B q = P^T (f - K a),   R = K u - f at the prescribed components.

   The books take loads and prescribed motion as grown together from zero, so that the work done is
   half of what they do in the end. */
#include "base/memory.h"
#include "geometry/text.h"
#include "linalg/solver.h"
#include "mechanics/constraints.h"
#include "mechanics/tangent.h"
#include "time/integrator.h"
#include "time/rigid.h"

#include <math.h>
#include <string.h>
#include <time.h>

typedef struct {
  sdr_system *system;
  int32_t unknowns;
  sdr_csr stiffness, reduced;
  sdr_slaves slaves;
  sdr_constraints constraints;
  double *load, *u, *force; /* unknowns each; force = K u */
  double *right, *q;        /* free ones */
} problem;

static void problem_destroy(problem *p)
{
  sdr_csr_destroy(&p->stiffness);
  sdr_csr_destroy(&p->reduced);
  sdr_slaves_destroy(&p->slaves);
  sdr_constraints_destroy(&p->constraints);
  sdr_free(p->load);
  sdr_free(p->u);
  sdr_free(p->force);
  sdr_free(p->right);
  sdr_free(p->q);
}

static double wall(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- setting up ------------------------------------------------------------------------------ */

static sdr_status refuse_velocity(const sdr_system *system, const sdr_prescribed *entry)
{
  const sdr_points *points = system->model->points;
  char text[SDR_PLACE_TEXT];
  double x[3] = {0.0};
  for (int a = 0; a < points->components; ++a) x[a] = points->x[a][entry->point];
  return sdr_fail(SDR_BAD_INPUT,
                  "a support prescribes a velocity at the point at %s, but nothing moves in a "
                  "static solution; give its displacement at time.end",
                  sdr_place_text(x, points->components, text));
}

static sdr_status constrain(problem *p)
{
  sdr_system *system = p->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  SDR_TRY(sdr_supports_values(system->supports, system->time, system->motion));
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    if (list[k].is_velocity && !isnan(system->motion[k])) return refuse_velocity(system, &list[k]);
  if (system->layers) {
    SDR_TRY(sdr_layers_values(system->layers, system->time));
    SDR_TRY(sdr_layers_slaves(system->layers, &p->slaves));
  }
  SDR_TRY(sdr_slaves_of_means(system->supports, system->motion, system->model->points, &p->slaves));
  return sdr_constraints_create(system->model->points, system->supports, system->motion,
                                p->slaves.count > 0 ? &p->slaves : NULL, &p->constraints);
}

static sdr_status hold(problem *p)
{
  SDR_TRY(constrain(p));
  if (p->slaves.count > 0) return SDR_OK;
  return sdr_rigid_held(p->system->model->points, p->constraints.prescribed);
}

static sdr_status take_loads(problem *p)
{
  sdr_system *system = p->system;
  const int m = system->components;
  const int32_t *points = sdr_loads_points(system->loads);
  SDR_TRY(sdr_loads_evaluate(system->loads, system->time));
  for (int32_t k = 0; k < sdr_loads_count(system->loads); ++k)
    for (int a = 0; a < m; ++a) {
      system->load_before[a][k] = sdr_loads_force(system->loads, a)[k];
      p->load[points[k] * m + a] += system->load_before[a][k];
    }
  return SDR_OK;
}

static sdr_status assemble(problem *p)
{
  sdr_system *system = p->system;
  const sdr_model_ops *ops = system->model->ops;
  if (!ops->visit_hessian)
    return sdr_fail(SDR_BAD_INPUT,
                    "time.integrator: a %s body has no static solution in this "
                    "version; take leapfrog",
                    ops->name);
  for (int a = 0; a < system->components; ++a)
    memset(system->u[a], 0, (size_t)system->count * sizeof(double));
  return sdr_tangent_assemble(system->model, system->u, &p->stiffness);
}

/* right = P^T (f - K a) */
static sdr_status make_right_side(problem *p)
{
  const sdr_constraints *c = &p->constraints;
  p->right = sdr_alloc((size_t)c->free, sizeof(double));
  p->q = sdr_alloc((size_t)c->free, sizeof(double));
  if (!p->right || !p->q) return SDR_RUN_FAILED;
  sdr_csr_times(&p->stiffness, c->offset, p->force);
  for (int32_t k = 0; k < p->unknowns; ++k) p->u[k] = p->load[k] - p->force[k];
  sdr_constraints_project(c, p->u, p->right);
  return SDR_OK;
}

static sdr_status set_up(problem *p)
{
  const size_t unknowns = (size_t)p->unknowns;
  p->load = sdr_alloc(unknowns, sizeof(double));
  p->u = sdr_alloc(unknowns, sizeof(double));
  p->force = sdr_alloc(unknowns, sizeof(double));
  if (!p->load || !p->u || !p->force) return SDR_RUN_FAILED;
  const double from = wall();
  SDR_TRY(hold(p));
  SDR_TRY(take_loads(p));
  SDR_TRY(assemble(p));
  SDR_TRY(make_right_side(p));
  SDR_TRY(sdr_constraints_reduce(&p->constraints, &p->stiffness, &p->reduced));
  sdr_csr_destroy(&p->stiffness); /* make room for the factor */
  p->system->solve.assemble_seconds = wall() - from;
  return SDR_OK;
}

/* ---- solving --------------------------------------------------------------------------------- */

/* Name the component that nothing holds. */
static sdr_status explain(const problem *p, int32_t row)
{
  const sdr_points *points = p->system->model->points;
  const int m = points->components;
  char text[SDR_PLACE_TEXT];
  double x[3] = {0.0};
  if (row < 0)
    return sdr_fail(SDR_RUN_FAILED,
                    "the body has no static solution: %s; give supports that keep the body, and "
                    "every part of it, from moving and turning",
                    sdr_error_message());
  const int32_t unknown = p->constraints.unknown[row];
  for (int a = 0; a < m; ++a) x[a] = points->x[a][unknown / m];
  return sdr_fail(
      SDR_RUN_FAILED,
      "the stiffness is singular: the point at %s can move freely along %c; give supports that "
      "keep the body, and every part of it, from moving and turning",
      sdr_place_text(x, m, text), "xyz"[unknown % m]);
}

/* A stiffness is positive; LU takes it as symmetric, so that it solves with one that is not. */
static sdr_matrix_kind kind_of(const problem *p, const char *solver)
{
  if (!p->constraints.symmetric) return SDR_MATRIX_GENERAL;
  const int direct_lu = strcmp(solver, "umfpack") == 0 || strcmp(solver, "klu") == 0;
  return direct_lu ? SDR_MATRIX_SYMMETRIC : SDR_MATRIX_POSITIVE;
}

static sdr_status factor_and_solve(problem *p, sdr_solver *solver)
{
  sdr_solve_record *record = &p->system->solve;
  const double from = wall();
  sdr_status status = sdr_solver_factor(solver, &p->reduced);
  const double factored = wall();
  if (status == SDR_OK) status = sdr_solver_solve(solver, p->right, p->q);
  const sdr_solver_report report = sdr_solver_report_of(solver);
  if (status == SDR_OK) {
    record->name = report.name;
    record->unknowns = p->constraints.free;
    record->nonzeros = p->reduced.row[p->reduced.rows];
    record->factor_seconds = factored - from;
    record->solve_seconds = wall() - factored;
    record->bytes = report.bytes;
    record->iterations = report.iterations;
    record->residual = report.residual;
    return SDR_OK;
  }
  const int singular = report.singular || report.residual > 1e-6;
  return singular ? explain(p, report.singular_row) : status;
}

static sdr_status solve(problem *p)
{
  const sdr_time_scene *how = p->system->how;
  const char *name = how && how->solver[0] ? how->solver : "auto";
  sdr_solver *solver = NULL;
  SDR_TRY(sdr_solver_create(name, kind_of(p, name), &solver));
  const sdr_status status = factor_and_solve(p, solver);
  sdr_solver_destroy(&solver);
  return status;
}

/* ---- the solved state ------------------------------------------------------------------------ */

/* force = K u. The matrix is gone: the model multiplies, at rest and with u for a velocity. */
static sdr_status find_force(problem *p)
{
  sdr_system *system = p->system;
  const int m = system->components;
  for (int32_t i = 0; i < system->count; ++i)
    for (int a = 0; a < m; ++a) system->v[a][i] = p->u[i * m + a];
  SDR_TRY(system->model->ops->tangent_times(system->model, system->u, system->v, system->f));
  for (int32_t i = 0; i < system->count; ++i)
    for (int a = 0; a < m; ++a) p->force[i * m + a] = system->f[a][i];
  return SDR_OK;
}

/* u = a + B q, and how far the bent body's own forces are from the linear K u. */
static sdr_status show(problem *p)
{
  sdr_system *system = p->system;
  const int m = system->components;
  double apart = 0.0, whole = 0.0;
  sdr_constraints_expand(&p->constraints, p->q, p->u);
  SDR_TRY(find_force(p));
  for (int32_t i = 0; i < system->count; ++i)
    for (int a = 0; a < m; ++a) system->u[a][i] = p->u[i * m + a];
  system->model->ops->force(system->model, system->u, system->f);
  for (int32_t i = 0; i < system->count; ++i)
    for (int a = 0; a < m; ++a) {
      const double linear = p->force[i * m + a], difference = system->f[a][i] + linear;
      apart += difference * difference;
      whole += linear * linear;
    }
  system->solve.nonlinearity = whole > 0.0 ? sqrt(apart / whole) : 0.0;
  return SDR_OK;
}

/* Total forces, zero but for rounding: the body's and its layers', the loads, the reactions. */
static void balance(problem *p)
{
  sdr_system *system = p->system;
  const int m = system->components;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int32_t i = 0; i < system->count; ++i)
    for (int a = 0; a < m; ++a) {
      system->v[a][i] = 0.0;
      system->f[a][i] = -p->force[i * m + a];
    }
  if (system->layers) sdr_layers_pull(system->layers, system->f);
  for (int32_t i = 0; i < system->count; ++i)
    for (int a = 0; a < m; ++a) system->f[a][i] += p->load[i * m + a];
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    const int a = list[k].component;
    const int acts = !isnan(system->motion[k]);
    system->reaction[k] = acts ? -system->f[a][list[k].point] : 0.0;
    if (acts) system->f[a][list[k].point] = 0.0;
  }
}

/* Loads, and what holds the components that are not free, grown from zero: 1/2 (f + R).u. Layers
   pull on free points too; with them it is 1/2 u.K u, what is left at free ones included. */
static void book(problem *p)
{
  const sdr_constraints *c = &p->constraints;
  double work = 0.0;
  int32_t next = 0; /* the next free unknown in c->unknown */
  for (int32_t k = 0; k < p->unknowns; ++k) {
    const int is_free = next < c->free && c->unknown[next] == k;
    next += is_free;
    work += (is_free && p->slaves.count == 0 ? p->load[k] : p->force[k]) * p->u[k];
  }
  p->system->external_work += 0.5 * work;
}

static sdr_status step(sdr_system *system, double dt)
{
  problem p = {.system = system, .unknowns = system->count * system->components};
  system->time = dt;
  ++system->step;
  sdr_status status = set_up(&p);
  if (status == SDR_OK) status = solve(&p);
  if (status == SDR_OK) status = show(&p);
  if (status == SDR_OK) {
    balance(&p);
    book(&p);
  }
  problem_destroy(&p);
  return status;
}

static sdr_status held(sdr_system *system, double dt)
{
  problem p = {.system = system, .unknowns = system->count * system->components};
  const double now = system->time;
  system->time = dt;
  const sdr_status status = hold(&p);
  system->time = now;
  problem_destroy(&p);
  return status;
}

/* Before the loads: the reference shape at rest. */
static sdr_status start(sdr_system *system, double dt)
{
  (void)dt;
  for (int a = 0; a < system->components; ++a) {
    const size_t bytes = (size_t)system->count * sizeof(double);
    memset(system->u[a], 0, bytes);
    memset(system->v[a], 0, bytes);
    memset(system->f[a], 0, bytes);
  }
  system->velocity_offset = 0.0;
  return SDR_OK;
}

const sdr_integrator sdr_static_linear = {
    .name = "static_linear",
    .doc = "the linear static solution under the loads at the end",
    .start = start,
    .held = held,
    .step = step,
    .is_static = 1};
