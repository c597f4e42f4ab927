/* The exact tangent of ordinary bodies. With g = (1-d)^2 and p = plus of a point, its energy E has

     d2E/ds_j ds_k = c Q_j [j = k] + bulk P_j P_k + soft D_j D_k,   D_j = dp/ds_j = (2 B s_j) Q_j
                                                                       + pull P_j

   on top of the change of direction of its forces; soft = V dg/dp while damage grows, else 0. */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/ordinary.h"

#include <math.h>
#include <string.h>

/* Second derivatives of a point's energy, as above. */
typedef struct {
  double bulk, pull, shape, soft; /* shape: 2 B */
} curvature;

/* o->sum and, with variational damage, o->square are those of u. */
static curvature curvature_of(const sdr_ordinary *o, int32_t i)
{
  const sdr_state_body *body = &o->body;
  const sdr_ordinary_constants of = sdr_ordinary_now(o, i);
  const double square = body->history ? o->square[i] : 0.0, bulk = body->bulk[i];
  const sdr_ordinary_point now = sdr_ordinary_point_of(&of, bulk, o->sum[i], square);
  const double volume = body->head.points->volume[i];
  const double under = now.theta > 0.0 ? bulk : 0.0; /* what of K damage softens */
  const double d = sdr_state_damage(body, i, now.plus), left = (1.0 - d) * (1.0 - d);
  const int loading = body->history && now.plus > 0.0 && now.plus >= body->history[i];
  return (curvature){.bulk = volume * of.t * of.t * (left * (under - 2.0 * of.a) + bulk - under),
                     .pull = (under - 2.0 * of.a) * now.theta * of.t,
                     .shape = 2.0 * of.b,
                     .soft = loading ? -2.0 * volume * body->softness[i] * left * (1.0 - d) : 0.0};
}

/* Sums and coefficients of all points at u, as the force sees them. */
static void prepare(sdr_ordinary *o, double *const u[3])
{
  const int law = (int)o->body.law, variational = law == SDR_LAW_VARIATIONAL;
  sdr_ordinary_sum(o, u, SDR_FLAGS_KEEP, variational);
  o->kernels->points[law](o, 0, o->body.head.points->count, 0);
}

/* A pair at u: direction, stretch, lengths, and which halves are lost. */
typedef struct {
  double n[3], s, l;
  sdr_flags lost;
} shape;

static shape shape_of(const sdr_ordinary *o, const sdr_pair *pair, double *const u[3])
{
  const int components = o->body.head.points->components;
  shape p;
  memset(&p, 0, sizeof p);
  p.s = sdr_pair_stretch(pair, components, u);
  for (int a = 0; a < components; ++a) {
    p.n[a] = pair->xi[a] + u[a][pair->j] - u[a][pair->i];
    p.l += p.n[a] * p.n[a];
  }
  p.l = sqrt(p.l);
  for (int a = 0; a < components; ++a) p.n[a] = p.l > 0.0 ? p.n[a] / p.l : 0.0;
  p.lost = sdr_state_lost(&o->body, pair, p.s, 0);
  return p;
}

/* P and Q of a half; 0 if it is lost. */
typedef struct {
  double p, q;
} half;

static half half_of(const sdr_ordinary *o, const sdr_pair *pair, const shape *at, sdr_flags side)
{
  const double weight = at->lost & side                 ? 0.0
                        : side == (sdr_flags)SDR_LOST_I ? pair->weight_ij
                                                        : pair->weight_ji;
  return (half){sdr_ordinary_p(o, pair, weight), sdr_ordinary_q(o, pair, weight)};
}

/* dE/ds of both halves together. */
static double pull_of(const sdr_ordinary *o, const sdr_pair *pair, const half *i, const half *j,
                      double s)
{
  return i->p * o->along[pair->i] + i->q * o->across[pair->i] * s + j->p * o->along[pair->j] +
         j->q * o->across[pair->j] * s;
}

/* ---- tangent times a vector ------------------------------------------------------------------ */

