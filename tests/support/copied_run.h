/* A run that takes over the state of another one, as from a checkpoint. */
#ifndef SDR_TESTS_COPIED_RUN_H
#define SDR_TESTS_COPIED_RUN_H

#include "support/scene_text.h"

static inline void copy_blocks(const sdr_state_block *from, const sdr_state_block *to, int count)
{
  for (int b = 0; b < count; ++b) {
    assert_int_equal(from[b].bytes, to[b].bytes);
    memcpy(to[b].data, from[b].data, from[b].bytes);
  }
}

/* `to` was built from the same scene and not started. */
static inline void copy_run(const sdr_built *from, const sdr_built *to)
{
  sdr_system *a = from->system, *b = to->system;
  sdr_state_block source[SDR_STATE_BLOCKS], target[SDR_STATE_BLOCKS];
  int count = 0, other = 0;
  for (int c = 0; c < a->components; ++c) {
    memcpy(b->u[c], a->u[c], (size_t)a->count * sizeof(double));
    memcpy(b->v[c], a->v[c], (size_t)a->count * sizeof(double));
    memcpy(b->f[c], a->f[c], (size_t)a->count * sizeof(double));
  }
  b->time = a->time;
  b->step = a->step;
  b->velocity_offset = a->velocity_offset;
  b->external_work = a->external_work;
  b->viscous = a->viscous;
  memcpy(b->impulse, a->impulse, sizeof a->impulse);
  memcpy(b->angular_impulse, a->angular_impulse, sizeof a->angular_impulse);
  from->model->ops->state(from->model, source, &count);
  to->model->ops->state(to->model, target, &other);
  assert_int_equal(count, other);
  copy_blocks(source, target, count);
  sdr_system_state(a, source, &count);
  sdr_system_state(b, target, &other);
  copy_blocks(source, target, count);
}

static inline int same_state(const sdr_built *one, const sdr_built *other)
{
  const sdr_system *a = one->system, *b = other->system;
  int same = a->time == b->time && a->external_work == b->external_work;
  for (int c = 0; c < a->components; ++c) {
    const size_t bytes = (size_t)a->count * sizeof(double);
    same &= memcmp(a->u[c], b->u[c], bytes) == 0 && memcmp(a->v[c], b->v[c], bytes) == 0;
  }
  return same;
}

/* Half way a checkpoint: whoever goes on from a copy of it ends as who went on. */
static inline void assert_resumes(const char *scene, double half, double end)
{
  sdr_built whole, resumed;
  scene_build(&whole, "%s", scene);
  scene_build(&resumed, "%s", scene);
  run_start(&whole);
  while (whole.system->time < half) run_step(&whole);
  copy_run(&whole, &resumed);
  assert_int_equal(whole.integrator->restart(whole.system, whole.step), SDR_OK);
  assert_int_equal(resumed.integrator->restart(resumed.system, resumed.step), SDR_OK);
  while (whole.system->time < end) run_step(&whole);
  while (resumed.system->time < end) run_step(&resumed);
  assert_true(same_state(&whole, &resumed));
  sdr_built_destroy(&whole);
  sdr_built_destroy(&resumed);
}

/* Run to the end; the largest |energy - start - work| over the largest energy, looked at where less
   than `early` (s) does not count: the first steps of a sudden load have next to no energy. */
static inline double run_to_end(const sdr_built *built, double early)
{
  sdr_balance balance;
  double start, worst = 0.0, most;
  run_start(built);
  sdr_system_balance(built->system, &balance);
  most = start = balance_energy(&balance);
  while (built->system->time < built->scene->time.end) {
    run_step(built);
    sdr_system_balance(built->system, &balance);
    const double energy = balance_energy(&balance) + built->system->viscous;
    most = fmax(most, energy);
    if (built->system->time >= early)
      worst = fmax(worst, fabs(energy - start - built->system->external_work));
  }
  return worst / most;
}

/* Relative difference of displacements, root of sums of squares. */
static inline double apart(const sdr_system *a, const sdr_system *b)
{
  double over = 0.0, whole = 0.0;
  for (int c = 0; c < a->components; ++c)
    for (int32_t i = 0; i < a->count; ++i) {
      over += (a->u[c][i] - b->u[c][i]) * (a->u[c][i] - b->u[c][i]);
      whole += b->u[c][i] * b->u[c][i];
    }
  return sqrt(over / whole);
}

#endif
