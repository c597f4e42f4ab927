/* Fields of bond-based bodies over their points. */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"

#include <math.h>
#include <string.h>

/* A sum over the bonds of each point: pairs of runs add to both their points, loose slots to the
   lane's own. */
typedef struct {
  sdr_bond_model *model;
  double *const *u;
  double *sum[9]; /* accumulators over points */
  void (*add)(const void *context, const sdr_pair *pair, int32_t point, double sign);
} field_call;

static void visit(void *context, const sdr_pair *pair)
{
  const field_call *call = context;
  call->add(call, pair, pair->i, 1.0);
  if (!pair->loose) call->add(call, pair, pair->j, -1.0);
}

static void field_of_stripe(void *context, int s)
{
  const field_call *call = context;
  sdr_bonds_visit_stripe(call->model->bonds, call->model->head.points, s, visit, context);
}

/* Weight and damage of the directed bond that `point` (i if sign > 0, else j) owns. */
static double own_weight(const sdr_pair *pair, double sign)
{
  return sign > 0.0 ? pair->weight_ij : pair->weight_ji;
}

static double stretch(const field_call *call, const sdr_pair *pair)
{
  return sdr_pair_stretch(pair, call->model->head.points->components, call->u);
}

static void add_loose_volume(void *context, const sdr_pair *pair)
{
  const field_call *call = context;
  if (pair->weight_ij > 0.0) call->sum[0][pair->i] += call->model->head.points->volume[pair->j];
}

static void family_volume_of_stripe(void *context, int s)
{
  const field_call *call = context;
  const sdr_bonds *bonds = call->model->bonds;
  const sdr_points *points = call->model->head.points;
  double *sum = call->sum[0];
  for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r) {
    const sdr_bond_run *run = &bonds->runs[r];
    const int32_t i = run->i0, j = run->j0;
    if (bonds->classes[run->class_index].weight_ij > 0.0)
      for (int32_t k = 0; k < run->length; ++k) sum[i + k] += points->volume[j + k];
    if (bonds->classes[run->class_index].weight_ji > 0.0)
      for (int32_t k = 0; k < run->length; ++k) sum[j + k] += points->volume[i + k];
  }
  if (bonds->loose.chunk_count > 0)
    for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i)
      sdr_bonds_visit_loose_point(bonds, i, add_loose_volume, context);
}

sdr_status sdr_bond_find_family_volume(sdr_bond_model *model)
{
  const sdr_points *points = model->head.points;
  if (model->family_volume) return SDR_OK;
  model->family_volume = sdr_alloc(sdr_points_padded(points), sizeof *model->family_volume);
  if (!model->family_volume) return SDR_RUN_FAILED;
  field_call call = {.model = model, .sum = {model->family_volume}};
  sdr_each_stripe(points, family_volume_of_stripe, &call);
  return SDR_OK;
}

static void add_loose_damage(void *context, const sdr_pair *pair)
{
  const field_call *call = context;
  if (pair->weight_ij <= 0.0) return;
  const sdr_pair_answer answer = sdr_pair_answer_at(&call->model->body, pair, stretch(call, pair));
  call->sum[0][pair->i] += call->model->head.points->volume[pair->j] * answer.ij.damage;
}

/* All slots of point i, of laws whose histories are flags. */
static void add_flagged_damage(const field_call *call, int32_t i)
{
  const sdr_bond_body *body = &call->model->body;
  const sdr_loose *loose = &body->bonds->loose;
  int64_t slot;
  if (!body->loose_flags) return;
  for (const int64_t end = sdr_loose_slots(loose, i, &slot); slot < end; slot += SDR_LANES)
    if (body->loose_flags[slot] & SDR_LOST_I && loose->weight_ij[slot] > 0.0)
      call->sum[0][i] += body->points->volume[loose->j[slot]];
}

/* Pairs of runs, which explicit bodies have a kernel for. */
static void add_damage(void *context, const sdr_pair *pair)
{
  const field_call *call = context;
  const double *volume = call->model->head.points->volume;
  const sdr_pair_answer answer = sdr_pair_answer_at(&call->model->body, pair, stretch(call, pair));
  if (pair->weight_ij > 0.0) call->sum[0][pair->i] += volume[pair->j] * answer.ij.damage;
  if (pair->weight_ji > 0.0) call->sum[0][pair->j] += volume[pair->i] * answer.ji.damage;
}

