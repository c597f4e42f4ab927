#include "nom/family.h"

#include "base/memory.h"
#include "nom/neighbourhood.h"
#include "nom/stencil.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- sums over one family, bond by bond ------------------------------------------------------ */

typedef struct {
  int components;
  double first, second, volume;
  double offset[3]; /* sum xi V: far from 0 if the family is one-sided */
  double quartic[SDR_MONOMIALS];
  double gram[SDR_MONOMIALS * SDR_MONOMIALS];
} sums;

/* Add a neighbour at xi with volume v and weight b. */
static void add_bond(sums *s, const double xi[3], double v, double b)
{
  double square = 0.0, phi[SDR_MONOMIALS];
  for (int a = 0; a < s->components; ++a) square += xi[a] * xi[a];
  const double length = sqrt(square);
  const double n[3] = {xi[0] / length, xi[1] / length, xi[2] / length};
  const int count = sdr_quartic(s->components, n, phi);
  s->first += b * length * v;
  s->second += b * square * v;
  s->volume += v;
  for (int a = 0; a < 3; ++a) s->offset[a] += xi[a] * v;
  for (int r = 0; r < count; ++r) {
    s->quartic[r] += b * length * v * phi[r];
    for (int c = 0; c < count; ++c) s->gram[r * count + c] += b * length * v * phi[r] * phi[c];
  }
}

double sdr_family_bond_weight(const sdr_families *families, const sdr_family *family,
                              const double lambda[SDR_MONOMIALS], const double xi[3])
{
  const double length = sqrt(xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]);
  switch (families->weight) {
  case SDR_FAMILY_PARTIAL_VOLUME:
    return sdr_partial_volume(length, family->horizon, family->spacing);
  case SDR_FAMILY_ISO: {
    const double n[3] = {xi[0] / length, xi[1] / length, xi[2] / length};
    return sdr_iso_weight(families->points->components, lambda, n);
  }
  default:
    return 1.0;
  }
}

double sdr_families_weight(const void *context, int32_t i, int32_t j, const double xi[3])
{
  const sdr_families *families = context;
  (void)j;
  const sdr_family *family = sdr_family_of(families, i);
  const double *lambda =
      families->lambda ? families->lambda + SDR_MONOMIALS * (size_t)i : family->lambda;
  return sdr_family_bond_weight(families, family, lambda, xi);
}

/* ---- a lattice's full stencil ---------------------------------------------------------------- */

void sdr_stencil_vector(const sdr_points *points, double spacing, const int32_t step[3],
                        double xi[3])
{
  for (int b = 0; b < 3; ++b) xi[b] = 0.0;
  for (int a = 0; a < points->components; ++a)
    for (int b = 0; b < points->components; ++b) xi[b] += spacing * step[a] * points->axes[a][b];
}

static sums sum_stencil(const sdr_families *families, const sdr_family *family,
                        const sdr_stencil *stencil, int weighted)
{
  sums total = {.components = families->points->components};
  for (int k = 0; k < stencil->count; ++k) {
    double xi[3];
    sdr_stencil_vector(families->points, family->spacing, stencil->step + 3 * k, xi);
    add_bond(&total, xi, family->volume,
             weighted ? sdr_family_bond_weight(families, family, family->lambda, xi) : 1.0);
  }
  return total;
}

static void take_moments(sdr_family *family, const sums *total)
{
  family->first = total->first;
  family->second = total->second;
  memcpy(family->quartic, total->quartic, sizeof family->quartic);
}

static sdr_status moments_of_stencil(const sdr_families *families, sdr_family *family)
{
  sdr_stencil stencil;
  const int components = families->points->components;
  SDR_TRY(sdr_stencil_create(components, family->spacing, family->horizon, &stencil));
  family->source = SDR_MOMENTS_STENCIL;
  family->neighbours = stencil.count;
  int removed = 0;
  for (int k = 0; k < stencil.count; ++k) removed += stencil.step[3 * k] > 0;
  family->cut_share = (double)removed / stencil.count;
  sdr_status status = SDR_OK;
  if (families->weight == SDR_FAMILY_ISO) {
    const sums plain = sum_stencil(families, family, &stencil, 0);
    status = sdr_iso_solve(components, plain.gram, plain.quartic, plain.first, family->lambda);
  }
  if (status == SDR_OK) {
    const sums total = sum_stencil(families, family, &stencil, 1);
    take_moments(family, &total);
  }
  sdr_stencil_destroy(&stencil);
  return status;
}

/* ---- irregular points ------------------------------------------------------------------------ */

static sums sum_neighbours(const sdr_families *families, const sdr_neighbourhood *near, int32_t i,
                           int weighted)
{
  const sdr_points *points = families->points;
  sums total = {.components = points->components};
  for (int64_t k = near->row[i]; k < near->row[i + 1]; ++k) {
    const int32_t j = near->column[k];
    double xi[3] = {0.0};
    for (int a = 0; a < points->components; ++a) xi[a] = points->x[a][j] - points->x[a][i];
    add_bond(&total, xi, points->volume[j],
             weighted ? sdr_families_weight(families, i, j, xi) : 1.0);
  }
  return total;
}

