/* Elastic moduli, the tangents of the laws of a point, and their small solvers. */
#include "mechanics/stress.h"

#include <string.h>

sdr_moduli sdr_moduli_of(sdr_dimension dimension, sdr_elasticity elasticity, double young,
                         double poisson)
{
  if (dimension == SDR_1D) return (sdr_moduli){0.0, 0.5 * young, 0};
  const double mu = 0.5 * young / (1.0 + poisson);
  const double lame = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
  if (dimension != SDR_PLANE_STRESS) return (sdr_moduli){lame, mu, 0};
  if (elasticity == SDR_NEO_HOOKEAN) return (sdr_moduli){lame, mu, 1};
  return (sdr_moduli){young * poisson / (1.0 - poisson * poisson), mu, 0};
}

/* P33 = 0: mu (a - 1) + lambda (L + ln a/2) = 0 for a = F33^2, in x = ln a: increasing and convex,
   so Newton from the right of the root, where the linear answer lies, falls onto it. */
static double log_thickness(const sdr_moduli *m, double l)
{
  double x = -m->lambda * l / (m->mu + 0.5 * m->lambda);
  for (int step = 0; step < 60; ++step) {
    const double rest = m->mu * expm1(x) + m->lambda * (l + 0.5 * x);
    const double change = rest / (m->mu * exp(x) + 0.5 * m->lambda);
    x -= change;
    if (fabs(change) <= 1e-15 * fabs(x)) break;
  }
  return x;
}

double sdr_thickness_stretch(const sdr_moduli *moduli, double log_volume)
{
  return exp(0.5 * log_thickness(moduli, log_volume));
}

double sdr_plane_thickness(sdr_elasticity elasticity, const sdr_moduli *moduli,
                           const double *gradient)
{
  double work[9];
  if (elasticity == SDR_NEO_HOOKEAN)
    return sdr_thickness_stretch(moduli,
                                 sdr_long_log(sdr_cofactors(2, gradient, work), SDR_LEAST_J).value);
  /* S33 = 0: E33 = -nu/(1 - nu) tr E, and lambda/(lambda + 2 mu) = nu as lambda is condensed */
  const double nu = moduli->lambda / (moduli->lambda + 2.0 * moduli->mu);
  sdr_strain_of(2, 1, gradient, work);
  return sqrt(fmax(1.0 - 2.0 * nu / (1.0 - nu) * sdr_trace(2, work), SDR_LEAST_J * SDR_LEAST_J));
}

sdr_function sdr_condensed_volume(const sdr_moduli *m, double l)
{
  const double x = log_thickness(m, l), sum = l + 0.5 * x;
  const double slope = -m->lambda / (m->mu * exp(x) + 0.5 * m->lambda); /* dx/dL */
  return (sdr_function){0.5 * m->mu * (expm1(x) - x) + 0.5 * m->lambda * sum * sum, m->lambda * sum,
                        m->lambda * (1.0 + 0.5 * slope)};
}

/* One Jacobi rotation of the plane p, q. */
static void rotate(double a[9], double v[9], int p, int q)
{
  const double off = a[3 * p + q];
  if (off == 0.0) return;
  const double theta = 0.5 * (a[3 * q + q] - a[3 * p + p]) / off;
  const double t = copysign(1.0, theta) / (fabs(theta) + sqrt(theta * theta + 1.0));
  const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
  for (int k = 0; k < 3; ++k) {
    const double kp = a[3 * k + p], kq = a[3 * k + q];
    a[3 * k + p] = c * kp - s * kq;
    a[3 * k + q] = s * kp + c * kq;
  }
  for (int k = 0; k < 3; ++k) {
    const double pk = a[3 * p + k], qk = a[3 * q + k], vp = v[3 * k + p], vq = v[3 * k + q];
    a[3 * p + k] = c * pk - s * qk;
    a[3 * q + k] = s * pk + c * qk;
    v[3 * k + p] = c * vp - s * vq;
    v[3 * k + q] = s * vp + c * vq;
  }
}

