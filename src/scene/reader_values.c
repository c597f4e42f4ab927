#include "scene/reader.h"

#include "scene/formula.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- formulas -------------------------------------------------------------------------------- */

static void release_expression(void *object)
{
  sdr_expression *expression = object;
  sdr_expression_destroy(&expression);
}

/* An expression's message "COLUMN: text" becomes an error at that column of the file. */
static void formula_error(sdr_reader *reader, const sdr_node *node)
{
  const char *message = sdr_error_message();
  char *end, path[256];
  const long column = strtol(message, &end, 10);
  const char *text = *end == ':' ? end + 2 : message;
  sdr_origin origin = node->origin;
  if (node->text_column > 0 && column > 0) origin.column = node->text_column + (int)column - 1;
  sdr_node_path(node, path, sizeof path);
  sdr_read_error(reader, origin, "%s: %s", path, text);
}

static int create_expression(sdr_reader *reader, sdr_node *node, sdr_unit unit,
                             const char *relative, int *is_relative, sdr_expression **out)
{
  char what[96];
  const char *example = sdr_unit_equal(unit, SDR_ANY_UNIT) ? "" : sdr_unit_example(unit);
  snprintf(what, sizeof what, "%s%s%s", *example ? sdr_unit_name(unit) : "a number",
           *example ? ", like " : "", example);
  if (!sdr_read_is(reader, node, SDR_SCALAR, what)) return 0;
  const sdr_status status = sdr_expression_create(node->text, unit, relative, is_relative, out);
  if (status == SDR_BAD_INPUT) {
    formula_error(reader, node);
  } else if (status != SDR_OK) {
    sdr_read_fatal(reader, status);
  }
  return status == SDR_OK;
}

/* Names of the variables in `uses`, for a message. */
static const char *variable_names(int uses)
{
  return uses == SDR_USES_TIME    ? "the time t"
         : uses == SDR_USES_SPACE ? "places (x y z r theta)"
                                  : "variables (x y z t r theta)";
}

static int check_uses(sdr_reader *reader, const sdr_node *node, const sdr_expression *expression,
                      int allowed)
{
  const int extra = sdr_expression_uses(expression) & ~allowed;
  if (!extra) return 1;
  char path[256];
  sdr_node_path(node, path, sizeof path);
  if (extra & SDR_USES_INDEX) {
    sdr_read_error(reader, node->origin, "%s: '%s' uses n, which only the formula of a series has",
                   path, node->text);
    return 0;
  }
  sdr_read_error(reader, node->origin, "%s: '%s' uses %s, which %s", path, node->text,
                 variable_names(extra),
                 allowed ? "it may not depend on" : "cannot stand here; give a constant");
  return 0;
}

int sdr_read_relative_node(sdr_reader *reader, sdr_node *node, sdr_unit unit, const char *relative,
                           int allowed, int *is_relative, sdr_expression **out)
{
  sdr_expression *expression;
  if (!create_expression(reader, node, unit, relative, is_relative, &expression)) return 0;
  if (sdr_store_keep(reader->store, expression, release_expression) != SDR_OK) {
    sdr_read_fatal(reader, SDR_RUN_FAILED);
    return 0;
  }
  if (!check_uses(reader, node, expression, allowed)) return 0;
  if (sdr_expression_uses(expression) == 0) {
    double value;
    sdr_expression_value(expression, (double[3]){0, 0, 0}, 0, &value);
    node->canonical = sdr_store_format(reader->store, "%.15g%s", value,
                                       is_relative && *is_relative ? relative : "");
    if (!node->canonical) sdr_read_fatal(reader, SDR_RUN_FAILED);
  }
  *out = expression;
  return 1;
}

int sdr_read_formula_node(sdr_reader *reader, sdr_node *node, sdr_unit unit, int allowed,
                          sdr_expression **out)
{
  return sdr_read_relative_node(reader, node, unit, NULL, allowed, NULL, out);
}

static int read_component_map(sdr_reader *reader, sdr_node *node, sdr_unit unit, int allowed,
                              sdr_expression *out[3])
{
  static const char *const names[] = {"x", "y", "z"};
  int given = 0;
  for (int c = 0; c < sdr_components(reader->dimension); ++c) {
    sdr_node *child = sdr_read_value(reader, node, names[c], SDR_OPTIONAL, "a value");
    if (child && sdr_read_formula_node(reader, child, unit, allowed, &out[c])) ++given;
  }
  sdr_read_done(reader, node);
  return given;
}

