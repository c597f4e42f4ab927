/* CVODES on the free components (q, w = dq/dt) of u = a(t) + B q:

     q' = w,   M w' = P^T f(u) + loads

   by BDF with Newton's method, or by Adams with a fixed-point iteration. Newton's matrix is
   [I, -gamma I; gamma M^-1 K, I]; with the velocities eliminated it asks for

     (M/gamma^2 + P^T K B) dq = M (r2/gamma + r1/gamma^2),   dw = (dq - r1)/gamma.

   The history of damage is that of the last accepted step all through a step, with whatever the
   present u adds to it, and takes u in when the step is accepted: the force is a function of u
   then, and rejected trials leave nothing behind. Work and impulses are quadratures of the same
   order. Loads and supports have kinks at the ends of steps only, and after each the method starts
   anew. */
#include "base/memory.h"
#include "base/parallel.h"
#include "time/integrator.h"
#include "time/mean_solver.h"
#include "time/stable_step.h"
#include "time/sun_run.h"
#include "time/sun_vectors.h"
#include "time/tolerances.h"

#include <cvodes/cvodes.h>
#include <math.h>
#include <nvector/nvector_serial.h>
#include <string.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

typedef struct {
  sdr_system *system;
  sdr_motion *motion;
  sdr_reduced_solver *reduced; /* NULL: Adams */
  sdr_mean_solver *solver;     /* likewise */
  sdr_tolerances tolerances;
  double longest; /* s */
  int held;       /* 1: supports or layers; reactions are wanted */

  SUNContext context;
  void *memory;
  N_Vector y, slope, outside;
  SUNMatrix matrix;
  SUNLinearSolver linear;
  SUNNonlinearSolver nonlinear;
  int32_t size; /* free components that these were made for */
  double *g;    /* forces on q */
  double *diagonal, *right, *scale;
  double known[SDR_MOTION_RATES]; /* of `outside`: booked already */
  double force_time;              /* where the system's f and g are known; NAN: nowhere */
  double made_gamma;              /* of the factor */
  sdr_method_record before;       /* counts of methods before the present start */
  sdr_sun_complaint complaint;
  sdr_status failure; /* of a function of ours within a step */
} work;

/* ---- creation -------------------------------------------------------------------------------- */

static void close_method(work *w)
{
  if (w->memory) CVodeFree(&w->memory);
  if (w->linear) SUNLinSolFree(w->linear);
  if (w->matrix) SUNMatDestroy(w->matrix);
  if (w->nonlinear) SUNNonlinSolFree(w->nonlinear);
  N_Vector *const vectors[] = {&w->y, &w->slope, &w->outside};
  for (size_t k = 0; k < sizeof vectors / sizeof *vectors; ++k) {
    if (*vectors[k]) N_VDestroy(*vectors[k]);
    *vectors[k] = NULL;
  }
  w->linear = NULL;
  w->matrix = NULL;
  w->nonlinear = NULL;
  sdr_free(w->g);
  sdr_free(w->diagonal);
  sdr_free(w->right);
  sdr_free(w->scale);
  w->g = w->diagonal = w->right = w->scale = NULL;
}

static void end_work(void *given)
{
  work *w = given;
  close_method(w);
  if (w->context) SUNContext_Free(&w->context);
  sdr_mean_solver_destroy(&w->solver);
  sdr_reduced_solver_destroy(&w->reduced);
  sdr_motion_destroy(&w->motion);
  sdr_free(w);
}

static double *values(N_Vector vector)
{
  return N_VGetArrayPointer(vector);
}

/* ---- what CVODES calls ----------------------------------------------------------------------- */

/* 0, 1: at a smaller step perhaps, -1: never. */
static int judge(work *w, sdr_status status)
{
  if (status == SDR_OK) return 0;
  w->failure = status;
  return -1;
}

