#include "linalg/solver.h"

#include "base/memory.h"
#include "linalg/solver_ops.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const sdr_solver_ops *const table[] = {&sdr_solver_cholmod, &sdr_solver_klu,
                                              &sdr_solver_umfpack, &sdr_solver_pcg};
static const char *const kind_names[] = {"symmetric positive definite", "symmetric", "general"};

struct sdr_solver {
  const sdr_solver_ops *ops; /* NULL: chosen at the first factor */
  int automatic;
  sdr_matrix_kind kind;
  const sdr_csr *matrix; /* NULL: none is factored */
  int32_t rows;          /* of the matrix that state knows */
  void *state;
  double *residual, *correction;
  sdr_solver_report report;
};

/* ---- choice ---------------------------------------------------------------------------------- */

static const sdr_solver_ops *find(const char *name)
{
  for (size_t k = 0; k < sizeof table / sizeof *table; ++k)
    if (strcmp(table[k]->name, name) == 0) return table[k];
  return NULL;
}

/* Products that conjugate gradients take, roughly: they grow with the points across a body, so more
   in a plane, whose points have two components or one, than in space (50,000 points of a
   state-based plate took 1000, 30,000 of a bar in space 243). */
static sdr_status guess_products(const sdr_csr *matrix, double *products)
{
  sdr_csr_groups groups;
  SDR_TRY(sdr_csr_groups_find(matrix, &groups));
  *products = matrix->rows > 2.5 * groups.count ? 300.0 : 1000.0;
  sdr_csr_groups_destroy(&groups);
  return SDR_OK;
}

/* Iterate where a factor would take far longer than the products, or more than 8 GB: at 1.5e10
   flops a second, and 1e9 for products that stream the matrix. So 3-D bodies from some 10,000
   points on, 2-D ones beyond a million. */
static sdr_status choose(sdr_solver *solver, const sdr_csr *matrix)
{
  double flops = 0.0, nonzeros = 0.0;
  solver->ops = &sdr_solver_umfpack;
  if (solver->kind != SDR_MATRIX_POSITIVE) return SDR_OK;
  solver->ops = &sdr_solver_cholmod;
  if (matrix->rows == 0) return SDR_OK;
  SDR_TRY(sdr_cholmod_analyse(matrix, &solver->state, &flops, &nonzeros));
  double products = 0.0;
  SDR_TRY(guess_products(matrix, &products));
  const double seconds = 2.0 * products * (double)matrix->row[matrix->rows] / 1e9;
  if (flops / 1.5e10 <= 2.0 + seconds && 8.0 * nonzeros <= 8e9) return SDR_OK;
  solver->ops->destroy(solver->state);
  solver->state = NULL;
  solver->ops = &sdr_solver_pcg;
  return SDR_OK;
}

static void limit_threads(void)
{
  if (!getenv("OPENBLAS_NUM_THREADS")) openblas_set_num_threads(1);
}

sdr_status sdr_solver_create(const char *name, sdr_matrix_kind kind, sdr_solver **out)
{
  const int automatic = strcmp(name, "auto") == 0;
  const sdr_solver_ops *ops = find(name);
  if (!ops && !automatic)
    return sdr_fail(SDR_BAD_INPUT,
                    "there is no linear solver '%s'; choose auto, cholmod, klu, umfpack or pcg",
                    name);
  if (ops && !ops->takes[kind])
    return sdr_fail(SDR_BAD_INPUT,
                    "the linear solver '%s' does not take a %s matrix; choose auto or umfpack",
                    name, kind_names[kind]);
  sdr_solver *solver = sdr_alloc(1, sizeof *solver);
  if (!solver) return SDR_RUN_FAILED;
  *solver = (sdr_solver){.ops = ops, .automatic = automatic, .kind = kind};
  solver->report = (sdr_solver_report){.name = ops ? ops->name : "auto", .singular_row = -1};
  *out = solver;
  return SDR_OK;
}

static void drop_state(sdr_solver *solver)
{
  if (solver->state) solver->ops->destroy(solver->state);
  solver->state = NULL;
  sdr_free(solver->residual);
  sdr_free(solver->correction);
  solver->residual = solver->correction = NULL;
  solver->matrix = NULL;
  solver->rows = 0;
}

void sdr_solver_destroy(sdr_solver **solver)
{
  if (!*solver) return;
  drop_state(*solver);
  sdr_free(*solver);
  *solver = NULL;
}

sdr_solver_report sdr_solver_report_of(const sdr_solver *solver)
{
  return solver->report;
}

/* ---- singular matrices ----------------------------------------------------------------------- */

