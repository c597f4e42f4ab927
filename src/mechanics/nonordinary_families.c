/* Shape tensors of non-ordinary bodies, made anew when critical stretch takes bonds out of
   families, and the energy that goes with them. */
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/nonordinary_internal.h"
#include "nom/weight.h"

#include <math.h>
#include <string.h>

/* Above this ratio of eigenvalues a shape tensor counts as singular. */
static const double worst_condition = 1e8;
/* The stiffness of a point goes with the square of the inverse of its shape tensor K. Where lost
   bonds have brought the least eigenvalue of K below this share of the first, the moduli fade with
   its square, so that the step that suited the whole body still does. A plane cut leaves 1/2. */
static const double least_share = 0.3;

static sdr_flags flags_of(const sdr_state_body *state, const sdr_pair *pair)
{
  const sdr_flags *flags = pair->loose ? state->loose_flags : state->flags;
  return flags ? flags[pair->slot] : 0;
}

/* ---- shape tensors --------------------------------------------------------------------------- */

typedef struct {
  sdr_nonordinary_model *model;
  int only_fresh;
} families_call;

/* K, in the place of its inverse, and the fourth moments of point i. */
static void add_moments(sdr_nonordinary_model *model, int32_t i, const sdr_pair *pair, double w)
{
  const int n = model->state.head.points->components;
  double phi[SDR_MONOMIALS], normal[3] = {0.0};
  for (int a = 0; a < n; ++a) {
    normal[a] = pair->xi[a] / pair->length;
    for (int b = a; b < n; ++b)
      model->body.inverse[sdr_upper(n, a, b)][i] += w * pair->xi[a] * pair->xi[b];
  }
  const int count = sdr_quartic(n, normal, phi);
  for (int k = 0; k < count; ++k)
    model->body.quartic[k][i] += w * pair->length * pair->length * phi[k];
}

static void add_family(void *context, const sdr_pair *pair)
{
  const families_call *call = context;
  const sdr_state_body *state = &call->model->state;
  const sdr_flags flags = flags_of(state, pair);
  const int i = !call->only_fresh || state->fresh[pair->i];
  const int j = (!call->only_fresh || state->fresh[pair->j]) && !pair->loose;
  if (i && !(flags & SDR_LOST_I)) add_moments(call->model, pair->i, pair, pair->weight_ij);
  if (j && !(flags & SDR_LOST_J)) add_moments(call->model, pair->j, pair, pair->weight_ji);
}

static void clear_moments(sdr_nonordinary_model *model, int32_t i)
{
  const int n = model->state.head.points->components;
  for (int k = 0; k < n * (n + 1) / 2; ++k) model->body.inverse[k][i] = 0.0;
  for (int k = 0; k < sdr_monomial_count(n); ++k) model->body.quartic[k][i] = 0.0;
}

/* Adjugate of the symmetric matrix k (upper half), and its determinant. */
static double adjugate(int n, const double k[6], double a[6])
{
  if (n == 1) {
    a[0] = 1.0;
    return k[0];
  }
  if (n == 2) {
    a[0] = k[2];
    a[1] = -k[1];
    a[2] = k[0];
    return k[0] * k[2] - k[1] * k[1];
  }
  a[0] = k[3] * k[5] - k[4] * k[4];
  a[1] = k[2] * k[4] - k[1] * k[5];
  a[2] = k[1] * k[4] - k[2] * k[3];
  a[3] = k[0] * k[5] - k[2] * k[2];
  a[4] = k[1] * k[2] - k[0] * k[4];
  a[5] = k[0] * k[3] - k[1] * k[1];
  return k[0] * a[0] + k[1] * a[1] + k[2] * a[2];
}

/* Least and largest eigenvalue of k. */
typedef struct {
  double least, most;
} extremes;

static extremes extremes_of(int n, const double k[6])
{
  double full[9] = {0.0}, e[3], v[9];
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) full[3 * a + b] = k[sdr_upper(n, a, b)];
  sdr_eigen3(full, e, v);
  extremes of = {e[0], e[0]};
  for (int a = 1; a < n; ++a) {
    of.least = fmin(of.least, e[a]);
    of.most = fmax(of.most, e[a]);
  }
  return of;
}

