#include "output/frames.h"

#include "base/memory.h"

#include <stdio.h>

void sdr_frame_path(char path[SDR_FRAME_PATH], int frame, const char *dataset)
{
  snprintf(path, SDR_FRAME_PATH, "frame_%04d%s%s", frame, *dataset ? "/" : "", dataset);
}

static int32_t place_of(const sdr_points *points, int32_t i)
{
  return points->generated ? points->generated[i] : i;
}

static sdr_status write_index(sdr_hdf *file, size_t count)
{
  const sdr_hdf_shape shape = {SDR_HDF_INT32, 1, count, 1};
  int32_t *index = sdr_alloc(count, sizeof *index);
  if (!index) return SDR_RUN_FAILED;
  for (size_t i = 0; i < count; ++i) index[i] = (int32_t)i;
  const sdr_status status = sdr_hdf_write(file, "points/index", shape, index, NULL);
  sdr_free(index);
  return status;
}

/* scratch: 3 count. */
static sdr_status write_positions(sdr_hdf *file, const sdr_points *points, double *scratch)
{
  const sdr_hdf_shape shape = {SDR_HDF_DOUBLE, 2, (size_t)points->count, 3};
  for (int32_t i = 0; i < points->count; ++i)
    for (int c = 0; c < 3; ++c)
      scratch[3 * (size_t)place_of(points, i) + (size_t)c] =
          c < points->components ? points->x[c][i] : 0.0;
  return sdr_hdf_write(file, "points/position", shape, scratch, "m");
}

static sdr_status write_scalars(sdr_hdf *file, const sdr_points *points, const char *name,
                                const char *unit, const double *values, double *scratch)
{
  const sdr_hdf_shape shape = {SDR_HDF_DOUBLE, 1, (size_t)points->count, 1};
  for (int32_t i = 0; i < points->count; ++i) scratch[place_of(points, i)] = values[i];
  return sdr_hdf_write(file, name, shape, scratch, unit);
}

sdr_status sdr_frames_write_points(sdr_hdf *file, const sdr_points *points)
{
  double *scratch = sdr_alloc(3 * (size_t)points->count, sizeof *scratch);
  sdr_status status = scratch ? write_index(file, (size_t)points->count) : SDR_RUN_FAILED;
  if (status == SDR_OK) status = write_positions(file, points, scratch);
  if (status == SDR_OK)
    status = write_scalars(file, points, "points/volume", "m^3", points->volume, scratch);
  if (status == SDR_OK)
    status = write_scalars(file, points, "points/horizon", "m", points->horizon, scratch);
  if (status == SDR_OK)
    status = write_scalars(file, points, "points/spacing", "m", points->spacing, scratch);
  sdr_free(scratch);
  return status;
}

sdr_status sdr_frame_write(sdr_hdf *file, int frame, const sdr_field_info *field, int width,
                           const sdr_points *points, const double *values, float *packed)
{
  const size_t count = (size_t)points->count, columns = (size_t)width;
  const sdr_hdf_shape shape = {SDR_HDF_FLOAT, width > 1 ? 2 : 1, count, columns};
  char path[SDR_FRAME_PATH];
  for (size_t i = 0; i < count; ++i) {
    float *to = packed + columns * (size_t)place_of(points, (int32_t)i);
    for (size_t k = 0; k < columns; ++k) to[k] = (float)values[k * count + i];
  }
  sdr_frame_path(path, frame, field->name);
  return sdr_hdf_write(file, path, shape, packed, field->unit);
}

sdr_status sdr_frame_finish(sdr_hdf *file, int frame, double time)
{
  const sdr_hdf_shape single = {SDR_HDF_DOUBLE, 0, 1, 1};
  char path[SDR_FRAME_PATH];
  sdr_frame_path(path, frame, "time");
  SDR_TRY(sdr_hdf_write(file, path, single, &time, "s"));
  return sdr_hdf_flush(file);
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
