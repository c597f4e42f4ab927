/* Sparse LU by KLU. Rows of A are given as columns, so it factors A^T and solves with its
   transpose. */
#include "base/memory.h"
#include "linalg/solver_ops.h"

#include <klu.h>
#include <string.h>

typedef struct {
  klu_l_common common;
  klu_l_symbolic *symbolic;
  klu_l_numeric *numeric;
  int64_t *column;
  int32_t rows;
} state;

static void destroy(void *given)
{
  state *s = given;
  klu_l_free_symbolic(&s->symbolic, &s->common);
  klu_l_free_numeric(&s->numeric, &s->common);
  sdr_free(s->column);
  sdr_free(s);
}

static sdr_status complain(const state *s, const sdr_csr *a, sdr_solver_report *report)
{
  if (s->common.status == KLU_OUT_OF_MEMORY || s->common.status == KLU_TOO_LARGE)
    return sdr_fail(SDR_RUN_FAILED,
                    "out of memory for the LU factors of KLU; take the solver 'umfpack' or 'pcg'");
  if (s->common.status != KLU_SINGULAR)
    return sdr_fail(SDR_RUN_FAILED, "KLU failed (its code %d)", (int)s->common.status);
  const int64_t row = s->common.singular_col; /* a column of A^T */
  return sdr_solver_singular(report, a, row < a->rows ? (int32_t)row : -1, "singular");
}

/* KLU divides row P[k] of its matrix, which is A's column, by Rs[k]; Q orders A's rows. */
static sdr_status judge(const state *s, const sdr_csr *a, sdr_solver_report *report)
{
  double *scale = sdr_alloc((size_t)a->rows, sizeof *scale), ratio;
  if (!scale) return SDR_RUN_FAILED;
  const SuiteSparse_long *columns = s->numeric->Pnum;
  const double *divisor = s->numeric->Rs;
  for (int32_t k = 0; k < a->rows; ++k) scale[columns[k]] = divisor ? 1.0 / divisor[k] : 1.0;
  const int32_t row = sdr_solver_weakest_pivot(a, scale, (const int64_t *)s->symbolic->Q,
                                               s->numeric->Udiag, &ratio);
  sdr_free(scale);
  report->weakest = ratio;
  if (ratio < sdr_solver_zero_pivot) return sdr_solver_singular(report, a, row, "singular");
  return SDR_OK;
}

static state *open_state(void)
{
  state *s = sdr_alloc(1, sizeof *s);
  if (s) klu_l_defaults(&s->common);
  return s;
}

static sdr_status factor(sdr_matrix_kind kind, const sdr_csr *a, void **out,
                         sdr_solver_report *report)
{
  (void)kind;
  if (!*out && !(*out = open_state())) return SDR_RUN_FAILED;
  state *s = *out;
  s->rows = a->rows;
  klu_l_free_numeric(&s->numeric, &s->common);
  sdr_free(s->column);
  s->column = sdr_csr_wide_columns(a);
  if (!s->column) return SDR_RUN_FAILED;
  SuiteSparse_long *start = (SuiteSparse_long *)a->row, *column = (SuiteSparse_long *)s->column;
  if (!s->symbolic) s->symbolic = klu_l_analyze(a->rows, start, column, &s->common);
  if (!s->symbolic) return complain(s, a, report);
  s->numeric = klu_l_factor(start, column, a->value, s->symbolic, &s->common);
  if (!s->numeric || s->common.status != KLU_OK) return complain(s, a, report);
  report->bytes = (double)s->common.mempeak;
  report->nonzeros = (double)(s->numeric->lnz + s->numeric->unz);
  sdr_free(s->column);
  s->column = NULL;
  return judge(s, a, report);
}

static sdr_status solve(void *given, const double *b, double *x, sdr_solver_report *report)
{
  state *s = given;
  (void)report;
  memcpy(x, b, (size_t)s->rows * sizeof *b);
  if (klu_l_tsolve(s->symbolic, s->numeric, s->rows, 1, x, &s->common)) return SDR_OK;
  return sdr_fail(SDR_RUN_FAILED, "KLU failed to solve (its code %d)", (int)s->common.status);
}

const sdr_solver_ops sdr_solver_klu = {.name = "klu",
                                       .direct = 1,
                                       .takes = {1, 1, 1},
                                       .factor = factor,
                                       .solve = solve,
                                       .destroy = destroy};
