#include "app/rundata.h"

#include "base/memory.h"
#include "output/hdf_trial.h"

#include <errno.h>
#include <hdf5.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { PATH_ROOM = 4096 };

/* HDF5 prints its errors itself; ours are told in words. */
typedef struct {
  H5E_auto2_t function;
  void *data;
} h5_voice;

static h5_voice hush(void)
{
  h5_voice voice = {NULL, NULL};
  H5Eget_auto2(H5E_DEFAULT, &voice.function, &voice.data);
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
  return voice;
}

static void unhush(h5_voice voice)
{
  H5Eset_auto2(H5E_DEFAULT, voice.function, voice.data);
}

/* ---- summary.json ---- */

static sdr_status read_summary(const char *path, sdr_rundata *run)
{
  json_error_t error;
  if (access(path, R_OK) != 0) return sdr_fail(SDR_IO_ERROR, "%s: %s", path, strerror(errno));
  run->summary = json_load_file(path, 0, &error);
  if (run->summary && json_is_object(run->summary)) return SDR_OK;
  if (run->summary) return sdr_fail(SDR_BAD_INPUT, "%s: not a JSON object", path);
  return sdr_fail(SDR_BAD_INPUT, "%s:%d:%d: %s", path, error.line, error.column, error.text);
}

static const json_t *find(const sdr_rundata *run, const char *path)
{
  const json_t *value = run->summary;
  while (value && *path) {
    char key[256];
    const size_t length = strcspn(path, ".");
    if (length >= sizeof key) return NULL;
    memcpy(key, path, length);
    key[length] = '\0';
    value = json_object_get(value, key);
    path += length + (path[length] == '.');
  }
  return value;
}

const char *sdr_rundata_text(const sdr_rundata *run, const char *path)
{
  return json_string_value(find(run, path));
}

