#include "mechanics/ordinary.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/isa.h"
#include "mechanics/records.h"

#include <math.h>
#include <string.h>

/* ---- force ----------------------------------------------------------------------------------- */

typedef struct {
  sdr_ordinary *o;
  sdr_ordinary_sums run_sums, loose_sums;
  sdr_ordinary_force run_force, loose_force;
  sdr_ordinary_points points;
  double *const *u, *const *f;
  int squares, commit;
} pass;

static void zero_range(double *array, int32_t first, int32_t end)
{
  if (array) memset(array + first, 0, (size_t)(end - first) * sizeof *array);
}

/* What loose pairs read of the points of stripe s: a component, or a coefficient behind them. */
static void write_records(const sdr_ordinary *o, int s, int at, const double *from)
{
  const sdr_points *points = o->body.head.points;
  for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i)
    o->records[(size_t)i * SDR_RECORD + (size_t)at] = from[i];
}

/* Even stripes come first: they clear their own sums and the next stripe's, where they add. */
static void sums_of_stripe(void *context, int s)
{
  const pass *call = context;
  sdr_ordinary *o = call->o;
  const sdr_points *points = o->body.head.points;
  const int32_t *stripe = points->stripe_first;
  for (int k = s; s % 2 == 0 && k < s + 2 && k < points->stripe_count; ++k) {
    zero_range(o->sum, stripe[k], stripe[k + 1]);
    zero_range(o->lost, stripe[k], stripe[k + 1]);
    if (call->squares) zero_range(o->square, stripe[k], stripe[k + 1]);
  }
  for (int a = 0; o->records && a < points->components; ++a) write_records(o, s, a, call->u[a]);
  if (sdr_state_rests(&o->body, s, 0, 1)) return;
  const int64_t *run = o->body.bonds->stripe_run;
  call->run_sums(o, run[s], run[s + 1], call->u);
}

static void loose_sums_of_stripe(void *context, int s)
{
  const pass *call = context;
  int64_t first, end;
  sdr_state_chunks(&call->o->body, s, &first, &end);
  call->loose_sums(call->o, first, end, call->u);
}

static void each_sum(pass *call)
{
  const sdr_points *points = call->o->body.head.points;
  sdr_state_watch(&call->o->body, call->u);
  sdr_each_stripe(points, sums_of_stripe, call);
  if (call->o->body.bonds->loose.chunk_count > 0)
    sdr_parallel_for(0, points->stripe_count, 1, loose_sums_of_stripe, call);
}

void sdr_ordinary_sum(sdr_ordinary *o, double *const u[3], sdr_flags_use use, int squares)
{
  const int n = o->body.head.points->components - 1;
  pass call = {.o = o,
               .run_sums = squares ? o->kernels->run_squares[n] : o->kernels->run_sums[n][use],
               .loose_sums =
                   squares ? o->kernels->loose_squares[n] : o->kernels->loose_sums[n][use],
               .u = u,
               .squares = squares};
  each_sum(&call);
}

/* Even stripes get the coefficients of their own points and the next stripe's, and clear the forces
   of both. */
static void force_of_stripe(void *context, int s)
{
  const pass *call = context;
  sdr_ordinary *o = call->o;
  const sdr_points *points = o->body.head.points;
  const int32_t *stripe = points->stripe_first;
  for (int k = s; s % 2 == 0 && k < s + 2 && k < points->stripe_count; ++k) {
    call->points(o, stripe[k], stripe[k + 1], call->commit);
    for (int a = 0; a < points->components; ++a) zero_range(call->f[a], stripe[k], stripe[k + 1]);
    if (o->records) write_records(o, k, points->components, o->along);
    if (o->records && points->components < 3)
      write_records(o, k, points->components + 1, o->across);
  }
  /* Loose pairs reach any stripe, and so do the sums that they add to. */
  if (o->body.bonds->loose.chunk_count == 0 && sdr_state_rests(&o->body, s, 1, 2)) return;
  const int64_t *run = o->body.bonds->stripe_run;
  call->run_force(o, run[s], run[s + 1], call->u, call->f);
}

static void loose_force_of_stripe(void *context, int s)
{
  const pass *call = context;
  int64_t first, end;
  sdr_state_chunks(&call->o->body, s, &first, &end);
  call->loose_force(call->o, first, end, call->u, call->f);
}

