/* Ordinary state-based bodies for tests, and the equations of theory sec. 5 over all pairs of
   points, plainly and in long double. */
#ifndef SDR_TESTS_ORDINARY_H
#define SDR_TESTS_ORDINARY_H

#include "mechanics/state_based.h"
#include "mechanics/state_body.h"
#include "support/body.h"

/* body.stretch is s0 of the body without scatter (critical_stretch), or the strain at which its
   uniaxial energy is Gc/ell (variational). */
typedef struct {
  body_how body;
  double poisson; /* 0: 0.3 */
  sdr_ordinary_form form;
} ordinary_how;

static inline double ordinary_poisson(const ordinary_how *how)
{
  return how->poisson > 0.0 ? how->poisson : 0.3;
}

static inline sdr_model *ordinary_model(const ordinary_how *how, body *b)
{
  const sdr_bonds_how bonds_how = {.force_loose = how->body.force_loose,
                                   .weight = sdr_families_weight,
                                   .context = b->families,
                                   .bulk = b->families->bulk};
  sdr_bonds *bonds;
  sdr_model *model;
  assert_int_equal(sdr_bonds_create(b->points, &bonds_how, &bonds), SDR_OK);
  b->bonds = bonds;
  const double poisson[2] = {ordinary_poisson(how), 0.2};
  const sdr_state_based_how model_how = {.dimension = how->body.dimension,
                                         .law = how->body.law,
                                         .ell = {how->body.ell, 1},
                                         .form = how->form,
                                         .young = b->young,
                                         .poisson = poisson,
                                         .toughness = b->toughness};
  assert_int_equal(sdr_ordinary_create(b->points, bonds, &model_how, &model), SDR_OK);
  return model;
}

/* The model itself says what s0 or ell it makes of a toughness. */
static inline void ordinary_toughness(const ordinary_how *how, body *b)
{
  const double stretch = how->body.stretch > 0.0 ? how->body.stretch : 0.01;
  double ell, threshold;
  b->toughness[0] = b->toughness[1] = 1.0;
  if (how->body.law == SDR_LAW_NONE) return;
  sdr_model *model = ordinary_model(how, b);
  sdr_state_constants(model, 0, &ell, &threshold);
  model->ops->destroy(model);
  const double scattered = b->young[0] / body_young;
  b->toughness[0] = how->body.law == SDR_LAW_VARIATIONAL
                        ? 0.5 * body_young * stretch * stretch * ell
                        : stretch * stretch * scattered / threshold;
  b->toughness[1] = 3.0 * b->toughness[0];
}

static inline body ordinary_create(const ordinary_how *how)
{
  body b = {.how = how->body, .points = body_points(&how->body, NULL)};
  sdr_families_how weight = how->body.weight;
  weight.state_based = 1;
  assert_int_equal(sdr_families_create(b.points, &weight, &b.families), SDR_OK);
  body_materials(&b);
  ordinary_toughness(how, &b);
  b.model = ordinary_model(how, &b);
  return b;
}

/* ---- reference ------------------------------------------------------------------------------- */

typedef struct {
  const body *body;
  const ordinary_how *how;
  char *mark;           /* of the pair (i, j), count x count: SDR_CUT, SDR_PROTECTED or 0 */
  char *lost;           /* directed bond i -> j */
  long double *history; /* H of a point */
  double farthest;      /* above every horizon, m */
} plain;

static inline plain plain_create(const body *b, const ordinary_how *how)
{
  const size_t n = (size_t)b->points->count;
  plain r = {.body = b,
             .how = how,
             .mark = sdr_alloc(n * n, 1),
             .lost = sdr_alloc(n * n, 1),
             .history = sdr_alloc(n, sizeof(long double))};
  for (size_t i = 0; i < n; ++i) r.farthest = fmax(r.farthest, 1.001 * b->points->horizon[i]);
  return r;
}

static inline void plain_destroy(plain *r)
{
  sdr_free(r->mark);
  sdr_free(r->lost);
  sdr_free(r->history);
}

/* The same marks on the model and here. */
static inline void plain_mark(plain *r, sdr_pair_mark mark)
{
  const sdr_points *points = r->body->points;
  int64_t cut;
  assert_int_equal(r->body->model->ops->mark(r->body->model, mark, NULL, &cut), SDR_OK);
  assert_true(cut > 0);
  for (int32_t i = 0; i < points->count; ++i)
    for (int32_t j = 0; j < points->count; ++j) {
      double a[3] = {0.0}, b[3] = {0.0};
      for (int c = 0; c < points->components; ++c) {
        a[c] = points->x[c][i];
        b[c] = points->x[c][j];
      }
      r->mark[(size_t)i * (size_t)points->count + (size_t)j] = (char)mark(NULL, a, b);
    }
}

