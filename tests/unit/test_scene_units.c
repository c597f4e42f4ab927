/* scene: units of measurement and formulas. */
#include "scene/expression.h"
#include "scene/units.h"
#include "support/cmocka_all.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const sdr_unit PLAIN = {0, 0, 0, 0}, LENGTH = {1, 0, 0, 0}, TIME = {0, 0, 1, 0},
                      PRESSURE = {-1, 1, -2, 0}, VELOCITY = {1, 0, -1, 0};

/* Compile and evaluate at a place and time; the test fails if either does. */
static double value_at(const char *text, sdr_unit unit, const double x[3], double t)
{
  sdr_expression *e = NULL;
  double value = NAN;
  const sdr_status status = sdr_expression_create(text, unit, NULL, NULL, &e);
  if (status != SDR_OK) fail_msg("%s: %s", text, sdr_error_message());
  assert_int_equal(sdr_expression_value(e, x, t, &value), SDR_OK);
  sdr_expression_destroy(&e);
  assert_null(e);
  return value;
}

static double value_of(const char *text, sdr_unit unit)
{
  return value_at(text, unit, (double[3]){0, 0, 0}, 0);
}

#define assert_near(found, expected, tolerance)                                                    \
  assert_true(fabs((found) - (expected)) <= (tolerance))

#define assert_value(text, unit, expected)                                                         \
  assert_true(fabs(value_of(text, unit) - (expected)) <= 2 * DBL_EPSILON * fabs(expected))

static void assert_refused(const char *text, sdr_unit unit, const char *message)
{
  sdr_expression *e = NULL;
  assert_int_equal(sdr_expression_create(text, unit, NULL, NULL, &e), SDR_BAD_INPUT);
  assert_null(e);
  assert_string_equal(sdr_error_message(), message);
}

static void units_become_si(void **state)
{
  (void)state;
  assert_value("81 mm", LENGTH, 0.081);
  assert_value("0.1us", TIME, 1e-7);
  assert_value("210 GPa", PRESSURE, 210e9);
  assert_value("2e4 J/m^2", ((sdr_unit){0, 1, -2, 0}), 2e4);
  assert_value("20 N/mm", ((sdr_unit){0, 1, -2, 0}), 2e4);
  assert_value("7.85 g/cm^3", ((sdr_unit){-3, 1, 0, 0}), 7850.0);
  assert_value("1 N.m", ((sdr_unit){2, 1, -2, 0}), 1.0);
  assert_value("3 kg m s^-2", ((sdr_unit){1, 1, -2, 0}), 3.0);
  assert_value("72 km/h", VELOCITY, 20.0);
  assert_value("5 %", PLAIN, 0.05);
  assert_value("180 deg", PLAIN, 3.14159265358979323846);
  assert_value("2 rad", PLAIN, 2.0);
  assert_value("300 K", ((sdr_unit){0, 0, 0, 1}), 300.0);
  assert_value("2 /s", ((sdr_unit){0, 0, -1, 0}), 2.0);
  assert_value("5 \xC2\xB5s", TIME, 5e-6);
  assert_value("-5", LENGTH, -5.0);
  assert_value("(5 m^2)/2", ((sdr_unit){2, 0, 0, 0}), 2.5); /* as the manual says */
  assert_value("1/2 m", ((sdr_unit){-1, 0, 0, 0}), 0.5);
}

/* A decimal length in mm is the double nearest to it in m, so lattices meet their shapes. */
static void millimetres_are_rounded_once(void **state)
{
  (void)state;
  assert_true(value_of("81 mm", LENGTH) == 0.081);
  assert_true(value_of("149 mm", LENGTH) == 0.149);
  assert_true(value_of("0.5 mm", LENGTH) == 0.0005);
  assert_true(value_of("100 us", TIME) == 0.0001);
}

