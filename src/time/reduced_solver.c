#include "time/reduced_solver.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/small.h"
#include "linalg/solver.h"
#include "mechanics/reduction.h"
#include "mechanics/tangent.h"
#include "time/kept_tangent.h"

#include <math.h>
#include <string.h>

/* ITERATIONS: at most, of conjugate gradients. WORN: iterations after which a stale factor is made
   anew. FEW: iterations with the points' blocks that cost less than one with a factor. PIECES: of a
   product, one task each. */
enum { MOST_COMPONENTS = 3, ITERATIONS = 500, WORN = 12, FEW = 8, PIECES = 32, SMALL = 20000 };

typedef enum { BLOCKS, STALE, DIRECT } method;

struct sdr_reduced_solver {
  sdr_model *model;
  method method;
  int automatic;
  sdr_tangent *tangent;
  sdr_reduction *reduction;
  const sdr_constraints *constraints;
  const sdr_csr *matrix; /* P^T K B */
  sdr_csr shifted;       /* D + it; borrows rows and columns */
  int64_t *diagonal_at;  /* where diagonal entries stand */
  int32_t size;          /* of what follows: free components */
  int renewed, indefinite, worn;
  int factored;                      /* STALE: 1 if the solver holds a factor that serves */
  int stiff;                         /* of STALE: 1 once the points' blocks were not enough */
  double stiffened;                  /* largest entry of D then */
  sdr_solver *solver;                /* DIRECT, STALE */
  int32_t block_count, *block_first; /* groups of components of one point */
  double *block;                     /* their inverses, MOST_COMPONENTS^2 values each */
  double *diagonal;
  double *residual, *direction, *product, *scaled;
  double *full[2];        /* over all components */
  sdr_kept_tangent *kept; /* in place of a matrix, where keeps is 1 */
  int keeps;
  sdr_reduced_report report;
};

/* ---- creation -------------------------------------------------------------------------------- */

static void drop_vectors(sdr_reduced_solver *s)
{
  sdr_free(s->shifted.value);
  sdr_free(s->diagonal_at);
  sdr_free(s->block_first);
  sdr_free(s->block);
  sdr_free(s->diagonal);
  sdr_free(s->residual);
  sdr_free(s->direction);
  sdr_free(s->product);
  sdr_free(s->scaled);
  s->shifted = (sdr_csr){0};
  s->diagonal_at = NULL;
  s->block_first = NULL;
  s->block = s->diagonal = s->residual = s->direction = s->product = s->scaled = NULL;
}

void sdr_reduced_solver_destroy(sdr_reduced_solver **solver)
{
  sdr_reduced_solver *s = *solver;
  if (!s) return;
  drop_vectors(s);
  sdr_solver_destroy(&s->solver);
  sdr_reduction_destroy(&s->reduction);
  sdr_tangent_destroy(&s->tangent);
  sdr_free(s->full[0]);
  sdr_free(s->full[1]);
  sdr_kept_tangent_destroy(&s->kept);
  sdr_free(s);
  *solver = NULL;
}

static sdr_status find_method(sdr_reduced_solver *s, const char *name)
{
  static const struct {
    const char *name;
    method method;
  } known[] = {{"pcg", BLOCKS},     {"stale", STALE}, {"auto", BLOCKS},
               {"cholmod", DIRECT}, {"klu", DIRECT},  {"umfpack", DIRECT}};
  for (size_t k = 0; k < sizeof known / sizeof *known; ++k)
    if (strcmp(known[k].name, name) == 0) {
      s->method = known[k].method;
      s->automatic = strcmp(name, "auto") == 0;
      s->report.name = s->automatic ? "pcg" : known[k].name;
      return SDR_OK;
    }
  return sdr_fail(
      SDR_BAD_INPUT,
      "there is no linear solver '%s'; choose auto, pcg, stale, cholmod, klu or umfpack", name);
}

sdr_status sdr_reduced_solver_create(sdr_model *model, const char *name, sdr_reduced_solver **out)
{
  sdr_reduced_solver *s = sdr_alloc(1, sizeof *s);
  if (!s) return SDR_RUN_FAILED;
  s->model = model;
  sdr_status status = find_method(s, name);
  const size_t unknowns = (size_t)(model->points->count * model->points->components);
  s->full[0] = sdr_alloc(unknowns, sizeof(double));
  s->full[1] = sdr_alloc(unknowns, sizeof(double));
  if (status == SDR_OK && (!s->full[0] || !s->full[1])) status = SDR_RUN_FAILED;
  if (status == SDR_OK)
    *out = s;
  else
    sdr_reduced_solver_destroy(&s);
  return status;
}

