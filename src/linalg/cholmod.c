/* Cholesky factors by CHOLMOD: supernodal L L^T of positive definite matrices, simplicial L D L^T
   of indefinite ones (without pivoting: the residual is the judge). */
#include "base/memory.h"
#include "linalg/solver_ops.h"

#include <cholmod.h>
#include <math.h>
#include <string.h>

typedef struct {
  cholmod_common common;
  cholmod_sparse *upper;
  cholmod_factor *factor;
  cholmod_dense *b, *x, *y, *e; /* y, e: work space of solve2 */
  double *diagonal;             /* of A */
} state;

static void destroy(void *given)
{
  state *s = given;
  cholmod_l_free_sparse(&s->upper, &s->common);
  cholmod_l_free_factor(&s->factor, &s->common);
  cholmod_l_free_dense(&s->b, &s->common);
  cholmod_l_free_dense(&s->x, &s->common);
  cholmod_l_free_dense(&s->y, &s->common);
  cholmod_l_free_dense(&s->e, &s->common);
  cholmod_l_finish(&s->common);
  sdr_free(s->diagonal);
  sdr_free(s);
}

/* The copy of A: the factor does not need it. */
static void drop_matrix(state *s)
{
  cholmod_l_free_sparse(&s->upper, &s->common);
  sdr_free(s->diagonal);
  s->diagonal = NULL;
}

static sdr_status complain(const state *s)
{
  if (s->common.status == CHOLMOD_OUT_OF_MEMORY)
    return sdr_fail(SDR_RUN_FAILED,
                    "out of memory for the Cholesky factor: %.2g GB were in use; take the solver "
                    "'pcg'",
                    (double)s->common.memory_usage * 1e-9);
  return sdr_fail(SDR_RUN_FAILED, "CHOLMOD failed (its code %d)", s->common.status);
}

static state *open_state(sdr_matrix_kind kind)
{
  state *s = sdr_alloc(1, sizeof *s);
  if (!s) return NULL;
  cholmod_l_start(&s->common);
  s->common.print = 0;
  s->common.quick_return_if_not_posdef = 1;
  s->common.supernodal = kind == SDR_MATRIX_POSITIVE ? CHOLMOD_AUTO : CHOLMOD_SIMPLICIAL;
  s->common.final_ll = kind == SDR_MATRIX_POSITIVE;
  s->common.nmethods = 1;
  s->common.postorder = 1;
  return s;
}

static int64_t count_upper(const sdr_csr *a)
{
  int64_t count = 0;
  for (int32_t r = 0; r < a->rows; ++r)
    for (int64_t k = a->row[r]; k < a->row[r + 1] && a->column[k] <= r; ++k) ++count;
  return count;
}

/* The upper triangle by columns: of row r (column r of the symmetric matrix) what is left of the
   diagonal. */
static sdr_status copy_upper(const sdr_csr *a, state *s)
{
  const size_t n = (size_t)a->rows, count = (size_t)count_upper(a);
  s->diagonal = sdr_alloc(n, sizeof(double));
  if (!s->diagonal) return SDR_RUN_FAILED;
  s->upper = cholmod_l_allocate_sparse(n, n, count, 1, 1, 1, CHOLMOD_REAL, &s->common);
  if (!s->upper) return complain(s);
  int64_t *start = s->upper->p, *row = s->upper->i, at = 0;
  double *value = s->upper->x;
  for (int32_t r = 0; r < a->rows; ++r) {
    start[r] = at;
    for (int64_t k = a->row[r]; k < a->row[r + 1] && a->column[k] <= r; ++k) {
      row[at] = a->column[k];
      value[at++] = a->value[k];
      if (a->column[k] == r) s->diagonal[r] = a->value[k];
    }
  }
  start[n] = at;
  return SDR_OK;
}

static sdr_status analyse(const sdr_csr *a, state *s)
{
  enum { SMALL = 500 }; /* rows below which METIS gains nothing */
  int64_t *order = NULL;
  s->common.method[0].ordering = CHOLMOD_AMD;
  if (a->rows > SMALL) {
    order = sdr_alloc((size_t)a->rows, sizeof *order);
    const sdr_status status = order ? sdr_csr_dissect(a, order) : SDR_RUN_FAILED;
    if (status != SDR_OK) {
      sdr_free(order);
      return status;
    }
    s->common.method[0].ordering = CHOLMOD_GIVEN;
  }
  s->factor = cholmod_l_analyze_p(s->upper, (SuiteSparse_long *)order, NULL, 0, &s->common);
  sdr_free(order);
  return s->factor ? SDR_OK : complain(s);
}

