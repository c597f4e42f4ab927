#include "output/snapshots.h"

#include "base/memory.h"
#include "output/fields.h"
#include "output/fragments.h"
#include "output/frames.h"
#include "output/hdf.h"
#include "output/hdf_trial.h"
#include "output/rundir.h"
#include "output/xdmf.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MOST_FIELDS = 24 };

typedef struct {
  sdr_observer head;
  const sdr_scene *scene;
  const sdr_points *points;
  int own_points; /* 1: they have changed since the file's were written */
  char *directory;
  char path[PATH_MAX];
  int field_count;
  const sdr_field_info *fields[MOST_FIELDS];
  int next;           /* the wanted time that comes next: next / snapshots of the end */
  int64_t frame_step; /* step of the latest frame; -1: none */
  int frame_count, room;
  double *times; /* of the frames */
  int32_t *counts;
  int *own;       /* of the frames: points, and whether they are not the file's */
  sdr_hdf *file;  /* NULL until the first frame */
  double *values; /* scratch: the widest field, component-major */
  float *packed;  /* scratch: the same, point after point, in the order of generation */
} snapshots;

static snapshots *of(sdr_observer *observer)
{
  return (snapshots *)(void *)observer;
}

/* The frame number `next` is wanted at this step, or before it. The last one is that of the last
   step, which may lie up to a step beyond the end. */
static int reached(const snapshots *s, const sdr_moment *moment, int next)
{
  const int wanted = s->scene->output.snapshots;
  if (next > wanted) return 0;
  if (next == wanted) return moment->last;
  const double target = moment->end * ((double)next / (double)wanted);
  return moment->last || target <= moment->time + moment->step_size * (0.5 - 1e-9);
}

static int due(const sdr_observer *observer, const sdr_moment *moment, int *wants_balance)
{
  (void)wants_balance;
  const snapshots *s = (const snapshots *)(const void *)observer;
  return s->scene->output.snapshots > 0 && reached(s, moment, s->next);
}

static sdr_status make_fragments(snapshots *s, sdr_system *system)
{
  sdr_fragments found;
  int32_t *piece = sdr_alloc((size_t)s->points->count, sizeof *piece);
  if (!piece) return SDR_RUN_FAILED;
  const sdr_status status =
      sdr_fragments_find(system, s->scene->output.fragment_threshold, piece, &found);
  for (int32_t i = 0; status == SDR_OK && i < s->points->count; ++i)
    s->values[i] = (double)piece[i];
  sdr_free(piece);
  return status;
}

static sdr_status write_field(snapshots *s, sdr_system *system, const sdr_field_info *field)
{
  const int width = sdr_field_width(field, s->points->components);
  if (strcmp(field->name, "fragment") == 0)
    SDR_TRY(make_fragments(s, system));
  else
    SDR_TRY(sdr_system_field(system, field->name, s->values));
  return sdr_frame_write(s->file, s->frame_count, field, width, s->points, s->values, s->packed);
}

/* Bytes of a frame, with room for what HDF5 adds. */
static size_t frame_bytes(const snapshots *s)
{
  size_t values = 0;
  for (int f = 0; f < s->field_count; ++f)
    values += (size_t)sdr_field_width(s->fields[f], s->points->components);
  size_t bytes = values * sizeof(float);
  if (s->own_points || s->frame_count == 0) bytes += 6 * sizeof(double) + sizeof(int32_t);
  return bytes * (size_t)s->points->count + 65536;
}

static sdr_status write_frame(snapshots *s, const sdr_moment *moment)
{
  SDR_TRY(sdr_hdf_reserve(s->file, frame_bytes(s)));
  if (s->frame_count == 0) {
    SDR_TRY(sdr_frames_write_points(s->file, -1, s->points));
    s->own_points = 0;
  }
  if (s->own_points) SDR_TRY(sdr_frames_write_points(s->file, s->frame_count, s->points));
  for (int f = 0; f < s->field_count; ++f) SDR_TRY(write_field(s, moment->system, s->fields[f]));
  return sdr_frame_finish(s->file, s->frame_count, moment->time);
}

static sdr_status grow(snapshots *s)
{
  const size_t room = 2 * (size_t)s->room + 16;
  double *times = sdr_realloc(s->times, room, sizeof *times);
  if (times) s->times = times;
  int32_t *counts = sdr_realloc(s->counts, room, sizeof *counts);
  if (counts) s->counts = counts;
  int *own = sdr_realloc(s->own, room, sizeof *own);
  if (own) s->own = own;
  if (!times || !counts || !own) return SDR_RUN_FAILED;
  s->room = (int)room;
  return SDR_OK;
}

