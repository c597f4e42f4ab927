#include "mechanics/state_body.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/state_cut.h"

#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

static sdr_state_body *body_of(sdr_model *model)
{
  return (sdr_state_body *)model;
}

/* ---- constants ------------------------------------------------------------------------------- */

double sdr_state_bulk(sdr_dimension dimension, double young, double poisson)
{
  switch (dimension) {
  case SDR_1D:
    return young;
  case SDR_PLANE_STRESS:
    return young / (2.0 * (1.0 - poisson));
  case SDR_PLANE_STRAIN:
    return young / (2.0 * (1.0 + poisson) * (1.0 - 2.0 * poisson));
  default:
    return young / (3.0 * (1.0 - 2.0 * poisson));
  }
}

double sdr_state_shear(sdr_dimension dimension, double young, double poisson)
{
  return dimension == SDR_1D ? young / 3.0 : young / (2.0 * (1.0 + poisson));
}

double sdr_state_threshold(sdr_dimension dimension, double bulk, double shear, double toughness,
                           double horizon)
{
  double modulus;
  switch (dimension) {
  case SDR_1D: /* sum over the bonds across of 3 G xi^2/(2 m), m = 2 delta^3/3 */
    modulus = 9.0 / 8.0 * shear;
    break;
  case SDR_3D:
    modulus = 3.0 * shear + 81.0 / 256.0 * (bulk - 5.0 / 3.0 * shear);
    break;
  default:
    modulus = 6.0 / pi * shear + 16.0 / (9.0 * pi * pi) * (bulk - 2.0 * shear);
  }
  return toughness / (modulus * horizon);
}

double sdr_state_ell(const sdr_points *points, const sdr_length *given, int32_t i)
{
  const double horizon = points->horizon[i];
  if (given->value > 0.0) return given->relative ? given->value * horizon : given->value;
  return 2.0 * horizon * (points->irregular ? 1.0 : sdr_cut_lattice_reach(points, i));
}

void sdr_state_constants(const sdr_model *model, int32_t i, double *ell, double *threshold)
{
  const sdr_state_body *body = (const sdr_state_body *)model;
  *ell = body->ell ? body->ell[i] : (double)NAN;
  *threshold = body->threshold ? body->threshold[i] : (double)NAN;
}

/* ---- creation -------------------------------------------------------------------------------- */

static sdr_status check_constants(const sdr_points *points, const sdr_state_based_how *how)
{
  for (int32_t i = 0; how->dimension != SDR_1D && i < points->count; ++i) {
    const double nu = how->poisson[points->material[i]];
    if (!(nu > -1.0 && nu < 0.5))
      return sdr_fail(SDR_BAD_INPUT,
                      "a state-based body needs a Poisson's ratio above -1 and below 0.5, not %g",
                      nu);
  }
  return SDR_OK;
}

static sdr_status alloc_points(double **array, const sdr_points *points)
{
  *array = sdr_alloc(sdr_points_padded(points), sizeof(double));
  return *array ? SDR_OK : SDR_RUN_FAILED;
}

/* The length ell of every point. */
static void set_ell(sdr_state_body *body, const sdr_length *given)
{
  const sdr_points *points = body->head.points;
  const int banded = points->irregular && !(given->value > 0.0);
  const double reach = banded ? sdr_cut_reach(points, body->bonds) : 1.0;
  for (int32_t i = 0; i < points->count; ++i) {
    const int same = i > 0 && points->horizon[i] == points->horizon[i - 1] &&
                     points->spacing[i] == points->spacing[i - 1];
    body->ell[i] = same ? body->ell[i - 1] : reach * sdr_state_ell(points, given, i);
  }
}