static void each_force(pass *call)
{
  const sdr_points *points = call->o->body.head.points;
  sdr_each_stripe(points, force_of_stripe, call);
  if (call->o->body.bonds->loose.chunk_count > 0)
    sdr_parallel_for(0, points->stripe_count, 1, loose_force_of_stripe, call);
}

/* Forces of the sums and flags as they are. */
static void force_of_sums(sdr_ordinary *o, int commit, double *const u[3], double *const f[3])
{
  const int n = o->body.head.points->components - 1;
  pass call = {.o = o,
               .run_force = o->kernels->run_force[n],
               .loose_force = o->kernels->loose_force[n],
               .points = o->kernels->points[o->body.law],
               .u = u,
               .f = f,
               .commit = commit};
  each_force(&call);
}

static void force(sdr_model *model, double *const u[3], double *const f[3])
{
  sdr_ordinary *o = (sdr_ordinary *)model;
  sdr_ordinary_sum(o, u, SDR_FLAGS_KEEP, o->body.law == SDR_LAW_VARIATIONAL);
  force_of_sums(o, 0, u, f);
}

static void force_commit(sdr_model *model, double *const u[3], double *const v[3], double dt,
                         double *const f[3])
{
  sdr_ordinary *o = (sdr_ordinary *)model;
  const int breaks = o->body.law == SDR_LAW_CRITICAL_STRETCH;
  sdr_ordinary_sum(o, u, breaks ? SDR_FLAGS_COMMIT : SDR_FLAGS_KEEP,
                   o->body.law == SDR_LAW_VARIATIONAL);
  if (breaks) sdr_state_book(&o->body, u, v, dt);
  force_of_sums(o, 1, u, f);
}

/* The stiffness of the reference shape is the force of small displacements, with no rest. */
void sdr_ordinary_reference_times(sdr_model *model, double *const v[3], double *const out[3])
{
  sdr_ordinary *o = (sdr_ordinary *)model;
  const int n = model->points->components - 1, kept = o->body.keep_resting;
  const int critical = o->body.law == SDR_LAW_CRITICAL_STRETCH;
  pass call = {.o = o,
               .run_sums = o->kernels->run_linear_sums[n],
               .loose_sums = o->kernels->loose_linear_sums[n],
               .run_force = o->kernels->run_linear_force[n],
               .loose_force = o->kernels->loose_linear_force[n],
               .points = o->kernels->points[critical ? SDR_LAW_CRITICAL_STRETCH : SDR_LAW_NONE],
               .u = v,
               .f = out};
  const sdr_points *points = model->points;
  o->body.keep_resting = 1;
  sdr_each_stripe(points, sums_of_stripe, &call);
  if (o->body.bonds->loose.chunk_count > 0)
    sdr_parallel_for(0, points->stripe_count, 1, loose_sums_of_stripe, &call);
  each_force(&call);
  o->body.keep_resting = kept;
}

/* ---- hooks ----------------------------------------------------------------------------------- */

static const char *isa(const sdr_state_body *body)
{
  return ((const sdr_ordinary *)body)->kernels->name;
}

static void split_stripe(void *context, int s)
{
  sdr_ordinary *o = context;
  const int32_t *stripe = o->body.head.points->stripe_first;
  for (int32_t i = stripe[s]; i < stripe[s + 1]; ++i) {
    const sdr_ordinary_constants of = sdr_ordinary_now(o, i);
    const sdr_ordinary_point now =
        sdr_ordinary_point_of(&of, o->body.bulk[i], o->sum[i], o->square[i]);
    o->body.plus[i] = now.plus;
    o->body.minus[i] = now.minus;
  }
}

static void split(sdr_state_body *body, double *const u[3])
{
  sdr_ordinary *o = (sdr_ordinary *)body;
  sdr_ordinary_sum(o, u, SDR_FLAGS_KEEP, 1);
  sdr_parallel_for(0, body->head.points->stripe_count, 1, split_stripe, o);
}

static void add_whole(void *context, const sdr_pair *pair)
{
  sdr_ordinary *o = context;
  const sdr_flags *flags = pair->loose ? o->body.loose_flags : o->body.flags;
  if (flags && flags[pair->slot] & SDR_CUT) return;
  o->whole[pair->i] += sdr_ordinary_r(o, pair, pair->weight_ij);
  if (!pair->loose) o->whole[pair->j] += sdr_ordinary_r(o, pair, pair->weight_ji);
}

