/* Non-ordinary (correspondence) state-based bodies with zero-energy control (theory sec. 11). */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/isa.h"
#include "mechanics/nonordinary_internal.h"
#include "mechanics/records.h"

#include <math.h>
#include <string.h>

static sdr_nonordinary_model *model_of(sdr_model *model)
{
  return (sdr_nonordinary_model *)model;
}

/* ---- passes ---------------------------------------------------------------------------------- */

/* The blocks that stripe s computes: those that begin in it. */
typedef struct {
  int64_t first, end;
  int beyond; /* stripes that the last one reaches into */
} block_range;

static block_range blocks_of(const sdr_points *points, int s)
{
  const int32_t *stripe = points->stripe_first;
  block_range range = {(stripe[s] + SDR_LANES - 1) / SDR_LANES,
                       (stripe[s + 1] + SDR_LANES - 1) / SDR_LANES, 0};
  while (s + range.beyond + 1 < points->stripe_count &&
         stripe[s + range.beyond + 1] < SDR_LANES * range.end)
    ++range.beyond;
  return range;
}

static void states_of_stripe(void *context, int s)
{
  const sdr_nonordinary_call *call = context;
  const block_range range = blocks_of(call->body.points, s);
  const int rests = call->skip && sdr_state_rests(&call->model->state, s, 1, 1 + range.beyond);
  call->states(&call->body, range.first, range.end, rests ? NULL : call->u, call->f);
}

static void zero_stripe(void *context, int s)
{
  const sdr_nonordinary_call *call = context;
  const block_range range = blocks_of(call->body.points, s);
  for (int a = 0; a < call->body.points->components; ++a)
    memset(call->f[a] + SDR_LANES * range.first, 0,
           (size_t)(range.end - range.first) * SDR_LANES * sizeof(double));
}

static void loose_of_stripe(void *context, int s)
{
  const sdr_nonordinary_call *call = context;
  const block_range range = blocks_of(call->body.points, s);
  const int n = call->body.points->components;
  if (call->skip && sdr_state_rests(&call->model->state, s, 2, 2 + range.beyond)) return;
  call->model->kernels->force[n - 1][!call->linear](&call->body, range.first, range.end, call->u,
                                                    call->f);
}

static void places_of_stripe(void *context, int s)
{
  const sdr_nonordinary_call *call = context;
  const sdr_points *points = call->body.points;
  for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i)
    for (int a = 0; a < points->components; ++a)
      call->body.places[(size_t)i * SDR_RECORD + (size_t)a] = call->u[a][i];
}

/* Put displacements where kernels of loose pairs look for them. */
static void place(sdr_nonordinary_call *call)
{
  if (call->body.places)
    sdr_parallel_for(0, call->body.points->stripe_count, 1, places_of_stripe, call);
}

static void all_states(sdr_nonordinary_call *call)
{
  place(call);
  sdr_parallel_for(0, call->body.points->stripe_count, 1, states_of_stripe, call);
}

/* Runs of a stripe's blocks reach one stripe down and, from its last block, one further than that
   block: stripes at work at the same time lie so far apart that none adds where another does. */
static void all_forces(sdr_nonordinary_call *call)
{
  const sdr_points *points = call->body.points;
  const int stripes = points->stripe_count;
  int apart = 3;
  for (int s = 0; s < stripes; ++s) {
    const int needed = 3 + blocks_of(points, s).beyond;
    if (needed > apart) apart = needed;
  }
  place(call);
  sdr_parallel_for(0, stripes, 1, zero_stripe, call);
  for (int colour = 0; colour < apart; ++colour)
    sdr_parallel_for(colour, stripes, apart, states_of_stripe, call);
  if (call->body.bonds->loose.chunk_count > 0)
    sdr_parallel_for(0, stripes, 1, loose_of_stripe, call);
}

/* ---- state ----------------------------------------------------------------------------------- */

/* Families follow from the flags, so a checkpoint need not hold them; but sums made anew have other
   last digits than those that followed bond by bond. So both who writes a checkpoint and who reads
   it make them anew: what is written says that they are stale. */
static void state_blocks(sdr_model *model, sdr_state_block *blocks, int *count)
{
  sdr_nonordinary_model *own = model_of(model);
  sdr_state_blocks(model, blocks, count);
  if (own->state.law != SDR_LAW_CRITICAL_STRETCH) return;
  own->stale = 1;
  blocks[(*count)++] = (sdr_state_block){"stale", &own->stale, sizeof own->stale};
}

/* ---- operations ------------------------------------------------------------------------------ */

