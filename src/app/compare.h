/* `sunder compare`: two runs side by side. */
#ifndef SDR_APP_COMPARE_H
#define SDR_APP_COMPARE_H

#include "base/status.h"

#include <stdio.h>

/* Print a table of both runs on `out` (what they were, what came out, the difference and the
   ratio; where they have the same points also how far their fields differ at the last common time)
   and draw both damage fields on one colour scale with both ledgers on the same axes below them.
   png: NULL for DIR_A/compare.png. What one run lacks is said on `out` and left out.
   Fails as sdr_plot does; runs with nothing in common to draw get the table only. */
sdr_status sdr_compare(const char *dir_a, const char *dir_b, const char *png, FILE *out);

#endif
