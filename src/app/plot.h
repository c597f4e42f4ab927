/* `sunder plot`: pictures of a run. */
#ifndef SDR_APP_PLOT_H
#define SDR_APP_PLOT_H

#include "base/status.h"

#include <stdio.h>

typedef struct {
  const char *directory; /* of a run; it may still be going on */
  const char *field;     /* FIELD or FIELD.COMPONENT; NULL: damage, or what there is */
  double time;           /* s: the nearest frame is shown; NAN: the last */
  double deformed;       /* points are moved by this times their displacement; 0: not at all */
  int slice_axis;        /* of a solid body, beside the view: sdr_view_how (plot_view.h) */
  double slice_at;       /* m */
  int movie;             /* 1: all frames (plot_movie.h); `png` is the movie's file then */
  const char
      *png; /* NULL: DIRECTORY/FIELD.png (FIELD_at_TIME.png of a given time), ledger.png and, with
               probes or supports, reactions.png; else the field's picture alone goes here */
} sdr_plot_options;

/* Draw, and print one line on `out` for each file written.
   SDR_BAD_INPUT: not a run's directory, no snapshots, an unknown field (the message lists those
   present), a time outside of the snapshots. SDR_IO_ERROR: the directory is missing, a file cannot
   be read or written, or gnuplot is missing or fails. Without snapshots the ledger is still drawn
   before the field's failure is returned. */
sdr_status sdr_plot(const sdr_plot_options *options, FILE *out);

#endif