typedef struct {
  sdr_ordinary *o;
  double *const *u, *const *v, *const *out;
} times_call;

/* Change of the stretch, and of the vector from point to point. */
static double change(const times_call *call, const sdr_pair *pair, const shape *at, double dv[3])
{
  double along = 0.0;
  for (int a = 0; a < call->o->body.head.points->components; ++a) {
    dv[a] = call->v[a][pair->j] - call->v[a][pair->i];
    along += at->n[a] * dv[a];
  }
  return along / pair->length;
}

static void sum_changes(void *context, const sdr_pair *pair)
{
  const times_call *call = context;
  sdr_ordinary *o = call->o;
  const shape at = shape_of(o, pair, call->u);
  const half i = half_of(o, pair, &at, SDR_LOST_I), j = half_of(o, pair, &at, SDR_LOST_J);
  double dv[3];
  const double ds = change(call, pair, &at, dv);
  o->slope[0][pair->i] += i.p * ds;
  o->slope[1][pair->i] += i.q * at.s * ds;
  if (pair->loose) return;
  o->slope[0][pair->j] += j.p * ds;
  o->slope[1][pair->j] += j.q * at.s * ds;
}

static void sums_of_stripe(void *context, int s)
{
  const times_call *call = context;
  sdr_bonds_visit_stripe(call->o->body.bonds, call->o->body.head.points, s, sum_changes, context);
}

/* From the changes of S and of 1/2 Q to those of a and c. */
static void change_coefficients(sdr_ordinary *o)
{
  for (int32_t i = 0; i < o->body.head.points->count; ++i) {
    const curvature k = curvature_of(o, i);
    const double dp = k.shape * o->slope[1][i] + k.pull * o->slope[0][i];
    o->slope[0][i] = k.bulk * o->slope[0][i] + k.soft * k.pull * dp;
    o->slope[1][i] = k.soft * k.shape * dp;
  }
}

static void add_tangent(void *context, const sdr_pair *pair)
{
  const times_call *call = context;
  const sdr_ordinary *o = call->o;
  const shape at = shape_of(o, pair, call->u);
  const half i = half_of(o, pair, &at, SDR_LOST_I), j = half_of(o, pair, &at, SDR_LOST_J);
  double dv[3];
  const double ds = change(call, pair, &at, dv), force = pull_of(o, pair, &i, &j, at.s);
  if (!(at.l > 0.0)) return;
  const double stiff = i.p * o->slope[0][pair->i] + j.p * o->slope[0][pair->j] +
                       i.q * (o->across[pair->i] * ds + o->slope[1][pair->i] * at.s) +
                       j.q * (o->across[pair->j] * ds + o->slope[1][pair->j] * at.s);
  for (int a = 0; a < o->body.head.points->components; ++a) {
    const double turned = dv[a] - pair->length * ds * at.n[a];
    const double k = (stiff * at.n[a] + force / at.l * turned) / pair->length;
    call->out[a][pair->i] -= k;
    if (!pair->loose) call->out[a][pair->j] += k;
  }
}

static void tangent_of_stripe(void *context, int s)
{
  const times_call *call = context;
  sdr_bonds_visit_stripe(call->o->body.bonds, call->o->body.head.points, s, add_tangent, context);
}

sdr_status sdr_ordinary_tangent_times(sdr_model *model, double *const u[3], double *const v[3],
                                      double *const out[3])
{
  sdr_ordinary *o = (sdr_ordinary *)model;
  const sdr_points *points = model->points;
  times_call call = {o, u, v, out};
  for (int k = 0; k < 2; ++k) {
    if (!o->slope[k] && !(o->slope[k] = sdr_alloc(sdr_points_padded(points), sizeof(double))))
      return SDR_RUN_FAILED;
    memset(o->slope[k], 0, (size_t)points->count * sizeof(double));
  }
  prepare(o, u);
  sdr_each_stripe(points, sums_of_stripe, &call);
  change_coefficients(o);
  for (int a = 0; a < points->components; ++a)
    memset(out[a], 0, (size_t)points->count * sizeof(double));
  sdr_each_stripe(points, tangent_of_stripe, &call);
  return SDR_OK;
}

