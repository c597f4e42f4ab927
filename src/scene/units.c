#include "scene/units.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <udunits2.h>

enum { NAME_MAX_BYTES = 32, EXPONENT_MAX = 12 };

/* ---- names of dimensions --------------------------------------------------------------------- */

static const struct {
  sdr_unit unit;
  const char *name, *example;
} dimensions[] = {
    {{0, 0, 0, 0}, "a plain number", "2"},
    {{1, 0, 0, 0}, "a length", "1 mm"},
    {{2, 0, 0, 0}, "an area", "1 mm^2"},
    {{3, 0, 0, 0}, "a volume", "1 mm^3"},
    {{0, 1, 0, 0}, "a mass", "1 kg"},
    {{0, 0, 1, 0}, "a time", "1 us"},
    {{0, 0, 0, 1}, "a temperature", "300 K"},
    {{1, 0, -1, 0}, "a velocity", "1 m/s"},
    {{1, 0, -2, 0}, "an acceleration", "1 m/s^2"},
    {{1, 1, -2, 0}, "a force", "1 kN"},
    {{-1, 1, -2, 0}, "a pressure", "1 MPa"},
    {{-2, 1, -2, 0}, "a force per volume", "1 N/m^3"},
    {{-3, 1, 0, 0}, "a density", "7850 kg/m^3"},
    {{0, 1, -2, 0}, "an energy per area", "100 J/m^2"},
    {{2, 1, -2, 0}, "an energy", "1 J"},
    {{2, 1, -3, 0}, "a power", "1 W"},
    {{0, 0, -1, 0}, "a frequency", "1 Hz"},
    {{-1, 0, 0, 0}, "a number per length", "1 /m"},
};
enum { DIMENSION_COUNT = sizeof dimensions / sizeof *dimensions };

int sdr_unit_equal(sdr_unit a, sdr_unit b)
{
  return a.m == b.m && a.kg == b.kg && a.s == b.s && a.K == b.K;
}

const char *sdr_unit_name(sdr_unit unit)
{
  static _Thread_local char texts[4][48];
  static _Thread_local int turn;
  for (int k = 0; k < DIMENSION_COUNT; ++k) {
    if (sdr_unit_equal(unit, dimensions[k].unit)) return dimensions[k].name;
  }
  char *text = texts[turn++ & 3];
  const char *symbols[] = {"m", "kg", "s", "K"};
  const int exponents[] = {unit.m, unit.kg, unit.s, unit.K};
  size_t used = (size_t)snprintf(text, sizeof texts[0], "in");
  for (int k = 0; k < 4 && used < sizeof texts[0]; ++k) {
    if (exponents[k] == 0) continue;
    const char *format = exponents[k] == 1 ? " %s" : " %s^%d";
    used += (size_t)snprintf(text + used, sizeof texts[0] - used, format, symbols[k], exponents[k]);
  }
  return text;
}

const char *sdr_unit_example(sdr_unit unit)
{
  for (int k = 0; k < DIMENSION_COUNT; ++k) {
    if (sdr_unit_equal(unit, dimensions[k].unit)) return dimensions[k].example;
  }
  return "";
}

/* ---- single units ---------------------------------------------------------------------------- */

static ut_system *table(void)
{
  static ut_system *system; /* for the life of the program */
  if (!system) {
    ut_set_error_message_handler(ut_ignore);
    system = ut_read_xml(NULL);
  }
  return system;
}

/* What a walk over a UDUNITS unit collects. */
typedef struct {
  double scale;
  sdr_unit dimension;
  int unfit; /* an offset (degC), a logarithm, or amperes, moles, candelas */
} walk;

static void count_base(walk *w, const ut_unit *basic, int power)
{
  const char *symbol = ut_get_symbol(basic, UT_ASCII);
  const signed char exponent = (signed char)power;
  if (ut_is_dimensionless(basic)) return;
  if (symbol && strcmp(symbol, "m") == 0) {
    w->dimension.m = exponent;
  } else if (symbol && strcmp(symbol, "kg") == 0) {
    w->dimension.kg = exponent;
  } else if (symbol && strcmp(symbol, "s") == 0) {
    w->dimension.s = exponent;
  } else if (symbol && strcmp(symbol, "K") == 0) {
    w->dimension.K = exponent;
  } else {
    w->unfit = 1;
  }
}

static ut_status visit_basic(const ut_unit *unit, void *context)
{
  count_base(context, unit, 1);
  return UT_SUCCESS;
}

static ut_status visit_product(const ut_unit *unit, int count, const ut_unit *const *basics,
                               const int *powers, void *context)
{
  (void)unit;
  for (int k = 0; k < count; ++k) count_base(context, basics[k], powers[k]);
  return UT_SUCCESS;
}

static const ut_visitor visitor;