int sdr_reduced_solver_iterates(const sdr_reduced_solver *solver)
{
  return solver->method != DIRECT;
}

sdr_reduced_report sdr_reduced_solver_report(const sdr_reduced_solver *solver)
{
  return solver->report;
}

/* ---- matrix ---------------------------------------------------------------------------------- */

/* Components of one point make a block, if they stand beside each other. */
static void find_blocks(sdr_reduced_solver *s)
{
  const int32_t *unknown = s->constraints->unknown;
  const int m = s->model->points->components;
  s->block_count = 0;
  for (int32_t k = 0; k < s->size; ++k)
    if (k == 0 || unknown[k] / m != unknown[k - 1] / m) s->block_first[s->block_count++] = k;
  s->block_first[s->block_count] = s->size;
}

static void find_diagonal(sdr_reduced_solver *s)
{
  const sdr_csr *a = s->matrix;
  for (int32_t r = 0; r < a->rows; ++r)
    for (int64_t p = a->row[r]; p < a->row[r + 1]; ++p)
      if (a->column[p] == r) s->diagonal_at[r] = p;
}

/* Room for `rows` free components, and for the factors of a matrix, if there is one. */
static sdr_status make_room(sdr_reduced_solver *s, int32_t count)
{
  const size_t rows = (size_t)count, block = MOST_COMPONENTS * MOST_COMPONENTS;
  drop_vectors(s);
  s->size = count;
  int failed = !(s->diagonal_at = sdr_alloc(rows, sizeof *s->diagonal_at));
  failed |= !(s->block_first = sdr_alloc(rows + 1, sizeof *s->block_first));
  failed |= !(s->block = sdr_alloc(rows * block, sizeof(double)));
  failed |= !(s->diagonal = sdr_alloc(rows, sizeof(double)));
  failed |= !(s->residual = sdr_alloc(rows, sizeof(double)));
  failed |= !(s->direction = sdr_alloc(rows, sizeof(double)));
  failed |= !(s->product = sdr_alloc(rows, sizeof(double)));
  failed |= !(s->scaled = sdr_alloc(rows, sizeof(double)));
  if (failed) return SDR_RUN_FAILED;
  find_blocks(s);
  s->report.unknowns = count;
  return SDR_OK;
}

/* The same for a matrix of another pattern. */
static sdr_status take_pattern(sdr_reduced_solver *s)
{
  const sdr_csr *a = s->matrix;
  SDR_TRY(make_room(s, a->rows));
  s->shifted =
      (sdr_csr){.rows = a->rows, .columns = a->columns, .row = a->row, .column = a->column};
  if (s->method != BLOCKS &&
      !(s->shifted.value = sdr_alloc((size_t)a->row[a->rows], sizeof(double))))
    return SDR_RUN_FAILED;
  find_diagonal(s);
  s->renewed = 1;
  s->report.nonzeros = a->row[a->rows];
  return SDR_OK;
}

static sdr_status check_kind(sdr_reduced_solver *s, const sdr_constraints *constraints)
{
  if (constraints->symmetric) return SDR_OK;
  if (s->automatic) {
    s->method = DIRECT;
    s->report.name = "umfpack";
  }
  if (strcmp(s->report.name, "umfpack") == 0 || strcmp(s->report.name, "klu") == 0) return SDR_OK;
  return sdr_fail(
      SDR_BAD_INPUT,
      "time.solver: with fictitious traction layers the stiffness is not symmetric, and "
      "'%s' needs that; choose auto, umfpack or klu",
      s->report.name);
}

/* No matrix: the model multiplies. */
static sdr_status keep_tangent(sdr_reduced_solver *s, double *const u[3], int other)
{
  if (!s->kept) SDR_TRY(sdr_kept_tangent_create(s->model, &s->kept));
  if (other || !s->keeps || s->constraints->free != s->size)
    SDR_TRY(make_room(s, s->constraints->free));
  s->keeps = 1;
  return sdr_kept_tangent_take(s->kept, s->constraints, u);
}

