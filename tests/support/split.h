/* A body split by a plane through its middle, its halves moved apart as rigid bodies: what points
   away from the ends dissipate. */
#ifndef SDR_TESTS_SPLIT_H
#define SDR_TESTS_SPLIT_H

#include "support/body.h"

typedef struct {
  double tilt;      /* of the plane's normal, turned from the first axis to the second, radians */
  int rows, layers; /* points along y and z that count */
  sdr_law law;
  double growth; /* each opening over the one before */
} split;

/* Make the cells of a body large enough to be split. Families of points that count end inside. */
static inline split split_plan(body_how *how, double tilt)
{
  const int solid = how->dimension == SDR_3D, random = how->jitter > 0.0;
  const int edge = (int)ceil(how->ratio > 0.0 ? how->ratio : 3.015);
  split plan = {.tilt = tilt, .layers = solid ? 3 : 1, .law = how->law};
  plan.rows = !random ? 12
              : solid ? 36
                      : 120; /* chance wants many; 12 are 5 in x at 22.5 degrees */
  plan.growth = solid || random ? 1.03 : 1.015;
  how->cells[1] = plan.rows + 2 * edge;
  how->cells[2] = solid ? plan.layers + 2 * edge : 0;
  how->cells[0] = 2 * (2 * edge + (int)(0.5 * how->cells[1] * tan(tilt)));
  return plan;
}

static inline void split_open(const split *plan, const sdr_points *points, sdr_model *model,
                              double *const u[3])
{
  const int breaks = plan->law == SDR_LAW_CRITICAL_STRETCH;
  const double to = breaks ? 0.3 * body_spacing : 10.0;
  const double growth = breaks ? plan->growth : 10.0;
  const double c = cos(plan->tilt), t = sin(plan->tilt);
  double *v[3], *f[3], before = 0.0;
  vector_create(points, v);
  vector_create(points, f);
  for (double gap = breaks ? 1e-3 * body_spacing : 1e-3; gap < growth * to; gap *= growth) {
    for (int32_t i = 0; i < points->count; ++i) {
      const int moves = c * points->x[0][i] + t * points->x[1][i] > 1e-6 * body_spacing;
      u[0][i] = moves ? gap * c : 0.0;
      u[1][i] = moves ? gap * t : 0.0;
      v[0][i] = moves ? (gap - before) * c : 0.0; /* a step of 1 s led here */
      v[1][i] = moves ? (gap - before) * t : 0.0;
    }
    model->ops->force_commit(model, u, v, 1.0, f);
    before = gap;
  }
  vector_destroy(v);
  vector_destroy(f);
}

/* Over the area, J/m^2. */
static inline double split_dissipated(const split *plan, const sdr_points *points, sdr_model *model)
{
  const int solid = points->components == 3;
  double *u[3], sum = 0.0, *field = sdr_alloc(sdr_points_padded(points), sizeof *field);
  vector_create(points, u);
  split_open(plan, points, model, u);
  sdr_energies e;
  model->ops->energies(model, u, &e);
  assert_at_most(e.stored, 1e-2 * e.dissipated);
  assert_int_equal(model->ops->field(model, u, SDR_FIELD_DISSIPATED, field), SDR_OK);
  for (int32_t i = 0; i < points->count; ++i)
    if (fabs(points->x[1][i]) < 0.5 * plan->rows * body_spacing &&
        (!solid || fabs(points->x[2][i]) < 0.5 * plan->layers * body_spacing))
      sum += field[i] * points->volume[i];
  vector_destroy(u);
  sdr_free(field);
  const double depth = solid ? plan->layers * body_spacing : 1.0;
  return sum * cos(plan->tilt) / (plan->rows * body_spacing * depth);
}

#endif
