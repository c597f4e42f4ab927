/* Tangents of bond-based bodies: of the reference shape, and the exact one at any state. */
#include "base/parallel.h"
#include "mechanics/bond_internal.h"

#include <math.h>
#include <string.h>

typedef struct {
  sdr_bond_model *model;
  double *const *u, *const *v, *const *out;
  double *diagonal;
} tangent_call;

static void clear(const sdr_points *points, double *const out[3])
{
  for (int a = 0; a < points->components; ++a)
    memset(out[a], 0, (size_t)points->count * sizeof(double));
}

/* ---- reference ------------------------------------------------------------------------------- */

static void reference_of_pair(void *context, const sdr_pair *pair)
{
  const tangent_call *call = context;
  const sdr_bond_body *body = &call->model->body;
  const int n = body->points->components;
  if (!pair->loose) return; /* runs have a kernel */
  const double stiffness = pair->weight_ij * sdr_body_stiffness(body, pair->i) +
                           pair->weight_ji * sdr_body_stiffness(body, pair->j);
  double along = 0.0;
  for (int a = 0; a < n; ++a) along += pair->xi[a] * (call->v[a][pair->j] - call->v[a][pair->i]);
  along *= stiffness / (pair->length * pair->length * pair->length);
  for (int a = 0; a < n; ++a) call->out[a][pair->i] -= along * pair->xi[a];
}

static void reference_of_stripe(void *context, int s)
{
  const tangent_call *call = context;
  const sdr_bond_model *model = call->model;
  const sdr_bonds *bonds = model->bonds;
  const int n = model->head.points->components, each = model->body.stiffness_at != NULL;
  model->kernels->run_reference[n - 1][each](&model->body, bonds->stripe_run[s],
                                             bonds->stripe_run[s + 1], call->v, call->out);
  if (bonds->loose.chunk_count > 0)
    for (int32_t i = model->head.points->stripe_first[s];
         i < model->head.points->stripe_first[s + 1]; ++i)
      sdr_bonds_visit_loose_point(bonds, i, reference_of_pair, context);
}

void sdr_bond_reference_times(sdr_model *model, double *const v[3], double *const out[3])
{
  tangent_call call = {.model = (sdr_bond_model *)model, .v = v, .out = out};
  clear(model->points, out);
  sdr_each_stripe(model->points, reference_of_stripe, &call);
}

/* ---- exact ----------------------------------------------------------------------------------- */

/* Force and slope of both directed bonds as the model's force has them: explicit bodies lose a bond
   of critical stretch in the force itself, precise ones when they commit. */
static sdr_pair_answer answer_of_force(const sdr_bond_body *body, const sdr_pair *pair, double s)
{
  sdr_pair_answer answer = sdr_pair_answer_at(body, pair, s);
  if (body->precise || body->law != SDR_LAW_CRITICAL_STRETCH) return answer;
  const sdr_flags flags = (pair->loose ? body->loose_flags : body->flags)[pair->slot];
  if (flags & SDR_PROTECTED) return answer;
  if (sdr_critical_breaks(s, sdr_body_threshold(body, pair->i))) answer.ij = sdr_bond_lost();
  if (sdr_critical_breaks(s, sdr_body_threshold(body, pair->j))) answer.ji = sdr_bond_lost();
  return answer;
}

/* Unit vector from i to j as they are now; returns their distance. */
static double present_direction(const sdr_bond_body *body, const sdr_pair *pair, double *const u[3],
                                double n[3])
{
  const int components = body->points->components;
  double square = 0.0;
  for (int c = 0; c < components; ++c) {
    n[c] = pair->xi[c] + u[c][pair->j] - u[c][pair->i];
    square += n[c] * n[c];
  }
  const double l = sqrt(square);
  for (int c = 0; c < components && l > 0.0; ++c) n[c] /= l;
  return l;
}

/* K = A n (x) n + B (I - n (x) n) of a pair: A = dF/dl, B = F/l. Gives l = 0 no stiffness. */
void sdr_bond_pair_tangent(const sdr_bond_body *body, const sdr_pair *pair, double *const u[3],
                           double n[3], double *a, double *b)
{
  const double s = sdr_pair_stretch(pair, body->points->components, u);
  const sdr_pair_answer answer = answer_of_force(body, pair, s);
  const double l = present_direction(body, pair, u, n);
  const double ci = pair->weight_ij * sdr_body_stiffness(body, pair->i);
  const double cj = pair->weight_ji * sdr_body_stiffness(body, pair->j);
  *a = *b = 0.0;
  if (l <= 0.0) return;
  *a = (ci * answer.ij.slope + cj * answer.ji.slope) / pair->length;
  *b = (ci * answer.ij.force + cj * answer.ji.force) / l;
}

static void pair_tangent(const tangent_call *call, const sdr_pair *pair, double n[3], double *a,
                         double *b)
{
  sdr_bond_pair_tangent(&call->model->body, pair, call->u, n, a, b);
}

