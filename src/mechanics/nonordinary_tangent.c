/* The exact tangent of non-ordinary bodies. The energy is a sum over points, each of which sees its
   own family, so the Hessian is a sum of one dense block per family. With h = (z.n)^2/2 of the
   control's normal part, a change of the relative displacements changes the state
   T = W (A xi + g (shear z + normal dh/deta)), A = (V (g P+ + P-) + g normal S) K^-1,
   S = sum W dh/dp (x) xi, p = G xi, term by term (theory sec. 11). */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/nonordinary_internal.h"

#include <string.h>

/* ---- lists of families ----------------------------------------------------------------------- */

typedef struct {
  sdr_nonordinary_model *model;
  int64_t *next;
} list_call;

static void count_members(void *context, const sdr_pair *pair)
{
  const list_call *call = context;
  call->next[pair->i] += pair->weight_ij > 0.0;
  call->next[pair->j] += pair->weight_ji > 0.0 && !pair->loose;
}

static void add_member(const list_call *call, const sdr_pair *pair, int32_t i, int32_t j,
                       double sign, double weight)
{
  if (!(weight > 0.0)) return;
  sdr_member *member = &call->model->member[call->next[i]++];
  *member = (sdr_member){.j = j, .loose = pair->loose, .slot = pair->slot, .weight = weight};
  for (int a = 0; a < 3; ++a) member->xi[a] = sign * pair->xi[a];
  if (sign < 0.0) member->loose = -1; /* the other half of a run's pair */
}

static void list_members(void *context, const sdr_pair *pair)
{
  const list_call *call = context;
  add_member(call, pair, pair->i, pair->j, 1.0, pair->weight_ij);
  if (!pair->loose) add_member(call, pair, pair->j, pair->i, -1.0, pair->weight_ji);
}

static sdr_status make_lists(sdr_nonordinary_model *model)
{
  if (model->first) return SDR_OK;
  const sdr_points *points = model->state.head.points;
  const int32_t count = points->count;
  int64_t *first = sdr_alloc((size_t)count + 2, sizeof *first);
  if (!first) return SDR_RUN_FAILED;
  list_call call = {model, first + 2};
  sdr_bonds_visit(model->state.bonds, points, count_members, &call);
  for (int32_t i = 0; i < count; ++i) {
    if (first[i + 2] > model->most) model->most = (int)first[i + 2];
    first[i + 2] += first[i + 1];
  }
  model->member = sdr_alloc((size_t)first[count + 1], sizeof *model->member);
  if (!model->member) {
    sdr_free(first);
    return SDR_RUN_FAILED;
  }
  call.next = first + 1; /* each ends where the next one starts */
  sdr_bonds_visit(model->state.bonds, points, list_members, &call);
  model->first = first;
  return SDR_OK;
}

/* ---- one family ------------------------------------------------------------------------------ */

/* z, f (or n), z.f/f.f and dh/dp of a member. */
typedef struct {
  double z[3], f[3], p[3], square, share;
} bond_state;

/* A point at u. */
typedef struct {
  int n, count, finite;
  const sdr_member *member;
  double volume, inverse[9], gradient[9], s[9], p_plus[9], tangent[81];
  double shear, normal, intact, intact_slope; /* (1-d)^2, and its slope by psi+ where d grows */
  double *weight;                             /* count: W, 0 of lost bonds */
  double *eta;                                /* 3 count */
  bond_state *bond;                           /* count */
} family;

static void multiply(int n, const double *a, const double *b, double *out)
{
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      out[n * r + c] = 0.0;
      for (int k = 0; k < n; ++k) out[n * r + c] += a[n * r + k] * b[n * k + c];
    }
}

