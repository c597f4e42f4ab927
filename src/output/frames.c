#include "output/frames.h"

#include <stdio.h>

void sdr_frame_path(char path[SDR_FRAME_PATH], int frame, const char *dataset)
{
  snprintf(path, SDR_FRAME_PATH, "frame_%04d%s%s", frame, *dataset ? "/" : "", dataset);
}

int sdr_frames_times(sdr_hdf *file, double *times, int room)
{
  const sdr_hdf_shape single = {SDR_HDF_DOUBLE, 0, 1, 1};
  for (int k = 0;; ++k) {
    char path[SDR_FRAME_PATH];
    double time;
    sdr_frame_path(path, k, "time");
    if (!sdr_hdf_has(file, path) || sdr_hdf_read(file, path, single, &time) != SDR_OK) return k;
    if (k < room) times[k] = time;
  }
}
