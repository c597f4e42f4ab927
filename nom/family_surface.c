/* Corrections from each point's own family, surfaces and interfaces included (theory sec. 5). */
#include "base/memory.h"
#include "nom/family_sums.h"

#include <math.h>
#include <string.h>

/* 1 if the point's family is the full stencil of its lattice. */
static int is_bulk(const sdr_families *families, int32_t i)
{
  return families->bulk && families->bulk[i];
}

sdr_status sdr_own_iso_weights(sdr_families *families, const sdr_neighbourhood *near)
{
  const sdr_points *points = families->points;
  families->lambda = sdr_alloc((size_t)points->count, SDR_MONOMIALS * sizeof(double));
  if (!families->lambda) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < points->count; ++i) {
    double *lambda = families->lambda + SDR_MONOMIALS * (size_t)i;
    if (is_bulk(families, i)) {
      memcpy(lambda, sdr_family_of(families, i)->lambda, SDR_MONOMIALS * sizeof *lambda);
      continue;
    }
    const sdr_family_sums own = sdr_sum_neighbours(families, near, i, SDR_WEIGHED_PLAIN);
    if (own.moment <= 0.0) continue; /* no neighbour: no weight */
    SDR_TRY(sdr_iso_solve(points->components, own.gram, own.quartic, own.moment, lambda));
  }
  return SDR_OK;
}

/* Bring each point's sum of r to the full family's: dilation then stores the exact energy. */
sdr_status sdr_own_scales(sdr_families *families, const sdr_neighbourhood *near)
{
  const sdr_points *points = families->points;
  double *scale = sdr_alloc((size_t)points->count, sizeof *scale);
  if (!scale) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < points->count; ++i) {
    scale[i] = 1.0;
    if (is_bulk(families, i)) continue;
    const double own = sdr_sum_neighbours(families, near, i, SDR_WEIGHED_FULL).moment;
    if (own > 0.0) scale[i] = sdr_family_of(families, i)->moment / own;
  }
  families->scale = scale;
  return SDR_OK;
}

/* ---- madenci_oterkus ------------------------------------------------------------------------- */

/* The sum of r that the model's constants stand for. */
static double promised(const sdr_families *families, const sdr_family *family)
{
  return families->how.printed
             ? sdr_continuum_moment(families->points, family, families->how.state_based)
             : family->moment;
}

/* Places of x^4, y^4, z^4 among the quartic monomials. */
static const int pure[3][3] = {{0, 0, 0}, {0, 4, 0}, {0, 10, 14}};

void sdr_axial_factors(const sdr_families *families, const sdr_family *family,
                       const double quartic[SDR_MONOMIALS], double factor[3])
{
  const int n = families->points->components;
  double mean[SDR_MONOMIALS];
  sdr_quartic_means(n, mean);
  for (int a = 0; a < 3; ++a) {
    const int k = pure[n - 1][a];
    factor[a] = a < n && quartic[k] > 0.0 ? mean[k] * promised(families, family) / quartic[k] : 1.0;
  }
}

/* sum[a] of point i += its half, and of j += the other half, of the bond i -> j. A point without a
   family stands for one inside, whose half of the mirrored bond counts for i. */
static void add_halves(const sdr_families *families, int32_t i, int32_t j, double *sum)
{
  const sdr_points *points = families->points;
  const int n = points->components;
  const sdr_family *family = sdr_family_of(families, i);
  double xi[3] = {0.0}, square = 0.0;
  for (int a = 0; a < n; ++a) {
    xi[a] = points->x[a][j] - points->x[a][i];
    square += xi[a] * xi[a];
  }
  const double length = sqrt(square);
  const double r = sdr_family_plain_weight(families, family, points->spacing[j], length) *
                   (families->how.state_based ? square : length) / promised(families, family);
  const double half = sdr_has_family(points, j) ? 0.5 : 1.0;
  for (int a = 0; a < n; ++a) {
    const double share = xi[a] * xi[a] / square;
    sum[(size_t)n * (size_t)i + (size_t)a] += half * r * share * share * points->volume[j];
    sum[(size_t)n * (size_t)j + (size_t)a] += 0.5 * r * share * share * points->volume[i];
  }
}

/* S_a = exact energy over the family's, both halves of each bond counted, of a uniform strain
   along axis a (003 sec. 3.2). */
sdr_status sdr_own_axial_factors(sdr_families *families, const sdr_neighbourhood *near)
{
  const sdr_points *points = families->points;
  const size_t n = (size_t)points->components;
  double mean[SDR_MONOMIALS];
  sdr_quartic_means(points->components, mean);
  double *sum = sdr_alloc((size_t)points->count, n * sizeof *sum);
  if (!sum) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < points->count; ++i)
    for (int64_t k = near->row[i]; k < near->row[i + 1]; ++k)
      add_halves(families, i, near->column[k], sum);
  for (int32_t i = 0; i < points->count; ++i)
    for (size_t a = 0; a < n; ++a) {
      double *factor = &sum[n * (size_t)i + a];
      if (is_bulk(families, i))
        *factor = sdr_family_of(families, i)->axial[a];
      else
        *factor = *factor > 0.0 ? mean[pure[n - 1][a]] / *factor : 1.0;
    }
  families->axial = sum;
  return SDR_OK;
}