static void damage_of_stripe(void *context, int s)
{
  const field_call *call = context;
  const sdr_bond_model *model = call->model;
  const sdr_points *points = model->head.points;
  const sdr_bonds *bonds = model->bonds;
  const int each = model->body.stiffness_at != NULL;
  if (!model->body.precise)
    model->kernels->run_damage[model->body.law][points->components - 1][each](
        &model->body, bonds->stripe_run[s], bonds->stripe_run[s + 1], call->u, call->sum[0]);
  else
    for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r)
      sdr_bonds_visit_run(bonds, &bonds->runs[r], add_damage, context);
  if (bonds->loose.chunk_count == 0) return;
  const int flagged = !sdr_law_softens((int)model->body.law);
  for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i) {
    if (flagged)
      add_flagged_damage(call, i);
    else
      sdr_bonds_visit_loose_point(bonds, i, add_loose_damage, context);
  }
}

/* Stored and dissipated energy of a pair, J. */
static void energies_of_pair(const field_call *call, const sdr_pair *pair, double *stored,
                             double *dissipated)
{
  const sdr_bond_body *body = &call->model->body;
  const sdr_pair_answer answer = sdr_pair_answer_at(body, pair, stretch(call, pair));
  const double hi = pair->weight_ij * pair->length * sdr_body_stiffness(body, pair->i);
  const double hj = pair->weight_ji * pair->length * sdr_body_stiffness(body, pair->j);
  *stored = *dissipated = 0.0;
  if (answer.cut) return;
  *stored = hi * answer.ij.stored + hj * answer.ji.stored;
  *dissipated = hi * answer.ij.dissipated + hj * answer.ji.dissipated;
  /* What a lost bond took is known by threshold only to the step: s0^2 is the energy it held. */
  if (body->law == SDR_LAW_CRITICAL_STRETCH)
    *dissipated = 0.5 * (hi * sdr_body_threshold(body, pair->i) * answer.ij.damage +
                         hj * sdr_body_threshold(body, pair->j) * answer.ji.damage);
}

static void add_energy(const void *context, const sdr_pair *pair, int32_t point, double sign)
{
  const field_call *call = context;
  double stored, dissipated;
  (void)sign;
  energies_of_pair(call, pair, &stored, &dissipated);
  call->sum[0][point] += 0.5 * stored;
  call->sum[1][point] += 0.5 * dissipated;
}

