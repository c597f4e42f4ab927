/* What a run measures: the figures that every run has, and the scene's own measures. */
#ifndef SDR_APP_FIGURES_H
#define SDR_APP_FIGURES_H

#include "output/observer.h"
#include "output/summary.h"

#include <stdio.h>

/* Of a ring, where the scene asks. */
typedef struct {
  int known;
  int32_t cracks, sectors;
} sdr_ring_counts;

/* All that the scene's figures may name, with the values of a run that is over; summary NULL:
   names only. A measure that has the name of a figure of every run is SDR_BAD_INPUT. Owner: the
   caller (sdr_free). */
sdr_status sdr_figures_measured(const sdr_scene *scene, const sdr_summary *summary,
                                const sdr_ring_counts *ring, const sdr_observer *measures,
                                sdr_measured **out, int *count);

/* SDR_BAD_INPUT if the scene lists a figure that nothing measures, or a measure that cannot be. */
sdr_status sdr_figures_known(const sdr_scene *scene);

/* The scene's figures and measures, one a line, with range and the paper's value. */
void sdr_figures_print(const sdr_summary *summary, FILE *out);

#endif
