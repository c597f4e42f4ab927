/* What CVODES, IDA and KINSOL are given alike: a matrix that is none, a linear solver that calls
   us, and a place for what they complain of. Their own types stay out of headers: void * is a
   SUNContext, SUNMatrix or SUNLinearSolver. */
#ifndef SDR_TIME_SUN_PARTS_H
#define SDR_TIME_SUN_PARTS_H

#include "base/status.h"

/* Solve for x with b (not changed); `weight` (NULL: none) and `tolerance`: an iteration may leave a
   residual whose norm (two-norm of weight times entry) is at most that, 0 for direct solvers.
   0: done; 1: not now (a shorter step may do); -1: never. */
typedef int (*sdr_sun_solve)(void *context, double *x, const double *b, const double *weight,
                             double tolerance);

/* For the error handlers of all three: the latest message, without warnings. */
typedef struct {
  char text[512];
} sdr_sun_complaint;
void sdr_sun_remember(int code, const char *module, const char *function, char *message,
                      void *complaint);

/* NULL on failure. The matrix holds nothing; the solver calls `solve` with `context`. */
void *sdr_sun_matrix_create(void *sun_context);
void *sdr_sun_solver_create(void *sun_context, int iterates, sdr_sun_solve solve, void *context);

#endif
