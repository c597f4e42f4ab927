/* The equations of theory sec. 1-4 over all pairs of points, plainly and in long double: what the
   fast kernels are compared with. */
#ifndef SDR_TESTS_REFERENCE_H
#define SDR_TESTS_REFERENCE_H

#include "support/body.h"

typedef struct {
  const body *body;
  float *stretch;     /* k of the pair (i, j), count x count; committed */
  char *lost;         /* directed bond i -> j lost for good (critical stretch) */
  char *mark;         /* SDR_CUT, SDR_PROTECTED or 0 */
  double *c, *q, *a;  /* constants of each point; a: s0^2/s_e^2 of cohesive */
  long double booked; /* energy of lost directed bonds, as commit books it: at their stretch then */
  double farthest;    /* above every horizon, m */
  int without_dual;   /* 1: leave out what the dual horizon adds */
} reference;

static inline reference reference_create(const body *b)
{
  const size_t n = (size_t)b->points->count;
  reference r = {.body = b,
                 .stretch = sdr_alloc(n * n, sizeof(float)),
                 .lost = sdr_alloc(n * n, 1),
                 .mark = sdr_alloc(n * n, 1),
                 .c = sdr_alloc(n, sizeof(double)),
                 .q = sdr_alloc(n, sizeof(double)),
                 .a = sdr_alloc(n, sizeof(double))};
  for (int32_t i = 0; i < b->points->count; ++i) {
    r.c[i] = body_micromodulus(b, i);
    r.q[i] = body_threshold(b, i);
    if (b->how.law == SDR_LAW_COHESIVE) r.a[i] = body_critical(b, i) / (r.q[i] * r.q[i]);
    r.farthest = fmax(r.farthest, 1.001 * b->points->horizon[i]);
  }
  return r;
}

static inline void reference_destroy(reference *r)
{
  sdr_free(r->stretch);
  sdr_free(r->lost);
  sdr_free(r->mark);
  sdr_free(r->c);
  sdr_free(r->q);
  sdr_free(r->a);
}

/* One pair at u: xi, y = xi + eta, their lengths, and the stretch. */
typedef struct {
  long double y[3], length, l, s;
  double xi[3];
} reference_pair;

static inline reference_pair reference_kinematics(const sdr_points *points, double *const u[3],
                                                  int32_t i, int32_t j)
{
  reference_pair p = {0};
  long double xx = 0.0L, yy = 0.0L, difference = 0.0L;
  for (int a = 0; a < points->components; ++a) {
    const long double xi = (long double)points->x[a][j] - (long double)points->x[a][i];
    const long double eta = (long double)u[a][j] - (long double)u[a][i];
    p.xi[a] = (double)xi;
    p.y[a] = xi + eta;
    xx += xi * xi;
    yy += p.y[a] * p.y[a];
    difference += eta * (2.0L * xi + eta);
  }
  p.length = sqrtl(xx);
  p.l = sqrtl(yy);
  p.s = difference / (p.length * (p.l + p.length)); /* (l^2 - xi^2)/(xi (l + xi)) */
  return p;
}

/* 1 if no horizon can join i and j: all pairs are looked at, but most end here. */
static inline int reference_far(const reference *r, int32_t i, int32_t j)
{
  const sdr_points *points = r->body->points;
  for (int a = 0; a < points->components; ++a)
    if (fabs(points->x[a][j] - points->x[a][i]) > r->farthest) return 1;
  return i == j;
}

static inline int reference_in_family(const sdr_points *points, int32_t i, const double xi[3])
{
  const double square = xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2];
  return square <= points->horizon[i] * points->horizon[i] * (1.0 + 1e-9);
}

/* Force C (...) s of the directed bond i -> j, and its energies, per volume squared. */
typedef struct {
  long double force, stored, dissipated;
} reference_law;

/* What is left of the stiffness after a largest stretch k, and what that has dissipated over
   C |xi|. Cohesive: force over C s_e is a line from (1, 1) to (mu, gamma) and one to (x_f, 0). */
typedef struct {
  long double left, dissipated;
} reference_softening;

static inline reference_softening reference_cohesive(long double k, long double s_e, long double a)
{
  const long double x = k / s_e, mu = 1.25L, last = 1.0L + (a - mu) / 0.5L;
  const long double first = x < mu ? x : mu, second = x < last ? x : last;
  if (x <= 1.0L) return (reference_softening){1.0L, 0.0L};
  long double force = 1.0L - 2.0L * (first - 1.0L);
  long double work = 0.5L + 0.5L * (1.0L + force) * (first - 1.0L);
  if (x > mu) {
    force = 0.5L * (last - second) / (last - mu);
    work += 0.5L * (0.5L + force) * (second - mu);
  }
  return (reference_softening){force / x, s_e * s_e * (work - 0.5L * force * x)};
}