/* The arrays of the shared part may have come since: flags with the first mark. */
static sdr_nonordinary_body body_now(const sdr_nonordinary_model *model)
{
  sdr_nonordinary_body body = model->body;
  body.flags = model->state.flags;
  body.loose_flags = model->state.loose_flags;
  body.run_flagged = model->state.run_flagged;
  body.loose_flagged = model->state.loose_flags != NULL;
  body.elasticity = (int)model->elasticity;
  body.split = model->split;
  body.commit = 0;
  return body;
}

static sdr_nonordinary_call call_of(sdr_nonordinary_model *model, int task, double *const u[3])
{
  sdr_nonordinary_call call = {.model = model,
                               .body = body_now(model),
                               .linear = model->elasticity == SDR_LINEAR,
                               .skip = model->local,
                               .u = u};
  const int n = model->state.head.points->components;
  call.states = model->kernels->state[n - 1][!call.linear][task];
  sdr_state_watch(&model->state, u);
  sdr_nonordinary_refresh(model);
  return call;
}

static void compute_force(sdr_nonordinary_model *model, int commit, double *const u[3],
                          double *const f[3])
{
  const int task = model->state.history ? SDR_POINT_DAMAGED : SDR_POINT_ELASTIC;
  sdr_nonordinary_call call = call_of(model, task, u);
  call.body.commit = commit;
  call.f = f;
  all_forces(&call);
}

static void force(sdr_model *model, double *const u[3], double *const f[3])
{
  compute_force(model_of(model), 0, u, f);
}

static void force_commit(sdr_model *model, double *const u[3], double *const v[3], double dt,
                         double *const f[3])
{
  sdr_nonordinary_model *own = model_of(model);
  if (own->state.law == SDR_LAW_CRITICAL_STRETCH) {
    sdr_nonordinary_refresh(own);
    sdr_nonordinary_break(own, u);
    sdr_state_book(&own->state, u, v, dt);
  }
  compute_force(own, 1, u, f);
}

static void commit(sdr_model *model, double *const u[3])
{
  sdr_nonordinary_model *own = model_of(model);
  if (own->state.law != SDR_LAW_CRITICAL_STRETCH) {
    sdr_state_commit(model, u);
    return;
  }
  sdr_nonordinary_refresh(own);
  sdr_nonordinary_break(own, u);
  sdr_state_book(&own->state, u, NULL, 0.0);
}

static void split(sdr_state_body *state, double *const u[3])
{
  sdr_nonordinary_call call = call_of((sdr_nonordinary_model *)state, SDR_POINT_ENERGY, u);
  all_states(&call);
}

/* The tangent of the undeformed body is that of small strains. */
static void reference_times(sdr_model *model, double *const v[3], double *const out[3])
{
  sdr_nonordinary_model *own = model_of(model);
  const int n = model->points->components;
  sdr_nonordinary_refresh(own);
  sdr_nonordinary_call call = {.model = own, .body = body_now(own), .linear = 1, .u = v, .f = out};
  call.body.lambda = own->reference_lambda;
  call.body.mu = own->reference_mu;
  call.body.elasticity = SDR_LINEAR;
  call.body.split = SDR_SPLIT_WHOLE;
  call.states = own->kernels->state[n - 1][0][SDR_POINT_ELASTIC];
  all_forces(&call);
  for (int a = 0; a < n; ++a)
    for (int32_t i = 0; i < model->points->count; ++i) out[a][i] = -out[a][i];
}

static const char *isa(const sdr_state_body *state)
{
  return ((const sdr_nonordinary_model *)state)->kernels->name;
}

static sdr_status remake(sdr_state_body *state)
{
  sdr_nonordinary_model *model = (sdr_nonordinary_model *)state;
  return sdr_nonordinary_families(model, state->law == SDR_LAW_CRITICAL_STRETCH);
}

static void destroy(sdr_model *model)
{
  sdr_nonordinary_model *own = model_of(model);
  if (!own) return;
  sdr_state_body_clear(&own->state);
  for (int k = 0; k < 6; ++k) sdr_free(own->body.inverse[k]);
  for (int k = 0; k < 15; ++k) sdr_free(own->body.quartic[k]);
  for (int k = 0; k < 9; ++k) {
    sdr_free(own->body.gradient[k]);
    sdr_free(own->body.moment[k]);
  }
  void *const blocks[] = {own->body.shear,
                          own->body.normal,
                          own->body.square,
                          own->body.along,
                          own->body.places,
                          own->body.bearings,
                          own->lambda,
                          own->mu,
                          own->body.blocks,
                          own->body.bundles,
                          own->body.directions,
                          own->control_shear,
                          own->control_normal,
                          own->reference_lambda,
                          own->reference_mu,
                          own->limit,
                          own->whole,
                          own->least,
                          own->whole_lambda,
                          own->whole_mu,
                          own->found,
                          own->found_loose,
                          own->first,
                          own->member,
                          own->torn,
                          own->space};
  for (size_t k = 0; k < sizeof blocks / sizeof *blocks; ++k) sdr_free(blocks[k]);
  sdr_free(own);
}

