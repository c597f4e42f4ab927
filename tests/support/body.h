/* Bodies for tests, made without a scene: boxes of a lattice, or of jittered points with horizons
   that differ from point to point. */
#ifndef SDR_TESTS_BODY_H
#define SDR_TESTS_BODY_H

#include "base/memory.h"
#include "base/parallel.h"
#include "damage/strength.h"
#include "mechanics/bond_based.h"
#include "mechanics/bond_body.h"
#include "support/cmocka_all.h"
#include "support/noise.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
  sdr_dimension dimension;
  int32_t cells[3];      /* points along each axis */
  double ratio;          /* horizon over spacing; 0: 3.015 */
  double angle;          /* of the lattice axes, radians */
  double jitter;         /* share of the spacing; > 0: no lattice */
  double horizon_spread; /* horizons are ratio (1 + this share of noise) spacings */
  sdr_law law;
  sdr_families_how weight;
  double ell;        /* in horizons; 0: 1 */
  double stretch;    /* s_c or s0 for the modulus without scatter; 0: 0.01 */
  double brittle;    /* cohesive: (s_c/s_e)^2 for the same, about; 0: 20 */
  double scatter;    /* of Young's modulus, share */
  int two_materials; /* points with x > 0 have 3 times the toughness and half the modulus */
  int force_loose;
  int (*refined)(
      const int32_t cell[3]); /* cells that are replaced by children of half their size */
  int mixed;                  /* explicit forces of runs in float */
  int precise;                /* histories in double, as implicit integrators want them */
} body_how;

typedef struct {
  body_how how;
  sdr_points *points;
  sdr_families *families;
  sdr_model *model;
  const sdr_bonds *bonds; /* the model's */
  double *young, toughness[2], strength[2];
  double beta; /* cohesive */
} body;

static const double body_young = 70e9, body_spacing = 0.5e-3;

static inline void body_place(const body_how *how, sdr_points *points, int32_t i,
                              const int32_t cell[3], int level, uint64_t *seed)
{
  const int n = points->components;
  const double spacing = ldexp(body_spacing, -level);
  for (int a = 0; a < n; ++a) {
    double x = 0.0;
    for (int b = 0; b < n; ++b) {
      const double middle = ldexp(0.5 * how->cells[b], level) - 0.5;
      x += points->axes[b][a] * (cell[b] - middle) * spacing;
    }
    points->x[a][i] = x + (how->jitter > 0.0 ? how->jitter * body_spacing * noise(seed) : 0.0);
  }
  const double ratio = how->ratio > 0.0 ? how->ratio : 3.015;
  points->spacing[i] = spacing;
  points->volume[i] = pow(spacing, n);
  points->horizon[i] = ratio * spacing;
  if (points->level) points->level[i] = (uint8_t)level;
  if (points->cell) memcpy(points->cell + 3 * (size_t)i, cell, 3 * sizeof *cell);
  if (how->horizon_spread > 0.0) points->horizon[i] *= 1.0 + how->horizon_spread * noise(seed);
  points->material[i] = how->two_materials && points->x[0][i] > 0.0;
}

/* The cell, or its children. */
static inline int32_t body_place_cell(const body_how *how, sdr_points *points, int32_t i,
                                      const int32_t cell[3], uint64_t *seed)
{
  const int n = points->components;
  if (!how->refined || !how->refined(cell)) {
    body_place(how, points, i, cell, 0, seed);
    return i + 1;
  }
  for (int k = 0; k < 1 << n; ++k) {
    int32_t child[3] = {0};
    for (int a = 0; a < n; ++a) child[a] = 2 * cell[a] + (k >> a & 1);
    body_place(how, points, i++, child, 1, seed);
  }
  return i;
}

