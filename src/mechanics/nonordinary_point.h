/* From the sums over the families of points to what bears on their bonds: gradient, stress, damage,
   and the share of the control energy that comes from z = eta - G xi hanging on G. Literals as in
   nonordinary_loop.h; points are the lanes. */
#ifndef SDR_MECHANICS_NONORDINARY_POINT_H
#define SDR_MECHANICS_NONORDINARY_POINT_H

#include "mechanics/nonordinary_loop.h"
#include "mechanics/nonordinary_neo.h"
#include "mechanics/stress.h"

/* Passes A and A2 of points. */
typedef void (*sdr_lanes_gather)(const sdr_lanes_points *at, sdr_lanes_sums *out);
typedef void (*sdr_lanes_control)(const sdr_lanes_points *at, const sdr_lanes *g,
                                  sdr_lanes_sums *out);
/* Forces of points. */
typedef void (*sdr_lanes_spread)(const sdr_lanes_points *at, const sdr_bearing *bearing,
                                 double *const f[3]);
/* Stress of points i and after at G, n x n. */
typedef void (*sdr_lanes_law)(const sdr_nonordinary_body *body, int64_t i, const sdr_lanes *g,
                              sdr_lanes_stress *out);

/* ---- small matrices -------------------------------------------------------------------------- */

/* out = a b */
SDR_INLINE void lanes_multiply(const int n, const sdr_lanes *a, const sdr_lanes *b, sdr_lanes *out)
{
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      out[n * r + c] = a[n * r] * b[c];
      for (int k = 1; k < n; ++k)
        out[n * r + c] = fma_lanes(a[n * r + k], b[n * k + c], out[n * r + c]);
    }
}

/* out = a K^-1 */
SDR_INLINE void lanes_times_inverse(const int n, const sdr_nonordinary_body *body, int64_t i,
                                    const sdr_lanes *a, sdr_lanes *out)
{
  sdr_lanes inverse[9];
  for (int r = 0; r < n; ++r)
    for (int c = r; c < n; ++c)
      inverse[n * r + c] = inverse[n * c + r] = load_lanes(body->inverse[sdr_upper(n, r, c)] + i);
  lanes_multiply(n, a, inverse, out);
}

SDR_INLINE sdr_lanes lanes_contract(const int n, const sdr_lanes *a, const sdr_lanes *b)
{
  sdr_lanes sum = a[0] * b[0];
  for (int k = 1; k < n * n; ++k) sum = fma_lanes(a[k], b[k], sum);
  return sum;
}

SDR_INLINE sdr_lanes lanes_trace(const int n, const sdr_lanes *a)
{
  sdr_lanes trace = a[0];
  for (int r = 1; r < n; ++r) trace += a[(n + 1) * r];
  return trace;
}

/* sdr_strain_of */
SDR_INLINE void lanes_strain(const int n, const int finite, const sdr_lanes *g, sdr_lanes *e)
{
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      sdr_lanes sum = g[n * a + b] + g[n * b + a];
      for (int c = 0; finite && c < n; ++c) sum = fma_lanes(g[n * c + a], g[n * c + b], sum);
      e[n * a + b] = e[n * b + a] = 0.5 * sum;
    }
}

/* sdr_piola_of, in place */
SDR_INLINE void lanes_piola(const int n, const sdr_lanes *g, sdr_lanes *s)
{
  sdr_lanes turned[9];
  lanes_multiply(n, g, s, turned);
  for (int k = 0; k < n * n; ++k) s[k] += turned[k];
}

/* ---- laws ------------------------------------------------------------------------------------ */

/* sdr_strain_law, whole or split by dilatation, and the first Piola stress of it. */
SDR_INLINE void strain_law(const int n, const int finite, const int split,
                           const sdr_nonordinary_body *body, int64_t i, const sdr_lanes *g,
                           sdr_lanes_stress *out)
{
  const sdr_lanes mu = load_lanes(body->mu + i), zero = all_lanes(0.0);
  const sdr_lanes bulk = load_lanes(body->lambda + i) + (2.0 / n) * mu;
  sdr_lanes e[9], square = zero;
  lanes_strain(n, finite, g, e);
  const sdr_lanes trace = lanes_trace(n, e), share = (1.0 / n) * trace;
  const sdr_lanes grown = split == SDR_SPLIT_WHOLE ? trace : where_above(trace, zero, trace, zero);
  const sdr_lanes shrunk = trace - grown;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      const sdr_lanes part = a == b ? e[n * a + b] - share : e[n * a + b];
      square = fma_lanes(part, part, square);
      out->p_plus[n * a + b] = 2.0 * mu * part;
      out->p_minus[n * a + b] = zero;
      if (a != b) continue;
      out->p_plus[n * a + b] += bulk * grown;
      out->p_minus[n * a + b] = bulk * shrunk;
    }
  out->plus = 0.5 * bulk * grown * grown + mu * square;
  out->minus = 0.5 * bulk * shrunk * shrunk;
  if (!finite) return;
  lanes_piola(n, g, out->p_plus);
  if (split != SDR_SPLIT_WHOLE) lanes_piola(n, g, out->p_minus);
}

