/* SI prefixes for axes and tables. */
#ifndef SDR_APP_PLOT_UNITS_H
#define SDR_APP_PLOT_UNITS_H

#include <stddef.h>

typedef struct {
  double scale;       /* a value in SI times this is what is shown */
  const char *symbol; /* before the unit, UTF-8: "m", "µ", "" */
  const char *plain;  /* the same in ASCII */
  const char *power;  /* for a number without unit: "10⁻³", "" */
} sdr_prefix;

/* The prefix with which `largest` (its magnitude counts) lies in [1, 1000); none for 0, for what is
   not finite and beyond 1e-18 .. 1e18. */
sdr_prefix sdr_prefix_for(double largest);

/* "12.3 kJ" into `text` (ASCII), `digits` significant; "-" if the value is not finite; without unit
   ("") a plain %g. */
void sdr_quantity(double value, const char *unit, int digits, char *text, size_t room);

/* A time for a title: "43.6 µs"; in us below 10 ms. */
void sdr_time_text(double seconds, char *text, size_t room);

/* "name (kPa)", "name (10⁻³)" or "name" for an axis. */
void sdr_axis_label(const char *name, const char *unit, sdr_prefix prefix, char *text, size_t room);

#endif
