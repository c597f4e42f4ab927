/* The largest stable step of leapfrog: 2/omega_max (theory sec. 7). */
#ifndef SDR_TIME_STABLE_STEP_H
#define SDR_TIME_STABLE_STEP_H

#include "mechanics/system.h"

/* Limit in seconds, by Lanczos iteration on M^-1/2 K M^-1/2 with the tangent K of the undeformed
   body; low by at most 0.5 %, never high by more than rounding. Contact
   counts as if all surfaces were touched. Prescribed components count as
   free. NAN: there are points without mass. */
sdr_status sdr_stable_step(sdr_system *system, double *limit);

#endif
