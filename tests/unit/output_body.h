/* A body for the tests of the output floor: few points, a model that says what the test wants, and
   a directory to write into. */
#ifndef SDR_TESTS_OUTPUT_BODY_H
#define SDR_TESTS_OUTPUT_BODY_H

#include "base/memory.h"
#include "output/observer.h"
#include "support/cmocka_all.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct {
  int32_t i, j;
  double damage;
} body_pair;

/* damage and history: one value a point; the model's state is `history`. */
typedef struct {
  sdr_model head;
  int pair_count;
  body_pair *pairs;
  double *damage, *history;
  sdr_energies energies;
  int field_calls;
} body_model;

typedef struct {
  char directory[64];
  sdr_points *points;
  body_model model;
  sdr_loads *loads;
  sdr_supports *supports;
  sdr_system *system;
  sdr_scene *scene;
  sdr_balance balance;
  sdr_moment moment;
} body;

static inline void body_visit(sdr_model *model, double *const u[3],
                              void (*visit)(void *, int32_t, int32_t, double), void *context)
{
  const body_model *m = (const body_model *)model;
  (void)u;
  for (int k = 0; k < m->pair_count; ++k)
    visit(context, m->pairs[k].i, m->pairs[k].j, m->pairs[k].damage);
}

/* Scalars are the damage; component k of a tensor at point i is 100 k + i. */
static inline sdr_status body_field(sdr_model *model, double *const u[3], sdr_model_field which,
                                    double *out)
{
  body_model *m = (body_model *)model;
  const int32_t count = model->points->count;
  const int components = model->points->components;
  (void)u;
  ++m->field_calls;
  if (which == SDR_FIELD_STRESS || which == SDR_FIELD_STRAIN) {
    for (int k = 0; k < components * (components + 1) / 2; ++k)
      for (int32_t i = 0; i < count; ++i) out[k * count + i] = 100.0 * k + i;
    return SDR_OK;
  }
  memcpy(out, m->damage, (size_t)count * sizeof *out);
  return SDR_OK;
}

static inline void body_energies(sdr_model *model, double *const u[3], sdr_energies *out)
{
  (void)u;
  *out = ((body_model *)model)->energies;
}

static inline void body_state(sdr_model *model, sdr_state_block *blocks, int *count)
{
  body_model *m = (body_model *)model;
  blocks[0] =
      (sdr_state_block){"history", m->history, (size_t)model->points->count * sizeof *m->history};
  *count = 1;
}

static const sdr_model_ops body_ops = {.name = "fake",
                                       .energies = body_energies,
                                       .field = body_field,
                                       .visit_damage = body_visit,
                                       .state = body_state};

/* Conditions and system, when the scene has all its supports; body_create does it once. */
static inline void body_wire(body *b)
{
  const double density[1] = {1.0};
  sdr_system_destroy(&b->system);
  sdr_loads_destroy(&b->loads);
  sdr_supports_destroy(&b->supports);
  assert_int_equal(sdr_loads_create(b->scene, b->points, &b->loads), SDR_OK);
  assert_int_equal(sdr_supports_create(b->scene, b->points, &b->supports), SDR_OK);
  assert_int_equal(sdr_system_create(&b->model.head, density, b->loads, b->supports, &b->system),
                   SDR_OK);
  b->moment.system = b->system;
}

/* `count` points along x, 1 m apart, of 1 kg, at rest; a moment at step 0 of 100 steps of 1 us. */
static inline void body_create(body *b, int32_t count, int components)
{
  memset(b, 0, sizeof *b);
  strcpy(b->directory, "sunder_output_XXXXXX");
  assert_non_null(mkdtemp(b->directory));
  assert_int_equal(sdr_points_create(count, components, 0, &b->points), SDR_OK);
  for (int32_t i = 0; i < count; ++i) {
    b->points->x[0][i] = i;
    b->points->volume[i] = 1.0;
    b->points->spacing[i] = 1.0;
    b->points->horizon[i] = 3.0;
  }
  b->model.head = (sdr_model){.ops = &body_ops, .points = b->points};
  b->model.damage = sdr_alloc((size_t)count, sizeof(double));
  b->model.history = sdr_alloc((size_t)count, sizeof(double));
  b->scene = calloc(1, sizeof *b->scene);
  b->scene->output.fragment_threshold = 0.5;
  b->scene->output.checkpoint_every = HUGE_VAL;
  b->moment = (sdr_moment){
      .scene = b->scene, .directory = b->directory, .step_size = 1e-6, .end = 100e-6, .steps = 100};
  body_wire(b);
}

static inline int body_remove(const char *path, const struct stat *status, int kind,
                              struct FTW *where)
{
  (void)status;
  (void)kind;
  (void)where;
  return remove(path);
}

static inline void body_destroy(body *b)
{
  sdr_system_destroy(&b->system);
  sdr_loads_destroy(&b->loads);
  sdr_supports_destroy(&b->supports);
  sdr_free(b->model.damage);
  sdr_free(b->model.history);
  free(b->model.pairs);
  free(b->scene);
  sdr_points_destroy(&b->points);
  nftw(b->directory, body_remove, 8, FTW_DEPTH | FTW_PHYS);
}

static inline void body_at(body *b, int64_t step)
{
  b->moment.step = b->system->step = step;
  b->moment.time = b->system->time = (double)step * b->moment.step_size;
  b->moment.last = step == b->moment.steps;
}

/* What the run's loop does at a step. */
static inline sdr_status body_show(body *b, sdr_observer *observer)
{
  int wants_balance = 0;
  if (!observer->ops->due(observer, &b->moment, &wants_balance)) return SDR_OK;
  b->moment.balance = wants_balance ? &b->balance : NULL;
  return observer->ops->look(observer, &b->moment);
}

static inline const char *body_path(const body *b, const char *name)
{
  static char path[128];
  snprintf(path, sizeof path, "%s/%s", b->directory, name);
  return path;
}

/* A file's text, for free(); NULL if there is none. */
static inline char *body_read(const body *b, const char *name)
{
  char *text = NULL;
  size_t room = 0;
  FILE *file = fopen(body_path(b, name), "r");
  if (!file) return NULL;
  if (getdelim(&text, &room, '\0', file) < 0) {
    free(text);
    text = strdup("");
  }
  fclose(file);
  return text;
}

static inline void body_write(const body *b, const char *name, const char *text)
{
  FILE *file = fopen(body_path(b, name), "w");
  assert_non_null(file);
  fputs(text, file);
  fclose(file);
}

static inline int body_has(const body *b, const char *name)
{
  return access(body_path(b, name), F_OK) == 0;
}

/* Run `work` in a process that may write files of at most `bytes`, as on a full disk; what it
   returns, 0 for success, must be below 128. */
static inline int body_with_full_disk(rlim_t bytes, int (*work)(void *), void *context)
{
  fflush(NULL);
  const pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) {
    const struct rlimit limit = {bytes, bytes};
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &limit);
    _exit(work(context));
  }
  int status = 0;
  assert_int_equal(waitpid(child, &status, 0), child);
  assert_true(WIFEXITED(status));
  return WEXITSTATUS(status);
}

#endif
