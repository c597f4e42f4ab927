/* When damage begins: the first time that some point's damage grown since t = 0 passes the scene's
   damage.onset, looked for at least every 0.5 us. */
#ifndef SDR_OUTPUT_ONSET_H
#define SDR_OUTPUT_ONSET_H

#include "output/observer.h"

/* threshold: damage in (0, 1]. Must be shown step 0, whose damage (pre-cracks) does not count.
   After the onset it looks no more. Owner: the caller. */
sdr_status sdr_onset_create(const sdr_points *points, double threshold, sdr_observer **out);
double sdr_onset_time(const sdr_observer *onset); /* s; NAN: never so far */

#endif
