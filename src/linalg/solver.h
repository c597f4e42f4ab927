/* Linear solvers behind one table (design sec. 3): A x = b for sparse A. */
#ifndef SDR_LINALG_SOLVER_H
#define SDR_LINALG_SOLVER_H

#include "linalg/csr.h"

/* What is known of a matrix. */
typedef enum { SDR_MATRIX_POSITIVE, SDR_MATRIX_SYMMETRIC, SDR_MATRIX_GENERAL } sdr_matrix_kind;

typedef struct sdr_solver sdr_solver;

/* `name`: "cholmod" (positive; symmetric by LDL^T), "klu", "umfpack" (any), "pcg" (positive), or
   "auto": the best for the kind, size and dimension. The whole of a symmetric matrix is given.
   Owner: the caller. */
sdr_status sdr_solver_create(const char *name, sdr_matrix_kind kind, sdr_solver **out);
void sdr_solver_destroy(sdr_solver **solver); /* NULL-safe */

/* Factor (or prepare) A, which is borrowed until the next factor or destroy. A singular matrix is
   SDR_RUN_FAILED with the row at which it failed, where that is known; so is one that is not
   positive definite though said to be. OpenBLAS is set to one thread, unless the environment names
   a number (OPENBLAS_NUM_THREADS): on small supernodes two were 8 times slower. */
sdr_status sdr_solver_factor(sdr_solver *solver, const sdr_csr *matrix);

/* The same of a matrix with the pattern of the one factored last: what was found about the pattern
   (order, fill) is kept, where the solver keeps such. Also after a factor that failed for the
   values. SDR_RUN_FAILED if none was tried. */
sdr_status sdr_solver_refactor(sdr_solver *solver, const sdr_csr *matrix);

/* Solve for one right-hand side; x and b hold `rows` values and may not overlap. Direct solvers
   refine their answer once or twice where its residual asks for it. SDR_RUN_FAILED if pcg leaves
   more than 1e-6 of b, or a direct solver more than rounding of the terms in A x. */
sdr_status sdr_solver_solve(sdr_solver *solver, const double *b, double *x);

/* x = an approximate inverse times b, linear in b: the factors alone, without a look at the matrix,
   whose values may have changed since; of pcg its preconditioner. For iterations of others. */
sdr_status sdr_solver_precondition(sdr_solver *solver, const double *b, double *x);

/* What a solver was, held and did. */
typedef struct {
  const char *name;   /* the solver that was chosen; "auto" before the first factor */
  double bytes;       /* held at most */
  double nonzeros;    /* of the factor; 0: none */
  double flops;       /* that the factor took; 0: none or not known */
  int64_t iterations; /* so far; 0: direct */
  double residual;    /* |b - A x|/|b| of the last solve */
  double weakest;     /* least pivot of the factor, over the entry of A that it started from */
  int singular;       /* 1: the last factor or solve found A singular (or not positive definite) */
  int32_t singular_row; /* where; -1: nowhere, or not known */
} sdr_solver_report;
sdr_solver_report sdr_solver_report_of(const sdr_solver *solver);

#endif
