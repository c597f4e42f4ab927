#include "mechanics/bond_based.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/records.h"

#include <math.h>
#include <string.h>

/* ---- force ----------------------------------------------------------------------------------- */

typedef struct {
  sdr_bond_model *model;
  sdr_run_force run;
  sdr_mixed_force mixed; /* instead of run, if not NULL */
  int32_t bits[256];     /* a stripe: what it returns */
  sdr_loose_force loose;
  double *const *u, *const *v, *const *f;
  double dt;
} force_call;

static void zero_stripe(const sdr_points *points, int s, double *const f[3])
{
  if (s >= points->stripe_count) return;
  const int32_t first = points->stripe_first[s], end = points->stripe_first[s + 1];
  for (int a = 0; a < points->components; ++a)
    memset(f[a] + first, 0, (size_t)(end - first) * sizeof(double));
}

/* What loose pairs read of the points of stripe s. */
static void write_records(const sdr_bond_body *body, int s, double *const u[3])
{
  const sdr_points *points = body->points;
  const int n = points->components;
  if (body->bonds->loose.chunk_count == 0) return;
  for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i) {
    if (body->bonds->loose.lane[i] < 0) continue;
    double *const record = body->records + (size_t)i * SDR_RECORD;
    for (int a = 0; a < n; ++a) record[a] = u[a][i];
    if (body->stiffness_at) record[n] = body->stiffness_at[i];
    if (body->threshold_at && n < 3) record[n + 1] = body->threshold_at[i];
  }
}

/* Even stripes come first: they clear their own force and the next stripe's, where they add. */
static void force_of_stripe(void *context, int s)
{
  force_call *call = context;
  const sdr_bonds *bonds = call->model->bonds;
  write_records(&call->model->body, s, call->u);
  if (s % 2 == 0) {
    zero_stripe(call->model->head.points, s, call->f);
    zero_stripe(call->model->head.points, s + 1, call->f);
  }
  if (sdr_stripe_rests(call->model, s)) return;
  const int64_t first = bonds->stripe_run[s], end = bonds->stripe_run[s + 1];
  if (call->mixed)
    call->bits[s] = call->mixed(&call->model->body, first, end, call->u, call->f);
  else
    call->run(&call->model->body, first, end, call->u, call->f);
}

/* After the runs' stripes: chunks add to their own points only. */
static void force_of_loose_stripe(void *context, int s)
{
  const force_call *call = context;
  int64_t first, end;
  sdr_stripe_chunks(&call->model->body, s, &first, &end);
  call->loose(&call->model->body, first, end, call->u, call->f);
}

static void book_stripe(void *context, int s)
{
  const force_call *call = context;
  sdr_bond_book(call->model, s, call->u, call->v, call->dt);
}

/* Book what the step lost, when every stripe's force is known. */
static void book(force_call *call)
{
  const sdr_bond_model *model = call->model;
  if (!model->booked) return;
  sdr_parallel_for(0, model->head.points->stripe_count, 1, book_stripe, call);
  /* In order, a chunk may belong to two stripes, so its mark goes when both have looked. */
  if (model->body.chunk_fresh)
    memset(model->body.chunk_fresh, 0, (size_t)model->bonds->loose.chunk_count);
}

static void take_bits(const force_call *call)
{
  int32_t bits = 0;
  for (int s = 0; s < call->model->head.points->stripe_count; ++s) bits |= call->bits[s];
  sdr_bond_take_bits(call->model, bits);
}

static void compute_force(sdr_bond_model *model, int commit, double *const u[3], double *const v[3],
                          double dt, double *const f[3])
{
  const int n = model->head.points->components, each = model->body.stiffness_at != NULL;
  const int mixed = commit && model->body.mixed;
  force_call call = {.model = model,
                     .run = model->kernels->run_force[model->body.law][n - 1][each],
                     .mixed = mixed ? model->kernels->mixed_run_force[model->body.law][n - 1][each]
                                    : NULL,
                     .loose = model->kernels->loose_force[model->body.law][n - 1][each],
                     .u = u,
                     .v = v,
                     .f = f,
                     .dt = dt};
  model->body.commit = commit;
  sdr_bond_watch(model, u);
  if (mixed) sdr_bond_split(model, u, v, dt);
  sdr_each_stripe(model->head.points, force_of_stripe, &call);
  if (mixed) take_bits(&call);
  if (model->bonds->loose.chunk_count > 0)
    sdr_parallel_for(0, model->head.points->stripe_count, 1, force_of_loose_stripe, &call);
  if (commit) book(&call);
}

