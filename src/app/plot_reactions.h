/* reactions.png: what history.csv has of probes and supports. */
#ifndef SDR_APP_PLOT_REACTIONS_H
#define SDR_APP_PLOT_REACTIONS_H

#include "app/rundata.h"

#include <stdio.h>

/* Draw DIRECTORY/reactions.png and print a line on `out`: one panel for each probe and field and
   for each support over time, and the force over the displacement where a support prescribes one.
   Nothing if history.csv has no such columns, or less than two rows. */
sdr_status sdr_plot_reactions(const sdr_rundata *run, FILE *out);

#endif