static sdr_status set_constants(sdr_state_body *body, const sdr_state_based_how *how)
{
  const sdr_points *points = body->head.points;
  const int variational = body->law == SDR_LAW_VARIATIONAL;
  const int critical = body->law == SDR_LAW_CRITICAL_STRETCH;
  SDR_TRY(alloc_points(&body->bulk, points));
  SDR_TRY(alloc_points(&body->shear, points));
  if (variational) SDR_TRY(alloc_points(&body->ell, points));
  if (variational) SDR_TRY(alloc_points(&body->softness, points));
  if (critical) SDR_TRY(alloc_points(&body->threshold, points));
  if (variational) set_ell(body, &how->ell);
  for (int32_t i = 0; i < points->count; ++i) {
    const int material = points->material[i];
    const double nu = how->dimension == SDR_1D ? 0.0 : how->poisson[material];
    body->bulk[i] = sdr_state_bulk(how->dimension, how->young[i], nu);
    body->shear[i] = sdr_state_shear(how->dimension, how->young[i], nu);
    if (variational) body->softness[i] = body->ell[i] / how->toughness[material];
    if (critical)
      body->threshold[i] = sdr_state_threshold(how->dimension, body->bulk[i], body->shear[i],
                                               how->toughness[material], points->horizon[i]);
  }
  return SDR_OK;
}

/* Flags for all slots, zero, where they are not there yet. */
static sdr_status alloc_flags(sdr_state_body *body)
{
  const sdr_bonds *bonds = body->bonds;
  const size_t runs = (size_t)bonds->run_slots, loose = (size_t)bonds->loose.slot_count;
  if (runs > 0 && !body->flags && !(body->flags = sdr_alloc(runs, sizeof(sdr_flags))))
    return SDR_RUN_FAILED;
  if (runs > 0 && !body->run_flagged &&
      !(body->run_flagged = sdr_alloc((size_t)bonds->run_count, 1)))
    return SDR_RUN_FAILED;
  if (loose > 0 && !body->loose_flags && !(body->loose_flags = sdr_alloc(loose, sizeof(sdr_flags))))
    return SDR_RUN_FAILED;
  return SDR_OK;
}

static sdr_status alloc_state(sdr_state_body *body)
{
  const sdr_points *points = body->head.points;
  const sdr_bonds *bonds = body->bonds;
  SDR_TRY(alloc_points(&body->plus, points));
  SDR_TRY(alloc_points(&body->minus, points));
  SDR_TRY(alloc_points(&body->family_volume, points));
  body->family_count = sdr_alloc(sdr_points_padded(points), sizeof(int32_t));
  body->moved = sdr_alloc((size_t)points->stripe_count, 1);
  if (!body->family_count || !body->moved) return SDR_RUN_FAILED;
  if (body->law == SDR_LAW_VARIATIONAL) SDR_TRY(alloc_points(&body->history, points));
  if (body->law != SDR_LAW_CRITICAL_STRETCH) return SDR_OK;
  SDR_TRY(alloc_flags(body));
  SDR_TRY(alloc_points(&body->booked, points));
  SDR_TRY(alloc_points(&body->release, points));
  body->fresh = sdr_alloc(sdr_points_padded(points), 1);
  if (!body->fresh) return SDR_RUN_FAILED;
  if (bonds->run_count > 0 && !(body->run_fresh = sdr_alloc((size_t)bonds->run_count, 1)))
    return SDR_RUN_FAILED;
  if (bonds->loose.chunk_count > 0 &&
      !(body->chunk_fresh = sdr_alloc((size_t)bonds->loose.chunk_count, 1)))
    return SDR_RUN_FAILED;
  return SDR_OK;
}

static void count_family(void *context, const sdr_pair *pair)
{
  sdr_state_body *body = context;
  const double *volume = body->head.points->volume;
  if (pair->weight_ij > 0.0) {
    body->family_volume[pair->i] += volume[pair->j];
    ++body->family_count[pair->i];
  }
  if (pair->loose || !(pair->weight_ji > 0.0)) return;
  body->family_volume[pair->j] += volume[pair->i];
  ++body->family_count[pair->j];
}

