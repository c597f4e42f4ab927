/* The layout of snapshots.h5: the one place that knows its names; for who writes it and who reads
   it again (plot, compare). */
#ifndef SDR_OUTPUT_FRAMES_H
#define SDR_OUTPUT_FRAMES_H

#include "output/hdf.h"

#include <stdint.h>

typedef struct sdr_frames sdr_frames;

/* Open DIRECTORY/snapshots.h5 to read; errors as sdr_hdf_open, and SDR_BAD_INPUT if it holds no
   whole frame. The caller closes. */
sdr_status sdr_frames_open(const char *directory, sdr_frames **out);
void sdr_frames_close(sdr_frames **frames); /* NULL-safe */

int sdr_frames_count(const sdr_frames *frames);
double sdr_frames_time(const sdr_frames *frames, int k);       /* s */
int sdr_frames_nearest(const sdr_frames *frames, double time); /* index */
int32_t sdr_frames_points(const sdr_frames *frames);

/* "position" (3 values a point), "volume", "horizon", "spacing": SI; values holds points x width,
   point after point. */
sdr_status sdr_frames_read_points(sdr_frames *frames, const char *name, double *values);

/* Fields that frame k holds: how many, and the f-th's name (at most 23 letters). */
int sdr_frames_field_count(sdr_frames *frames, int k);
sdr_status sdr_frames_field_name(sdr_frames *frames, int k, int f, char name[24]);

/* Values a point has in a field of frame k. A missing field is SDR_BAD_INPUT naming those there. */
sdr_status sdr_frames_width(sdr_frames *frames, int k, const char *field, int *width);

/* Field of frame k: points x width values, point after point. */
sdr_status sdr_frames_read(sdr_frames *frames, int k, const char *field, double *values);

/* "frame_0007/time" for k = 7: the path of a dataset. */
enum { SDR_FRAME_PATH = 64 };
void sdr_frame_path(char path[SDR_FRAME_PATH], int k, const char *dataset);

/* Times of the whole frames of an open file, in order: the first `room` are written (NULL: none);
   returns how many there are. */
int sdr_frames_times(sdr_hdf *file, double *times, int room);

#endif
