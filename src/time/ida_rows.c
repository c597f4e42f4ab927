/* What IDA calls: the rows of F (ida.c), and Newton's matrix with velocities eliminated. */
#include "time/ida_internal.h"

#include <math.h>
#include <nvector/nvector_serial.h>
#include <string.h>

static double *values(N_Vector vector)
{
  return N_VGetArrayPointer(vector);
}

double sdr_ida_viscous_of(const sdr_ida_work *w, int32_t k)
{
  const int massless = !(sdr_motion_mass(w->motion)[k] > 0.0);
  return massless && w->viscous ? w->viscous[sdr_motion_constraints(w->motion)->unknown[k]] : 0.0;
}

/* ---- what IDA calls -------------------------------------------------------------------------- */

static int judge(sdr_ida_work *w, sdr_status status)
{
  if (status == SDR_OK) return 0;
  w->failure = status;
  return -1;
}

/* The body at x; prescribed components where y has them. */
sdr_status sdr_ida_place(sdr_ida_work *w, double t, const double *x)
{
  sdr_system *system = w->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  SDR_TRY(sdr_motion_place(w->motion, t, x));
  for (int32_t k = w->free; k < w->size; ++k) {
    const sdr_prescribed *p = &list[w->entry[k - w->free]];
    system->u[p->component][p->point] = x[k];
  }
  if (system->layers && w->size > w->free) sdr_layers_follow(system->layers, system->u);
  return SDR_OK;
}

static void free_rows(const sdr_ida_work *w, const double *y, const double *slope, double *out)
{
  const int32_t size = w->size;
  const double *mass = sdr_motion_mass(w->motion);
  for (int32_t k = 0; k < w->free; ++k) {
    const double viscous = sdr_ida_viscous_of(w, k);
    if (mass[k] > 0.0) {
      out[k] = slope[k] - y[size + k];
      out[size + k] = mass[k] * slope[size + k] - w->g[k];
    } else {
      out[k] = viscous * slope[k] - w->g[k];
      out[size + k] = y[size + k] - (viscous > 0.0 ? slope[k] : 0.0);
    }
  }
}

static sdr_status prescribed_rows(sdr_ida_work *w, double t, const double *y, double *out)
{
  const int32_t size = w->size;
  for (int32_t k = w->free; k < size; ++k) {
    double position, rate, bend;
    SDR_TRY(sdr_motion_prescribed(w->motion, t, w->entry[k - w->free], &position, &rate, &bend));
    out[k] = y[k] - position;
    out[size + k] = y[size + k] - rate;
  }
  return SDR_OK;
}

static double viscous_power(const sdr_ida_work *w, const double *slope)
{
  double power = 0.0;
  for (int32_t k = 0; w->viscous && k < w->free; ++k)
    power += sdr_ida_viscous_of(w, k) * slope[k] * slope[k];
  return power;
}

sdr_status sdr_ida_rates(sdr_ida_work *w, double t, const double *y, const double *slope,
                         double rates[SDR_IDA_SUMS])
{
  SDR_TRY(sdr_motion_outside(w->motion, t, y + w->size, rates));
  rates[SDR_IDA_VISCOUS] = viscous_power(w, slope);
  return SDR_OK;
}

int sdr_ida_residual(realtype t, N_Vector y, N_Vector slope, N_Vector left, void *context)
{
  sdr_ida_work *w = context;
  const double *at = values(y), *rate = values(slope);
  double *out = values(left), sum = 0.0;
  sdr_status status = sdr_ida_place(w, t, at);
  if (status == SDR_OK) {
    sdr_motion_force(w->motion, w->g);
    free_rows(w, at, rate, out);
    status = prescribed_rows(w, t, at, out);
  }
  if (status != SDR_OK) return judge(w, status);
  for (int32_t k = 0; k < 2 * w->size; ++k) sum += fabs(out[k]);
  return isfinite(sum) ? 0 : 1;
}

/* weight = 1/(relative |y| + absolute). */
int sdr_ida_weigh(N_Vector y, N_Vector weight, void *context)
{
  const sdr_ida_work *w = context;
  const sdr_tolerances *t = &w->tolerances;
  const double *from = values(y);
  double *to = values(weight);
  for (int32_t k = 0; k < w->size; ++k) {
    to[k] = 1.0 / (t->relative * fabs(from[k]) + t->displacement);
    to[w->size + k] = 1.0 / (t->relative * fabs(from[w->size + k]) + t->velocity);
  }
  return 0;
}