/* Linear: f = xi, whose length does not matter to the direction. */
static bond_state bond_of(const family *at, int k)
{
  const int n = at->n;
  bond_state b = {.square = 1e-300};
  double along = 0.0;
  for (int a = 0; a < n; ++a) {
    for (int c = 0; c < n; ++c) b.p[a] += at->gradient[n * a + c] * at->member[k].xi[c];
    b.f[a] = at->member[k].xi[a] + (at->finite ? b.p[a] : 0.0);
    b.z[a] = at->eta[3 * k + a] - b.p[a];
    b.square += b.f[a] * b.f[a];
    along += b.z[a] * b.f[a];
  }
  b.share = along / b.square;
  return b;
}

/* dh/dp; dh/deta is share f. */
static void by_gradient(const family *at, const bond_state *b, double *out)
{
  for (int a = 0; a < at->n; ++a)
    out[a] = at->finite ? b->share * (b->z[a] - (1.0 + b->share) * b->f[a]) : -b->share * b->f[a];
}

/* Changes of dh/deta and dh/dp with those of eta and p. */
static void bond_change(const family *at, const bond_state *b, const double *deta, const double *dp,
                        double *by_eta, double *by_p)
{
  const int n = at->n;
  double along = 0.0, square = 0.0;
  for (int a = 0; a < n; ++a) {
    along += (deta[a] - dp[a]) * b->f[a] + (at->finite ? b->z[a] * dp[a] : 0.0);
    square += at->finite ? 2.0 * b->f[a] * dp[a] : 0.0;
  }
  const double dshare = (along - b->share * square) / b->square;
  for (int a = 0; a < n; ++a) {
    const double df = at->finite ? dp[a] : 0.0;
    by_eta[a] = dshare * b->f[a] + b->share * df;
    by_p[a] = -by_eta[a];
    if (!at->finite) continue;
    /* share (z - f - share f) */
    by_p[a] = dshare * (b->z[a] - b->f[a] - b->share * b->f[a]) +
              b->share * (deta[a] - dp[a] - df - dshare * b->f[a] - b->share * df);
  }
}

static int is_lost(const sdr_state_body *state, const sdr_member *member)
{
  const sdr_flags *flags = member->loose > 0 ? state->loose_flags : state->flags;
  if (!flags) return 0;
  return (flags[member->slot] & (member->loose < 0 ? SDR_LOST_J : SDR_LOST_I)) != 0;
}

/* eta, W and G of the family of point i at u. */
static void load_family(const sdr_nonordinary_model *model, int32_t i, double *const u[3],
                        family *at)
{
  const sdr_nonordinary_body *body = &model->body;
  const int n = at->n = model->state.head.points->components;
  double m[9] = {0.0};
  at->member = model->member + model->first[i];
  at->count = (int)(model->first[i + 1] - model->first[i]);
  at->finite = model->elasticity != SDR_LINEAR;
  at->volume = body->points->volume[i];
  at->shear = body->shear[i];
  at->normal = body->normal[i];
  for (int k = 0; k < at->count; ++k) {
    const sdr_member *member = &at->member[k];
    at->weight[k] = is_lost(&model->state, member) ? 0.0 : member->weight;
    for (int a = 0; a < n; ++a) {
      at->eta[3 * k + a] = u[a][member->j] - u[a][i];
      for (int b = 0; b < n; ++b)
        m[n * a + b] += at->weight[k] * at->eta[3 * k + a] * member->xi[b];
    }
  }
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) at->inverse[n * a + b] = body->inverse[sdr_upper(n, a, b)][i];
  multiply(n, m, at->inverse, at->gradient);
}

