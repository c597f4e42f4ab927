/* gnuplot, run as a separate program, and the words it reads. */
#ifndef SDR_APP_PLOT_GNUPLOT_H
#define SDR_APP_PLOT_GNUPLOT_H

#include "base/status.h"

#include <stdio.h>

/* A part of the canvas, in pixels from its lower left corner. */
typedef struct {
  double left, bottom, width, height;
} sdr_area;

/* A picture in the making: gnuplot's commands and inline data, written to `script`. */
typedef struct {
  FILE *script;
  char *text; /* behind `script` */
  size_t length;
  int width, height; /* px */
  double font;       /* of the tics, size of its letters in px; titles are larger */
} sdr_picture;

/* Begin a picture of this size: white, several plots, UTF-8. SDR_RUN_FAILED if memory is short. */
sdr_status sdr_picture_begin(sdr_picture *picture, int width, int height, double font);

/* Run gnuplot on it and write `path` (PNG) beside under a temporary name, then rename. Clears the
   picture whatever happens. SDR_IO_ERROR: gnuplot is not installed (names the package), fails (with
   what it said), or the file cannot be written. */
sdr_status sdr_picture_end(sdr_picture *picture, const char *path);

/* Drop a picture without writing it; harmless on one that has ended. */
void sdr_picture_drop(sdr_picture *picture);

/* The next plot's axes cover exactly this area. */
void sdr_picture_place(sdr_picture *picture, sdr_area area);

/* `text` as a quoted string of gnuplot; control characters become blanks, and what is longer than
   `characters` ends in an ellipsis. */
void sdr_picture_quote(sdr_picture *picture, const char *text, int characters);

/* gnuplot's font size for letters of `size` times the picture's font. */
double sdr_picture_points(const sdr_picture *picture, double size);

/* Text on the canvas, shown with the next plot: at x, y (px; its middle line), aligned "left",
   "center" or "right", `size` times the font, at most `width` px wide. */
void sdr_picture_text(sdr_picture *picture, double x, double y, const char *align, double size,
                      double width, const char *text);

/* The same upwards, for an axis. */
void sdr_picture_upright(sdr_picture *picture, double x, double y, double size, double width,
                         const char *text);

/* Back to no tics, labels, grid or legend, ranges by the data, a thin border. */
void sdr_picture_clear_axes(sdr_picture *picture);

/* An image of width x height pixels over the whole area of the axes: rgba bytes row after row from
   the bottom; x[2] and y[2] are the axes' ranges. width, height >= 2. */
void sdr_picture_image(sdr_picture *picture, int width, int height, const double x[2],
                       const double y[2], const unsigned char *rgba);

#endif
