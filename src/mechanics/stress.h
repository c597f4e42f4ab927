/* Elastic laws of a point: energy density psi of the displacement gradient G = F - I (n x n, row
   major), split into the part psi+ that drives damage and the part psi- that damage leaves alone,
   and the first Piola stresses P+- = d psi+-/dF (theory sec. 11).

     linear                psi = lambda/2 tr(e)^2 + mu e:e, e = sym G
     saint_venant_kirchhoff  the same with Green's strain e = (G + G^T + G^T G)/2
     neo_hookean           psi = mu/2 (|F|^2 - n) - mu L + vol(L), L = ln J; vol = lambda/2 L^2, in
                           plane stress the least of mu/2 (a - 1 - ln a) + lambda/2 (L + ln a/2)^2
                           over a = F33^2, which is P33 = 0

   Splits: `dilatation` puts all shear and the energy of growth into psi+, that of shrinking into
   psi-; `spectral` divides by the sign of principal strains and of their sum. Below J = 0.1 (a
   principal F^2 of 0.01) logarithms go on as parabolas, so that a crushed point has a finite
   energy and exact derivatives. Valid for mu > 0 and n lambda + 2 mu > 0; spectral needs
   lambda >= 0 for both parts to be positive. `n`, `elasticity` and `split` are literals where the
   functions are inlined. */
#ifndef SDR_MECHANICS_STRESS_H
#define SDR_MECHANICS_STRESS_H

#include "scene/scene.h"

#include <math.h>

#define SDR_STRESS_INLINE static inline __attribute__((always_inline))

/* Not split: all of it is psi+. */
enum { SDR_SPLIT_WHOLE = 2 };

/* Pa. In plane stress the two laws of a strain have the condensed lambda E nu/(1 - nu^2) instead
   of Lame's. In 1-D lambda = 0 and mu = E/2. */
typedef struct {
  double lambda, mu;
  int plane_stress; /* neo_hookean: find F33 */
} sdr_moduli;

typedef struct {
  double plus, minus;           /* J/m^3 */
  double p_plus[9], p_minus[9]; /* Pa, n x n */
} sdr_point_stress;

sdr_moduli sdr_moduli_of(sdr_dimension dimension, sdr_elasticity elasticity, double young,
                         double poisson);

/* Tangents d P+-/dF at G: (n n) x (n n), row major, symmetric; away from the kinks of the split. */
void sdr_stress_tangent(int n, sdr_elasticity elasticity, int split, const sdr_moduli *moduli,
                        const double *gradient, double *plus, double *minus);

/* The same as sdr_stress_at, with nothing known to the compiler. */
void sdr_stress_of(int n, sdr_elasticity elasticity, int split, const sdr_moduli *moduli,
                   const double *gradient, sdr_point_stress *out);

/* Cauchy stress from the first Piola stress, n x n; F = I + gradient. In plane stress J does not
   know F33: `thickness` is F33 (1 elsewhere). */
void sdr_cauchy(int n, const double *gradient, const double *piola, double thickness,
                double *cauchy);

/* F33 of a neo-Hookean point in plane stress; L = ln J of the plane. */
double sdr_thickness_stretch(const sdr_moduli *moduli, double log_volume);
/* F33 of either law of finite strain in plane stress. */
double sdr_plane_thickness(sdr_elasticity elasticity, const sdr_moduli *moduli,
                           const double *gradient);

/* Eigenvalues e and unit eigenvectors (columns of v, 3 x 3) of a symmetric 3 x 3 matrix. */
void sdr_eigen3(const double *matrix, double *e, double *v);

/* vol(L) of neo_hookean and its two derivatives. */
typedef struct {
  double value, first, second;
} sdr_function;
sdr_function sdr_condensed_volume(const sdr_moduli *moduli, double log_volume);

SDR_STRESS_INLINE sdr_function sdr_volume_energy(const sdr_moduli *m, double l)
{
  if (m->plane_stress) return sdr_condensed_volume(m, l);
  return (sdr_function){0.5 * m->lambda * l * l, m->lambda * l, m->lambda};
}

