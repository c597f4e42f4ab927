#include "app/plot_units.h"

#include <math.h>
#include <stdio.h>

enum { LOWEST = -6, HIGHEST = 6 }; /* powers of 1000 */

static const char *const symbols[] = {"a", "f", "p", "n", "µ", "m", "",
                                      "k", "M", "G", "T", "P", "E"};
static const char *const plain[] = {"a", "f", "p", "n", "u", "m", "", "k", "M", "G", "T", "P", "E"};
static const char *const powers[] = {"10⁻¹⁸", "10⁻¹⁵", "10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "",
                                     "10³",   "10⁶",   "10⁹",   "10¹²", "10¹⁵", "10¹⁸"};

static sdr_prefix prefix_of(int thousands)
{
  const int k = thousands - LOWEST;
  return (sdr_prefix){pow(1000.0, -thousands), symbols[k], plain[k], powers[k]};
}

sdr_prefix sdr_prefix_for(double largest)
{
  const double size = fabs(largest);
  if (!(size > 0.0) || !isfinite(size)) return prefix_of(0);
  /* a hair above, so that 0.001 is 1 m and not 1000 u */
  const double thousands = floor(log10(size * (1.0 + 1e-9)) / 3.0);
  if (thousands < LOWEST || thousands > HIGHEST) return prefix_of(0);
  return prefix_of((int)thousands);
}

void sdr_quantity(double value, const char *unit, int digits, char *text, size_t room)
{
  if (!isfinite(value)) {
    snprintf(text, room, "-");
  } else if (!*unit) {
    snprintf(text, room, "%.*g", digits, value);
  } else {
    const sdr_prefix prefix = sdr_prefix_for(value);
    snprintf(text, room, "%.*g %s%s", digits, value * prefix.scale, prefix.plain, unit);
  }
}

void sdr_time_text(double seconds, char *text, size_t room)
{
  const sdr_prefix prefix = fabs(seconds) < 1e-2 ? prefix_of(-2) : sdr_prefix_for(seconds);
  snprintf(text, room, "%.5g %ss", seconds * prefix.scale, prefix.symbol);
}

void sdr_axis_label(const char *name, const char *unit, sdr_prefix prefix, char *text, size_t room)
{
  if (*unit)
    snprintf(text, room, "%s (%s%s)", name, prefix.symbol, unit);
  else if (*prefix.power)
    snprintf(text, room, "%s (%s)", name, prefix.power);
  else
    snprintf(text, room, "%s", name);
}
