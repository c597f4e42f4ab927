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

static sdr_bond_answer whole(double s)
{
  return sdr_bond_law(SDR_LAW_NONE, s, 0.0, 1.0, 1.0);
}

/* The history is a stretch. Explicit bodies keep it as a float, and answer as with that float. */
static sdr_pair_answer softening_answer(const sdr_bond_body *body, const sdr_pair *pair, double s)
{
  const double before =
      body->precise ? (pair->loose ? body->loose_history : body->history)[pair->slot]
                    : (double)(pair->loose ? body->loose_stretch : body->stretch)[pair->slot];
  if (before == (double)SDR_STRETCH_CUT)
    return (sdr_pair_answer){sdr_bond_lost(), sdr_bond_lost(), 1};
  if (before < 0.0) return (sdr_pair_answer){whole(s), whole(s), 0};
  const double now = body->precise ? s : (double)(float)s;
  const int loading = s > 0.0 && now >= before;
  const double k = loading ? now : before;
  const int32_t i = pair->i, j = pair->j;
  return (sdr_pair_answer){sdr_bond_law_at((int)body->law, s, k, loading,
                                           sdr_body_threshold(body, i), sdr_body_decline(body, i)),
                           sdr_bond_law_at((int)body->law, s, k, loading,
                                           sdr_body_threshold(body, j), sdr_body_decline(body, j)),
                           0};
}

sdr_pair_answer sdr_pair_answer_at(const sdr_bond_body *body, const sdr_pair *pair, double s)
{
  if (sdr_law_softens((int)body->law)) return softening_answer(body, pair, s);
  const sdr_flags *flags = pair->loose ? body->loose_flags : body->flags;
  const sdr_flags flag = flags ? flags[pair->slot] : 0;
  return (sdr_pair_answer){flag & SDR_LOST_I ? sdr_bond_lost() : whole(s),
                           flag & SDR_LOST_J ? sdr_bond_lost() : whole(s), (flag & SDR_CUT) != 0};
}

void sdr_stripe_chunks(const sdr_bond_body *body, int s, int64_t *first, int64_t *end)
{
  const sdr_loose *loose = &body->bonds->loose;
  *first = loose->chunk_count > 0 ? loose->stripe_chunk[s] : 0;
  *end = loose->chunk_count > 0 ? loose->stripe_chunk[s + 1] : 0;
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
