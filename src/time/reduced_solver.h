/* Linear systems of implicit steps with velocities eliminated: (D + P^T K B) x = r over the free
   components, K the exact tangent (damage included), D a diagonal: masses over gamma^2 and such. */
#ifndef SDR_TIME_REDUCED_SOLVER_H
#define SDR_TIME_REDUCED_SOLVER_H

#include "mechanics/constraints.h"
#include "mechanics/model.h"

typedef struct sdr_reduced_solver sdr_reduced_solver;

/* `name`: "pcg" (conjugate gradients, the inverses of points' blocks as preconditioner), "stale"
   (the same until it takes more than a few iterations, then a Cholesky factor is the
   preconditioner, as long as it serves), "cholmod" (L L^T, or L D L^T where the tangent is
   indefinite), "klu", "umfpack"; "auto": pcg, or umfpack for layers whose forces act elsewhere than
   they move. SDR_BAD_INPUT: no such solver, or the model has no tangent. Borrows the model. Owner:
   the caller. */
sdr_status sdr_reduced_solver_create(sdr_model *model, const char *name, sdr_reduced_solver **out);
void sdr_reduced_solver_destroy(sdr_reduced_solver **solver); /* NULL-safe */

/* 1 if it iterates: then D may change at every solution. */
int sdr_reduced_solver_iterates(const sdr_reduced_solver *solver);

/* Take the tangent at u. SDR_BAD_INPUT if the solver cannot take its kind of matrix. */
sdr_status sdr_reduced_solver_tangent(sdr_reduced_solver *solver,
                                      const sdr_constraints *constraints, double *const u[3]);

/* What came of it: a system that is not solved now may be at a smaller step. */
typedef enum {
  SDR_REDUCED_OK = 0,
  SDR_REDUCED_SMALLER_STEP = 1,
  SDR_REDUCED_FAILED = -1
} sdr_reduced;

/* Take D (positive, copied) and factor, or make the preconditioner. */
sdr_reduced sdr_reduced_solver_prepare(sdr_reduced_solver *solver, const double *diagonal);

/* x from r. An iteration ends where the root mean square of scale_k residual_k is at most
   `tolerance`, scale NULL: all 1; its D is `diagonal`, that of the preparation if NULL. Direct
   solvers ignore these.
 */
typedef struct {
  const double *diagonal, *scale;
  double tolerance;
} sdr_reduced_aim;
sdr_reduced sdr_reduced_solver_solve(sdr_reduced_solver *solver, const sdr_reduced_aim *aim,
                                     const double *r, double *x);

/* out = P^T K z, for z over all components. */
void sdr_reduced_solver_pull(sdr_reduced_solver *solver, const double *z, double *out);

/* Diagonal entry k of P^T K B. */
double sdr_reduced_solver_stiffness(const sdr_reduced_solver *solver, int32_t k);

typedef struct {
  const char *name;
  int64_t unknowns, nonzeros; /* of the matrix */
  int64_t tangents, factors, solutions, iterations;
  double bytes;
} sdr_reduced_report;
sdr_reduced_report sdr_reduced_solver_report(const sdr_reduced_solver *solver);

#endif
