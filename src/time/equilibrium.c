#include "time/equilibrium.h"

#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* ---- making ---------------------------------------------------------------------------------- */

static sdr_status allocate(sdr_equilibrium *e)
{
  const sdr_system *system = e->implicit->system;
  const size_t unknowns = (size_t)e->implicit->unknowns;
  const size_t padded = sdr_points_padded(system->model->points);
  e->internal = sdr_alloc(unknowns, sizeof *e->internal);
  e->wide = sdr_alloc(unknowns, sizeof *e->wide);
  e->wider = sdr_alloc(unknowns, sizeof *e->wider);
  double *still = sdr_alloc(padded, sizeof *still);
  for (int a = 0; a < system->components; ++a) e->still[a] = still;
  return e->internal && e->wide && e->wider && still ? SDR_OK : SDR_RUN_FAILED;
}

sdr_status sdr_equilibrium_create(sdr_implicit *implicit, const char *solver, sdr_equilibrium **out)
{
  sdr_model *model = implicit->system->model;
  sdr_equilibrium *e = sdr_alloc(1, sizeof *e);
  if (!e) return SDR_RUN_FAILED;
  e->implicit = implicit;
  sdr_status status = allocate(e);
  if (status == SDR_OK) status = sdr_tangent_create(model, SDR_TANGENT_EXACT, &e->tangent);
  if (status == SDR_OK && model->ops->visit_secant)
    status = sdr_tangent_create(model, SDR_TANGENT_SECANT, &e->secant);
  if (status == SDR_OK)
    status =
        sdr_reduction_create(sdr_tangent_matrix(e->secant ? e->secant : e->tangent), &e->reduction);
  if (status == SDR_OK) status = sdr_mean_border_create(&e->border);
  if (status == SDR_OK) status = sdr_solver_create(solver, SDR_MATRIX_POSITIVE, &e->solver);
  if (status == SDR_OK)
    *out = e;
  else
    sdr_equilibrium_destroy(&e);
  return status;
}

void sdr_equilibrium_destroy(sdr_equilibrium **equilibrium)
{
  sdr_equilibrium *e = *equilibrium;
  if (!e) return;
  sdr_solver_destroy(&e->solver);
  sdr_reduction_destroy(&e->reduction);
  sdr_mean_border_destroy(&e->border);
  sdr_tangent_destroy(&e->tangent);
  sdr_tangent_destroy(&e->secant);
  sdr_free(e->internal);
  sdr_free(e->wide);
  sdr_free(e->wider);
  sdr_free(e->still[0]);
  sdr_free(e);
  *equilibrium = NULL;
}

void sdr_equilibrium_renumber(sdr_equilibrium *equilibrium)
{
  equilibrium->factored = 0;
}

/* ---- energy and its gradient ----------------------------------------------------------------- */

double sdr_equilibrium_energy(sdr_equilibrium *e, const double *u, double *size)
{
  const sdr_implicit *implicit = e->implicit;
  sdr_system *system = implicit->system;
  sdr_energies energies;
  double work = 0.0, springs = 0.0, work_size = 0.0;
  sdr_implicit_scatter(implicit, u, system->u);
  system->model->ops->energies(system->model, system->u, &energies);
  for (int32_t r = 0; r < implicit->unknowns; ++r) {
    const double here = implicit->load[r] * u[r];
    work += here;
    work_size += fabs(here);
  }
  for (int32_t r = 0; e->pull && r < implicit->unknowns; ++r)
    springs += 0.5 * e->pull[r] * (u[r] - e->target[r]) * (u[r] - e->target[r]);
  *size = energies.stored + energies.dissipated + work_size + springs;
  return energies.stored + energies.dissipated - work + springs;
}

/* Loads, and on held components what the body pulls with. */
static double outside_squared(const sdr_equilibrium *e)
{
  const sdr_implicit *implicit = e->implicit;
  double sum = 0.0;
  for (int32_t r = 0; r < implicit->unknowns; ++r) {
    const double force = implicit->held[r] ? e->internal[r] : implicit->load[r];
    sum += force * force;
  }
  return sum;
}

double sdr_equilibrium_gradient(sdr_equilibrium *e, const double *u, double *gradient)
{
  sdr_implicit *implicit = e->implicit;
  double most = 0.0;
  sdr_implicit_force(implicit, u, e->internal);
  for (int32_t r = 0; r < implicit->unknowns; ++r) {
    e->wide[r] = -e->internal[r] - implicit->load[r];
    if (e->pull) e->wide[r] += e->pull[r] * (u[r] - e->target[r]);
    if (fabs(u[r]) > most) most = fabs(u[r]);
  }
  /* each force is known to some DBL_EPSILON of its largest terms, stiffness times displacement */
  e->rounding = 4.0 * DBL_EPSILON * most * e->stiffest * sqrt((double)implicit->unknowns);
  sdr_constraints_project(&implicit->constraints, e->wide, gradient);
  e->scale = sqrt(outside_squared(e));
  e->largest = fmax(e->largest, e->scale);
  return sqrt(sdr_equilibrium_dot(e, gradient, gradient));
}