/* Their ratio; 0 for an empty family, infinite for a singular one. */
static double condition_of(const extremes *k)
{
  if (!(k->most > 0.0)) return 0.0;
  return k->least > 0.0 ? k->most / k->least : (double)INFINITY;
}

double sdr_nonordinary_least(int n, const double k[6])
{
  return least_share * extremes_of(n, k).least;
}

double sdr_nonordinary_share(int n, const double k[6], double least, double inverse[6])
{
  double a[6];
  const extremes of = extremes_of(n, k);
  const double determinant = adjugate(n, k, a), condition = condition_of(&of);
  const int sound = condition >= 1.0 && condition <= worst_condition;
  for (int e = 0; e < n * (n + 1) / 2; ++e) inverse[e] = sound ? a[e] / determinant : 0.0;
  if (!sound) return 0.0;
  return of.least < least ? of.least / least : 1.0;
}

static double trace_of(int n, const double k[6])
{
  double trace = 0.0;
  for (int a = 0; a < n; ++a) trace += k[sdr_upper(n, a, a)];
  return trace;
}

/* Note what the family of point i is at the start. */
static void note_whole(sdr_nonordinary_model *model, int32_t i)
{
  const int n = model->state.head.points->components;
  double k[6] = {0.0};
  for (int e = 0; e < n * (n + 1) / 2; ++e) k[e] = model->body.inverse[e][i];
  model->least[i] = sdr_nonordinary_least(n, k);
  model->whole[i] = trace_of(n, k);
}

/* Let point i have `share` of its moduli. */
static void soften(sdr_nonordinary_model *model, int32_t i, double share)
{
  const sdr_state_body *state = &model->state;
  const int n = state->head.points->components;
  model->lambda[i] = share * model->whole_lambda[i];
  model->mu[i] = share * model->whole_mu[i];
  model->reference_mu[i] = share * state->shear[i];
  model->reference_lambda[i] = share * (state->bulk[i] - 2.0 * state->shear[i] / n);
}

/* K^-1, control and moduli of point i; 0 if K has no inverse, and the point carries nothing. */
static int invert(sdr_nonordinary_model *model, int32_t i)
{
  const sdr_points *points = model->state.head.points;
  const int n = points->components, size = n * (n + 1) / 2;
  double k[6] = {0.0}, inverse[6];
  for (int e = 0; e < size; ++e) k[e] = model->body.inverse[e][i];
  const double share = sdr_nonordinary_share(n, k, model->least[i], inverse);
  for (int e = 0; e < size; ++e) model->body.inverse[e][i] = inverse[e];
  const double volume = share > 0.0 ? points->volume[i] / model->whole[i] : 0.0;
  model->body.shear[i] = volume * model->control_shear[i];
  model->body.normal[i] = volume * model->control_normal[i];
  /* where K has no inverse there is no strain, and laws want moduli above 0 */
  soften(model, i, share > 0.0 ? share * share : 1.0);
  return share > 0.0 || !(trace_of(n, k) > 0.0);
}

/* Of point i, from the inverse, which has the same ratio; 0 if it carries nothing. */
static double condition_at(const sdr_nonordinary_model *model, int32_t i)
{
  const int n = model->state.head.points->components;
  double k[6] = {0.0};
  for (int e = 0; e < n * (n + 1) / 2; ++e) k[e] = model->body.inverse[e][i];
  const extremes of = extremes_of(n, k);
  return condition_of(&of);
}

static sdr_status singular(const sdr_points *points, int32_t i)
{
  return sdr_fail(SDR_BAD_INPUT,
                  "the non-ordinary model cannot tell strains at point %d, (%g, %g, %g) m: its "
                  "neighbours lie (almost) in a %s; take a larger horizon or more points across",
                  (int)i, points->x[0][i], points->components > 1 ? points->x[1][i] : 0.0,
                  points->components > 2 ? points->x[2][i] : 0.0,
                  points->components > 2 ? "plane" : "line");
}

