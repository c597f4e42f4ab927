#include "time/motion_internal.h"

#include "base/memory.h"
#include "mechanics/schedule.h"

#include <math.h>
#include <string.h>

/* ---- creation -------------------------------------------------------------------------------- */

void sdr_motion_destroy(sdr_motion **motion)
{
  sdr_motion *m = *motion;
  if (!m) return;
  sdr_implicit_destroy(&m->implicit);
  sdr_free(m->mass);
  sdr_free(m->place);
  sdr_free(m->position);
  sdr_free(m->rate);
  sdr_free(m->bend);
  for (int k = 0; k < SDR_MOTION_SAMPLES; ++k) sdr_free(m->sample[k]);
  sdr_free(m->mean_first);
  sdr_free(m->mean_entry);
  sdr_free(m->mean_place);
  sdr_free(m->mean_pull);
  sdr_free(m->layer_rate);
  sdr_free(m->raw);
  for (int a = 0; a < 3; ++a) sdr_free(m->slack[a]);
  sdr_free(m);
  *motion = NULL;
}

static sdr_status alloc_parts(sdr_motion *m, const sdr_system *system)
{
  const size_t held = (size_t)sdr_supports_count(system->supports);
  const size_t components = (size_t)system->components;
  const size_t unknowns = (size_t)system->count * components;
  int failed = !(m->mass = sdr_alloc(unknowns, sizeof(double)));
  failed |= !(m->place = sdr_alloc(unknowns, sizeof *m->place));
  failed |= !(m->position = sdr_alloc(held, sizeof(double)));
  failed |= !(m->rate = sdr_alloc(held, sizeof(double)));
  failed |= !(m->bend = sdr_alloc(held, sizeof(double)));
  for (int k = 0; k < SDR_MOTION_SAMPLES; ++k)
    failed |= !(m->sample[k] = sdr_alloc(held, sizeof(double)));
  if (system->layers) {
    const size_t layers = (size_t)sdr_layers_count(system->layers);
    const size_t touched = (size_t)sdr_layers_touched_count(system->layers);
    failed |= !(m->layer_rate = sdr_alloc(components * layers, sizeof(double)));
    failed |= !(m->raw = sdr_alloc(components * touched, sizeof(double)));
    for (size_t a = 0; a < components; ++a)
      failed |=
          !(m->slack[a] = sdr_alloc(sdr_points_padded(system->model->points), sizeof(double)));
  }
  return failed ? SDR_RUN_FAILED : SDR_OK;
}

sdr_status sdr_motion_create(sdr_system *system, sdr_motion **out)
{
  sdr_motion *m = sdr_alloc(1, sizeof *m);
  if (!m) return SDR_RUN_FAILED;
  sdr_status status = alloc_parts(m, system);
  if (status == SDR_OK) status = sdr_implicit_create(system, &m->implicit);
  if (status == SDR_OK) {
    m->implicit->free_means = 1;
    status = sdr_motion_make_means(m);
  }
  if (status == SDR_OK)
    *out = m;
  else
    sdr_motion_destroy(&m);
  return status;
}

double sdr_motion_until(const sdr_motion *motion)
{
  return motion->until;
}

const sdr_constraints *sdr_motion_constraints(const sdr_motion *motion)
{
  return &motion->implicit->constraints;
}

const double *sdr_motion_mass(const sdr_motion *motion)
{
  return motion->mass;
}

/* ---- states ---------------------------------------------------------------------------------- */

void sdr_motion_take(const sdr_motion *motion, double *q, double *w)
{
  const sdr_system *system = motion->implicit->system;
  const sdr_constraints *c = sdr_motion_constraints(motion);
  const int m = system->components;
  for (int32_t k = 0; k < c->free; ++k) {
    q[k] = system->u[c->unknown[k] % m][c->unknown[k] / m];
    w[k] = system->v[c->unknown[k] % m][c->unknown[k] / m];
  }
}

/* to[component][point] = from[k] at the free components. */
void sdr_motion_spread(const sdr_motion *m, const double *from, double *const to[3])
{
  const sdr_constraints *c = sdr_motion_constraints(m);
  const int components = m->implicit->system->components;
  if (components == 2 && c->free == c->unknowns) {
    for (int32_t i = 0; i < c->free / 2; ++i) {
      to[0][i] = from[2 * i];
      to[1][i] = from[2 * i + 1];
    }
    return;
  }
  for (int32_t k = 0; k < c->free; ++k)
    to[c->unknown[k] % components][c->unknown[k] / components] = from[k];
}