/* A directed bond i -> j at u: xi, y = xi + eta, their lengths, extension e, and omega V_j; weight
   0: j is not in the family. */
typedef struct {
  long double y[3], length, l, e, weight;
} plain_bond;

static inline plain_bond plain_any_bond(const plain *r, double *const u[3], int32_t i, int32_t j)
{
  const sdr_points *points = r->body->points;
  const size_t slot = (size_t)i * (size_t)points->count + (size_t)j;
  plain_bond b = {.weight = 0.0L};
  double xi[3] = {0.0}, square = 0.0;
  if (i == j || r->mark[slot] == SDR_CUT || fabs(points->x[0][j] - points->x[0][i]) > r->farthest)
    return b;
  for (int a = 0; a < points->components; ++a) {
    xi[a] = points->x[a][j] - points->x[a][i];
    square += xi[a] * xi[a];
  }
  if (square > points->horizon[i] * points->horizon[i] * (1.0 + 1e-9)) return b;
  long double difference = 0.0L;
  for (int a = 0; a < points->components; ++a) {
    const long double eta = (long double)u[a][j] - (long double)u[a][i];
    b.y[a] = (long double)xi[a] + eta;
    b.length += (long double)xi[a] * (long double)xi[a];
    b.l += b.y[a] * b.y[a];
    difference += eta * (2.0L * (long double)xi[a] + eta);
  }
  b.length = sqrtl(b.length);
  b.l = sqrtl(b.l);
  b.e = difference / (b.l + b.length);
  b.weight = (long double)sdr_families_weight(r->body->families, i, j, xi) *
             (long double)points->volume[j];
  return b;
}

static inline plain_bond plain_bond_at(const plain *r, double *const u[3], int32_t i, int32_t j)
{
  const int lost = r->lost[(size_t)i * (size_t)r->body->points->count + (size_t)j];
  return lost ? (plain_bond){.weight = 0.0L} : plain_any_bond(r, u, i, j);
}

/* What a point's energy needs: theta and the energy without 1/2 K theta^2. With s = e/|xi| the
   forms are theta = t sum p w s and B sum q w s^2 - A theta^2, w = omega V_j. Of lost bonds the
   stretches take what costs least: in B sum q w s^2 + (1/2 K - A) theta^2 they are minus t k (K -
   2A) theta p/(2 B q), so that theta is what the bonds left make of it over 1 + (K - 2A) t^2 R/(2
   B), R the sum of w p^2/q over lost ones. The energy then is (1/2 K - A') theta^2 of the theta of
   those left. */
typedef struct {
  long double m, lost, theta, shape, bulk, shear, n, t, a, b;
  int printed;
} plain_point;

static inline long double plain_p(const plain_point *p, const plain_bond *at)
{
  return p->printed ? 1.0L : at->length * at->length;
}
static inline long double plain_q(const plain_point *p, const plain_bond *at)
{
  return at->length * (p->printed ? 1.0L : at->length);
}

/* t, A and B of the whole family, then A of what is left. */
static inline void plain_constants(const plain *r, int32_t i, plain_point *p)
{
  const long double pi = 3.14159265358979323846264L;
  const long double delta = (long double)r->body->points->horizon[i]; /* thickness 1 m */
  p->t = p->printed ? 2.0L / (pi * delta * delta) : p->n / p->m;
  p->b = p->printed ? 6.0L * p->shear / (pi * delta * delta * delta)
                    : p->n * (p->n + 2.0L) * p->shear / (2.0L * p->m);
  p->a = p->printed ? p->shear : (p->n + 2.0L) * p->shear / (2.0L * p->n);
  const long double k = p->bulk - 2.0L * p->a;
  p->a = (p->bulk - k / (1.0L + k * p->t * p->t * p->lost / (2.0L * p->b))) / 2.0L;
}

static inline plain_point plain_point_at(const plain *r, double *const u[3], int32_t i)
{
  const body *b = r->body;
  const sdr_points *points = b->points;
  const sdr_dimension dimension = r->how->body.dimension;
  const double nu = b->points->material[i] ? 0.2 : ordinary_poisson(r->how);
  plain_point p = {.bulk = (long double)sdr_state_bulk(dimension, b->young[i], nu),
                   .shear = (long double)sdr_state_shear(dimension, b->young[i], nu),
                   .n = points->components,
                   .printed = r->how->form == SDR_FORM_MADENCI_OTERKUS};
  long double sum = 0.0L, square = 0.0L;
  for (int32_t j = 0; j < points->count; ++j) {
    const plain_bond any = plain_any_bond(r, u, i, j), at = plain_bond_at(r, u, i, j);
    if (!(any.weight > 0.0L)) continue;
    const long double s = any.e / any.length;
    const long double p_of = plain_p(&p, &any), q_of = plain_q(&p, &any);
    p.m += any.weight * any.length * any.length;
    if (!(at.weight > 0.0L)) p.lost += any.weight * p_of * p_of / q_of;
    sum += at.weight * p_of * s;
    square += at.weight * q_of * s * s;
  }
  if (!(p.m > 0.0L)) return p;
  plain_constants(r, i, &p);
  p.theta = p.t * sum;
  p.shape = p.b * square - p.a * p.theta * p.theta;
  return p;
}

