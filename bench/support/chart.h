/* Grouped bars: the picture of a table of times or errors. */
#ifndef SDR_BENCH_CHART_H
#define SDR_BENCH_CHART_H

#include "app/plot_gnuplot.h"

typedef struct {
  const char *title, *colour;
} bench_bar;

typedef struct {
  const char *title, *unit;
  int groups, bars;
  const char *const *group;
  const bench_bar *bar; /* of every group */
  const double *value;  /* groups rows of `bars`; NAN: no bar */
  const char *format;   /* of the figure over a bar, for printf */
  int columns;          /* of the legend */
  double limit;         /* drawn as a line, 0: none */
  int logarithmic;
} bench_chart;

/* Draw it with its axes in `area` (px from the lower left corner). */
void bench_draw_bars(sdr_picture *picture, const bench_chart *chart, sdr_area area);

#endif