static void put_positions(const sdr_motion *m)
{
  sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    if (list[k].mean < 0 && !isnan(m->position[k]))
      system->u[list[k].component][list[k].point] = m->position[k];
  sdr_motion_shift_means(m, m->position, system->u);
  if (system->layers) sdr_layers_follow(system->layers, system->u);
}

sdr_status sdr_motion_place(sdr_motion *motion, double t, const double *q)
{
  SDR_TRY(sdr_motion_stand(motion, t));
  if (sdr_motion_means(motion) > 0) SDR_TRY(sdr_motion_find_rates(motion, t));
  sdr_motion_spread(motion, q, motion->implicit->system->u);
  put_positions(motion);
  return SDR_OK;
}

/* Velocities of prescribed components and layers, where free ones have theirs. */
void sdr_motion_put_velocities(const sdr_motion *m)
{
  sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  const int components = system->components;
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    if (list[k].mean < 0 && !isnan(m->position[k]))
      system->v[list[k].component][list[k].point] = m->rate[k];
  sdr_motion_shift_means(m, m->rate, system->v);
  if (!system->layers) return;
  const int32_t *points = sdr_layers_points(system->layers);
  sdr_layers_extend(system->layers, SDR_LAYER_MOTION, system->v);
  for (int32_t k = 0; k < sdr_layers_count(system->layers); ++k)
    for (int a = 0; a < components; ++a)
      system->v[a][points[k]] += m->layer_rate[k * components + a];
}

/* ---- forces ---------------------------------------------------------------------------------- */

static void hand_on(sdr_motion *m)
{
  sdr_system *system = m->implicit->system;
  const int components = system->components;
  const int32_t *touched = sdr_layers_touched(system->layers);
  for (int32_t k = 0; k < sdr_layers_touched_count(system->layers); ++k)
    for (int a = 0; a < components; ++a) m->raw[k * components + a] = system->f[a][touched[k]];
  sdr_layers_pull(system->layers, system->f);
}

void sdr_motion_force(sdr_motion *motion, double *g)
{
  sdr_system *system = motion->implicit->system;
  const sdr_constraints *c = sdr_motion_constraints(motion);
  const int components = system->components;
  system->model->ops->force(system->model, system->u, system->f);
  if (system->layers) hand_on(motion);
  for (int32_t k = 0; k < c->free; ++k)
    g[k] = system->f[c->unknown[k] % components][c->unknown[k] / components];
  const int32_t *loaded = sdr_loads_points(system->loads);
  for (int32_t k = 0; k < sdr_loads_count(system->loads); ++k)
    for (int a = 0; a < components; ++a) {
      const int32_t place = motion->place[loaded[k] * components + a];
      if (place >= 0) g[place] += sdr_loads_force(system->loads, a)[k];
    }
  sdr_motion_pull_means(motion, g);
}

/* ---- stretches ------------------------------------------------------------------------------- */

static void number(sdr_motion *m)
{
  const sdr_constraints *c = sdr_motion_constraints(m);
  for (int32_t r = 0; r < c->unknowns; ++r) m->place[r] = -1;
  for (int32_t k = 0; k < c->free; ++k) {
    m->place[c->unknown[k]] = k;
    m->mass[k] = m->implicit->mass[c->unknown[k]];
  }
}

sdr_status sdr_motion_begin(sdr_motion *motion, double end, int *renumbered)
{
  sdr_implicit *implicit = motion->implicit;
  const sdr_system *system = implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  const double event = sdr_implicit_next_event(implicit, system->time);
  motion->from = system->time;
  motion->until = fmin(event, end);
  motion->first = motion->from * (1.0 + 4.0 * SDR_TIME_SLACK);
  motion->last = fmax(motion->until * (1.0 - 4.0 * SDR_TIME_SLACK), motion->first);
  motion->at = motion->rates_at = NAN;
  SDR_TRY(sdr_implicit_move(implicit, motion->first, renumbered));
  number(motion);
  motion->has_velocities = 0;
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    motion->has_velocities |= list[k].is_velocity;
  sdr_implicit_accept(implicit);
  return sdr_motion_number_means(motion);
}

