#include "scene/formula.h"

#include "scene/units.h"

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *const sdr_formula_variables[SDR_VAR_COUNT] = {"x", "y", "z", "t", "r", "theta", "n"};

/* What muParser knows, without `log`, which elsewhere is sometimes ln and sometimes log10. */
static const char *const functions[] = {"sin",   "cos",  "tan",   "asin", "acos",  "atan",
                                        "atan2", "sinh", "cosh",  "tanh", "asinh", "acosh",
                                        "atanh", "log2", "log10", "ln",   "exp",   "sqrt",
                                        "sign",  "rint", "abs",   "min",  "max"};

#define FUNCTION_LIST                                                                              \
  "sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh log2 log10 ln exp sqrt sign " \
  "rint abs min max"

static void put(sdr_formula *f, const char *text, int column)
{
  f->after_number = 0;
  for (; *text; ++text) {
    f->text[f->length] = *text;
    f->column[f->length++] = column;
  }
  f->text[f->length] = '\0';
}

/* Length of a number literal: 12, 1.5, .5, 2e4; 0 if none. */
static size_t number_length(const char *text)
{
  static const char digits[] = "0123456789";
  size_t length = strspn(text, digits);
  size_t count = length;
  if (text[length] == '.') {
    const size_t decimals = strspn(text + length + 1, digits);
    count += decimals;
    length += 1 + decimals;
  }
  if (count == 0) return 0;
  if (text[length] == 'e' || text[length] == 'E') {
    const size_t sign = text[length + 1] == '-' || text[length + 1] == '+';
    const size_t exponent = strspn(text + length + 1 + sign, digits);
    if (exponent > 0) length += 1 + sign + exponent;
  }
  return length;
}

/* strtod of a literal that is cut out first, so that 0x10 is not taken for a number. */
static double number_value(const char *text, size_t length)
{
  char copy[64];
  if (length >= sizeof copy) return NAN;
  memcpy(copy, text, length);
  copy[length] = '\0';
  return strtod(copy, NULL);
}

/* A literal other than zero whose value is zero, or so small that it has lost digits. */
static int is_too_small(const char *text, size_t length, double value)
{
  if (fabs(value) >= DBL_MIN) return 0;
  for (size_t k = 0; k < length && text[k] != 'e' && text[k] != 'E'; ++k)
    if (text[k] >= '1' && text[k] <= '9') return 1;
  return 0;
}

static size_t word_length(const char *text)
{
  size_t length = 0;
  while (isalnum((unsigned char)text[length]) || text[length] == '_') ++length;
  return length;
}

static sdr_status scan_number(const char *text, size_t *at, sdr_formula *f)
{
  const int column = (int)*at + 1;
  const size_t length = number_length(text + *at);
  if (f->quantity_count == SDR_FORMULA_MAX_QUANTITIES) {
    return sdr_fail(SDR_BAD_INPUT, "%d: more than 100 numbers in one formula", column);
  }
  const double number = number_value(text + *at, length);
  if (!isfinite(number)) {
    return sdr_fail(SDR_BAD_INPUT, "%d: the number '%.*s' is too large or too long", column,
                    (int)(length > 40 ? 40 : length), text + *at);
  }
  size_t used;
  sdr_measure measure;
  const sdr_status status = sdr_units_scan(text + *at + length, &used, &measure);
  if (status != SDR_OK) {
    char why[256];
    snprintf(why, sizeof why, "%s", sdr_error_message());
    return sdr_fail(status, "%d: %s", column, why);
  }
  const double value = number * measure.multiply / measure.divide;
  if (is_too_small(text + *at, length, value)) {
    return sdr_fail(SDR_BAD_INPUT, "%d: '%.*s' is below 2.3e-308 in SI units, too small; write 0",
                    column, (int)(length > 40 ? 40 : length + used), text + *at);
  }
  f->quantity[f->quantity_count] = (sdr_formula_quantity){value, measure.dimension};
  if (used > 0) f->has_units = 1;
  char name[16];
  snprintf(name, sizeof name, "_q%d", f->quantity_count++);
  put(f, name, column);
  f->after_number = 1;
  *at += length + used;
  return SDR_OK;
}

static sdr_status unknown_word(const char *text, size_t at, size_t length, const sdr_formula *f)
{
  const int column = (int)at + 1, shown = (int)(length > 40 ? 40 : length);
  const char *word = text + at;
  const size_t letters = strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ");
  if (f->after_number) {
    const char *hint = sdr_units_suggest(word, length);
    if (letters < length && sdr_units_known(word, letters)) hint = "; write a power as m^2";
    return sdr_fail(SDR_BAD_INPUT, "%d: unknown unit '%.*s'%s", column, shown, word, hint);
  }
  if (length == 3 && strncmp(word, "log", 3) == 0) {
    return sdr_fail(SDR_BAD_INPUT, "%d: 'log' could mean two things; write ln or log10", column);
  }
  if (length == 3 && strncmp(word, "pow", 3) == 0) {
    return sdr_fail(SDR_BAD_INPUT, "%d: unknown function 'pow'; write a^b", column);
  }
  if (letters == length && sdr_units_known(word, length)) {
    return sdr_fail(SDR_BAD_INPUT, "%d: the unit '%.*s' must follow a number, like 1 %.*s", column,
                    shown, word, shown, word);
  }
  return sdr_fail(
      SDR_BAD_INPUT,
      "%d: unknown name '%.*s'; known: x y z t r theta pi and the functions " FUNCTION_LIST, column,
      shown, word);
}