void sdr_eigen3(const double *matrix, double *e, double *v)
{
  double a[9];
  memcpy(a, matrix, sizeof a);
  for (int k = 0; k < 9; ++k) v[k] = k % 4 == 0 ? 1.0 : 0.0;
  for (int sweep = 0; sweep < 30; ++sweep) {
    const double off = a[1] * a[1] + a[2] * a[2] + a[5] * a[5];
    const double on = a[0] * a[0] + a[4] * a[4] + a[8] * a[8];
    if (!(off > 1e-34 * on)) break;
    rotate(a, v, 0, 1);
    rotate(a, v, 0, 2);
    rotate(a, v, 1, 2);
  }
  for (int k = 0; k < 3; ++k) e[k] = a[4 * k];
}

/* ---- stress with run-time laws --------------------------------------------------------------- */

#define SDR_ALL_SPLITS(n, elasticity)                                                              \
  if (split == SDR_SPLIT_WHOLE)                                                                    \
    sdr_stress_at(n, elasticity, SDR_SPLIT_WHOLE, moduli, gradient, out);                          \
  else if (split == SDR_SPLIT_SPECTRAL)                                                            \
    sdr_stress_at(n, elasticity, SDR_SPLIT_SPECTRAL, moduli, gradient, out);                       \
  else                                                                                             \
    sdr_stress_at(n, elasticity, SDR_SPLIT_DILATATION, moduli, gradient, out);

#define SDR_STRESS_IN(n)                                                                           \
  static void stress_in_##n(sdr_elasticity elasticity, int split, const sdr_moduli *moduli,        \
                            const double *gradient, sdr_point_stress *out)                         \
  {                                                                                                \
    if (elasticity == SDR_LINEAR) {                                                                \
      SDR_ALL_SPLITS(n, SDR_LINEAR)                                                                \
    } else if (elasticity == SDR_NEO_HOOKEAN) {                                                    \
      SDR_ALL_SPLITS(n, SDR_NEO_HOOKEAN)                                                           \
    } else {                                                                                       \
      SDR_ALL_SPLITS(n, SDR_SAINT_VENANT_KIRCHHOFF)                                                \
    }                                                                                              \
  }
SDR_STRESS_IN(1)
SDR_STRESS_IN(2)
SDR_STRESS_IN(3)

void sdr_stress_of(int n, sdr_elasticity elasticity, int split, const sdr_moduli *moduli,
                   const double *gradient, sdr_point_stress *out)
{
  (n == 1   ? stress_in_1
   : n == 2 ? stress_in_2
            : stress_in_3)(elasticity, split, moduli, gradient, out);
}

void sdr_cauchy(int n, const double *gradient, const double *piola, double thickness,
                double *cauchy)
{
  double c[9];
  const double j = (1.0 + sdr_cofactors(n, gradient, c)) * thickness;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      double sum = piola[n * a + b];
      for (int k = 0; k < n; ++k) sum += piola[n * a + k] * gradient[n * b + k];
      cauchy[n * a + b] = sum / j;
    }
}

/* ---- tangents of the laws of a strain -------------------------------------------------------- */

/* d(2-nd Piola stress)/d(strain) in the axes of principal strain: stress along axes, its slopes,
   and the shear stiffness of each pair of axes. */
typedef struct {
  double s[3], slope[3][3], shear[3][3];
} axes_law;

typedef struct {
  int n;
  double v[9];      /* columns: principal axes, n x n */
  axes_law part[2]; /* of psi+ and psi- */
} spectral_tangent;

static void principal_slopes(int n, sdr_elasticity elasticity, const sdr_moduli *m, const double *e,
                             axes_law part[2])
{
  sdr_function log_c[3], vol = {0};
  double sum = 0.0;
  const int neo = elasticity == SDR_NEO_HOOKEAN;
  for (int a = 0; a < n; ++a) {
    log_c[a] = sdr_long_log(2.0 * e[a], SDR_LEAST_J * SDR_LEAST_J);
    sum += neo ? 0.5 * log_c[a].value : e[a];
  }
  if (neo) vol = sdr_volume_energy(m, sum);
  for (int a = 0; a < n; ++a) {
    double *const own = &part[e[a] > 0.0 ? 0 : 1].slope[a][a];
    *own += neo ? -2.0 * m->mu * log_c[a].second : 2.0 * m->mu;
    for (int b = 0; b < n; ++b) {
      double *const both = &part[sum > 0.0 ? 0 : 1].slope[a][b];
      *both += !neo ? m->lambda : vol.second * log_c[a].first * log_c[b].first;
      if (neo && a == b) *both += 2.0 * vol.first * log_c[a].second;
    }
  }
}

