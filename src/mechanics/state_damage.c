/* Damage of state-based bodies: what pairs and points have lost, energies, and the books of bonds
   that critical stretch loses. */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/state_body.h"

#include <string.h>

enum { MOST_STRIPES = 256, FRESH = SDR_FRESH_I | SDR_FRESH_J, LOST = SDR_LOST_I | SDR_LOST_J };

static sdr_state_body *body_of(sdr_model *model)
{
  return (sdr_state_body *)model;
}

static sdr_flags flags_of(const sdr_state_body *body, const sdr_pair *pair)
{
  const sdr_flags *flags = pair->loose ? body->loose_flags : body->flags;
  return flags ? flags[pair->slot] : 0;
}

/* Halves that the stretch s would break. */
static sdr_flags broken_by(const sdr_state_body *body, const sdr_pair *pair, double s)
{
  if (!body->threshold) return 0;
  return (sdr_critical_breaks(s, body->threshold[pair->i]) ? SDR_LOST_I : 0) |
         (sdr_critical_breaks(s, body->threshold[pair->j]) ? SDR_LOST_J : 0);
}

sdr_flags sdr_state_lost(const sdr_state_body *body, const sdr_pair *pair, double s, int grown)
{
  const sdr_flags flags = flags_of(body, pair);
  if (!grown || flags & SDR_PROTECTED) return flags & LOST;
  return (flags | broken_by(body, pair, s)) & LOST;
}

/* ---- commit ---------------------------------------------------------------------------------- */

typedef struct {
  sdr_state_body *body;
  double *const *u;
  int fresh; /* 1 once a pair lost something */
} commit_call;

static void break_pair(void *context, const sdr_pair *pair)
{
  commit_call *call = context;
  sdr_state_body *body = call->body;
  sdr_flags *flags = (pair->loose ? body->loose_flags : body->flags) + pair->slot;
  if (*flags & SDR_PROTECTED) return;
  const double s = sdr_pair_stretch(pair, body->head.points->components, call->u);
  const sdr_flags fresh = broken_by(body, pair, s) & ~*flags;
  if (!fresh) return;
  *flags |= fresh | fresh << 2;
  call->fresh = 1;
}

static void break_stripe(void *context, int s)
{
  commit_call call = *(const commit_call *)context;
  sdr_state_body *body = call.body;
  const sdr_bonds *bonds = body->bonds;
  for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r) {
    call.fresh = 0;
    sdr_bonds_visit_run(bonds, &bonds->runs[r], break_pair, &call);
    if (call.fresh) body->run_fresh[r] = body->run_flagged[r] = 1;
  }
  const int32_t *stripe = body->head.points->stripe_first;
  for (int32_t i = stripe[s]; bonds->loose.chunk_count > 0 && i < stripe[s + 1]; ++i) {
    call.fresh = 0;
    sdr_bonds_visit_loose_point(bonds, i, break_pair, &call);
    if (call.fresh) body->chunk_fresh[bonds->loose.lane[i] / SDR_LANES] = 1;
  }
}

void sdr_state_commit(sdr_model *model, double *const u[3])
{
  sdr_state_body *body = body_of(model);
  if (body->law == SDR_LAW_VARIATIONAL) {
    body->hooks->split(body, u);
    for (int32_t i = 0; i < model->points->count; ++i)
      if (body->plus[i] > body->history[i]) body->history[i] = body->plus[i];
  }
  if (body->law != SDR_LAW_CRITICAL_STRETCH) return;
  commit_call call = {body, u, 0};
  for (int s = 0; s < model->points->stripe_count; ++s) break_stripe(&call, s);
  sdr_state_book(body, u, NULL, 0.0);
}

/* ---- bonds lost ------------------------------------------------------------------------------ */

static void mark_fresh(void *context, const sdr_pair *pair)
{
  sdr_state_body *body = context;
  const sdr_flags flags = flags_of(body, pair);
  if (flags & SDR_FRESH_I) body->fresh[pair->i] = 1;
  if (flags & SDR_FRESH_J && !pair->loose) body->fresh[pair->j] = 1;
}

typedef struct {
  sdr_state_body *body;
  int stripe;
} clear_call;