static sdr_status remember(snapshots *s, double time, int32_t points, int own)
{
  if (s->frame_count == s->room) SDR_TRY(grow(s));
  s->times[s->frame_count] = time;
  s->counts[s->frame_count] = points;
  s->own[s->frame_count++] = own;
  return SDR_OK;
}

static sdr_status write_xdmf(const snapshots *s)
{
  const sdr_xdmf what = {.points = s->counts,
                         .own_points = s->own,
                         .components = s->points->components,
                         .frame_count = s->frame_count,
                         .times = s->times,
                         .field_count = s->field_count,
                         .fields = s->fields};
  return sdr_xdmf_write(s->directory, &what);
}

/* After a failed write the file cannot be gone on with. Frames before this one stay readable; a
   file without any is removed. */
static void give_up(snapshots *s)
{
  sdr_hdf_discard(&s->file);
  if (s->frame_count == 0) unlink(s->path);
}

static sdr_status look(sdr_observer *observer, const sdr_moment *moment)
{
  snapshots *s = of(observer);
  if (!s->file) SDR_TRY(sdr_hdf_create(s->path, &s->file));
  const sdr_status status = write_frame(s, moment);
  if (status != SDR_OK) {
    give_up(s);
    return status;
  }
  SDR_TRY(remember(s, moment->time, s->points->count, s->own_points));
  while (reached(s, moment, s->next)) ++s->next;
  s->frame_step = moment->step;
  return write_xdmf(s);
}

static sdr_status finish(sdr_observer *observer, const sdr_moment *moment)
{
  snapshots *s = of(observer);
  const int missing = s->scene->output.snapshots > 0 && s->next <= s->scene->output.snapshots &&
                      s->frame_step != moment->step;
  if (missing) SDR_TRY(look(observer, moment));
  return sdr_hdf_close(&s->file);
}

/* Points that have split are other ones than the file began with. */
static sdr_status check_points(const snapshots *s, sdr_hdf *file)
{
  sdr_hdf_shape shape;
  if (s->own_points) return SDR_OK;
  SDR_TRY(sdr_hdf_shape_of(file, "points/index", &shape));
  if (shape.rows == (size_t)s->points->count) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s holds %zu points, this run has %d, so it cannot be continued; give another "
                  "directory with -o",
                  s->path, shape.rows, (int)s->points->count);
}

static sdr_status open_tried(const snapshots *s, sdr_hdf **left)
{
  SDR_TRY(sdr_hdf_trial(s->path));
  return sdr_hdf_open(s->path, 0, left);
}

/* Open what a run left that may have been killed while it wrote: a file that ends before its
   superblock says is padded. NULL if it is none of HDF5's; one that is damaged is not written over
   unasked. */
static sdr_status open_left(const snapshots *s, sdr_hdf **left)
{
  struct stat info;
  *left = NULL;
  sdr_status status = open_tried(s, left);
  if (status != SDR_BAD_INPUT || stat(s->path, &info) != 0) return status;
  if (truncate(s->path, info.st_size + (off_t)frame_bytes(s) + (1 << 20)) != 0) return status;
  status = open_tried(s, left);
  return status == SDR_BAD_INPUT ? SDR_OK : status;
}

/* Copy whole frames up to `time` into a new file, as many as can be read in turn. */
static sdr_status copy_frames(snapshots *s, sdr_hdf *left, sdr_hdf *kept, double time)
{
  const sdr_hdf_shape single = {SDR_HDF_DOUBLE, 0, 1, 1};
  char path[SDR_FRAME_PATH];
  SDR_TRY(check_points(s, left));
  SDR_TRY(sdr_hdf_copy(left, kept, "points"));
  for (int k = 0;; ++k) {
    double at;
    sdr_frame_path(path, k, "time");
    if (!sdr_hdf_has(left, path) || sdr_hdf_read(left, path, single, &at) != SDR_OK) break;
    sdr_frame_path(path, k, "");
    if (at > time || sdr_hdf_copy(left, kept, path) != SDR_OK) break;
    int own;
    const int32_t points = sdr_frames_count_points(left, k, &own);
    SDR_TRY(remember(s, at, points, own));
  }
  return sdr_hdf_flush(kept);
}

/* Keep the whole frames up to `time`, in a new file: one that was killed half way through a frame
   can be read up to there, but not gone on with. */
