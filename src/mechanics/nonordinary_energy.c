/* Energies of single points, whose families are about to lose bonds. */
#include "mechanics/nonordinary_internal.h"

/* out = a K^-1 */
static void times_inverse(int n, const sdr_nonordinary_body *body, int64_t i, const double *a,
                          double *out)
{
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      double sum = 0.0;
      for (int k = 0; k < n; ++k) sum += a[n * r + k] * body->inverse[sdr_upper(n, k, c)][i];
      out[n * r + c] = sum;
    }
}

static void load_matrix(int n, double *const from[9], int64_t i, double *to)
{
  for (int k = 0; k < n * n; ++k) to[k] = from[k][i];
}
/* Q of the kept values and the trace of M. */
static void load_normal(int n, const sdr_nonordinary_body *body, int64_t i, const double *m,
                        double *q)
{
  double last = sdr_trace(n, m);
  int k = 0;
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      const double value = k < (n == 1 ? 0 : n == 2 ? 2 : 5) ? body->moment[k][i] : last;
      ++k;
      q[n * a + b] = q[n * b + a] = value;
      if (a == b) last -= value;
    }
}

/* S = -(Q - C:G), C the fourth moments. */
static void normal_sum(int n, const sdr_nonordinary_body *body, int64_t i, const double *q,
                       const double *strain, double *s)
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

void sdr_nonordinary_gradient(const sdr_nonordinary_model *model, int32_t i)
{
  const int n = model->state.head.points->components;
  double m[9], g[9] = {0.0};
  load_matrix(n, model->body.gradient, i, m);
  times_inverse(n, &model->body, i, m, g);
  for (int k = 0; k < n * n; ++k) model->body.gradient[k][i] = g[k];
  model->body.square[i] = model->body.along[i] = 0.0;
}

/* sum W |eta - G xi|^2 and sum W (eta.n - n.G xi)^2, multiplied out, in place of those of eta;
   G in g. */
static void linear_sums(const sdr_nonordinary_model *model, int32_t i, double *g, double sum[2])
{
  const sdr_nonordinary_body *body = &model->body;
  const int n = model->state.head.points->components;
  double m[9], q[9], strain[9], s[9];
  load_matrix(n, body->gradient, i, m);
  load_normal(n, body, i, m, q);
  times_inverse(n, body, i, m, g);
  sdr_strain_of(n, 0, g, strain);
  normal_sum(n, body, i, q, strain, s);
  sum[0] -= sdr_contract(n, g, m);
  sum[1] += sdr_contract(n, strain, s) - sdr_contract(n, strain, q);
}

void sdr_nonordinary_energy(const sdr_nonordinary_model *model, int32_t i)
{
  const sdr_nonordinary_body *body = &model->body;
  const int n = model->state.head.points->components;
  const sdr_moduli moduli = {model->lambda[i], model->mu[i], body->plane_stress};
  const double volume = body->points->volume[i];
  double g[9], sum[2] = {body->square[i], body->along[i]};
  sdr_point_stress stress;
  if (model->elasticity == SDR_LINEAR)
    linear_sums(model, i, g, sum);
  else
    load_matrix(n, body->gradient, i, g);
  sdr_stress_of(n, model->elasticity, SDR_SPLIT_WHOLE, &moduli, g, &stress);
  const double control = 0.5 * (body->shear[i] * sum[0] + body->normal[i] * sum[1]);
  body->plus[i] = stress.plus + (volume > 0.0 ? control / volume : 0.0);
  body->minus[i] = stress.minus;
}
