/* The panels of a picture: a field over the body, its colour bar, the energies over time. */
#ifndef SDR_APP_PLOT_PANEL_H
#define SDR_APP_PLOT_PANEL_H

#include "app/plot_field.h"
#include "app/plot_gnuplot.h"
#include "app/raster.h"

/* The points of a run as a cloud (borrowed). */
sdr_cloud sdr_panel_cloud(const sdr_rundata *run);

/* The scene's title, else its name, else the directory; belongs to the run. */
const char *sdr_panel_title(const sdr_rundata *run);

/* "variational damage, t = 85 µs", without the time if `frame` is negative. */
void sdr_panel_subtitle(const sdr_rundata *run, int frame, char *text, size_t room);

/* A plane or solid body: the raster over the area, which has its window's size, so that a pixel of
   it is one of the picture. */
sdr_status sdr_panel_body(sdr_picture *picture, sdr_area area, const sdr_raster *raster,
                          const sdr_plot_field *field, int dimension);

/* A slice of a solid body, whose axes have these names. */
sdr_status sdr_panel_slice(sdr_picture *picture, sdr_area area, const sdr_raster *raster,
                           const sdr_plot_field *field, const char *const names[2]);

/* A body in one dimension: the field as a line over x; x[2] is the range (m). */
sdr_status sdr_panel_line(sdr_picture *picture, sdr_area area, const sdr_rundata *run,
                          const sdr_plot_field *field, const double x[2]);

/* The colour scale with its name, which is written to the right of the area. */
void sdr_panel_colours(sdr_picture *picture, sdr_area area, const sdr_plot_field *field);

#endif