static sdr_status keep_frames(snapshots *s, double time)
{
  char temporary[PATH_MAX + 8];
  sdr_hdf *left = NULL, *kept = NULL;
  snprintf(temporary, sizeof temporary, "%s.part", s->path);
  SDR_TRY(open_left(s, &left));
  if (!left || sdr_frames_times(left, NULL, 0) == 0) {
    sdr_hdf_discard(&left);
    return SDR_OK;
  }
  sdr_status status = sdr_hdf_create(temporary, &kept);
  if (status == SDR_OK) status = copy_frames(s, left, kept, time);
  sdr_hdf_discard(&left);
  if (status == SDR_OK)
    status = sdr_hdf_close(&kept);
  else
    sdr_hdf_discard(&kept);
  if (status == SDR_OK) return sdr_rundir_settle(temporary, s->path);
  unlink(temporary);
  return status;
}

/* Without a file, or without a frame in it, a new one is begun. */
static sdr_status resumed(sdr_observer *observer, const sdr_moment *moment)
{
  snapshots *s = of(observer);
  int unused = 0;
  s->frame_count = 0;
  s->next = 0;
  s->frame_step = -1;
  SDR_TRY(sdr_hdf_close(&s->file));
  if (s->scene->output.snapshots <= 0) return SDR_OK;
  if (access(s->path, F_OK) == 0) {
    SDR_TRY(keep_frames(s, moment->time + sdr_moment_slack(moment)));
    if (s->frame_count > 0) SDR_TRY(sdr_hdf_open(s->path, 1, &s->file));
  }
  if (s->frame_count > 0) {
    sdr_moment latest = *moment;
    latest.last = 0;
    latest.time = s->times[s->frame_count - 1];
    while (reached(s, &latest, s->next)) ++s->next;
    if (!(latest.time < moment->time)) s->frame_step = moment->step; /* this one's is there */
    SDR_TRY(write_xdmf(s));
  }
  const int is_due = s->frame_step != moment->step && due(observer, moment, &unused);
  return is_due ? look(observer, moment) : SDR_OK;
}

static sdr_status make_room(snapshots *s)
{
  int widest = 1;
  for (int f = 0; f < s->field_count; ++f) {
    const int width = sdr_field_width(s->fields[f], s->points->components);
    if (width > widest) widest = width;
  }
  const size_t size = (size_t)widest * (size_t)s->points->count;
  sdr_free(s->values);
  sdr_free(s->packed);
  s->values = sdr_alloc(size, sizeof *s->values);
  s->packed = sdr_alloc(size, sizeof *s->packed);
  return s->values && s->packed ? SDR_OK : SDR_RUN_FAILED;
}

static sdr_status points_changed(sdr_observer *observer, const sdr_moment *moment,
                                 const sdr_point_map *map)
{
  snapshots *s = of(observer);
  (void)map;
  s->points = moment->system->model->points;
  s->own_points = 1;
  return s->scene->output.snapshots > 0 ? make_room(s) : SDR_OK;
}

static void destroy(sdr_observer *observer)
{
  snapshots *s = of(observer);
  sdr_hdf_discard(&s->file); /* each frame was flushed */
  sdr_free(s->directory);
  sdr_free(s->times);
  sdr_free(s->counts);
  sdr_free(s->own);
  sdr_free(s->values);
  sdr_free(s->packed);
  sdr_free(s);
}

static const sdr_observer_ops ops = {.name = "snapshots",
                                     .due = due,
                                     .look = look,
                                     .finish = finish,
                                     .resumed = resumed,
                                     .points_changed = points_changed,
                                     .destroy = destroy};

static sdr_status choose_fields(snapshots *s)
{
  const sdr_output_scene *output = &s->scene->output;
  for (int f = 0; f < output->field_count && f < MOST_FIELDS; ++f) {
    const sdr_field_info *field = sdr_field_find(output->field[f]);
    if (!field)
      return sdr_fail(SDR_BAD_INPUT, "output.fields: there is no field '%s'", output->field[f]);
    for (int earlier = 0; field && earlier < s->field_count; ++earlier)
      if (s->fields[earlier] == field) field = NULL;
    if (field) s->fields[s->field_count++] = field;
  }
  return SDR_OK;
}

sdr_status sdr_snapshots_create(const sdr_scene *scene, const char *directory,
                                const sdr_points *points, sdr_observer **out)
{
  snapshots *s = sdr_alloc(1, sizeof *s);
  if (!s) return SDR_RUN_FAILED;
  *s = (snapshots){.head.ops = &ops, .scene = scene, .points = points, .frame_step = -1};
  snprintf(s->path, sizeof s->path, "%s/snapshots.h5", directory);
  s->directory = sdr_strdup(directory);
  sdr_status status = s->directory ? choose_fields(s) : SDR_RUN_FAILED;
  if (status == SDR_OK && scene->output.snapshots > 0) status = make_room(s);
  if (status == SDR_OK)
    *out = &s->head;
  else
    destroy(&s->head);
  return status;
}
