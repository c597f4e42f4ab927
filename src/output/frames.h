/* The layout of snapshots.h5: its paths, and which frames are whole. */
#ifndef SDR_OUTPUT_FRAMES_H
#define SDR_OUTPUT_FRAMES_H

#include "output/hdf.h"

/* "frame_0007/damage", or the frame's group for dataset "". */
enum { SDR_FRAME_PATH = 64 };
void sdr_frame_path(char path[SDR_FRAME_PATH], int frame, const char *dataset);

/* Times (s) of the whole frames of an open file, in order: the first `room` are written (NULL:
   none); returns how many there are. A frame without `time`, and what follows it, is not whole. */
int sdr_frames_times(sdr_hdf *file, double *times, int room);

#endif