static void clear_fresh(void *context, const sdr_pair *pair)
{
  const clear_call *call = context;
  sdr_state_body *body = call->body;
  sdr_flags *flags = (pair->loose ? body->loose_flags : body->flags) + pair->slot;
  if (*flags & FRESH && body->head.lost) sdr_lost_note(body->head.lost, call->stripe, pair, *flags);
  *flags &= ~FRESH;
}

/* Visit the pairs of the stripe's fresh runs and chunks. */
static void each_fresh_pair(const sdr_state_body *body, int s, sdr_pair_visitor visit,
                            void *context)
{
  const sdr_bonds *bonds = body->bonds;
  const int32_t *stripe = body->head.points->stripe_first;
  for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r)
    if (body->run_fresh[r]) sdr_bonds_visit_run(bonds, &bonds->runs[r], visit, context);
  for (int32_t i = stripe[s]; body->chunk_fresh && i < stripe[s + 1]; ++i)
    if (bonds->loose.lane[i] >= 0 && body->chunk_fresh[bonds->loose.lane[i] / SDR_LANES])
      sdr_bonds_visit_loose_point(bonds, i, visit, context);
}

static void mark_stripe(void *context, int s)
{
  each_fresh_pair(context, s, mark_fresh, context);
}

static void clear_stripe(void *context, int s)
{
  sdr_state_body *body = context;
  const int32_t *stripe = body->head.points->stripe_first;
  const int64_t first = body->bonds->stripe_run[s], end = body->bonds->stripe_run[s + 1];
  clear_call call = {body, s};
  each_fresh_pair(body, s, clear_fresh, &call);
  memset(body->fresh + stripe[s], 0, (size_t)(stripe[s + 1] - stripe[s]));
  if (body->run_fresh) memset(body->run_fresh + first, 0, (size_t)(end - first));
}

/* A point whose family would be left with more energy than it had keeps its bonds. */
static void give_back(void *context, const sdr_pair *pair)
{
  sdr_state_body *body = context;
  sdr_flags *flags = (pair->loose ? body->loose_flags : body->flags) + pair->slot;
  const int i = body->release[pair->i] < 0.0, j = body->release[pair->j] < 0.0;
  if (*flags & SDR_FRESH_I && i) *flags &= ~(SDR_FRESH_I | SDR_LOST_I);
  if (*flags & SDR_FRESH_J && j) *flags &= ~(SDR_FRESH_J | SDR_LOST_J);
}

static void give_back_stripe(void *context, int s)
{
  each_fresh_pair(context, s, give_back, context);
}

/* Book what points released; returns 1 if one keeps its bonds. Those are left fresh. */
static int take_releases(sdr_state_body *body)
{
  int kept = 0;
  for (int32_t i = 0; i < body->head.points->count; ++i) {
    if (!body->fresh[i]) continue;
    kept |= body->release[i] < 0.0;
    body->fresh[i] = body->release[i] < 0.0;
    if (body->release[i] > 0.0) body->booked[i] += body->release[i];
  }
  return kept;
}

void sdr_state_book(sdr_state_body *body, double *const u[3], double *const v[3], double dt)
{
  const sdr_bonds *bonds = body->bonds;
  const sdr_points *points = body->head.points;
  const size_t runs = (size_t)bonds->run_count, chunks = (size_t)bonds->loose.chunk_count;
  if (!(body->run_fresh && memchr(body->run_fresh, 1, runs)) &&
      !(body->chunk_fresh && memchr(body->chunk_fresh, 1, chunks)))
    return;
  sdr_each_stripe(points, mark_stripe, body);
  memset(body->release, 0, (size_t)points->count * sizeof *body->release);
  body->hooks->book(body, u, v, dt);
  if (take_releases(body)) {
    sdr_each_stripe(points, give_back_stripe, body);
    body->hooks->remake_fresh(body);
  }
  sdr_parallel_for(0, points->stripe_count, 1, clear_stripe, body);
  /* In order, a chunk may belong to two stripes, so its mark goes when both have looked. */
  if (body->chunk_fresh) memset(body->chunk_fresh, 0, chunks);
}

typedef struct {
  const sdr_state_body *body;
  sdr_pair_visitor visit;
  void *context;
} fresh_call;