/* ---- diagonal blocks ------------------------------------------------------------------------- */

/* first, second: sum P n/|xi| and sum Q s n/|xi| of each point, `components` values a point. */
typedef struct {
  sdr_ordinary *o;
  double *const *u;
  double *first, *second, *out;
} diagonal_call;

static void sum_directions(void *context, const sdr_pair *pair)
{
  const diagonal_call *call = context;
  const sdr_ordinary *o = call->o;
  const int n = o->body.head.points->components;
  const shape at = shape_of(o, pair, call->u);
  const half i = half_of(o, pair, &at, SDR_LOST_I), j = half_of(o, pair, &at, SDR_LOST_J);
  for (int a = 0; a < 3 && a < n; ++a) {
    const double direction = at.n[a] / pair->length;
    call->first[pair->i * (int64_t)n + a] -= i.p * direction;
    call->second[pair->i * (int64_t)n + a] -= i.q * at.s * direction;
    if (pair->loose) continue;
    call->first[pair->j * (int64_t)n + a] += j.p * direction;
    call->second[pair->j * (int64_t)n + a] += j.q * at.s * direction;
  }
}

/* block += factor v (x) v + spread I */
static void add_block(int n, double factor, const double *v, double spread, double *block)
{
  for (int a = 0; a < n; ++a)
    for (int c = 0; c < n; ++c) block[a * n + c] += factor * v[a] * v[c] + (a == c ? spread : 0.0);
}

/* What the energy of a neighbour adds to the block of the other end of its bond, over n (x) n. */
static double from_neighbour(const curvature *k, const half *of, double s)
{
  const double d = k->shape * of->q * s + k->pull * of->p;
  return k->bulk * of->p * of->p + k->soft * d * d;
}

static void diagonal_of_pair(void *context, const sdr_pair *pair)
{
  const diagonal_call *call = context;
  const sdr_ordinary *o = call->o;
  const int n = o->body.head.points->components;
  const shape at = shape_of(o, pair, call->u);
  if (!(at.l > 0.0)) return;
  const half i = half_of(o, pair, &at, SDR_LOST_I), j = half_of(o, pair, &at, SDR_LOST_J);
  const double turning = pull_of(o, pair, &i, &j, at.s) / (at.l * pair->length);
  const double square = pair->length * pair->length;
  const double own = (i.q * o->across[pair->i] + j.q * o->across[pair->j]) / square - turning;
  const curvature ki = curvature_of(o, pair->i), kj = curvature_of(o, pair->j);
  add_block(n, own + from_neighbour(&kj, &j, at.s) / square, at.n, turning,
            call->out + pair->i * (int64_t)(n * n));
  if (!pair->loose)
    add_block(n, own + from_neighbour(&ki, &i, at.s) / square, at.n, turning,
              call->out + pair->j * (int64_t)(n * n));
}

static void diagonal_of_point(const diagonal_call *call, int32_t i)
{
  const int n = call->o->body.head.points->components;
  const curvature k = curvature_of(call->o, i);
  const double *first = call->first + i * (int64_t)n, *second = call->second + i * (int64_t)n;
  double d[3] = {0.0}, *block = call->out + i * (int64_t)(n * n);
  for (int a = 0; a < n; ++a) d[a] = k.shape * second[a] + k.pull * first[a];
  add_block(n, k.bulk, first, 0.0, block);
  add_block(n, k.soft, d, 0.0, block);
}

sdr_status sdr_ordinary_tangent_diagonal(sdr_model *model, double *const u[3], double *out)
{
  sdr_ordinary *o = (sdr_ordinary *)model;
  const sdr_points *points = model->points;
  const size_t n = (size_t)points->components, count = (size_t)points->count;
  double *sums = sdr_alloc(2 * n * count, sizeof *sums);
  if (!sums) return SDR_RUN_FAILED;
  const diagonal_call call = {o, u, sums, sums + n * count, out};
  memset(out, 0, n * n * count * sizeof *out);
  prepare(o, u);
  sdr_bonds_visit(o->body.bonds, points, sum_directions, (void *)(uintptr_t)&call);
  sdr_bonds_visit(o->body.bonds, points, diagonal_of_pair, (void *)(uintptr_t)&call);
  for (int32_t i = 0; i < points->count; ++i) diagonal_of_point(&call, i);
  sdr_free(sums);
  return SDR_OK;
}

