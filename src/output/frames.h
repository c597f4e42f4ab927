/* The layout of snapshots.h5: its paths, its points and frames, and which frames are whole. */
#ifndef SDR_OUTPUT_FRAMES_H
#define SDR_OUTPUT_FRAMES_H

#include "nom/points.h"
#include "output/fields.h"
#include "output/hdf.h"

/* "frame_0007/damage", or the frame's group for dataset "". */
enum { SDR_FRAME_PATH = 64 };
void sdr_frame_path(char path[SDR_FRAME_PATH], int frame, const char *dataset);

/* points/{index,position,volume,horizon,spacing} of the file, in the order of generation, or of a
   frame (>= 0) that has points of its own. */
sdr_status sdr_frames_write_points(sdr_hdf *file, int frame, const sdr_points *points);

/* How many points a whole frame has, and whether they are its own; 0: there are none. */
int32_t sdr_frames_count_points(sdr_hdf *file, int frame, int *own);

/* One field of a frame with `width` values a point, component-major in `values`. packed: scratch
   for as many floats. */
sdr_status sdr_frame_write(sdr_hdf *file, int frame, const sdr_field_info *field, int width,
                           const sdr_points *points, const double *values, float *packed);

/* Write the frame's time (s), which makes it whole, and flush. */
sdr_status sdr_frame_finish(sdr_hdf *file, int frame, double time);

/* Times (s) of the whole frames of an open file, in order: the first `room` are written (NULL:
   none); returns how many there are. A frame without `time`, and what follows it, is not whole. */
int sdr_frames_times(sdr_hdf *file, double *times, int room);

#endif