static ut_status visit_galilean(const ut_unit *unit, double scale, const ut_unit *underlying,
                                double offset, void *context)
{
  (void)unit;
  walk *w = context;
  w->scale *= scale;
  if (offset < 0 || offset > 0) w->unfit = 1;
  return ut_accept_visitor(underlying, &visitor, context);
}

static ut_status visit_timestamp(const ut_unit *unit, const ut_unit *time, double origin,
                                 void *context)
{
  (void)unit, (void)time, (void)origin;
  ((walk *)context)->unfit = 1;
  return UT_SUCCESS;
}

static ut_status visit_logarithmic(const ut_unit *unit, double base, const ut_unit *reference,
                                   void *context)
{
  (void)unit, (void)base, (void)reference;
  ((walk *)context)->unfit = 1;
  return UT_SUCCESS;
}

static const ut_visitor visitor = {visit_basic, visit_product, visit_galilean, visit_timestamp,
                                   visit_logarithmic};

/* UDUNITS knows short names that are only ever typing errors in mechanics: pa is a pico-are, u an
   atomic mass, t a tonne (and our time), a an are. */
static int is_trap(const char *name)
{
  const size_t length = strlen(name);
  if (strcmp(name, "u") == 0 || strcmp(name, "a") == 0 || strcmp(name, "t") == 0) return 1;
  return length >= 2 && strcmp(name + length - 2, "pa") == 0;
}

/* *known = 0 if there is no such unit. */
static sdr_status look_up(const char *name, int *known, walk *w)
{
  *w = (walk){.scale = 1};
  *known = 1;
  if (strcmp(name, "%") == 0 || strcmp(name, "percent") == 0) {
    w->scale = 0.01;
    return SDR_OK;
  }
  if (strcmp(name, "deg") == 0 || strcmp(name, "degree") == 0 || strcmp(name, "degrees") == 0) {
    w->scale = 0.017453292519943295;
    return SDR_OK;
  }
  ut_system *system = table();
  if (!system) {
    return sdr_fail(SDR_IO_ERROR, "the table of units of UDUNITS-2 cannot be read; install "
                                  "libudunits2-data or set UDUNITS2_XML_PATH");
  }
  ut_unit *unit = is_trap(name) ? NULL : ut_parse(system, name, UT_ASCII);
  *known = unit != NULL;
  if (unit) ut_accept_visitor(unit, &visitor, w);
  ut_free(unit);
  return SDR_OK;
}

/* Copy a name of letters, at most `length` bytes; 0 if it is too long. The micro sign becomes u,
   the degree sign deg. */
static int copy_name(const char *text, size_t length, char name[NAME_MAX_BYTES])
{
  size_t used = 0;
  for (size_t k = 0; k < length; ++k) {
    const unsigned char c = (unsigned char)text[k];
    if (used + 4 > NAME_MAX_BYTES) return 0;
    if (c == 0xC2 && (unsigned char)text[k + 1] == 0xB5) {
      name[used++] = 'u';
      ++k;
    } else if (c == 0xC2 && (unsigned char)text[k + 1] == 0xB0) {
      memcpy(name + used, "deg", 3);
      used += 3;
      ++k;
    } else {
      name[used++] = (char)c;
    }
  }
  name[used] = '\0';
  return used > 0;
}

int sdr_units_known(const char *name, size_t length)
{
  char copy[NAME_MAX_BYTES];
  int known = 0;
  walk w;
  return copy_name(name, length, copy) && look_up(copy, &known, &w) == SDR_OK && known;
}

const char *sdr_units_suggest(const char *name, size_t length)
{
  static const char *const common[] = {"m",  "mm", "um", "cm",  "km",  "s",   "ms",  "us", "ns",
                                       "kg", "g",  "Pa", "kPa", "MPa", "GPa", "N",   "kN", "MN",
                                       "J",  "kJ", "mJ", "Hz",  "kHz", "K",   "deg", "rad"};
  static _Thread_local char text[64];
  for (size_t k = 0; k < sizeof common / sizeof *common; ++k) {
    if (strlen(common[k]) == length && strncasecmp(common[k], name, length) == 0) {
      snprintf(text, sizeof text, "; did you mean '%s'?", common[k]);
      return text;
    }
  }
  return "";
}

/* ---- products -------------------------------------------------------------------------------- */

static int is_letter(const char *c)
{
  const unsigned char first = (unsigned char)c[0], second = (unsigned char)c[first != 0];
  return isalpha(first) || (first == 0xC2 && (second == 0xB5 || second == 0xB0));
}

/* Length of the name at `text`; 0 if none stands there that could be a unit: a variable, a function
   call or a word with digits is none. */
static size_t name_length(const char *text)
{
  static const char *const variables[] = {"x", "y", "z", "t", "r", "theta", "pi"};
  size_t length = 0;
  if (text[0] == '%') return 1;
  while (is_letter(text + length)) length += isalpha((unsigned char)text[length]) ? 1 : 2;
  if (isdigit((unsigned char)text[length]) || text[length] == '_') return 0;
  for (size_t k = 0; k < sizeof variables / sizeof *variables; ++k) {
    if (strlen(variables[k]) == length && strncmp(text, variables[k], length) == 0) return 0;
  }
  return text[length + strspn(text + length, " ")] == '(' ? 0 : length;
}

