/* Follows cracks from the tips of their notches: when each point was passed, and in the end
   cracks.csv and the figures of sdr_crack_figure. */
#ifndef SDR_OUTPUT_CRACK_TIPS_H
#define SDR_OUTPUT_CRACK_TIPS_H

#include "output/crack_report.h"
#include "output/observer.h"

/* For scene->output.cracks; plane_cut: the threshold where the scene gives none. Looks at the
   damage of points every so many steps, and at step 0 for what is damaged from the start. A notch's
   tip farther than a horizon from the body is SDR_BAD_INPUT. At the end of the run it writes
   DIRECTORY/cracks.csv (output/crack_file.h). Borrows the scene. Owner: the caller. */
sdr_status sdr_crack_tips_create(const sdr_scene *scene, const sdr_points *points, double plane_cut,
                                 sdr_observer **out);

/* What came out for the tips, in the scene's order; NULL before the run is over. The observer's. */
const sdr_crack_report *sdr_crack_tips_reports(const sdr_observer *observer);

#endif