static int check_count(sdr_reader *reader, const sdr_node *node)
{
  const int components = sdr_components(reader->dimension);
  if (node->count == components) return 1;
  char path[256];
  sdr_node_path(node, path, sizeof path);
  sdr_read_error(reader, node->origin, "%s has %d component%s; this scene has %d (%s)", path,
                 node->count, node->count == 1 ? "" : "s", components,
                 components == 1   ? "[x]"
                 : components == 2 ? "[x, y]"
                                   : "[x, y, z]");
  return 0;
}

int sdr_read_components(sdr_reader *reader, sdr_node *node, sdr_unit unit, int allowed,
                        sdr_expression *out[3])
{
  out[0] = out[1] = out[2] = NULL;
  if (node->kind == SDR_MAPPING) return read_component_map(reader, node, unit, allowed, out);
  if (!sdr_read_is(reader, node, SDR_SEQUENCE, "components, as [x, y] or {x: ..., y: ...}")) {
    return 0;
  }
  if (!check_count(reader, node)) return 0;
  int given = 0, c = 0;
  for (sdr_node *child = node->first; child; child = child->next, ++c) {
    if (sdr_node_is_null(child)) continue;
    if (sdr_read_formula_node(reader, child, unit, allowed, &out[c])) ++given;
  }
  return given;
}

/* ---- numbers --------------------------------------------------------------------------------- */

static const char *si_symbol(sdr_unit unit)
{
  static const struct {
    sdr_unit unit;
    const char *symbol;
  } symbols[] = {{{1, 0, 0, 0}, " m"},    {{2, 0, 0, 0}, " m^2"},     {{0, 0, 1, 0}, " s"},
                 {{-1, 1, -2, 0}, " Pa"}, {{-3, 1, 0, 0}, " kg/m^3"}, {{0, 1, -2, 0}, " J/m^2"},
                 {{1, 0, -1, 0}, " m/s"}};
  for (size_t k = 0; k < sizeof symbols / sizeof *symbols; ++k) {
    if (sdr_unit_equal(unit, symbols[k].unit)) return symbols[k].symbol;
  }
  return "";
}

static void describe_range(sdr_quantity quantity, char *text, size_t size)
{
  const char *symbol = si_symbol(quantity.unit);
  if (isinf(quantity.high)) {
    snprintf(text, size, "%s %g%s", quantity.above_low ? "above" : "at least", quantity.low,
             symbol);
  } else if (isinf(quantity.low)) {
    snprintf(text, size, "%s %g%s", quantity.below_high ? "below" : "at most", quantity.high,
             symbol);
  } else {
    snprintf(text, size, "%s %g and %s %g%s", quantity.above_low ? "above" : "at least",
             quantity.low, quantity.below_high ? "below" : "at most", quantity.high, symbol);
  }
}

static int check_range(sdr_reader *reader, const sdr_node *node, sdr_quantity quantity,
                       double value)
{
  const int low_good = quantity.above_low ? value > quantity.low : value >= quantity.low;
  const int high_good = quantity.below_high ? value < quantity.high : value <= quantity.high;
  if (low_good && high_good) return 1;
  char path[256], range[96];
  sdr_node_path(node, path, sizeof path);
  describe_range(quantity, range, sizeof range);
  sdr_read_error(reader, node->origin, "%s = %s is out of range; allowed: %s", path, node->text,
                 range);
  return 0;
}

static int read_constant(sdr_reader *reader, sdr_node *node, const char *relative,
                         sdr_quantity quantity, sdr_length *out)
{
  sdr_expression *expression;
  int is_relative = 0, good = 0;
  double value = 0;
  if (!create_expression(reader, node, quantity.unit, relative, &is_relative, &expression))
    return 0;
  if (check_uses(reader, node, expression, 0)) {
    sdr_expression_value(expression, (double[3]){0, 0, 0}, 0, &value);
    good = check_range(reader, node, quantity, value);
  }
  sdr_expression_destroy(&expression);
  if (!good) return 0;
  node->canonical = sdr_store_format(reader->store, "%.15g%s%s", value, is_relative ? " " : "",
                                     is_relative ? relative : "");
  if (!node->canonical) sdr_read_fatal(reader, SDR_RUN_FAILED);
  *out = (sdr_length){value, is_relative};
  return 1;
}

