#include "geometry/text.h"

#include <math.h>
#include <stdio.h>

const char *sdr_length_text(double metres, char text[SDR_LENGTH_TEXT])
{
  static const struct {
    double least, unit;
    const char *name;
  } units[] = {{1.0, 1.0, "m"}, {1e-4, 1e-3, "mm"}, {1e-7, 1e-6, "um"}, {1e-15, 1e-9, "nm"}};
  const double size = fabs(metres) * (1.0 + 1e-9);
  for (int k = 0; k < (int)(sizeof units / sizeof units[0]); ++k) {
    if (size >= units[k].least && isfinite(size)) {
      snprintf(text, SDR_LENGTH_TEXT, "%.6g %s", metres / units[k].unit, units[k].name);
      return text;
    }
  }
  snprintf(text, SDR_LENGTH_TEXT, "%.6g m", metres);
  return text;
}

const char *sdr_place_text(const double *x, int components, char text[SDR_PLACE_TEXT])
{
  int used = 0;
  text[0] = '\0';
  for (int c = 0; c < components; ++c) {
    char length[SDR_LENGTH_TEXT];
    used += snprintf(text + used, (size_t)(SDR_PLACE_TEXT - used), "%s%c = %s", c ? ", " : "",
                     "xyz"[c], sdr_length_text(x[c], length));
  }
  return text;
}