/* sum of f (x) xi over the pairs, symmetric part, in the order of sdr_model_field. */
static void add_stress(const void *context, const sdr_pair *pair, int32_t point, double sign)
{
  const field_call *call = context;
  const sdr_bond_body *body = &call->model->body;
  const int n = body->points->components;
  const double s = stretch(call, pair);
  const sdr_pair_answer answer = sdr_pair_answer_at(body, pair, s);
  const double force = pair->weight_ij * sdr_body_stiffness(body, pair->i) * answer.ij.force +
                       pair->weight_ji * sdr_body_stiffness(body, pair->j) * answer.ji.force;
  const double l = pair->length * (1.0 + s);
  const double factor = l > 0.0 ? force / l : 0.0; /* l = 0 has no direction */
  double f[3] = {0.0};
  (void)sign; /* f and xi both turn with the point */
  for (int a = 0; a < n; ++a)
    f[a] = factor * (pair->xi[a] + call->u[a][pair->j] - call->u[a][pair->i]);
  static const int order[3][6][2] = {
      {{0, 0}}, {{0, 0}, {1, 1}, {0, 1}}, {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};
  const int count = n * (n + 1) / 2;
  for (int k = 0; k < count; ++k) {
    const int a = order[n - 1][k][0], b = order[n - 1][k][1];
    call->sum[k][point] += 0.5 * (f[a] * pair->xi[b] + f[b] * pair->xi[a]);
  }
}

/* Shape tensor and sum of eta (x) xi over H_i, weight 1: 3 x 3 each, but one at a time. */
static void add_shape(const void *context, const sdr_pair *pair, int32_t point, double sign)
{
  const field_call *call = context;
  const sdr_points *points = call->model->head.points;
  if (own_weight(pair, sign) <= 0.0) return;
  const double volume = points->volume[sign > 0.0 ? pair->j : pair->i];
  for (int a = 0; a < points->components; ++a)
    for (int b = 0; b < points->components; ++b)
      call->sum[a * points->components + b][point] += volume * pair->xi[a] * pair->xi[b];
}

static void add_gradient(const void *context, const sdr_pair *pair, int32_t point, double sign)
{
  const field_call *call = context;
  const sdr_points *points = call->model->head.points;
  if (own_weight(pair, sign) <= 0.0) return;
  const double volume = points->volume[sign > 0.0 ? pair->j : pair->i];
  for (int a = 0; a < points->components; ++a) {
    const double eta = call->u[a][pair->j] - call->u[a][pair->i];
    for (int b = 0; b < points->components; ++b)
      call->sum[a * points->components + b][point] += volume * eta * pair->xi[b];
  }
}

/* Run `add` over all bonds into `count` zeroed accumulators in `store`. */
static void accumulate(sdr_bond_model *model, double *const u[3], int count, double *store,
                       void (*add)(const void *, const sdr_pair *, int32_t, double))
{
  const size_t padded = sdr_points_padded(model->head.points);
  field_call call = {.model = model, .u = u, .add = add};
  memset(store, 0, (size_t)count * padded * sizeof *store);
  for (int k = 0; k < count; ++k) call.sum[k] = store + (size_t)k * padded;
  sdr_each_stripe(model->head.points, field_of_stripe, &call);
}

/* Inverse of a symmetric matrix by cofactors; 0 if singular. */
static int invert(int n, const double k[9], double inverse[9])
{
  if (n == 1) {
    if (k[0] <= 0.0) return 0;
    inverse[0] = 1.0 / k[0];
    return 1;
  }
  if (n == 2) {
    const double det = k[0] * k[3] - k[1] * k[2];
    if (!(fabs(det) > 1e-12 * (k[0] + k[3]) * (k[0] + k[3]))) return 0;
    inverse[0] = k[3] / det;
    inverse[1] = inverse[2] = -k[1] / det;
    inverse[3] = k[0] / det;
    return 1;
  }
  double det = 0.0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const int a1 = (a + 1) % 3, a2 = (a + 2) % 3, b1 = (b + 1) % 3, b2 = (b + 2) % 3;
      inverse[3 * b + a] = k[3 * a1 + b1] * k[3 * a2 + b2] - k[3 * a1 + b2] * k[3 * a2 + b1];
    }
  for (int b = 0; b < 3; ++b) det += k[b] * inverse[3 * b];
  const double trace = k[0] + k[4] + k[8];
  if (!(fabs(det) > 1e-12 * trace * trace * trace)) return 0;
  for (int c = 0; c < 9; ++c) inverse[c] /= det;
  return 1;
}

/* Displacement gradient of point i from its sums; zero where the family determines none. */
static void gradient_of(int n, const double *shape, const double *moment, size_t padded, int32_t i,
                        double gradient[9])
{
  double k[9], inverse[9];
  for (int c = 0; c < n * n; ++c) k[c] = shape[(size_t)c * padded + (size_t)i];
  memset(gradient, 0, 9 * sizeof *gradient);
  if (!invert(n, k, inverse)) return;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b)
      for (int c = 0; c < n; ++c)
        gradient[a * n + b] +=
            moment[(size_t)(a * n + c) * padded + (size_t)i] * inverse[c * n + b];
}

