/* From the sums over a point's family to what bears on its bonds: gradient, stress, damage, and the
   share of the control energy that comes from z = eta - G xi hanging on G. Literals as in
   nonordinary_loop.h; points are the lanes. */
#ifndef SDR_MECHANICS_NONORDINARY_POINT_H
#define SDR_MECHANICS_NONORDINARY_POINT_H

#include "mechanics/nonordinary_loop.h"
#include "mechanics/stress.h"

/* out = a K^-1 */
SDR_INLINE void times_inverse(const int n, const sdr_nonordinary_body *body, int64_t i,
                              const double *a, double *out)
{
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      double sum = 0.0;
      for (int k = 0; k < n; ++k) sum += a[n * r + k] * body->inverse[sdr_upper(n, k, c)][i];
      out[n * r + c] = sum;
    }
}

SDR_INLINE void load_matrix(const int n, double *const from[9], int64_t i, double *to)
{
  for (int k = 0; k < n * n; ++k) to[k] = from[k][i];
}
SDR_INLINE void store_matrix(const int n, const double *from, int64_t i, double *const to[9])
{
  for (int k = 0; k < n * n; ++k) to[k][i] = from[k];
}

/* Q of the kept values and the trace of M. */
SDR_INLINE void load_normal(const int n, const sdr_nonordinary_body *body, int64_t i,
                            const double *m, double *q)
{
  double last = sdr_trace(n, m);
  int k = 0;
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      const double value = k < kept_of_normal(n) ? body->bearing[k][i] : last;
      ++k;
      q[n * a + b] = q[n * b + a] = value;
      if (a == b) last -= value;
    }
}

/* S = -(Q - C:G), C the fourth moments. */
SDR_INLINE void normal_sum(const int n, const sdr_nonordinary_body *body, int64_t i,
                           const double *q, const double *strain, double *s)
{
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      double sum = -q[n * a + b];
      for (int c = 0; c < n; ++c)
        for (int d = 0; d < n; ++d)
          sum += body->quartic[sdr_quartic_index(n, a, b, c, d)][i] * strain[n * c + d];
      s[n * a + b] = sum;
    }
}

/* What pass A (and A2) left of a point: gradient (linear: its symmetric part in `strain`), S, and
   the sums of W |z|^2 and W (z.n)^2. */
typedef struct {
  double g[9], strain[9], s[9], square, along;
} sdr_family_state;

SDR_INLINE void family_state(const int n, const int finite, const int sums,
                             const sdr_nonordinary_body *body, int64_t i, sdr_family_state *out)
{
  if (finite) {
    load_matrix(n, body->gradient, i, out->g);
    load_matrix(n, body->bearing, i, out->s);
    out->square = body->square[i];
    out->along = body->along[i];
    return;
  }
  double m[9], q[9];
  load_matrix(n, body->gradient, i, m);
  load_normal(n, body, i, m, q);
  times_inverse(n, body, i, m, out->g);
  sdr_strain_of(n, 0, out->g, out->strain);
  normal_sum(n, body, i, q, out->strain, out->s);
  if (!sums) return;
  /* sum W |eta - G xi|^2 and sum W (eta.n - n.G xi)^2, multiplied out */
  out->square = body->square[i] - sdr_contract(n, out->g, m);
  out->along =
      body->along[i] - sdr_contract(n, out->strain, q) + sdr_contract(n, out->strain, out->s);
}

/* A = (V P + stiff S) K^-1, less soft G, which turns soft z into soft eta. */
SDR_INLINE void store_bearing(const int n, const int finite, const sdr_nonordinary_body *body,
                              int64_t i, const sdr_family_state *state, const double *stress,
                              double soft, double stiff)
{
  double sum[9], a[9];
  for (int k = 0; k < n * n; ++k)
    sum[k] = body->points->volume[i] * stress[k] + stiff * state->s[k];
  times_inverse(n, body, i, sum, a);
  for (int k = 0; k < n * n; ++k) a[k] -= soft * state->g[k];
  store_matrix(n, a, i, body->bearing);
  if (!finite) store_matrix(n, state->strain, i, body->gradient);
  body->soft[i] = soft;
  body->stiff[i] = stiff;
}

