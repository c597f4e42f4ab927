#include "time/sun_parts.h"

#include "base/memory.h"

#include <nvector/nvector_serial.h>
#include <stdio.h>
#include <string.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

void sdr_sun_remember(int code, const char *module, const char *function, char *message,
                      void *complaint)
{
  (void)module, (void)function;
  sdr_sun_complaint *kept = complaint;
  if (code < 0) snprintf(kept->text, sizeof kept->text, "%s", message);
}

/* ---- matrix ---------------------------------------------------------------------------------- */

static SUNMatrix_ID matrix_id(SUNMatrix matrix)
{
  (void)matrix;
  return SUNMATRIX_CUSTOM;
}

static int matrix_zero(SUNMatrix matrix)
{
  (void)matrix;
  return SUNMAT_SUCCESS;
}

void *sdr_sun_matrix_create(void *sun_context)
{
  SUNMatrix matrix = SUNMatNewEmpty(sun_context);
  if (!matrix) return NULL;
  matrix->ops->getid = matrix_id;
  matrix->ops->zero = matrix_zero; /* IDA and KINSOL call it */
  matrix->ops->destroy = SUNMatFreeEmpty;
  return matrix;
}

/* ---- linear solver --------------------------------------------------------------------------- */

typedef struct {
  int iterates;
  sdr_sun_solve solve;
  void *context;
  N_Vector weight;
} content;

static SUNLinearSolver_Type solver_type(SUNLinearSolver solver)
{
  const content *c = solver->content;
  return c->iterates ? SUNLINEARSOLVER_MATRIX_ITERATIVE : SUNLINEARSOLVER_DIRECT;
}

static SUNLinearSolver_ID solver_id(SUNLinearSolver solver)
{
  (void)solver;
  return SUNLINEARSOLVER_CUSTOM;
}

static int solver_weights(SUNLinearSolver solver, N_Vector left, N_Vector right)
{
  content *c = solver->content;
  (void)right;
  c->weight = left;
  return SUNLS_SUCCESS;
}

static int solver_setup(SUNLinearSolver solver, SUNMatrix matrix)
{
  (void)solver, (void)matrix;
  return SUNLS_SUCCESS; /* it was made with the matrix */
}

static int solver_solve(SUNLinearSolver solver, SUNMatrix matrix, N_Vector x, N_Vector b,
                        realtype tolerance)
{
  const content *c = solver->content;
  (void)matrix;
  const int result = c->solve(c->context, N_VGetArrayPointer(x), N_VGetArrayPointer(b),
                              c->weight ? N_VGetArrayPointer(c->weight) : NULL, (double)tolerance);
  if (result == 0) return SUNLS_SUCCESS;
  return result > 0 ? SUNLS_CONV_FAIL : SUNLS_PACKAGE_FAIL_UNREC;
}

/* IDA wants both of a solver that iterates; of one that says 0 it would take the residual as x. */
static int solver_iterations(SUNLinearSolver solver)
{
  (void)solver;
  return 1;
}

static N_Vector solver_residual(SUNLinearSolver solver)
{
  (void)solver;
  return NULL;
}

static int solver_free(SUNLinearSolver solver)
{
  sdr_free(solver->content);
  solver->content = NULL;
  SUNLinSolFreeEmpty(solver);
  return SUNLS_SUCCESS;
}

void *sdr_sun_solver_create(void *sun_context, int iterates, sdr_sun_solve solve, void *context)
{
  SUNLinearSolver solver = SUNLinSolNewEmpty(sun_context);
  content *c = sdr_alloc(1, sizeof *c);
  if (!solver || !c) {
    SUNLinSolFreeEmpty(solver);
    sdr_free(c);
    return NULL;
  }
  *c = (content){iterates, solve, context, NULL};
  solver->content = c;
  solver->ops->gettype = solver_type;
  solver->ops->getid = solver_id;
  solver->ops->setscalingvectors = solver_weights;
  solver->ops->setup = solver_setup;
  solver->ops->solve = solver_solve;
  solver->ops->numiters = solver_iterations;
  solver->ops->resid = solver_residual;
  solver->ops->free = solver_free;
  return solver;
}