static void what_udunits_would_misread_is_refused(void **state)
{
  (void)state;
  assert_refused("4 m^0.5", LENGTH,
                 "1: the exponent of a unit must be a whole number from -12 to 12, like m^2");
#define FRACTION                                                                                   \
  "' after a unit: units have whole exponents only, so there are no roots of them; to divide, "    \
  "put "                                                                                           \
  "the value in brackets, like (1 m^2)/2. A toughness is an energy per area, like 100 J/m^2: "     \
  "from "                                                                                          \
  "a stress intensity K it is K^2/E"
  assert_refused("1 MPa*m^1/2", PRESSURE, "1: '^1/2" FRACTION);
  assert_refused("1 kg m^-12/25", PRESSURE, "1: '^-12/25" FRACTION);
  assert_refused("4 m^x", LENGTH, "1: the exponent of a unit must be a whole number, like m^2");
  assert_refused("4 mpa", PRESSURE, "3: unknown unit 'mpa'; did you mean 'MPa'?");
  assert_refused("4 pa", PRESSURE, "3: unknown unit 'pa'; did you mean 'Pa'?");
  assert_refused("4 m2", LENGTH, "3: unknown unit 'm2'; write a power as m^2");
  assert_refused("20 degC", (sdr_unit){0, 0, 0, 1},
                 "1: the unit 'degC' is none of mechanics (products of m, kg, s, K)");
  assert_refused("4 V", LENGTH, "1: the unit 'V' is none of mechanics (products of m, kg, s, K)");
}

static void a_wrong_unit_says_what_it_is_and_what_is_wanted(void **state)
{
  (void)state;
  assert_refused("5 mm", PRESSURE, "1: '5 mm' is a length, wanted a pressure, like 1 MPa");
  assert_refused("0 s", LENGTH, "1: '0 s' is a time, wanted a length, like 1 mm");
  assert_refused("5 %", LENGTH, "1: '5 %' is a plain number, wanted a length, like 1 mm");
  assert_refused("1 m^2 kg", PLAIN, "1: '1 m^2 kg' is in m^2 kg, wanted a plain number, like 2");
}

static void units_work_inside_formulas(void **state)
{
  (void)state;
  const double x[3] = {0.03, 0.04, 0.5};
  assert_near(value_at("400 MPa * exp(-t/(100 us))", PRESSURE, x, 5e-5), 400e6 * exp(-0.5), 1e-6);
  assert_near(value_at("x/(1 mm) + 1", PLAIN, x, 0), 31, 1e-12);
  assert_near(value_at("sqrt(x^2 + y^2)", LENGTH, x, 0), 0.05, 1e-15);
  assert_near(value_at("r", LENGTH, x, 0), 0.05, 1e-15);
  assert_near(value_at("theta", PLAIN, x, 0), atan2(0.04, 0.03), 1e-15);
  assert_near(value_at("2 m/s * sin(2*pi*t/(4 s))", VELOCITY, x, 1), 2, 1e-12);
  assert_near(value_at("t < 1 us ? 1 MPa : 0", PRESSURE, x, 5e-7), 1e6, 1e-6);
  assert_near(value_at("max(x - 10 mm, 0)", LENGTH, x, 0), 0.02, 1e-15);
  assert_near(value_at("1 MPa*(x > 1 mm && y > 1 mm)", PRESSURE, x, 0), 1e6, 1e-6);
  assert_near(value_at("-2^2", PLAIN, x, 0), -4, 0);
  assert_near(value_at("sqrt(4 m * x)", LENGTH, x, 0), sqrt(0.12), 1e-15);
}

static void a_formula_without_units_is_si_throughout(void **state)
{
  (void)state;
  assert_near(value_at("400e6*exp(-t/100e-6)", PRESSURE, (double[3]){0, 0, 0}, 1e-4),
              400e6 * exp(-1), 1e-6);
}

