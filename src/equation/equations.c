#include "equation/equations.h"

#include "base/memory.h"
#include "equation/conditions.h"
#include "geometry/face.h"
#include "geometry/place.h"
#include "geometry/point_grid.h"
#include "nom/operator_energy.h"

#include <math.h>

/* Value of the scene's source in row p at point i. */
static sdr_status source_at(const sdr_problem *problem, int p, int32_t i, double *value)
{
  const int c = p - problem->ops->source_row;
  double x[3];
  *value = 0.0;
  if (c < 0 || c >= 3 || !problem->equation->source[c]) return SDR_OK;
  sdr_problem_place(problem, i, x);
  return sdr_equation_value(problem->equation->source[c], problem->equation->origin, "the source",
                            x, value);
}

/* ---- collocation ----------------------------------------------------------------------------- */

static sdr_status add_row(const sdr_problem *problem, const sdr_row_condition *condition, int p,
                          int32_t i, sdr_csr_builder *builder, double *f)
{
  const sdr_equation *e = problem->equation;
  sdr_term terms[SDR_EQUATION_TERMS];
  double normal[3], x[3];
  int count, row = p;
  if (condition->entry < 0) {
    count = problem->ops->inside(problem, p, terms);
    SDR_TRY(source_at(problem, p, i, f));
  } else {
    const sdr_boundary *boundary = &e->boundary[condition->entry];
    const int c = condition->component;
    sdr_problem_place(problem, i, x);
    SDR_TRY(sdr_condition_normal(problem, boundary, &boundary->on[condition->place], normal));
    count = problem->ops->condition(problem, boundary->condition, c, normal, terms, &row);
    SDR_TRY(sdr_condition_value(boundary, e, c, x, f));
  }
  return sdr_collocate(&problem->op, i, count, terms, row * problem->points->count + i, builder);
}

/* Rows of different kinds, as a value and a force, get one size. */
static void balance_rows(sdr_csr *matrix, double *f)
{
  for (int32_t r = 0; r < matrix->rows; ++r) {
    double largest = 0.0;
    for (int64_t k = matrix->row[r]; k < matrix->row[r + 1]; ++k)
      largest = fmax(largest, fabs(matrix->value[k]));
    if (!(largest > 0.0)) continue;
    for (int64_t k = matrix->row[r]; k < matrix->row[r + 1]; ++k) matrix->value[k] /= largest;
    f[r] /= largest;
  }
}

static sdr_status collocate(const sdr_problem *problem, sdr_csr_builder *builder, double *f)
{
  const int32_t count = problem->points->count;
  sdr_row_condition *rows = NULL;
  SDR_TRY(sdr_conditions_find(problem, 1, &rows));
  sdr_status status = SDR_OK;
  for (int p = 0; p < problem->fields; ++p)
    for (int32_t i = 0; status == SDR_OK && i < count; ++i)
      status = add_row(problem, &rows[p * count + i], p, i, builder, &f[p * count + i]);
  sdr_free(rows);
  return status;
}

/* ---- the variational form -------------------------------------------------------------------- */

/* The work of a natural condition on one face: pieces of it push the nearest point. */
typedef struct {
  const sdr_problem *problem;
  const sdr_boundary *boundary;
  const sdr_point_grid *grid;
  double *f, measure; /* of the thickness or area */
  sdr_status status;
} push;

static void push_piece(void *context, const sdr_piece *piece)
{
  push *p = context;
  const int32_t i = sdr_point_grid_nearest(p->grid, piece->x);
  for (int c = 0; c < 3 && i >= 0 && p->status == SDR_OK; ++c) {
    double value = 0.0;
    if (!p->boundary->value[c]) continue;
    p->status = sdr_condition_value(p->boundary, p->problem->equation, c, piece->x, &value);
    p->f[c * p->problem->points->count + i] += value * piece->measure * p->measure;
  }
}

static sdr_status push_faces(const sdr_problem *problem, const sdr_point_grid *grid, double *f)
{
  const sdr_scene *scene = problem->scene;
  push p = {.problem = problem,
            .grid = grid,
            .f = f,
            .measure = problem->components < 3 ? scene->points.thickness : 1.0};
  for (int b = 0; b < problem->equation->boundary_count; ++b) {
    p.boundary = &problem->equation->boundary[b];
    if (!problem->words->condition[p.boundary->condition].is_natural) continue;
    for (int k = 0; k < p.boundary->place_count; ++k) {
      const sdr_place *place = &p.boundary->on[k];
      SDR_TRY(sdr_face_pieces(sdr_place_shape(scene, place), place->face, scene->dimension,
                              scene->points.spacing / 8.0, push_piece, &p));
      SDR_TRY(p.status);
    }
  }
  return SDR_OK;
}