/* 000 eq. 42, where P^2/Q = P; points without a bond have no constants. */
static void standard_constants(sdr_ordinary *o, int32_t i)
{
  const double n = o->body.head.points->components, shear = o->body.shear[i], m = o->whole[i];
  o->t[i] = m > 0.0 ? n / m : 0.0;
  o->b[i] = m > 0.0 ? 0.5 * n * (n + 2.0) * shear / m : 0.0;
  o->a[i] = 0.5 * (n + 2.0) * shear / n;
}

/* 004 eq. 15-17, with t corrected to 2 delta b s. */
static void printed_constants(sdr_ordinary *o, int32_t i)
{
  const sdr_points *points = o->body.head.points;
  const double pi = 3.14159265358979323846, delta = points->horizon[i], v = points->volume[i];
  const double thickness = v / (points->spacing[i] * points->spacing[i]);
  const double d = 2.0 / (pi * thickness * delta * delta * delta);
  const double b = 3.0 * o->body.shear[i] * d / delta;
  o->t[i] = d * delta / v;
  o->b[i] = b * delta / v;
  o->a[i] = o->body.shear[i];
}

/* Families without the bonds cut at the start. */
static sdr_status remake(sdr_state_body *body)
{
  sdr_ordinary *o = (sdr_ordinary *)body;
  const sdr_points *points = body->head.points;
  zero_range(o->whole, 0, points->count);
  sdr_bonds_visit(body->bonds, points, add_whole, o);
  for (int32_t i = 0; i < points->count; ++i)
    if (o->form == SDR_FORM_MADENCI_OTERKUS)
      printed_constants(o, i);
    else
      standard_constants(o, i);
  return SDR_OK;
}

static const sdr_state_hooks hooks = {.isa = isa,
                                      .split = split,
                                      .remake = remake,
                                      .book = sdr_ordinary_book,
                                      .overstretch = sdr_state_square_stretch,
                                      .remake_fresh = sdr_ordinary_remake_fresh};

/* ---- creation -------------------------------------------------------------------------------- */

static void destroy(sdr_model *model)
{
  sdr_ordinary *o = (sdr_ordinary *)model;
  if (!o) return;
  sdr_state_body_clear(&o->body);
  void *const blocks[] = {o->classes, o->t,    o->a,     o->b,      o->whole,  o->sum,
                          o->square,  o->lost, o->along, o->across, o->records};
  for (size_t k = 0; k < sizeof blocks / sizeof *blocks; ++k) sdr_free(blocks[k]);
  for (int k = 0; k < SDR_ORDINARY_BOOKS; ++k) sdr_free(o->book[k]);
  for (int k = 0; k < 2; ++k) sdr_free(o->slope[k]);
  sdr_free(o);
}

static const sdr_model_ops ops = {.name = "ordinary",
                                  .force = force,
                                  .force_commit = force_commit,
                                  .commit = sdr_state_commit,
                                  .energies = sdr_state_energies,
                                  .reference_times = sdr_ordinary_reference_times,
                                  .tangent_times = sdr_ordinary_tangent_times,
                                  .tangent_diagonal = sdr_ordinary_tangent_diagonal,
                                  .field = sdr_ordinary_field,
                                  .visit_damage = sdr_state_visit_damage,
                                  .visit_hessian = sdr_ordinary_visit_hessian,
                                  .visit_secant = sdr_ordinary_visit_secant,
                                  .break_most = sdr_state_break_most,
                                  .mark = sdr_state_mark,
                                  .visit_lost = sdr_state_visit_lost,
                                  .skip_rest = sdr_state_skip_rest,
                                  .traits = sdr_state_traits,
                                  .state = sdr_state_blocks,
                                  .destroy = destroy};