static void tangent_of_pair(void *context, const sdr_pair *pair)
{
  const tangent_call *call = context;
  const int components = call->model->head.points->components;
  double n[3], a, b, dv[3], along = 0.0;
  pair_tangent(call, pair, n, &a, &b);
  for (int c = 0; c < components; ++c) {
    dv[c] = call->v[c][pair->j] - call->v[c][pair->i];
    along += n[c] * dv[c];
  }
  for (int c = 0; c < components; ++c) {
    const double k = b * dv[c] + (a - b) * along * n[c];
    call->out[c][pair->i] -= k;
    if (!pair->loose) call->out[c][pair->j] += k;
  }
}

static void tangent_of_stripe(void *context, int s)
{
  const tangent_call *call = context;
  sdr_bonds_visit_stripe(call->model->bonds, call->model->head.points, s, tangent_of_pair, context);
}

sdr_status sdr_bond_tangent_times(sdr_model *model, double *const u[3], double *const v[3],
                                  double *const out[3])
{
  tangent_call call = {.model = (sdr_bond_model *)model, .u = u, .v = v, .out = out};
  clear(model->points, out);
  sdr_each_stripe(model->points, tangent_of_stripe, &call);
  return SDR_OK;
}

static void diagonal_of_pair(void *context, const sdr_pair *pair)
{
  const tangent_call *call = context;
  const int m = call->model->head.points->components;
  double n[3], a, b;
  pair_tangent(call, pair, n, &a, &b);
  for (int r = 0; r < m; ++r)
    for (int c = 0; c < m; ++c) {
      const double k = (r == c ? b : 0.0) + (a - b) * n[r] * n[c];
      call->diagonal[(size_t)pair->i * (size_t)(m * m) + (size_t)(r * m + c)] += k;
      if (!pair->loose)
        call->diagonal[(size_t)pair->j * (size_t)(m * m) + (size_t)(r * m + c)] += k;
    }
}

static void diagonal_of_stripe(void *context, int s)
{
  const tangent_call *call = context;
  sdr_bonds_visit_stripe(call->model->bonds, call->model->head.points, s, diagonal_of_pair,
                         context);
}

sdr_status sdr_bond_tangent_diagonal(sdr_model *model, double *const u[3], double *out)
{
  const int m = model->points->components;
  tangent_call call = {.model = (sdr_bond_model *)model, .u = u, .diagonal = out};
  memset(out, 0, (size_t)model->points->count * (size_t)(m * m) * sizeof *out);
  sdr_each_stripe(model->points, diagonal_of_stripe, &call);
  return SDR_OK;
}

/* ---- Hessian --------------------------------------------------------------------------------- */

typedef struct {
  tangent_call call;
  sdr_hessian_visitor visit;
  void *context;
} hessian_call;

/* Hand out [K -K; -K K] over the components of i, then of j, with K = b I + (a - b) n (x) n. */
static void visit_block(const hessian_call *h, const sdr_pair *pair, const double n[3], double a,
                        double b)
{
  const int m = h->call.model->head.points->components;
  const int32_t ends[2] = {pair->i, pair->j};
  double block[36];
  for (int r = 0; r < m; ++r)
    for (int c = 0; c < m; ++c) {
      const double k = (r == c ? b : 0.0) + (a - b) * n[r] * n[c];
      block[r * 2 * m + c] = block[(r + m) * 2 * m + c + m] = k;
      block[r * 2 * m + c + m] = block[(r + m) * 2 * m + c] = -k;
    }
  h->visit(h->context, 2, ends, block);
}

static void hessian_of_pair(void *context, const sdr_pair *pair)
{
  const hessian_call *h = context;
  double n[3], a, b;
  if (!pair->primary) return;
  pair_tangent(&h->call, pair, n, &a, &b);
  visit_block(h, pair, n, a, b);
}

sdr_status sdr_bond_visit_hessian(sdr_model *model, double *const u[3], sdr_hessian_visitor visit,
                                  void *context)
{
  hessian_call h = {.call = {.model = (sdr_bond_model *)model, .u = u}, visit, context};
  sdr_bonds_visit(h.call.model->bonds, model->points, hessian_of_pair, &h);
  return SDR_OK;
}

/* K = (F/s)/|xi| n (x) n: stretching only, with the stiffness that damage leaves. */
static void secant_of_pair(void *context, const sdr_pair *pair)
{
  const hessian_call *h = context;
  const sdr_bond_body *body = &h->call.model->body;
  if (!pair->primary) return;
  const double s = sdr_pair_stretch(pair, body->points->components, h->call.u);
  const sdr_pair_answer answer = answer_of_force(body, pair, s);
  const double left_i = s != 0.0 ? answer.ij.force / s : answer.ij.slope;
  const double left_j = s != 0.0 ? answer.ji.force / s : answer.ji.slope;
  double n[3];
  const double l = present_direction(body, pair, h->call.u, n);
  const double a = (pair->weight_ij * sdr_body_stiffness(body, pair->i) * left_i +
                    pair->weight_ji * sdr_body_stiffness(body, pair->j) * left_j) /
                   pair->length;
  visit_block(h, pair, n, l > 0.0 ? a : 0.0, 0.0);
}

sdr_status sdr_bond_visit_secant(sdr_model *model, double *const u[3], sdr_hessian_visitor visit,
                                 void *context)
{
  hessian_call h = {.call = {.model = (sdr_bond_model *)model, .u = u}, visit, context};
  sdr_bonds_visit(h.call.model->bonds, model->points, secant_of_pair, &h);
  return SDR_OK;
}
