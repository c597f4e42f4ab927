#include "scene/expression.h"

#include "base/memory.h"
#include "scene/formula.h"
#include "scene/units.h"

#include <float.h>
#include <math.h>
#include <muParserDLL.h>
#include <stdio.h>
#include <string.h>

struct sdr_expression {
  muParserHandle_t parser;
  char *text;
  int uses, is_polar;
  double constant; /* the value of a formula that uses nothing */
  double variable[SDR_VAR_COUNT];
  int quantity_count;
  double *quantity; /* what the formula's numbers are now; the parser reads them here */
};

/* ---- muParser -------------------------------------------------------------------------------- */

static void fill_variables(sdr_expression *e, const double x[3], double t)
{
  e->variable[SDR_VAR_X] = x[0];
  e->variable[SDR_VAR_Y] = x[1];
  e->variable[SDR_VAR_Z] = x[2];
  e->variable[SDR_VAR_T] = t;
  if (!e->is_polar) return;
  e->variable[SDR_VAR_R] = sqrt(x[0] * x[0] + x[1] * x[1]);
  e->variable[SDR_VAR_THETA] = atan2(x[1], x[0]);
}

static const char *reason_for(int code)
{
  switch (code) {
  case 2:
    return "the formula ends too early";
  case 3:
    return "unexpected ','; a formula gives one number";
  case 5:
  case 6:
  case 12:
    return "an operator is missing before this";
  case 7:
    return "unexpected parenthesis";
  case 11:
    return "a closing parenthesis is missing";
  case 14:
    return "the function has too many arguments";
  case 15:
    return "the function has too few arguments";
  case 32:
  case 33:
  case 34:
    return "a choice is written CONDITION ? VALUE : VALUE";
  default:
    return "an operator or a value is missing or too many";
  }
}

static sdr_status parser_error(sdr_expression *e, const sdr_formula *f)
{
  const int code = mupGetErrorCode(e->parser), at = mupGetErrorPos(e->parser);
  const int index = at < 0 ? 0 : at >= f->length ? f->length - 1 : at;
  mupErrorReset(e->parser);
  return sdr_fail(SDR_BAD_INPUT, "%d: %s", f->length > 0 ? f->column[index] : 1, reason_for(code));
}

/* Without a handler muParser would print. */
static void stay_silent(muParserHandle_t parser)
{
  (void)parser;
}

static sdr_status compile(sdr_expression *e, const sdr_formula *f)
{
  e->parser = mupCreate(muBASETYPE_FLOAT);
  if (!e->parser) return sdr_fail(SDR_RUN_FAILED, "out of memory: no room for a formula");
  mupSetErrorHandler(e->parser, stay_silent);
  mupClearConst(e->parser);
  mupDefineConst(e->parser, "pi", 3.14159265358979323846);
  for (int k = 0; k < SDR_VAR_COUNT; ++k) {
    mupDefineVar(e->parser, sdr_formula_variables[k], &e->variable[k]);
  }
  for (int k = 0; k < f->quantity_count; ++k) {
    char name[16];
    snprintf(name, sizeof name, "_q%d", k);
    e->quantity[k] = f->quantity[k].value;
    mupDefineVar(e->parser, name, &e->quantity[k]);
  }
  fill_variables(e, (double[3]){0.3, 0.2, 0.1}, 1e-3);
  mupSetExpr(e->parser, f->text);
  int results = 0;
  mupEvalMulti(e->parser, &results);
  if (mupError(e->parser)) return parser_error(e, f);
  if (results != 1) return sdr_fail(SDR_BAD_INPUT, "1: a formula gives one number, not several");
  return SDR_OK;
}

/* ---- the check of dimensions ----------------------------------------------------------------- */

/* Each base unit is made SCALE times smaller, which must multiply the value by SCALE^exponent. A
   power of 4 scales without rounding, also under square roots. */
enum { SCALE = 4, BASES = 4 };

static double scaled_value(sdr_expression *e, const sdr_formula *f, const double x[3], double t,
                           int base)
{
  for (int k = 0; k < f->quantity_count; ++k) {
    const sdr_unit unit = f->quantity[k].unit;
    const int exponent[BASES] = {unit.m, unit.kg, unit.s, unit.K};
    e->quantity[k] = f->quantity[k].value * (base < 0 ? 1 : pow(SCALE, exponent[base]));
  }
  const double length = base == 0 ? SCALE : 1, time = base == 2 ? SCALE : 1;
  const double place[3] = {length * x[0], length * x[1], length * x[2]};
  fill_variables(e, place, time * t);
  return mupEval(e->parser);
}