/* ln(1 + x), going on as a parabola below 1 + x = least. */
SDR_STRESS_INLINE sdr_function sdr_long_log(double x, double least)
{
  const double at = 1.0 + x;
  if (at >= least) return (sdr_function){log1p(x), 1.0 / at, -1.0 / (at * at)};
  const double t = at / least - 1.0;
  return (sdr_function){log(least) + t - 0.5 * t * t, (1.0 - t) / least, -1.0 / (least * least)};
}

#define SDR_LEAST_J 0.1

/* ---- small matrices -------------------------------------------------------------------------- */

/* Strain of the two laws that are functions of one, and of spectral neo_hookean. */
SDR_STRESS_INLINE void sdr_strain_of(const int n, const int finite, const double *g, double *e)
{
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      double sum = g[n * a + b] + g[n * b + a];
      for (int c = 0; finite && c < n; ++c) sum += g[n * c + a] * g[n * c + b];
      e[n * a + b] = 0.5 * sum;
    }
}

/* P = F S, or S itself where strains are small. */
SDR_STRESS_INLINE void sdr_piola_of(const int n, const int finite, const double *g, const double *s,
                                    double *p)
{
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      double sum = s[n * a + b];
      for (int c = 0; finite && c < n; ++c) sum += g[n * a + c] * s[n * c + b];
      p[n * a + b] = sum;
    }
}

SDR_STRESS_INLINE double sdr_trace(const int n, const double *a)
{
  return n == 1 ? a[0] : n == 2 ? a[0] + a[3] : a[0] + a[4] + a[8];
}

SDR_STRESS_INLINE double sdr_contract(const int n, const double *a, const double *b)
{
  double sum = 0.0;
  for (int k = 0; k < n * n; ++k) sum += a[k] * b[k];
  return sum;
}

/* Cofactors of F less I, and J - 1, without cancellation: c is n x n. */
SDR_STRESS_INLINE double sdr_cofactors(const int n, const double *g, double *c)
{
  if (n == 1) {
    c[0] = 0.0;
    return g[0];
  }
  if (n == 2) {
    c[0] = g[3];
    c[1] = -g[2];
    c[2] = -g[1];
    c[3] = g[0];
    return g[0] + g[3] + (g[0] * g[3] - g[1] * g[2]);
  }
  const double trace = g[0] + g[4] + g[8];
  double second = 0.0, third = 0.0; /* invariants of G */
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const int p = (a + 1) % 3, q = (a + 2) % 3, r = (b + 1) % 3, s = (b + 2) % 3;
      const double cofactor = g[3 * p + r] * g[3 * q + s] - g[3 * p + s] * g[3 * q + r];
      if (a == b) second += cofactor;
      if (a == 0) third += cofactor * g[b];
      c[3 * a + b] = cofactor - g[3 * b + a] + (a == b ? trace : 0.0);
    }
  return trace + second + third;
}

/* ---- laws of a strain ------------------------------------------------------------------------ */

/* 2-nd Piola stresses (n x n) of a strain, whole or split by dilatation. */
SDR_STRESS_INLINE void sdr_strain_law(const int n, const int split, const sdr_moduli *m,
                                      const double *e, sdr_point_stress *out)
{
  const double trace = sdr_trace(n, e), share = trace / n, bulk = m->lambda + 2.0 * m->mu / n;
  const int whole = split == SDR_SPLIT_WHOLE;
  const double grown = trace > 0.0 ? trace : 0.0, shrunk = trace - grown;
  double shear = 0.0;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const double part = e[n * a + b] - (a == b ? share : 0.0);
      shear += part * part;
      out->p_plus[n * a + b] = 2.0 * m->mu * part + (a == b ? bulk * (whole ? trace : grown) : 0.0);
      out->p_minus[n * a + b] = a == b && !whole ? bulk * shrunk : 0.0;
    }
  out->plus = 0.5 * bulk * (whole ? trace * trace : grown * grown) + m->mu * shear;
  out->minus = whole ? 0.0 : 0.5 * bulk * shrunk * shrunk;
}

