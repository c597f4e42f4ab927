/* The energies of a run over time, with the imbalance below. */
#ifndef SDR_APP_PLOT_LEDGER_H
#define SDR_APP_PLOT_LEDGER_H

#include "app/plot_gnuplot.h"
#include "app/rundata.h"

/* Ranges of the axes (SI) and the largest energy, over which the imbalance is also given. */
typedef struct {
  double time[2], energy[2], imbalance[2], largest;
} sdr_ledger_range;

/* A run without a row of history, or without a column `time`, is SDR_BAD_INPUT. */
sdr_status sdr_ledger_range_of(const sdr_rundata *run, sdr_ledger_range *out);

/* Both runs on the same axes. */
sdr_ledger_range sdr_ledger_range_merge(const sdr_ledger_range *a, const sdr_ledger_range *b);

/* Draw within the area (the axes' own; labels and the legend lie around it). */
void sdr_panel_ledger(sdr_picture *picture, sdr_area area, const sdr_rundata *run,
                      const sdr_ledger_range *range);

#endif