static void visit_if_fresh(void *context, const sdr_pair *pair)
{
  const fresh_call *call = context;
  if (call->body->fresh[pair->i] || call->body->fresh[pair->j]) call->visit(call->context, pair);
}

void sdr_state_visit_fresh(const sdr_state_body *body, int s, sdr_pair_visitor visit, void *context)
{
  const sdr_bonds *bonds = body->bonds;
  const int32_t *stripe = body->head.points->stripe_first;
  fresh_call call = {body, visit, context};
  for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r) {
    const sdr_bond_run *run = &bonds->runs[r];
    const size_t length = (size_t)run->length;
    if (memchr(body->fresh + run->i0, 1, length) || memchr(body->fresh + run->j0, 1, length))
      sdr_bonds_visit_run(bonds, run, visit_if_fresh, &call);
  }
  for (int32_t i = stripe[s]; bonds->loose.chunk_count > 0 && i < stripe[s + 1]; ++i)
    if (body->fresh[i]) sdr_bonds_visit_loose_point(bonds, i, visit, context);
}

/* ---- energies -------------------------------------------------------------------------------- */

/* Stored and dissipated energy of point i, J/m^3; returns its damage. hooks->split came before. */
static double point_energy(const sdr_state_body *body, int32_t i, double *stored,
                           double *dissipated)
{
  const double plus = body->plus[i], d = sdr_state_damage(body, i, plus);
  *stored = (1.0 - d) * (1.0 - d) * plus + body->minus[i];
  *dissipated = 0.0;
  if (body->history)
    *dissipated = (plus > body->history[i] ? plus : body->history[i]) * d * (1.0 - d);
  if (body->booked) *dissipated = body->booked[i] / body->head.points->volume[i];
  return d;
}

static void count_lost(void *context, const sdr_pair *pair)
{
  const fresh_call *call = context;
  int64_t *lost = call->context;
  const sdr_flags flags = flags_of(call->body, pair);
  if (flags & SDR_CUT) return;
  *lost += flags & SDR_LOST_I && pair->weight_ij > 0.0;
  *lost += flags & SDR_LOST_J && pair->weight_ji > 0.0 && !pair->loose;
}

/* Directed bonds of stripe s lost since t = 0. */
static int64_t lost_of_stripe(const sdr_state_body *body, int s)
{
  const sdr_bonds *bonds = body->bonds;
  const int32_t *stripe = body->head.points->stripe_first;
  int64_t lost = 0;
  fresh_call call = {body, NULL, &lost};
  for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r)
    if (body->run_flagged[r]) sdr_bonds_visit_run(bonds, &bonds->runs[r], count_lost, &call);
  for (int32_t i = stripe[s]; body->loose_flags && i < stripe[s + 1]; ++i)
    sdr_bonds_visit_loose_point(bonds, i, count_lost, &call);
  return lost;
}

typedef struct {
  sdr_state_body *body;
  sdr_energies *stripe;
} energies_call;

static void energies_of_stripe(void *context, int s)
{
  const energies_call *call = context;
  const sdr_state_body *body = call->body;
  const sdr_points *points = body->head.points;
  sdr_energies *sum = &call->stripe[s];
  for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i) {
    double stored, dissipated;
    const double d = point_energy(body, i, &stored, &dissipated);
    sum->stored += points->volume[i] * stored;
    sum->dissipated += points->volume[i] * dissipated;
    if (d > sum->max_damage && body->family_count[i] > 0) sum->max_damage = d;
    if (d > 0.5) sum->broken += body->family_count[i];
  }
  if (body->law != SDR_LAW_CRITICAL_STRETCH) return;
  sum->broken = lost_of_stripe(body, s);
  sum->max_damage = sum->broken > 0 ? 1.0 : 0.0;
}

void sdr_state_energies(sdr_model *model, double *const u[3], sdr_energies *out)
{
  sdr_state_body *body = body_of(model);
  sdr_energies stripe[MOST_STRIPES];
  const int stripes = model->points->stripe_count;
  memset(stripe, 0, sizeof stripe);
  energies_call call = {body, stripe};
  body->hooks->split(body, u);
  sdr_parallel_for(0, stripes, 1, energies_of_stripe, &call);
  *out = (sdr_energies){0};
  for (int s = 0; s < stripes; ++s) {
    out->stored += stripe[s].stored;
    out->dissipated += stripe[s].dissipated;
    out->broken += stripe[s].broken;
    if (stripe[s].max_damage > out->max_damage) out->max_damage = stripe[s].max_damage;
  }
}

