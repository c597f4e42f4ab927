/* How much surface cracks have made, and what it cost. */
#ifndef SDR_OUTPUT_CRACK_AREA_H
#define SDR_OUTPUT_CRACK_AREA_H

#include "output/crack_growth.h"
#include "mechanics/system.h"

/* Of one crack: area m^2, energy J. */
typedef struct {
  double area, energy;
} sdr_crack_surface;

/* Damage integrated over a body of one long plane crack is its area times the mean of |xi.n| over
   a family, n its normal: an area follows from damage grown since the start (`first`: of each
   point, at t = 0), with the mean over all directions of n. Each point's damage and half of what
   its bonds dissipated count for the crack that has the nearest site within the point's horizon.
   owner: of each site, the crack it belongs to, -1: none. out: `cracks` values. */
sdr_status sdr_crack_surfaces(sdr_system *system, const sdr_crack_sites *sites,
                              const int32_t *owner, const float *first, int cracks,
                              sdr_crack_surface *out);

/* Mean of |xi.n| over the full lattice family and all directions n, m. */
double sdr_mean_projection(int components, double spacing, double horizon);

#endif
