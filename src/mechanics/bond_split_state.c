/* What decides where points of bond-based bodies split: in one pass over the bonds, and only where
   something has moved. */
#include "base/memory.h"
#include "mechanics/bond_internal.h"

#include <math.h>
#include <string.h>

typedef struct {
  const sdr_bond_model *model;
  double *const *u;
  double *energy, *damage; /* out: sums over the bonds of each point */
  double *volume;          /* sum of V_j over the family */
} state_call;

/* What one pair adds to its two points. */
typedef struct {
  double energy;             /* J, half of the pair's */
  double damage_i, damage_j; /* of the directed bonds */
} share;

static inline double stretch_of(const double *xi, int n, double inverse_square, double *const *u,
                                int32_t i, int32_t j)
{
  double z = 0.0;
  for (int a = 0; a < n; ++a) {
    const double eta = u[a][j] - u[a][i];
    z += (2.0 * xi[a] + eta) * eta;
  }
  z *= inverse_square;
  return z / (1.0 + sqrt(fmax(1.0 + z, 1e-200)));
}

/* `k` and `flags`: the pair's history, whichever the law has. wi, wj: weights times length. */
static inline share share_of(const sdr_bond_body *body, int32_t i, int32_t j, double s, double wi,
                             double wj, float k, sdr_flags flags)
{
  const double ci = wi * sdr_body_stiffness(body, i), cj = wj * sdr_body_stiffness(body, j);
  if (flags & SDR_CUT || k == SDR_STRETCH_CUT) return (share){0.0, 0.0, 0.0};
  const double half = 0.25 * s * s; /* both halves of a pair add to both points */
  if (!sdr_law_softens((int)body->law) || k < 0.0f) {
    const double di = flags & SDR_LOST_I ? 1.0 : 0.0, dj = flags & SDR_LOST_J ? 1.0 : 0.0;
    return (share){half * ((1.0 - di) * ci + (1.0 - dj) * cj), di, dj};
  }
  const double grown = fmax((double)k, s);
  const sdr_softening at_i = sdr_softening_of((int)body->law, grown, sdr_body_threshold(body, i),
                                              sdr_body_decline(body, i));
  const sdr_softening at_j = sdr_softening_of((int)body->law, grown, sdr_body_threshold(body, j),
                                              sdr_body_decline(body, j));
  const double left_i = s > 0.0 ? at_i.left : 1.0, left_j = s > 0.0 ? at_j.left : 1.0;
  return (share){half * (left_i * ci + left_j * cj), at_i.damage, at_j.damage};
}

enum { PIECE = 128 };

/* The same of consecutive pairs of a run of laws without softening, which vectorises. */
static void add_sound_piece(const state_call *call, const sdr_bond_run *run, int32_t first,
                            int32_t length)
{
  const sdr_bond_body *body = &call->model->body;
  const sdr_bond_class *class = &body->bonds->classes[run->class_index];
  const double wi = class->weight_ij * class->length, wj = class->weight_ji * class->length;
  const int32_t i0 = run->i0 + first, j0 = run->j0 + first;
  const sdr_flags *flags = body->flags ? body->flags + run->slot + first : NULL;
  const double *volume = body->points->volume;
  double z[PIECE] = {0.0}, energy[PIECE], at_i[PIECE], at_j[PIECE];
  for (int a = 0; a < body->points->components; ++a) {
    const double *u = call->u[a];
    const double twice = 2.0 * class->xi[a];
    for (int32_t k = 0; k < length; ++k) {
      const double eta = u[j0 + k] - u[i0 + k];
      z[k] += (twice + eta) * eta;
    }
  }
  for (int32_t k = 0; k < length; ++k) {
    const sdr_flags f = flags ? flags[k] : 0;
    const double zk = z[k] * class->inverse_square, root = 1.0 + zk > 0.0 ? 1.0 + zk : 0.0;
    const double s = zk / (1.0 + sqrt(root));
    const double ci = body->stiffness_at ? body->stiffness_at[i0 + k] : body->stiffness;
    const double cj = body->stiffness_at ? body->stiffness_at[j0 + k] : body->stiffness;
    const double left_i = f & SDR_LOST_I ? 0.0 : wi, left_j = f & SDR_LOST_J ? 0.0 : wj;
    energy[k] = 0.25 * s * s * (ci * left_i + cj * left_j);
    at_i[k] = (f & (SDR_CUT | SDR_LOST_I)) == SDR_LOST_I ? volume[j0 + k] : 0.0;
    at_j[k] = (f & (SDR_CUT | SDR_LOST_J)) == SDR_LOST_J ? volume[i0 + k] : 0.0;
  }
  for (int32_t k = 0; k < length; ++k) {
    call->energy[i0 + k] += energy[k];
    call->damage[i0 + k] += at_i[k];
    call->volume[i0 + k] += volume[j0 + k];
  }
  for (int32_t k = 0; k < length; ++k) {
    call->energy[j0 + k] += energy[k];
    call->damage[j0 + k] += at_j[k];
    call->volume[j0 + k] += volume[i0 + k];
  }
}

static void add_sound_run(const state_call *call, const sdr_bond_run *run)
{
  for (int32_t k = 0; k < run->length; k += PIECE)
    add_sound_piece(call, run, k, run->length - k < PIECE ? run->length - k : PIECE);
}

