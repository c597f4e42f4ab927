/* precision mixed: displacements and forces of runs as whole numbers of 32 bits.

   Kernels take differences of displacements and sums of forces, and both are exact in whole
   numbers: differences even where the displacements themselves overflow, as long as the difference
   does not. So the unit of length follows from how far the ends of any bond have moved apart, which
   is known without looking at bonds in each step: it was measured a few steps ago, and since then
   no difference can have grown faster than the spread of the velocities. The unit of force follows
   in the same way from the largest force, which cannot grow faster than stiffness times that. */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/motion.h"

#include <float.h>
#include <math.h>

enum { MOST_STRIPES = 256, STEPS_A_MEASURE = 16, STEPS_A_WATCH = 4 };

typedef struct {
  sdr_bond_model *model;
  double *const *u, *const *v;
  const sdr_motion_kernels *kernels;
  sdr_spread spread[3][MOST_STRIPES];
  int32_t apart[MOST_STRIPES];
} mixed_call;

static void split_stripe(void *context, int s)
{
  mixed_call *call = context;
  const sdr_bond_body *body = &call->model->body;
  const sdr_points *points = body->points;
  const int32_t first = points->stripe_first[s], count = points->stripe_first[s + 1] - first;
  for (int a = 0; a < points->components; ++a)
    call->kernels->split(count, body->per_length_unit, call->u[a] + first, call->v[a] + first,
                         body->place[a] + first, &call->spread[a][s]);
}

static void measure_stripe(void *context, int s)
{
  mixed_call *call = context;
  const sdr_bond_model *model = call->model;
  const int64_t *const run = model->bonds->stripe_run;
  call->apart[s] = model->kernels->run_apart[model->head.points->components - 1](
      &model->body, run[s], run[s + 1]);
}

/* How far the ends of some bond have moved apart at most in one component, by the present places,
   m. */
static double measure(mixed_call *call)
{
  const sdr_bond_model *model = call->model;
  int32_t apart = 0;
  sdr_parallel_for(0, model->head.points->stripe_count, 1, measure_stripe, call);
  for (int s = 0; s < model->head.points->stripe_count; ++s)
    apart = call->apart[s] > apart ? call->apart[s] : apart;
  return (apart + 2.0) * model->body.length_unit; /* both ends are rounded */
}

/* The spread of all stripes' values: the most of any component. */
static sdr_spread whole_spread(const mixed_call *call)
{
  const sdr_points *points = call->model->head.points;
  sdr_spread all = {.low = 0.0, .high = 0.0, .largest = 0.0};
  for (int a = 0; a < points->components; ++a) {
    sdr_spread one = call->spread[a][0];
    for (int s = 0; s < points->stripe_count; ++s) {
      const sdr_spread *own = &call->spread[a][s];
      one.low = fmin(one.low, own->low);
      one.high = fmax(one.high, own->high);
      all.largest = fmax(all.largest, own->largest);
    }
    all.high = fmax(all.high, one.high - one.low);
  }
  return all;
}

/* The smallest power of two not below x > 0. */
static double next_power(double x)
{
  int exponent;
  const double half = frexp(x, &exponent);
  return ldexp(1.0, half == 0.5 ? exponent - 1 : exponent);
}

/* Set the unit of length from the bound `widest` (m) and the largest displacement: fractions of a
   displacement beyond double's digits mean nothing, and squares of lengths must stay in float. The
   spacing is a power of two of it, so that reference vectors of an upright lattice are exact. */
static void set_length_unit(sdr_bond_body *body, double widest, double largest)
{
  const double spacing = body->points->lattice_spacing;
  const double least = fmax(ldexp(largest, -50), ldexp(spacing, -56));
  body->length_unit = spacing * next_power(fmax(ldexp(widest, -29), least) / spacing);
  body->per_length_unit = 1.0 / body->length_unit;
}

/* What pairs of a class share, in these units. */
static void set_terms(sdr_bond_body *body)
{
  const double unit = body->length_unit, per_unit = body->per_length_unit;
  const double stiffness = body->stiffness * unit / body->force_unit;
  for (int c = 0; c < body->bonds->class_count; ++c) {
    const sdr_bond_class *class = &body->bonds->classes[c];
    sdr_terms_float *out = &body->float_terms[c];
    for (int a = 0; a < 3; ++a) out->xi[a] = (float)(class->xi[a] * per_unit);
    const double inverse = unit * unit * class->inverse_square;
    out->inverse_square = (float)inverse;
    out->wij = (float)(class->by_length_ij * stiffness);
    out->wji = (float)(class->by_length_ji * stiffness);
    const double left = (double)out->inverse_square * ((double)out->wij + (double)out->wji);
    out->rest =
        (float)(inverse * stiffness * (class->by_length_ij + class->by_length_ji) / left - 1.0);
  }
}

