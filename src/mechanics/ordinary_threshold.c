/* The critical stretch of ordinary bodies, from what their families really lose. Bonds that a plane
   cut opens break one after the other, and each leaves the dilatation of its family. So a full
   family is split here in many directions, and s0 is such that the cheapest and the dearest lie
   equally far from Gc. */
#include "mechanics/ordinary.h"
#include "mechanics/state_split.h"

#include <math.h>
#include <stdlib.h>

/* A bond that the cut opens: distance along the normal, stretch over opening, P and Q. */
typedef struct {
  double reach, rate, p, q;
} crossing;

/* A family with all its bonds: t, and A and B over G; and K/G. */
typedef struct {
  const sdr_ordinary *o;
  double ratio;
} split_call;

static int by_rate(const void *a, const void *b)
{
  const crossing *left = a, *right = b;
  return (left->rate < right->rate) - (left->rate > right->rate);
}

static int by_size(const void *a, const void *b)
{
  const double left = *(const double *)a, right = *(const double *)b;
  return (left > right) - (left < right);
}

static sdr_ordinary_constants constants_of(const sdr_full_family *f, int printed, double moment)
{
  const double pi = 3.14159265358979323846, delta = f->horizon, n = f->components;
  if (!printed)
    return (sdr_ordinary_constants){n / moment, 0.5 * (n + 2.0) / n, 0.5 * n * (n + 2.0) / moment};
  const double d = 2.0 / (pi * f->thickness * delta * delta * delta);
  return (sdr_ordinary_constants){d * delta, 1.0, 3.0 * d};
}

/* What is left of a family: sums over bonds across (S and Q per opening), and P^2/Q lost. */
typedef struct {
  double sum, square, lost;
} remains;

/* Energy density over G and opening squared. */
static double density_of(const sdr_ordinary_constants *whole, double ratio, const remains *left)
{
  const double theta = whole->t * left->sum;
  const double a = sdr_ordinary_torn(whole, ratio, left->lost);
  return (0.5 * ratio - a) * theta * theta + whole->b * left->square;
}

/* What a point at the distance h from the plane loses, over s0^2 G; bonds sorted by rate. */
static double loss_at(const crossing *bond, int count, double h,
                      const sdr_ordinary_constants *whole, double ratio)
{
  remains left = {0.0, 0.0, 0.0};
  double loss = 0.0;
  for (int k = 0; k < count; ++k) {
    if (!(bond[k].reach > h)) continue;
    left.sum += bond[k].p * bond[k].rate;
    left.square += bond[k].q * bond[k].rate * bond[k].rate;
  }
  double before = density_of(whole, ratio, &left);
  for (int k = 0; k < count; ++k) {
    if (!(bond[k].reach > h)) continue;
    left.sum -= bond[k].p * bond[k].rate;
    left.square -= bond[k].q * bond[k].rate * bond[k].rate;
    left.lost += bond[k].p * bond[k].p / bond[k].q;
    const double after = density_of(whole, ratio, &left);
    loss += (before - after) / (bond[k].rate * bond[k].rate); /* opening squared, over s0^2 */
    before = after;
  }
  return loss;
}

/* Energy per area over s0^2 G and horizon. */
static double cost_of(const void *context, const sdr_full_family *f, const double normal[3])
{
  const split_call *call = context;
  crossing *bond = (crossing *)f->space;
  double *reach = f->space + 4 * (size_t)f->count, moment = 0.0, from = 0.0, sum = 0.0;
  int count = 0;
  for (int k = 0; k < f->count; ++k) {
    const double *xi = f->xi + 3 * (size_t)k;
    const double along = xi[0] * normal[0] + xi[1] * normal[1] + xi[2] * normal[2];
    const double square = xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2];
    const sdr_pair pair = {.length = sqrt(square)};
    const double p = sdr_ordinary_p(call->o, &pair, f->weight[k]);
    moment += p;
    if (!(along > 1e-9 * f->horizon)) continue;
    reach[count] = along;
    bond[count++] =
        (crossing){along, along / square, p, sdr_ordinary_q(call->o, &pair, f->weight[k])};
  }
  qsort(bond, (size_t)count, sizeof *bond, by_rate);
  qsort(reach, (size_t)count, sizeof *reach, by_size);
  const sdr_ordinary_constants whole =
      constants_of(f, call->o->form == SDR_FORM_MADENCI_OTERKUS, moment);
  for (int k = 0; k < count; ++k) { /* nothing changes between two reaches */
    if (!(reach[k] > from)) continue;
    const double loss = loss_at(bond, count, 0.5 * (from + reach[k]), &whole, call->ratio);
    sum += 2.0 * loss * (reach[k] - from) / f->horizon;
    from = reach[k];
  }
  return sum;
}

sdr_status sdr_ordinary_set_threshold(sdr_ordinary *o, const double *toughness)
{
  const sdr_points *points = o->body.head.points;
  const double *bulk = o->body.bulk, *shear = o->body.shear;
  double cost[UINT8_MAX + 1] = {0.0}; /* of each material; its points share K/G */
  for (int32_t i = 0; i < points->count; ++i) {
    double *of = &cost[points->material[i]];
    const split_call call = {o, bulk[i] / shear[i]};
    if (!(*of > 0.0))
      SDR_TRY(sdr_split_middle(points, o->body.bonds, SDR_CUT_DIRECTIONS, cost_of, &call, of));
    o->body.threshold[i] = toughness[points->material[i]] / (*of * shear[i] * points->horizon[i]);
  }
  return SDR_OK;
}
