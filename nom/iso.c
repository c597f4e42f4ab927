/* Lattice isotropy correction: weights that make the fourth moments of a family isotropic. */
#include "base/memory.h"
#include "nom/family.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>

/* Mean over directions of each quartic monomial: 3/8, 1/8 in 2-D; 1/5, 1/15 in 3-D; odd ones 0. */
void sdr_quartic_means(int components, double mean[SDR_MONOMIALS])
{
  static const double pure[3] = {1.0, 3.0 / 8.0, 1.0 / 5.0};
  static const double mixed[3] = {0.0, 1.0 / 8.0, 1.0 / 15.0};
  int count = 0;
  for (int a = 4; a >= 0; --a)
    for (int b = 4 - a; b >= 0; --b) {
      const int c = 4 - a - b;
      if ((components < 3 && c > 0) || (components < 2 && b > 0)) continue;
      const int even = a % 2 == 0 && b % 2 == 0 && c % 2 == 0;
      const int single = a == 4 || b == 4 || c == 4;
      mean[count++] = !even ? 0.0 : single ? pure[components - 1] : mixed[components - 1];
    }
}

static sdr_status least_squares(size_t n, gsl_matrix *a, gsl_vector *right, gsl_vector *x)
{
  gsl_matrix *v = gsl_matrix_alloc(n, n);
  gsl_vector *s = gsl_vector_alloc(n), *work = gsl_vector_alloc(n);
  sdr_status status = SDR_RUN_FAILED;
  if (v && s && work && gsl_linalg_SV_decomp(a, v, s, work) == GSL_SUCCESS) {
    /* Directions that the family does not resolve stay uncorrected. */
    for (size_t k = 0; k < n; ++k)
      if (gsl_vector_get(s, k) < 1e-10 * gsl_vector_get(s, 0)) gsl_vector_set(s, k, 0.0);
    if (gsl_linalg_SV_solve(a, v, s, right, x) == GSL_SUCCESS) status = SDR_OK;
  }
  gsl_matrix_free(v);
  gsl_vector_free(s);
  gsl_vector_free(work);
  return status;
}

sdr_status sdr_iso_solve(int components, const double *gram, const double *moment, double m,
                         double lambda[SDR_MONOMIALS])
{
  gsl_set_error_handler_off();
  const size_t n = (size_t)sdr_monomial_count(components);
  double mean[SDR_MONOMIALS];
  sdr_quartic_means(components, mean);
  gsl_matrix *a = gsl_matrix_alloc(n, n);
  gsl_vector *right = gsl_vector_alloc(n), *x = gsl_vector_alloc(n);
  sdr_status status = SDR_RUN_FAILED;
  if (a && right && x && m > 0.0) {
    for (size_t r = 0; r < n; ++r) {
      gsl_vector_set(right, r, mean[r] - moment[r] / m);
      for (size_t c = 0; c < n; ++c) gsl_matrix_set(a, r, c, gram[r * n + c] / m);
    }
    status = least_squares(n, a, right, x);
  }
  if (status == SDR_OK)
    for (size_t k = 0; k < n; ++k) lambda[k] = gsl_vector_get(x, k);
  else
    sdr_fail(status, "the isotropy weights of a family could not be solved for");
  gsl_matrix_free(a);
  gsl_vector_free(right);
  gsl_vector_free(x);
  return status;
}
