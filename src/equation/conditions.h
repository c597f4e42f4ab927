/* The conditions of an equation's scene, found at points. */
#ifndef SDR_EQUATION_CONDITIONS_H
#define SDR_EQUATION_CONDITIONS_H

#include "equation/problem.h"

/* What stands in a row of unknowns: entry of the scene's boundary, one of its places, component of
   its values; entry -1: nothing. */
typedef struct {
  int16_t entry, place, component;
} sdr_row_condition;

/* One for each unknown (p count + i); later entries overwrite earlier ones. `natural` 0 leaves out
   those that a variational form takes as loads. An entry whose place meets no point is
   SDR_BAD_INPUT. Owner: the caller (sdr_free). */
sdr_status sdr_conditions_find(const sdr_problem *problem, int natural, sdr_row_condition **out);

/* SDR_BAD_INPUT unless every point on the surface has a condition for each unknown. */
sdr_status sdr_conditions_complete(const sdr_problem *problem, const sdr_row_condition *rows);

/* Outward normal of the place's face; zero for a volume. SDR_BAD_INPUT if the face is not flat. */
sdr_status sdr_condition_normal(const sdr_problem *problem, const sdr_boundary *boundary,
                                const sdr_place *place, double normal[3]);

/* The value that the scene prescribes there. */
sdr_status sdr_condition_value(const sdr_boundary *boundary, const sdr_equation *equation, int c,
                               const double x[3], double *value);

/* The value of a formula of the scene at a place; failures name `what` and the origin. */
sdr_status sdr_equation_value(sdr_expression *formula, sdr_origin origin, const char *what,
                              const double x[3], double *value);

#endif
