/* Bonds of non-ordinary bodies that critical stretch breaks (theory sec. 11). A half is lost once
   s > s0. Where a family has lost some, what is left of it no longer moves as one, and the part of
   z = eta - G xi across the bond, which its control resists without limit, counts too: halves are
   lost once s > 0 and s^2 + |z across|^2/xi^2 > s0^2. Else bonds almost along a crack, which
   hardly stretch as it opens, would hold it together and its energy hang on the direction. */
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/nonordinary_internal.h"

#include <math.h>
#include <string.h>

/* ---- bonds that break ------------------------------------------------------------------------ */

typedef struct {
  sdr_nonordinary_model *model;
  double *const *u;
  int fresh;
} break_call;

static void break_pair(void *context, const sdr_pair *pair)
{
  break_call *call = context;
  sdr_state_body *state = &call->model->state;
  sdr_flags *flags = (pair->loose ? state->loose_flags : state->flags) + pair->slot;
  const double s = sdr_pair_stretch(pair, state->head.points->components, call->u);
  const sdr_flags fresh = sdr_state_lost(state, pair, s, 1) & ~*flags;
  if (!fresh) return;
  *flags |= fresh | fresh << 2;
  call->fresh = 1;
}

static void break_stripe(void *context, int s)
{
  break_call call = *(const break_call *)context;
  sdr_nonordinary_model *model = call.model;
  sdr_state_body *state = &model->state;
  const sdr_bonds *bonds = state->bonds;
  const int64_t first = bonds->stripe_run[s], end = bonds->stripe_run[s + 1];
  sdr_nonordinary_body body = model->body;
  body.flags = state->flags;
  body.run_flagged = state->run_flagged;
  if (sdr_state_rests(state, s, 0, 1)) return;
  model->kernels->find[bonds->components - 1](&body, first, end, call.u, model->limit,
                                              model->found);
  for (int64_t r = first; r < end; ++r) {
    if (!model->found[r]) continue;
    call.fresh = 0;
    sdr_bonds_visit_run(bonds, &bonds->runs[r], break_pair, &call);
    if (call.fresh) state->run_fresh[r] = state->run_flagged[r] = 1;
  }
}

/* The slots of one loose point belong to it alone. */
static void break_chunks(void *context, int s)
{
  break_call call = *(const break_call *)context;
  sdr_nonordinary_model *model = call.model;
  sdr_state_body *state = &model->state;
  const int32_t count = state->head.points->count;
  int64_t first, end;
  sdr_state_chunks(state, s, &first, &end);
  sdr_nonordinary_body body = model->body;
  body.loose_flags = state->loose_flags;
  model->kernels->find_loose[state->bonds->components - 1](&body, first, end, call.u, model->limit,
                                                           model->found_loose);
  for (int64_t chunk = first; chunk < end; ++chunk) {
    if (!model->found_loose[chunk]) continue;
    call.fresh = 0;
    for (int64_t i = chunk * SDR_LANES; i < (chunk + 1) * SDR_LANES && i < count; ++i)
      sdr_bonds_visit_loose_point(state->bonds, (int32_t)i, break_pair, &call);
    if (call.fresh) state->chunk_fresh[chunk] = 1;
  }
}

/* ---- of torn families ------------------------------------------------------------------------ */

/* A half that point i owns and has not lost; `lost` and `flags` are its own. */
typedef struct {
  int32_t j;
  double xi[3], weight;
  sdr_flags *flags, lost;
  int64_t run; /* -1: loose */
} half;

/* Where the next half of a point is looked for. */
typedef struct {
  int bundle;
  int64_t slot;
} half_place;

static half_place first_half(const sdr_nonordinary_model *model, int32_t i)
{
  const sdr_loose *loose = &model->state.bonds->loose;
  return (half_place){0, loose->chunk_count > 0 ? loose->chunk_slot[i / SDR_LANES] + i % SDR_LANES
                                                : 0};
}

