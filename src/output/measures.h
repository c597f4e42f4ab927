/* The scene's measures: numbers from fields of points, or from the ledger, at one instant or over a
   time, some of them against exact values. Nothing is looked at but what and when is asked for. */
#ifndef SDR_OUTPUT_MEASURES_H
#define SDR_OUTPUT_MEASURES_H

#include "output/observer.h"

/* The points of each measure are chosen here. An instant is the step nearest to its time. A mean
   over a place is by volume, an l2_error is sqrt(sum V (f - exact)^2 / sum V exact^2) with V the
   points' volume; over a time each instant counts the same. `ledger` (borrowed) must stand before
   this observer among the run's.
   SDR_BAD_INPUT with the measure's origin: a place without points, a point outside the body, an
   instant beyond `steps`, a table that does not reach over the points or times. Borrows scene and
   points. Owner: the caller. */
sdr_status sdr_measures_create(const sdr_scene *scene, const sdr_points *points,
                               sdr_observer *ledger, int64_t steps, sdr_observer **out);

/* What scene->output.measure[k] has come to, SI; NAN: its instant has not come, or the exact values
   of an l2_error are all 0. */
double sdr_measures_value(const sdr_observer *measures, int k);

#endif