/* What looks for principal values: lane by lane. */
SDR_INLINE void law_by_lane(const int n, const int elasticity, const int split,
                            const sdr_nonordinary_body *body, int64_t i, const sdr_lanes *g,
                            sdr_lanes_stress *out)
{
  for (int l = 0; l < SDR_WIDTH; ++l) {
    const sdr_moduli moduli = {body->lambda[i + l], body->mu[i + l], body->plane_stress};
    double gradient[9];
    sdr_point_stress stress;
    for (int k = 0; k < n * n; ++k) gradient[k] = g[k][l];
    sdr_stress_at(n, elasticity, split, &moduli, gradient, &stress);
    out->plus[l] = stress.plus;
    out->minus[l] = stress.minus;
    for (int k = 0; k < n * n; ++k) {
      out->p_plus[k][l] = stress.p_plus[k];
      out->p_minus[k][l] = stress.p_minus[k];
    }
  }
}

SDR_INLINE void law_of_lanes(const int n, const int elasticity, const int split,
                             const sdr_nonordinary_body *body, int64_t i, const sdr_lanes *g,
                             sdr_lanes_stress *out)
{
  if (split == SDR_SPLIT_SPECTRAL)
    law_by_lane(n, elasticity, split, body, i, g, out);
  else if (elasticity == SDR_NEO_HOOKEAN)
    neo_hookean_lanes(n, split, body, i, g, out);
  else
    strain_law(n, elasticity != SDR_LINEAR, split, body, i, g, out);
}

/* ---- states ---------------------------------------------------------------------------------- */

/* A point's G, what pass B takes for it (linear: sym G), S, and the sums of W |z|^2, W (z.n)^2. */
typedef struct {
  sdr_lanes g[9], strain[9], s[9], square, along;
} sdr_lanes_state;

/* S = -(Q - C:G), C the fourth moments, Q of the kept values and the trace of M; the sums
   multiplied out. */
SDR_INLINE void linear_state(const int n, const int sums, const sdr_nonordinary_body *body,
                             int64_t i, const sdr_lanes_sums *of, sdr_lanes_state *out)
{
  sdr_lanes q[9], quartic[15], last = lanes_trace(n, of->m);
  int kept = 0;
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      q[n * a + b] = q[n * b + a] = kept < kept_of_normal(n) ? of->q[kept] : last;
      ++kept;
      if (a == b) last -= q[n * a + b];
    }
  lanes_strain(n, 0, out->g, out->strain);
  for (int k = 0; k < (n == 1 ? 1 : n == 2 ? 5 : 15); ++k)
    quartic[k] = load_lanes(body->quartic[k] + i);
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      /* cppcheck-suppress uninitvar ; the loops above set all n x n of them */
      sdr_lanes sum = -q[n * a + b];
      for (int c = 0; c < n; ++c)
        for (int d = 0; d < n; ++d)
          sum = fma_lanes(quartic[sdr_quartic_index(n, a, b, c, d)], out->strain[n * c + d], sum);
      out->s[n * a + b] = out->s[n * b + a] = sum;
    }
  if (!sums) return;
  out->square = of->square - lanes_contract(n, out->g, of->m);
  out->along =
      of->along - lanes_contract(n, out->strain, q) + lanes_contract(n, out->strain, out->s);
}

/* A = (V P + stiff S) K^-1, less soft G, which turns soft z into soft eta. */
SDR_INLINE void bearing_of(const int n, const int finite, const sdr_nonordinary_body *body,
                           int64_t i, const sdr_lanes_state *state, const sdr_lanes *stress,
                           sdr_lanes intact, sdr_bearing *out)
{
  const sdr_lanes volume = load_lanes(body->points->volume + i);
  sdr_lanes sum[9];
  out->soft = intact * load_lanes(body->shear + i);
  out->stiff = intact * load_lanes(body->normal + i);
  for (int k = 0; k < n * n; ++k) sum[k] = fma_lanes(volume, stress[k], out->stiff * state->s[k]);
  lanes_times_inverse(n, body, i, sum, out->a);
  for (int k = 0; k < n * n; ++k) {
    out->a[k] = fma_lanes(-out->soft, state->g[k], out->a[k]);
    out->g[k] = finite ? state->g[k] : out->stiff * state->strain[k];
  }
}