/* (s_a - s_b)/(e_a - e_b), or its limit. */
static void shear_slopes(int n, const double *e, axes_law *law)
{
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const double gap = e[a] - e[b];
      const int close = fabs(gap) <= 1e-5 * (fabs(e[a]) + fabs(e[b]));
      law->shear[a][b] = close ? 0.5 * (law->slope[a][a] + law->slope[b][b]) - law->slope[a][b]
                               : (law->s[a] - law->s[b]) / gap;
    }
}

static void principal_axes(int n, const double *strain, double *e, double *v)
{
  double full[9] = {0.0}, axes[9];
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) full[3 * a + b] = strain[n * a + b];
  sdr_eigen3(full, e, axes);
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) v[n * a + b] = axes[3 * a + b];
}

static void spectral_tangent_of(int n, sdr_elasticity elasticity, const sdr_moduli *m,
                                const double *strain, spectral_tangent *t)
{
  double e[3];
  sdr_principal p;
  *t = (spectral_tangent){.n = n};
  principal_axes(n, strain, e, t->v);
  if (n == 1)
    sdr_principal_law(1, (int)elasticity, m, e, &p);
  else if (n == 2)
    sdr_principal_law(2, (int)elasticity, m, e, &p);
  else
    sdr_principal_law(3, (int)elasticity, m, e, &p);
  for (int a = 0; a < n; ++a) {
    t->part[0].s[a] = p.s_plus[a];
    t->part[1].s[a] = p.s_minus[a];
  }
  principal_slopes(n, elasticity, m, e, t->part);
  shear_slopes(n, e, &t->part[0]);
  shear_slopes(n, e, &t->part[1]);
}

/* out = v^T a v, or v a v^T. */
static void turn(int n, const double *v, int back, const double *a, double *out)
{
  double half[9] = {0.0};
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      for (int k = 0; k < n; ++k)
        half[n * r + c] += (back ? v[n * r + k] : v[n * k + r]) * a[n * k + c];
    }
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      out[n * r + c] = 0.0;
      for (int k = 0; k < n; ++k)
        out[n * r + c] += half[n * r + k] * (back ? v[n * c + k] : v[n * k + c]);
    }
}

/* dS of a change of strain. */
static void spectral_change(const spectral_tangent *t, int which, const double *de, double *ds)
{
  const axes_law *law = &t->part[which];
  const int n = t->n;
  double local[9], stress[9];
  turn(n, t->v, 0, de, local);
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      double sum = a == b ? 0.0 : law->shear[a][b] * local[n * a + b];
      for (int c = 0; a == b && c < n; ++c) sum += law->slope[a][c] * local[n * c + c];
      stress[n * a + b] = sum;
    }
  turn(n, t->v, 1, stress, ds);
}

static void dilatation_change(int n, int split, const sdr_moduli *m, double trace, int which,
                              const double *de, double *ds)
{
  const double bulk = m->lambda + 2.0 * m->mu / n, change = sdr_trace(n, de);
  const int plus = split == SDR_SPLIT_WHOLE || trace > 0.0;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const double one = a == b ? 1.0 : 0.0;
      ds[n * a + b] = which == 0 ? 2.0 * m->mu * (de[n * a + b] - one * change / n) : 0.0;
      if (plus == (which == 0)) ds[n * a + b] += bulk * change * one;
    }
}

/* Change of strain with the unit change of F at row r, column k. */
static void strain_change(int n, int finite, const double *g, int r, int k, double *de)
{
  memset(de, 0, (size_t)(n * n) * sizeof *de);
  for (int a = 0; a < n; ++a) {
    const double f = (a == r ? 1.0 : 0.0) + (finite ? g[n * r + a] : 0.0); /* F_ra */
    de[n * a + k] += 0.5 * f;
    de[n * k + a] += 0.5 * f;
  }
}