double sdr_equilibrium_tolerance(const sdr_equilibrium *e)
{
  return fmax(1e-6 * fmax(e->scale, 1e-4 * e->largest), fmin(e->rounding, 1e-4 * e->scale));
}

/* ---- matrices -------------------------------------------------------------------------------- */

sdr_status sdr_equilibrium_linearise(sdr_equilibrium *e, const double *u, int secant)
{
  sdr_system *system = e->implicit->system;
  sdr_tangent *tangent = secant && e->secant ? e->secant : e->tangent;
  sdr_implicit_scatter(e->implicit, u, system->u);
  SDR_TRY(sdr_tangent_update(tangent, NULL, system->u));
  e->matrix = sdr_tangent_matrix(tangent);
  return SDR_OK;
}

void sdr_equilibrium_times(sdr_equilibrium *e, const double *p, double *out)
{
  const sdr_constraints *c = &e->implicit->constraints;
  sdr_csr_times(&c->map, p, e->wide);
  sdr_csr_times(e->matrix, e->wide, e->wider);
  for (int32_t r = 0; e->pull && r < c->unknowns; ++r) e->wider[r] += e->pull[r] * e->wide[r];
  sdr_constraints_project(c, e->wider, out);
}

/* The springs, and a trace of the stiffness that keeps pieces that have come loose from making the
   matrix singular. */
static void set_shift(sdr_equilibrium *e)
{
  const sdr_csr *k = e->matrix;
  double most = 0.0;
  for (int32_t r = 0; r < k->rows; ++r)
    for (int64_t p = k->row[r]; p < k->row[r + 1]; ++p)
      if (k->column[p] == r && k->value[p] > most) most = k->value[p];
  e->stiffest = fmax(e->stiffest, most);
  for (int32_t r = 0; r < k->rows; ++r)
    e->wide[r] = 1e-9 * e->stiffest + (e->pull ? e->pull[r] : 0.0);
}

/* What was assembled last, of the tangent that the reduction knows, as it is to be factored;
 *renewed = 1: entries stand in other places than before. */
static sdr_status prepare_matrix(sdr_equilibrium *e, int *renewed)
{
  SDR_TRY(sdr_mean_border_take(e->border, e->implicit));
  const sdr_constraints *open = sdr_mean_border_open(e->border);
  SDR_TRY(sdr_reduction_update(e->reduction, open, renewed));
  set_shift(e);
  sdr_mean_border_add_springs(e->border, e->stiffest, e->wide);
  sdr_reduction_add_diagonal(e->reduction, open, e->wide);
  return SDR_OK;
}

static sdr_status factor_matrix(sdr_equilibrium *e, int renewed)
{
  const sdr_csr *reduced = sdr_reduction_matrix(e->reduction);
  ++e->implicit->system->solve.factorisations;
  const int again = e->factored && !renewed;
  e->factored = 0;
  SDR_TRY(again ? sdr_solver_refactor(e->solver, reduced) : sdr_solver_factor(e->solver, reduced));
  SDR_TRY(sdr_mean_border_factor(e->border, e->solver));
  e->factored = 1;
  return SDR_OK;
}

sdr_status sdr_equilibrium_factor(sdr_equilibrium *e, const double *u)
{
  int renewed;
  if (e->secant) {
    SDR_TRY(sdr_equilibrium_linearise(e, u, 1));
    SDR_TRY(prepare_matrix(e, &renewed));
    const sdr_status status = factor_matrix(e, renewed);
    if (status == SDR_OK || !sdr_solver_report_of(e->solver).singular) return status;
  }
  sdr_tangent *tangent = e->secant ? e->secant : e->tangent;
  SDR_TRY(sdr_tangent_update(tangent, NULL, e->still));
  e->matrix = sdr_tangent_matrix(tangent);
  SDR_TRY(prepare_matrix(e, &renewed));
  return factor_matrix(e, renewed);
}

sdr_status sdr_equilibrium_precondition(sdr_equilibrium *e, const double *r, double *z)
{
  ++e->implicit->system->solve.iterations;
  return sdr_mean_border_solve(e->border, e->solver, r, z);
}

double sdr_equilibrium_dot(const sdr_equilibrium *e, const double *x, const double *y)
{
  double sum = 0.0;
  for (int32_t k = 0; k < e->implicit->free; ++k) sum += x[k] * y[k];
  return sum;
}
