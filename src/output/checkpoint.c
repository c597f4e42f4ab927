/* The state is a list of blocks of bytes, made by one function for writing and for reading: names
   and sizes come from the run, so that a file which fits is one that this run could have written.
   A seal over the file (seal.h) tells a damaged one before HDF5 sees it. */
#include "output/checkpoint.h"

#include "base/memory.h"
#include "output/hdf.h"
#include "output/rundir.h"
#include "output/seal.h"
#include "output/version.h"

#include <inttypes.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NAME_SIZE = 160 };

/* Where a run stands. Doubles and int64 only: no padding. */
typedef struct {
  double time, step_size, velocity_offset, external_work, viscous, refinement, time_since;
  double impulse[3], angular_impulse[3];
  int64_t step, step_since;
} standing;

typedef struct {
  char name[NAME_SIZE]; /* its path in the file */
  void *data;
  void *read; /* what the file has, until all is known to be right */
  size_t bytes;
} block;

typedef struct {
  int count, room;
  block *blocks;
} plan;

static void plan_free(plan *p)
{
  for (int k = 0; k < p->count; ++k) sdr_free(p->blocks[k].read);
  sdr_free(p->blocks);
}

static sdr_status add(plan *p, const char *group, const char *name, void *data, size_t bytes)
{
  if (p->count == p->room) {
    const int room = 2 * p->room + 16;
    block *grown = sdr_realloc(p->blocks, (size_t)room, sizeof *grown);
    if (!grown) return SDR_RUN_FAILED;
    p->blocks = grown;
    p->room = room;
  }
  block *b = &p->blocks[p->count++];
  *b = (block){.data = data, .bytes = bytes};
  snprintf(b->name, sizeof b->name, "%s/%s", group, name);
  return SDR_OK;
}

static sdr_status add_blocks(plan *p, const char *group, const sdr_state_block *blocks, int count)
{
  for (int k = 0; k < count; ++k)
    if (blocks[k].bytes > 0)
      SDR_TRY(add(p, group, blocks[k].name, blocks[k].data, blocks[k].bytes));
  return SDR_OK;
}

static sdr_status add_system(plan *p, sdr_system *system)
{
  static const char *const names[3][3] = {
      {"u.x", "u.y", "u.z"}, {"v.x", "v.y", "v.z"}, {"f.x", "f.y", "f.z"}};
  const size_t bytes = (size_t)system->count * sizeof(double);
  for (int c = 0; c < system->components; ++c) {
    SDR_TRY(add(p, "system", names[0][c], system->u[c], bytes));
    SDR_TRY(add(p, "system", names[1][c], system->v[c], bytes));
    SDR_TRY(add(p, "system", names[2][c], system->f[c], bytes));
  }
  sdr_state_block blocks[SDR_STATE_BLOCKS];
  int count = 0;
  sdr_system_state(system, blocks, &count);
  return add_blocks(p, "system", blocks, count);
}

static sdr_status add_observer(plan *p, sdr_observer *observer)
{
  sdr_state_block blocks[SDR_STATE_BLOCKS];
  char group[NAME_SIZE / 2];
  int count = 0;
  if (!observer->ops->state) return SDR_OK;
  observer->ops->state(observer, blocks, &count);
  snprintf(group, sizeof group, "observers/%s", observer->ops->name);
  return add_blocks(p, group, blocks, count);
}

static sdr_status make_plan(plan *p, standing *now, sdr_system *system,
                            sdr_observer *const *observers, int observer_count)
{
  sdr_state_block blocks[SDR_STATE_BLOCKS];
  int count = 0;
  SDR_TRY(add(p, "system", "standing", now, sizeof *now));
  SDR_TRY(add_system(p, system));
  if (system->model->ops->state) system->model->ops->state(system->model, blocks, &count);
  SDR_TRY(add_blocks(p, "model", blocks, count));
  for (int k = 0; k < observer_count; ++k) SDR_TRY(add_observer(p, observers[k]));
  return SDR_OK;
}

/* What must agree between a checkpoint and the run that reads it. */
typedef struct {
  const char *key, *what;
  char text[64];
} item;

enum { ITEMS = 5 };

static void identify(item items[ITEMS], const sdr_moment *moment, const char *instruction_set)
{
  static const char *const keys[ITEMS] = {"version", "scene", "precision", "instruction_set",
                                          "points"};
  for (int k = 0; k < ITEMS; ++k) items[k] = (item){.key = keys[k], .what = keys[k]};
  items[1].what = "scene hash";
  items[3].what = "instruction set";
  items[4].what = "number of points";
  snprintf(items[0].text, sizeof items[0].text, "%s", SUNDER_VERSION);
  snprintf(items[1].text, sizeof items[1].text, "%016" PRIx64, moment->scene->hash);
  snprintf(items[2].text, sizeof items[2].text, "%s", moment->scene->mixed ? "mixed" : "double");
  snprintf(items[3].text, sizeof items[3].text, "%s", instruction_set);
  snprintf(items[4].text, sizeof items[4].text, "%d", (int)moment->system->count);
}