static void terms_that_do_not_fit_together_are_refused(void **state)
{
  (void)state;
  const char *const mixed = "1: '%s' adds or compares different kinds of quantities (beside units, "
                            "a bare number in a formula is a plain number), wanted a pressure, "
                            "like 1 MPa";
  const char *const texts[] = {"400 MPa * exp(-t/100)", "1 MPa + x", "1 MPa + 1", "1 MPa * (1 + t)",
                               "t > 1e-4 ? 1 MPa : 1 kPa + t"};
  for (size_t k = 0; k < sizeof texts / sizeof *texts; ++k) {
    char message[400];
    snprintf(message, sizeof message, mixed, texts[k]);
    assert_refused(texts[k], PRESSURE, message);
  }
  assert_refused("400 MPa * t", PRESSURE,
                 "1: '400 MPa * t' is in m^-1 kg s^-1, wanted a pressure, like 1 MPa");
}

static void bad_formulas_say_column_and_reason(void **state)
{
  (void)state;
  assert_refused("", PLAIN, "1: an empty formula; give a value");
  assert_refused("x=5", LENGTH, "2: '=' assigns, which is not allowed; compare with ==");
  assert_refused("1, 2", PLAIN, "1: a formula gives one number, not several");
  assert_refused("(1 + 2", PLAIN, "6: a closing parenthesis is missing");
  assert_refused("1 + 2)", PLAIN, "6: unexpected parenthesis");
  assert_refused("1 + ", PLAIN, "3: the formula ends too early");
  assert_refused("2 x", LENGTH, "3: 'x' follows a number without an operator; write 2*x");
  assert_refused("2 3", PLAIN, "3: two numbers without an operator between them");
  assert_refused("2 # 3", PLAIN, "3: unexpected '#' in a formula");
  assert_refused("_pi", PLAIN,
                 "1: unknown name '_pi'; known: x y z t r theta pi and the functions sin cos tan "
                 "asin acos atan atan2 sinh cosh tanh asinh acosh atanh log2 log10 ln exp sqrt "
                 "sign rint abs min max");
  assert_refused("3 * mm", LENGTH, "5: the unit 'mm' must follow a number, like 1 mm");
  assert_refused("log(2)", PLAIN, "1: 'log' could mean two things; write ln or log10");
  assert_refused("pow(2, 3)", PLAIN, "1: unknown function 'pow'; write a^b");
  assert_refused("sin(1, 2)", PLAIN, "9: the function has too many arguments");
  assert_refused("atan2(1)", PLAIN, "8: the function has too few arguments");
  assert_refused("1/0", PLAIN, "1: '1/0' is not a finite number");
  assert_refused("sqrt(-1)", PLAIN, "1: 'sqrt(-1)' is not a finite number");
  assert_refused(".nan", PLAIN, "1: '.nan' is not a finite number");
  assert_refused("1e999", PLAIN, "1: the number '1e999' is too large or too long");
  assert_refused("0x10", PLAIN, "2: unknown unit 'x10'");
  assert_refused("1 \xE2\x82\xAC", PLAIN, "3: a letter or sign that no formula has");
}

/* Below 2.3e-308 numbers lose digits, and do not scale as their unit any more. */
static void numbers_too_small_to_keep_their_digits_are_refused(void **state)
{
  (void)state;
  const double x[3] = {0.5, 0, 0};
  assert_refused("2*1e-320", PLAIN,
                 "3: '1e-320' is below 2.3e-308 in SI units, too small; write 0");
  assert_refused("1e-400", PLAIN, "1: '1e-400' is below 2.3e-308 in SI units, too small; write 0");
  assert_refused("-1e-305 um", LENGTH,
                 "2: '1e-305 um' is below 2.3e-308 in SI units, too small; write 0");
  assert_refused("1 MPa * 1e-300 * 1e-15", PRESSURE,
                 "1: '1 MPa * 1e-300 * 1e-15' gives 1e-309, below 2.3e-308, which is too small; "
                 "write 0");
  assert_near(value_at("0.00e-400 MPa", PRESSURE, x, 0), 0, 0);
  assert_near(value_at("1 MPa * exp(-1400*x/(1 m))", PRESSURE, x, 0), 1e6 * exp(-700), 1e-310);
  assert_refused("1 m * exp(-1400*x/(1 m))", PRESSURE,
                 "1: '1 m * exp(-1400*x/(1 m))' is a length, wanted a pressure, like 1 MPa");
}

