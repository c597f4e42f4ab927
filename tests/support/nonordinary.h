/* Non-ordinary bodies for tests, and their equations over all pairs of points, plainly: what the
   kernels are compared with. */
#ifndef SDR_TESTS_NONORDINARY_H
#define SDR_TESTS_NONORDINARY_H

#include "mechanics/state_based.h"
#include "mechanics/state_body.h"
#include "mechanics/stress.h"
#include "support/body.h"

typedef struct {
  body_how shape; /* its law, dimension, weight, scatter and storage hold too */
  sdr_elasticity elasticity;
  sdr_split split;
  double poisson; /* 0: 0.3; of the second material 0.2 */
  double strain;  /* uniaxial strain at which d = 1/2 (variational) or bonds break; 0: 0.01 */
  int no_control; /* 1: P_s = P_n = 0 */
  sdr_length ell; /* value 0: the band */
} nonordinary_how;

typedef struct {
  nonordinary_how how;
  body shape; /* its model is the non-ordinary one */
  double poisson[2], toughness[2];
} nonordinary;

static inline sdr_state_based_how nonordinary_model_how(const nonordinary *b)
{
  return (sdr_state_based_how){.dimension = b->how.shape.dimension,
                               .law = b->how.shape.law,
                               .ell = b->how.ell,
                               .elasticity = b->how.elasticity,
                               .split = b->how.split,
                               .control_shear = b->how.no_control ? 0.0 : (double)NAN,
                               .control_normal = b->how.no_control ? 0.0 : (double)NAN,
                               .young = b->shape.young,
                               .poisson = b->poisson,
                               .toughness = b->toughness};
}

/* Gc so that psi+ = Gc/ell, where d = 1/2, at the given strain; or that bonds break there. */
static inline void nonordinary_toughness(nonordinary *b)
{
  const double strain = b->how.strain > 0.0 ? b->how.strain : 0.01;
  const sdr_dimension dimension = b->how.shape.dimension;
  const double ell = sdr_state_ell(b->shape.points, &b->how.ell, 0);
  const double unit = sdr_state_threshold(
      dimension, sdr_state_bulk(dimension, body_young, b->poisson[0]),
      sdr_state_shear(dimension, body_young, b->poisson[0]), 1.0, b->shape.points->horizon[0]);
  b->toughness[0] = b->how.shape.law == SDR_LAW_VARIATIONAL
                        ? 0.5 * body_young * strain * strain * ell
                        : strain * strain / unit;
  b->toughness[1] = 3.0 * b->toughness[0];
}

static inline nonordinary nonordinary_create_of(const nonordinary_how *how, sdr_points *points)
{
  nonordinary b = {.how = *how};
  b.shape.how = how->shape;
  b.shape.points = points;
  b.poisson[0] = how->poisson > 0.0 ? how->poisson : 0.3;
  b.poisson[1] = 0.2;
  assert_int_equal(sdr_families_create(points, &how->shape.weight, &b.shape.families), SDR_OK);
  b.shape.young = sdr_alloc(sdr_points_padded(points), sizeof(double));
  uint64_t seed = 977;
  for (int32_t i = 0; i < points->count; ++i)
    b.shape.young[i] = body_young * (1.0 + how->shape.scatter * noise(&seed)) *
                       (points->material[i] == 1 ? 0.5 : 1.0);
  nonordinary_toughness(&b);
  const sdr_bonds_how bonds_how = {.force_loose = how->shape.force_loose,
                                   .in_order = 1,
                                   .weight = sdr_families_weight,
                                   .context = b.shape.families,
                                   .bulk = b.shape.families->bulk};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(points, &bonds_how, &bonds), SDR_OK);
  const sdr_state_based_how model_how = nonordinary_model_how(&b);
  if (sdr_nonordinary_create(points, bonds, &model_how, &b.shape.model) != SDR_OK)
    fail_msg("%s", sdr_error_message());
  b.shape.bonds = bonds;
  return b;
}

static inline nonordinary nonordinary_create(const nonordinary_how *how)
{
  return nonordinary_create_of(how, body_points(&how->shape, NULL));
}

static inline void nonordinary_destroy(nonordinary *b)
{
  body_destroy(&b->shape);
}

/* ---- the equations, plainly ------------------------------------------------------------------ */

typedef struct {
  const nonordinary *of;
  double *history;
  char *lost; /* directed bonds i -> j that are cut, count x count */
} plain_body;

static inline plain_body plain_create(const nonordinary *of)
{
  const size_t count = (size_t)of->shape.points->count;
  return (plain_body){of, sdr_alloc(count, sizeof(double)), sdr_alloc(count * count, 1)};
}

static inline void plain_destroy(plain_body *plain)
{
  sdr_free(plain->history);
  sdr_free(plain->lost);
}