static int next_of_runs(const sdr_nonordinary_model *model, int32_t i, half_place *at, half *out)
{
  const sdr_nonordinary_body *body = &model->body;
  const sdr_block_bundles *block = &body->blocks[i / SDR_LANES];
  while (at->bundle < block->count) {
    const sdr_bundle *bundle = &body->bundles[block->first + at->bundle++];
    if (!((unsigned)bundle->lanes >> i % SDR_LANES & 1u)) continue;
    const sdr_bond_run *run = &body->bonds->runs[bundle->run];
    const sdr_direction *direction = &body->directions[bundle->direction];
    const int side = bundle->direction & 1;
    out->j = i + bundle->offset;
    out->weight = direction->own;
    out->flags = model->state.flags + run->slot + i - (side ? run->j0 : run->i0);
    out->lost = side ? SDR_LOST_J : SDR_LOST_I;
    out->run = bundle->run;
    memcpy(out->xi, direction->xi, sizeof out->xi);
    if (out->weight > 0.0 && !(*out->flags & out->lost)) return 1;
  }
  return 0;
}

static int next_loose(const sdr_nonordinary_model *model, int32_t i, half_place *at, half *out)
{
  const sdr_loose *loose = &model->state.bonds->loose;
  if (loose->chunk_count == 0) return 0;
  for (; at->slot < loose->chunk_slot[i / SDR_LANES + 1]; at->slot += SDR_LANES) {
    const int64_t slot = at->slot;
    out->j = loose->j[slot];
    out->weight = loose->weight_ij[slot];
    out->flags = model->state.loose_flags + slot;
    out->lost = SDR_LOST_I;
    out->run = -1;
    for (int a = 0; a < model->state.bonds->components; ++a) out->xi[a] = loose->xi[a][slot];
    if (!(out->weight > 0.0) || *out->flags & SDR_LOST_I) continue;
    at->slot += SDR_LANES;
    return 1;
  }
  return 0;
}

static int next_half(const sdr_nonordinary_model *model, int32_t i, half_place *at, half *out)
{
  return next_of_runs(model, i, at, out) || next_loose(model, i, at, out);
}

/* G of point i into the gradient's place. */
static void gradient_of(const sdr_nonordinary_model *model, int32_t i, double *const u[3])
{
  const int n = model->state.head.points->components;
  half_place at = first_half(model, i);
  half h;
  for (int k = 0; k < n * n; ++k) model->body.gradient[k][i] = 0.0;
  while (next_half(model, i, &at, &h))
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b)
        model->body.gradient[n * a + b][i] += h.weight * (u[a][h.j] - u[a][i]) * h.xi[b];
  sdr_nonordinary_gradient(model, i);
}

/* What is compared to s0^2 of the half from i to j, with G of i there. */
static double overstretch(const sdr_nonordinary_model *model, int32_t i, int32_t j,
                          const double xi[3], double *const u[3])
{
  const int n = model->state.head.points->components;
  const int finite = model->elasticity != SDR_LINEAR;
  double square = 0.0, change = 0.0, along = 0.0, f_square = 0.0, z_square = 0.0;
  for (int a = 0; a < n; ++a) {
    const double eta = u[a][j] - u[a][i];
    double p = 0.0;
    for (int b = 0; b < n; ++b) p += model->body.gradient[n * a + b][i] * xi[b];
    const double z = eta - p, f = xi[a] + (finite ? p : 0.0);
    square += xi[a] * xi[a];
    change += (2.0 * xi[a] + eta) * eta;
    along += z * f;
    f_square += f * f;
    z_square += z * z;
  }
  if (!(change > 0.0)) return 0.0;
  change /= square;
  const double s = change / (1.0 + sqrt(1.0 + change));
  const double across = z_square - (f_square > 0.0 ? along * along / f_square : 0.0);
  return s * s + across / square;
}

static int is_overstretched(const sdr_nonordinary_model *model, int32_t i, int32_t j,
                            const double xi[3], double *const u[3])
{
  return overstretch(model, i, j, xi, u) > model->state.threshold[i];
}

typedef struct {
  sdr_nonordinary_model *model;
  double *const *u;
} torn_call;

static void gradients_of_stripe(void *context, int s)
{
  const torn_call *call = context;
  const int32_t *stripe = call->model->state.head.points->stripe_first;
  for (int32_t i = stripe[s]; i < stripe[s + 1]; ++i)
    if (call->model->torn[i]) gradient_of(call->model, i, call->u);
}

static void tear_point(const torn_call *call, int32_t i)
{
  sdr_nonordinary_model *model = call->model;
  half_place at = first_half(model, i);
  half h;
  while (next_half(model, i, &at, &h)) {
    if (*h.flags & SDR_PROTECTED || !is_overstretched(model, i, h.j, h.xi, call->u)) continue;
    *h.flags |= h.lost | h.lost << 2;
    if (h.run < 0)
      model->found_loose[i / SDR_LANES] = 1;
    else
      model->state.run_fresh[h.run] = model->state.run_flagged[h.run] = 1;
  }
}

