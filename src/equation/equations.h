/* The linear system of a problem: a matrix and its right-hand side. */
#ifndef SDR_EQUATION_EQUATIONS_H
#define SDR_EQUATION_EQUATIONS_H

#include "equation/problem.h"
#include "linalg/solver.h"

typedef struct {
  sdr_csr matrix;
  double *f; /* fields count */
  sdr_matrix_kind kind;
} sdr_equations_system;

/* By collocation, or as the minimum of the functional with its operator energy, as the scene says.
   Owner: the caller. */
sdr_status sdr_equations_assemble(const sdr_problem *problem, sdr_equations_system *out);
void sdr_equations_destroy(sdr_equations_system *system);

#endif