/* For loose pairs. */
SDR_INLINE void store_bearing(const int n, const int finite, const sdr_lanes_points *at,
                              const sdr_bearing *bearing)
{
  const int size = sdr_bearing_size(n, finite);
  double row[24][SDR_WIDTH] = {{0.0}};
  int entry[9], k = 0;
  const int entries = gradient_entries(n, finite, entry);
  for (int a = 0; a < n; ++a, ++k)
    if (at->u) store_lanes(row[k], load_lanes(at->u[a] + at->i));
  store_lanes(row[k++], bearing->soft);
  store_lanes(row[k++], bearing->stiff);
  for (int e = 0; e < n * n; ++e) store_lanes(row[k++], bearing->a[e]);
  for (int e = 0; e < entries; ++e) store_lanes(row[k++], bearing->g[entry[e]]);
  for (int l = 0; l < SDR_WIDTH; ++l) {
    double *const to = at->body->bearings + (at->i + l) * size;
    for (k = 0; k < size; ++k) to[k] = row[k][l];
  }
}

/* psi+ and the control energy. */
SDR_INLINE sdr_lanes driving_energy(const sdr_nonordinary_body *body, int64_t i, sdr_lanes plus,
                                    const sdr_lanes_state *state)
{
  const sdr_lanes one = all_lanes(1.0), zero = all_lanes(0.0);
  const sdr_lanes volume = load_lanes(body->points->volume + i);
  const sdr_lanes control = 0.5 * (load_lanes(body->shear + i) * state->square +
                                   load_lanes(body->normal + i) * state->along);
  return plus + where_above(volume, zero, control / where_above(volume, zero, volume, one), zero);
}

/* What a state becomes once its stress is known. */
SDR_INLINE void finish_state(const int n, const int finite, const int task,
                             const sdr_nonordinary_body *body, int64_t i,
                             const sdr_lanes_state *state, sdr_lanes_stress *stress,
                             sdr_bearing *out)
{
  const sdr_lanes one = all_lanes(1.0);
  sdr_lanes intact = one;
  if (task != SDR_POINT_ELASTIC) {
    const sdr_lanes plus = driving_energy(body, i, stress->plus, state);
    if (task == SDR_POINT_ENERGY) {
      store_lanes(body->plus + i, plus);
      store_lanes(body->minus + i, stress->minus);
      for (int k = 0; k < n * n; ++k)
        store_lanes(body->gradient[k] + i, finite ? state->g[k] : state->strain[k]);
      return;
    }
    const sdr_lanes before = load_lanes(body->history + i);
    const sdr_lanes grown = where_above(plus, before, plus, before);
    const sdr_lanes left = one / fma_lanes(grown, load_lanes(body->softness + i), one);
    if (body->commit) store_lanes(body->history + i, grown);
    intact = left * left;
    for (int k = 0; k < n * n; ++k)
      stress->p_plus[k] = fma_lanes(intact, stress->p_plus[k], stress->p_minus[k]);
  }
  bearing_of(n, finite, body, i, state, stress->p_plus, intact, out);
}

SDR_INLINE void state_of(const int n, const int finite, const int task, sdr_lanes_gather gather_all,
                         sdr_lanes_control control_all, sdr_lanes_spread spread_all,
                         sdr_lanes_law law, double *const f[3], const sdr_lanes_points *at)
{
  const int sums = task != SDR_POINT_ELASTIC;
  sdr_lanes_sums of;
  sdr_lanes_state state;
  sdr_lanes_stress stress;
  sdr_bearing bearing;
  if (at->u)
    gather_all(at, &of);
  else
    memset(&of, 0, sizeof of);
  lanes_times_inverse(n, at->body, at->i, of.m, state.g);
  if (finite) {
    if (at->u) control_all(at, state.g, &of);
    copy_matrix(n, of.s, state.s);
    state.square = of.square;
    state.along = of.along;
  } else {
    linear_state(n, sums, at->body, at->i, &of, &state);
  }
  law(at->body, at->i, state.g, &stress);
  finish_state(n, finite, task, at->body, at->i, &state, &stress, &bearing);
  if (task == SDR_POINT_ENERGY) return;
  if (at->body->bonds->loose.chunk_count > 0) store_bearing(n, finite, at, &bearing);
  if (at->u && f) spread_all(at, &bearing, f);
}

#endif