static sdr_status scan_word(const char *text, size_t *at, sdr_formula *f)
{
  const size_t length = word_length(text + *at);
  const int column = (int)*at + 1;
  char word[16] = "";
  if (length < sizeof word) memcpy(word, text + *at, length);
  int known = strcmp(word, "pi") == 0;
  for (int k = 0; k < SDR_VAR_COUNT; ++k) {
    if (strcmp(word, sdr_formula_variables[k]) != 0) continue;
    known = 1;
    f->uses |= k == SDR_VAR_T ? SDR_USES_TIME : k == SDR_VAR_N ? SDR_USES_INDEX : SDR_USES_SPACE;
    if (k == SDR_VAR_R || k == SDR_VAR_THETA) f->is_polar = 1;
  }
  for (size_t k = 0; k < sizeof functions / sizeof *functions; ++k) {
    if (strcmp(word, functions[k]) == 0) known = 1;
  }
  if (!known) return unknown_word(text, *at, length, f);
  if (f->after_number) {
    return sdr_fail(SDR_BAD_INPUT, "%d: '%s' follows a number without an operator; write 2*%s",
                    column, word, word);
  }
  put(f, word, column);
  *at += length;
  return SDR_OK;
}

static sdr_status scan_operator(const char *text, size_t *at, sdr_formula *f)
{
  static const char *const pairs[] = {"==", "!=", "<=", ">=", "&&", "||"};
  const char *here = text + *at;
  const int column = (int)*at + 1;
  for (size_t k = 0; k < sizeof pairs / sizeof *pairs; ++k) {
    if (strncmp(here, pairs[k], 2) != 0) continue;
    put(f, pairs[k], column);
    *at += 2;
    return SDR_OK;
  }
  if (*here == '.' && isalpha((unsigned char)here[1])) { /* YAML's .nan and .inf */
    return sdr_fail(SDR_BAD_INPUT, "%d: '%.5s' is not a finite number", column, here);
  }
  if (*here == '=') {
    return sdr_fail(SDR_BAD_INPUT,
                    "%d: '=' assigns, which is not allowed; compare with ==", column);
  }
  if (!strchr("+-*/^(),<>?:", *here)) {
    if ((unsigned char)*here >= 0x80) {
      return sdr_fail(SDR_BAD_INPUT, "%d: a letter or sign that no formula has", column);
    }
    return sdr_fail(SDR_BAD_INPUT, "%d: unexpected '%c' in a formula", column, *here);
  }
  const char one[2] = {*here, '\0'};
  put(f, one, column);
  ++*at;
  return SDR_OK;
}

/* One quantity with nothing but signs before it. */
static int is_one_number(const sdr_formula *f)
{
  const size_t signs = strspn(f->text, "+-");
  return f->quantity_count == 1 && signs <= 1 && strcmp(f->text + signs, "_q0") == 0;
}

sdr_status sdr_formula_scan(const char *text, sdr_formula *f)
{
  const size_t length = strlen(text);
  memset(f, 0, sizeof *f);
  if (text[strspn(text, " \t\n")] == '\0') {
    return sdr_fail(SDR_BAD_INPUT, "1: an empty formula; give a value");
  }
  if (length > SDR_FORMULA_MAX_TEXT) {
    return sdr_fail(SDR_BAD_INPUT, "1: a formula of more than 2000 characters");
  }
  for (size_t at = 0; at < length;) {
    if (isspace((unsigned char)text[at])) {
      ++at;
    } else if (number_length(text + at) > 0) {
      if (f->after_number) {
        return sdr_fail(SDR_BAD_INPUT, "%d: two numbers without an operator between them",
                        (int)at + 1);
      }
      SDR_TRY(scan_number(text, &at, f));
    } else if (isalpha((unsigned char)text[at]) || text[at] == '_') {
      SDR_TRY(scan_word(text, &at, f));
    } else {
      SDR_TRY(scan_operator(text, &at, f));
    }
  }
  f->is_number = is_one_number(f);
  return SDR_OK;
}

int sdr_formula_relative(const char *text, const char *relative, double *value)
{
  const char *at = text + strspn(text, " ");
  const double sign = *at == '-' ? -1 : 1;
  if (*at == '-' || *at == '+') ++at;
  const size_t digits = number_length(at);
  if (digits == 0) return 0;
  const double number = number_value(at, digits);
  at += digits;
  at += strspn(at, " ");
  if (strncmp(at, relative, strlen(relative)) != 0) return 0;
  at += strlen(relative);
  if (at[strspn(at, " ")] != '\0' || !isfinite(number)) return 0;
  *value = sign * number;
  return 1;
}
