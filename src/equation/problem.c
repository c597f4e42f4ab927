#include "equation/problem.h"

#include "base/memory.h"
#include "equation/conditions.h"
#include "geometry/lattice.h"
#include "geometry/place.h"
#include "geometry/shape.h"

#include <math.h>
#include <stdio.h>

void sdr_problem_place(const sdr_problem *problem, int32_t i, double x[3])
{
  for (int c = 0; c < 3; ++c) x[c] = c < problem->components ? problem->points->x[c][i] : 0.0;
}

/* ---- volumes --------------------------------------------------------------------------------- */

enum { SAMPLES = 8 }; /* of a cell along each axis */

/* Share of point i's cell that lies in the shape, from samples: exact for halves and quarters. */
static double share_inside(const sdr_problem *p, int32_t i)
{
  const double h = p->points->spacing[i];
  double at[3];
  int total = 1, inside = 0;
  sdr_problem_place(p, i, at);
  if (sdr_shape_contains(p->scene->points.shape, at, -0.87 * h)) return 1.0; /* half a diagonal */
  for (int c = 0; c < p->components; ++c) total *= SAMPLES;
  for (int k = 0; k < total; ++k) {
    const int index[3] = {k % SAMPLES, k / SAMPLES % SAMPLES, k / (SAMPLES * SAMPLES)};
    double x[3] = {at[0], at[1], at[2]};
    for (int a = 0; a < p->components; ++a)
      for (int c = 0; c < p->components; ++c)
        x[c] += p->points->axes[a][c] * h * ((index[a] + 0.5) / SAMPLES - 0.5);
    inside += sdr_shape_contains(p->scene->points.shape, x, SDR_SHAPE_TOLERANCE * h);
  }
  return fmax((double)inside, 1.0) / total;
}

static void find_volumes(sdr_problem *p)
{
  for (int32_t i = 0; i < p->points->count; ++i)
    p->volume[i] = p->points->volume[i] * (p->equation->variational ? share_inside(p, i) : 1.0);
}

/* ---- what is held ---------------------------------------------------------------------------- */

static void mark_held(sdr_problem *p, const sdr_boundary *boundary)
{
  if (!p->words->condition[boundary->condition].is_solution) return;
  for (int k = 0; k < boundary->place_count; ++k) {
    const sdr_place *place = &boundary->on[k];
    if (place->face[0]) continue;
    for (int32_t i = 0; i < p->points->count; ++i) {
      double x[3];
      sdr_problem_place(p, i, x);
      const double h = p->points->spacing[i];
      if (sdr_place_holds(p->scene, place, x, h, h)) p->held[i] = 1;
    }
  }
}

/* ---- operators ------------------------------------------------------------------------------- */

static sdr_status make_support(sdr_problem *p)
{
  const sdr_equation *e = p->equation;
  const sdr_cloud cloud = {p->components,
                           p->points->count,
                           {p->points->x[0], p->points->x[1], p->points->x[2]},
                           p->volume};
  if (e->nearest > 0) return sdr_support_by_count(&cloud, e->nearest, &p->support);
  double *radius = sdr_alloc((size_t)cloud.count, sizeof *radius);
  if (!radius) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < cloud.count; ++i)
    radius[i] = e->radius.value * (e->radius.relative ? p->points->spacing[i] : 1.0);
  const sdr_status status = sdr_support_by_radius(&cloud, radius, &p->support);
  sdr_free(radius);
  return status;
}

/* The derivative along the given axes; -1 where the operators' order is too low. */
static int derivative(const sdr_problem *p, const int *axis, int count)
{
  char name[4] = "";
  int index = -1;
  for (int k = 0; k < count; ++k) name[k] = "xyz"[axis[k]];
  if (count > p->shape.set.order || sdr_operator_find(&p->op, name, &index) != SDR_OK) return -1;
  return index;
}

static void name_derivatives(sdr_problem *p)
{
  for (int a = 0; a < p->components; ++a) {
    p->d[a] = derivative(p, &a, 1);
    for (int b = 0; b < p->components; ++b) {
      const int two[2] = {a, b};
      p->dd[a][b] = derivative(p, two, 2);
    }
  }
}

static sdr_status make_operators(sdr_problem *p)
{
  const sdr_equation *e = p->equation;
  /* both lists of weights stand in the same order */
  const sdr_shape_how how = {
      .order = e->order, .influence = (sdr_influence)e->weight, .enlarge = e->enlarge};
  sdr_status status = make_support(p);
  if (status == SDR_OK) status = sdr_shape_tensors_create(&p->support, &how, &p->shape);
  if (status == SDR_BAD_INPUT) {
    char why[400];
    snprintf(why, sizeof why, "%s", sdr_error_message());
    return sdr_fail(SDR_BAD_INPUT, "%s: %s", sdr_origin_text(e->origin), why);
  }
  if (status == SDR_OK) status = sdr_operator_create(&p->shape, &p->op);
  if (status == SDR_OK) name_derivatives(p);
  return status;
}

/* Found again where they are needed; here for the sake of an early message. */
static sdr_status check_conditions(const sdr_problem *p)
{
  const int is_collocation = !p->equation->variational;
  sdr_row_condition *rows = NULL;
  SDR_TRY(sdr_conditions_find(p, is_collocation, &rows));
  const sdr_status status = is_collocation ? sdr_conditions_complete(p, rows) : SDR_OK;
  sdr_free(rows);
  return status;
}

static sdr_status fill(sdr_problem *p)
{
  SDR_TRY(sdr_lattice_points(p->scene, &p->points));
  const size_t count = (size_t)p->points->count;
  p->volume = sdr_alloc(count, sizeof *p->volume);
  p->held = sdr_alloc(count, 1);
  if (!p->volume || !p->held) return SDR_RUN_FAILED;
  find_volumes(p);
  for (int k = 0; k < p->equation->boundary_count; ++k) mark_held(p, &p->equation->boundary[k]);
  SDR_TRY(make_operators(p));
  return check_conditions(p);
}

sdr_status sdr_problem_create(const sdr_scene *scene, sdr_problem **out)
{
  sdr_problem *p = sdr_alloc(1, sizeof *p);
  if (!p) return SDR_RUN_FAILED;
  p->scene = scene;
  p->equation = scene->equation;
  p->words = &sdr_equations[scene->equation->kind];
  p->ops = sdr_equation_ops_of(scene->equation->kind);
  p->components = sdr_components(scene->dimension);
  p->fields = p->ops->fields(p->components);
  const sdr_status status = fill(p);
  if (status == SDR_OK)
    *out = p;
  else
    sdr_problem_destroy(&p);
  return status;
}

void sdr_problem_destroy(sdr_problem **problem)
{
  sdr_problem *p = problem ? *problem : NULL;
  if (!p) return;
  sdr_operator_destroy(&p->op);
  sdr_shape_tensors_destroy(&p->shape);
  sdr_support_destroy(&p->support);
  sdr_points_destroy(&p->points);
  sdr_free(p->volume);
  sdr_free(p->held);
  sdr_free(p);
  *problem = NULL;
}

double sdr_problem_mean_condition(const sdr_problem *p)
{
  double sum = 0.0;
  for (int32_t i = 0; i < p->points->count; ++i) sum += p->shape.condition[i];
  return sum / p->points->count;
}
