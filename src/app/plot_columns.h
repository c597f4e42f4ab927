/* The columns of history.csv that the scene named, probes and reactions, sorted into panels. */
#ifndef SDR_APP_PLOT_COLUMNS_H
#define SDR_APP_PLOT_COLUMNS_H

#include "app/rundata.h"

enum { SDR_PANEL_CURVES = 6, SDR_PANEL_NAME = 128 };

/* One panel: the components of a field at a probe, or of a support's reaction. */
typedef struct {
  char name[SDR_PANEL_NAME]; /* of the probe or support */
  const char *field, *unit;  /* "" : none */
  int count;
  const double *value[SDR_PANEL_CURVES]; /* columns, SI */
  char part[SDR_PANEL_CURVES][4];        /* "x", "xy", "" */
  /* How far the support has moved, m: one value a row, NAN where it holds nothing. NULL: the panel
     is over time. */
  double *moved;
} sdr_column_panel;

typedef struct {
  int count;
  sdr_column_panel *panel;
} sdr_column_panels;

/* In the order of the columns. Each reaction whose component the support moves by the same amount
   everywhere, by used.yaml, has a panel of its own over that displacement behind the one over
   time. A missing or strange used.yaml means that there are none of these. Borrows the run. */
sdr_status sdr_column_panels_find(const sdr_rundata *run, sdr_column_panels *out);
void sdr_column_panels_clear(sdr_column_panels *panels);

#endif