/* ---- Hessian --------------------------------------------------------------------------------- */

/* A half that point i owns and has not lost. */
typedef struct {
  int32_t j;
  double weight, xi[3];
} member;

typedef struct {
  const sdr_ordinary *o;
  double *const *u;
  int secant;   /* 1: damage stays, and forces do not turn */
  int64_t *row; /* count + 1: family of i is member[row[i]] .. member[row[i + 1] - 1] */
  int64_t *next;
  member *member; /* NULL: count only, into row[i + 1] */
} families;

static void add_member(families *all, int32_t i, int32_t j, double weight, double sign,
                       const double xi[3])
{
  if (!(weight > 0.0)) return;
  if (!all->member) {
    ++all->row[i + 1];
    return;
  }
  all->member[all->next[i]++] = (member){j, weight, {sign * xi[0], sign * xi[1], sign * xi[2]}};
}

static void gather_pair(void *context, const sdr_pair *pair)
{
  families *all = context;
  const shape at = shape_of(all->o, pair, all->u);
  if (!(at.lost & SDR_LOST_I)) add_member(all, pair->i, pair->j, pair->weight_ij, 1.0, pair->xi);
  if (!(at.lost & SDR_LOST_J) && !pair->loose)
    add_member(all, pair->j, pair->i, pair->weight_ji, -1.0, pair->xi);
}

static sdr_status gather(families *all)
{
  const sdr_points *points = all->o->body.head.points;
  const size_t count = (size_t)points->count;
  all->row = sdr_alloc(count + 1, sizeof *all->row);
  all->next = sdr_alloc(count, sizeof *all->next);
  if (!all->row || !all->next) return SDR_RUN_FAILED;
  sdr_bonds_visit(all->o->body.bonds, points, gather_pair, all);
  for (size_t i = 0; i < count; ++i) all->row[i + 1] += all->row[i];
  memcpy(all->next, all->row, count * sizeof *all->next);
  all->member = sdr_alloc((size_t)all->row[count], sizeof *all->member);
  if (!all->member) return SDR_RUN_FAILED;
  sdr_bonds_visit(all->o->body.bonds, points, gather_pair, all);
  return SDR_OK;
}

/* The dense Hessian of one point's energy: point i first, then its family. first and second: sums
   of P and of D times the derivative of each stretch by the displacements. */
typedef struct {
  int points, size; /* size: components times points */
  int32_t *point;
  double *block, *first, *second;
} element;

/* Member k's own terms, and its part of first and second. */
static void add_to_element(const families *all, int32_t i, const curvature *of, const member *m,
                           int k, element *e)
{
  const sdr_ordinary *o = all->o;
  const int n = o->body.head.points->components;
  sdr_pair pair = {.i = i, .j = m->j, .weight_ij = m->weight};
  double square = 0.0;
  for (int a = 0; a < n; ++a) {
    pair.xi[a] = m->xi[a];
    square += m->xi[a] * m->xi[a];
  }
  pair.length = sqrt(square);
  shape at = {0};
  at.s = sdr_pair_stretch(&pair, n, all->u);
  for (int a = 0; a < n; ++a) {
    at.n[a] = m->xi[a] + all->u[a][m->j] - all->u[a][i];
    at.l += at.n[a] * at.n[a];
  }
  at.l = sqrt(at.l);
  e->point[k + 1] = m->j;
  if (!(at.l > 0.0)) return;
  const double p = sdr_ordinary_p(o, &pair, m->weight), q = sdr_ordinary_q(o, &pair, m->weight);
  const double pull = all->secant ? 0.0 : p * o->along[i] + q * o->across[i] * at.s;
  const double turning = pull / (at.l * pair.length);
  const double stiff = q * o->across[i] / square - turning;
  const double d = of->shape * q * at.s + of->pull * p;
  const int near = n * (k + 1);
  for (int a = 0; a < n; ++a) at.n[a] /= at.l;
  for (int a = 0; a < n; ++a) {
    const double slope = at.n[a] / pair.length;
    e->first[near + a] += p * slope;
    e->first[a] -= p * slope;
    e->second[near + a] += d * slope;
    e->second[a] -= d * slope;
    for (int c = 0; c < n; ++c) {
      const double value = stiff * at.n[a] * at.n[c] + (a == c ? turning : 0.0);
      e->block[(near + a) * e->size + near + c] += value;
      e->block[a * e->size + c] += value;
      e->block[(near + a) * e->size + c] -= value;
      e->block[a * e->size + near + c] -= value;
    }
  }
}