/* Sums and inverses of all families as the flags leave them. */
static void make_families(sdr_nonordinary_model *model, int first)
{
  const sdr_points *points = model->state.head.points;
  families_call call = {model, 0};
  for (int32_t i = 0; i < points->count; ++i) clear_moments(model, i);
  sdr_bonds_visit(model->state.bonds, points, add_family, &call);
  for (int32_t i = 0; first && i < points->count; ++i) note_whole(model, i);
}

sdr_status sdr_nonordinary_families(sdr_nonordinary_model *model, int may_fail)
{
  const sdr_points *points = model->state.head.points;
  make_families(model, 1);
  model->condition = 0.0;
  for (int32_t i = 0; i < points->count; ++i) {
    if (!invert(model, i) && !may_fail) return singular(points, i);
    model->condition = fmax(model->condition, condition_at(model, i));
  }
  return SDR_OK;
}

static void note_torn(void *context, const sdr_pair *pair)
{
  sdr_nonordinary_model *model = context;
  const sdr_flags flags = flags_of(&model->state, pair);
  if (flags & SDR_CUT) return;
  if (flags & SDR_LOST_I) model->torn[pair->i] = 1;
  if (flags & SDR_LOST_J && !pair->loose) model->torn[pair->j] = 1;
}

void sdr_nonordinary_refresh(sdr_nonordinary_model *model)
{
  if (!model->stale) return;
  make_families(model, 0);
  sdr_bonds_visit(model->state.bonds, model->state.head.points, note_torn, model);
  for (int32_t i = 0; i < model->state.head.points->count; ++i) invert(model, i);
  model->stale = 0;
}

/* ---- books ----------------------------------------------------------------------------------- */

/* The displacement u - back dt v, of families as they are (`before`: with what is fresh). */
typedef struct {
  sdr_nonordinary_model *model;
  double *const *u, *const *v;
  double back, factor;
  int before;
} book_call;

static void difference(const book_call *call, const sdr_pair *pair, double eta[3])
{
  for (int a = 0; a < call->model->state.head.points->components; ++a) {
    eta[a] = call->u[a][pair->j] - call->u[a][pair->i];
    if (call->v) eta[a] -= call->back * (call->v[a][pair->j] - call->v[a][pair->i]);
  }
}

/* 1 if the half `lost` of the pair still counts. */
static int counts(const book_call *call, const sdr_pair *pair, sdr_flags lost)
{
  const sdr_flags flags = flags_of(&call->model->state, pair);
  return !(flags & lost) || (call->before && flags & (lost << 2));
}

/* Pass A for one point. */
static void gather_point(const sdr_nonordinary_model *model, int32_t i, const sdr_pair *pair,
                         double w, const double *eta)
{
  const sdr_nonordinary_body *body = &model->body;
  const int n = model->state.head.points->components;
  double along = 0.0;
  int kept = 0;
  for (int a = 0; a < n; ++a) {
    along += eta[a] * pair->xi[a] / pair->length;
    body->square[i] += w * eta[a] * eta[a];
    for (int b = 0; b < n; ++b) body->gradient[n * a + b][i] += w * eta[a] * pair->xi[b];
  }
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n && a < n - 1; ++b)
      body->moment[kept++][i] += w * along * pair->xi[a] * pair->xi[b] / pair->length;
  body->along[i] += w * along * along;
}

/* Pass A2 for one point. */
static void control_point(const sdr_nonordinary_model *model, int32_t i, const sdr_pair *pair,
                          double w, const double *eta)
{
  const sdr_nonordinary_body *body = &model->body;
  const int n = model->state.head.points->components;
  double z[3], f[3], along = 0.0, square = 1e-300;
  for (int a = 0; a < n; ++a) {
    f[a] = pair->xi[a];
    for (int b = 0; b < n; ++b) f[a] += body->gradient[n * a + b][i] * pair->xi[b];
    z[a] = eta[a] + pair->xi[a] - f[a];
    along += z[a] * f[a];
    square += f[a] * f[a];
    body->square[i] += w * z[a] * z[a];
  }
  body->along[i] += w * along * along / square;
}