static sdr_status assemble(sdr_reduced_solver *s, double *const u[3], int other)
{
  int renewed = 0;
  if (!s->tangent) SDR_TRY(sdr_tangent_create(s->model, SDR_TANGENT_EXACT, &s->tangent));
  if (!s->reduction) SDR_TRY(sdr_reduction_create(sdr_tangent_matrix(s->tangent), &s->reduction));
  SDR_TRY(sdr_tangent_update(s->tangent, NULL, u));
  SDR_TRY(sdr_reduction_update(s->reduction, s->constraints, &renewed));
  s->matrix = sdr_reduction_matrix(s->reduction);
  if (renewed || other || s->keeps || s->matrix->rows != s->size) SDR_TRY(take_pattern(s));
  s->keeps = 0;
  return SDR_OK;
}

/* Where masses outweigh the stiffness a factor is wasted: STALE does without until it is missed. */
static int uses_blocks(const sdr_reduced_solver *s)
{
  return s->method == BLOCKS || (s->method == STALE && !s->stiff);
}

sdr_status sdr_reduced_solver_tangent(sdr_reduced_solver *solver,
                                      const sdr_constraints *constraints, double *const u[3])
{
  SDR_TRY(check_kind(solver, constraints));
  const int other = solver->constraints != constraints;
  solver->constraints = constraints;
  ++solver->report.tangents;
  if (uses_blocks(solver) && sdr_kept_tangent_fits(solver->model, constraints))
    return keep_tangent(solver, u, other);
  return assemble(solver, u, other);
}

void sdr_reduced_solver_pull(sdr_reduced_solver *solver, const double *z, double *out)
{
  if (solver->keeps) {
    sdr_kept_tangent_pull(solver->kept, z, out);
    return;
  }
  sdr_csr_times(sdr_tangent_matrix(solver->tangent), z, solver->full[0]);
  sdr_constraints_project(solver->constraints, solver->full[0], out);
}

double sdr_reduced_solver_stiffness(const sdr_reduced_solver *solver, int32_t k)
{
  return solver->keeps ? sdr_kept_tangent_entry(solver->kept, k, k)
                       : solver->matrix->value[solver->diagonal_at[k]];
}

typedef struct {
  const sdr_csr *a;
  const double *d, *x;
  double *y;
} product_call;

static void product_of_piece(void *context, int piece)
{
  const product_call *call = context;
  const sdr_csr *a = call->a;
  const int64_t rows = a->rows;
  const int32_t first = (int32_t)(rows * piece / PIECES),
                end = (int32_t)(rows * (piece + 1) / PIECES);
  for (int32_t r = first; r < end; ++r) {
    double sum = call->d[r] * call->x[r];
    for (int64_t p = a->row[r]; p < a->row[r + 1]; ++p) sum += a->value[p] * call->x[a->column[p]];
    call->y[r] = sum;
  }
}

/* y = (D + A) x. */
static void times(const sdr_reduced_solver *s, const double *d, const double *x, double *y)
{
  if (s->keeps) {
    sdr_kept_tangent_times(s->kept, d, x, y);
    return;
  }
  product_call call = {s->matrix, d, x, y};
  if (s->size >= SMALL) {
    sdr_parallel_for(0, PIECES, 1, product_of_piece, &call);
    return;
  }
  for (int piece = 0; piece < PIECES; ++piece) product_of_piece(&call, piece);
}

/* ---- preconditioner -------------------------------------------------------------------------- */

/* Add the stiffness of entries first .. first + n - 1, one point's, to a block. */
static void add_stiffness(const sdr_reduced_solver *s, int32_t first, int n, double *block)
{
  const sdr_csr *a = s->matrix;
  if (s->keeps) {
    for (int r = 0; r < n; ++r)
      for (int c = 0; c < n; ++c)
        block[3 * r + c] += sdr_kept_tangent_entry(s->kept, first + r, first + c);
    return;
  }
  for (int r = 0; r < n; ++r) {
    int64_t p = s->diagonal_at[first + r];
    while (p > a->row[first + r] && a->column[p - 1] >= first) --p;
    for (; p < a->row[first + r + 1] && a->column[p] < first + n; ++p)
      block[3 * r + a->column[p] - first] += a->value[p];
  }
}

