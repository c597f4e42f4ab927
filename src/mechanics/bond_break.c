/* Critical stretch under static loads, where nothing says which of several overstretched bonds goes
   first: the most overstretched do, and the body finds its balance again (theory sec. 7). */
#include "mechanics/bond_internal.h"

#include <math.h>

typedef struct {
  sdr_bond_model *model;
  double *const *u;
  double least; /* (s/s0)^2 from which bonds go */
  double most;  /* largest (s/s0)^2 found */
  int64_t lost;
  int stripe;
} break_call;

/* (s/s0)^2 of a directed bond that overstretching would lose, else 0. */
static double excess(sdr_flags flags, int lost, double weight, double s, double q)
{
  if (flags & (lost | SDR_PROTECTED) || weight <= 0.0) return 0.0;
  return sdr_critical_breaks(s, q) ? s * s / q : 0.0;
}

static void find_most(void *context, const sdr_pair *pair)
{
  break_call *call = context;
  const sdr_bond_body *body = &call->model->body;
  const sdr_flags flags = (pair->loose ? body->loose_flags : body->flags)[pair->slot];
  const double s = sdr_pair_stretch(pair, body->points->components, call->u);
  call->most = fmax(
      call->most, excess(flags, SDR_LOST_I, pair->weight_ij, s, sdr_body_threshold(body, pair->i)));
  call->most = fmax(
      call->most, excess(flags, SDR_LOST_J, pair->weight_ji, s, sdr_body_threshold(body, pair->j)));
}

/* A pair's two slots of loose storage come to the same answer; each books the half of its lane. */
static void lose(void *context, const sdr_pair *pair)
{
  break_call *call = context;
  const sdr_bond_body *body = &call->model->body;
  sdr_flags *flags = (pair->loose ? body->loose_flags : body->flags) + pair->slot;
  const double s = sdr_pair_stretch(pair, body->points->components, call->u);
  const double i =
      excess(*flags, SDR_LOST_I, pair->weight_ij, s, sdr_body_threshold(body, pair->i));
  const double j =
      excess(*flags, SDR_LOST_J, pair->weight_ji, s, sdr_body_threshold(body, pair->j));
  const double half = 0.5 * pair->length * s * s;
  double *booked = &call->model->booked[call->stripe];
  if (i > 0.0 && i >= call->least) {
    *flags = (*flags | SDR_LOST_I);
    *booked += half * pair->weight_ij * sdr_body_stiffness(body, pair->i);
    ++call->lost;
  }
  if (j > 0.0 && j >= call->least) {
    *flags = (*flags | SDR_LOST_J);
    if (pair->loose) return;
    *booked += half * pair->weight_ji * sdr_body_stiffness(body, pair->j);
    ++call->lost;
  }
}

int64_t sdr_bond_break_most(sdr_model *model, double *const u[3], double share)
{
  break_call call = {.model = (sdr_bond_model *)model, .u = u};
  if (call.model->body.law != SDR_LAW_CRITICAL_STRETCH) return 0;
  sdr_bonds_visit(call.model->bonds, model->points, find_most, &call);
  if (call.most <= 0.0) return 0;
  call.least = share * share * call.most;
  for (call.stripe = 0; call.stripe < model->points->stripe_count; ++call.stripe)
    sdr_bonds_visit_stripe(call.model->bonds, model->points, call.stripe, lose, &call);
  sdr_bond_note_flags(&call.model->body, 0, call.model->bonds->run_count);
  return call.lost;
}