/* d theta/de and d shape/de of a bond, over its weight. */
static inline void plain_slopes(const plain_point *p, const plain_bond *at, long double *theta,
                                long double *shape)
{
  *theta = p->t * plain_p(p, at) / at->length;
  *shape = 2.0L * p->b * plain_q(p, at) * at->e / (at->length * at->length) -
           2.0L * p->a * p->theta * *theta;
}

/* Force (N) and stored and dissipated energies (J) at u; history max(committed, present). */
static inline void plain_force(const plain *r, double *const u[3], double *const out[3],
                               long double energy[2])
{
  const sdr_points *points = r->body->points;
  long double *f = calloc(3 * (size_t)points->count, sizeof *f);
  energy[0] = energy[1] = 0.0L;
  for (int32_t i = 0; i < points->count; ++i) {
    const plain_point p = plain_point_at(r, u, i);
    const long double volume = (long double)points->volume[i];
    const long double volumetric = 0.5L * p.bulk * p.theta * p.theta;
    const long double plus = p.shape + (p.theta > 0.0L ? volumetric : 0.0L);
    const long double h = plus > r->history[i] ? plus : r->history[i];
    long double d = 0.0L;
    if (r->how->body.law == SDR_LAW_VARIATIONAL) {
      double ell, threshold;
      sdr_state_constants(r->body->model, i, &ell, &threshold);
      const long double g = (long double)r->body->toughness[points->material[i]] / (long double)ell;
      const int hard = r->mark[(size_t)i * (size_t)points->count + (size_t)i] == SDR_PROTECTED;
      d = hard ? 0.0L : h / (h + g);
      energy[1] += volume * g * d * d;
    }
    const long double left = (1.0L - d) * (1.0L - d);
    energy[0] += volume * (left * plus + (p.theta > 0.0L ? 0.0L : volumetric));
    for (int32_t j = 0; j < points->count; ++j) {
      const plain_bond at = plain_bond_at(r, u, i, j);
      if (!(at.weight > 0.0L) || !(at.l > 0.0L)) continue;
      long double theta, shape;
      plain_slopes(&p, &at, &theta, &shape);
      const long double t =
          left * shape + (p.theta > 0.0L ? left : 1.0L) * p.bulk * p.theta * theta;
      for (int a = 0; a < points->components; ++a) {
        const long double pull = volume * at.weight * t * at.y[a] / at.l;
        f[3 * i + a] += pull;
        f[3 * j + a] -= pull;
      }
    }
  }
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) out[a][i] = (double)f[3 * i + a];
  free(f);
}

/* Take u in: histories of points, bonds that break (critical_stretch). */
static inline void plain_commit(plain *r, double *const u[3])
{
  const sdr_points *points = r->body->points;
  const size_t count = (size_t)points->count;
  for (int32_t i = 0; i < points->count; ++i) {
    const plain_point p = plain_point_at(r, u, i);
    const long double plus = p.shape + (p.theta > 0.0L ? 0.5L * p.bulk * p.theta * p.theta : 0.0L);
    if (plus > r->history[i]) r->history[i] = plus;
  }
  char *broken = sdr_alloc(count * count, 1);
  for (int32_t i = 0; i < points->count && r->how->body.law == SDR_LAW_CRITICAL_STRETCH; ++i) {
    const double s0 = ((const sdr_state_body *)r->body->model)->threshold[i];
    for (int32_t j = 0; j < points->count; ++j) {
      const plain_bond at = plain_bond_at(r, u, i, j);
      const size_t slot = (size_t)i * count + (size_t)j;
      if (!(at.weight > 0.0L) || r->mark[slot] == SDR_PROTECTED) continue;
      const long double s = at.e / at.length;
      broken[slot] = s > 0.0L && s * s > (long double)s0;
    }
  }
  for (size_t slot = 0; slot < count * count; ++slot)
    r->lost[slot] = (char)(r->lost[slot] || broken[slot]);
  sdr_free(broken);
}

#endif