static int slope_of(realtype t, N_Vector y, N_Vector slope, void *context)
{
  work *w = context;
  const int32_t n = w->size;
  const double *q = values(y), *mass = sdr_motion_mass(w->motion);
  double *out = values(slope), sum = 0.0;
  const int failed = judge(w, sdr_motion_place(w->motion, t, q));
  if (failed) return failed;
  sdr_motion_force(w->motion, w->g);
  w->force_time = NAN;
  memcpy(out, q + n, (size_t)n * sizeof *out);
  for (int32_t k = 0; k < n; ++k) {
    out[n + k] = w->g[k] / mass[k];
    sum += fabs(out[n + k]);
  }
  return isfinite(sum) ? 0 : 1;
}

static int outside_of(realtype t, N_Vector y, N_Vector rates, void *context)
{
  work *w = context;
  int failed = judge(w, sdr_motion_place(w->motion, t, values(y)));
  if (!failed && w->held) {
    sdr_motion_force(w->motion, w->g);
    w->force_time = t;
  }
  if (!failed)
    failed = judge(w, sdr_motion_outside(w->motion, t, values(y) + w->size, values(rates)));
  return failed;
}

/* weight = 1/(relative |y| + absolute), both kinds of entries in one go. */
static int weigh(N_Vector y, N_Vector weight, void *context)
{
  const work *w = context;
  const sdr_tolerances *t = &w->tolerances;
  const double *from = values(y);
  double *to = values(weight);
  const int32_t n = w->size;
#pragma omp simd
  for (int32_t k = 0; k < n; ++k) to[k] = 1.0 / (t->relative * fabs(from[k]) + t->displacement);
#pragma omp simd
  for (int32_t k = n; k < 2 * n; ++k) to[k] = 1.0 / (t->relative * fabs(from[k]) + t->velocity);
  return 0;
}

static void find_diagonal(work *w, double gamma)
{
  const double *mass = sdr_motion_mass(w->motion);
  for (int32_t k = 0; k < w->size; ++k) w->diagonal[k] = mass[k] / (gamma * gamma);
}

/* NOLINTNEXTLINE(readability-function-size): CVODES gives it eleven arguments */
static int make_matrix(realtype t, N_Vector y, N_Vector slope, SUNMatrix matrix, booleantype keep,
                       booleantype *renewed, realtype gamma, void *context, N_Vector a, N_Vector b,
                       N_Vector c)
{
  work *w = context;
  (void)slope, (void)matrix, (void)a, (void)b, (void)c;
  *renewed = !keep;
  if (!keep) {
    int failed = judge(w, sdr_motion_place(w->motion, t, values(y)));
    if (!failed)
      failed = judge(w, sdr_reduced_solver_tangent(w->reduced, sdr_motion_constraints(w->motion),
                                                   w->system->u));
    if (failed) return failed;
  }
  find_diagonal(w, gamma);
  w->made_gamma = gamma;
  return sdr_reduced_solver_prepare(w->reduced, w->diagonal);
}

static int solve(void *context, double *x, const double *b, const double *weight, double tolerance)
{
  work *w = context;
  const int32_t n = w->size;
  const double *mass = sdr_motion_mass(w->motion);
  double gamma = w->made_gamma;
  if (sdr_reduced_solver_iterates(w->reduced)) {
    CVodeGetCurrentGamma(w->memory, &gamma);
    find_diagonal(w, gamma);
    for (int32_t k = 0; k < n; ++k) { /* errors of dq and dw by a residual of one, weighted */
      const double mobility = gamma / mass[k];
      const double way = weight[k] * gamma * mobility, speed = weight[n + k] * mobility;
      w->scale[k] = sqrt(0.5 * (way * way + speed * speed));
    }
  }
  for (int32_t k = 0; k < n; ++k) w->right[k] = mass[k] * (b[n + k] + b[k] / gamma) / gamma;
  const sdr_reduced_aim aim = {w->diagonal, w->scale, tolerance / sqrt(2.0 * n)};
  const int result = sdr_mean_solver_solve(w->solver, &aim, gamma, w->right, x);
  for (int32_t k = 0; k < n; ++k) x[n + k] = (x[k] - b[k]) / gamma;
  return result;
}

/* ---- starting -------------------------------------------------------------------------------- */

static sdr_sun_failure failure_of(const work *w)
{
  return (sdr_sun_failure){w->failure, &w->complaint};
}

static sdr_status complain(const work *w)
{
  return sdr_sun_complain("CVODES", failure_of(w));
}

