/* Energies of bond-based bodies, and the books of bonds that critical stretch loses. */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"

#include <math.h>
#include <string.h>

typedef struct {
  sdr_bond_model *model;
  double *const *u;
  sdr_stripe_energies *stripe;
} energies_call;

/* One loose slot: the directed bond i -> j of its own lane, so that each counts once. */
static void energies_of_slot(const sdr_bond_body *body, const sdr_pair *pair, double *const u[3],
                             sdr_stripe_energies *sum)
{
  if (pair->weight_ij <= 0.0) return;
  const double s = sdr_pair_stretch(pair, body->points->components, u);
  const double whole = pair->weight_ij * sdr_body_stiffness(body, pair->i) * pair->length;
  const sdr_pair_answer answer = sdr_pair_answer_at(body, pair, s);
  if (answer.cut) return;
  sum->stored += whole * answer.ij.stored;
  sum->dissipated += whole * answer.ij.dissipated;
  sum->broken += answer.ij.damage > 0.5;
  if (answer.ij.damage > sum->max_damage) sum->max_damage = answer.ij.damage;
}

typedef struct {
  const energies_call *call;
  sdr_stripe_energies *sum;
} slot_call;

static void visit_slot(void *context, const sdr_pair *pair)
{
  const slot_call *slot = context;
  energies_of_slot(&slot->call->model->body, pair, slot->call->u, slot->sum);
}

/* The same of all slots of point i, of laws whose histories are flags: without a call a pair. */
static void energies_of_flagged(const sdr_bond_body *body, int32_t i, double *const u[3],
                                sdr_stripe_energies *sum)
{
  const sdr_loose *loose = &body->bonds->loose;
  const int n = body->points->components;
  double stored = 0.0;
  int64_t slot;
  for (const int64_t end = sdr_loose_slots(loose, i, &slot); slot < end; slot += SDR_LANES) {
    const int32_t j = loose->j[slot];
    const sdr_flags flags = body->loose_flags ? body->loose_flags[slot] : 0;
    double z = 0.0, square = 0.0;
    if (!(loose->weight_ij[slot] > 0.0) || flags & SDR_CUT) continue; /* padding weighs nothing */
    if (flags & SDR_LOST_I) {
      ++sum->broken;
      sum->max_damage = 1.0;
      continue;
    }
    for (int a = 0; a < n; ++a) {
      const double xi = loose->xi[a][slot], eta = u[a][j] - u[a][i];
      z += (2.0 * xi + eta) * eta;
      square += xi * xi;
    }
    z /= square;
    const double s = z / (1.0 + sqrt(1.0 + z > 1e-200 ? 1.0 + z : 1e-200));
    stored += loose->weight_ij[slot] * sqrt(square) * s * s;
  }
  sum->stored += 0.5 * sdr_body_stiffness(body, i) * stored;
}

/* Loose pairs join any stripes: theirs may not rest. */
static void energies_of_loose(const energies_call *call, int s, sdr_stripe_energies *sum)
{
  const sdr_bond_model *model = call->model;
  if (!model->body.precise) {
    const int32_t *stripe = model->head.points->stripe_first;
    slot_call slot = {call, sum};
    for (int32_t i = stripe[s]; i < stripe[s + 1]; ++i) {
      if (sdr_law_softens((int)model->body.law))
        sdr_bonds_visit_loose_point(model->bonds, i, visit_slot, &slot);
      else
        energies_of_flagged(&model->body, i, call->u, sum);
    }
    return;
  }
  int64_t first, end;
  sdr_stripe_chunks(&model->body, s, &first, &end);
  const int n = model->head.points->components, each = model->body.stiffness_at != NULL;
  model->precise->loose_energies[model->body.law][n - 1][each](&model->body, first, end, call->u,
                                                               sum);
}

static void energies_of_stripe(void *context, int s)
{
  const energies_call *call = context;
  sdr_bond_model *model = call->model;
  const sdr_bonds *bonds = model->bonds;
  const int n = model->head.points->components, each = model->body.stiffness_at != NULL;
  sdr_stripe_energies *sum = &call->stripe[s];
  const sdr_run_energies energies =
      model->body.precise ? model->precise->run_energies[model->body.law][n - 1][each]
                          : model->kernels->run_energies[model->body.law][n - 1][each];
  if (!sdr_stripe_rests(model, s))
    energies(&model->body, bonds->stripe_run[s], bonds->stripe_run[s + 1], call->u, sum);
  if (bonds->loose.chunk_count > 0) energies_of_loose(call, s, sum);
  if (model->booked) sum->dissipated += model->booked[s];
}

