/* Points of the unit cube for nonlocal operators: (cells + 1)^d lattice points, jittered inside. */
#ifndef SDR_TESTS_GRID_H
#define SDR_TESTS_GRID_H

#include "base/memory.h"
#include "nom/operator.h"
#include "support/cmocka_all.h"
#include "support/noise.h"

#include <math.h>

#define GRID_PI 3.14159265358979323846

#ifndef assert_near
/* |value - expected| <= tolerance, in double (assert_float_equal rounds to float). */
#define assert_near(value, expected, tolerance)                                                    \
  do {                                                                                             \
    const double value_ = (value), expected_ = (expected);                                         \
    if (!(fabs(value_ - expected_) <= (tolerance)))                                                \
      fail_msg("%s is %.17g, expected %.17g", #value, value_, expected_);                          \
  } while (0)
#endif

typedef struct {
  int components, cells;
  int32_t count;
  double *x[3], *volume;
  uint8_t *edge; /* 1 on the cube's surface */
  sdr_cloud cloud;
} grid;

/* Points inside move by up to `jitter` spacings along each axis; volumes are those of the lattice's
   cells inside the cube. Lengths are multiplied by `size`. */
static inline void grid_create(int components, int cells, double jitter, double size, grid *g)
{
  uint64_t seed = 7;
  *g = (grid){.components = components, .cells = cells, .count = 1};
  for (int a = 0; a < components; ++a) g->count *= cells + 1;
  for (int a = 0; a < components; ++a) g->x[a] = sdr_alloc((size_t)g->count, sizeof(double));
  g->volume = sdr_alloc((size_t)g->count, sizeof(double));
  g->edge = sdr_alloc((size_t)g->count, 1);
  for (int32_t i = 0; i < g->count; ++i) {
    int32_t rest = i, at[3] = {0};
    g->volume[i] = pow(size / cells, components);
    for (int a = 0; a < components; ++a, rest /= cells + 1) {
      at[a] = rest % (cells + 1);
      if (at[a] % cells == 0) {
        g->edge[i] = 1;
        g->volume[i] *= 0.5;
      }
    }
    for (int a = 0; a < components; ++a) {
      const double shift = jitter * noise(&seed);
      g->x[a][i] = size * (at[a] + (g->edge[i] ? 0.0 : shift)) / cells;
    }
  }
  g->cloud = (sdr_cloud){components, g->count, {g->x[0], g->x[1], g->x[2]}, g->volume};
}

static inline void grid_destroy(grid *g)
{
  for (int a = 0; a < 3; ++a) sdr_free(g->x[a]);
  sdr_free(g->volume);
  sdr_free(g->edge);
}

/* Supports by count, shape tensors and row weights over a grid. */
typedef struct {
  sdr_support support;
  sdr_shape_tensors shape;
  sdr_operator op;
} grid_operators;

static inline void grid_operators_create(const grid *g, int order, int nearest,
                                         sdr_influence influence, grid_operators *o)
{
  const sdr_shape_how how = {.order = order, .influence = influence};
  assert_int_equal(sdr_support_by_count(&g->cloud, nearest, &o->support), SDR_OK);
  if (sdr_shape_tensors_create(&o->support, &how, &o->shape) != SDR_OK)
    fail_msg("%s", sdr_error_message());
  assert_int_equal(sdr_operator_create(&o->shape, &o->op), SDR_OK);
}

static inline void grid_operators_destroy(grid_operators *o)
{
  sdr_operator_destroy(&o->op);
  sdr_shape_tensors_destroy(&o->shape);
  sdr_support_destroy(&o->support);
}

static inline int grid_find(const grid_operators *o, const char *name)
{
  int found = 0;
  assert_int_equal(sdr_operator_find(&o->op, name, &found), SDR_OK);
  return found;
}

#endif