static void force(sdr_model *model, double *const u[3], double *const f[3])
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  if (bond->body.precise)
    sdr_bond_precise_force(bond, u, f);
  else
    compute_force(bond, 0, u, NULL, 0.0, f);
}

typedef struct {
  sdr_bond_model *model;
  double *const *u;
} commit_call;

/* The history of one pair takes the present stretch in. */
static void commit_pair(void *context, const sdr_pair *pair)
{
  const commit_call *call = context;
  sdr_bond_body *body = &call->model->body;
  const double s = sdr_pair_stretch(pair, call->model->head.points->components, call->u);
  if (body->precise && sdr_law_softens((int)body->law)) {
    double *k = (pair->loose ? body->loose_history : body->history) + pair->slot;
    if (*k >= 0.0 && s > *k) *k = s;
  } else if (sdr_law_softens((int)body->law)) {
    float *k = (pair->loose ? body->loose_stretch : body->stretch) + pair->slot;
    if (*k >= 0.0f && (float)s > *k) *k = (float)s;
  } else if (body->law == SDR_LAW_CRITICAL_STRETCH) {
    sdr_flags *flags = (pair->loose ? body->loose_flags : body->flags) + pair->slot;
    if (*flags & SDR_PROTECTED) return;
    const int i =
        sdr_critical_breaks(s, sdr_body_threshold(body, pair->i)) && !(*flags & SDR_LOST_I);
    const int j =
        sdr_critical_breaks(s, sdr_body_threshold(body, pair->j)) && !(*flags & SDR_LOST_J);
    *flags = (*flags | (i ? SDR_LOST_I | SDR_FRESH_I : 0) | (j ? SDR_LOST_J | SDR_FRESH_J : 0));
  }
}

/* Of a stripe: runs of histories in double have a loop of their own. */
static void commit_pairs(commit_call *call, int s)
{
  const sdr_bond_model *model = call->model;
  const sdr_points *points = model->head.points;
  const sdr_bonds *bonds = model->bonds;
  if (!model->body.precise || !sdr_law_softens((int)model->body.law)) {
    sdr_bonds_visit_stripe(bonds, points, s, commit_pair, call);
    return;
  }
  model->precise->run_commit[points->components - 1](&model->body, bonds->stripe_run[s],
                                                     bonds->stripe_run[s + 1], call->u);
  if (bonds->loose.chunk_count > 0)
    for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i)
      sdr_bonds_visit_loose_point(bonds, i, commit_pair, call);
}

static void commit_stripe(void *context, int s)
{
  commit_call *call = context;
  sdr_bond_model *model = call->model;
  commit_pairs(call, s);
  if (!model->booked) return;
  const int64_t first = model->bonds->stripe_run[s], end = model->bonds->stripe_run[s + 1];
  sdr_bond_note_flags(&model->body, first, end);
  if (model->body.run_fresh) memset(model->body.run_fresh + first, 1, (size_t)(end - first));
  int64_t chunk, last;
  sdr_stripe_chunks(&model->body, s, &chunk, &last);
  if (model->body.chunk_fresh) memset(model->body.chunk_fresh + chunk, 1, (size_t)(last - chunk));
}

static void commit(sdr_model *model, double *const u[3])
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  if (bond->body.law == SDR_LAW_NONE) return;
  commit_call call = {bond, u};
  sdr_parallel_for(0, model->points->stripe_count, 1, commit_stripe, &call);
  force_call booking = {.model = bond, .u = u};
  book(&booking);
}

static void force_commit(sdr_model *model, double *const u[3], double *const v[3], double dt,
                         double *const f[3])
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  if (!bond->body.precise) {
    compute_force(bond, 1, u, v, dt, f);
    return;
  }
  commit(model, u);
  sdr_bond_precise_force(bond, u, f);
}

/* ---- creation -------------------------------------------------------------------------------- */

static void state(sdr_model *model, sdr_state_block *blocks, int *count)
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  const sdr_bond_body *body = &bond->body;
  const size_t runs = (size_t)bond->bonds->run_slots, loose = (size_t)bond->bonds->loose.slot_count;
  int n = 0;
  if (body->stretch)
    blocks[n++] = (sdr_state_block){"stretch", body->stretch, runs * sizeof(float)};
  if (body->loose_stretch)
    blocks[n++] = (sdr_state_block){"loose_stretch", body->loose_stretch, loose * sizeof(float)};
  if (body->history)
    blocks[n++] = (sdr_state_block){"history", body->history, runs * sizeof(double)};
  if (body->loose_history)
    blocks[n++] = (sdr_state_block){"loose_history", body->loose_history, loose * sizeof(double)};
  if (body->flags) blocks[n++] = (sdr_state_block){"flags", body->flags, runs * sizeof(sdr_flags)};
  if (body->loose_flags)
    blocks[n++] = (sdr_state_block){"loose_flags", body->loose_flags, loose * sizeof(sdr_flags)};
  if (body->run_flagged)
    blocks[n++] =
        (sdr_state_block){"run_flagged", body->run_flagged, (size_t)bond->bonds->run_count};
  if (body->mixed) blocks[n++] = (sdr_state_block){"bound", &bond->bound, sizeof bond->bound};
  blocks[n++] = (sdr_state_block){"moved", bond->moved, (size_t)model->points->stripe_count};
  if (bond->booked)
    blocks[n++] = (sdr_state_block){"booked", bond->booked,
                                    (size_t)model->points->stripe_count * sizeof(double)};
  *count = n;
}

