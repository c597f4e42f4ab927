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

SDR_INLINE void points_of(const int n, const int elasticity, const int split, const int task,
                          const sdr_nonordinary_body *body, int32_t first, int32_t end)
{
#pragma omp simd
  for (int32_t i = first; i < end; ++i) point_at(n, elasticity, split, task, body, i);
}

/* G of M; the sums of pass A2 start at zero. */
SDR_INLINE void gradients_of(const int n, const sdr_nonordinary_body *body, int32_t first,
                             int32_t end)
{
#pragma omp simd
  for (int32_t i = first; i < end; ++i) {
    double m[9], g[9];
    load_matrix(n, body->gradient, i, m);
    times_inverse(n, body, i, m, g);
    store_matrix(n, g, i, body->gradient);
    for (int k = 0; k < n * n; ++k) body->bearing[k][i] = 0.0;
    body->square[i] = body->along[i] = 0.0;
  }
}

#endif
