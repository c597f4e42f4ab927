/* The neo-Hookean law of points that are lanes: sdr_neo_hookean_law (stress.h), where the formulas
   are. Literals as in nonordinary_loop.h. */
#ifndef SDR_MECHANICS_NONORDINARY_NEO_H
#define SDR_MECHANICS_NONORDINARY_NEO_H

#include "mechanics/lanes_log.h"
#include "mechanics/nonordinary_body.h"
#include "mechanics/stress.h"

/* sdr_point_stress of the lanes; p_minus only where energies are split. */
typedef struct {
  sdr_lanes plus, minus, p_plus[9], p_minus[9];
} sdr_lanes_stress;

/* A function's value and slope. */
typedef struct {
  sdr_lanes value, first;
} sdr_lanes_function;

/* sdr_cofactors */
SDR_INLINE sdr_lanes cofactor_lanes(const int n, const sdr_lanes *g, sdr_lanes *c)
{
  if (n == 1) {
    c[0] = all_lanes(0.0);
    return g[0];
  }
  if (n == 2) {
    c[0] = g[3];
    c[1] = -g[2];
    c[2] = -g[1];
    c[3] = g[0];
    return g[0] + g[3] + (g[0] * g[3] - g[1] * g[2]);
  }
  const sdr_lanes trace = g[0] + g[4] + g[8];
  sdr_lanes second = all_lanes(0.0), third = second;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const int p = (a + 1) % 3, q = (a + 2) % 3, r = (b + 1) % 3, s = (b + 2) % 3;
      const sdr_lanes cofactor = g[3 * p + r] * g[3 * q + s] - g[3 * p + s] * g[3 * q + r];
      if (a == b) second += cofactor;
      if (a == 0) third += cofactor * g[b];
      c[3 * a + b] = cofactor - g[3 * b + a];
      if (a == b) c[3 * a + b] += trace;
    }
  return trace + second + third;
}

/* sdr_long_log of J = 1 + grown */
SDR_INLINE sdr_lanes_function long_log_lanes(sdr_lanes grown)
{
  const double log_least = -2.302585092994045684; /* of SDR_LEAST_J */
  const sdr_lanes at = 1.0 + grown, least = all_lanes(SDR_LEAST_J);
  const sdr_lanes_bits crushed = at < least;
  const sdr_lanes t = at * (1.0 / SDR_LEAST_J) - 1.0;
  const sdr_lanes sound = where_set(crushed, least - 1.0, grown);
  return (sdr_lanes_function){
      where_set(crushed, log_least + t - 0.5 * t * t, log1p_lanes(sound)),
      where_set(crushed, (1.0 - t) * (1.0 / SDR_LEAST_J), 1.0 / (1.0 + sound))};
}

SDR_INLINE sdr_lanes size_of(sdr_lanes v)
{
  return (sdr_lanes)((sdr_lanes_bits)v & 0x7fffffffffffffffLL);
}

/* sdr_condensed_volume, by Newton's method for d = F33^2 - 1:

     mu d + lambda (L + ln(1 + d)/2) = 0

   is increasing and concave for lambda >= 0, and the linear answer and exp(-2 L) - 1 lie left of
   the root, so Newton climbs to it. Lanes that have arrived stay as they are, whatever the others
   do. What does not arrive (lambda < 0) is left to the function for one point. */