static void skip_rest(sdr_model *model, int skip)
{
  ((sdr_bond_model *)model)->keep_resting = !skip;
}

static size_t history_bytes(const sdr_bond_model *bond)
{
  const size_t slots = (size_t)(bond->bonds->run_slots + bond->bonds->loose.slot_count);
  if (sdr_law_softens((int)bond->body.law))
    return slots * (bond->body.precise ? sizeof(double) : sizeof(float));
  return bond->body.flags || bond->body.loose_flags ? slots * sizeof(sdr_flags) : 0;
}

static void traits(const sdr_model *model, sdr_model_traits *out)
{
  const sdr_bond_model *bond = (const sdr_bond_model *)model;
  const int stripes = model->points->stripe_count;
  int moved = 0;
  for (int s = 0; s < stripes; ++s) moved += bond->moved[s];
  *out = (sdr_model_traits){.name = model->ops->name,
                            .isa = bond->kernels->name,
                            .bonds = bond->bonds,
                            .mixed = bond->body.mixed,
                            .shared_moduli = !bond->body.stiffness_at,
                            .history_bytes = history_bytes(bond),
                            .moved = (double)moved / stripes};
}

static void destroy(sdr_model *model)
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  if (!bond) return;
  sdr_bonds_destroy(&bond->bonds);
  sdr_free(bond->body.stiffness_at);
  sdr_free(bond->body.threshold_at);
  sdr_free(bond->body.decline_at);
  sdr_free(bond->body.history);
  sdr_free(bond->body.loose_history);
  sdr_free(bond->body.records);
  sdr_free(bond->body.stretch);
  sdr_free(bond->body.loose_stretch);
  sdr_free(bond->body.flags);
  sdr_free(bond->body.loose_flags);
  sdr_free(bond->body.run_marked);
  sdr_free(bond->body.run_fresh);
  sdr_free(bond->body.run_flagged);
  sdr_free(bond->body.run_limit);
  sdr_free(bond->body.chunk_fresh);
  for (int a = 0; a < 3; ++a) sdr_free(bond->body.place[a]);
  sdr_free(bond->body.float_terms);
  sdr_free(bond->body.relative_stiffness);
  sdr_free(bond->body.float_threshold);
  sdr_free(bond->moved);
  sdr_free(bond->family_volume);
  sdr_free(bond->booked);
  sdr_mean_kept_destroy(&bond->mean);
  sdr_free(bond);
}

static const sdr_model_ops ops = {.name = "bond_based",
                                  .force = force,
                                  .force_commit = force_commit,
                                  .commit = commit,
                                  .energies = sdr_bond_energies,
                                  .reference_times = sdr_bond_reference_times,
                                  .tangent_times = sdr_bond_tangent_times,
                                  .tangent_diagonal = sdr_bond_tangent_diagonal,
                                  .field = sdr_bond_field,
                                  .visit_damage = sdr_bond_visit_damage,
                                  .visit_hessian = sdr_bond_visit_hessian,
                                  .visit_secant = sdr_bond_visit_secant,
                                  .break_most = sdr_bond_break_most,
                                  .tangent_keep = sdr_bond_tangent_keep,
                                  .kept_times = sdr_bond_kept_times,
                                  .kept_diagonal = sdr_bond_kept_diagonal,
                                  .mean_force = sdr_bond_mean_force,
                                  .mean_keep = sdr_bond_mean_keep,
                                  .mean_times = sdr_bond_mean_times,
                                  .mean_diagonal = sdr_bond_mean_diagonal,
                                  .visit_mean_tangent = sdr_bond_visit_mean_tangent,
                                  .mark = sdr_bond_mark,
                                  .visit_lost = sdr_bond_visit_lost,
                                  .skip_rest = skip_rest,
                                  .split_state = sdr_bond_split_state,
                                  .inherit = sdr_bond_inherit,
                                  .visit_held = sdr_bond_visit_held,
                                  .traits = traits,
                                  .state = state,
                                  .destroy = destroy};

