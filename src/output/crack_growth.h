/* How a crack grew: which damaged points joined the cluster that is connected to its notch, when,
   and how far along the crack. */
#ifndef SDR_OUTPUT_CRACK_GROWTH_H
#define SDR_OUTPUT_CRACK_GROWTH_H

#include "geometry/point_grid.h"

/* Points that were damaged on the way (those of the notch are none of them). */
typedef struct {
  const sdr_points *points; /* the damaged ones only; x, spacing and horizon count */
  const sdr_point_grid *grid;
  const double *arrival; /* s, of each: when its damage passed the threshold */
} sdr_crack_sites;

/* Entries in the order in which they joined. */
typedef struct {
  int32_t count;
  int32_t *site;    /* index of the damaged point */
  int32_t *before;  /* the nearest entry of those before it in its horizon; -1: the notch */
  double *time;     /* s, rising */
  double *distance; /* m, from the notch's tip along the crack, when it joined */
} sdr_crack_growth;

/* Grow a crack from the notch's tip start[3]. A point joins when it is damaged and a point of the
   crack (at first: the tip, within two horizons) lies in its horizon. One that had been damaged
   for longer than `lag` (s) by then belongs to something else, such as a spall that the crack runs
   into: it does not join, and nothing joins through it. Owner: the caller, who clears. */
sdr_status sdr_crack_grow(const sdr_crack_sites *sites, const double start[3], double lag,
                          sdr_crack_growth *out);
void sdr_crack_growth_clear(sdr_crack_growth *growth);

#endif
