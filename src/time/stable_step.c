#include "time/stable_step.h"

#include "base/memory.h"

#include <gsl/gsl_eigen.h>
#include <math.h>
#include <string.h>

enum { MOST = 80, ENOUGH = 16 };

/* A vector over all components, and the scaled operator on it. */
typedef struct {
  sdr_system *system;
  size_t padded;
  double *root;                                   /* 1/sqrt(mass) */
  double *now, *before, *product, *scaled, *back; /* components * padded each */
} lanczos;

static void components_of(const lanczos *l, double *vector, double *parts[3])
{
  for (int a = 0; a < 3; ++a)
    parts[a] = a < l->system->components ? vector + (size_t)a * l->padded : NULL;
}

static double dot(const lanczos *l, const double *x, const double *y)
{
  double sum = 0.0;
  for (int a = 0; a < l->system->components; ++a)
    for (int32_t i = 0; i < l->system->count; ++i)
      sum += x[(size_t)a * l->padded + (size_t)i] * y[(size_t)a * l->padded + (size_t)i];
  return sum;
}

/* out = K v, K the stiffness of the body's points with their layers; its symmetric part if the
   layers' forces do not act back on what moves them. */
static void stiffness_times(const lanczos *l, double *const v[3], double *const out[3])
{
  sdr_system *system = l->system;
  const sdr_layers *layers = system->layers;
  if (layers) sdr_layers_extend(layers, SDR_LAYER_MOTION, v);
  system->model->ops->reference_times(system->model, v, out);
  if (system->contact) sdr_contact_bound_times(system->contact, v, out);
  if (!layers) return;
  sdr_layers_gather(layers, SDR_LAYER_FORCE, out);
  if (sdr_layers_symmetric(layers)) return;
  double *back[3];
  components_of(l, l->back, back);
  sdr_layers_extend(layers, SDR_LAYER_FORCE, v);
  system->model->ops->reference_times(system->model, v, back);
  sdr_layers_gather(layers, SDR_LAYER_MOTION, back);
  for (int a = 0; a < system->components; ++a)
    for (int32_t i = 0; i < system->count; ++i) out[a][i] = 0.5 * (out[a][i] + back[a][i]);
}

/* product = M^-1/2 K M^-1/2 now */
static void apply(const lanczos *l)
{
  double *v[3], *out[3];
  components_of(l, l->scaled, v);
  components_of(l, l->product, out);
  for (int a = 0; a < l->system->components; ++a)
    for (int32_t i = 0; i < l->system->count; ++i)
      v[a][i] = l->root[i] * l->now[(size_t)a * l->padded + (size_t)i];
  stiffness_times(l, v, out);
  for (int a = 0; a < l->system->components; ++a)
    for (int32_t i = 0; i < l->system->count; ++i) out[a][i] *= l->root[i];
}

/* A start that no symmetry of the body shares: noise from a fixed generator. */
static void start_vector(lanczos *l)
{
  uint64_t state = 88172645463325252u;
  for (int a = 0; a < l->system->components; ++a)
    for (int32_t i = 0; i < l->system->count; ++i) {
      state ^= state << 13;
      state ^= state >> 7;
      state ^= state << 17;
      l->now[(size_t)a * l->padded + (size_t)i] = (double)(state >> 11) * 0x1p-53 - 0.5;
    }
  const double scale = 1.0 / sqrt(dot(l, l->now, l->now));
  for (size_t k = 0; k < (size_t)l->system->components * l->padded; ++k) l->now[k] *= scale;
}

/* Largest eigenvalue of the tridiagonal matrix, and the bound on its error: the last component of
   its vector times the next off-diagonal. */
