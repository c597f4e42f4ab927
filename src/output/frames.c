#include "output/frames.h"

#include "base/memory.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

struct sdr_frames {
  sdr_hdf *file;
  char path[PATH_MAX];
  int count;
  double *times;
  int32_t points;
};

void sdr_frame_path(char path[SDR_FRAME_PATH], int k, const char *dataset)
{
  snprintf(path, SDR_FRAME_PATH, "frame_%04d%s%s", k, *dataset ? "/" : "", dataset);
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

static sdr_status load_index(sdr_frames *frames)
{
  sdr_hdf_shape shape;
  SDR_TRY(sdr_hdf_shape_of(frames->file, "points/index", &shape));
  frames->points = (int32_t)shape.rows;
  frames->count = sdr_frames_times(frames->file, NULL, 0);
  if (frames->count == 0) return sdr_fail(SDR_BAD_INPUT, "%s holds no frame", frames->path);
  frames->times = sdr_alloc((size_t)frames->count, sizeof *frames->times);
  if (!frames->times) return SDR_RUN_FAILED;
  sdr_frames_times(frames->file, frames->times, frames->count);
  return SDR_OK;
}

sdr_status sdr_frames_open(const char *directory, sdr_frames **out)
{
  sdr_frames *frames = sdr_alloc(1, sizeof *frames);
  if (!frames) return SDR_RUN_FAILED;
  snprintf(frames->path, sizeof frames->path, "%s/snapshots.h5", directory);
  sdr_status status = sdr_hdf_open(frames->path, 0, &frames->file);
  if (status == SDR_OK) status = load_index(frames);
  if (status == SDR_OK)
    *out = frames;
  else
    sdr_frames_close(&frames);
  return status;
}

void sdr_frames_close(sdr_frames **frames)
{
  if (!*frames) return;
  sdr_hdf_discard(&(*frames)->file);
  sdr_free((*frames)->times);
  sdr_free(*frames);
  *frames = NULL;
}

int sdr_frames_count(const sdr_frames *frames)
{
  return frames->count;
}

double sdr_frames_time(const sdr_frames *frames, int k)
{
  return frames->times[k];
}

int sdr_frames_nearest(const sdr_frames *frames, double time)
{
  int best = 0;
  for (int k = 1; k < frames->count; ++k)
    if (fabs(frames->times[k] - time) < fabs(frames->times[best] - time)) best = k;
  return best;
}

int32_t sdr_frames_points(const sdr_frames *frames)
{
  return frames->points;
}

static sdr_status read_whole(sdr_frames *frames, const char *path, double *values)
{
  sdr_hdf_shape shape;
  SDR_TRY(sdr_hdf_shape_of(frames->file, path, &shape));
  if (shape.rows != (size_t)frames->points)
    return sdr_fail(SDR_BAD_INPUT, "%s: %s holds %zu points, not %d", frames->path, path,
                    shape.rows, (int)frames->points);
  shape.type = SDR_HDF_DOUBLE;
  return sdr_hdf_read(frames->file, path, shape, values);
}

sdr_status sdr_frames_read_points(sdr_frames *frames, const char *name, double *values)
{
  char path[SDR_FRAME_PATH];
  snprintf(path, sizeof path, "points/%s", name);
  return read_whole(frames, path, values);
}

/* `time` is a member of a frame too; by name it may stand before some fields. */
sdr_status sdr_frames_field_name(sdr_frames *frames, int k, int f, char name[24])
{
  char group[SDR_FRAME_PATH];
  sdr_frame_path(group, k, "");
  const int members = sdr_hdf_count(frames->file, group);
  for (int m = 0, found = 0; m < members; ++m) {
    SDR_TRY(sdr_hdf_name(frames->file, group, m, name, 24));
    if (strcmp(name, "time") == 0) continue;
    if (found++ == f) return SDR_OK;
  }
  return sdr_fail(SDR_BAD_INPUT, "%s: %s has no field number %d", frames->path, group, f);
}

int sdr_frames_field_count(sdr_frames *frames, int k)
{
  char group[SDR_FRAME_PATH];
  sdr_frame_path(group, k, "");
  return sdr_hdf_count(frames->file, group) - 1;
}

static sdr_status fail_missing(sdr_frames *frames, int k, const char *field)
{
  char list[512] = "", name[24];
  size_t length = 0;
  for (int f = 0; f < sdr_frames_field_count(frames, k) && length < sizeof list - 32; ++f) {
    SDR_TRY(sdr_frames_field_name(frames, k, f, name));
    length += (size_t)snprintf(list + length, sizeof list - length, "%s%s", f ? ", " : "", name);
  }
  return sdr_fail(SDR_BAD_INPUT, "%s holds no field '%s'; it has: %s", frames->path, field, list);
}

sdr_status sdr_frames_width(sdr_frames *frames, int k, const char *field, int *width)
{
  char path[SDR_FRAME_PATH];
  sdr_hdf_shape shape;
  sdr_frame_path(path, k, field);
  if (!*field || strcmp(field, "time") == 0 || !sdr_hdf_has(frames->file, path))
    return fail_missing(frames, k, field);
  SDR_TRY(sdr_hdf_shape_of(frames->file, path, &shape));
  *width = (int)shape.columns;
  return SDR_OK;
}

sdr_status sdr_frames_read(sdr_frames *frames, int k, const char *field, double *values)
{
  char path[SDR_FRAME_PATH];
  int width;
  SDR_TRY(sdr_frames_width(frames, k, field, &width));
  sdr_frame_path(path, k, field);
  return read_whole(frames, path, values);
}
