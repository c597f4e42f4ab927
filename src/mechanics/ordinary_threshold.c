/* The critical stretch of ordinary bodies, from what their families really lose. Bonds that a plane
   cut opens break one after the other, and each leaves the dilatation of its family. So a full
   family is split here in many directions, and s0 is such that the cheapest and the dearest lie
   equally far from Gc. */
#include "base/memory.h"
#include "mechanics/ordinary.h"
#include "mechanics/state_cut.h"
#include "nom/stencil.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The bonds of a full family: xi (m), P and Q over the volume of their owner. */
typedef struct {
  int count;
  double *xi, *p, *q; /* xi: 3 a bond */
  double horizon, thickness;
} full_family;

/* A bond that the cut opens: distance along the normal, and stretch over opening. */
typedef struct {
  double reach, rate, p, q;
} crossing;

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

/* t, and A and B over G, of the whole family. */
static sdr_ordinary_constants constants_of(const full_family *f, int n, int printed, double moment)
{
  const double pi = 3.14159265358979323846, delta = f->horizon;
  if (!printed)
    return (sdr_ordinary_constants){n / moment, 0.5 * (n + 2.0) / n, 0.5 * n * (n + 2.0) / moment};
  const double d = 2.0 / (pi * f->thickness * delta * delta * delta);
  return (sdr_ordinary_constants){d * delta, 1.0, 3.0 * d};
}

/* What is left of a family: sums over bonds across (S and Q per opening), and P^2/Q lost. */
typedef struct {
  double sum, square, lost;
} remains;

/* Energy density over G and opening squared; ratio: K/G. */
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

/* Energy per area over s0^2 G and horizon that a cut with the normal `normal` takes, from both its
   sides. `bond` and `reach` are scratch. */
static double cut(const full_family *f, int n, int printed, double ratio, const double normal[3],
                  crossing *bond, double *reach)
{
  double moment = 0.0, from = 0.0, sum = 0.0;
  int count = 0;
  for (int k = 0; k < f->count; ++k) {
    const double *xi = f->xi + 3 * (size_t)k;
    const double along = xi[0] * normal[0] + xi[1] * normal[1] + xi[2] * normal[2];
    const double square = xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2];
    moment += f->p[k];
    if (!(along > 1e-9 * f->horizon)) continue;
    reach[count] = along;
    bond[count++] = (crossing){along, along / square, f->p[k], f->q[k]};
  }
  qsort(bond, (size_t)count, sizeof *bond, by_rate);
  qsort(reach, (size_t)count, sizeof *reach, by_size);
  const sdr_ordinary_constants whole = constants_of(f, n, printed, moment);
  for (int k = 0; k < count; ++k) { /* nothing changes between two reaches */
    if (!(reach[k] > from)) continue;
    const double loss = loss_at(bond, count, 0.5 * (from + reach[k]), &whole, ratio);
    sum += 2.0 * loss * (reach[k] - from) / f->horizon;
    from = reach[k];
  }
  return sum;
}

/* ---- directions ------------------------------------------------------------------------------ */

/* What cuts in all directions cost, as `cut` has it. */
typedef struct {
  int count, printed;
  double ratio; /* K/G */
  double normal[SDR_CUT_DIRECTIONS][3];
  double cost[SDR_CUT_DIRECTIONS];
} cuts;

/* Add the costs of a family. */
static sdr_status add_cuts(const full_family *f, int n, cuts *all)
{
  crossing *bond = sdr_alloc((size_t)f->count, sizeof *bond);
  double *reach = sdr_alloc((size_t)f->count, sizeof *reach);
  const int failed = !bond || !reach;
  for (int k = 0; k < all->count && !failed; ++k)
    all->cost[k] += cut(f, n, all->printed, all->ratio, all->normal[k], bond, reach);
  sdr_free(bond);
  sdr_free(reach);
  return failed ? SDR_RUN_FAILED : SDR_OK;
}

/* The middle between the cheapest and the dearest direction. */
static double middle_cost(const cuts *all)
{
  double least = INFINITY, most = 0.0;
  for (int k = 0; k < all->count; ++k) {
    least = fmin(least, all->cost[k]);
    most = fmax(most, all->cost[k]);
  }
  return 0.5 * (least + most);
}

/* ---- full families --------------------------------------------------------------------------- */

static sdr_status family_alloc(full_family *f, size_t most)
{
  f->xi = sdr_alloc(3 * most, sizeof *f->xi);
  f->p = sdr_alloc(most, sizeof *f->p);
  f->q = sdr_alloc(most, sizeof *f->q);
  return f->xi && f->p && f->q ? SDR_OK : SDR_RUN_FAILED;
}

static void family_free(full_family *f)
{
  sdr_free(f->xi);
  sdr_free(f->p);
  sdr_free(f->q);
}

/* A bond with `weight` = omega V_j. */
static void add_bond(const sdr_ordinary *o, full_family *f, const double xi[3], double sign,
                     double weight)
{
  sdr_pair pair = {.length = sqrt(xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2])};
  if (!(weight > 0.0)) return;
  for (int a = 0; a < 3; ++a) f->xi[3 * (size_t)f->count + (size_t)a] = sign * xi[a];
  f->p[f->count] = sdr_ordinary_p(o, &pair, weight);
  f->q[f->count++] = sdr_ordinary_q(o, &pair, weight);
}