/* "m^1/2" looks like a root and is half a metre; nobody who wants that writes it so. */
static sdr_status refuse_fraction(const char *exponent)
{
  int length = 1; /* of "1/2" */
  while (isdigit((unsigned char)exponent[length])) ++length;
  for (++length; isdigit((unsigned char)exponent[length]);) ++length;
  return sdr_fail(SDR_BAD_INPUT,
                  "'^%.*s' after a unit: units have whole exponents only, so there are no roots of "
                  "them; to divide, put the value in brackets, like (1 m^2)/2. A toughness is an "
                  "energy per area, like 100 J/m^2: from a stress intensity K it is K^2/E",
                  length, exponent);
}

static sdr_status scan_exponent(const char *text, size_t *used, int *exponent)
{
  *exponent = 1;
  if (text[0] != '^') return SDR_OK;
  char *end;
  const long value = strtol(text + 1, &end, 10);
  if (!isdigit((unsigned char)text[1]) &&
      !((text[1] == '-' || text[1] == '+') && isdigit((unsigned char)text[2]))) {
    return sdr_fail(SDR_BAD_INPUT, "the exponent of a unit must be a whole number, like m^2");
  }
  if (*end == '.' || value < -EXPONENT_MAX || value > EXPONENT_MAX) {
    return sdr_fail(SDR_BAD_INPUT,
                    "the exponent of a unit must be a whole number from -12 to 12, like m^2");
  }
  if (*end == '/' && isdigit((unsigned char)end[1])) return refuse_fraction(text + 1);
  *used += (size_t)(end - text);
  *exponent = (int)value;
  return SDR_OK;
}

static sdr_status multiply(sdr_measure *measure, const walk *w, int exponent)
{
  const double inverse = 1.0 / w->scale, whole = rint(inverse);
  const int divides = w->scale < 1 && fabs(inverse - whole) < 1e-9 * whole;
  for (int k = 0; k < abs(exponent); ++k) {
    double *by = (exponent > 0) == divides ? &measure->divide : &measure->multiply;
    *by *= divides ? whole : w->scale;
  }
  const int sums[] = {measure->dimension.m + exponent * w->dimension.m,
                      measure->dimension.kg + exponent * w->dimension.kg,
                      measure->dimension.s + exponent * w->dimension.s,
                      measure->dimension.K + exponent * w->dimension.K};
  for (int k = 0; k < 4; ++k) {
    if (abs(sums[k]) > 100) return sdr_fail(SDR_BAD_INPUT, "a unit with exponents above 100");
  }
  measure->dimension = (sdr_unit){(signed char)sums[0], (signed char)sums[1], (signed char)sums[2],
                                  (signed char)sums[3]};
  return SDR_OK;
}

/* One unit with its exponent at `text`; *used = 0 if none stands there. */
static sdr_status scan_factor(const char *text, int sign, size_t *used, sdr_measure *measure)
{
  char name[NAME_MAX_BYTES];
  const size_t length = name_length(text);
  int known = 0, exponent;
  walk w;
  *used = 0;
  if (length == 0 || !copy_name(text, length, name)) return SDR_OK;
  SDR_TRY(look_up(name, &known, &w));
  if (!known) return SDR_OK;
  if (w.unfit) {
    return sdr_fail(SDR_BAD_INPUT, "the unit '%s' is none of mechanics (products of m, kg, s, K)",
                    name);
  }
  *used = length;
  SDR_TRY(scan_exponent(text + length, used, &exponent));
  return multiply(measure, &w, sign * exponent);
}

/* The sign and start of the next factor after a first one (or of a leading "/"); 0: no more. */
static int joint(const char *text, int is_first, size_t *start)
{
  const size_t blanks = strspn(text, " ");
  const char at = text[blanks];
  *start = blanks;
  if (at == '/' || (!is_first && (at == '*' || at == '.'))) {
    *start = blanks + 1 + strspn(text + blanks + 1, " ");
    return at == '/' ? -1 : 1;
  }
  return is_first || blanks > 0 || at == '%' ? 1 : 0;
}

sdr_status sdr_units_scan(const char *text, size_t *used, sdr_measure *measure)
{
  sdr_measure product = {1, 1, {0, 0, 0, 0}};
  size_t end = 0;
  for (;;) {
    size_t start, length;
    const int sign = joint(text + end, end == 0, &start);
    if (sign == 0) break;
    SDR_TRY(scan_factor(text + end + start, sign, &length, &product));
    if (length == 0) break;
    end += start + length;
  }
  *used = end;
  *measure = product;
  return SDR_OK;
}