void sdr_bond_energies(sdr_model *model, double *const u[3], sdr_energies *out)
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  enum { MOST_STRIPES = 256 };
  static _Thread_local sdr_stripe_energies stripe[MOST_STRIPES];
  const int stripes = model->points->stripe_count;
  memset(stripe, 0, sizeof stripe);
  energies_call call = {bond, u, stripe};
  sdr_bond_watch(bond, u);
  sdr_parallel_for(0, stripes, 1, energies_of_stripe, &call);
  *out = (sdr_energies){0};
  for (int s = 0; s < stripes; ++s) {
    out->stored += stripe[s].stored;
    out->dissipated += stripe[s].dissipated;
    out->broken += stripe[s].broken;
    if (stripe[s].max_damage > out->max_damage) out->max_damage = stripe[s].max_damage;
  }
}

/* ---- bonds lost ------------------------------------------------------------------------------ */

typedef struct {
  sdr_bond_model *model;
  double *const *u, *const *v;
  double dt, sum;
  int stripe;
} book_call;

/* Stretch before the step: at u - dt v. */
static double stretch_before(const sdr_pair *pair, int components, const book_call *call)
{
  if (!call->v) return sdr_pair_stretch(pair, components, call->u);
  double before[3][2], *u[3] = {NULL};
  sdr_pair local = *pair;
  local.i = 0;
  local.j = 1;
  for (int a = 0; a < components; ++a) {
    before[a][0] = call->u[a][pair->i] - call->dt * call->v[a][pair->i];
    before[a][1] = call->u[a][pair->j] - call->dt * call->v[a][pair->j];
    u[a] = before[a];
  }
  return sdr_pair_stretch(&local, components, u);
}

/* Leapfrog loses 1/2 C |xi| s_n s_(n+1) with a bond (theory sec. 4). */
static void book_pair(book_call *call, const sdr_pair *pair, sdr_flags *flags)
{
  const sdr_flags fresh = *flags & (SDR_FRESH_I | SDR_FRESH_J);
  if (!fresh) return;
  *flags = (*flags & ~(SDR_FRESH_I | SDR_FRESH_J));
  const sdr_bond_body *body = &call->model->body;
  const int n = body->points->components;
  const double product = sdr_pair_stretch(pair, n, call->u) * stretch_before(pair, n, call);
  /* A loose slot books the half of its own lane; the other half is booked in j's lane. */
  const double half = 0.5 * pair->length * product;
  if (fresh & SDR_FRESH_I) call->sum += half * pair->weight_ij * sdr_body_stiffness(body, pair->i);
  if (fresh & SDR_FRESH_J && !pair->loose)
    call->sum += half * pair->weight_ji * sdr_body_stiffness(body, pair->j);
  if (call->model->head.lost) sdr_lost_note(call->model->head.lost, call->stripe, pair, *flags);
}

static void book_of_run(void *context, const sdr_pair *pair)
{
  book_call *call = context;
  book_pair(call, pair, call->model->body.flags + pair->slot);
}

static void book_loose(void *context, const sdr_pair *pair)
{
  book_call *call = context;
  if (pair->loose) book_pair(call, pair, call->model->body.loose_flags + pair->slot);
}

static int any_fresh_chunk(const sdr_bond_body *body, int s)
{
  int64_t chunk, end;
  sdr_stripe_chunks(body, s, &chunk, &end);
  /* In order, a stripe's first points may lie in a chunk that starts in the stripe before. */
  if (body->bonds->loose.in_order && end > 0 && chunk > 0) --chunk;
  for (; chunk < end; ++chunk)
    if (body->chunk_fresh[chunk]) return 1;
  return 0;
}

void sdr_bond_book(sdr_bond_model *model, int s, double *const u[3], double *const v[3], double dt)
{
  sdr_bond_body *body = &model->body;
  const sdr_bonds *bonds = model->bonds;
  book_call call = {model, u, v, dt, 0.0, s};
  for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r) {
    if (!body->run_fresh[r]) continue;
    sdr_bonds_visit_run(bonds, &bonds->runs[r], book_of_run, &call);
    body->run_fresh[r] = 0;
  }
  if (bonds->loose.chunk_count > 0 && any_fresh_chunk(body, s))
    for (int32_t i = body->points->stripe_first[s]; i < body->points->stripe_first[s + 1]; ++i)
      sdr_bonds_visit_loose_point(bonds, i, book_loose, &call);
  model->booked[s] += call.sum;
}
