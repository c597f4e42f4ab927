/* Snapshots of fields: snapshots.h5 with snapshots.xdmf beside it (opens in ParaView). */
#ifndef SDR_OUTPUT_SNAPSHOTS_H
#define SDR_OUTPUT_SNAPSHOTS_H

#include "output/observer.h"

/* Frames at t = 0 and at scene->output.snapshots evenly spaced times up to the end, nearest step.
   Groups /frame_0000/{FIELD..., time} (fields float, N or N x components, `time` written last),
   /points/{index int32, position, volume, horizon} once (positions N x 3, z = 0 in 2-D). H5Fflush
   after each frame; the .xdmf is rewritten by rename and lists flushed frames only.
   Points are written in the generated order when that differs from storage. */
sdr_status sdr_snapshots_create(const sdr_scene *scene, const char *directory,
                                const sdr_points *points, sdr_observer **out);

#endif
