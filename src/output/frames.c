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

/* "points/NAME" of the file (frame < 0) or of a frame. */
static void points_path(char path[SDR_FRAME_PATH], int frame, const char *name)
{
  char inner[32];
  snprintf(inner, sizeof inner, "points/%s", name);
  if (frame < 0)
    snprintf(path, SDR_FRAME_PATH, "%s", inner);
  else
    sdr_frame_path(path, frame, inner);
}

static sdr_status write_index(sdr_hdf *file, int frame, size_t count)
{
  const sdr_hdf_shape shape = {SDR_HDF_INT32, 1, count, 1};
  char path[SDR_FRAME_PATH];
  int32_t *index = sdr_alloc(count, sizeof *index);
  if (!index) return SDR_RUN_FAILED;
  for (size_t i = 0; i < count; ++i) index[i] = (int32_t)i;
  points_path(path, frame, "index");
  const sdr_status status = sdr_hdf_write(file, path, shape, index, NULL);
  sdr_free(index);
  return status;
}

/* scratch: 3 count. */
static sdr_status write_positions(sdr_hdf *file, int frame, const sdr_points *points,
                                  double *scratch)
{
  const sdr_hdf_shape shape = {SDR_HDF_DOUBLE, 2, (size_t)points->count, 3};
  char path[SDR_FRAME_PATH];
  for (int32_t i = 0; i < points->count; ++i)
    for (int c = 0; c < 3; ++c)
      scratch[3 * (size_t)place_of(points, i) + (size_t)c] =
          c < points->components ? points->x[c][i] : 0.0;
  points_path(path, frame, "position");
  return sdr_hdf_write(file, path, shape, scratch, "m");
}

sdr_status sdr_frames_write_points(sdr_hdf *file, int frame, const sdr_points *points)
{
  const struct {
    const char *name, *unit;
    const double *values;
  } scalars[] = {{"volume", "m^3", points->volume},
                 {"horizon", "m", points->horizon},
                 {"spacing", "m", points->spacing}};
  const sdr_hdf_shape shape = {SDR_HDF_DOUBLE, 1, (size_t)points->count, 1};
  char path[SDR_FRAME_PATH];
  double *scratch = sdr_alloc(3 * (size_t)points->count, sizeof *scratch);
  sdr_status status = scratch ? write_index(file, frame, (size_t)points->count) : SDR_RUN_FAILED;
  if (status == SDR_OK) status = write_positions(file, frame, points, scratch);
  for (int k = 0; k < 3 && status == SDR_OK; ++k) {
    for (int32_t i = 0; i < points->count; ++i) scratch[place_of(points, i)] = scalars[k].values[i];
    points_path(path, frame, scalars[k].name);
    status = sdr_hdf_write(file, path, shape, scratch, scalars[k].unit);
  }
  sdr_free(scratch);
  return status;
}

int32_t sdr_frames_count_points(sdr_hdf *file, int frame, int *own)
{
  char path[SDR_FRAME_PATH];
  sdr_hdf_shape shape;
  points_path(path, frame, "index");
  *own = sdr_hdf_has(file, path);
  if (!*own) points_path(path, -1, "index");
  return sdr_hdf_shape_of(file, path, &shape) == SDR_OK ? (int32_t)shape.rows : 0;
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