static void strain_tangent(int n, sdr_elasticity elasticity, int split, const sdr_moduli *m,
                           const double *g, double *out[2])
{
  const int finite = elasticity != SDR_LINEAR;
  double e[9], de[9], ds[9], dp[9];
  spectral_tangent spectral;
  sdr_point_stress second;
  sdr_strain_of(n, finite, g, e);
  if (split == SDR_SPLIT_SPECTRAL) {
    spectral_tangent_of(n, elasticity, m, e, &spectral);
    sdr_spectral_law(n, (int)elasticity, m, e, &second);
  } else {
    sdr_strain_law(n, split, m, e, &second);
  }
  for (int column = 0; column < n * n; ++column)
    for (int which = 0; which < 2; ++which) {
      const int r = column / n, k = column % n;
      const double *s = which == 0 ? second.p_plus : second.p_minus;
      strain_change(n, finite, g, r, k, de);
      if (split == SDR_SPLIT_SPECTRAL)
        spectral_change(&spectral, which, de, ds);
      else
        dilatation_change(n, split, m, sdr_trace(n, e), which, de, ds);
      sdr_piola_of(n, finite, g, ds, dp);
      for (int c = 0; finite && c < n; ++c) dp[n * r + c] += s[n * k + c]; /* dF S */
      for (int row = 0; row < n * n; ++row) out[which][row * n * n + column] = dp[row];
    }
}

/* ---- neo_hookean ----------------------------------------------------------------------------- */

/* d cof F/dF along the unit change of F at row r, column k. */
static void cofactor_change(int n, const double *g, int r, int k, double *dc)
{
  memset(dc, 0, (size_t)(n * n) * sizeof *dc);
  if (n == 2) dc[n * (1 - r) + 1 - k] = r == k ? 1.0 : -1.0;
  if (n < 3) return;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      if (a == r || b == k) continue;
      /* cof_ab = F_pr F_qs - F_ps F_qr, (a, p, q) and (b, r, s) even permutations */
      const int row = 3 - a - r, column = 3 - b - k;
      const double even = ((a + 1) % 3 == r) == ((b + 1) % 3 == k) ? 1.0 : -1.0;
      dc[3 * a + b] = even * (g[3 * row + column] + (row == column ? 1.0 : 0.0));
    }
}

/* Coefficients of cof F in P+-, and their slopes by J. */
typedef struct {
  double value, slope;
} coefficient;

static void neo_hookean_tangent(int n, int split, const sdr_moduli *m, const double *g,
                                double *out[2])
{
  double c[9], dc[9];
  const sdr_function l = sdr_long_log(sdr_cofactors(n, g, c), SDR_LEAST_J);
  const sdr_function vol = sdr_volume_energy(m, l.value);
  const int whole = split == SDR_SPLIT_WHOLE;
  const double power = exp(2.0 * l.value / n);
  /* by L, then by J: (h(L) L_J)' = h' L_J^2 + h L_JJ */
  const double shape = whole ? -m->mu : -m->mu * power, shape_slope = whole ? 0.0 : 2.0 / n * shape;
  const double bulk = vol.first + (whole ? 0.0 : m->mu * (power - 1.0));
  const double bulk_slope = vol.second + (whole ? 0.0 : 2.0 * m->mu * power / n);
  coefficient part[2] = {{shape, shape_slope}, {0.0, 0.0}};
  part[whole || l.value > 0.0 ? 0 : 1].value += bulk;
  part[whole || l.value > 0.0 ? 0 : 1].slope += bulk_slope;
  for (int k = 0; k < n; ++k) c[(n + 1) * k] += 1.0;
  for (int column = 0; column < n * n; ++column) {
    cofactor_change(n, g, column / n, column % n, dc);
    for (int which = 0; which < 2; ++which) {
      const double by_j = part[which].slope * l.first * l.first + part[which].value * l.second;
      for (int row = 0; row < n * n; ++row)
        out[which][row * n * n + column] = by_j * c[row] * c[column] +
                                           part[which].value * l.first * dc[row] +
                                           (which == 0 && row == column ? m->mu : 0.0);
    }
  }
}

void sdr_stress_tangent(int n, sdr_elasticity elasticity, int split, const sdr_moduli *moduli,
                        const double *gradient, double *plus, double *minus)
{
  double *out[2] = {plus, minus};
  if (elasticity == SDR_NEO_HOOKEAN && split != SDR_SPLIT_SPECTRAL)
    neo_hookean_tangent(n, split, moduli, gradient, out);
  else
    strain_tangent(n, elasticity, split, moduli, gradient, out);
}
