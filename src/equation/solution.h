/* The solution of a problem, and how far it is from the exact one. */
#ifndef SDR_EQUATION_SOLUTION_H
#define SDR_EQUATION_SOLUTION_H

#include "equation/problem.h"
#include "linalg/solver.h"

/* Component-major arrays: component c of point i at c count + i. */
typedef struct {
  int width;            /* components of the solution that are compared: 1 or the body's */
  int stresses;         /* of the stress; 0: none */
  double *value;        /* fields count; the solution is its first `width` components */
  double *exact;        /* width count; NULL: not known */
  double *stress;       /* stresses count; NULL: none */
  double *exact_stress; /* likewise; NULL: not known */
  /* Relative in the L2 norm over the points that are not held as a volume; the largest deviation
     over the largest exact value. NAN: not known. */
  double error_l2, error_max, error_stress;
  int64_t unknowns, nonzeros; /* of the matrix */
  double assemble_seconds, solve_seconds;
  sdr_solver_report solver;
} sdr_solution;

/* Assemble, solve and compare. Owner of *out: the caller. */
sdr_status sdr_problem_solve(const sdr_problem *problem, sdr_solution *out);
void sdr_solution_destroy(sdr_solution *solution);

#endif
