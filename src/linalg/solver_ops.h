/* Inside src/linalg: what a solver gives to the table in solver.c. */
#ifndef SDR_LINALG_SOLVER_OPS_H
#define SDR_LINALG_SOLVER_OPS_H

#include "linalg/solver.h"

#include <stddef.h>

typedef struct {
  const char *name;
  int direct;   /* 1: a residual may be cut by solving again */
  int takes[3]; /* by sdr_matrix_kind */
  /* Factor A into *state: a new one, or that of a matrix with the same pattern (cholmod: also one
     that was only analysed), which is written also on failure if there is something to destroy.
     report: bytes, nonzeros, flops, weakest (direct
     solvers), singular_row. */
  sdr_status (*factor)(sdr_matrix_kind kind, const sdr_csr *matrix, void **state,
                       sdr_solver_report *report);
  sdr_status (*solve)(void *state, const double *b, double *x, sdr_solver_report *report);
  /* One linear approximation to solve; NULL: that is one. */
  sdr_status (*precondition)(void *state, const double *b, double *x, sdr_solver_report *report);
  void (*destroy)(void *state); /* never NULL */
} sdr_solver_ops;

extern const sdr_solver_ops sdr_solver_cholmod, sdr_solver_klu, sdr_solver_umfpack, sdr_solver_pcg;

/* Record that A is singular (or not positive definite) at `row` (-1: not known); SDR_RUN_FAILED. */
sdr_status sdr_solver_singular(sdr_solver_report *report, const sdr_csr *matrix, int32_t row,
                               const char *how);

/* A pivot below this times the size that it started from is zero. That of a singular matrix need
   not be so small: below the second limit the matrix is looked at more closely. */
static const double sdr_solver_zero_pivot = 1e-15, sdr_solver_weak_pivot = 1e-7;

/* Of an LU factor of A^T with its rows (A's columns) multiplied by `scale`: the row of A whose
   pivot is the smallest beside the largest of A's scaled entries in that row, and that ratio.
   order[k] is the row of A behind pivot k. So neither the units of equations nor of unknowns
   matter. */
int32_t sdr_solver_weakest_pivot(const sdr_csr *matrix, const double *scale, const int64_t *order,
                                 const double *pivot, double *ratio);

/* Column indices in 64 bits, as SuiteSparse's long interfaces want them; NULL on failure. */
int64_t *sdr_csr_wide_columns(const sdr_csr *matrix);

/* Groups of consecutive rows with the same columns: the components of a point. group[r] is the
   group of row r, first[g] the first row of group g (groups + 1 entries). */
typedef struct {
  int32_t count;
  int32_t *group, *first;
} sdr_csr_groups;
sdr_status sdr_csr_groups_find(const sdr_csr *matrix, sdr_csr_groups *out);
void sdr_csr_groups_destroy(sdr_csr_groups *groups);

/* Nested dissection by METIS on the graph of the groups of a matrix with symmetric pattern: row
   order[k] becomes the k-th. */
sdr_status sdr_csr_dissect(const sdr_csr *matrix, int64_t *order);

/* What CHOLMOD would need to factor a positive definite matrix, from its analysis;
   sdr_solver_cholmod goes on from *state, or destroys it. */
sdr_status sdr_cholmod_analyse(const sdr_csr *matrix, void **state, double *flops,
                               double *nonzeros);

#endif