sdr_status sdr_state_body_init(sdr_state_body *body, const sdr_model_ops *ops,
                               const sdr_state_hooks *hooks, const sdr_points *points,
                               sdr_bonds *bonds, const sdr_state_based_how *how)
{
  body->head = (sdr_model){.ops = ops, .points = points, .bonds = bonds->directed};
  body->hooks = hooks;
  body->bonds = bonds;
  body->dimension = how->dimension;
  body->law = how->law;
  SDR_TRY(check_constants(points, how));
  SDR_TRY(set_constants(body, how));
  SDR_TRY(alloc_state(body));
  sdr_bonds_visit(bonds, points, count_family, body);
  return SDR_OK;
}

void sdr_state_body_clear(sdr_state_body *body)
{
  sdr_bonds_destroy(&body->bonds);
  void *const blocks[] = {
      body->bulk,      body->shear,         body->ell,          body->softness,    body->threshold,
      body->history,   body->flags,         body->loose_flags,  body->run_flagged, body->booked,
      body->run_fresh, body->chunk_fresh,   body->fresh,        body->plus,        body->minus,
      body->moved,     body->family_volume, body->family_count, body->release};
  for (size_t k = 0; k < sizeof blocks / sizeof *blocks; ++k) sdr_free(blocks[k]);
}

/* ---- marks ----------------------------------------------------------------------------------- */

typedef struct {
  sdr_state_body *body;
  sdr_pair_mark mark;
  const void *context;
  int64_t cut; /* directed bonds */
} mark_call;

static void position(const sdr_points *points, int32_t i, double x[3])
{
  for (int a = 0; a < 3; ++a) x[a] = a < points->components ? points->x[a][i] : 0.0;
}

static void mark_pair(void *context, const sdr_pair *pair)
{
  mark_call *call = context;
  sdr_state_body *body = call->body;
  double a[3], b[3];
  position(body->head.points, pair->i, a);
  position(body->head.points, pair->j, b);
  const int mark = call->mark(call->context, a, b);
  sdr_flags *flags = (pair->loose ? body->loose_flags : body->flags) + pair->slot;
  if (mark == SDR_CUT) {
    if (pair->weight_ij > 0.0 && !(*flags & SDR_CUT)) --body->family_count[pair->i];
    if (pair->weight_ji > 0.0 && !(*flags & SDR_CUT) && !pair->loose) --body->family_count[pair->j];
    *flags = SDR_CUT | SDR_LOST_I | SDR_LOST_J;
    if (pair->primary) call->cut += (pair->weight_ij > 0.0) + (pair->weight_ji > 0.0);
  } else if (mark == SDR_PROTECTED && body->law == SDR_LAW_CRITICAL_STRETCH) {
    *flags = SDR_PROTECTED;
  }
  if (pair->loose && *flags) body->loose_flagged = 1;
}

static int run_has_flag(const sdr_state_body *body, const sdr_bond_run *run)
{
  for (int64_t slot = run->slot; slot < run->slot + run->length; ++slot)
    if (body->flags[slot]) return 1;
  return 0;
}

sdr_status sdr_state_mark(sdr_model *model, sdr_pair_mark mark, const void *context,
                          int64_t *cut_bonds)
{
  sdr_state_body *body = body_of(model);
  const sdr_points *points = model->points;
  SDR_TRY(alloc_flags(body));
  mark_call call = {.body = body, .mark = mark, .context = context};
  sdr_bonds_visit(body->bonds, points, mark_pair, &call);
  for (int64_t r = 0; r < body->bonds->run_count; ++r)
    body->run_flagged[r] = (uint8_t)run_has_flag(body, &body->bonds->runs[r]);
  for (int32_t i = 0; body->softness && i < points->count; ++i) {
    double x[3];
    position(points, i, x);
    if (mark(context, x, x) == SDR_PROTECTED) body->softness[i] = 0.0;
  }
  if (body->hooks->remake) SDR_TRY(body->hooks->remake(body));
  *cut_bonds = call.cut;
  return SDR_OK;
}