/* D alone where damage has turned a point's block indefinite. */
static void make_blocks(sdr_reduced_solver *s)
{
  for (int32_t g = 0; g < s->block_count; ++g) {
    double *block = s->block + (size_t)g * (MOST_COMPONENTS * MOST_COMPONENTS);
    const int32_t first = s->block_first[g], n = s->block_first[g + 1] - first;
    memset(block, 0, MOST_COMPONENTS * MOST_COMPONENTS * sizeof *block);
    for (int32_t r = 0; r < n; ++r) block[3 * r + r] = s->diagonal[first + r];
    add_stiffness(s, first, n, block);
    if (sdr_invert_positive(block, n)) continue;
    memset(block, 0, MOST_COMPONENTS * MOST_COMPONENTS * sizeof *block);
    for (int32_t r = 0; r < n; ++r) block[3 * r + r] = 1.0 / s->diagonal[first + r];
  }
}

static sdr_status precondition(sdr_reduced_solver *s, const double *r, double *z)
{
  if (s->factored) return sdr_solver_precondition(s->solver, r, z);
  for (int32_t g = 0; g < s->block_count; ++g) {
    const double *b = s->block + (size_t)g * (MOST_COMPONENTS * MOST_COMPONENTS);
    const int32_t first = s->block_first[g], n = s->block_first[g + 1] - first;
    if (n == 2) {
      z[first] = b[0] * r[first] + b[1] * r[first + 1];
      z[first + 1] = b[3] * r[first] + b[4] * r[first + 1];
      continue;
    }
    for (int32_t p = 0; p < n; ++p) {
      z[first + p] = 0.0;
      for (int32_t q = 0; q < n; ++q) z[first + p] += b[3 * p + q] * r[first + q];
    }
  }
  return SDR_OK;
}

/* ---- factors --------------------------------------------------------------------------------- */

static sdr_status open_solver(sdr_reduced_solver *s, sdr_matrix_kind kind)
{
  sdr_solver_destroy(&s->solver);
  s->renewed = 1;
  return sdr_solver_create(s->method == STALE ? "cholmod" : s->report.name, kind, &s->solver);
}

static sdr_matrix_kind usual_kind(const sdr_reduced_solver *s)
{
  if (!s->constraints->symmetric) return SDR_MATRIX_GENERAL;
  const int cholesky = s->method == STALE || strcmp(s->report.name, "cholmod") == 0;
  return cholesky ? SDR_MATRIX_POSITIVE : SDR_MATRIX_SYMMETRIC;
}

static sdr_status factor(sdr_reduced_solver *s)
{
  const int again = !s->renewed;
  s->renewed = 0;
  ++s->report.factors;
  const sdr_status status = again ? sdr_solver_refactor(s->solver, &s->shifted)
                                  : sdr_solver_factor(s->solver, &s->shifted);
  const sdr_solver_report report = sdr_solver_report_of(s->solver);
  s->report.bytes = fmax(s->report.bytes, report.bytes);
  return status;
}

/* An indefinite matrix has an L D L^T. As a preconditioner it would not do: then blocks serve until
   the next. */
static sdr_reduced make_factor(sdr_reduced_solver *s)
{
  const sdr_csr *a = s->matrix;
  const sdr_matrix_kind usual = usual_kind(s);
  memcpy(s->shifted.value, a->value, (size_t)a->row[a->rows] * sizeof *a->value);
  for (int32_t r = 0; r < a->rows; ++r) s->shifted.value[s->diagonal_at[r]] += s->diagonal[r];
  if (!s->solver || s->indefinite) {
    if (open_solver(s, usual) != SDR_OK) return SDR_REDUCED_FAILED;
    s->indefinite = 0;
  }
  s->factored = factor(s) == SDR_OK;
  if (s->factored) return SDR_REDUCED_OK;
  if (usual != SDR_MATRIX_POSITIVE) return SDR_REDUCED_SMALLER_STEP;
  s->indefinite = 1;
  if (s->method == STALE) {
    make_blocks(s);
    return SDR_REDUCED_OK;
  }
  if (open_solver(s, SDR_MATRIX_SYMMETRIC) != SDR_OK) return SDR_REDUCED_FAILED;
  return factor(s) == SDR_OK ? SDR_REDUCED_OK : SDR_REDUCED_SMALLER_STEP;
}

static double largest(const sdr_reduced_solver *s)
{
  double most = 0.0;
  for (int32_t k = 0; k < s->size; ++k) most = fmax(most, s->diagonal[k]);
  return most;
}