/* S, stress, damage and tangent of the law. */
static void set_state(const sdr_nonordinary_model *model, int32_t i, family *at)
{
  const int n = at->n;
  const sdr_moduli moduli = {model->lambda[i], model->mu[i], model->body.plane_stress};
  double square = 0.0, along = 0.0, minus[81];
  sdr_point_stress stress;
  memset(at->s, 0, sizeof at->s);
  for (int k = 0; k < at->count; ++k) {
    const bond_state b = at->bond[k] = bond_of(at, k);
    double h[3];
    by_gradient(at, &b, h);
    for (int a = 0; a < n; ++a) {
      square += at->weight[k] * b.z[a] * b.z[a];
      for (int c = 0; c < n; ++c) at->s[n * a + c] += at->weight[k] * h[a] * at->member[k].xi[c];
    }
    along += at->weight[k] * b.share * b.share * b.square;
  }
  sdr_stress_of(n, model->elasticity, model->split, &moduli, at->gradient, &stress);
  sdr_stress_tangent(n, model->elasticity, model->split, &moduli, at->gradient, at->tangent, minus);
  at->intact = 1.0;
  at->intact_slope = 0.0;
  if (model->state.history) {
    const double control = 0.5 * (at->shear * square + at->normal * along);
    const double plus = stress.plus + (at->volume > 0.0 ? control / at->volume : 0.0);
    const double left = 1.0 - sdr_state_damage(&model->state, i, plus);
    at->intact = left * left;
    if (plus >= model->state.history[i] && plus > 0.0)
      at->intact_slope = -2.0 * left * left * left * model->state.softness[i];
  }
  memcpy(at->p_plus, stress.p_plus, sizeof at->p_plus);
  for (int k = 0; k < n * n * n * n; ++k) at->tangent[k] = at->intact * at->tangent[k] + minus[k];
}

/* Change of T (3 values a member) with that of eta (likewise). */
static void family_change(const family *at, const double *deta, double *dt)
{
  const int n = at->n;
  double m[9] = {0.0}, g[9], ds[9] = {0.0}, sum[9], a_change[9], drive = 0.0;
  for (int k = 0; k < at->count; ++k)
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b)
        m[n * a + b] += at->weight[k] * deta[3 * k + a] * at->member[k].xi[b];
  multiply(n, m, at->inverse, g);
  for (int k = 0; k < at->count; ++k) {
    const bond_state b = at->bond[k];
    const double *const de = deta + 3 * (size_t)k, w = at->weight[k];
    double dp[3] = {0.0}, by_eta[3], by_p[3];
    for (int a = 0; a < n; ++a)
      for (int c = 0; c < n; ++c) dp[a] += g[n * a + c] * at->member[k].xi[c];
    bond_change(at, &b, de, dp, by_eta, by_p);
    for (int a = 0; a < n; ++a) {
      for (int c = 0; c < n; ++c) ds[n * a + c] += w * by_p[a] * at->member[k].xi[c];
      dt[3 * k + a] = w * at->intact * (at->shear * (de[a] - dp[a]) + at->normal * by_eta[a]);
      drive += w * (at->shear * b.z[a] + at->normal * b.share * b.f[a]) * de[a];
    }
  }
  for (int r = 0; r < n * n; ++r) {
    drive += (at->volume * at->p_plus[r] + at->normal * at->s[r]) * g[r];
    double stress = 0.0;
    for (int c = 0; c < n * n; ++c) stress += at->tangent[r * n * n + c] * g[c];
    sum[r] = at->volume * stress + at->intact * at->normal * ds[r];
  }
  /* damage: the driving state, times the change of (1-d)^2 */
  const double softer = at->volume > 0.0 ? at->intact_slope * drive / at->volume : 0.0;
  for (int r = 0; r < n * n; ++r)
    sum[r] += softer * (at->volume * at->p_plus[r] + at->normal * at->s[r]);
  multiply(n, sum, at->inverse, a_change);
  for (int k = 0; k < at->count; ++k) {
    const bond_state b = at->bond[k];
    for (int a = 0; a < n; ++a) {
      double t = softer * (at->shear * b.z[a] + at->normal * b.share * b.f[a]);
      for (int c = 0; c < n; ++c) t += a_change[n * a + c] * at->member[k].xi[c];
      dt[3 * k + a] += at->weight[k] * t;
    }
  }
}

/* ---- work space ------------------------------------------------------------------------------ */

