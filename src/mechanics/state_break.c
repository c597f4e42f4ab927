/* Critical stretch of state-based bodies under static loads: the most overstretched bonds go, and
   the body finds its balance again (theory sec. 7). */
#include "mechanics/bond_internal.h"
#include "mechanics/state_body.h"

#include <math.h>

typedef struct {
  sdr_state_body *body;
  double *const *u;
  double least, most; /* over the threshold: from which halves go; the largest found */
  int fresh;          /* 1 once a pair lost something */
  int64_t lost;
} break_call;

/* What decides about the half that `lost` names, over its threshold; 0: it stays, or is gone. */
static double excess(const break_call *call, const sdr_pair *pair, sdr_flags flags, int lost)
{
  const sdr_state_body *body = call->body;
  const int from_i = lost == SDR_LOST_I;
  const double threshold = body->threshold[from_i ? pair->i : pair->j];
  if (flags & (lost | SDR_PROTECTED)) return 0.0;
  if (!((from_i ? pair->weight_ij : pair->weight_ji) > 0.0)) return 0.0;
  const double square = body->hooks->overstretch(body, pair, from_i, call->u);
  return square > threshold ? square / threshold : 0.0;
}

static sdr_flags *flags_of(const sdr_state_body *body, const sdr_pair *pair)
{
  return (pair->loose ? body->loose_flags : body->flags) + pair->slot;
}

static void find_most(void *context, const sdr_pair *pair)
{
  break_call *call = context;
  const sdr_flags flags = *flags_of(call->body, pair);
  call->most = fmax(call->most, excess(call, pair, flags, SDR_LOST_I));
  call->most = fmax(call->most, excess(call, pair, flags, SDR_LOST_J));
}

static void count_lost(void *context, const sdr_pair *pair)
{
  break_call *call = context;
  const sdr_flags flags = *flags_of(call->body, pair);
  call->lost += flags & SDR_LOST_I && pair->weight_ij > 0.0;
  call->lost += flags & SDR_LOST_J && pair->weight_ji > 0.0 && !pair->loose;
}

static int64_t lost_halves(sdr_state_body *body)
{
  break_call call = {.body = body};
  sdr_bonds_visit(body->bonds, body->head.points, count_lost, &call);
  return call.lost;
}

/* The two slots of a loose pair come to the same answer. */
static void lose(void *context, const sdr_pair *pair)
{
  break_call *call = context;
  sdr_flags *flags = flags_of(call->body, pair);
  sdr_flags fresh = 0;
  const double i = excess(call, pair, *flags, SDR_LOST_I);
  const double j = excess(call, pair, *flags, SDR_LOST_J);
  if (i > 0.0 && i >= call->least) fresh |= SDR_LOST_I;
  if (j > 0.0 && j >= call->least) fresh |= SDR_LOST_J;
  if (!fresh) return;
  *flags |= fresh | fresh << 2;
  call->fresh = 1;
}

/* Lose the halves above `least`; how many are lost after the books, which give some back. */
static int64_t lose_all(break_call *call, double least)
{
  sdr_state_body *body = call->body;
  const sdr_bonds *bonds = body->bonds;
  const int32_t count = body->head.points->count;
  const int64_t before = lost_halves(body);
  call->least = least;
  for (int64_t r = 0; r < bonds->run_count; ++r) {
    call->fresh = 0;
    sdr_bonds_visit_run(bonds, &bonds->runs[r], lose, call);
    if (call->fresh) body->run_fresh[r] = body->run_flagged[r] = 1;
  }
  for (int32_t i = 0; bonds->loose.chunk_count > 0 && i < count; ++i) {
    call->fresh = 0;
    sdr_bonds_visit_loose_point(bonds, i, lose, call);
    if (call->fresh) body->chunk_fresh[bonds->loose.lane[i] / SDR_LANES] = 1;
  }
  sdr_state_book(body, call->u, NULL, 0.0);
  return lost_halves(body) - before;
}

double sdr_state_square_stretch(const sdr_state_body *body, const sdr_pair *pair, int from_i,
                                double *const u[3])
{
  (void)from_i;
  const double s = sdr_pair_stretch(pair, body->head.points->components, u);
  return s > 0.0 ? s * s : 0.0;
}

int64_t sdr_state_break_most(sdr_model *model, double *const u[3], double share)
{
  sdr_state_body *body = (sdr_state_body *)model;
  break_call call = {.body = body, .u = u};
  if (body->law != SDR_LAW_CRITICAL_STRETCH) return 0;
  if (body->hooks->look) body->hooks->look(body, u);
  sdr_bonds_visit(body->bonds, model->points, find_most, &call);
  if (call.most <= 0.0) return 0;
  const int64_t lost = lose_all(&call, share * share * call.most);
  return lost > 0 ? lost : lose_all(&call, 0.0); /* where the first ones would gain energy */
}
