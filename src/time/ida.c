/* IDA on F(t, y, y') = 0 with supports as algebraic rows. With x the free components q and then the
   prescribed ones, y = (x, w):

     free, with mass      q' - w = 0                     M w' - g = 0
     free, without mass   C q' - g = 0                   w - q' = 0   (w = 0 where C = 0)
     prescribed           x - X(t) = 0                   w - X'(t) = 0

   g = P^T f(u) + loads, C = viscosity times the stiffness of a point at rest. Newton's matrix
   dF/dy + c dF/dy' leaves, w eliminated,

     (D + P^T K B) dq = r + ... - P^T K dx,   D = M c^2 or C c,   dx of the prescribed known.

   Consistent values at the start, and after each event, come from IDACalcIC. IDA tests its
   iteration by the size of the last correction; so the residual is looked at after each step. Work,
   impulses and viscous work are summed by Simpson's rule over each step's polynomial. */
#include "base/memory.h"
#include "base/parallel.h"
#include "time/ida_internal.h"
#include "time/integrator.h"
#include "time/stable_step.h"
#include "time/sun_vectors.h"

#include <math.h>
#include <nvector/nvector_serial.h>
#include <string.h>

static double *values(N_Vector vector)
{
  return N_VGetArrayPointer(vector);
}

/* ---- creation -------------------------------------------------------------------------------- */

static void close_method(sdr_ida_work *w)
{
  if (w->memory) IDAFree(&w->memory);
  if (w->linear) SUNLinSolFree(w->linear);
  if (w->matrix) SUNMatDestroy(w->matrix);
  N_Vector *const vectors[] = {&w->y, &w->slope, &w->kind, &w->left, &w->middle, &w->middle_slope};
  for (size_t k = 0; k < sizeof vectors / sizeof *vectors; ++k) {
    if (*vectors[k]) N_VDestroy(*vectors[k]);
    *vectors[k] = NULL;
  }
  w->linear = NULL;
  w->matrix = NULL;
  sdr_free(w->entry);
  sdr_free(w->g);
  sdr_free(w->diagonal);
  sdr_free(w->right);
  sdr_free(w->scale);
  w->entry = NULL;
  w->g = w->diagonal = w->right = w->scale = NULL;
}

static void end_work(void *given)
{
  sdr_ida_work *w = given;
  close_method(w);
  if (w->context) SUNContext_Free(&w->context);
  sdr_mean_solver_destroy(&w->solver);
  sdr_reduced_solver_destroy(&w->reduced);
  sdr_motion_destroy(&w->motion);
  sdr_free(w->viscous);
  sdr_free(w->full);
  sdr_free(w);
}

/* ---- starting -------------------------------------------------------------------------------- */

static sdr_sun_failure failure_of(const sdr_ida_work *w)
{
  return (sdr_sun_failure){w->failure, &w->complaint};
}

static sdr_status complain(const sdr_ida_work *w)
{
  return sdr_sun_complain("IDA", failure_of(w));
}

static sdr_status number(sdr_ida_work *w)
{
  const sdr_constraints *c = sdr_motion_constraints(w->motion);
  const sdr_prescribed *list = sdr_supports_list(w->system->supports);
  const int32_t count = sdr_supports_count(w->system->supports);
  w->entry = sdr_alloc((size_t)count, sizeof *w->entry);
  if (!w->entry) return SDR_RUN_FAILED;
  w->free = w->size = c->free;
  for (int32_t k = 0; k < count; ++k)
    if (sdr_motion_prescribes(w->motion, k) &&
        c->prescribed[list[k].point * w->system->components + list[k].component])
      w->entry[w->size++ - w->free] = k;
  return SDR_OK;
}

static sdr_status make_vectors(sdr_ida_work *w)
{
  SDR_TRY(number(w));
  const size_t n = (size_t)w->free;
  w->g = sdr_alloc(n, sizeof(double));
  w->diagonal = sdr_alloc(n, sizeof(double));
  w->right = sdr_alloc(n, sizeof(double));
  w->scale = sdr_alloc(n, sizeof(double));
  w->y = N_VNew_Serial(2 * (sunindextype)w->size, w->context);
  if (!w->g || !w->diagonal || !w->right || !w->scale || !w->y) return complain(w);
  sdr_sun_quicken(w->y);
  w->slope = N_VClone(w->y);
  w->kind = N_VClone(w->y);
  w->left = N_VClone(w->y);
  w->middle = N_VClone(w->y);
  w->middle_slope = N_VClone(w->y);
  const int whole = w->slope && w->kind && w->left && w->middle && w->middle_slope;
  return whole ? SDR_OK : complain(w);
}