int sdr_read_number_node(sdr_reader *reader, sdr_node *node, sdr_quantity quantity, double *out)
{
  sdr_length length;
  if (!read_constant(reader, node, NULL, quantity, &length)) return 0;
  *out = length.value;
  return 1;
}

static sdr_node *find_number(sdr_reader *reader, sdr_node *map, const char *key,
                             sdr_quantity quantity, const char *fallback, const char *relative)
{
  char what[128];
  const char *example = sdr_unit_example(quantity.unit);
  snprintf(what, sizeof what, "%s%s%s%s%s", sdr_unit_name(quantity.unit), *example ? ", like " : "",
           example, relative ? " or 2 " : "", relative ? relative : "");
  if (sdr_unit_equal(quantity.unit, SDR_ANY_UNIT)) snprintf(what, sizeof what, "a number");
  return sdr_read_value(reader, map, key, fallback, what);
}

int sdr_read_number(sdr_reader *reader, sdr_node *map, const char *key, sdr_quantity quantity,
                    const char *fallback, double *out)
{
  sdr_node *node = find_number(reader, map, key, quantity, fallback, NULL);
  return node && sdr_read_number_node(reader, node, quantity, out);
}

int sdr_read_length(sdr_reader *reader, sdr_node *map, const char *key, const char *relative,
                    sdr_quantity quantity, const char *fallback, sdr_length *out)
{
  sdr_node *node = find_number(reader, map, key, quantity, fallback, relative);
  return node && read_constant(reader, node, relative, quantity, out);
}

int sdr_read_number_or(sdr_reader *reader, sdr_node *map, const char *key, const char *word,
                       double word_value, sdr_quantity quantity, const char *fallback, double *out)
{
  sdr_node *node = find_number(reader, map, key, quantity, fallback, NULL);
  if (!node) return 0;
  if (node->kind == SDR_SCALAR && strcmp(node->text, word) == 0) {
    *out = word_value;
    return 1;
  }
  return sdr_read_number_node(reader, node, quantity, out);
}

int sdr_read_formula(sdr_reader *reader, sdr_node *map, const char *key, sdr_unit unit, int allowed,
                     const char *fallback, sdr_expression **out)
{
  const sdr_quantity any = {unit, -INFINITY, INFINITY, 0, 0};
  sdr_node *node = find_number(reader, map, key, any, fallback, NULL);
  return node && sdr_read_formula_node(reader, node, unit, allowed, out);
}

int sdr_read_integer(sdr_reader *reader, sdr_node *map, const char *key, int64_t low, int64_t high,
                     const char *fallback, int64_t *out)
{
  sdr_node *node = sdr_read_value(reader, map, key, fallback, "a whole number");
  if (!node || !sdr_read_is(reader, node, SDR_SCALAR, "a whole number")) return 0;
  char *end, path[256];
  errno = 0;
  const long long value = strtoll(node->text, &end, 10);
  sdr_node_path(node, path, sizeof path);
  if (end == node->text || *end != '\0' || isspace((unsigned char)node->text[0])) {
    sdr_read_error(reader, node->origin, "%s: '%.60s' is not a whole number", path, node->text);
    return 0;
  }
  if (errno || value < low || value > high) {
    sdr_read_error(reader, node->origin, "%s = %.60s is out of range; allowed: %lld to %lld", path,
                   node->text, (long long)low, (long long)high);
    return 0;
  }
  node->canonical = sdr_store_format(reader->store, "%lld", value);
  if (!node->canonical) sdr_read_fatal(reader, SDR_RUN_FAILED);
  *out = value;
  return 1;
}

int sdr_read_vector_node(sdr_reader *reader, sdr_node *node, sdr_quantity quantity, double out[3])
{
  double values[3] = {0, 0, 0};
  int c = 0, good = 1;
  if (!sdr_read_is(reader, node, SDR_SEQUENCE, "a list of components")) return 0;
  if (!check_count(reader, node)) return 0;
  for (sdr_node *child = node->first; child; child = child->next, ++c) {
    good = sdr_read_number_node(reader, child, quantity, &values[c]) && good;
  }
  if (good) memcpy(out, values, sizeof values);
  return good;
}

