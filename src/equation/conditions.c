#include "equation/conditions.h"

#include "base/memory.h"
#include "geometry/face.h"
#include "geometry/place.h"
#include "geometry/shape.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Points this near to a face, in spacings, lie on it. */
static const double on_face = 0.25;

sdr_status sdr_equation_value(sdr_expression *formula, sdr_origin origin, const char *what,
                              const double x[3], double *value)
{
  char why[400];
  if (sdr_expression_value(formula, x, 0.0, value) == SDR_OK) return SDR_OK;
  snprintf(why, sizeof why, "%s", sdr_error_message());
  return sdr_fail(SDR_BAD_INPUT, "%s: %s: %s", sdr_origin_text(origin), what, why);
}

sdr_status sdr_condition_value(const sdr_boundary *boundary, const sdr_equation *equation, int c,
                               const double x[3], double *value)
{
  sdr_expression *formula = boundary->is_exact ? equation->exact[c] : boundary->value[c];
  return sdr_equation_value(formula, boundary->origin, "the condition", x, value);
}

sdr_status sdr_condition_normal(const sdr_problem *problem, const sdr_boundary *boundary,
                                const sdr_place *place, double normal[3])
{
  double x[3];
  memset(normal, 0, 3 * sizeof *normal);
  if (!problem->words->condition[boundary->condition].is_natural || !place->face[0]) return SDR_OK;
  if (sdr_face_plane(sdr_place_shape(problem->scene, place), place->face, x, normal)) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: '%s' is not flat, so there is no one direction for '%s'; prescribe the "
                  "solution there",
                  sdr_origin_text(boundary->origin), place->text,
                  problem->words->condition[boundary->condition].word);
}

/* 1 if the entry prescribes component c. */
static int gives(const sdr_problem *problem, const sdr_boundary *boundary, int c)
{
  const int components = problem->words->is_vector ? problem->components : 1;
  return c < components && (boundary->is_exact || boundary->value[c]);
}

static sdr_status find_entry(const sdr_problem *problem, int entry, sdr_row_condition *rows)
{
  const sdr_boundary *boundary = &problem->equation->boundary[entry];
  const int32_t count = problem->points->count;
  sdr_term terms[SDR_EQUATION_TERMS];
  for (int k = 0; k < boundary->place_count; ++k) {
    const sdr_place *place = &boundary->on[k];
    double normal[3], x[3];
    int32_t met = 0;
    SDR_TRY(sdr_condition_normal(problem, boundary, place, normal));
    for (int32_t i = 0; i < count; ++i) {
      const double h = problem->points->spacing[i];
      sdr_problem_place(problem, i, x);
      if (!sdr_place_holds(problem->scene, place, x, h, on_face * h)) continue;
      ++met;
      for (int c = 0, row; c < 3; ++c) {
        if (!gives(problem, boundary, c)) continue;
        problem->ops->condition(problem, boundary->condition, c, normal, terms, &row);
        rows[row * count + i] = (sdr_row_condition){(int16_t)entry, (int16_t)k, (int16_t)c};
      }
    }
    if (met == 0)
      return sdr_fail(SDR_BAD_INPUT,
                      "%s: '%s' meets no point; align the points with it, or choose another place",
                      sdr_origin_text(place->origin), place->text);
  }
  return SDR_OK;
}

sdr_status sdr_conditions_find(const sdr_problem *problem, int natural, sdr_row_condition **out)
{
  const size_t unknowns = (size_t)problem->fields * (size_t)problem->points->count;
  sdr_row_condition *rows = sdr_alloc(unknowns, sizeof *rows);
  if (!rows) return SDR_RUN_FAILED;
  for (size_t r = 0; r < unknowns; ++r) rows[r].entry = -1;
  sdr_status status = SDR_OK;
  for (int k = 0; status == SDR_OK && k < problem->equation->boundary_count; ++k) {
    const int which = problem->equation->boundary[k].condition;
    if (natural || !problem->words->condition[which].is_natural)
      status = find_entry(problem, k, rows);
  }
  if (status == SDR_OK)
    *out = rows;
  else
    sdr_free(rows);
  return status;
}

sdr_status sdr_conditions_complete(const sdr_problem *problem, const sdr_row_condition *rows)
{
  const int32_t count = problem->points->count;
  for (int32_t i = 0; i < count; ++i) {
    double x[3];
    sdr_problem_place(problem, i, x);
    if (sdr_shape_contains(problem->scene->points.shape, x, -on_face * problem->points->spacing[i]))
      continue;
    for (int p = 0; p < problem->fields; ++p)
      if (rows[p * count + i].entry < 0)
        return sdr_fail(SDR_BAD_INPUT,
                        "%s: %s lies on the surface and lacks a condition (%d of %d); collocation "
                        "needs one for each unknown there: give equation.boundary an entry for its "
                        "face",
                        sdr_origin_text(problem->equation->origin),
                        sdr_point_named(&problem->support.cloud, i).text, p + 1, problem->fields);
  }
  return SDR_OK;
}