static void element_of_point(const families *all, int32_t i, element *e)
{
  const int n = all->o->body.head.points->components;
  const int count = (int)(all->row[i + 1] - all->row[i]);
  curvature of = curvature_of(all->o, i);
  if (all->secant) of.soft = 0.0;
  e->points = count + 1;
  e->size = n * e->points;
  const size_t size = (size_t)e->size;
  memset(e->block, 0, size * size * sizeof(double));
  memset(e->first, 0, size * sizeof(double));
  memset(e->second, 0, size * sizeof(double));
  e->point[0] = i;
  for (int k = 0; k < count; ++k) add_to_element(all, i, &of, &all->member[all->row[i] + k], k, e);
  for (int a = 0; a < e->size; ++a)
    for (int c = 0; c < e->size; ++c)
      e->block[a * e->size + c] +=
          of.bulk * e->first[a] * e->first[c] + of.soft * e->second[a] * e->second[c];
}

static sdr_status visit_elements(const families *all, sdr_hessian_visitor visit, void *context)
{
  const sdr_points *points = all->o->body.head.points;
  int64_t most = 0;
  for (int32_t i = 0; i < points->count; ++i)
    if (all->row[i + 1] - all->row[i] > most) most = all->row[i + 1] - all->row[i];
  const size_t size = (size_t)points->components * (size_t)(most + 1);
  element e = {.point = sdr_alloc((size_t)most + 1, sizeof *e.point),
               .block = sdr_alloc(size * size, sizeof *e.block),
               .first = sdr_alloc(size, sizeof *e.first),
               .second = sdr_alloc(size, sizeof *e.second)};
  const int failed = !e.point || !e.block || !e.first || !e.second;
  for (int32_t i = 0; !failed && i < points->count; ++i) {
    if (all->row[i + 1] == all->row[i]) continue;
    element_of_point(all, i, &e);
    visit(context, e.points, e.point, e.block);
  }
  sdr_free(e.point);
  sdr_free(e.block);
  sdr_free(e.first);
  sdr_free(e.second);
  return failed ? SDR_RUN_FAILED : SDR_OK;
}

static sdr_status visit(sdr_model *model, double *const u[3], int secant,
                        sdr_hessian_visitor visitor, void *context)
{
  sdr_ordinary *o = (sdr_ordinary *)model;
  families all = {.o = o, .u = u, .secant = secant};
  prepare(o, u);
  sdr_status status = gather(&all);
  if (status == SDR_OK) status = visit_elements(&all, visitor, context);
  sdr_free(all.row);
  sdr_free(all.next);
  sdr_free(all.member);
  return status;
}

sdr_status sdr_ordinary_visit_hessian(sdr_model *model, double *const u[3],
                                      sdr_hessian_visitor visitor, void *context)
{
  return visit(model, u, 0, visitor, context);
}

/* At fixed damage a point's energy is a sum of squares of its stretches. */
sdr_status sdr_ordinary_visit_secant(sdr_model *model, double *const u[3],
                                     sdr_hessian_visitor visitor, void *context)
{
  return visit(model, u, 1, visitor, context);
}