static void add_run(const state_call *call, const sdr_bond_run *run)
{
  const sdr_bond_body *body = &call->model->body;
  const sdr_bond_class *class = &body->bonds->classes[run->class_index];
  const double *volume = body->points->volume;
  const double wi = class->weight_ij * class->length, wj = class->weight_ji * class->length;
  const int n = body->points->components;
  for (int32_t k = 0; k < run->length; ++k) {
    const int32_t i = run->i0 + k, j = run->j0 + k;
    const int64_t slot = run->slot + k;
    const double s = stretch_of(class->xi, n, class->inverse_square, call->u, i, j);
    const share one = share_of(body, i, j, s, wi, wj, body->stretch ? body->stretch[slot] : 0.0f,
                               body->flags ? body->flags[slot] : 0);
    call->energy[i] += one.energy;
    call->energy[j] += one.energy;
    call->damage[i] += volume[j] * one.damage_i;
    call->damage[j] += volume[i] * one.damage_j;
    call->volume[i] += volume[j];
    call->volume[j] += volume[i];
  }
}

static void add_loose(void *context, const sdr_pair *pair)
{
  const state_call *call = context;
  const sdr_bond_body *body = &call->model->body;
  const int32_t i = pair->i, j = pair->j;
  const double s = stretch_of(pair->xi, body->points->components,
                              1.0 / (pair->length * pair->length), call->u, i, j);
  const share one =
      share_of(body, i, j, s, pair->weight_ij * pair->length, pair->weight_ji * pair->length,
               body->loose_stretch ? body->loose_stretch[pair->slot] : 0.0f,
               body->loose_flags ? body->loose_flags[pair->slot] : 0);
  call->energy[i] += one.energy;
  if (!(pair->weight_ij > 0.0)) return;
  call->damage[i] += body->points->volume[j] * one.damage_i;
  call->volume[i] += body->points->volume[j];
}

static void add_stripe(void *context, int s)
{
  const state_call *call = context;
  const sdr_points *points = call->model->head.points;
  const sdr_bonds *bonds = call->model->bonds;
  const int softens = sdr_law_softens((int)call->model->body.law);
  const int64_t end = sdr_stripe_rests(call->model, s) ? 0 : bonds->stripe_run[s + 1];
  for (int64_t r = bonds->stripe_run[s]; r < end; ++r) {
    if (softens)
      add_run(call, &bonds->runs[r]);
    else
      add_sound_run(call, &bonds->runs[r]);
  }
  if (bonds->loose.chunk_count > 0)
    for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i)
      sdr_bonds_visit_loose_point(bonds, i, add_loose, context);
}

/* ---- lost bonds only ------------------------------------------------------------------------- */

static int any_lost(const sdr_flags *flags, int64_t length)
{
  sdr_flags any = 0;
  for (int64_t k = 0; k < length; ++k) any |= flags[k];
  return (any & (SDR_LOST_I | SDR_LOST_J)) != 0;
}

/* Volumes that the lost bonds of runs and of loose points take from their families. */
static void add_lost_stripe(void *context, int s)
{
  const state_call *call = context;
  const sdr_bond_body *body = &call->model->body;
  const sdr_points *points = call->model->head.points;
  const sdr_bonds *bonds = call->model->bonds;
  for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r) {
    const sdr_bond_run *run = &bonds->runs[r];
    const sdr_flags *flags = body->flags + run->slot;
    if (!any_lost(flags, run->length)) continue;
    for (int32_t k = 0; k < run->length; ++k) {
      const int32_t i = run->i0 + k, j = run->j0 + k;
      if (flags[k] & SDR_CUT) continue;
      if (flags[k] & SDR_LOST_I) call->damage[i] += points->volume[j];
      if (flags[k] & SDR_LOST_J) call->damage[j] += points->volume[i];
    }
  }
}

static void add_lost_loose(const state_call *call, int32_t i)
{
  const sdr_bond_body *body = &call->model->body;
  const sdr_loose *loose = &body->bonds->loose;
  int64_t slot;
  for (const int64_t end = sdr_loose_slots(loose, i, &slot); slot < end; slot += SDR_LANES)
    if ((body->loose_flags[slot] & (SDR_LOST_I | SDR_CUT)) == SDR_LOST_I &&
        loose->weight_ij[slot] > 0.0)
      call->damage[i] += body->points->volume[loose->j[slot]];
}

static sdr_status lost_shares(sdr_bond_model *model, double *damage)
{
  const sdr_points *points = model->head.points;
  const sdr_bond_body *body = &model->body;
  const sdr_loose *loose = &model->bonds->loose;
  state_call call = {.model = model, .damage = damage};
  SDR_TRY(sdr_bond_find_family_volume(model));
  memset(damage, 0, (size_t)points->count * sizeof *damage);
  if (body->flags) sdr_each_stripe(points, add_lost_stripe, &call);
  if (body->loose_flags && any_lost(body->loose_flags, loose->slot_count))
    for (int32_t i = 0; i < points->count; ++i) add_lost_loose(&call, i);
  for (int32_t i = 0; i < points->count; ++i)
    if (damage[i] > 0.0) damage[i] /= model->family_volume[i];
  return SDR_OK;
}

sdr_status sdr_bond_split_state(sdr_model *model, double *const u[3], double *energy,
                                double *damage)
{
  const sdr_points *points = model->points;
  if (!energy && !sdr_law_softens((int)((sdr_bond_model *)model)->body.law))
    return lost_shares((sdr_bond_model *)model, damage);
  const size_t padded = sdr_points_padded(points);
  double *sums = sdr_alloc(3 * padded, sizeof *sums);
  if (!sums) return SDR_RUN_FAILED;
  state_call call = {(sdr_bond_model *)model, u, sums, sums + padded, sums + 2 * padded};
  sdr_each_stripe(points, add_stripe, &call);
  for (int32_t i = 0; i < points->count; ++i) {
    if (energy) energy[i] = call.energy[i] / points->volume[i];
    damage[i] = call.volume[i] > 0.0 ? call.damage[i] / call.volume[i] : 0.0;
  }
  sdr_free(sums);
  return SDR_OK;
}