/* Generated in lattice order, x fastest; `keep` (or NULL) says which cells belong to the body. */
static inline sdr_points *body_points(const body_how *how, int (*keep)(const int32_t cell[3]))
{
  const int n = sdr_components(how->dimension);
  int32_t size[3] = {1, 1, 1}, count = 0;
  for (int a = 0; a < n; ++a) size[a] = how->cells[a];
  sdr_points *points;
  const int32_t most = size[0] * size[1] * size[2] * (how->refined ? 1 << n : 1);
  assert_int_equal(sdr_points_create(most, n, how->jitter <= 0.0, &points), SDR_OK);
  if (how->refined) points->level = sdr_alloc((size_t)most + 64, 1);
  if (n > 1) {
    points->axes[0][0] = points->axes[1][1] = cos(how->angle);
    points->axes[0][1] = sin(how->angle);
    points->axes[1][0] = -sin(how->angle);
  }
  uint64_t seed = 20261;
  for (int32_t z = 0; z < size[2]; ++z)
    for (int32_t y = 0; y < size[1]; ++y)
      for (int32_t x = 0; x < size[0]; ++x) {
        const int32_t cell[3] = {x, y, z};
        if (keep && !keep(cell)) continue;
        count = body_place_cell(how, points, count, cell, &seed);
      }
  points->count = count;
  points->lattice_spacing = body_spacing;
  points->irregular = how->jitter > 0.0;
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  return points;
}

static inline int body_has_ell(sdr_law law)
{
  return law == SDR_LAW_VARIATIONAL || law == SDR_LAW_AT1;
}

static inline void body_materials(body *b)
{
  const body_how *how = &b->how;
  const double stretch = how->stretch > 0.0 ? how->stretch : 0.01;
  const double ell = how->ell > 0.0 ? how->ell : 1.0;
  const double unit = sdr_critical_stretch_squared(how->dimension, SDR_CALIBRATE_FAMILY,
                                                   &b->families->family[0], body_young, 1.0);
  b->toughness[0] = stretch * stretch * (body_has_ell(how->law) ? ell : 1.0) / unit;
  b->toughness[1] = 3.0 * b->toughness[0];
  b->strength[0] = body_young * stretch / sqrt(how->brittle > 0.0 ? how->brittle : 20.0);
  b->strength[1] = 0.5 * b->strength[0];
  b->young = sdr_alloc(sdr_points_padded(b->points), sizeof(double));
  uint64_t seed = 977;
  for (int32_t i = 0; i < b->points->count; ++i)
    b->young[i] = body_young * (1.0 + how->scatter * noise(&seed)) *
                  (b->points->material[i] == 1 ? 0.5 : 1.0);
}

static inline sdr_model_traits body_traits(const sdr_model *model)
{
  sdr_model_traits traits;
  model->ops->traits(model, &traits);
  return traits;
}

/* C, s0^2 and q of point i, as theory sec. 3-4 has them (cohesive: q = s_e). */
static inline double body_micromodulus(const body *b, int32_t i)
{
  return sdr_micromodulus(b->how.dimension, SDR_CALIBRATE_FAMILY, sdr_family_of(b->families, i),
                          b->young[i]);
}
static inline double body_critical(const body *b, int32_t i)
{
  return sdr_critical_stretch_squared(b->how.dimension, SDR_CALIBRATE_FAMILY,
                                      sdr_family_of(b->families, i), b->young[i],
                                      b->toughness[b->points->material[i]]);
}
static inline double body_threshold(const body *b, int32_t i)
{
  if (b->how.law == SDR_LAW_NONE) return 1.0;
  const double q = body_critical(b, i);
  if (b->how.law == SDR_LAW_COHESIVE)
    return b->strength[b->points->material[i]] / (b->beta * b->young[i]);
  return body_has_ell(b->how.law) && b->how.ell > 0.0 ? q / b->how.ell : q;
}

/* Of the cells that `keep` keeps (NULL: all). */
static inline body body_create_kept(const body_how *how, int (*keep)(const int32_t cell[3]))
{
  body b = {.how = *how, .points = body_points(how, keep)};
  assert_int_equal(sdr_families_create(b.points, &how->weight, &b.families), SDR_OK);
  body_materials(&b);
  const sdr_bonds_how bonds_how = {.force_loose = how->force_loose,
                                   .levels = 1,
                                   .weight = sdr_families_weight,
                                   .context = b.families,
                                   .bulk = b.families->bulk};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(b.points, &bonds_how, &bonds), SDR_OK);
  const sdr_bond_based_how model_how = {.dimension = how->dimension,
                                        .law = how->law,
                                        .mixed = how->mixed,
                                        .precise = how->precise,
                                        .ell = {how->ell > 0.0 ? how->ell : 1.0, 1},
                                        .young = b.young,
                                        .toughness = b.toughness,
                                        .strength = b.strength};
  assert_int_equal(sdr_bond_based_create(b.points, bonds, b.families, &model_how, &b.model),
                   SDR_OK);
  b.bonds = bonds;
  if (how->law == SDR_LAW_COHESIVE)
    assert_int_equal(sdr_cohesive_beta(b.families, sdr_family_of(b.families, 0),
                                       body_micromodulus(&b, 0), b.young[0], &b.beta),
                     SDR_OK);
  return b;
}

