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
   SDR_RUN_FAILED with the row at which it failed, where that is known. */
sdr_status sdr_solver_factor(sdr_solver *solver, const sdr_csr *matrix);

/* Solve for one right-hand side; x and b hold `rows` values and may not overlap. */
sdr_status sdr_solver_solve(sdr_solver *solver, const double *b, double *x);

/* The solver that was chosen, what it held at most (bytes) and its iterations so far (0: direct).
 */
typedef struct {
  const char *name;
  double bytes;
  int64_t iterations;
} sdr_solver_report;
sdr_solver_report sdr_solver_report_of(const sdr_solver *solver);

#endif