int sdr_checkpoint_due(const sdr_moment *moment)
{
  const double every = moment->scene->output.checkpoint_every;
  if (!(every > 0.0) || isinf(every) || moment->step == 0) return 0;
  if (moment->last) return 1;
  const double half = moment->step_size * (0.5 - 1e-9);
  const double latest = floor((moment->time + half) / every);
  return latest >= 1.0 && latest > floor((moment->time - moment->step_size + half) / every);
}

static sdr_status write_file(sdr_hdf *file, const plan *p, const item items[ITEMS])
{
  size_t bytes = 65536;
  for (int k = 0; k < p->count; ++k) bytes += p->blocks[k].bytes + 1024;
  SDR_TRY(sdr_hdf_reserve(file, bytes));
  for (int k = 0; k < ITEMS; ++k) SDR_TRY(sdr_hdf_write_text(file, items[k].key, items[k].text));
  for (int k = 0; k < p->count; ++k) {
    const block *b = &p->blocks[k];
    const sdr_hdf_shape shape = {SDR_HDF_BYTES, 1, b->bytes, 1};
    SDR_TRY(sdr_hdf_write(file, b->name, shape, b->data, NULL));
  }
  return SDR_OK;
}

sdr_status sdr_checkpoint_write(const char *directory, const sdr_moment *moment,
                                const char *instruction_set, sdr_observer *const *observers,
                                int observer_count)
{
  char path[PATH_MAX], temporary[PATH_MAX + 8];
  item items[ITEMS];
  plan p = {0};
  sdr_hdf *file = NULL;
  const sdr_system *system = moment->system;
  standing now = {.time = moment->time,
                  .step_size = moment->step_size,
                  .velocity_offset = system->velocity_offset,
                  .external_work = system->external_work,
                  .viscous = system->viscous,
                  .refinement = system->refinement,
                  .time_since = system->time_since,
                  .step_since = system->step_since,
                  .step = moment->step};
  memcpy(now.impulse, system->impulse, sizeof now.impulse);
  memcpy(now.angular_impulse, system->angular_impulse, sizeof now.angular_impulse);
  snprintf(path, sizeof path, "%s/checkpoint.h5", directory);
  snprintf(temporary, sizeof temporary, "%s.part", path);
  identify(items, moment, instruction_set);

  sdr_status status = make_plan(&p, &now, moment->system, observers, observer_count);
  if (status == SDR_OK) status = sdr_hdf_create_sealed(temporary, &file);
  if (status == SDR_OK) status = write_file(file, &p, items);
  if (status == SDR_OK) status = sdr_hdf_close(&file);
  if (status == SDR_OK) status = sdr_seal_write(temporary);
  if (status == SDR_OK) {
    status = sdr_rundir_settle(temporary, path);
  } else {
    sdr_hdf_discard(&file);
    remove(temporary);
  }
  plan_free(&p);
  return status;
}

static sdr_status fail_not_whole(const char *path)
{
  return sdr_fail(SDR_BAD_INPUT, "%s is not a whole checkpoint: it is truncated or damaged", path);
}

/* What is no checkpoint at all, and where one may lie. */
static sdr_status fail_not_one(const char *path)
{
  struct stat info;
  const char *name = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
  const int length = (int)(name - path);
  if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
    return sdr_fail(SDR_BAD_INPUT, "%s is a directory, not a checkpoint; give %s%scheckpoint.h5",
                    path, path, path[strlen(path) - 1] == '/' ? "" : "/");
  if (strcmp(name, "snapshots.h5") == 0)
    return sdr_fail(SDR_BAD_INPUT, "%s holds snapshots, not a checkpoint; give %.*scheckpoint.h5",
                    path, length, path);
  if (strlen(name) > 5 && strcmp(name + strlen(name) - 5, ".yaml") == 0)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s is a scene, not a checkpoint; give the checkpoint.h5 of a run's directory",
                    path);
  return fail_not_whole(path);
}