/* 1 for differential entries, 0 for algebraic ones. */
static void find_kinds(sdr_ida_work *w)
{
  double *kind = values(w->kind);
  const double *mass = sdr_motion_mass(w->motion);
  N_VConst(0.0, w->kind);
  for (int32_t k = 0; k < w->free; ++k) {
    kind[k] = mass[k] > 0.0 || sdr_ida_viscous_of(w, k) > 0.0;
    kind[w->size + k] = mass[k] > 0.0;
  }
}

/* The system's state, and the best that is known of its rates. */
static sdr_status guess(sdr_ida_work *w)
{
  const int32_t size = w->size;
  const double *mass = sdr_motion_mass(w->motion);
  const double t = w->system->time;
  double *y = values(w->y), *slope = values(w->slope);
  N_VConst(0.0, w->y);
  N_VConst(0.0, w->slope);
  sdr_motion_take(w->motion, y, y + size);
  for (int32_t k = w->free; k < size; ++k) {
    SDR_TRY(sdr_motion_prescribed(w->motion, t, w->entry[k - w->free], &y[k], &y[size + k],
                                  &slope[size + k]));
    slope[k] = y[size + k];
  }
  SDR_TRY(sdr_ida_place(w, t, y));
  sdr_motion_force(w->motion, w->g);
  for (int32_t k = 0; k < w->free; ++k) {
    const double viscous = sdr_ida_viscous_of(w, k);
    if (!(mass[k] > 0.0)) y[size + k] = viscous > 0.0 ? w->g[k] / viscous : 0.0;
    slope[k] = y[size + k];
    slope[size + k] = mass[k] > 0.0 ? w->g[k] / mass[k] : 0.0;
  }
  return SDR_OK;
}

static int attach(sdr_ida_work *w)
{
  w->matrix = sdr_sun_matrix_create(w->context);
  const int iterates = sdr_reduced_solver_iterates(w->reduced);
  w->linear = sdr_sun_solver_create(w->context, iterates, sdr_ida_solve, w);
  if (!w->matrix || !w->linear) return -1;
  int flag = IDASetLinearSolver(w->memory, w->linear, w->matrix);
  if (!flag) flag = IDASetJacFn(w->memory, sdr_ida_make_matrix);
  if (!flag) flag = IDASetLinearSolutionScaling(w->memory, SUNFALSE); /* solve does */
  return flag;
}

static sdr_status open_method(sdr_ida_work *w)
{
  enum { MOST_FAILURES = 30 };
  const sdr_time_scene *how = w->system->how;
  SDR_TRY(make_vectors(w));
  SDR_TRY(guess(w));
  find_kinds(w);
  w->memory = IDACreate(w->context);
  if (!w->memory) return complain(w);
  int flag = IDASetErrHandlerFn(w->memory, sdr_sun_remember, &w->complaint);
  if (!flag) flag = IDAInit(w->memory, sdr_ida_residual, w->system->time, w->y, w->slope);
  if (!flag) flag = IDAWFtolerances(w->memory, sdr_ida_weigh);
  if (!flag) flag = IDASetUserData(w->memory, w);
  if (!flag) flag = IDASetId(w->memory, w->kind);
  if (!flag) flag = IDASetSuppressAlg(w->memory, SUNTRUE);
  if (!flag && how->order > 0) flag = IDASetMaxOrd(w->memory, how->order);
  if (!flag) flag = IDASetMaxStep(w->memory, w->longest);
  if (!flag) flag = IDASetMaxConvFails(w->memory, MOST_FAILURES);
  if (!flag) flag = IDASetMaxErrTestFails(w->memory, MOST_FAILURES);
  /* where nothing is differential no error tells that the first steps are of first order */
  if (!flag && !w->has_mass) flag = IDASetInitStep(w->memory, 1e-4 * w->longest);
  if (!flag) flag = attach(w);
  return flag ? complain(w) : SDR_OK;
}

static void count(const sdr_ida_work *w, sdr_method_record *out)
{
  long steps = 0, residuals = 0, setups = 0, errors = 0, iterations = 0, failures = 0;
  double first, last, next, time;
  int order = 0, next_order;
  IDAGetIntegratorStats(w->memory, &steps, &residuals, &setups, &errors, &order, &next_order,
                        &first, &last, &next, &time);
  IDAGetNonlinSolvStats(w->memory, &iterations, &failures);
  *out = w->before;
  out->steps += steps;
  out->evaluations += residuals;
  out->iterations += iterations;
  out->error_failures += errors;
  out->iteration_failures += failures;
  out->order = order;
  out->last_step = last;
}