double sdr_rundata_number(const sdr_rundata *run, const char *path)
{
  const json_t *value = find(run, path);
  return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

const char *sdr_rundata_figure(const sdr_rundata *run, int k)
{
  json_t *figures = run->summary ? json_object_get(run->summary, "figures") : NULL;
  const char *name = NULL;
  json_t *value = NULL;
  json_object_foreach(figures, name, value)
  {
    if (k-- == 0) return name;
  }
  return NULL;
}

/* ---- snapshots.h5 ---- */

/* Rank and sizes of a data set with 1 or 2 dimensions; {0, 0} if it is something else. */
static void shape_of(hid_t set, hsize_t size[2])
{
  const hid_t space = H5Dget_space(set);
  const int rank = H5Sget_simple_extent_ndims(space);
  size[0] = 0;
  size[1] = 1;
  if (rank == 1 || rank == 2)
    H5Sget_simple_extent_dims(space, size, NULL);
  else if (rank == 0)
    size[0] = 1;
  H5Sclose(space);
}

/* Data set `name` of `rows` rows (0: any, stored to it) and at most 16 columns, as `type`. */
static sdr_status read_set(const sdr_rundata *run, const char *name, hid_t type, size_t bytes,
                           hsize_t *rows, hsize_t *columns, void **out)
{
  const hid_t set = H5Dopen2(run->snapshots, name, H5P_DEFAULT);
  if (set < 0)
    return sdr_fail(SDR_BAD_INPUT, "%s/snapshots.h5: no data set %s", run->directory, name);
  hsize_t size[2];
  shape_of(set, size);
  sdr_status status = SDR_OK;
  void *data = NULL;
  if (size[0] == 0 || (*rows && size[0] != *rows) || size[1] < 1 || size[1] > 16 ||
      size[0] > INT32_MAX)
    status = sdr_fail(SDR_BAD_INPUT, "%s/snapshots.h5: data set %s has the wrong shape",
                      run->directory, name);
  else if (!(data = sdr_alloc((size_t)size[0] * (size_t)size[1], bytes)))
    status = SDR_RUN_FAILED;
  else if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
    status = sdr_fail(SDR_IO_ERROR,
                      "%s/snapshots.h5: data set %s cannot be read; the file may be "
                      "truncated",
                      run->directory, name);
  H5Dclose(set);
  if (status != SDR_OK) {
    sdr_free(data);
    return status;
  }
  *rows = size[0];
  *columns = size[1];
  *out = data;
  return SDR_OK;
}

static int dimension_of(const sdr_rundata *run)
{
  double extent[3], largest = 0.0;
  for (int c = 0; c < 3; ++c) {
    double low = INFINITY, high = -INFINITY;
    for (int32_t i = 0; i < run->point_count; ++i) {
      low = fmin(low, run->position[c][i]);
      high = fmax(high, run->position[c][i]);
    }
    extent[c] = high - low;
    largest = fmax(largest, extent[c]);
  }
  for (int c = 2; c > 0; --c)
    if (extent[c] > 1e-6 * largest) return c + 1;
  return 1;
}

static sdr_status spread_positions(sdr_rundata *run, const double *rows, hsize_t columns)
{
  for (int c = 0; c < 3; ++c) {
    run->position[c] = sdr_alloc((size_t)run->point_count, sizeof(double));
    if (!run->position[c]) return SDR_RUN_FAILED;
    for (int32_t i = 0; i < run->point_count && (hsize_t)c < columns; ++i) {
      run->position[c][i] = rows[(hsize_t)i * columns + (hsize_t)c];
      if (!isfinite(run->position[c][i]))
        return sdr_fail(SDR_BAD_INPUT, "%s/snapshots.h5: the position of point %d is not finite",
                        run->directory, i);
    }
  }
  run->dimension = dimension_of(run);
  return SDR_OK;
}

/* The points of `group`. */
static sdr_status read_points(sdr_rundata *run, const char *group)
{
  char name[64];
  hsize_t rows = 0, columns = 0;
  void *data = NULL;
  snprintf(name, sizeof name, "%s/position", group);
  SDR_TRY(read_set(run, name, H5T_NATIVE_DOUBLE, sizeof(double), &rows, &columns, &data));
  run->point_count = (int32_t)rows;
  for (int c = 0; c < 3; ++c) {
    sdr_free(run->position[c]);
    run->position[c] = NULL;
  }
  sdr_free(run->volume);
  run->volume = NULL;
  const sdr_status status = spread_positions(run, data, columns);
  sdr_free(data);
  if (status != SDR_OK) return status;
  data = NULL;
  snprintf(name, sizeof name, "%s/volume", group);
  if (H5Lexists(run->snapshots, name, H5P_DEFAULT) > 0)
    SDR_TRY(read_set(run, name, H5T_NATIVE_DOUBLE, sizeof(double), &rows, &columns, &data));
  run->volume = data;
  return SDR_OK;
}

sdr_status sdr_rundata_use(sdr_rundata *run, int frame)
{
  char group[64];
  const h5_voice voice = hush();
  snprintf(group, sizeof group, "/frame_%04d/points", frame);
  const int own = frame >= 0 && H5Lexists(run->snapshots, group, H5P_DEFAULT) > 0;
  const int wanted = own ? frame : -1;
  sdr_status status = SDR_OK;
  if (wanted != run->points_frame) status = read_points(run, own ? group : "/points");
  if (status == SDR_OK) run->points_frame = wanted;
  unhush(voice);
  return status;
}

/* Frames are numbered from 0; `time` is written last, so a frame without it is not whole. */
static sdr_status read_frames(sdr_rundata *run)
{
  int capacity = 0;
  for (;; ++run->frame_count) {
    char name[64];
    snprintf(name, sizeof name, "/frame_%04d", run->frame_count);
    if (H5Lexists(run->snapshots, name, H5P_DEFAULT) <= 0) return SDR_OK;
    snprintf(name, sizeof name, "/frame_%04d/time", run->frame_count);
    if (H5Lexists(run->snapshots, name, H5P_DEFAULT) <= 0) return SDR_OK;
    if (run->frame_count == capacity) {
      capacity = capacity ? 2 * capacity : 64;
      double *grown = sdr_realloc(run->frame_time, (size_t)capacity, sizeof *grown);
      if (!grown) return SDR_RUN_FAILED;
      run->frame_time = grown;
    }
    hsize_t rows = 1, columns = 0;
    void *time = NULL;
    SDR_TRY(read_set(run, name, H5T_NATIVE_DOUBLE, sizeof(double), &rows, &columns, &time));
    run->frame_time[run->frame_count] = *(const double *)time;
    sdr_free(time);
  }
}

/* Without file locking: a run that is still writing can be looked at. */
static hid_t open_file(const char *path)
{
  const hid_t access_list = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_file_locking(access_list, 0, 1);
  const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, access_list);
  H5Pclose(access_list);
  return file;
}

static sdr_status read_snapshots(const char *path, sdr_rundata *run)
{
  if (access(path, R_OK) != 0) return sdr_fail(SDR_IO_ERROR, "%s: %s", path, strerror(errno));
  SDR_TRY(sdr_hdf_trial(path));
  run->snapshots = open_file(path);
  if (run->snapshots < 0)
    return sdr_fail(SDR_IO_ERROR,
                    "%s: not a readable HDF5 file; it may be truncated, or its first frame is not "
                    "written yet",
                    path);
  SDR_TRY(read_points(run, "/points"));
  return read_frames(run);
}

int sdr_rundata_nearest(const sdr_rundata *run, double time)
{
  int nearest = run->frame_count - 1;
  for (int k = 0; k < run->frame_count; ++k)
    if (fabs(run->frame_time[k] - time) < fabs(run->frame_time[nearest] - time)) nearest = k;
  return nearest;
}