static int ritz(const double *alpha, const double *beta, size_t n, double *value, double *error)
{
  gsl_matrix *t = gsl_matrix_calloc(n, n), *vectors = gsl_matrix_alloc(n, n);
  gsl_vector *values = gsl_vector_alloc(n);
  gsl_eigen_symmv_workspace *work = gsl_eigen_symmv_alloc(n);
  int ok = t && vectors && values && work;
  if (ok) {
    for (size_t k = 0; k < n; ++k) {
      gsl_matrix_set(t, k, k, alpha[k]);
      if (k + 1 < n) {
        gsl_matrix_set(t, k, k + 1, beta[k]);
        gsl_matrix_set(t, k + 1, k, beta[k]);
      }
    }
    ok = gsl_eigen_symmv(t, values, vectors, work) == 0;
    const size_t largest = gsl_vector_max_index(values);
    *value = gsl_vector_get(values, largest);
    *error = beta[n - 1] * fabs(gsl_matrix_get(vectors, n - 1, largest));
  }
  gsl_matrix_free(t);
  gsl_matrix_free(vectors);
  gsl_vector_free(values);
  if (work) gsl_eigen_symmv_free(work);
  return ok;
}

/* One step of the recurrence; 0 when the space is exhausted. */
static int iterate(lanczos *l, double previous, double *alpha, double *beta)
{
  apply(l);
  *alpha = dot(l, l->now, l->product);
  const size_t size = (size_t)l->system->components * l->padded;
  for (size_t k = 0; k < size; ++k) l->product[k] -= *alpha * l->now[k] + previous * l->before[k];
  *beta = sqrt(dot(l, l->product, l->product));
  if (!(*beta > 1e-12 * fabs(*alpha))) return 0;
  memcpy(l->before, l->now, size * sizeof(double));
  for (size_t k = 0; k < size; ++k) l->now[k] = l->product[k] / *beta;
  return 1;
}

static sdr_status largest_eigenvalue(lanczos *l, double *largest)
{
  double alpha[MOST], beta[MOST], value = 0.0, error = INFINITY;
  start_vector(l);
  for (int n = 0; n < MOST; ++n) {
    const int more = iterate(l, n > 0 ? beta[n - 1] : 0.0, &alpha[n], &beta[n]);
    if (!more) beta[n] = 0.0;
    if (more && n < MOST - 1 && (n < ENOUGH || n % 4 != 0)) continue;
    if (!ritz(alpha, beta, (size_t)n + 1, &value, &error))
      return sdr_fail(SDR_RUN_FAILED, "the stable step could not be found: no eigenvalue");
    if (!more || error < 5e-3 * value) break;
  }
  *largest = value + error;
  return SDR_OK;
}

static int has_masses(const sdr_system *system)
{
  for (int32_t i = 0; i < system->count; ++i)
    if (sdr_in_body(system->model->points, i) && !(system->mass[i] > 0.0)) return 0;
  return 1;
}

sdr_status sdr_stable_step(sdr_system *system, double *limit)
{
  if (!has_masses(system)) {
    *limit = (double)NAN;
    return SDR_OK;
  }
  lanczos l = {.system = system, .padded = sdr_points_padded(system->model->points)};
  const size_t size = (size_t)system->components * l.padded;
  l.root = sdr_alloc(l.padded, sizeof(double));
  l.now = sdr_alloc(size, sizeof(double));
  l.before = sdr_alloc(size, sizeof(double));
  l.product = sdr_alloc(size, sizeof(double));
  l.scaled = sdr_alloc(size, sizeof(double));
  l.back = sdr_alloc(size, sizeof(double));
  sdr_status status = SDR_RUN_FAILED;
  if (l.root && l.now && l.before && l.product && l.scaled && l.back) {
    for (int32_t i = 0; i < system->count; ++i)
      l.root[i] = sdr_in_body(system->model->points, i) ? 1.0 / sqrt(system->mass[i]) : 0.0;
    double largest;
    status = largest_eigenvalue(&l, &largest);
    if (status == SDR_OK && system->contact)
      largest = fmax(largest, sdr_contact_loose_rate(system->contact, system->mass));
    if (status == SDR_OK) *limit = 2.0 / sqrt(largest);
  }
  sdr_free(l.root);
  sdr_free(l.now);
  sdr_free(l.before);
  sdr_free(l.product);
  sdr_free(l.scaled);
  sdr_free(l.back);
  return status;
}
