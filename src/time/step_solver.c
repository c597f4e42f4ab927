#include "time/step_solver.h"

#include "base/memory.h"
#include "linalg/krylov.h"
#include "linalg/solver.h"
#include "mechanics/reduction.h"
#include "mechanics/tangent.h"

#include <math.h>
#include <string.h>
#include <time.h>

typedef enum { BICGSTAB, STALE, UMFPACK, KLU } method;

/* inertia M + share K as a matrix over the free components, and its factors. */
typedef struct {
  sdr_tangent *tangent;
  sdr_csr sum;       /* over all components; shares the tangent's pattern */
  int64_t *diagonal; /* a row of it: where the diagonal stands */
  sdr_reduction *reduction;
  sdr_solver *solver;
  int factored;   /* 1: once at least */
  double inertia; /* of the factors */
} step_matrix;

struct sdr_step_solver {
  sdr_implicit *implicit;
  method method;
  int may_change; /* auto: by the condition */
  double inertia;
  double *const *u0, *const *u1;
  double *v[3], *out[3]; /* component arrays of points, for products */
  double *vector;        /* over all components: scratch */
  double *block;         /* a point: inverse of its diagonal block */
  uint8_t *free;         /* over all components: 1 if it is one of q */
  sdr_krylov *krylov;
  step_matrix matrix;
  int32_t first_iterations; /* of the stale factor: its first solution; -1: none yet */
  int refactor;             /* 1: the stale factor serves no more */
  double condition;         /* of the system, about */
  sdr_step_solver_report report;
};