/* omega V_j of the directed bond i -> j, and xi; 0: not in the family. */
static inline double plain_weight(const plain_body *plain, int32_t i, int32_t j, double xi[3])
{
  const sdr_points *points = plain->of->shape.points;
  double square = 0.0;
  for (int a = 0; a < 3; ++a) {
    xi[a] = a < points->components ? points->x[a][j] - points->x[a][i] : 0.0;
    square += xi[a] * xi[a];
  }
  if (i == j || square > points->horizon[i] * points->horizon[i] * (1.0 + 1e-9)) return 0.0;
  if (plain->lost[(size_t)i * (size_t)points->count + (size_t)j]) return 0.0;
  const double b = sdr_families_weight(plain->of->shape.families, i, j, xi);
  return b * points->volume[j];
}

/* A point: F - I, K^-1, m, and the sums of the control. */
typedef struct {
  double g[9], inverse[9], m, s[9], control; /* W_s without (1-d)^2 */
  double p_shear, p_normal;
  sdr_point_stress stress;
} plain_point;

/* Inverse by Gauss without pivots: K is positive definite. */
static inline void plain_invert(int n, const double *k, double *out)
{
  double a[9], b[9] = {0.0};
  memcpy(a, k, sizeof a);
  for (int r = 0; r < n; ++r) b[r * n + r] = 1.0;
  for (int p = 0; p < n; ++p) {
    const double pivot = a[p * n + p];
    for (int c = 0; c < n; ++c) {
      a[p * n + c] /= pivot;
      b[p * n + c] /= pivot;
    }
    for (int r = 0; r < n; ++r) {
      const double factor = a[r * n + p];
      for (int c = 0; r != p && c < n; ++c) {
        a[r * n + c] -= factor * a[p * n + c];
        b[r * n + c] -= factor * b[p * n + c];
      }
    }
  }
  memcpy(out, b, sizeof b);
}

/* eta, z and the unit vector of the control. */
static inline void plain_residual(const plain_body *plain, const plain_point *at, int32_t i,
                                  int32_t j, const double xi[3], double *const u[3], double eta[3],
                                  double z[3], double normal[3], double *length)
{
  const int n = plain->of->shape.points->components;
  double square = 0.0;
  for (int a = 0; a < n; ++a) {
    double p = 0.0;
    for (int b = 0; b < n; ++b) p += at->g[n * a + b] * xi[b];
    eta[a] = u[a][j] - u[a][i];
    z[a] = eta[a] - p;
    normal[a] = xi[a] + (plain->of->how.elasticity == SDR_LINEAR ? 0.0 : p);
    square += normal[a] * normal[a];
  }
  *length = sqrt(square);
  for (int a = 0; a < n; ++a) normal[a] /= *length;
}

static inline void plain_gradient(const plain_body *plain, int32_t i, double *const u[3],
                                  plain_point *at)
{
  const sdr_points *points = plain->of->shape.points;
  const int n = points->components;
  double k[9] = {0.0}, m[9] = {0.0}, xi[3];
  *at = (plain_point){.m = 0.0};
  for (int32_t j = 0; j < points->count; ++j) {
    const double w = plain_weight(plain, i, j, xi);
    for (int a = 0; w > 0.0 && a < n; ++a) {
      at->m += w * xi[a] * xi[a];
      for (int b = 0; b < n; ++b) {
        k[n * a + b] += w * xi[a] * xi[b];
        m[n * a + b] += w * (u[a][j] - u[a][i]) * xi[b];
      }
    }
  }
  plain_invert(n, k, at->inverse);
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b)
      for (int c = 0; c < n; ++c) at->g[n * a + b] += m[n * a + c] * at->inverse[n * c + b];
}

/* P_s and P_n of theory sec. 11. */
static inline void plain_control(const nonordinary *of, int32_t i, double *p_shear,
                                 double *p_normal)
{
  const sdr_points *points = of->shape.points;
  const sdr_dimension dimension = of->how.shape.dimension;
  const double e = of->shape.young[i], nu = of->poisson[points->material[i]];
  const int n = points->components;
  const double mu = dimension == SDR_1D ? e / 3.0 : e / (2.0 * (1.0 + nu));
  const double d = dimension == SDR_1D ? e
                   : dimension == SDR_PLANE_STRESS
                       ? e / (1.0 - nu * nu)
                       : e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
  *p_shear = of->how.no_control ? 0.0 : fmax(0.1 * e, n * (5.0 * mu - d) / 3.0);
  *p_normal = of->how.no_control ? 0.0 : n * (n + 4) * (d - mu) / 3.0;
}