static sdr_status add_work(const sdr_problem *problem, double *f)
{
  const int32_t count = problem->points->count;
  sdr_point_grid *grid = NULL;
  for (int p = 0; p < problem->fields; ++p)
    for (int32_t i = 0; i < count; ++i) {
      double source;
      SDR_TRY(source_at(problem, p, i, &source));
      f[p * count + i] += source * problem->volume[i];
    }
  SDR_TRY(sdr_point_grid_create(problem->points, &grid));
  const sdr_status status = push_faces(problem, grid, f);
  sdr_point_grid_destroy(&grid);
  return status;
}

static sdr_status add_energy(const sdr_problem *problem, sdr_csr_builder *builder)
{
  const int32_t count = problem->points->count;
  sdr_quadratic_term terms[SDR_EQUATION_TERMS];
  const sdr_functional functional = {problem->fields, problem->ops->functional(problem, terms),
                                     terms};
  SDR_TRY(sdr_functional_add(&problem->op, &functional, builder));
  double *coefficient = sdr_alloc((size_t)count, sizeof *coefficient);
  if (!coefficient) return SDR_RUN_FAILED;
  const double penalty = problem->equation->penalty * problem->ops->stiffness(problem);
  for (int32_t i = 0; i < count; ++i) coefficient[i] = penalty;
  const sdr_status status = penalty > 0.0 ? sdr_operator_energy_add(&problem->shape, coefficient,
                                                                    problem->fields, builder)
                                          : SDR_OK;
  sdr_free(coefficient);
  return status;
}

/* Prescribed unknowns of the finished matrix. */
static sdr_status fix(const sdr_problem *problem, sdr_equations_system *system)
{
  const int32_t count = problem->points->count, unknowns = problem->fields * count;
  sdr_row_condition *rows = NULL;
  SDR_TRY(sdr_conditions_find(problem, 0, &rows));
  uint8_t *fixed = sdr_alloc((size_t)unknowns, 1);
  double *value = sdr_alloc((size_t)unknowns, sizeof *value);
  sdr_status status = fixed && value ? SDR_OK : SDR_RUN_FAILED;
  for (int32_t r = 0; status == SDR_OK && r < unknowns; ++r) {
    double x[3];
    if (rows[r].entry < 0) continue;
    fixed[r] = 1;
    sdr_problem_place(problem, r % count, x);
    status = sdr_condition_value(&problem->equation->boundary[rows[r].entry], problem->equation,
                                 rows[r].component, x, &value[r]);
  }
  if (status == SDR_OK) status = sdr_fix_unknowns(&system->matrix, fixed, value, system->f);
  sdr_free(rows);
  sdr_free(fixed);
  sdr_free(value);
  return status;
}

/* ---- both ------------------------------------------------------------------------------------ */

static sdr_status assemble(const sdr_problem *problem, sdr_csr_builder *builder,
                           sdr_equations_system *system)
{
  const int is_variational = problem->equation->variational;
  if (is_variational) {
    SDR_TRY(add_energy(problem, builder));
    SDR_TRY(add_work(problem, system->f));
  } else {
    SDR_TRY(collocate(problem, builder, system->f));
  }
  SDR_TRY(sdr_csr_builder_finish(builder, &system->matrix));
  if (is_variational) return fix(problem, system);
  balance_rows(&system->matrix, system->f);
  return SDR_OK;
}

sdr_status sdr_equations_assemble(const sdr_problem *problem, sdr_equations_system *out)
{
  const int64_t unknowns = (int64_t)problem->fields * problem->points->count;
  sdr_equations_system system = {.kind = problem->equation->variational ? SDR_MATRIX_POSITIVE
                                                                        : SDR_MATRIX_GENERAL};
  sdr_csr_builder *builder = NULL;
  if (unknowns > INT32_MAX)
    return sdr_fail(SDR_BAD_INPUT, "%s: %lld unknowns; at most %d are possible",
                    sdr_origin_text(problem->scene->points.origin), (long long)unknowns, INT32_MAX);
  system.f = sdr_alloc((size_t)unknowns, sizeof *system.f);
  sdr_status status = system.f ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK)
    status = sdr_csr_builder_create((int32_t)unknowns, (int32_t)unknowns, &builder);
  if (status == SDR_OK) status = assemble(problem, builder, &system);
  sdr_csr_builder_destroy(&builder);
  if (status == SDR_OK)
    *out = system;
  else
    sdr_equations_destroy(&system);
  return status;
}

void sdr_equations_destroy(sdr_equations_system *system)
{
  sdr_csr_destroy(&system->matrix);
  sdr_free(system->f);
  *system = (sdr_equations_system){0};
}
