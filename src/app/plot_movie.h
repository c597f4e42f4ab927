/* `sunder plot --movie`: all frames of a field on one scale, and a movie of them if a program for
   that is installed. */
#ifndef SDR_APP_PLOT_MOVIE_H
#define SDR_APP_PLOT_MOVIE_H

#include "app/plot_view.h"

#include <stdio.h>

/* Draw every frame to DIRECTORY/FIELD_frames/0000.png ..., then the movie to `path` (.mp4 or .gif;
   NULL: DIRECTORY/FIELD.mp4 by ffmpeg, else .gif by ImageMagick's convert). Without such a program,
   or if it fails, the frames are kept and a line on `out` says so; that is no failure. */
sdr_status sdr_plot_movie(sdr_rundata *run, const char *field, const sdr_view_how *how,
                          const char *path, FILE *out);

#endif