/* Rates of the sums where a stretch begins. */
static sdr_status look_at_start(sdr_ida_work *w)
{
  const double t = w->system->time;
  SDR_TRY(sdr_ida_place(w, t, values(w->y)));
  sdr_motion_force(w->motion, w->g);
  return sdr_ida_rates(w, t, values(w->y), values(w->slope), w->rates);
}

/* Consistent values for the rows that hold now; `ahead`: a moment to say which way time goes. */
static sdr_status make_consistent(sdr_ida_work *w)
{
  const double t = w->system->time, until = sdr_motion_until(w->motion);
  const double ahead = t + fmin(0.1 * w->longest, 0.01 * (until - t));
  if (IDASetStopTime(w->memory, until)) return complain(w);
  const int flag = IDACalcIC(w->memory, IDA_YA_YDP_INIT, ahead);
  if (flag == IDA_SUCCESS) {
    if (IDAGetConsistentIC(w->memory, w->y, w->slope)) return complain(w);
    return look_at_start(w);
  }
  if (w->failure != SDR_OK) return w->failure;
  return sdr_fail(SDR_RUN_FAILED,
                  "ida found no consistent values to start from at t = %.6g s: %s; let loads and "
                  "supports set in with a ramp, or give points without mass a time.viscosity",
                  t, w->complaint.text);
}

static sdr_status begin(sdr_ida_work *w, int renumbered)
{
  if (w->memory) count(w, &w->before);
  if (!w->memory || renumbered) {
    close_method(w);
    SDR_TRY(open_method(w));
  } else {
    SDR_TRY(guess(w));
    if (IDAReInit(w->memory, w->system->time, w->y, w->slope)) return complain(w);
  }
  return make_consistent(w);
}

static sdr_status next_stretch(void *given, int silent)
{
  sdr_ida_work *w = given;
  int renumbered;
  SDR_TRY(sdr_motion_begin(w->motion, w->system->how->end, &renumbered));
  SDR_TRY(sdr_motion_jump(w->motion, silent));
  return begin(w, renumbered);
}

/* C of every component that has no mass. */
static sdr_status find_viscosity(sdr_ida_work *w)
{
  sdr_system *system = w->system;
  const size_t m = (size_t)system->components;
  double *stiffness = NULL;
  if (!(system->how->viscosity > 0.0)) return SDR_OK;
  w->viscous = sdr_alloc((size_t)system->count * m, sizeof(double));
  stiffness = sdr_alloc((size_t)system->count * m * m, sizeof(double));
  sdr_status status = w->viscous && stiffness ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK)
    status = system->model->ops->tangent_diagonal(system->model, system->u, stiffness);
  for (size_t r = 0; status == SDR_OK && r < (size_t)system->count * m; ++r)
    w->viscous[r] = system->how->viscosity * stiffness[r / m * m * m + r % m * (m + 1)];
  sdr_free(stiffness);
  return status;
}

static sdr_status create(sdr_system *system, double dt, const sdr_method_record *before, void **out)
{
  sdr_ida_work *w = sdr_alloc(1, sizeof *w);
  if (!w) return SDR_RUN_FAILED;
  double stable = 0.0;
  w->system = system;
  w->before = *before;
  w->longest = dt;
  w->full = sdr_alloc((size_t)(system->count * system->components), sizeof(double));
  sdr_status status = w->full ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) status = sdr_stable_step(system, &stable);
  w->has_mass = !isnan(stable);
  if (status == SDR_OK) status = sdr_tolerances_choose(system, stable, &w->tolerances);
  if (status == SDR_OK) status = find_viscosity(w);
  if (status == SDR_OK) status = sdr_motion_create(system, &w->motion);
  if (status == SDR_OK) sdr_motion_resist(w->motion, w->viscous);
  if (status == SDR_OK)
    status = sdr_reduced_solver_create(system->model, system->how->solver, &w->reduced);
  if (status == SDR_OK) status = sdr_mean_solver_create(w->reduced, w->motion, &w->solver);
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
  (void)system;
  return "ida";
}

