/* KINSOL on g(q) = 0 (equilibrium.h): Newton's method with a factor of the exact tangent,
   indefinite or not, and without a search: one on |g|, which KINSOL offers, fails at a peak, where
   the way down in energy goes up in |g|. What it finds counts if the tangent is positive there: a
   minimum. A cross-check of the minimisation, which shares its forces and tangents only. */
#include "base/memory.h"
#include "time/static.h"
#include "time/sun_parts.h"
#include "time/sun_vectors.h"

#include <kinsol/kinsol.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <string.h>

enum { MOST_STEPS = 60 };

typedef struct {
  sdr_equilibrium *e;
  sdr_reduction *reduction;
  sdr_solver *factor, *test; /* umfpack's; whether a tangent is positive */
  double *u;                 /* an unknown */
  SUNContext context;
  sdr_sun_complaint complaint;
  sdr_status failure;
} state;

static void destroy(void *given)
{
  state *s = given;
  sdr_solver_destroy(&s->factor);
  sdr_solver_destroy(&s->test);
  sdr_reduction_destroy(&s->reduction);
  sdr_free(s->u);
  if (s->context) SUNContext_Free(&s->context);
  sdr_free(s);
}

static sdr_status create(sdr_equilibrium *e, void **out)
{
  state *s = sdr_alloc(1, sizeof *s);
  if (!s) return SDR_RUN_FAILED;
  *out = s;
  s->e = e;
  s->u = sdr_alloc((size_t)e->implicit->unknowns, sizeof(double));
  if (!s->u) return SDR_RUN_FAILED;
  SDR_TRY(sdr_reduction_create(sdr_tangent_matrix(e->tangent), &s->reduction));
  if (SUNContext_Create(NULL, &s->context))
    return sdr_fail(SDR_RUN_FAILED, "SUNDIALS cannot start: out of memory");
  return SDR_OK;
}

static int gradient_of(N_Vector q, N_Vector gradient, void *given)
{
  state *s = given;
  sdr_constraints_expand(&s->e->implicit->constraints, N_VGetArrayPointer(q), s->u);
  const double size = sdr_equilibrium_gradient(s->e, s->u, N_VGetArrayPointer(gradient));
  return isfinite(size) ? 0 : 1;
}

/* 0, or 1: a shorter increment may do. */
static int judge(state *s, sdr_status status)
{
  if (status != SDR_OK) s->failure = status;
  return status == SDR_OK ? 0 : 1;
}

static int make_matrix(N_Vector q, N_Vector gradient, SUNMatrix matrix, void *given, N_Vector a,
                       N_Vector b)
{
  state *s = given;
  int renewed = 0;
  (void)gradient, (void)matrix, (void)a, (void)b;
  sdr_equilibrium *e = s->e;
  sdr_constraints_expand(&e->implicit->constraints, N_VGetArrayPointer(q), s->u);
  sdr_status status = sdr_equilibrium_linearise(e, s->u, 0);
  if (status == SDR_OK)
    status = sdr_reduction_update(s->reduction, &e->implicit->constraints, &renewed);
  if (status == SDR_OK && !s->factor) {
    renewed = 1;
    status = sdr_solver_create("umfpack", SDR_MATRIX_SYMMETRIC, &s->factor);
  }
  if (status == SDR_OK)
    status = renewed ? sdr_solver_factor(s->factor, sdr_reduction_matrix(s->reduction))
                     : sdr_solver_refactor(s->factor, sdr_reduction_matrix(s->reduction));
  ++e->implicit->system->solve.factorisations;
  return judge(s, status);
}

static int solve_linear(void *given, double *x, const double *b, const double *weight,
                        double tolerance)
{
  state *s = given;
  (void)weight, (void)tolerance;
  return judge(s, sdr_solver_solve(s->factor, b, x));
}

/* What KINSOL needs for one equilibrium. */
typedef struct {
  void *memory;
  N_Vector q, ones;
  SUNMatrix matrix;
  SUNLinearSolver linear;
} method;