static void tear_stripe(void *context, int s)
{
  const torn_call *call = context;
  const int32_t *stripe = call->model->state.head.points->stripe_first;
  for (int32_t i = stripe[s]; i < stripe[s + 1]; ++i)
    if (call->model->torn[i]) tear_point(call, i);
}

/* The other half of loose pairs has its flag here too: the same sums decide with the same bits. */
static void tear_others(const torn_call *call, int32_t i)
{
  sdr_nonordinary_model *model = call->model;
  const sdr_loose *loose = &model->state.bonds->loose;
  const int64_t end = loose->chunk_slot[i / SDR_LANES + 1];
  for (int64_t slot = first_half(model, i).slot; slot < end; slot += SDR_LANES) {
    sdr_flags *flags = model->state.loose_flags + slot;
    const int32_t j = loose->j[slot];
    if (!model->torn[j] || !(loose->weight_ji[slot] > 0.0)) continue;
    if (*flags & (SDR_LOST_J | SDR_PROTECTED)) continue;
    double xi[3] = {0.0};
    for (int a = 0; a < model->state.bonds->components; ++a) xi[a] = -loose->xi[a][slot];
    if (!is_overstretched(model, j, i, xi, call->u)) continue;
    *flags |= SDR_LOST_J | SDR_FRESH_J;
    model->found_loose[i / SDR_LANES] = 1;
  }
}

static void tear_chunks(void *context, int s)
{
  const torn_call *call = context;
  sdr_nonordinary_model *model = call->model;
  const int32_t count = model->state.head.points->count;
  int64_t first, end;
  sdr_state_chunks(&model->state, s, &first, &end);
  memset(model->found_loose + first, 0, (size_t)(end - first));
  for (int64_t i = first * SDR_LANES; i < end * SDR_LANES && i < count; ++i) {
    if (model->torn[i]) tear_point(call, (int32_t)i);
    tear_others(call, (int32_t)i);
  }
  for (int64_t chunk = first; chunk < end; ++chunk)
    if (model->found_loose[chunk]) model->state.chunk_fresh[chunk] = 1;
}

/* Points of one stripe write to runs of theirs and of the stripe before; with loose bonds there are
   no runs, or a thread a chunk would meet another's. */
static void tear(sdr_nonordinary_model *model, double *const u[3])
{
  const sdr_points *points = model->state.head.points;
  torn_call call = {model, u};
  if (!memchr(model->torn, 1, (size_t)points->count)) return;
  sdr_parallel_for(0, points->stripe_count, 1, gradients_of_stripe, &call);
  if (model->state.bonds->loose.chunk_count == 0)
    sdr_each_stripe(points, tear_stripe, &call);
  else if (model->state.bonds->run_count == 0)
    sdr_parallel_for(0, points->stripe_count, 1, tear_chunks, &call);
  else
    for (int s = 0; s < points->stripe_count; ++s) tear_chunks(&call, s);
}

void sdr_nonordinary_break(sdr_nonordinary_model *model, double *const u[3])
{
  const sdr_state_body *state = &model->state;
  const int stripes = state->head.points->stripe_count;
  break_call call = {model, u, 0};
  sdr_state_watch(&model->state, u);
  sdr_parallel_for(0, stripes, 1, break_stripe, &call);
  if (state->bonds->loose.chunk_count > 0) sdr_parallel_for(0, stripes, 1, break_chunks, &call);
  tear(model, u);
}

void sdr_nonordinary_look(sdr_state_body *state, double *const u[3])
{
  torn_call call = {(sdr_nonordinary_model *)state, u};
  sdr_nonordinary_refresh(call.model);
  for (int s = 0; s < state->head.points->stripe_count; ++s) gradients_of_stripe(&call, s);
}

double sdr_nonordinary_overstretch(const sdr_state_body *state, const sdr_pair *pair, int from_i,
                                   double *const u[3])
{
  const sdr_nonordinary_model *model = (const sdr_nonordinary_model *)state;
  const int32_t i = from_i ? pair->i : pair->j, j = from_i ? pair->j : pair->i;
  double xi[3] = {0.0};
  if (!model->torn[i]) return sdr_state_square_stretch(state, pair, from_i, u);
  for (int a = 0; a < state->bonds->components; ++a) xi[a] = from_i ? pair->xi[a] : -pair->xi[a];
  return overstretch(model, i, j, xi, u);
}
