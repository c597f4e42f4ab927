/* Means in a factor. A mean ties all its components to each other: its leader, a slave of the
   others (mechanics/constraints.h), would fill the matrix over q. So the matrix over q and the
   leaders, A, is factored without means, with a spring k_m at each leader e_m that keeps it
   regular, and means c_m^T x = 0 are kept by forces p_m along c_m:

     x = S f - sum p_m S c_m + sum w_m S e_m,   S = (A + sum k_m e_m e_m^T)^-1

   with p and w such that c_m^T x = 0 and w_m = k_m e_m^T x, which takes the spring away again. So x
   is B (B^T A B)^-1 r for any f with B^T f = r. */
#ifndef SDR_TIME_MEAN_BORDER_H
#define SDR_TIME_MEAN_BORDER_H

#include "linalg/solver.h"
#include "time/implicit.h"

typedef struct sdr_mean_border sdr_mean_border;

/* Owner: the caller. */
sdr_status sdr_mean_border_create(sdr_mean_border **out);
void sdr_mean_border_destroy(sdr_mean_border **border); /* NULL-safe */

/* Take the constraints of now, which must not go before the next call. */
sdr_status sdr_mean_border_take(sdr_mean_border *border, const sdr_implicit *implicit);

/* Constraints without means: what A is over. Borrowed until the next sdr_mean_border_take. */
const sdr_constraints *sdr_mean_border_open(const sdr_mean_border *border);

/* Add the springs to a diagonal over unknowns, N/m: each as stiff as `stiff`. */
void sdr_mean_border_add_springs(sdr_mean_border *border, double stiff, double *diagonal);

/* After `solver` has factored A with springs: what means need of it. */
sdr_status sdr_mean_border_factor(sdr_mean_border *border, sdr_solver *solver);

/* z = (B^T A B)^-1 r over q, by one solution of `solver` (or what it has as a preconditioner). */
sdr_status sdr_mean_border_solve(sdr_mean_border *border, sdr_solver *solver, const double *r,
                                 double *z);

#endif