static double wall(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- creation -------------------------------------------------------------------------------- */

static void matrix_destroy(step_matrix *matrix)
{
  sdr_solver_destroy(&matrix->solver);
  sdr_reduction_destroy(&matrix->reduction);
  sdr_free(matrix->sum.value); /* its pattern is the tangent's */
  sdr_free(matrix->diagonal);
  sdr_tangent_destroy(&matrix->tangent);
  *matrix = (step_matrix){0};
}

void sdr_step_solver_destroy(sdr_step_solver **solver)
{
  sdr_step_solver *s = *solver;
  if (!s) return;
  matrix_destroy(&s->matrix);
  sdr_krylov_destroy(&s->krylov);
  for (int a = 0; a < 3; ++a) {
    sdr_free(s->v[a]);
    sdr_free(s->out[a]);
  }
  sdr_free(s->vector);
  sdr_free(s->block);
  sdr_free(s->free);
  sdr_free(s);
  *solver = NULL;
}

static sdr_status find_method(sdr_step_solver *s, const char *name)
{
  static const char *const names[] = {"bicgstab", "stale", "umfpack", "klu"};
  const sdr_model_ops *ops = s->implicit->system->model->ops;
  s->may_change = strcmp(name, "auto") == 0 && ops->visit_secant;
  if (strcmp(name, "auto") == 0) return SDR_OK;
  for (int k = 0; k < 4; ++k)
    if (strcmp(name, names[k]) == 0) {
      s->method = (method)k;
      return SDR_OK;
    }
  return sdr_fail(SDR_BAD_INPUT,
                  "energy_momentum has no linear solver '%s'; it has auto, bicgstab, stale, "
                  "umfpack, klu",
                  name);
}

static sdr_status alloc_vectors(sdr_step_solver *s)
{
  const sdr_system *system = s->implicit->system;
  const size_t padded = sdr_points_padded(system->model->points);
  const size_t unknowns = (size_t)s->implicit->unknowns;
  int failed = 0;
  for (int a = 0; a < system->components; ++a) {
    failed |= !(s->v[a] = sdr_alloc(padded, sizeof(double)));
    failed |= !(s->out[a] = sdr_alloc(padded, sizeof(double)));
  }
  failed |= !(s->vector = sdr_alloc(unknowns, sizeof(double)));
  failed |= !(s->block = sdr_alloc(unknowns * (size_t)system->components, sizeof(double)));
  failed |= !(s->free = sdr_alloc(unknowns, 1));
  return failed ? SDR_RUN_FAILED : SDR_OK;
}

sdr_status sdr_step_solver_create(sdr_implicit *implicit, const char *name, sdr_step_solver **out)
{
  sdr_step_solver *s = sdr_alloc(1, sizeof *s);
  if (!s) return SDR_RUN_FAILED;
  s->implicit = implicit;
  sdr_status status = find_method(s, name);
  if (status == SDR_OK) status = alloc_vectors(s);
  if (status == SDR_OK)
    *out = s;
  else
    sdr_step_solver_destroy(&s);
  return status;
}

/* ---- between q and points -------------------------------------------------------------------- */

/* out = B q over all components. */
static void spread(const sdr_step_solver *s, const double *q, double *out)
{
  const sdr_constraints *c = &s->implicit->constraints;
  if (s->implicit->slaves.count > 0) {
    sdr_csr_times(&c->map, q, out);
  } else if (c->free == c->unknowns) {
    memcpy(out, q, (size_t)c->free * sizeof *q);
  } else {
    memset(out, 0, (size_t)c->unknowns * sizeof *out);
    for (int32_t k = 0; k < c->free; ++k) out[c->unknown[k]] = q[k];
  }
}

/* g = P^T f. */
static void project(const sdr_step_solver *s, const double *f, double *g)
{
  const sdr_constraints *c = &s->implicit->constraints;
  if (s->implicit->slaves.count > 0)
    sdr_constraints_project(c, f, g);
  else if (c->free == c->unknowns)
    memcpy(g, f, (size_t)c->free * sizeof *f);
  else
    for (int32_t k = 0; k < c->free; ++k) g[k] = f[c->unknown[k]];
}

/* ---- the operator ---------------------------------------------------------------------------- */

static sdr_status times(void *context, const double *x, double *out)
{
  sdr_step_solver *s = context;
  const sdr_implicit *implicit = s->implicit;
  sdr_model *model = implicit->system->model;
  const int m = implicit->system->components;
  double *const vector = s->vector;
  spread(s, x, vector);
  sdr_implicit_scatter(implicit, vector, s->v);
  model->ops->mean_times(model, s->u0, s->u1, s->v, s->out);
  for (int a = 0; a < m; ++a) {
    const double *const k = s->out[a];
    for (int32_t i = 0; i < implicit->system->count; ++i) {
      const int32_t r = i * m + a;
      vector[r] = s->inertia * implicit->mass[r] * vector[r] + k[i];
    }
  }
  project(s, vector, out);
  return SDR_OK;
}

static void times_blocks(const sdr_step_solver *s, const double *x, double *out)
{
  const int m = s->implicit->system->components;
  for (int32_t i = 0; i < s->implicit->system->count; ++i) {
    const double *block = s->block + (size_t)i * (size_t)(m * m), *from = x + i * m;
    for (int r = 0; r < m; ++r) {
      double sum = 0.0;
      for (int c = 0; c < m; ++c) sum += block[r * m + c] * from[c];
      out[i * m + r] = sum;
    }
  }
}

static sdr_status precondition(void *context, const double *x, double *out)
{
  sdr_step_solver *s = context;
  const sdr_constraints *c = &s->implicit->constraints;
  if (s->method == STALE) return sdr_solver_precondition(s->matrix.solver, x, out);
  if (c->free == c->unknowns) {
    times_blocks(s, x, out);
    return SDR_OK;
  }
  double *const vector = s->vector;
  memset(vector, 0, (size_t)c->unknowns * sizeof *vector);
  for (int32_t k = 0; k < c->free; ++k) vector[c->unknown[k]] = x[k];
  const int m = s->implicit->system->components;
  for (int32_t i = 0; i < s->implicit->system->count; ++i) {
    double own[3];
    for (int a = 0; a < m; ++a) own[a] = vector[i * m + a];
    const double *block = s->block + (size_t)i * (size_t)(m * m);
    for (int r = 0; r < m; ++r) {
      vector[i * m + r] = 0.0;
      for (int a = 0; a < m; ++a) vector[i * m + r] += block[r * m + a] * own[a];
    }
  }
  for (int32_t k = 0; k < c->free; ++k) out[k] = vector[c->unknown[k]];
  return SDR_OK;
}

/* ---- the preconditioner of points' blocks ---------------------------------------------------- */

/* The inverse of a (m x m) in place; 0 if a pivot (as they come) is not well above zero: then `a`
   is spoilt. */
static int invert(int m, double a[9])
{
  double size = 0.0;
  for (int k = 0; k < m * m; ++k) size = fmax(size, fabs(a[k]));
  for (int p = 0; p < m; ++p) {
    const double pivot = a[p * m + p];
    if (!(pivot > 1e-3 * size)) return 0;
    for (int c = 0; c < m; ++c) a[p * m + c] = c == p ? 1.0 / pivot : a[p * m + c] / pivot;
    for (int r = 0; r < m; ++r) {
      if (r == p) continue;
      const double factor = a[r * m + p];
      for (int c = 0; c < m; ++c)
        a[r * m + c] = c == p ? -factor * a[p * m + p] : a[r * m + c] - factor * a[p * m + c];
    }
  }
  return 1;
}

/* Blocks with the rows and columns of held components as those of the unit matrix; where softening
   leaves no sound inverse, that of the masses, or 1 for points without. */
static void make_blocks(sdr_step_solver *s)
{
  const sdr_implicit *implicit = s->implicit;
  sdr_model *model = implicit->system->model;
  const int m = implicit->system->components;
  model->ops->mean_diagonal(model, s->u0, s->u1, s->block);
  for (int32_t i = 0; i < implicit->system->count; ++i) {
    double *const block = s->block + (size_t)i * (size_t)(m * m);
    const double inertia = s->inertia * implicit->mass[i * m];
    for (int r = 0; r < m; ++r) {
      block[r * m + r] += inertia;
      if (s->free[i * m + r]) continue;
      for (int c = 0; c < m; ++c) block[r * m + c] = block[c * m + r] = 0.0;
      block[r * m + r] = fmax(inertia, 1e-300);
    }
    if (invert(m, block)) continue;
    memset(block, 0, (size_t)(m * m) * sizeof *block);
    for (int r = 0; r < m; ++r) block[r * m + r] = inertia > 0.0 ? 1.0 / inertia : 1.0;
  }
}

/* ---- matrices -------------------------------------------------------------------------------- */

static sdr_status find_diagonal(step_matrix *matrix)
{
  const sdr_csr *k = sdr_tangent_matrix(matrix->tangent);
  matrix->sum = *k;
  matrix->sum.value = sdr_alloc((size_t)k->row[k->rows], sizeof(double));
  matrix->diagonal = sdr_alloc((size_t)k->rows, sizeof *matrix->diagonal);
  if (!matrix->sum.value || !matrix->diagonal) return SDR_RUN_FAILED;
  for (int32_t r = 0; r < k->rows; ++r)
    for (int64_t p = k->row[r]; p < k->row[r + 1]; ++p)
      if (k->column[p] == r) matrix->diagonal[r] = p;
  return sdr_reduction_create(&matrix->sum, &matrix->reduction);
}

static sdr_status matrix_create(sdr_step_solver *s)
{
  step_matrix *matrix = &s->matrix;
  if (matrix->solver) return SDR_OK;
  const int stale = s->method == STALE;
  const char *const name = stale ? "cholmod" : s->method == KLU ? "klu" : "umfpack";
  SDR_TRY(sdr_tangent_create(s->implicit->system->model,
                             stale ? SDR_TANGENT_SECANT : SDR_TANGENT_MEAN, &matrix->tangent));
  SDR_TRY(find_diagonal(matrix));
  return sdr_solver_create(name, stale ? SDR_MATRIX_POSITIVE : SDR_MATRIX_GENERAL, &matrix->solver);
}

/* Factor inertia M + K; stale: half of the secant stiffness at u0 for K. */
static sdr_status factor(sdr_step_solver *s)
{
  step_matrix *matrix = &s->matrix;
  const int stale = s->method == STALE;
  int renewed;
  SDR_TRY(matrix_create(s));
  SDR_TRY(stale ? sdr_tangent_update(matrix->tangent, NULL, s->u0)
                : sdr_tangent_update(matrix->tangent, s->u0, s->u1));
  const sdr_csr *k = sdr_tangent_matrix(matrix->tangent);
  for (int64_t p = 0; p < k->row[k->rows]; ++p)
    matrix->sum.value[p] = stale ? 0.5 * k->value[p] : k->value[p];
  for (int32_t r = 0; r < k->rows; ++r)
    matrix->sum.value[matrix->diagonal[r]] += s->inertia * s->implicit->mass[r];
  SDR_TRY(sdr_reduction_update(matrix->reduction, &s->implicit->constraints, &renewed));
  const sdr_csr *reduced = sdr_reduction_matrix(matrix->reduction);
  ++s->report.factorisations;
  s->report.nonzeros = reduced->row[reduced->rows];
  SDR_TRY(renewed || !matrix->factored ? sdr_solver_factor(matrix->solver, reduced)
                                       : sdr_solver_refactor(matrix->solver, reduced));
  matrix->factored = 1;
  matrix->inertia = s->inertia;
  s->report.bytes = fmax(s->report.bytes, sdr_solver_report_of(matrix->solver).bytes);
  return SDR_OK;
}

/* A factor that serves badly, or is of another step length or other free components. */
static sdr_status renew_stale(sdr_step_solver *s, int renumbered)
{
  const int other = !s->matrix.factored || renumbered || s->matrix.inertia != s->inertia;
  if (!other && !s->refactor) return SDR_OK;
  s->refactor = 0;
  s->first_iterations = -1;
  return factor(s);
}

/* ---- use ------------------------------------------------------------------------------------- */

static sdr_status renumber(sdr_step_solver *s)
{
  const sdr_constraints *c = &s->implicit->constraints;
  memset(s->free, 0, (size_t)c->unknowns);
  for (int32_t k = 0; k < c->free; ++k) s->free[c->unknown[k]] = 1;
  sdr_krylov_destroy(&s->krylov);
  s->report.unknowns = c->free;
  return sdr_krylov_create(c->free, &s->krylov);
}

/* auto: a factor where blocks would take hundreds of iterations. */
static void choose(sdr_step_solver *s)
{
  if (s->may_change) s->method = s->condition > 1e4 ? STALE : BICGSTAB;
}

sdr_status sdr_step_solver_prepare(sdr_step_solver *s, int renumbered, double *const u0[3],
                                   double *const u1[3], double inertia, double condition)
{
  const double from = wall();
  s->u0 = u0;
  s->u1 = u1;
  s->inertia = inertia;
  s->condition = condition;
  choose(s);
  sdr_status status = renumbered || !s->krylov ? renumber(s) : SDR_OK;
  if (status == SDR_OK && s->method == BICGSTAB)
    make_blocks(s);
  else if (status == SDR_OK)
    status = s->method == STALE ? renew_stale(s, renumbered) : factor(s);
  s->report.prepare_s += wall() - from;
  return status;
}

/* A stale factor that takes twice the iterations that it took first is renewed. */
static void judge(sdr_step_solver *s, int32_t iterations, double tolerance)
{
  const double digits = fmax(1.0, -log10(tolerance));
  const int32_t each = (int32_t)(10.0 * iterations / digits);
  if (s->method != STALE) return;
  if (s->first_iterations < 0) s->first_iterations = each;
  s->refactor = each > 2 * s->first_iterations + 20;
}

/* Iterations that a sound system may take; one that softens more than its inertia holds takes many,
   and is better met with a shorter step. */
static int32_t most_iterations(const sdr_step_solver *s)
{
  return s->method == STALE ? 80 : 40 + (int32_t)(6.0 * sqrt(s->condition));
}

static sdr_status iterate(sdr_step_solver *s, double tolerance, const double *r, double *x,
                          double *reached)
{
  int32_t iterations;
  const sdr_krylov_how how = {.times = times,
                              .precondition = precondition,
                              .context = s,
                              .tolerance = tolerance,
                              .most = most_iterations(s)};
  SDR_TRY(sdr_krylov_solve(s->krylov, &how, r, x, reached, &iterations));
  s->report.iterations += iterations;
  judge(s, iterations, tolerance);
  return SDR_OK;
}

sdr_status sdr_step_solver_solve(sdr_step_solver *s, double tolerance, const double *r, double *x,
                                 double *reached)
{
  const double from = wall();
  sdr_status status = SDR_OK;
  if (s->method == BICGSTAB || s->method == STALE) {
    status = iterate(s, tolerance, r, x, reached);
  } else {
    status = sdr_solver_solve(s->matrix.solver, r, x);
    *reached = 0.0;
  }
  s->report.solve_s += wall() - from;
  return status;
}

sdr_step_solver_report sdr_step_solver_report_of(const sdr_step_solver *s)
{
  static const char *const names[] = {"bicgstab", "stale", "umfpack", "klu"};
  sdr_step_solver_report report = s->report;
  report.name = names[s->method];
  return report;
}