SDR_INLINE void point_at(const int n, const int elasticity, const int split, const int task,
                         const sdr_nonordinary_body *body, int64_t i)
{
  const int finite = elasticity != SDR_LINEAR;
  const sdr_moduli moduli = {body->lambda[i], body->mu[i], body->plane_stress};
  sdr_family_state state;
  sdr_point_stress stress;
  family_state(n, finite, task != SDR_POINT_ELASTIC, body, i, &state);
  sdr_stress_at(n, elasticity, split, &moduli, state.g, &stress);
  double intact = 1.0;
  if (task != SDR_POINT_ELASTIC) {
    const double control = 0.5 * (body->shear[i] * state.square + body->normal[i] * state.along);
    const double volume = body->points->volume[i];
    const double plus = stress.plus + (volume > 0.0 ? control / volume : 0.0);
    if (task == SDR_POINT_ENERGY) {
      body->plus[i] = plus;
      body->minus[i] = stress.minus;
      if (!finite) store_matrix(n, state.strain, i, body->gradient);
      return;
    }
    const double grown = plus > body->history[i] ? plus : body->history[i];
    const double left = 1.0 / (1.0 + grown * body->softness[i]);
    if (body->commit) body->history[i] = grown;
    intact = left * left;
    for (int k = 0; k < n * n; ++k)
      stress.p_plus[k] = intact * stress.p_plus[k] + stress.p_minus[k];
  }
  store_bearing(n, finite, body, i, &state, stress.p_plus, intact * body->shear[i],
                intact * body->normal[i]);
}

/* ---- small strains, in lanes ----------------------------------------------------------------- */

/* out = a K^-1 */
SDR_INLINE void lanes_times_inverse(const int n, const sdr_nonordinary_body *body, int64_t i,
                                    int count, const sdr_lanes *a, sdr_lanes *out)
{
  sdr_lanes inverse[6];
  for (int k = 0; k < n * (n + 1) / 2; ++k) inverse[k] = load_lanes(body->inverse[k] + i, count);
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      out[n * r + c] = a[n * r] * inverse[sdr_upper(n, 0, c)];
      for (int k = 1; k < n; ++k) out[n * r + c] += a[n * r + k] * inverse[sdr_upper(n, k, c)];
    }
}

SDR_INLINE sdr_lanes lanes_contract(const int n, const sdr_lanes *a, const sdr_lanes *b)
{
  sdr_lanes sum = a[0] * b[0];
  for (int k = 1; k < n * n; ++k) sum += a[k] * b[k];
  return sum;
}

/* family_state of points i and after. */
typedef struct {
  sdr_lanes g[9], strain[9], s[9], square, along;
} sdr_lanes_state;

SDR_INLINE void lanes_state(const int n, const int sums, const sdr_nonordinary_body *body,
                            int64_t i, int count, sdr_lanes_state *out)
{
  sdr_lanes m[9], q[9], quartic[15], last = all_lanes(0.0);
  int kept = 0;
  load_all(n * n, body->gradient, i, count, m);
  for (int a = 0; a < n; ++a) last += m[(n + 1) * a];
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      q[n * a + b] = last;
      if (kept < kept_of_normal(n)) q[n * a + b] = load_lanes(body->bearing[kept] + i, count);
      q[n * b + a] = q[n * a + b];
      ++kept;
      if (a == b) last -= q[n * a + b];
    }
  lanes_times_inverse(n, body, i, count, m, out->g);
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b)
      out->strain[n * a + b] = 0.5 * (out->g[n * a + b] + out->g[n * b + a]);
  for (int k = 0; k < (n == 1 ? 1 : n == 2 ? 5 : 15); ++k)
    quartic[k] = load_lanes(body->quartic[k] + i, count);
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      sdr_lanes sum = -q[n * a + b];
      for (int c = 0; c < n; ++c)
        for (int d = 0; d < n; ++d)
          sum += quartic[sdr_quartic_index(n, a, b, c, d)] * out->strain[n * c + d];
      out->s[n * a + b] = out->s[n * b + a] = sum;
    }
  if (!sums) return;
  out->square = load_lanes(body->square + i, count) - lanes_contract(n, out->g, m);
  out->along = load_lanes(body->along + i, count) - lanes_contract(n, out->strain, q) +
               lanes_contract(n, out->strain, out->s);
}

/* The linear law, whole or split by dilatation: stress is shear + I grown (psi+) and I shrunk. */
typedef struct {
  sdr_lanes shear[9], grown, shrunk, plus, minus;
} sdr_lanes_stress;

SDR_INLINE void lanes_stress(const int n, const int split, const sdr_nonordinary_body *body,
                             int64_t i, int count, const sdr_lanes *e, sdr_lanes_stress *out)
{
  const sdr_lanes mu = load_lanes(body->mu + i, count), zero = all_lanes(0.0);
  const sdr_lanes bulk = load_lanes(body->lambda + i, count) + (2.0 / n) * mu;
  sdr_lanes trace = e[0], square = zero;
  for (int a = 1; a < n; ++a) trace += e[(n + 1) * a];
  const sdr_lanes share = (1.0 / n) * trace;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const sdr_lanes part = a == b ? e[n * a + b] - share : e[n * a + b];
      square += part * part;
      out->shear[n * a + b] = 2.0 * mu * part;
    }
  const sdr_lanes grown = split == SDR_SPLIT_WHOLE ? trace : where_above(trace, zero, trace, zero);
  const sdr_lanes shrunk = trace - grown;
  out->grown = bulk * grown;
  out->shrunk = bulk * shrunk;
  out->plus = 0.5 * bulk * grown * grown + mu * square;
  out->minus = 0.5 * bulk * shrunk * shrunk;
}