static void find_diagonal(sdr_ida_work *w, double factor)
{
  const double *mass = sdr_motion_mass(w->motion);
  for (int32_t k = 0; k < w->free; ++k)
    w->diagonal[k] = mass[k] > 0.0 ? mass[k] * factor * factor : sdr_ida_viscous_of(w, k) * factor;
}

/* NOLINTNEXTLINE(readability-function-size): IDA gives it ten arguments */
int sdr_ida_make_matrix(realtype t, realtype factor, N_Vector y, N_Vector slope, N_Vector left,
                        SUNMatrix matrix, void *context, N_Vector a, N_Vector b, N_Vector c)
{
  sdr_ida_work *w = context;
  (void)slope, (void)left, (void)matrix, (void)a, (void)b, (void)c;
  int failed = judge(w, sdr_ida_place(w, t, values(y)));
  if (!failed)
    failed = judge(
        w, sdr_reduced_solver_tangent(w->reduced, sdr_motion_constraints(w->motion), w->system->u));
  if (failed) return failed;
  find_diagonal(w, factor);
  w->made_factor = factor;
  return sdr_reduced_solver_prepare(w->reduced, w->diagonal);
}

/* What known corrections of prescribed components pull free ones with. */
static void pull_of_prescribed(sdr_ida_work *w, const double *b)
{
  const sdr_prescribed *list = sdr_supports_list(w->system->supports);
  const int m = w->system->components;
  double most = 0.0;
  for (int32_t k = w->free; k < w->size; ++k) {
    const sdr_prescribed *p = &list[w->entry[k - w->free]];
    w->full[p->point * m + p->component] = b[k];
    most = fmax(most, fabs(b[k]));
  }
  memset(w->right, 0, (size_t)w->free * sizeof *w->right);
  if (most > 0.0) sdr_reduced_solver_pull(w->reduced, w->full, w->right);
  for (int32_t k = w->free; k < w->size; ++k) {
    const sdr_prescribed *p = &list[w->entry[k - w->free]];
    w->full[p->point * m + p->component] = 0.0;
  }
}

/* How residuals of the reduced system show in the error weights: by masses, or by a stiffness as
   low as that of smooth motions. */
static void find_scale(sdr_ida_work *w, const double *weight, double factor)
{
  for (int32_t k = 0; k < w->free; ++k) {
    const int massless = !(sdr_motion_mass(w->motion)[k] > 0.0);
    const double stiffness = massless ? 1e-3 * sdr_reduced_solver_stiffness(w->reduced, k) : 0.0;
    const double resistance = w->diagonal[k] + fmax(stiffness, 0.0);
    const double way = weight[k] / resistance;
    const double speed = massless ? 0.0 : weight[w->size + k] * factor / resistance;
    w->scale[k] = sqrt(0.5 * (way * way + speed * speed));
  }
}

int sdr_ida_solve(void *context, double *x, const double *b, const double *weight, double tolerance)
{
  sdr_ida_work *w = context;
  const int32_t size = w->size;
  const double *mass = sdr_motion_mass(w->motion);
  double factor = w->made_factor, now = factor, share = 1.0;
  IDAGetCurrentCj(w->memory, &now);
  if (!(now > 0.0)) now = factor; /* before the first step */
  if (sdr_reduced_solver_iterates(w->reduced)) {
    factor = now;
    find_diagonal(w, factor);
    find_scale(w, weight, factor);
  } else {
    share = 2.0 / (1.0 + now / factor); /* the factor is of another step: as IDA would do */
  }
  pull_of_prescribed(w, b);
  for (int32_t k = 0; k < w->free; ++k) {
    const double inertia = mass[k] > 0.0 ? b[size + k] + mass[k] * factor * b[k] : b[k];
    w->right[k] = inertia - w->right[k];
  }
  const sdr_reduced_aim aim = {w->diagonal, w->scale, tolerance / sqrt(2.0 * size)};
  const int result = sdr_mean_solver_solve(w->solver, &aim, factor, w->right, x);
  for (int32_t k = 0; k < w->free; ++k) {
    x[k] *= share;
    if (mass[k] > 0.0)
      x[size + k] = now * x[k] - b[k];
    else
      x[size + k] = b[size + k] + (sdr_ida_viscous_of(w, k) > 0.0 ? now * x[k] : 0.0);
  }
  for (int32_t k = w->free; k < size; ++k) {
    x[k] = b[k];
    x[size + k] = b[size + k];
  }
  return result;
}