/* So small that digits are lost, by which it no longer scales. */
static int is_too_small(double value)
{
  return value != 0 && fabs(value) < DBL_MIN;
}

/* Exponents of the value at one place and time; 0 if the value says nothing there. */
static int exponents_at(sdr_expression *e, const sdr_formula *f, const double x[3], double t,
                        double exponent[BASES])
{
  const double plain = scaled_value(e, f, x, t, -1);
  for (int base = 0; base < BASES; ++base) {
    const double scaled = scaled_value(e, f, x, t, base), ratio = scaled / plain;
    if (!isfinite(ratio) || !isfinite(plain) || plain == 0) return 0;
    if (is_too_small(plain) || is_too_small(scaled)) return 0;
    exponent[base] = ratio > 0 ? log2(ratio) / log2(SCALE) : (double)NAN;
  }
  return 1;
}

static sdr_status wrong_dimension(const char *text, const double exponent[BASES], sdr_unit wanted)
{
  const char *example = sdr_unit_example(wanted);
  double whole[BASES];
  int is_named = 1;
  for (int k = 0; k < BASES; ++k) {
    whole[k] = rint(exponent[k]);
    is_named = is_named && fabs(exponent[k] - whole[k]) < 1e-6 && fabs(whole[k]) < 100;
  }
  const sdr_unit found = is_named ? (sdr_unit){(signed char)whole[0], (signed char)whole[1],
                                               (signed char)whole[2], (signed char)whole[3]}
                                  : (sdr_unit){0, 0, 0, 0};
  if (!is_named || sdr_unit_equal(found, wanted)) {
    return sdr_fail(SDR_BAD_INPUT,
                    "1: '%s' adds or compares different kinds of quantities (beside units, a bare "
                    "number in a formula is a plain number), wanted %s%s%s",
                    text, sdr_unit_name(wanted), *example ? ", like " : "", example);
  }
  return sdr_fail(SDR_BAD_INPUT, "1: '%s' is %s, wanted %s%s%s", text, sdr_unit_name(found),
                  sdr_unit_name(wanted), *example ? ", like " : "", example);
}

/* Places and times of all sizes, so that a term of the wrong kind cannot hide behind a large one
   or behind a condition. */
static sdr_status check_dimension(sdr_expression *e, const sdr_formula *f, sdr_unit wanted)
{
  const double want[BASES] = {wanted.m, wanted.kg, wanted.s, wanted.K};
  if (f->is_number) { /* also 0, which scales as anything */
    const sdr_unit found = f->quantity[0].unit;
    const double exponent[BASES] = {found.m, found.kg, found.s, found.K};
    return sdr_unit_equal(found, wanted) ? SDR_OK : wrong_dimension(e->text, exponent, wanted);
  }
  const int samples = f->uses ? 16 : 1;
  for (int sample = 0; sample < samples; ++sample) {
    const double size = pow(10, -sample * 0.5), sign = sample % 4 < 2 ? 1 : -1;
    const double x[3] = {0.7 * size, sign * 0.45 * size, 0.31 * size};
    double exponent[BASES];
    if (!exponents_at(e, f, x, 0.83 * size, exponent)) continue;
    for (int k = 0; k < BASES; ++k) {
      if (!(fabs(exponent[k] - want[k]) < 1e-9)) return wrong_dimension(e->text, exponent, wanted);
    }
  }
  return SDR_OK;
}

/* ---- the interface --------------------------------------------------------------------------- */

/* A formula without any unit is in SI throughout; so is a bare number. */
static sdr_status finish(sdr_expression *e, const sdr_formula *f, sdr_unit unit)
{
  SDR_TRY(compile(e, f));
  if (f->has_units && !sdr_unit_equal(unit, SDR_ANY_UNIT)) {
    SDR_TRY(check_dimension(e, f, unit));
  }
  for (int k = 0; k < f->quantity_count; ++k) e->quantity[k] = f->quantity[k].value;
  if (e->uses) return SDR_OK;
  e->constant = mupEval(e->parser);
  if (!isfinite(e->constant)) {
    return sdr_fail(SDR_BAD_INPUT, "1: '%s' is not a finite number", e->text);
  }
  if (is_too_small(e->constant)) {
    return sdr_fail(SDR_BAD_INPUT, "1: '%s' gives %g, below 2.3e-308, which is too small; write 0",
                    e->text, e->constant);
  }
  return SDR_OK;
}

