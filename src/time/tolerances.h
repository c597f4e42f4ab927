/* How accurately integrators that control their error follow a motion. */
#ifndef SDR_TIME_TOLERANCES_H
#define SDR_TIME_TOLERANCES_H

#include "mechanics/system.h"

/* Errors of a step are held, as a root mean square, to relative |x| + displacement (m) or velocity
   (m/s). */
typedef struct {
  double relative, displacement, velocity;
} sdr_tolerances;

/* What the scene asks (system->how), and where that is automatic: relative times the scale of the
   motion. That of velocities is the largest of the start, of the supports, and of what forces in 32
   moments of the run and the start's own give their points within half a stable step; that of
   displacements the way at it within 1.5 stable steps, a wave's time through a horizon. In a scene
   where nothing moves both are tiny and not 0. Without masses (stable_step NAN) a tenth of the run
   takes the place of that step: displacements tell the scale. Uses the system's f as scratch. */
sdr_status sdr_tolerances_choose(sdr_system *system, double stable_step, sdr_tolerances *out);

#endif