static inline body body_create(const body_how *how)
{
  return body_create_kept(how, NULL);
}

static inline void body_destroy(body *b)
{
  b->model->ops->destroy(b->model);
  sdr_families_destroy(&b->families);
  sdr_points_destroy(&b->points);
  sdr_free(b->young);
}

/* Cut what crosses the plane x = 0.1 spacing, protect what has an end low on the first axis. */
static inline int body_cut_and_protect(const void *context, const double a[3], const double b[3])
{
  (void)context;
  const double plane = 0.1 * body_spacing;
  if ((a[0] > plane) != (b[0] > plane)) return SDR_CUT;
  return fmin(a[0], b[0]) < -4.2 * body_spacing ? SDR_PROTECTED : 0;
}

/* ---- vectors over points --------------------------------------------------------------------- */

static inline void vector_create(const sdr_points *points, double *v[3])
{
  for (int a = 0; a < 3; ++a)
    v[a] = a < points->components ? sdr_alloc(sdr_points_padded(points), sizeof(double)) : NULL;
}

static inline void vector_destroy(double *v[3])
{
  for (int a = 0; a < 3; ++a) sdr_free(v[a]);
}

/* Noise of +- amplitude in each component. */
static inline void vector_noise(const sdr_points *points, double amplitude, uint64_t seed,
                                double *const v[3])
{
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) v[a][i] = amplitude * noise(&seed);
}

/* v = gradient X; gradient is 3 x 3, row a that of component a. */
static inline void vector_linear(const sdr_points *points, const double gradient[9],
                                 double *const v[3])
{
  for (int32_t i = 0; i < points->count; ++i)
    for (int a = 0; a < points->components; ++a) {
      v[a][i] = 0.0;
      for (int b = 0; b < points->components; ++b) v[a][i] += gradient[3 * a + b] * points->x[b][i];
    }
}

static inline double vector_largest(const sdr_points *points, double *const v[3])
{
  double most = 0.0;
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) most = fmax(most, fabs(v[a][i]));
  return most;
}

static inline double vector_difference(const sdr_points *points, double *const v[3],
                                       double *const w[3])
{
  double most = 0.0;
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) {
      if (isnan(v[a][i]) || isnan(w[a][i])) return INFINITY;
      most = fmax(most, fabs(v[a][i] - w[a][i]));
    }
  return most;
}

static inline double vector_dot(const sdr_points *points, double *const v[3], double *const w[3])
{
  double sum = 0.0;
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) sum += v[a][i] * w[a][i];
  return sum;
}

/* out = v + factor w */
static inline void vector_add(const sdr_points *points, double *const v[3], double factor,
                              double *const w[3], double *const out[3])
{
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) out[a][i] = v[a][i] + factor * w[a][i];
}

/* Fail with numbers unless value <= limit. */
#define assert_at_most(value, limit)                                                               \
  do {                                                                                             \
    const double value_ = (value), limit_ = (limit);                                               \
    if (!(value_ <= limit_)) fail_msg(#value " = %.6g is above %.6g", value_, limit_);             \
  } while (0)

/* Fail unless |value - expected| <= tolerance. */
#define assert_near(value, expected, tolerance)                                                    \
  do {                                                                                             \
    const double value_ = (value), expected_ = (expected), tolerance_ = (tolerance);               \
    if (!(fabs(value_ - expected_) <= tolerance_))                                                 \
      fail_msg(#value " = %.15g, expected %.15g +- %.3g", value_, expected_, tolerance_);          \
  } while (0)

#endif