static sdr_status set_classes(sdr_ordinary *o)
{
  const sdr_bonds *bonds = o->body.bonds;
  o->classes = sdr_alloc((size_t)bonds->class_count, sizeof *o->classes);
  if (!o->classes) return SDR_RUN_FAILED;
  for (int c = 0; c < bonds->class_count; ++c) {
    const sdr_bond_class *from = &bonds->classes[c];
    const sdr_pair pair = {.length = from->length};
    sdr_ordinary_class *to = &o->classes[c];
    memcpy(to->xi, from->xi, sizeof to->xi);
    to->inverse_square = from->inverse_square;
    to->p_ij = sdr_ordinary_p(o, &pair, from->weight_ij);
    to->p_ji = sdr_ordinary_p(o, &pair, from->weight_ji);
    to->q_ij = sdr_ordinary_q(o, &pair, from->weight_ij);
    to->q_ji = sdr_ordinary_q(o, &pair, from->weight_ji);
    to->r_ij = sdr_ordinary_r(o, &pair, from->weight_ij);
    to->r_ji = sdr_ordinary_r(o, &pair, from->weight_ji);
    to->pf_ij = to->p_ij * from->inverse_square;
    to->pf_ji = to->p_ji * from->inverse_square;
    to->qf_ij = to->q_ij * from->inverse_square;
    to->qf_ji = to->q_ji * from->inverse_square;
  }
  return SDR_OK;
}

static sdr_status alloc_arrays(sdr_ordinary *o)
{
  const size_t padded = sdr_points_padded(o->body.head.points);
  double **const arrays[] = {&o->t,   &o->a,      &o->b,     &o->whole,
                             &o->sum, &o->square, &o->along, &o->across};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; ++k)
    if (!(*arrays[k] = sdr_alloc(padded, sizeof(double)))) return SDR_RUN_FAILED;
  if (o->body.bonds->loose.chunk_count > 0 &&
      !(o->records = sdr_alloc(SDR_RECORD * padded, sizeof(double))))
    return SDR_RUN_FAILED;
  if (o->body.law != SDR_LAW_CRITICAL_STRETCH) return SDR_OK;
  if (!(o->lost = sdr_alloc(padded, sizeof(double)))) return SDR_RUN_FAILED;
  for (int k = 0; k < SDR_ORDINARY_BOOKS; ++k)
    if (!(o->book[k] = sdr_alloc(padded, sizeof(double)))) return SDR_RUN_FAILED;
  return SDR_OK;
}

static sdr_status set_threshold(sdr_ordinary *o, const double *toughness)
{
  SDR_TRY(sdr_ordinary_set_threshold(o, toughness));
  o->weakest = INFINITY;
  for (int32_t i = 0; i < o->body.head.points->count; ++i)
    o->weakest = fmin(o->weakest, o->body.threshold[i]);
  o->one_threshold = 1;
  for (int32_t i = 0; i < o->body.head.points->count; ++i)
    o->one_threshold &= o->body.threshold[i] <= o->weakest;
  return SDR_OK;
}

static const sdr_ordinary_kernels *best_kernels(void)
{
#ifdef SDR_HAVE_X86_KERNELS
  if (sdr_isa_level() == 2) return &sdr_ordinary_kernels_avx512;
  if (sdr_isa_level() == 1) return &sdr_ordinary_kernels_avx2;
#endif
  return &sdr_ordinary_kernels_baseline;
}

static sdr_status set_up(sdr_ordinary *o, const sdr_state_based_how *how)
{
  const sdr_dimension dimension = o->body.dimension;
  if (o->form == SDR_FORM_MADENCI_OTERKUS && sdr_components(dimension) != 2)
    return sdr_fail(SDR_BAD_INPUT, "material.form madenci_oterkus exists in plane_stress and "
                                   "plane_strain only; leave it out to take the standard form");
  SDR_TRY(set_classes(o));
  SDR_TRY(alloc_arrays(o));
  if (how->law == SDR_LAW_CRITICAL_STRETCH) SDR_TRY(set_threshold(o, how->toughness));
  return remake(&o->body);
}

sdr_status sdr_ordinary_create(const sdr_points *points, sdr_bonds *bonds,
                               const sdr_state_based_how *how, sdr_model **out)
{
  sdr_ordinary *o = sdr_alloc(1, sizeof *o);
  if (!o) {
    sdr_bonds_destroy(&bonds);
    return SDR_RUN_FAILED;
  }
  o->kernels = best_kernels();
  o->form = how->form;
  sdr_status status = sdr_state_body_init(&o->body, &ops, &hooks, points, bonds, how);
  if (status == SDR_OK) status = set_up(o, how);
  if (status != SDR_OK) {
    destroy(&o->body.head);
    return status;
  }
  *out = &o->body.head;
  return SDR_OK;
}
