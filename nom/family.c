#include "nom/family.h"

#include "base/memory.h"
#include "nom/family_sums.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- weights --------------------------------------------------------------------------------- */

double sdr_family_plain_weight(const sdr_families *families, const sdr_family *family,
                               double spacing, double length)
{
  /* A neighbour on the horizon itself stays one, and that shows in a weight above zero. */
  static const double least = 1e-12;
  const sdr_families_how *how = &families->how;
  double b = sdr_influence_at(how->influence, length / family->horizon);
  if (how->partial_volume) b *= sdr_partial_volume(length, family->horizon, spacing);
  return b > least ? b : least;
}

/* (sum n_a^2/S_a^2)^(-1/2) */
static double ellipsoid(int components, const double factor[3], const double n[3])
{
  double sum = 0.0;
  for (int a = 0; a < components; ++a) sum += n[a] * n[a] / (factor[a] * factor[a]);
  return 1.0 / sqrt(sum);
}

/* Length of xi, and its direction. */
static double direction(const double xi[3], double n[3])
{
  const double length = sqrt(xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]);
  for (int a = 0; a < 3; ++a) n[a] = xi[a] / length;
  return length;
}

/* The correction of a full family along n. */
static double bulk_correction(const sdr_families *families, const sdr_family *family,
                              const double n[3])
{
  const int components = families->points->components;
  switch (families->how.correction) {
  case SDR_CORRECTION_ISO:
  case SDR_CORRECTION_SURFACE_ISO:
    return sdr_iso_weight(components, family->lambda, n);
  case SDR_CORRECTION_MADENCI_OTERKUS:
    return ellipsoid(components, family->axial, n);
  default:
    return 1.0;
  }
}

double sdr_family_bond_weight(const sdr_families *families, const sdr_family *family,
                              const double xi[3])
{
  double n[3];
  const double b = sdr_family_plain_weight(families, family, family->spacing, direction(xi, n));
  return b * bulk_correction(families, family, n);
}

/* Of both points' own factors, the mean; a point without a family has none, so the other's. */
static double pair_correction(const sdr_families *families, int32_t i, int32_t j, const double n[3])
{
  const size_t components = (size_t)families->points->components;
  const double *si = families->axial + components * (size_t)i;
  const double *sj =
      sdr_has_family(families->points, j) ? families->axial + components * (size_t)j : si;
  double mean[3] = {0.0};
  for (size_t a = 0; a < components; ++a) mean[a] = 0.5 * (si[a] + sj[a]);
  return ellipsoid((int)components, mean, n);
}

double sdr_families_weight(const void *context, int32_t i, int32_t j, const double xi[3])
{
  const sdr_families *families = context;
  const sdr_points *points = families->points;
  const sdr_family *family = sdr_family_of(families, i);
  double n[3];
  const double b = sdr_family_plain_weight(families, family, points->spacing[j], direction(xi, n));
  if (families->axial) return b * pair_correction(families, i, j, n);
  if (families->cubic && families->border[i] && families->border[j])
    return b * bulk_correction(families, family, n) * sdr_border_factor(families, i, j, n);
  if (!families->lambda) return b * bulk_correction(families, family, n);
  const double *lambda = families->lambda + SDR_MONOMIALS * (size_t)i;
  return b * (families->scale ? families->scale[i] : 1.0) *
         sdr_iso_weight(points->components, lambda, n);
}

/* ---- a lattice's full stencil ---------------------------------------------------------------- */

void sdr_stencil_vector(const sdr_points *points, double spacing, const int32_t step[3],
                        double xi[3])
{
  for (int b = 0; b < 3; ++b) xi[b] = 0.0;
  for (int a = 0; a < points->components; ++a)
    for (int b = 0; b < points->components; ++b) xi[b] += spacing * step[a] * points->axes[a][b];
}

static int is_iso(const sdr_families *families)
{
  return families->how.correction == SDR_CORRECTION_ISO ||
         families->how.correction == SDR_CORRECTION_SURFACE_ISO;
}

static int is_axial(const sdr_families *families)
{
  return families->how.correction == SDR_CORRECTION_MADENCI_OTERKUS;
}