static void a_value_that_is_not_finite_names_place_and_time(void **state)
{
  (void)state;
  sdr_expression *e = NULL;
  double value = 7;
  assert_int_equal(sdr_expression_create("sqrt(x)", LENGTH, NULL, NULL, &e), SDR_OK);
  assert_int_equal(sdr_expression_value(e, (double[3]){4, 0, 0}, 0, &value), SDR_OK);
  assert_true(value == 2);
  assert_int_equal(sdr_expression_value(e, (double[3]){-1, 0.5, 0}, 3, &value), SDR_BAD_INPUT);
  assert_true(value == 2);
  assert_string_equal(sdr_error_message(), "the formula 'sqrt(x)' gives nan at (x, y, z) = "
                                           "(-1, 0.5, 0) m; it must be finite");
  sdr_expression_destroy(&e);
}

static void a_formula_knows_what_it_uses(void **state)
{
  (void)state;
  static const struct {
    const char *text;
    int uses;
  } cases[] = {{"2*pi", 0},
               {"x", SDR_USES_SPACE},
               {"theta", SDR_USES_SPACE},
               {"exp(-t)", SDR_USES_TIME},
               {"r*t", SDR_USES_SPACE | SDR_USES_TIME}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    sdr_expression *e = NULL;
    assert_int_equal(sdr_expression_create(cases[k].text, PLAIN, NULL, NULL, &e), SDR_OK);
    assert_int_equal(sdr_expression_uses(e), cases[k].uses);
    assert_string_equal(sdr_expression_text(e), cases[k].text);
    sdr_expression_destroy(&e);
  }
}

static void a_relative_unit_is_told_apart(void **state)
{
  (void)state;
  sdr_expression *e = NULL;
  double value = 0;
  int is_relative = -1;
  assert_int_equal(sdr_expression_create("3.015 spacing", LENGTH, "spacing", &is_relative, &e),
                   SDR_OK);
  assert_int_equal(is_relative, 1);
  assert_int_equal(sdr_expression_value(e, (double[3]){0, 0, 0}, 0, &value), SDR_OK);
  assert_true(value == 3.015);
  sdr_expression_destroy(&e);
  assert_int_equal(sdr_expression_create("3 mm", LENGTH, "spacing", &is_relative, &e), SDR_OK);
  assert_int_equal(is_relative, 0);
  sdr_expression_destroy(&e);
  assert_int_equal(sdr_expression_create("2 horizon", LENGTH, "spacing", &is_relative, &e),
                   SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "3: unknown unit 'horizon'");
}

static void any_unit_keeps_its_si_value(void **state)
{
  (void)state;
  assert_value("43.6 us", SDR_ANY_UNIT, 43.6e-6);
  assert_value("12", SDR_ANY_UNIT, 12.0);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(units_become_si),
      cmocka_unit_test(millimetres_are_rounded_once),
      cmocka_unit_test(what_udunits_would_misread_is_refused),
      cmocka_unit_test(a_wrong_unit_says_what_it_is_and_what_is_wanted),
      cmocka_unit_test(units_work_inside_formulas),
      cmocka_unit_test(a_formula_without_units_is_si_throughout),
      cmocka_unit_test(terms_that_do_not_fit_together_are_refused),
      cmocka_unit_test(bad_formulas_say_column_and_reason),
      cmocka_unit_test(numbers_too_small_to_keep_their_digits_are_refused),
      cmocka_unit_test(a_value_that_is_not_finite_names_place_and_time),
      cmocka_unit_test(a_formula_knows_what_it_uses),
      cmocka_unit_test(a_relative_unit_is_told_apart),
      cmocka_unit_test(any_unit_keeps_its_si_value),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