static const sdr_state_hooks hooks = {.isa = isa,
                                      .split = split,
                                      .remake = remake,
                                      .book = sdr_nonordinary_book,
                                      .look = sdr_nonordinary_look,
                                      .overstretch = sdr_nonordinary_overstretch,
                                      .remake_fresh = sdr_nonordinary_remake_fresh};

static void traits(const sdr_model *model, sdr_model_traits *out)
{
  const sdr_nonordinary_model *own = (const sdr_nonordinary_model *)model;
  sdr_state_traits(model, out);
  out->control_shear = own->control_shear[0];
  out->control_normal = own->control_normal[0];
  out->condition = own->condition;
}

static const sdr_model_ops ops = {.name = "nonordinary",
                                  .force = force,
                                  .force_commit = force_commit,
                                  .commit = commit,
                                  .energies = sdr_state_energies,
                                  .reference_times = reference_times,
                                  .tangent_times = sdr_nonordinary_tangent_times,
                                  .tangent_diagonal = sdr_nonordinary_tangent_diagonal,
                                  .field = sdr_nonordinary_field,
                                  .visit_damage = sdr_state_visit_damage,
                                  .visit_hessian = sdr_nonordinary_visit_hessian,
                                  .visit_secant = sdr_nonordinary_visit_secant,
                                  .break_most = sdr_state_break_most,
                                  .mark = sdr_state_mark,
                                  .visit_lost = sdr_state_visit_lost,
                                  .skip_rest = sdr_state_skip_rest,
                                  .traits = traits,
                                  .state = state_blocks,
                                  .destroy = destroy};

/* ---- creation -------------------------------------------------------------------------------- */

static sdr_status alloc_all(sdr_nonordinary_model *model)
{
  sdr_nonordinary_body *body = &model->body;
  const sdr_bonds *bonds = model->state.bonds;
  const int n = model->state.head.points->components;
  const size_t padded = sdr_points_padded(model->state.head.points);
  double **const single[] = {
      &body->shear,          &body->normal,          &body->square,
      &body->along,          &model->lambda,         &model->mu,
      &model->control_shear, &model->control_normal, &model->reference_lambda,
      &model->reference_mu,  &model->limit,          &model->whole,
      &model->least,         &model->whole_lambda,   &model->whole_mu};
  int failed = 0;
  for (size_t k = 0; k < sizeof single / sizeof *single; ++k)
    failed |= !(*single[k] = sdr_alloc(padded, sizeof(double)));
  for (int k = 0; k < n * (n + 1) / 2; ++k)
    failed |= !(body->inverse[k] = sdr_alloc(padded, sizeof(double)));
  for (int k = 0; k < sdr_monomial_count(n); ++k)
    failed |= !(body->quartic[k] = sdr_alloc(padded, sizeof(double)));
  for (int k = 0; k < n * n; ++k) {
    failed |= !(body->gradient[k] = sdr_alloc(padded, sizeof(double)));
    failed |= !(body->moment[k] = sdr_alloc(padded, sizeof(double)));
  }
  const size_t bearings = (size_t)sdr_bearing_size(n, model->elasticity != SDR_LINEAR);
  if (bonds->loose.chunk_count > 0) {
    failed |= !(body->places = sdr_alloc(SDR_RECORD * padded, sizeof(double)));
    failed |= !(body->bearings = sdr_alloc(bearings * padded, sizeof(double)));
  }
  failed |= !(model->found = sdr_alloc((size_t)bonds->run_count, 1));
  failed |= !(model->found_loose = sdr_alloc((size_t)bonds->loose.chunk_count, 1));
  failed |= !(model->torn = sdr_alloc(padded, 1));
  return failed ? SDR_RUN_FAILED : SDR_OK;
}