static sdr_status moments_of_stencil(sdr_families *families, sdr_family *family)
{
  sdr_stencil stencil;
  const int components = families->points->components;
  SDR_TRY(sdr_stencil_create(components, family->spacing, family->horizon, &stencil));
  family->source = SDR_MOMENTS_STENCIL;
  family->neighbours = stencil.count;
  int removed = 0;
  for (int k = 0; k < stencil.count; ++k) removed += stencil.step[3 * k] > 0;
  family->cut_share = (double)removed / stencil.count;
  for (int a = 0; a < 3; ++a) family->axial[a] = 1.0;
  sdr_status status = SDR_OK;
  const sdr_family_sums plain = sdr_sum_stencil(families, family, &stencil, SDR_WEIGHED_PLAIN);
  family->moment = plain.moment;
  if (is_iso(families))
    status = sdr_iso_solve(components, plain.gram, plain.quartic, plain.moment, family->lambda);
  if (is_axial(families)) sdr_axial_factors(families, family, plain.quartic, family->axial);
  if (status == SDR_OK) {
    const sdr_family_sums full = sdr_sum_stencil(families, family, &stencil, SDR_WEIGHED_FULL);
    family->first = is_axial(families) ? plain.first : full.first;
    family->moment = is_axial(families) ? plain.moment : full.moment;
    family->second = full.second;
    memcpy(family->quartic, full.quartic, sizeof family->quartic);
  }
  sdr_stencil_destroy(&stencil);
  return status;
}

/* ---- what each point's own family asks for --------------------------------------------------- */

/* 1 if the point's family is the full stencil, of its own kind of points only. */
static int is_full(const sdr_families *families, const sdr_neighbourhood *near, int32_t i)
{
  const sdr_family *own = sdr_family_of(families, i);
  if (near->row[i + 1] - near->row[i] != own->neighbours) return 0;
  for (int64_t k = near->row[i]; families->of_point && k < near->row[i + 1]; ++k)
    if (sdr_family_of(families, near->column[k]) != own) return 0;
  return 1;
}

static sdr_status find_bulk(sdr_families *families, const sdr_neighbourhood *near)
{
  const sdr_points *points = families->points;
  if (points->row_count == 0) return SDR_OK;
  families->bulk = sdr_alloc(sdr_points_padded(points), 1);
  if (!families->bulk) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < points->count; ++i)
    families->bulk[i] = (uint8_t)is_full(families, near, i);
  return SDR_OK;
}

/* Means of the corrected weights, where the constants stay those of the plain ones. */
static sdr_status axial_means(sdr_families *families, const sdr_neighbourhood *near)
{
  double(*kept)[2] = sdr_alloc((size_t)families->count, sizeof *kept);
  if (!kept) return SDR_RUN_FAILED;
  for (int f = 0; f < families->count; ++f) {
    sdr_family *family = &families->family[f];
    kept[f][0] = family->first;
    kept[f][1] = family->moment;
    sdr_axial_factors(families, family, family->quartic, family->axial);
  }
  const sdr_status status = sdr_irregular_moments(families, near);
  for (int f = 0; f < families->count; ++f) {
    families->family[f].first = kept[f][0];
    families->family[f].moment = kept[f][1];
  }
  sdr_free(kept);
  return status;
}

static sdr_status correct_points(sdr_families *families, const sdr_neighbourhood *near)
{
  const int irregular = families->points->irregular;
  const int surface = families->how.correction == SDR_CORRECTION_SURFACE_ISO;
  if (!irregular) SDR_TRY(find_bulk(families, near));
  if (is_iso(families)) SDR_TRY(sdr_own_iso_weights(families, near));
  if (irregular) SDR_TRY(sdr_irregular_moments(families, near));
  if (surface) SDR_TRY(sdr_own_scales(families, near));
  if (!is_axial(families)) return SDR_OK;
  SDR_TRY(sdr_own_axial_factors(families, near));
  return irregular ? axial_means(families, near) : SDR_OK;
}

/* 1 if the weights at the border of two spacings are to be found. */
static int has_border(const sdr_families *families)
{
  return families->how.balance && families->count > 1 && families->points->row_count > 0 &&
         (families->how.correction == SDR_CORRECTION_NONE ||
          families->how.correction == SDR_CORRECTION_ISO);
}