static sdr_status strain(sdr_bond_model *model, double *const u[3], int dilatation, double *out)
{
  const sdr_points *points = model->head.points;
  const int n = points->components;
  const size_t padded = sdr_points_padded(points), count = (size_t)points->count;
  double *shape = sdr_alloc((size_t)(n * n) * padded, sizeof *shape);
  double *moment = sdr_alloc((size_t)(n * n) * padded, sizeof *moment);
  const int failed = !shape || !moment;
  if (!failed) {
    accumulate(model, u, n * n, shape, add_shape);
    accumulate(model, u, n * n, moment, add_gradient);
    static const int order[3][6][2] = {
        {{0, 0}}, {{0, 0}, {1, 1}, {0, 1}}, {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};
    for (int32_t i = 0; i < points->count; ++i) {
      double g[9];
      gradient_of(n, shape, moment, padded, i, g);
      if (dilatation) out[i] = g[0] + (n > 1 ? g[n + 1] : 0.0) + (n > 2 ? g[8] : 0.0);
      for (int k = 0; !dilatation && k < n * (n + 1) / 2; ++k) {
        const int a = order[n - 1][k][0], b = order[n - 1][k][1];
        out[(size_t)k * count + (size_t)i] = 0.5 * (g[a * n + b] + g[b * n + a]);
      }
    }
  }
  sdr_free(shape);
  sdr_free(moment);
  return failed ? SDR_RUN_FAILED : SDR_OK;
}

/* out[k] = numerator/denominator at each point, 0 where the denominator is. */
static void divide(const double *numerator, const double *denominator, int32_t count, double *out)
{
  for (int32_t i = 0; i < count; ++i)
    out[i] = denominator[i] > 0.0 ? numerator[i] / denominator[i] : 0.0;
}

static sdr_status damage(sdr_bond_model *model, double *const u[3], double *sum, double *out)
{
  const sdr_points *points = model->head.points;
  SDR_TRY(sdr_bond_find_family_volume(model));
  field_call call = {.model = model, .u = u, .sum = {sum}};
  sdr_each_stripe(points, damage_of_stripe, &call);
  divide(sum, model->family_volume, points->count, out);
  return SDR_OK;
}

sdr_status sdr_bond_field(sdr_model *model, double *const u[3], sdr_model_field which, double *out)
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  const sdr_points *points = model->points;
  const size_t padded = sdr_points_padded(points), count = (size_t)points->count;
  if (which == SDR_FIELD_STRAIN) return strain(bond, u, 0, out);
  if (which == SDR_FIELD_DILATATION) return strain(bond, u, 1, out);
  const size_t sums = which == SDR_FIELD_DAMAGE ? 1 : which == SDR_FIELD_STRESS ? 6 : 2;
  double *sum = sdr_alloc(sums * padded, sizeof *sum);
  if (!sum) return SDR_RUN_FAILED;
  sdr_status status = SDR_OK;
  if (which == SDR_FIELD_DAMAGE) {
    status = damage(bond, u, sum, out);
  } else if (which == SDR_FIELD_STRESS) {
    const int components = points->components * (points->components + 1) / 2;
    accumulate(bond, u, components, sum, add_stress);
    for (int k = 0; k < components; ++k)
      for (int32_t i = 0; i < points->count; ++i)
        out[(size_t)k * count + (size_t)i] =
            0.5 * sum[(size_t)k * padded + (size_t)i] / points->volume[i];
  } else {
    accumulate(bond, u, 2, sum, add_energy);
    const double *energy = which == SDR_FIELD_ENERGY_DENSITY ? sum : sum + padded;
    divide(energy, points->volume, points->count, out);
  }
  sdr_free(sum);
  return status;
}

typedef struct {
  field_call field;
  void (*visit)(void *context, int32_t i, int32_t j, double damage);
  void *context;
} damage_call;

static void visit_pair_damage(void *context, const sdr_pair *pair)
{
  const damage_call *call = context;
  if (!pair->primary) return;
  const sdr_pair_answer answer =
      sdr_pair_answer_at(&call->field.model->body, pair, stretch(&call->field, pair));
  const double ni = pair->weight_ij > 0.0 ? 1.0 : 0.0, nj = pair->weight_ji > 0.0 ? 1.0 : 0.0;
  call->visit(call->context, pair->i, pair->j,
              (ni * answer.ij.damage + nj * answer.ji.damage) / (ni + nj));
}

void sdr_bond_visit_damage(sdr_model *model, double *const u[3],
                           void (*each)(void *context, int32_t i, int32_t j, double damage),
                           void *context)
{
  damage_call call = {{.model = (sdr_bond_model *)model, .u = u}, each, context};
  sdr_bonds_visit(call.field.model->bonds, model->points, visit_pair_damage, &call);
}
