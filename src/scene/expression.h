/* Formulas of a scene: numbers with units, and expressions of x y z t r theta, in SI. */
#ifndef SDR_SCENE_EXPRESSION_H
#define SDR_SCENE_EXPRESSION_H

#include "base/status.h"

#include <stdint.h>

/* A compiled formula. One handle may be used by one thread at a time. */
typedef struct sdr_expression sdr_expression;

/* Which variables a formula uses, or'd. r = sqrt(x^2+y^2) and theta = atan2(y, x) count as space.
   The index is n, of a series. */
enum { SDR_USES_SPACE = 1, SDR_USES_TIME = 2, SDR_USES_INDEX = 4 };

/* Exponents of metre, kilogram, second, kelvin; a plain number has none. */
typedef struct {
  signed char m, kg, s, K;
} sdr_unit;

/* Compile `text`, whose value must have the dimension `unit`. Numbers may carry units
   ("400 MPa * exp(-t/(100 us))"); x y z r are lengths, t a time, theta a plain number. A bare
   number alone ("5") is taken as SI of the wanted unit. `relative`, if not NULL, names a unit of
   the scene's own, "spacing" or "horizon", that is allowed as the unit of a whole plain number
   ("3.015 spacing"); then *is_relative tells whether it was used.
   On failure SDR_BAD_INPUT with a message that starts with the column in `text` (1-based) and ": ".
   The caller destroys *out. */
sdr_status sdr_expression_create(const char *text, sdr_unit unit, const char *relative,
                                 int *is_relative, sdr_expression **out);
void sdr_expression_destroy(sdr_expression **expression); /* NULL-safe */

int sdr_expression_uses(const sdr_expression *expression); /* SDR_USES_... */

/* Value in SI at the place x[3] (metres) and time t (seconds). A value that is not finite gives
   SDR_BAD_INPUT with the place and time in the message. */
sdr_status sdr_expression_value(sdr_expression *expression, const double x[3], double t,
                                double *value);

/* Sum of the values for n = first .. last (first <= last), added in that order. */
sdr_status sdr_expression_sum(sdr_expression *expression, const double x[3], double t,
                              int64_t first, int64_t last, double *value);

/* The text it was compiled from. */
const char *sdr_expression_text(const sdr_expression *expression);

#endif