static sdr_status check_items(sdr_hdf *file, const char *path, const item items[ITEMS])
{
  for (int k = 0; k < ITEMS; ++k) {
    char found[64];
    if (sdr_hdf_read_text(file, items[k].key, found, sizeof found) != SDR_OK)
      return fail_not_whole(path);
    if (strcmp(found, items[k].text) != 0)
      return sdr_fail(
          SDR_BAD_INPUT,
          "%s does not fit this run: its %s is %s, this run's is %s; only title, "
          "output, figures, threads, time.end, time.allow_unstable and damage.onset may differ",
          path, items[k].what, found, items[k].text);
  }
  return SDR_OK;
}

static sdr_status read_block(sdr_hdf *file, const char *path, block *b)
{
  const sdr_hdf_shape shape = {SDR_HDF_BYTES, 1, b->bytes, 1};
  sdr_hdf_shape found;
  if (!sdr_hdf_has(file, b->name))
    return sdr_fail(SDR_BAD_INPUT, "%s does not fit this run: it has no %s", path, b->name);
  if (sdr_hdf_shape_of(file, b->name, &found) != SDR_OK) return fail_not_whole(path);
  if (found.rows != b->bytes)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s does not fit this run: its %s has %zu bytes, this run's has %zu", path,
                    b->name, found.rows, b->bytes);
  b->read = sdr_alloc(b->bytes, 1);
  if (!b->read) return SDR_RUN_FAILED;
  if (sdr_hdf_read(file, b->name, shape, b->read) != SDR_OK) return fail_not_whole(path);
  return SDR_OK;
}

static sdr_status check_end(const char *path, const standing *then, const sdr_moment *moment)
{
  const double end = moment->end * (1.0 + 1e-12);
  if (moment->steps > 0 ? then->step <= moment->steps : then->time <= end) return SDR_OK;
  if (moment->scene->points.adapt && then->time <= end) return SDR_OK; /* steps get shorter */
  return sdr_fail(SDR_BAD_INPUT,
                  "%s is at t = %g s, past this run's end at t = %g s; give a later time.end", path,
                  then->time, moment->end);
}

static sdr_status read_file(sdr_hdf *file, const char *path, plan *p, const item items[ITEMS],
                            const sdr_moment *moment)
{
  SDR_TRY(check_items(file, path, items));
  for (int k = 0; k < p->count; ++k) SDR_TRY(read_block(file, path, &p->blocks[k]));
  return check_end(path, p->blocks[0].read, moment);
}

static void take_over(const plan *p, const standing *now, sdr_moment *moment)
{
  sdr_system *system = moment->system;
  for (int k = 0; k < p->count; ++k)
    memcpy(p->blocks[k].data, p->blocks[k].read, p->blocks[k].bytes);
  moment->time = system->time = now->time;
  moment->step = system->step = now->step;
  moment->step_size = now->step_size;
  system->velocity_offset = now->velocity_offset;
  system->external_work = now->external_work;
  system->viscous = now->viscous;
  system->refinement = now->refinement;
  system->time_since = now->time_since;
  system->step_since = now->step_since;
  if (moment->scene->points.adapt)
    moment->steps = sdr_steps_until(moment->end, system, moment->step_size);
  memcpy(system->impulse, now->impulse, sizeof now->impulse);
  memcpy(system->angular_impulse, now->angular_impulse, sizeof now->angular_impulse);
}

static sdr_status tell_observers(const sdr_moment *moment, sdr_observer *const *observers,
                                 int observer_count)
{
  SDR_TRY(sdr_rundir_reopen(moment->directory));
  for (int k = 0; k < observer_count; ++k)
    if (observers[k]->ops->resumed) SDR_TRY(observers[k]->ops->resumed(observers[k], moment));
  return SDR_OK;
}

/* HDF5 sees no file that is not as it was written. */
static sdr_status open_whole(const char *path, sdr_hdf **file)
{
  if (access(path, R_OK) == 0 && !sdr_seal_holds(path)) return fail_not_one(path);
  const sdr_status status = sdr_hdf_open(path, 0, file);
  return status == SDR_BAD_INPUT ? fail_not_whole(path) : status;
}

sdr_status sdr_checkpoint_read(const char *path, sdr_moment *moment, const char *instruction_set,
                               sdr_observer *const *observers, int observer_count)
{
  item items[ITEMS];
  plan p = {0};
  standing now;
  sdr_hdf *file = NULL;
  identify(items, moment, instruction_set);
  sdr_status status = open_whole(path, &file);
  if (status == SDR_OK) status = make_plan(&p, &now, moment->system, observers, observer_count);
  if (status == SDR_OK) status = read_file(file, path, &p, items, moment);
  sdr_hdf_discard(&file);
  if (status == SDR_OK) take_over(&p, &now, moment);
  plan_free(&p);
  return status == SDR_OK ? tell_observers(moment, observers, observer_count) : status;
}