static void close_method(method *m)
{
  if (m->memory) KINFree(&m->memory);
  if (m->linear) SUNLinSolFree(m->linear);
  if (m->matrix) SUNMatDestroy(m->matrix);
  if (m->q) N_VDestroy(m->q);
  if (m->ones) N_VDestroy(m->ones);
}

static int open_method(state *s, method *m, double tolerance)
{
  m->q = N_VNew_Serial(s->e->implicit->free, s->context);
  m->memory = KINCreate(s->context);
  m->matrix = sdr_sun_matrix_create(s->context);
  m->linear = sdr_sun_solver_create(s->context, 0, solve_linear, s);
  if (!m->q || !m->memory || !m->matrix || !m->linear) return -1;
  sdr_sun_quicken(m->q);
  m->ones = N_VClone(m->q);
  if (!m->ones) return -1;
  N_VConst(1.0, m->ones);
  int flag = KINSetErrHandlerFn(m->memory, sdr_sun_remember, &s->complaint);
  if (!flag) flag = KINInit(m->memory, gradient_of, m->q);
  if (!flag) flag = KINSetUserData(m->memory, s);
  if (!flag) flag = KINSetLinearSolver(m->memory, m->linear, m->matrix);
  if (!flag) flag = KINSetJacFn(m->memory, make_matrix);
  if (!flag) flag = KINSetMaxSetupCalls(m->memory, 1); /* a factor for each iterate */
  if (!flag)
    flag = KINSetFuncNormTol(m->memory, fmax(tolerance / sqrt(s->e->implicit->free + 1.0),
                                             1e-300)); /* of the largest entry */
  if (!flag) flag = KINSetScaledStepTol(m->memory, 1e-300);
  if (!flag) flag = KINSetNumMaxIters(m->memory, MOST_STEPS);
  if (!flag) flag = KINSetMaxNewtonStep(m->memory, 1e6);
  return flag;
}

/* 1 if the tangent at u is positive: then u is a minimum of the energy. Newton's method finds any
   point where g = 0, past a peak also such that the body would leave at a touch. */
static int is_stable(state *s, const double *u)
{
  int renewed;
  if (sdr_equilibrium_linearise(s->e, u, 0) != SDR_OK) return 0;
  if (sdr_reduction_update(s->reduction, &s->e->implicit->constraints, &renewed) != SDR_OK)
    return 0;
  sdr_solver_destroy(&s->test);
  if (sdr_solver_create("cholmod", SDR_MATRIX_POSITIVE, &s->test) != SDR_OK) return 0;
  return sdr_solver_factor(s->test, sdr_reduction_matrix(s->reduction)) == SDR_OK;
}

static sdr_status solve(void *given, double *u, sdr_newton_report *report)
{
  state *s = given;
  sdr_equilibrium *e = s->e;
  const sdr_implicit *implicit = e->implicit;
  double *gradient = sdr_alloc((size_t)implicit->free, sizeof *gradient);
  method m = {0};
  long steps = 0;
  *report = (sdr_newton_report){0};
  s->failure = SDR_OK;
  if (!gradient) return SDR_RUN_FAILED;
  report->residual = sdr_equilibrium_gradient(e, u, gradient); /* and the scale of forces */
  if (open_method(s, &m, sdr_equilibrium_tolerance(e))) {
    close_method(&m);
    sdr_free(gradient);
    return sdr_fail(SDR_RUN_FAILED, "KINSOL cannot start: %s", s->complaint.text);
  }
  double *q = N_VGetArrayPointer(m.q);
  for (int32_t k = 0; k < implicit->free; ++k) q[k] = u[implicit->constraints.unknown[k]];
  KINSol(m.memory, m.q, KIN_NONE, m.ones, m.ones); /* the residual says how it went */
  KINGetNumNonlinSolvIters(m.memory, &steps);
  sdr_constraints_expand(&implicit->constraints, q, u);
  report->steps = (int)steps;
  report->residual = sdr_equilibrium_gradient(e, u, gradient);
  report->converged = report->residual <= sdr_equilibrium_tolerance(e) && is_stable(s, u);
  close_method(&m);
  sdr_free(gradient);
  return SDR_OK;
}

const sdr_static_method sdr_static_kinsol = {
    .name = "kinsol", .create = create, .solve = solve, .destroy = destroy};