/* Measure of the ball of radius `horizon`, times thickness or area. */
static double ball(const sdr_points *points, const sdr_family *family)
{
  const double d = family->horizon, pi = 3.14159265358979323846;
  const double across = family->volume / pow(family->spacing, points->components);
  const double measure[3] = {2.0 * d, pi * d * d, 4.0 / 3.0 * pi * d * d * d};
  return across * measure[points->components - 1];
}

/* A family counts as complete if it fills its ball and lies around its point. */
static int complete(const sdr_points *points, const sdr_family *family, const sums *total)
{
  double offset = 0.0;
  for (int a = 0; a < 3; ++a) offset += total->offset[a] * total->offset[a];
  return total->volume > 0.9 * ball(points, family) &&
         sqrt(offset) < 0.1 * total->volume * family->horizon;
}

static void continuum_moments(const sdr_points *points, sdr_family *family)
{
  const int n = points->components;
  const double volume = ball(points, family), d = family->horizon;
  const double plain[3][5] = {{1.0}, {3.0 / 8, 0, 1.0 / 8, 0, 3.0 / 8}};
  family->source = SDR_MOMENTS_CONTINUUM;
  family->first = volume * d * n / (n + 1);
  family->second = volume * d * d * n / (n + 2);
  if (n < 3) {
    for (int k = 0; k < 5; ++k) family->quartic[k] = family->first * plain[n - 1][k];
    return;
  }
  int k = 0;
  for (int a = 4; a >= 0; --a)
    for (int b = 4 - a; b >= 0; --b, ++k) {
      const int c = 4 - a - b, even = a % 2 == 0 && b % 2 == 0;
      family->quartic[k] = !even ? 0.0 : family->first / (a == 4 || b == 4 || c == 4 ? 5.0 : 15.0);
    }
}

/* Add the complete families' moments up in their family, whose moments were zeroed. */
static void add_complete(sdr_families *families, const sdr_neighbourhood *near, int64_t *counted)
{
  const sdr_points *points = families->points;
  for (int32_t i = 0; i < points->count; ++i) {
    const int32_t f = families->of_point ? families->of_point[i] : 0;
    sdr_family *family = &families->family[f];
    const sums own = sum_neighbours(families, near, i, 1);
    if (!complete(points, family, &own)) continue;
    ++counted[f];
    family->first += own.first;
    family->second += own.second;
    for (int k = 0; k < SDR_MONOMIALS; ++k) family->quartic[k] += own.quartic[k];
  }
}

static sdr_status mean_moments(sdr_families *families, const sdr_neighbourhood *near)
{
  int64_t *counted = sdr_alloc((size_t)families->count, sizeof *counted);
  if (!counted) return SDR_RUN_FAILED;
  const sums zero = {0};
  for (int f = 0; f < families->count; ++f) take_moments(&families->family[f], &zero);
  add_complete(families, near, counted);
  for (int f = 0; f < families->count; ++f) {
    sdr_family *family = &families->family[f];
    const double n = (double)counted[f];
    if (counted[f] == 0) {
      continuum_moments(families->points, family);
      continue;
    }
    family->source = SDR_MOMENTS_MEAN;
    family->first /= n;
    family->second /= n;
    for (int k = 0; k < SDR_MONOMIALS; ++k) family->quartic[k] /= n;
  }
  sdr_free(counted);
  return SDR_OK;
}

static sdr_status own_iso_weights(sdr_families *families, const sdr_neighbourhood *near)
{
  const sdr_points *points = families->points;
  families->lambda = sdr_alloc((size_t)points->count, SDR_MONOMIALS * sizeof(double));
  if (!families->lambda) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < points->count; ++i) {
    const sums own = sum_neighbours(families, near, i, 0);
    if (own.first <= 0.0) continue; /* no neighbour: no weight */
    SDR_TRY(sdr_iso_solve(points->components, own.gram, own.quartic, own.first,
                          families->lambda + SDR_MONOMIALS * (size_t)i));
  }
  return SDR_OK;
}

static sdr_status irregular_moments(sdr_families *families)
{
  sdr_neighbourhood near;
  SDR_TRY(sdr_neighbourhood_create(families->points, &near));
  sdr_status status =
      families->weight == SDR_FAMILY_ISO ? own_iso_weights(families, &near) : SDR_OK;
  if (status == SDR_OK) status = mean_moments(families, &near);
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

sdr_status sdr_families_create(const sdr_points *points, sdr_family_weight weight,
                               sdr_families **out)
{
  sdr_families *families = sdr_alloc(1, sizeof *families);
  if (!families) return SDR_RUN_FAILED;
  families->points = points;
  families->weight = weight;
  sdr_status status = group_points(families);
  for (int f = 0; f < families->count && status == SDR_OK; ++f)
    status = moments_of_stencil(families, &families->family[f]);
  if (status == SDR_OK && points->irregular) status = irregular_moments(families);
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
  sdr_free(f);
  *families = NULL;
}