/* Energies and principal stresses by principal strains e. */
typedef struct {
  double plus, minus, s_plus[3], s_minus[3];
} sdr_principal;

SDR_STRESS_INLINE void sdr_principal_strain_law(const int n, const sdr_moduli *m, const double *e,
                                                sdr_principal *out)
{
  double trace = 0.0;
  for (int a = 0; a < n; ++a) trace += e[a];
  const double grown = trace > 0.0 ? trace : 0.0, shrunk = trace - grown;
  out->plus = 0.5 * m->lambda * grown * grown;
  out->minus = 0.5 * m->lambda * shrunk * shrunk;
  for (int a = 0; a < n; ++a) {
    const double tension = e[a] > 0.0 ? e[a] : 0.0, pressure = e[a] - tension;
    out->plus += m->mu * tension * tension;
    out->minus += m->mu * pressure * pressure;
    out->s_plus[a] = m->lambda * grown + 2.0 * m->mu * tension;
    out->s_minus[a] = m->lambda * shrunk + 2.0 * m->mu * pressure;
  }
}

/* neo_hookean in principal Green strains: sum of mu/2 (c - 1 - ln c) with c = 1 + 2 e, and vol. */
SDR_STRESS_INLINE void sdr_principal_neo_hookean(const int n, const sdr_moduli *m, const double *e,
                                                 sdr_principal *out)
{
  double l = 0.0, slope[3] = {0.0};
  *out = (sdr_principal){0};
  for (int a = 0; a < n; ++a) {
    const sdr_function log_c = sdr_long_log(2.0 * e[a], SDR_LEAST_J * SDR_LEAST_J);
    const double energy = 0.5 * m->mu * (2.0 * e[a] - log_c.value);
    const double c = 1.0 + 2.0 * e[a];
    const double rest = c >= SDR_LEAST_J * SDR_LEAST_J ? 2.0 * e[a] / c : 1.0 - log_c.first;
    l += 0.5 * log_c.value;
    slope[a] = log_c.first;
    *(e[a] > 0.0 ? &out->plus : &out->minus) += energy;
    (e[a] > 0.0 ? out->s_plus : out->s_minus)[a] = m->mu * rest;
  }
  const sdr_function vol = sdr_volume_energy(m, l);
  *(l > 0.0 ? &out->plus : &out->minus) += vol.value;
  for (int a = 0; a < n; ++a) (l > 0.0 ? out->s_plus : out->s_minus)[a] += vol.first * slope[a];
}

SDR_STRESS_INLINE void sdr_principal_law(const int n, const int elasticity, const sdr_moduli *m,
                                         const double *e, sdr_principal *out)
{
  if (elasticity == SDR_NEO_HOOKEAN)
    sdr_principal_neo_hookean(n, m, e, out);
  else
    sdr_principal_strain_law(n, m, e, out);
}

/* In the plane: the matrix with principal values s where e has them. Equal ones have no direction
   and need none. */
SDR_STRESS_INLINE void sdr_turn_back2(const double *half, double radius, const double *s,
                                      double *out)
{
  const double mean = 0.5 * (s[0] + s[1]);
  const double ratio = radius > 1e-150 ? 0.5 * (s[0] - s[1]) / radius : 0.0;
  out[0] = mean + ratio * half[0];
  out[1] = out[2] = ratio * half[1];
  out[3] = mean - ratio * half[0];
}

