/* Any text as a formula of a length: it is refused with a column, or gives finite numbers or a
   message. */
#include "fuzz.h"

#include "scene/expression.h"

#include <math.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
  static const sdr_unit length = {.m = 1};
  static const double places[3][3] = {{0.0}, {0.1, -0.2, 0.3}, {1e300, -1e-300, 7.0}};
  char *text = malloc(size + 1);
  sdr_expression *formula = NULL;
  int relative = 0;
  memcpy(text, data, size);
  text[size] = '\0';
  sdr_fail(SDR_OK, "%s", "");
  const sdr_status status = sdr_expression_create(text, length, "spacing", &relative, &formula);
  PROMISE(status == SDR_OK || (status == SDR_BAD_INPUT && sdr_error_message()[0]));
  PROMISE((status == SDR_OK) == (formula != NULL));
  for (int k = 0; formula && k < 3; ++k) {
    double value;
    const sdr_status valued = sdr_expression_value(formula, places[k], 1e-6 * k, &value);
    PROMISE(valued == SDR_OK ? isfinite(value) : valued == SDR_BAD_INPUT);
  }
  if (formula) PROMISE(strcmp(sdr_expression_text(formula), text) == 0);
  sdr_expression_destroy(&formula);
  free(text);
  return 0;
}
