/* One picture of a field: a frame of a run on a scale of its own, or on one for many frames. */
#ifndef SDR_APP_PLOT_FRAME_H
#define SDR_APP_PLOT_FRAME_H

#include "app/plot_field.h"
#include "app/plot_gnuplot.h"
#include "app/plot_view.h"

/* What several frames share. Start with all zero but `film`. */
typedef struct {
  int frames; /* measured so far */
  int film;   /* 1: smaller pictures */
  double line[2];
  sdr_extent body, slice;
  sdr_plot_field field; /* without values */
} sdr_frame_scale;

/* The title and a second line at the top of a picture. */
void sdr_frame_heading(sdr_picture *picture, const sdr_rundata *run, const char *second);

/* Room around the axes, in letters' sizes. */
extern const double sdr_frame_left, sdr_frame_right, sdr_frame_below, sdr_frame_above;

/* Widen the scale so that the frame fits. Brings the run to the frame. */
sdr_status sdr_frame_measure(sdr_rundata *run, int frame, const char *field,
                             const sdr_view_how *how, sdr_frame_scale *scale);

/* Draw the frame. Brings the run to it. */
sdr_status sdr_frame_draw(sdr_rundata *run, int frame, const char *field, const sdr_view_how *how,
                          const sdr_frame_scale *scale, const char *png);

#endif