static sdr_status make_vectors(work *w)
{
  const size_t n = (size_t)w->size;
  w->g = sdr_alloc(n, sizeof(double));
  w->diagonal = sdr_alloc(n, sizeof(double));
  w->right = sdr_alloc(n, sizeof(double));
  w->scale = sdr_alloc(n, sizeof(double));
  w->y = N_VNew_Serial(2 * (sunindextype)n, w->context);
  w->outside = N_VNew_Serial(SDR_MOTION_RATES, w->context);
  if (!w->g || !w->diagonal || !w->right || !w->scale || !w->y || !w->outside) return complain(w);
  sdr_sun_quicken(w->y);
  w->slope = N_VClone(w->y);
  if (!w->slope) return complain(w);
  return SDR_OK;
}

/* Waves are followed with small steps, where masses outweigh the stiffness, an old matrix serves
   long and errors are smooth. CVODES changes step and order only if the step may grow by half: then
   it stays at a low order for good. With a fifth it takes a third fewer steps for a quarter of the
   error. Conjugate gradients take up the present gamma themselves, and stop well within what is
   asked of them: so a looser test ends Newton's iterations. */
static int tune_newton(const work *w, int iterates)
{
  int flag = CVodeSetEtaFixedStepBounds(w->memory, 0.0, 1.2);
  if (!flag) flag = CVodeSetLSetupFrequency(w->memory, iterates ? 60 : 200);
  if (!flag) flag = CVodeSetDeltaGammaMaxLSetup(w->memory, iterates ? 0.6 : 1.0);
  if (!flag && iterates) flag = CVodeSetNonlinConvCoef(w->memory, 0.3);
  return flag;
}

static int attach_newton(work *w)
{
  w->matrix = sdr_sun_matrix_create(w->context);
  const int iterates = sdr_reduced_solver_iterates(w->reduced);
  w->linear = sdr_sun_solver_create(w->context, iterates, solve, w);
  if (!w->matrix || !w->linear) return -1;
  int flag = CVodeSetLinearSolver(w->memory, w->linear, w->matrix);
  if (!flag) flag = CVodeSetLinSysFn(w->memory, make_matrix);
  if (!flag && iterates) flag = CVodeSetLinearSolutionScaling(w->memory, SUNFALSE);
  return flag ? flag : tune_newton(w, iterates);
}

static int attach_fixed_point(work *w)
{
  w->nonlinear = SUNNonlinSol_FixedPoint(w->y, 0, w->context);
  return w->nonlinear ? CVodeSetNonlinearSolver(w->memory, w->nonlinear) : -1;
}

static sdr_status open_method(work *w)
{
  enum { MOST_FAILURES = 30 };
  const sdr_time_scene *how = w->system->how;
  SDR_TRY(make_vectors(w));
  sdr_motion_take(w->motion, values(w->y), values(w->y) + w->size);
  w->memory = CVodeCreate(how->adams ? CV_ADAMS : CV_BDF, w->context);
  if (!w->memory) return complain(w);
  int flag = CVodeSetErrHandlerFn(w->memory, sdr_sun_remember, &w->complaint);
  if (!flag) flag = CVodeInit(w->memory, slope_of, w->system->time, w->y);
  if (!flag) flag = CVodeWFtolerances(w->memory, weigh);
  if (!flag) flag = CVodeSetUserData(w->memory, w);
  if (!flag && how->order > 0) flag = CVodeSetMaxOrd(w->memory, how->order);
  if (!flag) flag = CVodeSetMaxStep(w->memory, w->longest);
  if (!flag) flag = CVodeSetMaxConvFails(w->memory, MOST_FAILURES);
  if (!flag) flag = CVodeSetMaxErrTestFails(w->memory, MOST_FAILURES);
  if (!flag) flag = CVodeSetMaxHnilWarns(w->memory, -1);
  if (!flag) flag = how->adams ? attach_fixed_point(w) : attach_newton(w);
  N_VConst(0.0, w->outside);
  if (!flag && sdr_motion_driven(w->motion))
    flag = CVodeQuadInit(w->memory, outside_of, w->outside);
  return flag ? complain(w) : SDR_OK;
}