/* ---- fields ---------------------------------------------------------------------------------- */

typedef struct {
  const sdr_state_body *body;
  double *out;
} share_call;

/* Volume that the pair's lost halves have taken out of its points' families. */
static void add_lost_volume(void *context, const sdr_pair *pair)
{
  const share_call *call = context;
  const double *volume = call->body->head.points->volume;
  const sdr_flags flags = flags_of(call->body, pair);
  if (flags & SDR_LOST_I && pair->weight_ij > 0.0) call->out[pair->i] += volume[pair->j];
  if (flags & SDR_LOST_J && pair->weight_ji > 0.0 && !pair->loose)
    call->out[pair->j] += volume[pair->i];
}

static void lost_share(const sdr_state_body *body, double *out)
{
  const sdr_points *points = body->head.points;
  share_call call = {body, out};
  memset(out, 0, (size_t)points->count * sizeof *out);
  if (body->flags || body->loose_flags)
    sdr_bonds_visit(body->bonds, points, add_lost_volume, &call);
  for (int32_t i = 0; i < points->count; ++i)
    if (body->family_volume[i] > 0.0) out[i] /= body->family_volume[i];
}

sdr_status sdr_state_field(sdr_model *model, double *const u[3], sdr_model_field which, double *out)
{
  sdr_state_body *body = body_of(model);
  if (which == SDR_FIELD_DAMAGE && !body->history) {
    lost_share(body, out);
    return SDR_OK;
  }
  body->hooks->split(body, u);
  for (int32_t i = 0; i < model->points->count; ++i) {
    double stored, dissipated;
    const double d = point_energy(body, i, &stored, &dissipated);
    out[i] = which == SDR_FIELD_DAMAGE           ? d
             : which == SDR_FIELD_ENERGY_DENSITY ? stored
                                                 : dissipated;
  }
  return SDR_OK;
}

typedef struct {
  const sdr_state_body *body;
  void (*visit)(void *context, int32_t i, int32_t j, double damage);
  void *context;
} damage_call;

static void visit_pair_damage(void *context, const sdr_pair *pair)
{
  const damage_call *call = context;
  const sdr_state_body *body = call->body;
  if (!pair->primary) return;
  const sdr_flags flags = flags_of(body, pair);
  const double ni = pair->weight_ij > 0.0 ? 1.0 : 0.0, nj = pair->weight_ji > 0.0 ? 1.0 : 0.0;
  double damage = 1.0;
  if (body->history && !(flags & SDR_CUT))
    damage = 0.5 * (sdr_state_damage(body, pair->i, body->plus[pair->i]) +
                    sdr_state_damage(body, pair->j, body->plus[pair->j]));
  else if (!(flags & SDR_CUT))
    damage = ((flags & SDR_LOST_I ? ni : 0.0) + (flags & SDR_LOST_J ? nj : 0.0)) / (ni + nj);
  call->visit(call->context, pair->i, pair->j, damage);
}

void sdr_state_visit_damage(sdr_model *model, double *const u[3],
                            void (*visit)(void *context, int32_t i, int32_t j, double damage),
                            void *context)
{
  sdr_state_body *body = body_of(model);
  damage_call call = {body, visit, context};
  if (body->history) body->hooks->split(body, u);
  sdr_bonds_visit(body->bonds, model->points, visit_pair_damage, &call);
}

void sdr_state_visit_lost(const sdr_model *model, int s, sdr_lost_visitor visit, void *context)
{
  const sdr_state_body *body = (const sdr_state_body *)model;
  const int loose = body->law == SDR_LAW_CRITICAL_STRETCH || body->loose_flagged;
  const sdr_lost_where where = {.points = model->points,
                                .bonds = body->bonds,
                                .flags = body->flags,
                                .loose_flags = loose ? body->loose_flags : NULL,
                                .run_flagged = body->run_flagged};
  sdr_lost_visit(&where, s, visit, context);
}
