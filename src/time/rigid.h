/* Whether prescribed components keep a body from moving as a whole. */
#ifndef SDR_TIME_RIGID_H
#define SDR_TIME_RIGID_H

#include "nom/points.h"

/* SDR_BAD_INPUT if some (infinitesimal) rigid motion of the points leaves all prescribed components
   alone. `prescribed`: 1 for each unknown = point * components + component that is. */
sdr_status sdr_rigid_held(const sdr_points *points, const uint8_t *prescribed);

#endif
