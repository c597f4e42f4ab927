/* Fields of non-ordinary bodies that are their own: stress, strain, dilatation. */
#include "mechanics/nonordinary_internal.h"

/* Components of a symmetric tensor as fields hold them: xx | xx yy xy | xx yy zz yz xz xy. */
static int tensor_entries(int n, int entry[6])
{
  static const int plane[3] = {0, 3, 1}, space[6] = {0, 4, 8, 5, 2, 1};
  const int count = n == 1 ? 1 : n == 2 ? 3 : 6;
  for (int k = 0; k < count; ++k) entry[k] = n == 1 ? 0 : n == 2 ? plane[k] : space[k];
  return count;
}

static void strain_of(int n, const double *g, double *out)
{
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) out[n * a + b] = 0.5 * (g[n * a + b] + g[n * b + a]);
}

/* Stress of point i with its damage: true (Cauchy) stress for finite strain. */
static void stress_of(const sdr_nonordinary_model *model, int32_t i, const double *g, double *out)
{
  const int n = model->state.head.points->components;
  const sdr_moduli moduli = {model->lambda[i], model->mu[i], model->body.plane_stress};
  const double left = 1.0 - sdr_state_damage(&model->state, i, model->state.plus[i]);
  double piola[9], across = 1.0;
  sdr_point_stress stress;
  sdr_stress_of(n, model->elasticity, model->split, &moduli, g, &stress);
  const int dead = model->body.shear[i] <= 0.0 && model->body.inverse[0][i] <= 0.0;
  for (int k = 0; k < n * n; ++k)
    piola[k] = dead ? 0.0 : left * left * stress.p_plus[k] + stress.p_minus[k];
  if (model->elasticity == SDR_LINEAR) {
    for (int k = 0; k < n * n; ++k) out[k] = piola[k];
    return;
  }
  if (model->state.dimension == SDR_PLANE_STRESS)
    across = sdr_plane_thickness(model->elasticity, &moduli, g);
  sdr_cauchy(n, g, piola, across, out);
}

sdr_status sdr_nonordinary_field(sdr_model *model, double *const u[3], sdr_model_field which,
                                 double *out)
{
  sdr_nonordinary_model *own = (sdr_nonordinary_model *)model;
  const int n = model->points->components;
  const size_t points = (size_t)model->points->count;
  int entry[6];
  const int entries = tensor_entries(n, entry);
  if (which != SDR_FIELD_STRESS && which != SDR_FIELD_STRAIN && which != SDR_FIELD_DILATATION)
    return sdr_state_field(model, u, which, out);
  own->state.hooks->split(&own->state, u);
  for (int32_t i = 0; i < model->points->count; ++i) {
    double g[9], tensor[9];
    for (int k = 0; k < n * n; ++k) g[k] = own->body.gradient[k][i];
    if (which == SDR_FIELD_DILATATION) {
      out[i] = sdr_trace(n, g);
      continue;
    }
    if (which == SDR_FIELD_STRESS)
      stress_of(own, i, g, tensor);
    else
      strain_of(n, g, tensor);
    for (int k = 0; k < entries; ++k) out[(size_t)k * points + (size_t)i] = tensor[entry[k]];
  }
  return SDR_OK;
}
