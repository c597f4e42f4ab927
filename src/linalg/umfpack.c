/* Sparse LU by UMFPACK. Rows of A are given as columns, so it factors A^T and solves with its
   transpose. */
#include "base/memory.h"
#include "linalg/solver_ops.h"

#include <umfpack.h>

typedef struct {
  double control[UMFPACK_CONTROL], info[UMFPACK_INFO];
  void *symbolic, *numeric;
  const sdr_csr *matrix;
  int64_t *column;
} state;

static void destroy(void *given)
{
  state *s = given;
  umfpack_dl_free_symbolic(&s->symbolic);
  umfpack_dl_free_numeric(&s->numeric);
  sdr_free(s->column);
  sdr_free(s);
}

static sdr_status complain(int64_t code)
{
  if (code == UMFPACK_ERROR_out_of_memory)
    return sdr_fail(SDR_RUN_FAILED, "out of memory for the LU factors of UMFPACK; take the solver "
                                    "'pcg' if the matrix is positive definite");
  return sdr_fail(SDR_RUN_FAILED, "UMFPACK failed (its code %d)", (int)code);
}

/* UMFPACK's columns are A's rows, and Q is their order. */
static sdr_status judge(const state *s, const sdr_csr *a, sdr_solver_report *report)
{
  const size_t rows = (size_t)a->rows;
  int64_t *order = sdr_alloc(rows, sizeof *order);
  double *pivot = sdr_alloc(rows, sizeof *pivot), *scale = sdr_alloc(rows, sizeof *scale), ratio;
  SuiteSparse_long reciprocal = 0;
  sdr_status status = order && pivot && scale ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) {
    const int64_t code =
        umfpack_dl_get_numeric(NULL, NULL, NULL, NULL, NULL, NULL, NULL, (SuiteSparse_long *)order,
                               pivot, &reciprocal, scale, s->numeric);
    if (code != UMFPACK_OK) status = complain(code);
  }
  if (status == SDR_OK) {
    for (int32_t k = 0; k < a->rows && !reciprocal; ++k) scale[k] = 1.0 / scale[k];
    const int32_t row = sdr_solver_weakest_pivot(a, scale, order, pivot, &ratio);
    report->weakest = ratio;
    if (ratio < sdr_solver_zero_pivot) status = sdr_solver_singular(report, a, row, "singular");
  }
  sdr_free(order);
  sdr_free(pivot);
  sdr_free(scale);
  return status;
}

static sdr_status analyse(sdr_matrix_kind kind, const sdr_csr *a, void **out)
{
  enum { SMALL = 500 }; /* rows below which METIS gains nothing */
  state *s = sdr_alloc(1, sizeof *s);
  if (!s) return SDR_RUN_FAILED;
  *out = s;
  s->column = sdr_csr_wide_columns(a);
  if (!s->column) return SDR_RUN_FAILED;
  umfpack_dl_defaults(s->control);
  if (kind != SDR_MATRIX_GENERAL) s->control[UMFPACK_STRATEGY] = UMFPACK_STRATEGY_SYMMETRIC;
  if (a->rows > SMALL) s->control[UMFPACK_ORDERING] = UMFPACK_ORDERING_METIS;
  const int64_t code = umfpack_dl_symbolic(a->rows, a->rows, (const SuiteSparse_long *)a->row,
                                           (const SuiteSparse_long *)s->column, a->value,
                                           &s->symbolic, s->control, s->info);
  return code < 0 ? complain(code) : SDR_OK;
}

static sdr_status factor(sdr_matrix_kind kind, const sdr_csr *a, void **out,
                         sdr_solver_report *report)
{
  if (!*out) SDR_TRY(analyse(kind, a, out));
  state *s = *out;
  s->matrix = a;
  umfpack_dl_free_numeric(&s->numeric);
  const SuiteSparse_long *start = (const SuiteSparse_long *)a->row;
  const SuiteSparse_long *column = (const SuiteSparse_long *)s->column;
  const int64_t code =
      umfpack_dl_numeric(start, column, a->value, s->symbolic, &s->numeric, s->control, s->info);
  report->bytes = s->info[UMFPACK_PEAK_MEMORY] * s->info[UMFPACK_SIZE_OF_UNIT];
  report->nonzeros = s->info[UMFPACK_LNZ] + s->info[UMFPACK_UNZ];
  report->flops = s->info[UMFPACK_FLOPS];
  if (code < 0) return complain(code);
  return judge(s, a, report);
}

static sdr_status solve_with(state *s, const double *b, double *x)
{
  const int64_t code = umfpack_dl_solve(UMFPACK_At, (const SuiteSparse_long *)s->matrix->row,
                                        (const SuiteSparse_long *)s->column, s->matrix->value, x, b,
                                        s->numeric, s->control, s->info);
  return code < 0 ? complain(code) : SDR_OK;
}

static sdr_status solve(void *given, const double *b, double *x, sdr_solver_report *report)
{
  state *s = given;
  (void)report;
  return solve_with(s, b, x);
}

/* The factors alone. */
static sdr_status precondition(void *given, const double *b, double *x, sdr_solver_report *report)
{
  state *s = given;
  const double rounds = s->control[UMFPACK_IRSTEP];
  (void)report;
  s->control[UMFPACK_IRSTEP] = 0.0;
  const sdr_status status = solve_with(s, b, x);
  s->control[UMFPACK_IRSTEP] = rounds;
  return status;
}

const sdr_solver_ops sdr_solver_umfpack = {.name = "umfpack",
                                           .direct = 1,
                                           .takes = {1, 1, 1},
                                           .factor = factor,
                                           .solve = solve,
                                           .precondition = precondition,
                                           .destroy = destroy};