static sdr_status correct(sdr_families *families)
{
  const int surface = families->how.correction == SDR_CORRECTION_SURFACE_ISO;
  const int border = has_border(families);
  if (!families->points->irregular && !surface && !is_axial(families) && !border) return SDR_OK;
  sdr_neighbourhood near;
  SDR_TRY(sdr_neighbourhood_create(families->points, &near));
  const sdr_status status =
      border ? sdr_border_weights(families, &near) : correct_points(families, &near);
  sdr_neighbourhood_destroy(&near);
  return status;
}

/* ---- which points share a family ------------------------------------------------------------- */

static int compare_points(const sdr_points *p, int32_t i, int32_t j)
{
  if (p->spacing[i] != p->spacing[j]) return p->spacing[i] < p->spacing[j] ? -1 : 1;
  if (p->horizon[i] != p->horizon[j]) return p->horizon[i] < p->horizon[j] ? -1 : 1;
  if (p->volume[i] != p->volume[j]) return p->volume[i] < p->volume[j] ? -1 : 1;
  return 0;
}

static int by_family(const void *left, const void *right, void *points)
{
  const int32_t i = *(const int32_t *)left, j = *(const int32_t *)right;
  const int order = compare_points(points, i, j);
  return order != 0 ? order : i < j ? -1 : i > j;
}

static int all_alike(const sdr_points *points)
{
  for (int32_t i = 1; i < points->count; ++i)
    if (compare_points(points, 0, i) != 0) return 0;
  return 1;
}

static void start_family(sdr_families *families, int32_t i)
{
  const sdr_points *points = families->points;
  families->family[families->count++] = (sdr_family){
      .spacing = points->spacing[i], .horizon = points->horizon[i], .volume = points->volume[i]};
}

static sdr_status group_points(sdr_families *families)
{
  const sdr_points *points = families->points;
  if (all_alike(points)) {
    families->family = sdr_alloc(1, sizeof *families->family);
    if (!families->family) return SDR_RUN_FAILED;
    start_family(families, 0);
    return SDR_OK;
  }
  const size_t count = (size_t)points->count;
  int32_t *order = sdr_alloc(count, sizeof *order);
  families->of_point = sdr_alloc(sdr_points_padded(points), sizeof *families->of_point);
  sdr_status status = SDR_RUN_FAILED;
  if (!order || !families->of_point) goto cleanup;
  for (int32_t i = 0; i < points->count; ++i) order[i] = i;
  qsort_r(order, count, sizeof *order, by_family, (void *)(uintptr_t)points);
  size_t distinct = 1;
  for (size_t k = 1; k < count; ++k)
    distinct += compare_points(points, order[k - 1], order[k]) != 0;
  families->family = sdr_alloc(distinct, sizeof *families->family);
  if (!families->family) goto cleanup;
  for (size_t k = 0; k < count; ++k) {
    if (k == 0 || compare_points(points, order[k - 1], order[k]) != 0)
      start_family(families, order[k]);
    families->of_point[order[k]] = families->count - 1;
  }
  status = SDR_OK;
cleanup:
  sdr_free(order);
  return status;
}

sdr_status sdr_families_create(const sdr_points *points, const sdr_families_how *how,
                               sdr_families **out)
{
  sdr_families *families = sdr_alloc(1, sizeof *families);
  if (!families) return SDR_RUN_FAILED;
  families->points = points;
  families->how = *how;
  sdr_status status = group_points(families);
  for (int f = 0; f < families->count && status == SDR_OK; ++f)
    status = moments_of_stencil(families, &families->family[f]);
  if (status == SDR_OK) status = correct(families);
  if (status != SDR_OK) {
    sdr_families_destroy(&families);
    return status;
  }
  *out = families;
  return SDR_OK;
}

void sdr_families_destroy(sdr_families **families)
{
  sdr_families *f = *families;
  if (!f) return;
  sdr_free(f->family);
  sdr_free(f->of_point);
  sdr_free(f->lambda);
  sdr_free(f->scale);
  sdr_free(f->axial);
  sdr_free(f->bulk);
  sdr_free(f->border);
  sdr_free(f->cubic);
  sdr_free(f);
  *families = NULL;
}