static sdr_motion *motion_of(void *given)
{
  return ((sdr_ida_work *)given)->motion;
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

static sdr_status explain(const sdr_ida_work *w, int flag)
{
  static const sdr_sun_reason known[] = {
      {IDA_ERR_FAIL, "no step was short enough for the tolerances",
       "take a larger time.tolerance, or some time.viscosity for points without mass"},
      {IDA_TOO_MUCH_ACC, "the tolerances are below what double precision can hold",
       "take a larger time.tolerance, tolerance_displacement or tolerance_velocity"},
      {IDA_CONV_FAIL, "the implicit equations of a step were not solved, however short it was",
       "take solver: cholmod or umfpack; a body without mass that breaks needs time.viscosity"},
      {IDA_LSETUP_FAIL, "the matrix of a step could not be made", "take solver: pcg"},
      {IDA_LSOLVE_FAIL, "the linear equations of a step could not be solved",
       "take another time.solver"},
      {IDA_REP_RES_ERR, "forces are no numbers, however short the step",
       "look at the loads and the initial state"}};
  return sdr_sun_explain(w->system, "ida", failure_of(w), flag, known,
                         sizeof known / sizeof *known);
}

typedef struct {
  sdr_ida_work *w;
  double time;
  int flag;
} step_call;

static void take_step(void *context, int index)
{
  step_call *call = context;
  (void)index;
  call->flag = IDASolve(call->w->memory, sdr_motion_until(call->w->motion), &call->time, call->w->y,
                        call->w->slope, IDA_ONE_STEP);
}

/* Forces that are left over at the free components, over those that act on the body, supports'
   included, and ten times those of a displacement as small as its tolerance; g is known then. */
static sdr_status check_residual(sdr_ida_work *w, double t)
{
  const sdr_system *system = w->system;
  const double *mass = sdr_motion_mass(w->motion), *left = values(w->left);
  double over = 0.0, whole = 0.0;
  if (sdr_ida_residual(t, w->y, w->slope, w->left, w) < 0) return complain(w);
  for (int32_t k = 0; k < w->free; ++k) {
    const double rest = mass[k] > 0.0 ? left[w->size + k] : left[k];
    const double stiffness = w->diagonal[k] + fabs(sdr_reduced_solver_stiffness(w->reduced, k));
    const double slight = 10.0 * stiffness * w->tolerances.displacement;
    over += rest * rest;
    whole += w->g[k] * w->g[k] + slight * slight;
  }
  for (int a = 0; a < system->components; ++a)
    for (int32_t i = 0; i < system->count; ++i) whole += system->f[a][i] * system->f[a][i];
  const double share = whole > 0.0 ? sqrt(over / whole) : 0.0;
  w->system->method.residual = fmax(w->system->method.residual, share);
  if (share <= 0.1) return SDR_OK;
  return sdr_fail(SDR_RUN_FAILED,
                  "ida accepted a step to t = %.6g s although %.2g of the forces are not balanced; "
                  "take a smaller time.tolerance or, for points without mass, a larger "
                  "time.viscosity",
                  t, share);
}

/* Simpson's rule for the sums of the step to time t; g and the forces are those at t then. */
static sdr_status find_sums(sdr_ida_work *w, double t, double sums[SDR_IDA_SUMS])
{
  const double h = t - w->system->time, half = t - 0.5 * h;
  double middle[SDR_IDA_SUMS], end[SDR_IDA_SUMS];
  if (IDAGetDky(w->memory, half, 0, w->middle) || IDAGetDky(w->memory, half, 1, w->middle_slope))
    return complain(w);
  SDR_TRY(sdr_ida_place(w, half, values(w->middle)));
  sdr_motion_force(w->motion, w->g);
  SDR_TRY(sdr_ida_rates(w, half, values(w->middle), values(w->middle_slope), middle));
  SDR_TRY(check_residual(w, t));
  SDR_TRY(sdr_ida_rates(w, t, values(w->y), values(w->slope), end));
  for (int k = 0; k < SDR_IDA_SUMS; ++k) {
    sums[k] = h / 6.0 * (w->rates[k] + 4.0 * middle[k] + end[k]);
    w->rates[k] = end[k];
  }
  return SDR_OK;
}

static sdr_status step(sdr_system *system, double dt)
{
  sdr_ida_work *w = system->work;
  double change[SDR_IDA_SUMS];
  (void)dt;
  if (system->time >= sdr_motion_until(w->motion)) SDR_TRY(next_stretch(w, 0));
  step_call call = {.w = w};
  sdr_parallel_for(0, 1, 1, take_step, &call);
  if (call.flag < 0) return explain(w, call.flag);
  SDR_TRY(find_sums(w, call.time, change));
  system->viscous += change[SDR_IDA_VISCOUS];
  SDR_TRY(
      sdr_motion_accept(w->motion, call.time, values(w->y), values(w->y) + w->size, w->g, change));
  sdr_method_record counts;
  count(w, &counts);
  sdr_sun_report(system, w->reduced, &counts);
  return sdr_motion_broke(w->motion) ? begin(w, 0) : SDR_OK;
}

const sdr_integrator sdr_ida = {
    .name = "ida",
    .doc = "BDF to a tolerance with supports as algebraic rows; bodies without mass, viscosity",
    .start = start,
    .step = step,
    .restart = restart,
    .chooses = 1};