static double norm(const double *x, int32_t count)
{
  double most = 0.0, sum = 0.0;
  for (int32_t k = 0; k < count; ++k) most = fmax(most, fabs(x[k]));
  if (!(most > 0.0) || isinf(most)) return most;
  for (int32_t k = 0; k < count; ++k) sum += (x[k] / most) * (x[k] / most);
  return most * sqrt(sum);
}

/* Norm of the vector of sum over c of |A_rc x_c|: what rounding in A x is measured by. */
static double size_of_terms(const sdr_csr *a, const double *x)
{
  double sum = 0.0;
  for (int32_t r = 0; r < a->rows; ++r) {
    double terms = 0.0;
    for (int64_t k = a->row[r]; k < a->row[r + 1]; ++k)
      terms += fabs(a->value[k] * x[a->column[k]]);
    sum += terms * terms;
  }
  return sqrt(sum);
}

/* Unit vector along x; 0 if x is no such thing. */
static int normalise(double *x, int32_t count)
{
  const double length = norm(x, count);
  for (int32_t k = 0; k < count; ++k) {
    if (!isfinite(x[k])) return 0;
    x[k] /= length;
  }
  return length > 0.0;
}

/* Inverse iteration finds the vector x that A shortens most. If what is left of A x is no more than
   rounding, A is singular, and x is how the unknowns move: its largest entry is named. */
static sdr_status look_closer(sdr_solver *solver, const sdr_csr *a)
{
  double *b = solver->residual, *x = solver->correction;
  uint64_t noise = 88172645463325252u;
  int32_t most = 0;
  for (int32_t k = 0; k < a->rows; ++k) {
    noise = noise * 6364136223846793005u + 1442695040888963407u;
    b[k] = (double)(noise >> 11) * 0x1p-53 - 0.5;
  }
  for (int round = 0; round < 2; ++round) {
    SDR_TRY(solver->ops->solve(solver->state, b, x, &solver->report));
    if (!normalise(x, a->rows)) return sdr_solver_singular(&solver->report, a, -1, "singular");
    memcpy(b, x, (size_t)a->rows * sizeof *b);
  }
  sdr_csr_times(a, x, b);
  if (norm(b, a->rows) > 1e-15 * size_of_terms(a, x)) return SDR_OK;
  for (int32_t k = 0; k < a->rows; ++k)
    if (fabs(x[k]) > fabs(x[most])) most = k;
  return sdr_solver_singular(&solver->report, a, most, "singular");
}

/* ---- factor ---------------------------------------------------------------------------------- */

/* With what is known about the pattern in solver->state, if anything. */
static sdr_status factor_values(sdr_solver *solver, const sdr_csr *matrix)
{
  solver->matrix = NULL;
  solver->report.singular = 0;
  solver->report.singular_row = -1;
  solver->report.weakest = INFINITY;
  if (matrix->rows > 0) {
    SDR_TRY(solver->ops->factor(solver->kind, matrix, &solver->state, &solver->report));
    if (solver->report.weakest < sdr_solver_weak_pivot) SDR_TRY(look_closer(solver, matrix));
  }
  solver->matrix = matrix;
  return SDR_OK;
}

sdr_status sdr_solver_factor(sdr_solver *solver, const sdr_csr *matrix)
{
  if (matrix->rows != matrix->columns)
    return sdr_fail(SDR_RUN_FAILED, "a matrix of %d x %d cannot be solved with: it is not square",
                    (int)matrix->rows, (int)matrix->columns);
  limit_threads();
  drop_state(solver);
  const size_t rows = (size_t)matrix->rows;
  if (solver->automatic) SDR_TRY(choose(solver, matrix));
  solver->report.name = solver->ops->name;
  solver->residual = sdr_alloc(rows, sizeof(double));
  solver->correction = sdr_alloc(rows, sizeof(double));
  if (!solver->residual || !solver->correction) return SDR_RUN_FAILED;
  solver->rows = matrix->rows;
  return factor_values(solver, matrix);
}

sdr_status sdr_solver_refactor(sdr_solver *solver, const sdr_csr *matrix)
{
  if (!solver->residual || matrix->rows != solver->rows)
    return sdr_fail(SDR_RUN_FAILED, "a matrix of %d rows cannot be factored again: the last had %d",
                    (int)matrix->rows, (int)solver->rows);
  return factor_values(solver, matrix);
}

sdr_status sdr_solver_singular(sdr_solver_report *report, const sdr_csr *matrix, int32_t row,
                               const char *how)
{
  report->singular = 1;
  report->singular_row = row;
  if (row < 0)
    return sdr_fail(SDR_RUN_FAILED, "the matrix of %d rows is %s", (int)matrix->rows, how);
  return sdr_fail(SDR_RUN_FAILED, "the matrix of %d rows is %s at row %d", (int)matrix->rows, how,
                  (int)row);
}

