/* Units of measurement: "GPa", "kg/m^3", "%", "deg". The names come from UDUNITS-2, the products
   are read here, because UDUNITS reads "m^0.5" as 5 and "3-2" as 1/9. Used by one thread only. */
#ifndef SDR_SCENE_UNITS_H
#define SDR_SCENE_UNITS_H

#include "base/status.h"
#include "scene/expression.h"

#include <stddef.h>

/* A unit in SI: 1 of it is multiply/divide base units. Two numbers, so that 81 mm is 81/1000 and
   not 81 * 0.001. */
typedef struct {
  double multiply, divide;
  sdr_unit dimension;
} sdr_measure;

/* Any dimension will do (sdr_expression_create: the value keeps whatever it has). */
#define SDR_ANY_UNIT ((sdr_unit){127, 127, 127, 127})

int sdr_unit_equal(sdr_unit a, sdr_unit b);

/* "a length", "a pressure", or "in kg m^-1 s^-3" where the dimension has no name; in a thread-local
   buffer, valid until the 4th next call. */
const char *sdr_unit_name(sdr_unit unit);
/* A fitting example, "1 mm"; "2" for a plain number, "" if there is none. */
const char *sdr_unit_example(sdr_unit unit);

/* Read the longest product of units at the start of `text` (blanks before it are skipped): names
   with whole exponents joined by / * . or a blank. It ends before a variable (x y z t r theta pi)
   or a function call. *used: bytes read, 0 if no unit stands there (*measure is then 1).
   SDR_BAD_INPUT: a unit with an unfit exponent, or one that is measured in what mechanics does not
   use; the message names it. SDR_IO_ERROR: UDUNITS' table cannot be read. */
sdr_status sdr_units_scan(const char *text, size_t *used, sdr_measure *measure);

/* 1 if `name` (letters only, `length` bytes) is a unit known by itself. */
int sdr_units_known(const char *name, size_t length);

/* "; did you mean 'MPa'?" for an unknown unit that is a known one in other letters, else "". In a
   thread-local buffer. */
const char *sdr_units_suggest(const char *name, size_t length);

#endif
