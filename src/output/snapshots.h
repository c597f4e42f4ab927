/* Snapshots of fields: snapshots.h5 with snapshots.xdmf beside it (opens in ParaView). */
#ifndef SDR_OUTPUT_SNAPSHOTS_H
#define SDR_OUTPUT_SNAPSHOTS_H

#include "output/observer.h"

/* Frames at t = 0 and at the steps nearest to scene->output.snapshots evenly spaced times up to the
   end (0: no file at all). snapshots.h5 holds
     /points/{index int32 N, position double N x 3 (z = 0 in 2-D), volume, horizon, spacing}, once,
     and from where points have split on in each frame, /frame_0007/points/...;
     /frame_0000/{FIELD float N or N x components, time double}, SI, units in the attribute "unit";
   `time` is written last and the file flushed after each frame, so a frame without it is torn; the
   .xdmf is rewritten by rename and lists flushed frames only. Points stand in the order of
   generation. On resume frames after the checkpoint are removed; a file that HDF5 does not get
   through is SDR_IO_ERROR and stays as it is. A field nobody knows is
   SDR_BAD_INPUT. Borrows scene and points. Owner: the caller. */
sdr_status sdr_snapshots_create(const sdr_scene *scene, const char *directory,
                                const sdr_points *points, sdr_observer **out);

#endif