/* For the largest family: weights, eta, d eta, d T, states of bonds. */
enum { SPACE = 10 + sizeof(bond_state) / sizeof(double) };

static double *family_space(const sdr_nonordinary_model *model, int copies)
{
  return sdr_alloc((size_t)copies * SPACE * (size_t)(model->most + 1), sizeof(double));
}

static family family_at(const sdr_nonordinary_model *model, double *space)
{
  const size_t size = (size_t)model->most + 1;
  return (family){.weight = space, .eta = space + size, .bond = (bond_state *)(space + 10 * size)};
}

/* ---- tangent times a vector ------------------------------------------------------------------ */

typedef struct {
  sdr_nonordinary_model *model;
  double *const *u, *const *v, *const *out;
  double *space;
} tangent_call;

/* Families reach one stripe to either side on lattices, anywhere else: points are summed by one
   thread there. */
static void tangent_of_point(const tangent_call *call, int32_t i, double *space)
{
  const sdr_nonordinary_model *model = call->model;
  const size_t size = (size_t)model->most + 1;
  double *const deta = space + 4 * size, *const dt = space + 7 * size;
  family at = family_at(model, space);
  load_family(model, i, call->u, &at);
  set_state(model, i, &at);
  for (int k = 0; k < at.count; ++k)
    for (int a = 0; a < at.n; ++a) deta[3 * k + a] = call->v[a][at.member[k].j] - call->v[a][i];
  family_change(&at, deta, dt);
  for (int k = 0; k < at.count; ++k)
    for (int a = 0; a < at.n; ++a) {
      call->out[a][i] -= dt[3 * k + a];
      call->out[a][at.member[k].j] += dt[3 * k + a];
    }
}

static void tangent_of_stripe(void *context, int s)
{
  const tangent_call *call = context;
  const int32_t *stripe = call->model->state.head.points->stripe_first;
  const size_t size = SPACE * ((size_t)call->model->most + 1);
  for (int32_t i = stripe[s]; i < stripe[s + 1]; ++i)
    tangent_of_point(call, i, call->space + (size_t)s * size);
}

sdr_status sdr_nonordinary_tangent_times(sdr_model *model, double *const u[3], double *const v[3],
                                         double *const out[3])
{
  sdr_nonordinary_model *own = (sdr_nonordinary_model *)model;
  const sdr_points *points = model->points;
  SDR_TRY(make_lists(own));
  if (!own->space) own->space = family_space(own, points->stripe_count);
  if (!own->space) return SDR_RUN_FAILED;
  tangent_call call = {own, u, v, out, own->space};
  for (int a = 0; a < points->components; ++a)
    memset(out[a], 0, (size_t)points->count * sizeof(double));
  /* a point writes to its own stripe and both neighbours */
  if (own->state.bonds->loose.chunk_count == 0)
    for (int colour = 0; colour < 3; ++colour)
      sdr_parallel_for(colour, points->stripe_count, 3, tangent_of_stripe, &call);
  else
    for (int s = 0; s < points->stripe_count; ++s) tangent_of_stripe(&call, s);
  return SDR_OK;
}

/* ---- dense blocks ---------------------------------------------------------------------------- */

/* The stiffness of small strains in the reference shape, times (1-d)^2 at u. */
static void set_secant(const sdr_nonordinary_model *model, int32_t i, family *at)
{
  const int n = at->n;
  const sdr_moduli moduli = {model->reference_lambda[i], model->reference_mu[i], 0};
  double minus[81];
  at->finite = 0;
  at->intact_slope = 0.0;
  memset(at->gradient, 0, sizeof at->gradient);
  memset(at->eta, 0, 3 * (size_t)at->count * sizeof *at->eta);
  memset(at->s, 0, sizeof at->s);
  memset(at->p_plus, 0, sizeof at->p_plus);
  sdr_stress_tangent(n, SDR_LINEAR, SDR_SPLIT_WHOLE, &moduli, at->gradient, at->tangent, minus);
  for (int k = 0; k < n * n * n * n; ++k) at->tangent[k] *= at->intact;
  for (int k = 0; k < at->count; ++k) at->bond[k] = bond_of(at, k);
}