/* 1 if a prescribed component or layer is elsewhere, or faster, than it should be. */
static int is_jump(const sdr_motion *m)
{
  const sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    if (list[k].mean < 0 && !isnan(m->position[k]) &&
        (m->position[k] != system->u[list[k].component][list[k].point] ||
         m->rate[k] != system->v[list[k].component][list[k].point]))
      return 1;
  return system->layers != NULL || sdr_motion_means(m) > 0;
}

sdr_status sdr_motion_jump(sdr_motion *motion, int silent)
{
  sdr_system *system = motion->implicit->system;
  double before[SDR_MOTION_RATES], after[SDR_MOTION_RATES];
  SDR_TRY(sdr_motion_stand(motion, system->time));
  SDR_TRY(sdr_motion_find_rates(motion, system->time));
  const int jumps = is_jump(motion), books = jumps && !silent;
  if (books) sdr_motion_sum_body(system, before);
  put_positions(motion);
  sdr_motion_put_velocities(motion);
  if (jumps || silent) system->model->ops->commit(system->model, system->u);
  if (books) sdr_motion_sum_body(system, after);
  for (int k = 0; books && k < SDR_MOTION_RATES; ++k) after[k] -= before[k];
  if (books) sdr_motion_book(system, after);
  sdr_implicit_accept(motion->implicit);
  motion->at = NAN; /* velocities act from here on */
  SDR_TRY(sdr_motion_stand(motion, system->time));
  sdr_motion_sum_held(motion, motion->held);
  motion->flags = sdr_motion_flags(motion);
  motion->broke = 0;
  return SDR_OK;
}

/* ---- accepting ------------------------------------------------------------------------------- */

/* Total forces at the system's time, and what supports add to the model's and the loads'. */
static void put_forces(sdr_motion *m, const double *g)
{
  sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  const int32_t *loaded = sdr_loads_points(system->loads);
  for (int32_t k = 0; k < sdr_loads_count(system->loads); ++k)
    for (int a = 0; a < system->components; ++a) {
      system->load_before[a][k] = sdr_loads_force(system->loads, a)[k];
      system->f[a][loaded[k]] += system->load_before[a][k];
    }
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    double *const f = &system->f[list[k].component][list[k].point];
    system->reaction[k] = 0.0;
    if (isnan(m->position[k])) continue;
    if (list[k].mean >= 0) {
      system->reaction[k] = m->mean_pull[list[k].mean];
      continue;
    }
    const double total = system->mass[list[k].point] * m->bend[k];
    system->reaction[k] = total - *f;
    *f = total;
  }
  sdr_motion_spread(m, g, system->f);
}

sdr_status sdr_motion_accept(sdr_motion *motion, double t, const double *q, const double *w,
                             const double *g, const double outside[SDR_MOTION_RATES])
{
  sdr_system *system = motion->implicit->system;
  double held[SDR_MOTION_RATES], change[SDR_MOTION_RATES];
  SDR_TRY(sdr_motion_place(motion, t, q));
  SDR_TRY(sdr_motion_find_rates(motion, t));
  sdr_motion_spread(motion, w, system->v);
  sdr_motion_put_velocities(motion);
  put_forces(motion, g);
  sdr_motion_sum_held(motion, held);
  for (int k = 0; k < SDR_MOTION_RATES; ++k) {
    change[k] = outside[k] + held[k] - motion->held[k];
    motion->held[k] = held[k];
  }
  sdr_motion_book(system, change);
  system->velocity_offset = 0.0;
  system->time = t;
  ++system->step;
  system->model->ops->commit(system->model, system->u);
  const uint64_t flags = sdr_motion_flags(motion);
  motion->broke = flags != motion->flags;
  motion->flags = flags;
  sdr_implicit_accept(motion->implicit);
  return SDR_OK;
}

int sdr_motion_broke(const sdr_motion *motion)
{
  return motion->broke;
}

sdr_status sdr_motion_show(sdr_motion *motion)
{
  const int32_t count = sdr_motion_constraints(motion)->free;
  double *g = sdr_alloc((size_t)count, sizeof *g);
  if (!g) return SDR_RUN_FAILED;
  const sdr_status status = sdr_motion_stand(motion, motion->implicit->system->time);
  if (status == SDR_OK) {
    sdr_motion_force(motion, g);
    put_forces(motion, g);
  }
  sdr_free(g);
  return status;
}