static void each_end(const book_call *call, const sdr_pair *pair,
                     void (*visit)(const sdr_nonordinary_model *, int32_t, const sdr_pair *, double,
                                   const double *))
{
  const sdr_state_body *state = &call->model->state;
  double eta[3];
  difference(call, pair, eta);
  if (state->fresh[pair->i] && counts(call, pair, SDR_LOST_I))
    visit(call->model, pair->i, pair, pair->weight_ij, eta);
  if (state->fresh[pair->j] && counts(call, pair, SDR_LOST_J) && !pair->loose)
    visit(call->model, pair->j, pair, pair->weight_ji, eta);
}

static void gather_pair(void *context, const sdr_pair *pair)
{
  each_end(context, pair, gather_point);
}
static void control_pair(void *context, const sdr_pair *pair)
{
  each_end(context, pair, control_point);
}

static void gather_fresh(void *context, int s)
{
  const book_call *call = context;
  sdr_state_visit_fresh(&call->model->state, s, gather_pair, context);
}
static void control_fresh(void *context, int s)
{
  const book_call *call = context;
  sdr_state_visit_fresh(&call->model->state, s, control_pair, context);
}
static void family_fresh(void *context, int s)
{
  const families_call *call = context;
  sdr_state_visit_fresh(&call->model->state, s, add_family, context);
}

/* The arrays of the passes at point i, all zero. */
static void clear_sums(const sdr_nonordinary_model *model, int32_t i)
{
  const int n = model->state.head.points->components;
  for (int k = 0; k < n * n; ++k) model->body.gradient[k][i] = model->body.moment[k][i] = 0.0;
  model->body.square[i] = model->body.along[i] = 0.0;
}

/* release += factor times the energy of each fresh point. */
static void add_energies(book_call *call)
{
  sdr_nonordinary_model *model = call->model;
  sdr_state_body *state = &model->state;
  const sdr_points *points = state->head.points;
  const int finite = model->elasticity != SDR_LINEAR;
  for (int32_t i = 0; i < points->count; ++i)
    if (state->fresh[i]) clear_sums(model, i);
  sdr_each_stripe(points, gather_fresh, call);
  for (int32_t i = 0; finite && i < points->count; ++i)
    if (state->fresh[i]) sdr_nonordinary_gradient(model, i);
  if (finite) sdr_each_stripe(points, control_fresh, call);
  for (int32_t i = 0; i < points->count; ++i) {
    if (!state->fresh[i]) continue;
    sdr_nonordinary_energy(model, i);
    state->release[i] += call->factor * points->volume[i] * (state->plus[i] + state->minus[i]);
  }
}

/* With e(k) the energy lost at u - k dt v, what the step loses is e(0) + e'(0)/2: the work of the
   forces that went, over half the step, is missing from the trapezoid. */
static void add_all_energies(book_call *call, double sign, double dt)
{
  static const double back[3] = {0.0, 1.0, -1.0}, factor[3] = {1.0, 0.25, -0.25};
  for (int k = 0; k < (call->v ? 3 : 1); ++k) {
    call->back = back[k] * dt;
    call->factor = sign * factor[k];
    add_energies(call);
  }
}

/* The families of fresh points as the flags leave them. */
void sdr_nonordinary_remake_fresh(sdr_state_body *state)
{
  sdr_nonordinary_model *model = (sdr_nonordinary_model *)state;
  const sdr_points *points = state->head.points;
  families_call families = {model, 1};
  for (int32_t i = 0; i < points->count; ++i)
    if (state->fresh[i]) clear_moments(model, i);
  sdr_each_stripe(points, family_fresh, &families);
  for (int32_t i = 0; i < points->count; ++i)
    if (state->fresh[i]) invert(model, i);
}

void sdr_nonordinary_book(sdr_state_body *state, double *const u[3], double *const v[3], double dt)
{
  book_call call = {.model = (sdr_nonordinary_model *)state, .u = u, .v = v, .before = 1};
  add_all_energies(&call, 1.0, dt);
  sdr_nonordinary_remake_fresh(state);
  call.before = 0;
  add_all_energies(&call, -1.0, dt);
  for (int32_t i = 0; i < state->head.points->count; ++i)
    if (state->fresh[i] && !(state->release[i] < 0.0)) call.model->torn[i] = 1;
}