int sdr_read_vector(sdr_reader *reader, sdr_node *map, const char *key, sdr_quantity quantity,
                    const char *fallback, double out[3])
{
  static const char *const zeros[] = {"[0]", "[0, 0]", "[0, 0, 0]"};
  if (fallback && strcmp(fallback, "[0]") == 0) {
    fallback = zeros[sdr_components(reader->dimension) - 1];
  }
  sdr_node *node = sdr_read_value(reader, map, key, fallback, "a list of components");
  return node && sdr_read_vector_node(reader, node, quantity, out);
}

/* ---- words ----------------------------------------------------------------------------------- */

static int index_of(const char *text, const char *const *words)
{
  for (int k = 0; words && words[k]; ++k) {
    if (strcmp(text, words[k]) == 0) return k;
  }
  return -1;
}

static void join(const char *const *words, char *text, size_t size)
{
  size_t used = 0;
  text[0] = '\0';
  for (int k = 0; words[k] && used < size; ++k) {
    used += (size_t)snprintf(text + used, size - used, "%s%s", k ? ", " : "", words[k]);
  }
}

int sdr_read_word_node(sdr_reader *reader, const sdr_node *node, const char *what,
                       const char *const *words, const char *const *later, int *out)
{
  char list[300], wanted[340];
  join(words, list, sizeof list);
  snprintf(wanted, sizeof wanted, "one of: %s", list);
  if (!sdr_read_is(reader, node, SDR_SCALAR, wanted)) return 0;
  const int index = index_of(node->text, words);
  if (index >= 0) {
    *out = index;
    return 1;
  }
  if (index_of(node->text, later) >= 0) {
    sdr_read_error(reader, node->origin,
                   "the %s '%s' is not available in this version; available: %s", what, node->text,
                   list);
    return 0;
  }
  int count = 0;
  while (words[count]) ++count;
  const char *nearest = sdr_read_nearest(node->text, words, count);
  sdr_read_error(reader, node->origin, "unknown %s '%.60s'%s%s%s available: %s", what, node->text,
                 nearest ? "; did you mean '" : "", nearest ? nearest : "", nearest ? "'?" : ";",
                 list);
  return 0;
}

int sdr_read_word(sdr_reader *reader, sdr_node *map, const char *key, const char *const *words,
                  const char *const *later, const char *fallback, int *out)
{
  char list[300], wanted[340];
  join(words, list, sizeof list);
  snprintf(wanted, sizeof wanted, "one of: %s", list);
  sdr_node *node = sdr_read_value(reader, map, key, fallback, wanted);
  return node && sdr_read_word_node(reader, node, key, words, later, out);
}

int sdr_read_flag(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback,
                  int *out)
{
  static const char *const words[] = {"false", "true", NULL};
  return sdr_read_word(reader, map, key, words, NULL, fallback, out);
}

int sdr_read_text(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback,
                  char *out, size_t size)
{
  sdr_node *node = sdr_read_value(reader, map, key, fallback, "a text");
  if (!node || !sdr_read_is(reader, node, SDR_SCALAR, "a text")) return 0;
  char path[256];
  sdr_node_path(node, path, sizeof path);
  if (strlen(node->text) >= size) {
    sdr_read_error(reader, node->origin, "%s is longer than %zu bytes", path, size - 1);
    return 0;
  }
  if (node->text[0] == '\0') {
    sdr_read_error(reader, node->origin, "%s is an empty text", path);
    return 0;
  }
  memcpy(out, node->text, strlen(node->text) + 1);
  return 1;
}

int sdr_read_is_name(sdr_reader *reader, const char *text, sdr_origin origin, const char *what)
{
  static const char allowed[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  const size_t length = strlen(text);
  if (length > 0 && length < SDR_NAME_MAX && strspn(text, allowed) == length) return 1;
  sdr_read_error(reader, origin,
                 "'%.60s' is no name for %s; allowed: up to 63 letters, digits, _ and -", text,
                 what);
  return 0;
}

int sdr_read_name(sdr_reader *reader, sdr_node *map, const char *key, const char *fallback,
                  char out[SDR_NAME_MAX])
{
  sdr_node *node = sdr_read_value(reader, map, key, fallback, "a name");
  if (!node || !sdr_read_is(reader, node, SDR_SCALAR, "a name")) return 0;
  if (!sdr_read_is_name(reader, node->text, node->origin, key)) return 0;
  memcpy(out, node->text, strlen(node->text) + 1);
  return 1;
}