/* 2-nd Piola stresses of a strain, split by principal values. */
SDR_STRESS_INLINE void sdr_spectral_law(const int n, const int elasticity, const sdr_moduli *m,
                                        const double *e, sdr_point_stress *out)
{
  sdr_principal p;
  if (n == 1) {
    sdr_principal_law(1, elasticity, m, e, &p);
    out->p_plus[0] = p.s_plus[0];
    out->p_minus[0] = p.s_minus[0];
  } else if (n == 2) {
    const double mean = 0.5 * (e[0] + e[3]), half[2] = {0.5 * (e[0] - e[3]), e[1]};
    const double radius = sqrt(half[0] * half[0] + half[1] * half[1]);
    const double value[2] = {mean + radius, mean - radius};
    sdr_principal_law(2, elasticity, m, value, &p);
    sdr_turn_back2(half, radius, p.s_plus, out->p_plus);
    sdr_turn_back2(half, radius, p.s_minus, out->p_minus);
  } else {
    double value[3], v[9];
    sdr_eigen3(e, value, v);
    sdr_principal_law(3, elasticity, m, value, &p);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        double plus = 0.0, minus = 0.0;
        for (int c = 0; c < 3; ++c) {
          const double both = v[3 * a + c] * v[3 * b + c];
          plus += p.s_plus[c] * both;
          minus += p.s_minus[c] * both;
        }
        out->p_plus[3 * a + b] = plus;
        out->p_minus[3 * a + b] = minus;
      }
  }
  out->plus = p.plus;
  out->minus = p.minus;
}

/* ---- neo_hookean ----------------------------------------------------------------------------- */

/* Whole: mu/2 (|F|^2 - n) - mu L + vol. By dilatation: the shape's energy
   mu/2 (|F|^2 - n J^(2/n)), least 0 at equal principal stretches, and that of pure dilation,
   mu (n/2 (J^(2/n) - 1) - L) + vol. */
SDR_STRESS_INLINE void sdr_neo_hookean_law(const int n, const int split, const sdr_moduli *m,
                                           const double *g, sdr_point_stress *out)
{
  double c[9];
  const double grown = sdr_cofactors(n, g, c);
  const sdr_function l = sdr_long_log(grown, SDR_LEAST_J), vol = sdr_volume_energy(m, l.value);
  const double square = 2.0 * sdr_trace(n, g) + sdr_contract(n, g, g); /* |F|^2 - n */
  const double power = expm1(2.0 * l.value / n);                       /* J^(2/n) - 1 */
  const double sound = 1.0 + grown >= SDR_LEAST_J;
  const int whole = split == SDR_SPLIT_WHOLE, opens = whole || l.value > 0.0;
  /* P = mu (G + (1 - a) I - a (cof F - I)) + b cof F */
  const double a = whole ? l.first : (1.0 + power) * l.first;
  const double a_rest = whole && sound > 0.0 ? grown * l.first : 1.0 - a;
  const double b = (vol.first + (whole ? 0.0 : m->mu * power)) * l.first;
  const double dilation =
      whole ? vol.value - m->mu * l.value : m->mu * (0.5 * n * power - l.value) + vol.value;
  out->plus = 0.5 * m->mu * (square - (whole ? 0.0 : n * power)) + (opens ? dilation : 0.0);
  out->minus = opens ? 0.0 : dilation;
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < n; ++k) {
      const double one = r == k ? 1.0 : 0.0, part = b * (one + c[n * r + k]);
      out->p_plus[n * r + k] =
          m->mu * (g[n * r + k] + one * a_rest - a * c[n * r + k]) + (opens ? part : 0.0);
      out->p_minus[n * r + k] = opens ? 0.0 : part;
    }
}

/* ---- all of them ----------------------------------------------------------------------------- */

SDR_STRESS_INLINE void sdr_stress_at(const int n, const int elasticity, const int split,
                                     const sdr_moduli *moduli, const double *g,
                                     sdr_point_stress *out)
{
  if (elasticity == SDR_NEO_HOOKEAN && split != SDR_SPLIT_SPECTRAL) {
    sdr_neo_hookean_law(n, split, moduli, g, out);
    return;
  }
  const int finite = elasticity != SDR_LINEAR;
  double e[9];
  sdr_point_stress second;
  sdr_strain_of(n, finite, g, e);
  if (split == SDR_SPLIT_SPECTRAL)
    sdr_spectral_law(n, elasticity, moduli, e, &second);
  else
    sdr_strain_law(n, split, moduli, e, &second);
  out->plus = second.plus;
  out->minus = second.minus;
  sdr_piola_of(n, finite, g, second.p_plus, out->p_plus);
  sdr_piola_of(n, finite, g, second.p_minus, out->p_minus);
}

#endif
