/* cracks.csv: the ways of all tips. */
#ifndef SDR_OUTPUT_CRACK_FILE_H
#define SDR_OUTPUT_CRACK_FILE_H

#include "output/crack_report.h"

/* Write DIRECTORY/cracks.csv: crack,arm,parent,time,distance,x,y,z,speed,smooth_speed; a row for
   each place that a tip passed, an arm's rows together. SI; parent -1: the notch; speed is that of
   000 eq. 59, smooth_speed the slope over the window; empty: not known
   (sdr_crack_speed; without the slope speed is not either). 17 digits. `reports`: one
   per tip of the scene. */
sdr_status sdr_crack_file_write(const char *directory, const sdr_cracks_output *cracks,
                                const sdr_crack_report *reports, double window);

#endif