static void count(const work *w, sdr_method_record *out)
{
  long steps = 0, slopes = 0, setups = 0, errors = 0, iterations = 0, failures = 0;
  double first, last, next, time;
  int order = 0, next_order;
  CVodeGetIntegratorStats(w->memory, &steps, &slopes, &setups, &errors, &order, &next_order, &first,
                          &last, &next, &time);
  CVodeGetNonlinSolvStats(w->memory, &iterations, &failures);
  *out = w->before;
  out->steps += steps;
  out->evaluations += slopes;
  out->iterations += iterations;
  out->error_failures += errors;
  out->iteration_failures += failures;
  out->order = order;
  out->last_step = last;
}

/* From the system's state on: the method forgets what was before. */
static sdr_status begin(work *w)
{
  const int32_t size = sdr_motion_constraints(w->motion)->free;
  memset(w->known, 0, sizeof w->known);
  w->force_time = NAN;
  if (w->memory) count(w, &w->before);
  if (!w->memory || size != w->size) {
    close_method(w);
    w->size = size;
    SDR_TRY(open_method(w));
  } else {
    sdr_motion_take(w->motion, values(w->y), values(w->y) + w->size);
    N_VConst(0.0, w->outside);
    int flag = CVodeReInit(w->memory, w->system->time, w->y);
    if (!flag && sdr_motion_driven(w->motion)) flag = CVodeQuadReInit(w->memory, w->outside);
    if (flag) return complain(w);
  }
  if (CVodeSetStopTime(w->memory, sdr_motion_until(w->motion))) return complain(w);
  return SDR_OK;
}

static sdr_status next_stretch(void *given, int silent)
{
  work *w = given;
  int renumbered;
  SDR_TRY(sdr_motion_begin(w->motion, w->system->how->end, &renumbered));
  SDR_TRY(sdr_motion_jump(w->motion, silent));
  if (renumbered) w->size = -1;
  return begin(w);
}

static sdr_status check_masses(const sdr_system *system)
{
  for (int32_t i = 0; i < system->count; ++i)
    if (sdr_in_body(system->model->points, i) && !(system->mass[i] > 0.0))
      return sdr_fail(SDR_BAD_INPUT,
                      "time.integrator: cvode needs a mass at every point; take ida for bodies "
                      "without mass, with time.viscosity");
  return SDR_OK;
}

static sdr_status create(sdr_system *system, double dt, const sdr_method_record *before, void **out)
{
  work *w = sdr_alloc(1, sizeof *w);
  if (!w) return SDR_RUN_FAILED;
  double stable = 0.0;
  w->system = system;
  w->before = *before;
  w->longest = dt;
  w->held = sdr_supports_count(system->supports) > 0 || system->layers;
  sdr_status status = check_masses(system);
  if (status == SDR_OK) status = sdr_stable_step(system, &stable);
  if (status == SDR_OK) status = sdr_tolerances_choose(system, stable, &w->tolerances);
  if (status == SDR_OK) status = sdr_motion_create(system, &w->motion);
  if (status == SDR_OK && !system->how->adams)
    status = sdr_reduced_solver_create(system->model, system->how->solver, &w->reduced);
  if (status == SDR_OK && !system->how->adams)
    status = sdr_mean_solver_create(w->reduced, w->motion, &w->solver);
  if (status == SDR_OK && SUNContext_Create(NULL, &w->context))
    status = sdr_fail(SDR_RUN_FAILED, "SUNDIALS cannot start: out of memory");
  if (status == SDR_OK)
    *out = w;
  else
    end_work(w);
  return status;
}

static const char *name_of(const sdr_system *system)
{
  return system->how->adams ? "adams" : "bdf";
}

static sdr_motion *motion_of(void *given)
{
  return ((work *)given)->motion;
}

static const sdr_sun_method method = {name_of, create, end_work, next_stretch, motion_of};

static sdr_status start(sdr_system *system, double dt)
{
  return sdr_sun_start(&method, system, dt);
}

static sdr_status restart(sdr_system *system, double dt)
{
  return sdr_sun_restart(&method, system, dt);
}

