/* What the files of the bond-based model share: one pair's stretch and state, stripes, rest. */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"

#include <math.h>
#include <string.h>

double sdr_pair_stretch(const sdr_pair *pair, int components, double *const u[3])
{
  double z = 0.0;
  for (int a = 0; a < components; ++a) {
    const double eta = u[a][pair->j] - u[a][pair->i];
    z += (2.0 * pair->xi[a] + eta) * eta;
  }
  z /= pair->length * pair->length;
  return z / (1.0 + sqrt(fmax(1.0 + z, 1e-200)));
}

static sdr_pair_state variational_state(const sdr_bond_body *body, const sdr_pair *pair, double s,
                                        float k)
{
  if (k == SDR_STRETCH_CUT) return (sdr_pair_state){1.0, 1.0, 1, 0};
  if (k == SDR_STRETCH_PROTECTED) return (sdr_pair_state){0.0, 0.0, 0, 1};
  const float now = (float)s, grown = k > now ? k : now;
  return (sdr_pair_state){sdr_variational_damage(grown, sdr_body_threshold(body, pair->i)),
                          sdr_variational_damage(grown, sdr_body_threshold(body, pair->j)), 0, 0};
}

sdr_pair_state sdr_pair_state_at(const sdr_bond_body *body, const sdr_pair *pair, double s)
{
  const float *stretch = pair->loose ? body->loose_stretch : body->stretch;
  const sdr_flags *flags = pair->loose ? body->loose_flags : body->flags;
  if (body->law == SDR_LAW_VARIATIONAL)
    return variational_state(body, pair, s, stretch[pair->slot]);
  if (!flags) return (sdr_pair_state){0.0, 0.0, 0, 0};
  const sdr_flags flag = flags[pair->slot];
  return (sdr_pair_state){sdr_flag_damage(flag, SDR_LOST_I), sdr_flag_damage(flag, SDR_LOST_J),
                          (flag & SDR_CUT) != 0, (flag & SDR_PROTECTED) != 0};
}

void sdr_stripe_chunks(const sdr_bond_body *body, int s, int64_t *first, int64_t *end)
{
  const int32_t *stripe = body->points->stripe_first;
  const int some = body->bonds->loose.chunk_count > 0;
  *first = some ? (stripe[s] + SDR_LANES - 1) / SDR_LANES : 0;
  *end = some ? (stripe[s + 1] + SDR_LANES - 1) / SDR_LANES : 0;
}

void sdr_each_stripe(const sdr_points *points, void (*task)(void *, int), void *context)
{
  sdr_parallel_for(0, points->stripe_count, 2, task, context);
  sdr_parallel_for(1, points->stripe_count, 2, task, context);
}

/* ---- rest ----------------------------------------------------------------------------------- */

typedef struct {
  sdr_bond_model *model;
  double *const *u;
} watch_call;

static void watch_stripe(void *context, int s)
{
  const watch_call *call = context;
  sdr_bond_model *model = call->model;
  const sdr_points *points = model->head.points;
  if (model->moved[s]) return;
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i)
      if (call->u[a][i] != 0.0) {
        model->moved[s] = 1;
        return;
      }
}

void sdr_bond_watch(sdr_bond_model *model, double *const u[3])
{
  const int stripes = model->head.points->stripe_count;
  watch_call call = {model, u};
  if (memchr(model->moved, 0, (size_t)stripes))
    sdr_parallel_for(0, stripes, 1, watch_stripe, &call);
}

sdr_status sdr_bond_alloc_flags(sdr_bond_model *model)
{
  sdr_bond_body *body = &model->body;
  const size_t runs = (size_t)model->bonds->run_slots;
  const size_t loose = (size_t)model->bonds->loose.slot_count;
  if (runs > 0 && !body->flags && !(body->flags = sdr_alloc(runs, sizeof(sdr_flags))))
    return SDR_RUN_FAILED;
  if (loose > 0 && !body->loose_flags && !(body->loose_flags = sdr_alloc(loose, sizeof(sdr_flags))))
    return SDR_RUN_FAILED;
  return SDR_OK;
}