/* `count` numbers if there are any. */
static sdr_status alloc_some(size_t count, size_t size, void **out)
{
  if (count > 0 && !(*out = sdr_alloc(count, size))) return SDR_RUN_FAILED;
  return SDR_OK;
}

/* What kernels of critical stretch know of each run. A bond breaks at (1 + s)^2 = 1 + z; kernels
   ask the law a little before that, so that no rounding matters. */
static sdr_status alloc_runs(sdr_bond_body *body)
{
  const size_t count = (size_t)body->bonds->run_count;
  body->run_fresh = sdr_alloc(count, 1);
  body->run_flagged = sdr_alloc(count, 1);
  body->run_limit = sdr_alloc(count, sizeof(double));
  if (!body->run_fresh || !body->run_flagged || !body->run_limit) return SDR_RUN_FAILED;
  for (size_t r = 0; r < count; ++r) {
    const sdr_bond_run *run = &body->bonds->runs[r];
    double least = body->threshold;
    for (int32_t k = 0; body->threshold_at && k < run->length; ++k) {
      const double here = fmin(body->threshold_at[run->i0 + k], body->threshold_at[run->j0 + k]);
      least = k == 0 || here < least ? here : least;
    }
    const double s = sqrt(least);
    body->run_limit[r] = 0.999 * s * (2.0 + s);
  }
  return SDR_OK;
}

static sdr_status alloc_history(sdr_bond_model *model)
{
  sdr_bond_body *body = &model->body;
  const sdr_bonds *bonds = model->bonds;
  const size_t runs = (size_t)bonds->run_slots, loose = (size_t)bonds->loose.slot_count;
  if (sdr_law_softens((int)body->law) && body->precise) {
    SDR_TRY(alloc_some(runs, sizeof(double), (void **)&body->history));
    SDR_TRY(alloc_some(loose, sizeof(double), (void **)&body->loose_history));
  } else if (sdr_law_softens((int)body->law)) {
    SDR_TRY(alloc_some(runs, sizeof(float), (void **)&body->stretch));
    SDR_TRY(alloc_some(loose, sizeof(float), (void **)&body->loose_stretch));
  }
  if (body->law != SDR_LAW_CRITICAL_STRETCH) return SDR_OK;
  SDR_TRY(sdr_bond_alloc_flags(model));
  if (runs > 0) SDR_TRY(alloc_runs(body));
  if (loose > 0 && !(body->chunk_fresh = sdr_alloc((size_t)bonds->loose.chunk_count, 1)))
    return SDR_RUN_FAILED;
  model->booked = sdr_alloc((size_t)body->points->stripe_count, sizeof(double));
  return model->booked ? SDR_OK : SDR_RUN_FAILED;
}

sdr_status sdr_bond_based_create(const sdr_points *points, sdr_bonds *bonds,
                                 const sdr_families *families, const sdr_bond_based_how *how,
                                 sdr_model **out)
{
  sdr_bond_model *model = sdr_alloc(1, sizeof *model);
  if (!model) {
    sdr_bonds_destroy(&bonds);
    return SDR_RUN_FAILED;
  }
  model->head = (sdr_model){.ops = &ops, .points = points, .bonds = bonds->directed};
  model->bonds = bonds;
  model->kernels = sdr_bond_kernels_best();
  model->precise = sdr_precise_kernels_best();
  model->body =
      (sdr_bond_body){.points = points, .bonds = bonds, .law = how->law, .precise = how->precise};
  sdr_status status = sdr_bond_set_constants(&model->body, families, how);
  model->moved = sdr_alloc((size_t)points->stripe_count, 1);
  if (!model->moved)
    status = SDR_RUN_FAILED;
  else if (how->precise) /* implicit steps reach all of the body at once */
    memset(model->moved, 1, (size_t)points->stripe_count);
  if (status == SDR_OK) status = alloc_history(model);
  if (status == SDR_OK && bonds->loose.chunk_count > 0 && !how->precise)
    status = alloc_some(SDR_RECORD * sdr_points_padded(points), sizeof(double),
                        (void **)&model->body.records);
  if (status == SDR_OK && how->mixed && !how->precise && bonds->run_count > 0 &&
      model->kernels->mixed_run_force[how->law][0][0])
    status = sdr_bond_set_mixed(&model->body);
  if (status != SDR_OK) {
    destroy(&model->head);
    return status;
  }
  *out = &model->head;
  return SDR_OK;
}