static void start_family(const sdr_ordinary *o, int32_t i, full_family *f)
{
  const sdr_points *points = o->body.head.points;
  f->count = 0;
  f->horizon = points->horizon[i];
  f->thickness = points->volume[i] / pow(points->spacing[i], points->components);
}

/* On a lattice the classes are half of it. */
static sdr_status family_of_classes(const sdr_ordinary *o, full_family *f)
{
  const sdr_bonds *bonds = o->body.bonds;
  SDR_TRY(family_alloc(f, 2 * (size_t)bonds->class_count));
  start_family(o, 0, f);
  const double volume = o->body.head.points->volume[0];
  for (int c = 0; c < bonds->class_count; ++c) {
    add_bond(o, f, bonds->classes[c].xi, 1.0, bonds->classes[c].weight_ij / volume);
    add_bond(o, f, bonds->classes[c].xi, -1.0, bonds->classes[c].weight_ji / volume);
  }
  return SDR_OK;
}

/* The stencil of point i with influence 1: where no family is complete. */
static sdr_status family_of_stencil(const sdr_ordinary *o, int32_t i, full_family *f)
{
  const sdr_points *points = o->body.head.points;
  const double spacing = points->spacing[i];
  sdr_stencil stencil;
  SDR_TRY(sdr_stencil_create(points->components, spacing, points->horizon[i], &stencil));
  sdr_status status = family_alloc(f, (size_t)stencil.count);
  start_family(o, i, f);
  for (int k = 0; k < stencil.count && status == SDR_OK; ++k) {
    const int32_t *step = stencil.step + 3 * (size_t)k;
    const double xi[3] = {spacing * step[0], spacing * step[1], spacing * step[2]};
    add_bond(o, f, xi, 1.0, points->volume[i]);
  }
  sdr_stencil_destroy(&stencil);
  return status;
}

typedef struct {
  const sdr_ordinary *o;
  full_family *family;
} gather_call;

static void gather_slot(void *context, const sdr_pair *pair)
{
  const gather_call *call = context;
  add_bond(call->o, call->family, pair->xi, 1.0,
           pair->weight_ij / call->o->body.head.points->volume[pair->i]);
}

/* Mean over complete families, a few of them, evenly from all points; else a stencil's. */
static sdr_status cuts_of_loose(const sdr_ordinary *o, int n, cuts *all)
{
  const sdr_bonds *bonds = o->body.bonds;
  const sdr_points *points = o->body.head.points;
  full_family f = {0};
  gather_call call = {o, &f};
  int64_t most = 0;
  int met = 0, seen = 0;
  for (int32_t c = 0; c < bonds->loose.chunk_count; ++c) {
    const int64_t width = (bonds->loose.chunk_slot[c + 1] - bonds->loose.chunk_slot[c]) / SDR_LANES;
    if (width > most) most = width;
  }
  sdr_status status = family_alloc(&f, (size_t)most);
  for (int k = 0; k < SDR_CUT_TRIED && k < points->count && seen < SDR_CUT_ENOUGH; ++k) {
    const int32_t i = sdr_cut_sample(points, k);
    if (status != SDR_OK || !sdr_cut_complete(points, bonds, i)) continue;
    start_family(o, i, &f);
    sdr_bonds_visit_loose_point(bonds, i, gather_slot, &call);
    status = add_cuts(&f, n, all);
    seen += f.count;
    ++met;
  }
  family_free(&f);
  for (int k = 0; k < all->count && met > 0; ++k) all->cost[k] /= met;
  if (status != SDR_OK || met > 0) return status;
  f = (full_family){0};
  status = family_of_stencil(o, points->count / 2, &f);
  if (status == SDR_OK) status = add_cuts(&f, n, all);
  family_free(&f);
  return status;
}

static sdr_status cuts_of_runs(const sdr_ordinary *o, int n, cuts *all)
{
  full_family f = {0};
  sdr_status status = family_of_classes(o, &f);
  if (status == SDR_OK) status = add_cuts(&f, n, all);
  family_free(&f);
  return status;
}

/* What a cut costs over s0^2 G and horizon, for one K/G. */
static sdr_status cost_of(const sdr_ordinary *o, double ratio, cuts *all, double *out)
{
  const int n = o->body.head.points->components;
  all->ratio = ratio;
  memset(all->cost, 0, sizeof all->cost);
  SDR_TRY(o->body.bonds->class_count > 0 ? cuts_of_runs(o, n, all) : cuts_of_loose(o, n, all));
  *out = middle_cost(all);
  return SDR_OK;
}

sdr_status sdr_ordinary_set_threshold(sdr_ordinary *o, const double *toughness)
{
  const sdr_points *points = o->body.head.points;
  const double *bulk = o->body.bulk, *shear = o->body.shear;
  double cost[UINT8_MAX + 1] = {0.0}; /* of each material; its points share K/G */
  sdr_status status = SDR_OK;
  cuts *all = sdr_alloc(1, sizeof *all);
  if (!all) return SDR_RUN_FAILED;
  all->printed = o->form == SDR_FORM_MADENCI_OTERKUS;
  all->count = sdr_cut_directions(points, all->normal);
  for (int32_t i = 0; i < points->count && status == SDR_OK; ++i) {
    double *of = &cost[points->material[i]];
    if (!(*of > 0.0)) status = cost_of(o, bulk[i] / shear[i], all, of);
    o->body.threshold[i] = toughness[points->material[i]] / (*of * shear[i] * points->horizon[i]);
  }
  sdr_free(all);
  return status;
}