/* Five bonds (SDR_BAND) of force `largest` (N) together stay below 2^31 units. */
static void set_force_unit(sdr_bond_body *body, double largest)
{
  body->force_unit = next_power(ldexp(5.1 * largest, -31));
  set_terms(body);
}

/* The force that no bond can exceed: stiffness times the motion of its ends. */
static double most_force(const sdr_bond_model *model)
{
  const double apart = fmax(model->bound.widest, ldexp(model->body.length_unit, 20));
  return sqrt(3.0) * model->body.stiffest * apart;
}

void sdr_bond_take_bits(sdr_bond_model *model, int32_t bits)
{
  if (model->body.watch) model->bound.force = ((double)bits + 1.0) * model->body.force_unit;
}

/* How far any two points are apart in u at most, m. */
static double spread_of(const sdr_points *points, double *const u[3])
{
  double most = 0.0;
  for (int a = 0; a < points->components; ++a) {
    double low = u[a][0], high = u[a][0];
    for (int32_t i = 1; i < points->count; ++i) {
      low = fmin(low, u[a][i]);
      high = fmax(high, u[a][i]);
    }
    most = fmax(most, high - low);
  }
  return most;
}

void sdr_bond_split(sdr_bond_model *model, double *const u[3], double *const v[3], double dt)
{
  mixed_call call = {.model = model, .u = u, .v = v, .kernels = sdr_motion_kernels_best()};
  sdr_bond_body *body = &model->body;
  double *const widest = &model->bound.widest;
  const int known = dt > 0.0 && model->bound.unit > 0.0;
  body->length_unit = model->bound.unit;
  if (!known) {
    *widest = spread_of(body->points, u);
    set_length_unit(body, *widest, 0.0);
  } else if (++model->bound.steps >= STEPS_A_MEASURE) {
    *widest = measure(&call);
    model->bound.steps = 0.0;
    if (*widest < ldexp(body->length_unit, 27)) set_length_unit(body, *widest, 0.0);
  }
  body->per_length_unit = 1.0 / body->length_unit;
  const double before = *widest;
  for (int again = 0; again < 2; ++again) {
    sdr_parallel_for(0, body->points->stripe_count, 1, split_stripe, &call);
    const sdr_spread all = whole_spread(&call);
    *widest = before + (known ? dt * all.high : 0.0);
    if (*widest < ldexp(body->length_unit, 31) && all.largest < ldexp(body->length_unit, 51)) break;
    set_length_unit(body, *widest, all.largest);
  }
  model->bound.unit = body->length_unit;
  /* no law lets a force grow by more than stiffness times motion */
  const double most = most_force(model);
  model->bound.force += sqrt(3.0) * body->stiffest * (*widest - before);
  if (!known || model->bound.force > most) model->bound.force = most;
  set_force_unit(body, fmax(model->bound.force, ldexp(most, -24)));
  body->watch = fmod(model->bound.steps, STEPS_A_WATCH) == 0.0;
}

sdr_status sdr_bond_set_mixed(sdr_bond_body *body)
{
  const sdr_points *points = body->points;
  const size_t padded = sdr_points_padded(points);
  double stiffest = 1.0;
  int failed =
      !(body->float_terms = sdr_alloc((size_t)body->bonds->class_count, sizeof(sdr_terms_float)));
  for (int a = 0; a < points->components; ++a)
    failed |= !(body->place[a] = sdr_alloc(padded, sizeof(int32_t)));
  if (body->stiffness_at) {
    failed |= !(body->relative_stiffness = sdr_alloc(padded, sizeof(float)));
    failed |= !(body->float_threshold = sdr_alloc(padded, sizeof(float)));
  }
  if (failed) return SDR_RUN_FAILED;
  for (size_t i = 0; body->stiffness_at && i < padded; ++i) {
    body->relative_stiffness[i] = (float)(body->stiffness_at[i] / body->stiffness);
    body->float_threshold[i] = (float)body->threshold_at[i];
    stiffest = fmax(stiffest, body->stiffness_at[i] / body->stiffness);
  }
  for (int c = 0; c < body->bonds->class_count; ++c) {
    const sdr_bond_class *class = &body->bonds->classes[c];
    body->stiffest = fmax(body->stiffest, class->by_length_ij + class->by_length_ji);
  }
  body->stiffest *= stiffest * body->stiffness;
  body->mixed = 1;
  return SDR_OK;
}