static inline reference_softening reference_soften(const reference *r, int32_t i, long double k)
{
  const long double q = (long double)r->q[i];
  if (r->body->how.law == SDR_LAW_COHESIVE) return reference_cohesive(k, q, (long double)r->a[i]);
  if (r->body->how.law == SDR_LAW_AT1) {
    const long double d = 2.0L * k * k > q ? 1.0L - 0.5L * q / (k * k) : 0.0L;
    return (reference_softening){(1.0L - d) * (1.0L - d), 0.5L * q * d};
  }
  const long double d = k * k / (k * k + q);
  return (reference_softening){(1.0L - d) * (1.0L - d), 0.5L * q * d * d};
}

static inline reference_law reference_directed(const reference *r, int32_t i, int32_t j,
                                               const reference_pair *p)
{
  const size_t slot = (size_t)i * (size_t)r->body->points->count + (size_t)j;
  const long double c = (long double)r->c[i], s = p->s;
  const long double w = 0.5L * c * p->length * s * s;
  const char mark = r->mark[slot];
  if (mark == SDR_CUT) return (reference_law){0.0L, 0.0L, 0.0L};
  if (mark == SDR_PROTECTED || r->body->how.law == SDR_LAW_NONE)
    return (reference_law){c * s, w, 0.0L};
  if (r->body->how.law == SDR_LAW_CRITICAL_STRETCH)
    return r->lost[slot] ? (reference_law){0.0L, 0.0L, 0.0L} : (reference_law){c * s, w, 0.0L};
  const long double now = (long double)(float)s, before = (long double)r->stretch[slot];
  const reference_softening soft = reference_soften(r, i, now > before ? now : before);
  const long double left = s > 0.0L ? soft.left : 1.0L;
  return (reference_law){c * left * s, left * w, c * p->length * soft.dissipated};
}

/* b V_i V_j of the directed bond i -> j; 0 if j is not in H_i. */
static inline long double reference_weight(const reference *r, int32_t i, int32_t j,
                                           const double xi[3])
{
  const sdr_points *points = r->body->points;
  if (!reference_in_family(points, i, xi)) return 0.0L;
  const double b = sdr_families_weight(r->body->families, i, j, xi);
  return (long double)b * (long double)points->volume[i] * (long double)points->volume[j];
}

static inline void reference_add(const reference *r, int32_t i, int32_t j, double *const u[3],
                                 long double *f, long double energy[2])
{
  const sdr_points *points = r->body->points;
  const reference_pair p = reference_kinematics(points, u, i, j);
  const long double v = reference_weight(r, i, j, p.xi);
  if (v <= 0.0L) return;
  const reference_law law = reference_directed(r, i, j, &p);
  energy[0] += v * law.stored;
  energy[1] += v * law.dissipated;
  for (int a = 0; a < points->components && p.l > 0.0L; ++a) {
    const long double force = v * law.force * p.y[a] / p.l;
    f[3 * i + a] += force;
    if (!r->without_dual) f[3 * j + a] -= force;
  }
}

/* Force (N) and energies (J) at u, with history = max(committed, present). */
static inline void reference_force(const reference *r, double *const u[3], double *const out[3],
                                   sdr_energies *energies)
{
  const sdr_points *points = r->body->points;
  long double energy[2] = {0.0L}, *f = calloc(3 * (size_t)points->count, sizeof *f);
  for (int32_t i = 0; i < points->count; ++i)
    for (int32_t j = 0; j < points->count; ++j)
      if (!reference_far(r, i, j)) reference_add(r, i, j, u, f, energy);
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) out[a][i] = (double)f[3 * i + a];
  if (energies)
    *energies =
        (sdr_energies){.stored = (double)energy[0], .dissipated = (double)(energy[1] + r->booked)};
  free(f);
}

static inline void reference_commit_bond(reference *r, int32_t i, int32_t j, double *const u[3])
{
  const size_t slot = (size_t)i * (size_t)r->body->points->count + (size_t)j;
  const reference_pair p = reference_kinematics(r->body->points, u, i, j);
  if ((float)p.s > r->stretch[slot]) r->stretch[slot] = (float)p.s;
  if (p.s <= 0.0L || p.s * p.s <= (long double)r->q[i] || r->lost[slot] ||
      r->mark[slot] == SDR_PROTECTED)
    return;
  r->lost[slot] = 1;
  if (r->body->how.law == SDR_LAW_CRITICAL_STRETCH && r->mark[slot] != SDR_CUT)
    r->booked +=
        0.5L * (long double)r->c[i] * p.length * p.s * p.s * reference_weight(r, i, j, p.xi);
}

static inline void reference_commit(reference *r, double *const u[3])
{
  const int32_t n = r->body->points->count;
  for (int32_t i = 0; i < n; ++i)
    for (int32_t j = 0; j < n; ++j)
      if (!reference_far(r, i, j)) reference_commit_bond(r, i, j, u);
}

/* The same marks on the model and here. */
static inline void reference_mark(reference *r, sdr_pair_mark mark)
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
      if (i != j) r->mark[(size_t)i * (size_t)points->count + (size_t)j] = (char)mark(NULL, a, b);
    }
}

#endif
