/* What ordinary bodies lose with a bond: energy of its owner, whose dilatation the bond leaves. The
   energy is quadratic in the stretches of the family, so leapfrog loses
   the difference of two products of the stretches before and after the step (theory sec. 4). */
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/ordinary.h"

/* Sums over the bonds that a point keeps, and over those that it loses now: P s before the step,
   P s after it, Q times both, P^2/Q. */
enum { BEFORE, AFTER, PRODUCT, RESERVE, SUMS, LOSING = SUMS };

typedef struct {
  sdr_ordinary *o;
  double *const *u, *const *v;
  double dt;
} book_call;

/* Stretch before the step: at u - dt v. */
static double stretch_before(const sdr_pair *pair, int components, const book_call *call)
{
  double before[3][2], *u[3] = {NULL};
  sdr_pair local = *pair;
  if (!call->v) return sdr_pair_stretch(pair, components, call->u);
  local.i = 0;
  local.j = 1;
  for (int a = 0; a < components; ++a) {
    before[a][0] = call->u[a][pair->i] - call->dt * call->v[a][pair->i];
    before[a][1] = call->u[a][pair->j] - call->dt * call->v[a][pair->j];
    u[a] = before[a];
  }
  return sdr_pair_stretch(&local, components, u);
}

/* Add the half with weight `weight` that `point` owns. */
static void add_half(const book_call *call, const sdr_pair *pair, int32_t point, double weight,
                     const double s[2], int fresh)
{
  const sdr_ordinary *o = call->o;
  double *const *book = o->book + (fresh ? LOSING : 0);
  const double p = sdr_ordinary_p(o, pair, weight);
  if (!o->body.fresh[point]) return;
  book[BEFORE][point] += p * s[0];
  book[AFTER][point] += p * s[1];
  book[PRODUCT][point] += sdr_ordinary_q(o, pair, weight) * s[0] * s[1];
  book[RESERVE][point] += sdr_ordinary_r(o, pair, weight);
}

static void add_pair(void *context, const sdr_pair *pair)
{
  const book_call *call = context;
  const sdr_state_body *body = &call->o->body;
  const int n = body->head.points->components;
  const sdr_flags flags = (pair->loose ? body->loose_flags : body->flags)[pair->slot];
  const double s[2] = {stretch_before(pair, n, call), sdr_pair_stretch(pair, n, call->u)};
  const int fresh_i = (flags & SDR_FRESH_I) != 0, fresh_j = (flags & SDR_FRESH_J) != 0;
  if (fresh_i || !(flags & SDR_LOST_I)) add_half(call, pair, pair->i, pair->weight_ij, s, fresh_i);
  if ((fresh_j || !(flags & SDR_LOST_J)) && !pair->loose)
    add_half(call, pair, pair->j, pair->weight_ji, s, fresh_j);
}

/* Twice the energy density, as a product of two states of stretch. */
static double product(const sdr_ordinary *o, int32_t i, const double sum[SUMS])
{
  sdr_ordinary_constants of = {o->t[i], o->a[i], o->b[i]};
  of.a = sdr_ordinary_torn(&of, o->body.bulk[i], o->whole[i] - sum[RESERVE]);
  const double theta = of.t * of.t * sum[BEFORE] * sum[AFTER];
  return (o->body.bulk[i] - 2.0 * of.a) * theta + 2.0 * of.b * sum[PRODUCT];
}

static void add_stripe(void *context, int s)
{
  const book_call *call = context;
  sdr_state_visit_fresh(&call->o->body, s, add_pair, context);
}

static void clear_stripe(void *context, int s)
{
  const book_call *call = context;
  const sdr_ordinary *o = call->o;
  const int32_t *stripe = o->body.head.points->stripe_first;
  for (int32_t i = stripe[s]; i < stripe[s + 1]; ++i)
    for (int k = 0; o->body.fresh[i] && k < SDR_ORDINARY_BOOKS; ++k) o->book[k][i] = 0.0;
}

static void book_stripe(void *context, int s)
{
  const book_call *call = context;
  const sdr_ordinary *o = call->o;
  const sdr_points *points = o->body.head.points;
  for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i) {
    double with[SUMS], without[SUMS];
    if (!o->body.fresh[i]) continue;
    for (int k = 0; k < SUMS; ++k) {
      without[k] = o->book[k][i];
      with[k] = without[k] + o->book[LOSING + k][i];
    }
    o->body.release[i] = 0.5 * points->volume[i] * (product(o, i, with) - product(o, i, without));
  }
}

/* The sums that forces are made from, with what their points keep after all. */
void sdr_ordinary_remake_fresh(sdr_state_body *body)
{
  sdr_ordinary *o = (sdr_ordinary *)body;
  for (int32_t i = 0; i < body->head.points->count; ++i) {
    if (!body->fresh[i]) continue;
    o->sum[i] += o->book[LOSING + AFTER][i];
    o->lost[i] -= o->book[LOSING + RESERVE][i];
  }
}

void sdr_ordinary_book(sdr_state_body *body, double *const u[3], double *const v[3], double dt)
{
  book_call call = {(sdr_ordinary *)body, u, v, dt};
  const sdr_points *points = body->head.points;
  sdr_parallel_for(0, points->stripe_count, 1, clear_stripe, &call);
  sdr_each_stripe(points, add_stripe, &call);
  sdr_parallel_for(0, points->stripe_count, 1, book_stripe, &call);
}