int32_t sdr_solver_weakest_pivot(const sdr_csr *matrix, const double *scale, const int64_t *order,
                                 const double *pivot, double *ratio)
{
  int32_t weakest = -1;
  *ratio = INFINITY;
  for (int32_t k = 0; k < matrix->rows; ++k) {
    const int64_t row = order[k];
    double most = 0.0;
    for (int64_t p = matrix->row[row]; p < matrix->row[row + 1]; ++p)
      most = fmax(most, fabs(matrix->value[p] * scale[matrix->column[p]]));
    const double here = most > 0.0 ? fabs(pivot[k]) / most : 0.0;
    if (here >= *ratio) continue;
    weakest = (int32_t)row;
    *ratio = isnan(here) ? 0.0 : here;
  }
  return weakest;
}

int64_t *sdr_csr_wide_columns(const sdr_csr *matrix)
{
  const int64_t count = matrix->row[matrix->rows];
  int64_t *wide = sdr_alloc((size_t)count, sizeof *wide);
  for (int64_t k = 0; wide && k < count; ++k) wide[k] = matrix->column[k];
  return wide;
}

/* ---- solve ----------------------------------------------------------------------------------- */

/* residual = b - A x, and its norm over that of b. */
static double residual_of(const sdr_solver *solver, const double *b, const double *x)
{
  const int32_t rows = solver->matrix->rows;
  sdr_csr_times(solver->matrix, x, solver->residual);
  int finite = 1;
  for (int32_t k = 0; k < rows; ++k) {
    solver->residual[k] = b[k] - solver->residual[k];
    finite &= isfinite(solver->residual[k]) != 0;
  }
  const double whole = norm(b, rows), left = norm(solver->residual, rows);
  if (!finite) return (double)INFINITY;
  return whole > 0.0 ? left / whole : left;
}

/* Refine while it pays; x keeps the best. */
static sdr_status refine(sdr_solver *solver, const double *b, double *x)
{
  enum { ROUNDS = 3 };
  const int32_t rows = solver->matrix->rows;
  double *residual = &solver->report.residual;
  for (int round = 0; round<ROUNDS && * residual> 1e-14 && isfinite(*residual); ++round) {
    SDR_TRY(
        solver->ops->solve(solver->state, solver->residual, solver->correction, &solver->report));
    for (int32_t k = 0; k < rows; ++k) x[k] += solver->correction[k];
    const double now = residual_of(solver, b, x);
    if (!(now < *residual)) {
      for (int32_t k = 0; k < rows; ++k) x[k] -= solver->correction[k];
      return SDR_OK;
    }
    const int slow = now > 0.5 * *residual;
    *residual = now;
    if (slow) return SDR_OK;
  }
  return SDR_OK;
}

sdr_status sdr_solver_solve(sdr_solver *solver, const double *b, double *x)
{
  if (!solver->matrix) return sdr_fail(SDR_RUN_FAILED, "no matrix has been factored");
  solver->report.residual = 0.0;
  if (solver->matrix->rows == 0) return SDR_OK;
  SDR_TRY(solver->ops->solve(solver->state, b, x, &solver->report));
  solver->report.residual = residual_of(solver, b, x);
  if (solver->ops->direct) SDR_TRY(refine(solver, b, x));
  if (solver->report.residual <= 1e-6) return SDR_OK;
  if (!solver->ops->direct)
    return sdr_fail(SDR_RUN_FAILED,
                    "the linear solver '%s' did not converge: %.1e of the right-hand side is left "
                    "after %lld iterations; the matrix is singular or ill-conditioned: try cholmod "
                    "or umfpack",
                    solver->report.name, solver->report.residual,
                    (long long)solver->report.iterations);
  if (solver->report.residual * norm(b, solver->matrix->rows) <=
      1e-13 * size_of_terms(solver->matrix, x))
    return SDR_OK; /* as good as the numbers allow */
  return sdr_fail(SDR_RUN_FAILED,
                  "the linear solver '%s' left a residual of %.1e of the right-hand side: the "
                  "matrix is singular to working precision",
                  solver->report.name, solver->report.residual);
}

sdr_status sdr_solver_precondition(sdr_solver *solver, const double *b, double *x)
{
  if (!solver->matrix) return sdr_fail(SDR_RUN_FAILED, "no matrix has been factored");
  if (solver->rows == 0) return SDR_OK;
  const sdr_solver_ops *ops = solver->ops;
  return (ops->precondition ? ops->precondition : ops->solve)(solver->state, b, x, &solver->report);
}