/* ---- steps ----------------------------------------------------------------------------------- */

static sdr_status explain(const work *w, int flag)
{
  static const sdr_sun_reason known[] = {
      {CV_ERR_FAILURE, "no step was short enough for the tolerances",
       "take a larger time.tolerance, or leapfrog where bonds break all the time"},
      {CV_TOO_MUCH_ACC, "the tolerances are below what double precision can hold",
       "take a larger time.tolerance, tolerance_displacement or tolerance_velocity"},
      {CV_CONV_FAILURE, "the implicit equations of a step were not solved, however short it was",
       "take solver: cholmod or umfpack, or leapfrog where bonds break all the time"},
      {CV_LSETUP_FAIL, "the matrix of a step could not be made",
       "take solver: pcg, which needs the least memory"},
      {CV_LSOLVE_FAIL, "the linear equations of a step could not be solved",
       "take another time.solver"},
      {CV_REPTD_RHSFUNC_ERR, "forces are no numbers, however short the step",
       "look at the loads and the initial state"},
      {CV_FIRST_RHSFUNC_ERR, "forces are no numbers at the start",
       "look at the loads and the initial state"},
      {CV_TOO_CLOSE, "the time left is too short for a step", "end the run a little earlier"}};
  return sdr_sun_explain(w->system, "cvode", failure_of(w), flag, known,
                         sizeof known / sizeof *known);
}

typedef struct {
  work *w;
  double time;
  int flag;
} step_call;

/* As a task, so that denormal numbers count as zero: they fill the space ahead of a wave. */
static void take_step(void *context, int index)
{
  step_call *call = context;
  (void)index;
  call->flag = CVode(call->w->memory, sdr_motion_until(call->w->motion), call->w->y, &call->time,
                     CV_ONE_STEP);
}

/* Forces on q at the new state. Without supports and layers, whose reactions would be wanted, the
   method knows them well enough from its polynomial. */
static sdr_status find_forces(work *w, double t)
{
  const int32_t n = w->size;
  const double *mass = sdr_motion_mass(w->motion);
  if (w->held) {
    if (w->force_time == t) return SDR_OK;
    SDR_TRY(sdr_motion_place(w->motion, t, values(w->y)));
    sdr_motion_force(w->motion, w->g);
    return SDR_OK;
  }
  if (CVodeGetDky(w->memory, t, 1, w->slope)) return complain(w);
  for (int32_t k = 0; k < n; ++k) w->g[k] = mass[k] * values(w->slope)[n + k];
  return SDR_OK;
}

static sdr_status find_outside(work *w, double change[SDR_MOTION_RATES])
{
  double t;
  memset(change, 0, SDR_MOTION_RATES * sizeof *change);
  if (!sdr_motion_driven(w->motion)) return SDR_OK;
  if (CVodeGetQuad(w->memory, &t, w->outside)) return complain(w);
  for (int k = 0; k < SDR_MOTION_RATES; ++k) {
    change[k] = values(w->outside)[k] - w->known[k];
    w->known[k] = values(w->outside)[k];
  }
  return SDR_OK;
}

static sdr_status step(sdr_system *system, double dt)
{
  work *w = system->work;
  double change[SDR_MOTION_RATES];
  (void)dt;
  if (system->time >= sdr_motion_until(w->motion)) SDR_TRY(next_stretch(w, 0));
  step_call call = {.w = w};
  sdr_parallel_for(0, 1, 1, take_step, &call);
  if (call.flag < 0) return explain(w, call.flag);
  SDR_TRY(find_forces(w, call.time));
  SDR_TRY(find_outside(w, change));
  SDR_TRY(
      sdr_motion_accept(w->motion, call.time, values(w->y), values(w->y) + w->size, w->g, change));
  sdr_method_record counts;
  count(w, &counts);
  sdr_sun_report(system, w->reduced, &counts);
  return sdr_motion_broke(w->motion) ? begin(w) : SDR_OK;
}

const sdr_integrator sdr_cvode = {
    .name = "cvode",
    .doc = "BDF or Adams of variable order and step, to a tolerance; for smooth motion",
    .start = start,
    .step = step,
    .restart = restart,
    .chooses = 1};