static sdr_status create(const char *text, const sdr_formula *f, sdr_unit unit,
                         sdr_expression **out)
{
  sdr_expression *e = sdr_alloc(1, sizeof *e);
  if (!e) return SDR_RUN_FAILED;
  sdr_status status = SDR_RUN_FAILED;
  e->text = sdr_strdup(text);
  if (e->text) e->quantity = sdr_alloc((size_t)f->quantity_count, sizeof *e->quantity);
  e->uses = f->uses;
  e->is_polar = f->is_polar;
  e->variable[SDR_VAR_N] = 1.0; /* a plain number to the check of dimensions */
  if (e->quantity) status = finish(e, f, unit);
  if (status == SDR_OK) {
    *out = e;
  } else {
    sdr_expression_destroy(&e);
  }
  return status;
}

/* "3.015 spacing" becomes the plain number 3.015. */
static sdr_status create_relative(const char *text, double value, sdr_expression **out)
{
  char plain[40];
  sdr_formula *f = sdr_alloc(1, sizeof *f);
  if (!f) return SDR_RUN_FAILED;
  snprintf(plain, sizeof plain, "%.17g", value);
  sdr_status status = sdr_formula_scan(plain, f);
  if (status == SDR_OK) status = create(text, f, SDR_ANY_UNIT, out);
  sdr_free(f);
  return status;
}

sdr_status sdr_expression_create(const char *text, sdr_unit unit, const char *relative,
                                 int *is_relative, sdr_expression **out)
{
  double value;
  if (relative && sdr_formula_relative(text, relative, &value)) {
    SDR_TRY(create_relative(text, value, out));
    *is_relative = 1;
    return SDR_OK;
  }
  sdr_formula *f = sdr_alloc(1, sizeof *f);
  if (!f) return SDR_RUN_FAILED;
  sdr_status status = sdr_formula_scan(text, f);
  if (status == SDR_OK) status = create(text, f, unit, out);
  sdr_free(f);
  if (status == SDR_OK && is_relative) *is_relative = 0;
  return status;
}

void sdr_expression_destroy(sdr_expression **expression)
{
  if (!expression || !*expression) return;
  if ((*expression)->parser) mupRelease((*expression)->parser);
  sdr_free((*expression)->text);
  sdr_free((*expression)->quantity);
  sdr_free(*expression);
  *expression = NULL;
}

int sdr_expression_uses(const sdr_expression *expression)
{
  return expression->uses;
}

/* Only what the formula uses is named. The sign of a NaN is the compiler's whim. */
static sdr_status fail_not_finite(const sdr_expression *expression, double result,
                                  const double x[3], double t)
{
  char place[100] = "", time[40] = "", index[40] = "";
  const int both = (expression->uses & SDR_USES_SPACE) && (expression->uses & SDR_USES_TIME);
  if (expression->uses & SDR_USES_SPACE)
    snprintf(place, sizeof place, "(x, y, z) = (%g, %g, %g) m%s", x[0], x[1], x[2],
             both ? ", " : "");
  if (expression->uses & SDR_USES_TIME) snprintf(time, sizeof time, "t = %g s", t);
  if (expression->uses & SDR_USES_INDEX)
    snprintf(index, sizeof index, "%sn = %g", place[0] || time[0] ? ", " : "",
             expression->variable[SDR_VAR_N]);
  return sdr_fail(SDR_BAD_INPUT, "the formula '%s' gives %g at %s%s%s; it must be finite",
                  expression->text, isnan(result) ? fabs(result) : result, place, time, index);
}

sdr_status sdr_expression_sum(sdr_expression *expression, const double x[3], double t,
                              int64_t first, int64_t last, double *value)
{
  double sum = 0.0;
  for (int64_t n = first; n <= last; ++n) {
    double term = 0.0;
    expression->variable[SDR_VAR_N] = (double)n;
    SDR_TRY(sdr_expression_value(expression, x, t, &term));
    sum += term;
  }
  *value = sum;
  return SDR_OK;
}

sdr_status sdr_expression_value(sdr_expression *expression, const double x[3], double t,
                                double *value)
{
  if (!expression->uses) {
    *value = expression->constant;
    return SDR_OK;
  }
  fill_variables(expression, x, t);
  const double result = mupEval(expression->parser);
  if (!isfinite(result)) return fail_not_finite(expression, result, x, t);
  *value = result;
  return SDR_OK;
}

const char *sdr_expression_text(const sdr_expression *expression)
{
  return expression->text;
}