/* store_bearing of points i and after. */
SDR_INLINE void lanes_bearing(const int n, const sdr_nonordinary_body *body, int64_t i, int count,
                              const sdr_lanes_state *state, const sdr_lanes *stress,
                              sdr_lanes intact)
{
  const sdr_lanes soft = intact * load_lanes(body->shear + i, count);
  const sdr_lanes stiff = intact * load_lanes(body->normal + i, count);
  const sdr_lanes volume = load_lanes(body->points->volume + i, count);
  sdr_lanes sum[9], a[9];
  for (int k = 0; k < n * n; ++k) sum[k] = volume * stress[k] + stiff * state->s[k];
  lanes_times_inverse(n, body, i, count, sum, a);
  for (int k = 0; k < n * n; ++k) {
    store_lanes(body->bearing[k] + i, count, a[k] - soft * state->g[k]);
    store_lanes(body->gradient[k] + i, count, state->strain[k]);
  }
  store_lanes(body->soft + i, count, soft);
  store_lanes(body->stiff + i, count, stiff);
}

SDR_INLINE void linear_lanes(const int n, const int split, const int task,
                             const sdr_nonordinary_body *body, int64_t i, int count)
{
  const sdr_lanes one = all_lanes(1.0), zero = all_lanes(0.0);
  sdr_lanes_state state;
  sdr_lanes_stress law;
  lanes_state(n, task != SDR_POINT_ELASTIC, body, i, count, &state);
  lanes_stress(n, split, body, i, count, state.strain, &law);
  sdr_lanes intact = one;
  if (task != SDR_POINT_ELASTIC) {
    const sdr_lanes volume = load_lanes(body->points->volume + i, count);
    const sdr_lanes control = 0.5 * (load_lanes(body->shear + i, count) * state.square +
                                     load_lanes(body->normal + i, count) * state.along);
    const sdr_lanes plus =
        law.plus +
        where_above(volume, zero, control / where_above(volume, zero, volume, one), zero);
    if (task == SDR_POINT_ENERGY) {
      store_lanes(body->plus + i, count, plus);
      store_lanes(body->minus + i, count, law.minus);
      for (int k = 0; k < n * n; ++k) store_lanes(body->gradient[k] + i, count, state.strain[k]);
      return;
    }
    const sdr_lanes before = load_lanes(body->history + i, count);
    const sdr_lanes grown = where_above(plus, before, plus, before);
    const sdr_lanes left = one / (one + grown * load_lanes(body->softness + i, count));
    if (body->commit) store_lanes(body->history + i, count, grown);
    intact = left * left;
  }
  for (int a = 0; a < n; ++a) {
    for (int b = 0; b < n; ++b) law.shear[n * a + b] *= intact;
    law.shear[(n + 1) * a] += intact * law.grown + law.shrunk;
  }
  lanes_bearing(n, body, i, count, &state, law.shear, intact);
}

SDR_INLINE void points_of(const int n, const int elasticity, const int split, const int task,
                          const sdr_nonordinary_body *body, int32_t first, int32_t end)
{
  if (elasticity == SDR_LINEAR && split != SDR_SPLIT_SPECTRAL) {
    int32_t i = first;
    for (; i + SDR_WIDTH <= end; i += SDR_WIDTH) linear_lanes(n, split, task, body, i, SDR_WIDTH);
    if (i < end) linear_lanes(n, split, task, body, i, end - i);
    return;
  }
#pragma omp simd
  for (int32_t i = first; i < end; ++i) point_at(n, elasticity, split, task, body, i);
}

SDR_INLINE void gradients_of_lanes(const int n, const sdr_nonordinary_body *body, int64_t i,
                                   int count)
{
  const sdr_lanes zero = all_lanes(0.0);
  sdr_lanes m[9], g[9];
  load_all(n * n, body->gradient, i, count, m);
  lanes_times_inverse(n, body, i, count, m, g);
  for (int k = 0; k < n * n; ++k) {
    store_lanes(body->gradient[k] + i, count, g[k]);
    store_lanes(body->bearing[k] + i, count, zero);
  }
  store_lanes(body->square + i, count, zero);
  store_lanes(body->along + i, count, zero);
}

/* G of M; the sums of pass A2 start at zero. */
SDR_INLINE void gradients_of(const int n, const sdr_nonordinary_body *body, int32_t first,
                             int32_t end)
{
  int32_t i = first;
  for (; i + SDR_WIDTH <= end; i += SDR_WIDTH) gradients_of_lanes(n, body, i, SDR_WIDTH);
  if (i < end) gradients_of_lanes(n, body, i, end - i);
}

#endif