/* The Hessian of one family's energy by the displacements of the owner, then of the members. */
static void block_of(const sdr_nonordinary_model *model, int32_t i, double *const u[3], int secant,
                     double *space, int32_t *point, double *block)
{
  const size_t size = (size_t)model->most + 1;
  double *const deta = space + 4 * size, *const dt = space + 7 * size;
  family at = family_at(model, space);
  load_family(model, i, u, &at);
  set_state(model, i, &at);
  if (secant) set_secant(model, i, &at);
  const int n = at.n, wide = n * (at.count + 1);
  point[0] = i;
  for (int k = 0; k < at.count; ++k) point[k + 1] = at.member[k].j;
  for (int column = 0; column < wide; ++column) {
    memset(deta, 0, 3 * size * sizeof *deta);
    for (int k = 0; k < at.count; ++k)
      if (column < n || column / n == k + 1) deta[3 * k + column % n] = column < n ? -1.0 : 1.0;
    family_change(&at, deta, dt);
    for (int a = 0; a < n; ++a) {
      double own = 0.0;
      for (int k = 0; k < at.count; ++k) {
        block[(size_t)(n * (k + 1) + a) * (size_t)wide + (size_t)column] = dt[3 * k + a];
        own -= dt[3 * k + a];
      }
      block[(size_t)a * (size_t)wide + (size_t)column] = own;
    }
  }
}

static sdr_status visit(sdr_model *model, double *const u[3], int secant,
                        sdr_hessian_visitor visitor, void *context)
{
  sdr_nonordinary_model *own = (sdr_nonordinary_model *)model;
  SDR_TRY(make_lists(own));
  const size_t wide = (size_t)model->points->components * ((size_t)own->most + 1);
  double *space = family_space(own, 1), *block = sdr_alloc(wide * wide, sizeof *block);
  int32_t *point = sdr_alloc((size_t)own->most + 1, sizeof *point);
  const int failed = !space || !block || !point;
  for (int32_t i = 0; !failed && i < model->points->count; ++i) {
    const int count = (int)(own->first[i + 1] - own->first[i]);
    if (count == 0) continue;
    block_of(own, i, u, secant, space, point, block);
    visitor(context, count + 1, point, block);
  }
  sdr_free(space);
  sdr_free(block);
  sdr_free(point);
  return failed ? SDR_RUN_FAILED : SDR_OK;
}

sdr_status sdr_nonordinary_visit_hessian(sdr_model *model, double *const u[3],
                                         sdr_hessian_visitor visitor, void *context)
{
  return visit(model, u, 0, visitor, context);
}

sdr_status sdr_nonordinary_visit_secant(sdr_model *model, double *const u[3],
                                        sdr_hessian_visitor visitor, void *context)
{
  return visit(model, u, 1, visitor, context);
}

typedef struct {
  int n;
  double *out;
} diagonal_call;

static void add_diagonal(void *context, int count, const int32_t *point, const double *block)
{
  const diagonal_call *call = context;
  const int n = call->n;
  const size_t wide = (size_t)(n * count);
  for (int k = 0; k < count; ++k)
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b)
        call->out[(size_t)point[k] * (size_t)(n * n) + (size_t)(n * a + b)] +=
            block[(size_t)(n * k + a) * wide + (size_t)(n * k + b)];
}

sdr_status sdr_nonordinary_tangent_diagonal(sdr_model *model, double *const u[3], double *out)
{
  const int n = model->points->components;
  diagonal_call call = {n, out};
  memset(out, 0, (size_t)model->points->count * (size_t)(n * n) * sizeof *out);
  return sdr_nonordinary_visit_hessian(model, u, add_diagonal, &call);
}