static inline void plain_state(const plain_body *plain, int32_t i, double *const u[3],
                               plain_point *at)
{
  const nonordinary *of = plain->of;
  const sdr_points *points = of->shape.points;
  const int n = points->components, linear = of->how.elasticity == SDR_LINEAR;
  double xi[3], eta[3], z[3], normal[3], length;
  plain_gradient(plain, i, u, at);
  plain_control(of, i, &at->p_shear, &at->p_normal);
  for (int32_t j = 0; j < points->count; ++j) {
    const double w = plain_weight(plain, i, j, xi);
    if (!(w > 0.0)) continue;
    plain_residual(plain, at, i, j, xi, u, eta, z, normal, &length);
    double along = 0.0, square = 0.0;
    for (int a = 0; a < n; ++a) {
      along += z[a] * normal[a];
      square += z[a] * z[a];
    }
    at->control += 0.5 * w / at->m * (at->p_shear * square + at->p_normal * along * along);
    /* d/dF of 1/2 (z.n)^2: z falls by dF xi, n turns by (I - n n) dF xi/|F xi| */
    for (int a = 0; a < n; ++a) {
      const double turn = linear ? 0.0 : (z[a] - along * normal[a]) / length;
      for (int b = 0; b < n; ++b) at->s[n * a + b] += w * along * (turn - normal[a]) * xi[b];
    }
  }
  const sdr_moduli moduli = sdr_moduli_of(of->how.shape.dimension, of->how.elasticity,
                                          of->shape.young[i], of->poisson[points->material[i]]);
  const int split = of->how.shape.law == SDR_LAW_VARIATIONAL ? (int)of->how.split : SDR_SPLIT_WHOLE;
  sdr_stress_of(n, of->how.elasticity, split, &moduli, at->g, &at->stress);
}

/* ell of the point, as the body has it. */
static inline double plain_ell(const plain_body *plain, int32_t i)
{
  double ell, threshold;
  sdr_state_constants(plain->of->shape.model, i, &ell, &threshold);
  return ell;
}

/* Damage at a state whose psi+ is `plus`. */
static inline double plain_damage(const plain_body *plain, int32_t i, double plus)
{
  const nonordinary *of = plain->of;
  if (of->how.shape.law != SDR_LAW_VARIATIONAL) return 0.0;
  const double h = fmax(plain->history[i], plus);
  const double cost = of->toughness[of->shape.points->material[i]] / plain_ell(plain, i);
  return h / (h + cost);
}

static inline void plain_add_force(const plain_body *plain, int32_t i, const plain_point *at,
                                   double intact, double *const u[3], double *const f[3])
{
  const sdr_points *points = plain->of->shape.points;
  const int n = points->components;
  double bearing[9] = {0.0}, xi[3], eta[3], z[3], normal[3], length;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b)
      for (int c = 0; c < n; ++c)
        bearing[n * a + b] +=
            (intact * at->stress.p_plus[n * a + c] + at->stress.p_minus[n * a + c] +
             intact * at->p_normal / at->m * at->s[n * a + c]) *
            at->inverse[n * c + b];
  for (int32_t j = 0; j < points->count; ++j) {
    const double w = plain_weight(plain, i, j, xi);
    if (!(w > 0.0)) continue;
    plain_residual(plain, at, i, j, xi, u, eta, z, normal, &length);
    double along = 0.0;
    for (int a = 0; a < n; ++a) along += z[a] * normal[a];
    for (int a = 0; a < n; ++a) {
      double t = intact / at->m * (at->p_shear * z[a] + at->p_normal * along * normal[a]);
      for (int b = 0; b < n; ++b) t += bearing[n * a + b] * xi[b];
      f[a][i] += w * points->volume[i] * t;
      f[a][j] -= w * points->volume[i] * t;
    }
  }
}

/* Force (N) and energies (J) at u; `commit`: the history takes u in. */
static inline void plain_force(plain_body *plain, double *const u[3], double *const f[3],
                               sdr_energies *energies, int commit)
{
  const nonordinary *of = plain->of;
  const sdr_points *points = of->shape.points;
  *energies = (sdr_energies){.stored = 0.0};
  for (int a = 0; a < points->components; ++a)
    memset(f[a], 0, (size_t)points->count * sizeof(double));
  for (int32_t i = 0; i < points->count; ++i) {
    plain_point at;
    plain_state(plain, i, u, &at);
    const double plus = at.stress.plus + at.control, d = plain_damage(plain, i, plus);
    const double intact = (1.0 - d) * (1.0 - d);
    plain_add_force(plain, i, &at, intact, u, f);
    energies->stored += points->volume[i] * (intact * plus + at.stress.minus);
    if (of->how.shape.law != SDR_LAW_VARIATIONAL) continue;
    energies->dissipated +=
        points->volume[i] * d * d * of->toughness[points->material[i]] / plain_ell(plain, i);
    if (commit) plain->history[i] = fmax(plain->history[i], plus);
  }
}

/* The same marks on the model and here: SDR_CUT only. */
static inline void plain_mark(plain_body *plain, sdr_pair_mark mark)
{
  const sdr_points *points = plain->of->shape.points;
  int64_t cut = 0;
  if (plain->of->shape.model->ops->mark(plain->of->shape.model, mark, NULL, &cut) != SDR_OK)
    fail_msg("%s", sdr_error_message());
  assert_true(cut > 0);
  for (int32_t i = 0; i < points->count; ++i)
    for (int32_t j = 0; j < points->count; ++j) {
      double a[3] = {0.0}, b[3] = {0.0};
      for (int c = 0; c < points->components; ++c) {
        a[c] = points->x[c][i];
        b[c] = points->x[c][j];
      }
      if (i != j && mark(NULL, a, b) == SDR_CUT)
        plain->lost[(size_t)i * (size_t)points->count + (size_t)j] = 1;
    }
}

#endif
