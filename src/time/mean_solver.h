/* Linear equations of implicit steps where means of supports keep their value:

     (D + P^T K S B) x = r + sum over the means of p_n e_n,   e_n . x = e_n . D^-1 r,

   e_n: 1 at the components that mean n joins; S takes the means away. The second line is what the
   forces p_n of motion.h ask for: they follow from the others so that e_n . D^-1 of them is 0. */
#ifndef SDR_TIME_MEAN_SOLVER_H
#define SDR_TIME_MEAN_SOLVER_H

#include "time/motion.h"
#include "time/reduced_solver.h"

typedef struct sdr_mean_solver sdr_mean_solver;

/* Borrows both. Owner: the caller. */
sdr_status sdr_mean_solver_create(sdr_reduced_solver *reduced, const sdr_motion *motion,
                                  sdr_mean_solver **out);
void sdr_mean_solver_destroy(sdr_mean_solver **solver); /* NULL-safe */

/* As sdr_reduced_solver_solve, with aim->diagonal; `key`: another number wherever D or the tangent
   is another than at the last call (two factors in any order of one D have one). */
sdr_reduced sdr_mean_solver_solve(sdr_mean_solver *solver, const sdr_reduced_aim *aim, double key,
                                  const double *r, double *x);

#endif