static sdr_status prepare(sdr_matrix_kind kind, const sdr_csr *a, void **out)
{
  state *s = open_state(kind);
  if (!s) return SDR_RUN_FAILED;
  *out = s;
  SDR_TRY(copy_upper(a, s));
  return analyse(a, s);
}

/* ---- pivots ---------------------------------------------------------------------------------- */

/* The row whose pivot is the smallest beside A's diagonal entry there, and that ratio. */
typedef struct {
  int32_t row;
  double ratio;
} weakest;

static void look_at(const state *s, int64_t k, double pivot, weakest *least)
{
  const int64_t *order = s->factor->Perm;
  const int32_t row = (int32_t)order[k];
  /* an indefinite matrix may have zeros on its diagonal: then the pivot is judged as it is */
  const double whole = fabs(s->diagonal[row]) > 0.0 ? fabs(s->diagonal[row]) : 1.0;
  const double ratio = fabs(pivot) / whole;
  if (!(ratio < least->ratio) && !isnan(ratio)) return;
  *least = (weakest){row, isnan(ratio) ? 0.0 : ratio};
}

static weakest weakest_pivot(const state *s)
{
  const cholmod_factor *l = s->factor;
  const double *value = l->x;
  weakest least = {-1, INFINITY};
  if (!l->is_super) {
    const int64_t *start = l->p;
    for (int64_t k = 0; k < (int64_t)l->n; ++k) {
      const double d = value[start[k]];
      look_at(s, k, l->is_ll ? d * d : d, &least);
    }
    return least;
  }
  const int64_t *super = l->super, *rows = l->pi, *values = l->px;
  for (int64_t node = 0; node < (int64_t)l->nsuper; ++node) {
    const int64_t height = rows[node + 1] - rows[node];
    for (int64_t k = super[node]; k < super[node + 1]; ++k) {
      const double d = value[values[node] + (k - super[node]) * (height + 1)];
      look_at(s, k, d * d, &least);
    }
  }
  return least;
}

static sdr_status judge(const state *s, sdr_matrix_kind kind, const sdr_csr *a,
                        sdr_solver_report *report)
{
  const int64_t *order = s->factor->Perm;
  const int positive = kind == SDR_MATRIX_POSITIVE;
  if (s->factor->minor < s->factor->n)
    return sdr_solver_singular(report, a, (int32_t)order[s->factor->minor],
                               positive ? "singular or not positive definite" : "singular");
  const weakest least = weakest_pivot(s);
  report->weakest = least.ratio;
  if (least.ratio < sdr_solver_zero_pivot)
    return sdr_solver_singular(report, a, least.row, "singular");
  return SDR_OK;
}

static sdr_status factor(sdr_matrix_kind kind, const sdr_csr *a, void **out,
                         sdr_solver_report *report)
{
  if (!*out) SDR_TRY(prepare(kind, a, out));
  state *s = *out;
  if (!s->upper) SDR_TRY(copy_upper(a, s));
  report->nonzeros = s->common.lnz;
  report->flops = s->common.fl;
  const int done = cholmod_l_factorize(s->upper, s->factor, &s->common);
  report->bytes = fmax(report->bytes, (double)s->common.memory_usage);
  if (!done && s->common.status < CHOLMOD_OK) {
    drop_matrix(s);
    return complain(s);
  }
  const sdr_status status = judge(s, kind, a, report);
  drop_matrix(s);
  if (status != SDR_OK || s->b) return status;
  s->b = cholmod_l_allocate_dense(s->factor->n, 1, s->factor->n, CHOLMOD_REAL, &s->common);
  return s->b ? SDR_OK : complain(s);
}

static sdr_status solve(void *given, const double *b, double *x, sdr_solver_report *report)
{
  state *s = given;
  const size_t bytes = s->factor->n * sizeof *b;
  memcpy(s->b->x, b, bytes);
  if (!cholmod_l_solve2(CHOLMOD_A, s->factor, s->b, NULL, &s->x, NULL, &s->y, &s->e, &s->common))
    return complain(s);
  memcpy(x, s->x->x, bytes);
  report->bytes = fmax(report->bytes, (double)s->common.memory_usage);
  return SDR_OK;
}

sdr_status sdr_cholmod_analyse(const sdr_csr *matrix, void **out, double *flops, double *nonzeros)
{
  SDR_TRY(prepare(SDR_MATRIX_POSITIVE, matrix, out));
  const state *s = *out;
  *flops = s->common.fl;
  *nonzeros = s->common.lnz;
  return SDR_OK;
}

const sdr_solver_ops sdr_solver_cholmod = {.name = "cholmod",
                                           .direct = 1,
                                           .takes = {1, 1, 0},
                                           .factor = factor,
                                           .solve = solve,
                                           .destroy = destroy};