int sdr_rundata_has(const sdr_rundata *run, int frame, const char *field)
{
  char name[320];
  if (frame < 0 || frame >= run->frame_count || !*field || strcmp(field, "time") == 0 ||
      strcmp(field, "points") == 0 || strchr(field, '/') || strcmp(field, ".") == 0 ||
      strlen(field) > 255)
    return 0;
  snprintf(name, sizeof name, "/frame_%04d/%s", frame, field);
  const h5_voice voice = hush();
  const int found = H5Lexists(run->snapshots, name, H5P_DEFAULT) > 0;
  unhush(voice);
  return found;
}

static herr_t append_name(hid_t group, const char *name, const H5L_info_t *info, void *context)
{
  (void)group;
  (void)info;
  FILE *list = context;
  if (strcmp(name, "time") == 0 || strcmp(name, "points") == 0) return 0;
  fprintf(list, "%s%s", ftell(list) > 0 ? ", " : "", name);
  return 0;
}

char *sdr_rundata_fields(const sdr_rundata *run, int frame)
{
  char *text = NULL, group[64];
  size_t length = 0;
  FILE *list = open_memstream(&text, &length);
  if (!list) return NULL;
  snprintf(group, sizeof group, "/frame_%04d", frame);
  const h5_voice voice = hush();
  H5Literate_by_name(run->snapshots, group, H5_INDEX_NAME, H5_ITER_INC, NULL, append_name, list,
                     H5P_DEFAULT);
  unhush(voice);
  fclose(list);
  char *copy = sdr_strdup(text ? text : "");
  free(text);
  return copy;
}

sdr_status sdr_rundata_field(const sdr_rundata *run, int frame, const char *field, float **values,
                             int *components)
{
  if (!sdr_rundata_has(run, frame, field)) {
    char *present = sdr_rundata_fields(run, frame);
    sdr_fail(SDR_BAD_INPUT,
             "%s/snapshots.h5: no field \"%s\"; present: %s; the scene's "
             "output.fields says which are written",
             run->directory, field, present && *present ? present : "none");
    sdr_free(present);
    return SDR_BAD_INPUT;
  }
  char name[320];
  snprintf(name, sizeof name, "/frame_%04d/%s", frame, field);
  hsize_t rows = (hsize_t)run->point_count, columns = 0;
  void *data = NULL;
  const h5_voice voice = hush();
  const sdr_status status =
      read_set(run, name, H5T_NATIVE_FLOAT, sizeof(float), &rows, &columns, &data);
  unhush(voice);
  if (status != SDR_OK) return status;
  *values = data;
  *components = (int)columns;
  return SDR_OK;
}

/* ---- the directory ---- */

/* DIRECTORY/name into path; 1 if there is such a file. */
static int present(const char *directory, const char *name, char path[PATH_ROOM])
{
  struct stat info;
  snprintf(path, PATH_ROOM, "%s/%s", directory, name);
  return stat(path, &info) == 0;
}

static sdr_status read_files(sdr_rundata *run)
{
  char path[PATH_ROOM];
  int files = 0;
  if (present(run->directory, "summary.json", path) && ++files) SDR_TRY(read_summary(path, run));
  if (present(run->directory, "history.csv", path) && ++files)
    SDR_TRY(sdr_history_read(path, &run->history));
  if (present(run->directory, "snapshots.h5", path) && ++files) {
    const h5_voice voice = hush();
    const sdr_status status = read_snapshots(path, run);
    unhush(voice);
    if (status != SDR_OK) return status;
  }
  if (files > 0) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: not a run's directory; it holds no summary.json, "
                  "history.csv or snapshots.h5",
                  run->directory);
}

sdr_status sdr_rundata_open(const char *directory, sdr_rundata **out)
{
  struct stat info;
  if (stat(directory, &info) != 0)
    return sdr_fail(SDR_IO_ERROR, "%s: %s; give the directory of a run", directory,
                    strerror(errno));
  if (!S_ISDIR(info.st_mode))
    return sdr_fail(SDR_BAD_INPUT, "%s: not a directory; give the directory of a run", directory);
  if (strlen(directory) > PATH_ROOM - 64)
    return sdr_fail(SDR_BAD_INPUT, "the directory's name is too long");
  sdr_rundata *run = sdr_alloc(1, sizeof *run);
  if (!run) return SDR_RUN_FAILED;
  run->snapshots = -1;
  run->points_frame = -1;
  run->directory = sdr_strdup(directory);
  const sdr_status status = run->directory ? read_files(run) : SDR_RUN_FAILED;
  if (status != SDR_OK) {
    sdr_rundata_destroy(&run);
    return status;
  }
  *out = run;
  return SDR_OK;
}

void sdr_rundata_destroy(sdr_rundata **run)
{
  sdr_rundata *data = *run;
  if (!data) return;
  if (data->snapshots >= 0) H5Fclose(data->snapshots);
  json_decref(data->summary);
  sdr_history_clear(&data->history);
  for (int c = 0; c < 3; ++c) sdr_free(data->position[c]);
  sdr_free(data->volume);
  sdr_free(data->frame_time);
  sdr_free(data->directory);
  sdr_free(data);
  *run = NULL;
}
