/* Linear equations of energy-momentum steps: (inertia M + P^T K B) x = r over the free components,
   K the tangent of the mean force, which is not symmetric. */
#ifndef SDR_TIME_STEP_SOLVER_H
#define SDR_TIME_STEP_SOLVER_H

#include "time/implicit.h"

typedef struct sdr_step_solver sdr_step_solver;

/* `name`: "bicgstab" (K never made a matrix; the inverses of points' blocks precondition), "stale"
   (the same, preconditioned by a Cholesky factor of inertia M + half the secant stiffness, as long
   as it serves), "umfpack", "klu" (K as a matrix, factored in every iteration of Newton's), "auto":
   stale for steps of more than about a hundred times the explicit limit, else bicgstab.
   SDR_BAD_INPUT: no such solver. Borrows `implicit`. Owner: the caller. */
sdr_status sdr_step_solver_create(sdr_implicit *implicit, const char *name, sdr_step_solver **out);
void sdr_step_solver_destroy(sdr_step_solver **solver); /* NULL-safe */

/* Take the tangent of the step from u0 to u1, which mean_keep has kept; both are borrowed until the
   next call. `inertia`: 2/h^2, 1/s^2. `condition`: of the system without damage, about.
   `renumbered`: 1 if other components are free than before. */
sdr_status sdr_step_solver_prepare(sdr_step_solver *solver, int renumbered, double *const u0[3],
                                   double *const u1[3], double inertia, double condition);

/* x from r, to |r - A x| <= tolerance |r| (direct solvers: as exactly as they can). *reached: what
   came of it, as a share of |r|; 1 or more: nothing. */
sdr_status sdr_step_solver_solve(sdr_step_solver *solver, double tolerance, const double *r,
                                 double *x, double *reached);

typedef struct {
  const char *name;           /* that is at work */
  int64_t iterations;         /* so far; 0: direct */
  int64_t factorisations;     /* so far */
  int64_t unknowns, nonzeros; /* of the matrix; 0 nonzeros: there is none */
  double bytes;               /* of factors, at most */
  double prepare_s, solve_s;  /* wall time */
} sdr_step_solver_report;
sdr_step_solver_report sdr_step_solver_report_of(const sdr_step_solver *solver);

#endif