SDR_INLINE sdr_lanes_function condensed_lanes(sdr_lanes lambda, sdr_lanes mu, sdr_lanes l)
{
  const sdr_lanes zero = all_lanes(0.0), half = 0.5 * lambda;
  sdr_lanes d = -lambda * l / (mu + half);
  sdr_lanes_bits away = ~(lambda >= zero);
  if (any_ints(ints_of(d < -0.5))) {
    const sdr_lanes far = where_above(l, all_lanes(300.0), all_lanes(300.0), l);
    const sdr_lanes lowest = expm1_lanes(-2.0 * where_above(far, zero, far, zero));
    d = where_above(d, lowest, d, lowest);
  }
  sdr_lanes_bits there = {0};
  for (int step = 0; step < 12 && any_ints(ints_of(~there)); ++step) {
    const sdr_lanes rest = fma_lanes(mu, d, lambda * l + half * log1p_lanes(d));
    const sdr_lanes change = rest * (1.0 + d) / fma_lanes(mu, 1.0 + d, half);
    d = where_set(there, d, d - change);
    there |= size_of(change) <= 1e-9 * size_of(d); /* what is left is its square */
  }
  away |= ~there;
  const sdr_lanes x = log1p_lanes(d), sum = l + 0.5 * x;
  sdr_lanes_function vol = {0.5 * mu * (d - x) + half * sum * sum, lambda * sum};
  for (int lane = 0; any_ints(ints_of(away)) && lane < SDR_WIDTH; ++lane)
    if (away[lane]) {
      const sdr_moduli moduli = {lambda[lane], mu[lane], 1};
      const sdr_function one = sdr_condensed_volume(&moduli, l[lane]);
      vol.value[lane] = one.value;
      vol.first[lane] = one.first;
    }
  return vol;
}

/* sdr_neo_hookean_law of points i and after */
SDR_INLINE void neo_hookean_lanes(const int n, const int split, const sdr_nonordinary_body *body,
                                  int64_t i, const sdr_lanes *g, sdr_lanes_stress *out)
{
  const int whole = split == SDR_SPLIT_WHOLE;
  const sdr_lanes lambda = load_lanes(body->lambda + i), mu = load_lanes(body->mu + i);
  const sdr_lanes zero = all_lanes(0.0), one = all_lanes(1.0);
  sdr_lanes c[9], square = zero, trace = zero;
  const sdr_lanes grown = cofactor_lanes(n, g, c);
  const sdr_lanes_function l = long_log_lanes(grown);
  const sdr_lanes_function vol =
      n == 2 && body->plane_stress
          ? condensed_lanes(lambda, mu, l.value)
          : (sdr_lanes_function){0.5 * lambda * l.value * l.value, lambda * l.value};
  const sdr_lanes far = where_above(l.value, all_lanes(-150.0), l.value, all_lanes(-150.0));
  const sdr_lanes power = whole ? zero : expm1_lanes((2.0 / n) * far);
  for (int k = 0; k < n * n; ++k) square = fma_lanes(g[k], g[k], square);
  for (int k = 0; k < n; ++k) trace += g[(n + 1) * k];
  square += 2.0 * trace;
  const sdr_lanes a = whole ? l.first : (1.0 + power) * l.first;
  sdr_lanes a_rest = 1.0 - a;
  if (whole) a_rest = where_set(1.0 + grown >= SDR_LEAST_J, grown * l.first, a_rest);
  const sdr_lanes b = (whole ? vol.first : fma_lanes(mu, power, vol.first)) * l.first;
  const sdr_lanes dilation =
      whole ? vol.value - mu * l.value : fma_lanes(mu, 0.5 * n * power - l.value, vol.value);
  const sdr_lanes_bits opens = whole ? one > zero : l.value > zero;
  out->plus =
      0.5 * mu * (whole ? square : square - (double)n * power) + where_set(opens, dilation, zero);
  out->minus = where_set(opens, zero, dilation);
  for (int r = 0; r < n; ++r)
    for (int k = 0; k < n; ++k) {
      const sdr_lanes cof = c[n * r + k], part = r == k ? b * (1.0 + cof) : b * cof;
      const sdr_lanes shape = g[n * r + k] - a * cof;
      out->p_plus[n * r + k] =
          mu * (r == k ? shape + a_rest : shape) + where_set(opens, part, zero);
      out->p_minus[n * r + k] = where_set(opens, zero, part);
    }
}

#endif