sdr_reduced sdr_reduced_solver_prepare(sdr_reduced_solver *solver, const double *diagonal)
{
  memcpy(solver->diagonal, diagonal, (size_t)solver->size * sizeof *diagonal);
  if (solver->method == DIRECT) return make_factor(solver);
  if (solver->stiff && largest(solver) > 4.0 * solver->stiffened) solver->stiff = 0;
  if (uses_blocks(solver) || solver->keeps) {
    solver->factored = 0;
    make_blocks(solver);
    return SDR_REDUCED_OK;
  }
  const int needed = !solver->solver || solver->renewed || solver->indefinite || solver->worn;
  solver->worn = 0;
  return needed ? make_factor(solver) : SDR_REDUCED_OK;
}

/* ---- conjugate gradients --------------------------------------------------------------------- */

static double dot(const double *x, const double *y, int32_t count)
{
  double sum = 0.0;
#pragma omp simd reduction(+ : sum)
  for (int32_t k = 0; k < count; ++k) sum += x[k] * y[k];
  return sum;
}

static double size_of(const double *r, const double *scale, int32_t count)
{
  double sum = 0.0;
  if (!scale) return count > 0 ? sqrt(dot(r, r, count) / count) : 0.0;
#pragma omp simd reduction(+ : sum)
  for (int32_t k = 0; k < count; ++k) sum += (scale[k] * r[k]) * (scale[k] * r[k]);
  return count > 0 ? sqrt(sum / count) : 0.0;
}

/* One iteration; negative curvature asks for a smaller step, where masses outweigh the stiffness.
 */
static sdr_reduced iterate(sdr_reduced_solver *s, const double *d, double *rho, double *x)
{
  const int32_t n = s->size;
  const double before = *rho;
  if (precondition(s, s->residual, s->scaled) != SDR_OK) return SDR_REDUCED_SMALLER_STEP;
  *rho = dot(s->residual, s->scaled, n);
  const double beta = before > 0.0 ? *rho / before : 0.0;
#pragma omp simd
  for (int32_t k = 0; k < n; ++k) s->direction[k] = s->scaled[k] + beta * s->direction[k];
  times(s, d, s->direction, s->product);
  const double curvature = dot(s->direction, s->product, n);
  if (!(curvature > 0.0) || !(*rho > 0.0)) return SDR_REDUCED_SMALLER_STEP;
  const double alpha = *rho / curvature;
#pragma omp simd
  for (int32_t k = 0; k < n; ++k) {
    x[k] += alpha * s->direction[k];
    s->residual[k] -= alpha * s->product[k];
  }
  ++s->report.iterations;
  return SDR_REDUCED_OK;
}

static sdr_reduced iterate_all(sdr_reduced_solver *s, const sdr_reduced_aim *aim, const double *r,
                               double *x)
{
  const double *d = aim->diagonal ? aim->diagonal : s->diagonal;
  const int64_t before = s->report.iterations;
  double rho = 0.0, size = size_of(r, aim->scale, s->size);
  memset(x, 0, (size_t)s->size * sizeof *x);
  memset(s->direction, 0, (size_t)s->size * sizeof *x);
  memcpy(s->residual, r, (size_t)s->size * sizeof *r);
  for (int n = 0; n < ITERATIONS && size > aim->tolerance; ++n) {
    const sdr_reduced result = iterate(s, d, &rho, x);
    if (result != SDR_REDUCED_OK) return result;
    size = size_of(s->residual, aim->scale, s->size);
  }
  if (s->report.iterations - before > WORN) s->worn = 1;
  if (s->method == STALE && !s->stiff && s->report.iterations - before > FEW) {
    s->stiff = s->worn = 1; /* from the next tangent on */
    s->stiffened = largest(s);
  }
  return size <= aim->tolerance ? SDR_REDUCED_OK : SDR_REDUCED_SMALLER_STEP;
}

sdr_reduced sdr_reduced_solver_solve(sdr_reduced_solver *solver, const sdr_reduced_aim *aim,
                                     const double *r, double *x)
{
  ++solver->report.solutions;
  if (solver->method != DIRECT) return iterate_all(solver, aim, r, x);
  /* without pivots the residual is the judge; elsewhere Newton's iteration will see */
  const sdr_status status = solver->indefinite ? sdr_solver_solve(solver->solver, r, x)
                                               : sdr_solver_precondition(solver->solver, r, x);
  return status == SDR_OK ? SDR_REDUCED_OK : SDR_REDUCED_SMALLER_STEP;
}