/* ---- stripes --------------------------------------------------------------------------------- */

void sdr_state_chunks(const sdr_state_body *body, int s, int64_t *first, int64_t *end)
{
  const sdr_loose *loose = &body->bonds->loose;
  *first = loose->chunk_count > 0 ? loose->stripe_chunk[s] : 0;
  *end = loose->chunk_count > 0 ? loose->stripe_chunk[s + 1] : 0;
}

typedef struct {
  sdr_state_body *body;
  double *const *u;
} watch_call;

static void watch_stripe(void *context, int s)
{
  const watch_call *call = context;
  const sdr_points *points = call->body->head.points;
  if (call->body->moved[s]) return;
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i)
      if (call->u[a][i] != 0.0) {
        call->body->moved[s] = 1;
        return;
      }
}

void sdr_state_watch(sdr_state_body *body, double *const u[3])
{
  const int stripes = body->head.points->stripe_count;
  watch_call call = {body, u};
  if (memchr(body->moved, 0, (size_t)stripes)) sdr_parallel_for(0, stripes, 1, watch_stripe, &call);
}

int sdr_state_rests(const sdr_state_body *body, int s, int below, int above)
{
  const int last = body->head.points->stripe_count - 1;
  const int from = s - below > 0 ? s - below : 0, to = s + above < last ? s + above : last;
  for (int k = from; k <= to; ++k)
    if (body->moved[k]) return 0;
  return !body->keep_resting;
}

void sdr_state_skip_rest(sdr_model *model, int skip)
{
  body_of(model)->keep_resting = !skip;
}

/* ---- what it is made of ---------------------------------------------------------------------- */

static int same_everywhere(const double *values, int32_t count)
{
  for (int32_t i = 1; values && i < count; ++i)
    if (values[i] != values[0]) return 0;
  return 1;
}

void sdr_state_traits(const sdr_model *model, sdr_model_traits *out)
{
  const sdr_state_body *body = (const sdr_state_body *)model;
  const sdr_points *points = model->points;
  const size_t slots = (size_t)(body->bonds->run_slots + body->bonds->loose.slot_count);
  int moved = 0;
  for (int s = 0; s < points->stripe_count; ++s) moved += body->moved[s];
  *out = (sdr_model_traits){.name = model->ops->name,
                            .isa = body->hooks->isa(body),
                            .bonds = body->bonds,
                            .shared_moduli = same_everywhere(body->bulk, points->count) &&
                                             same_everywhere(body->shear, points->count),
                            .moved = (double)moved / points->stripe_count};
  if (body->history) out->history_bytes += (size_t)points->count * sizeof(double);
  if (body->flags || body->loose_flags) out->history_bytes += slots * sizeof(sdr_flags);
}

void sdr_state_blocks(sdr_model *model, sdr_state_block *blocks, int *count)
{
  sdr_state_body *body = body_of(model);
  const sdr_bonds *bonds = body->bonds;
  const size_t points = (size_t)model->points->count, runs = (size_t)bonds->run_slots;
  const size_t loose = (size_t)bonds->loose.slot_count;
  int n = 0;
  if (body->history)
    blocks[n++] = (sdr_state_block){"history", body->history, points * sizeof(double)};
  if (body->flags) blocks[n++] = (sdr_state_block){"flags", body->flags, runs * sizeof(sdr_flags)};
  if (body->run_flagged)
    blocks[n++] = (sdr_state_block){"run_flagged", body->run_flagged, (size_t)bonds->run_count};
  if (body->loose_flags)
    blocks[n++] = (sdr_state_block){"loose_flags", body->loose_flags, loose * sizeof(sdr_flags)};
  blocks[n++] = (sdr_state_block){"moved", body->moved, (size_t)model->points->stripe_count};
  if (body->booked)
    blocks[n++] = (sdr_state_block){"booked", body->booked, points * sizeof(double)};
  *count = n;
}
