/* A formula's text taken apart: numbers with their units become quantities, names are checked. */
#ifndef SDR_SCENE_FORMULA_H
#define SDR_SCENE_FORMULA_H

#include "base/status.h"
#include "scene/expression.h"

enum { SDR_FORMULA_MAX_TEXT = 2000, SDR_FORMULA_MAX_QUANTITIES = 100 };

typedef enum {
  SDR_VAR_X,
  SDR_VAR_Y,
  SDR_VAR_Z,
  SDR_VAR_T,
  SDR_VAR_R,
  SDR_VAR_THETA,
  SDR_VAR_N,
  SDR_VAR_COUNT
} sdr_formula_variable;
extern const char *const sdr_formula_variables[SDR_VAR_COUNT];

/* A number of the formula in SI. */
typedef struct {
  double value;
  sdr_unit unit;
} sdr_formula_quantity;

/* The text with every number replaced by a name _q0, _q1, ... and blanks kept out. */
typedef struct {
  char text[8 * SDR_FORMULA_MAX_TEXT];
  int column[8 * SDR_FORMULA_MAX_TEXT]; /* of each byte, in the source, 1-based */
  int length;
  sdr_formula_quantity quantity[SDR_FORMULA_MAX_QUANTITIES];
  int quantity_count;
  int uses;         /* SDR_USES_... */
  int has_units;    /* some number carries a unit */
  int is_number;    /* one number, perhaps with a sign, and nothing else but a unit */
  int is_polar;     /* uses r or theta */
  int after_number; /* while scanning: the last token was a number */
} sdr_formula;

/* Take `text` apart. SDR_BAD_INPUT: the message starts with the column and ": ". */
sdr_status sdr_formula_scan(const char *text, sdr_formula *formula);

/* Read "[sign] number WORD", WORD the unit `relative`; 1 and *value if the whole text is that. */
int sdr_formula_relative(const char *text, const char *relative, double *value);

#endif