/* P_s and P_n (Pa) that cancel the lattice's dispersion of second order for both waves. */
static void control_of(int n, double bulk, double shear, double young, double *p_shear,
                       double *p_normal)
{
  const double longitudinal = bulk + 2.0 * shear * (n - 1) / n; /* D = lambda + 2 mu */
  const double wanted = n * (5.0 * shear - longitudinal) / 3.0;
  *p_shear = fmax(wanted, 0.1 * young);
  *p_normal = n * (n + 4) * (longitudinal - shear) / 3.0;
}

static sdr_status set_control(sdr_nonordinary_model *model, const sdr_state_based_how *how)
{
  const sdr_points *points = model->state.head.points;
  for (int32_t i = 0; i < points->count; ++i) {
    double p_shear, p_normal;
    control_of(points->components, model->state.bulk[i], model->state.shear[i], how->young[i],
               &p_shear, &p_normal);
    if (!isnan(how->control_shear)) p_shear = how->control_shear;
    if (!isnan(how->control_normal)) p_normal = how->control_normal;
    if (!(p_shear >= 0.0 && p_shear + p_normal >= 0.0))
      return sdr_fail(SDR_BAD_INPUT,
                      "the zero-energy control needs shear >= 0 and shear + normal >= 0, not %g Pa "
                      "and %g Pa",
                      p_shear, p_normal);
    model->control_shear[i] = p_shear;
    model->control_normal[i] = p_normal;
  }
  return SDR_OK;
}

static sdr_status set_constants(sdr_nonordinary_model *model, const sdr_state_based_how *how)
{
  const sdr_points *points = model->state.head.points;
  for (int32_t i = 0; i < points->count; ++i) {
    const double nu = how->dimension == SDR_1D ? 0.0 : how->poisson[points->material[i]];
    const sdr_moduli moduli = sdr_moduli_of(how->dimension, how->elasticity, how->young[i], nu);
    model->whole_lambda[i] = moduli.lambda;
    model->whole_mu[i] = moduli.mu;
    model->body.plane_stress = moduli.plane_stress;
  }
  return set_control(model, how);
}

static sdr_status set_threshold(sdr_nonordinary_model *model, const double *toughness)
{
  if (!model->state.threshold) return SDR_OK;
  SDR_TRY(sdr_nonordinary_set_threshold(model, toughness));
  for (int32_t i = 0; i < model->state.head.points->count; ++i) {
    const double s = sqrt(model->state.threshold[i]);
    /* a little less: what is found here is looked at again */
    model->limit[i] = s * (2.0 + s) * (1.0 - 1e-12);
  }
  return SDR_OK;
}

static const sdr_nonordinary_kernels *best_kernels(void)
{
#ifdef SDR_HAVE_X86_KERNELS
  if (sdr_isa_level() == 2) return &sdr_nonordinary_kernels_avx512;
  if (sdr_isa_level() == 1) return &sdr_nonordinary_kernels_avx2;
#endif
  return &sdr_nonordinary_kernels_baseline;
}

static sdr_status make(sdr_nonordinary_model *model, const sdr_points *points, sdr_bonds *bonds,
                       const sdr_state_based_how *how)
{
  SDR_TRY(sdr_state_body_init(&model->state, &ops, &hooks, points, bonds, how));
  if (bonds->loose.chunk_count > 0 && !bonds->loose.in_order)
    return sdr_fail(SDR_BAD_INPUT, "non-ordinary bodies take loose pairs in order only");
  model->kernels = best_kernels();
  model->elasticity = how->elasticity;
  model->split = how->law == SDR_LAW_VARIATIONAL ? (int)how->split : SDR_SPLIT_WHOLE;
  SDR_TRY(alloc_all(model));
  SDR_TRY(set_constants(model, how));
  SDR_TRY(set_threshold(model, how->toughness));
  model->body.points = points;
  model->body.bonds = bonds;
  model->body.lambda = model->lambda;
  model->body.mu = model->mu;
  model->body.history = model->state.history;
  model->body.softness = model->state.softness;
  model->body.plus = model->state.plus;
  model->body.minus = model->state.minus;
  SDR_TRY(sdr_nonordinary_bundles(model));
  return sdr_nonordinary_families(model, 0);
}

sdr_status sdr_nonordinary_create(const sdr_points *points, sdr_bonds *bonds,
                                  const sdr_state_based_how *how, sdr_model **out)
{
  sdr_nonordinary_model *model = sdr_alloc(1, sizeof *model);
  if (!model) {
    sdr_bonds_destroy(&bonds);
    return SDR_RUN_FAILED;
  }
  const sdr_status status = make(model, points, bonds, how);
  if (status != SDR_OK) {
    destroy(&model->state.head);
    return status;
  }
  *out = &model->state.head;
  return SDR_OK;
}
