#include "time/motion.h"

#include "base/memory.h"
#include "mechanics/schedule.h"

#include <math.h>
#include <string.h>

enum { SAMPLES = 5 };

struct sdr_motion {
  sdr_implicit *implicit;
  double from, until;  /* of the stretch */
  double first, last;  /* the moments inside it that its ends stand for */
  double at, rates_at; /* times of loads and positions; of rates. NAN: none */
  double *mass;        /* of q */
  int32_t *place;      /* an unknown: where it stands in q; -1: not there */
  /* An entry of the supports' list: where it is prescribed (NAN: not), how fast, how fast that
     changes; and what the supports say at some times (displacements, or velocities). */
  double *position, *rate, *bend, *sample[SAMPLES];
  int has_velocities;
  double *layer_rate; /* a' of the layers' components */
  double *raw;        /* the model's force on touched components before layers handed theirs on */
  double *slack[3];   /* displacements of layers where the body rests; a component each */
  double held[SDR_MOTION_RATES]; /* kinetic energy and momenta of prescribed components */
};

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
  for (int k = 0; k < SAMPLES; ++k) sdr_free(m->sample[k]);
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
  for (int k = 0; k < SAMPLES; ++k) failed |= !(m->sample[k] = sdr_alloc(held, sizeof(double)));
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

/* ---- functions of time ----------------------------------------------------------------------- */

static double inside(const sdr_motion *m, double t)
{
  return fmin(fmax(t, m->first), m->last);
}

/* Where prescribed components are at time t; velocities act from the system's time on. */
static sdr_status find_positions(sdr_motion *m, double t)
{
  static const double node[3] = {-0.7745966692414834, 0.0, 0.7745966692414834};
  static const double weight[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0}; /* Gauss */
  sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  const int32_t count = sdr_supports_count(system->supports);
  const double way = t - system->time;
  SDR_TRY(sdr_supports_values(system->supports, inside(m, t), m->position));
  if (!m->has_velocities) return SDR_OK;
  for (int32_t k = 0; k < count; ++k)
    if (list[k].is_velocity && !isnan(m->position[k])) m->position[k] = m->implicit->reached[k];
  for (int g = 0; g < 3; ++g) {
    const double then = system->time + 0.5 * way * (1.0 + node[g]);
    SDR_TRY(sdr_supports_values(system->supports, inside(m, then), m->sample[0]));
    for (int32_t k = 0; k < count; ++k)
      if (list[k].is_velocity && !isnan(m->position[k]))
        m->position[k] += weight[g] * way * m->sample[0][k];
  }
  return SDR_OK;
}

/* Weights of five values at -2h .. 2h for the first and second derivative, times h and h^2, of the
   polynomial through them at s h. */
static void difference_weights(double s, double first[SAMPLES], double second[SAMPLES])
{
  static const double factorial[SAMPLES] = {24.0, -6.0, 4.0, -6.0, 24.0};
  for (int k = 0; k < SAMPLES; ++k) {
    double others[SAMPLES - 1];
    int n = 0;
    for (int j = 0; j < SAMPLES; ++j)
      if (j != k) others[n++] = s - (j - 2);
    first[k] = second[k] = 0.0;
    for (int a = 0; a < 4; ++a) {
      double product = 1.0;
      for (int b = 0; b < 4; ++b)
        if (b != a) product *= others[b];
      first[k] += product / factorial[k];
      for (int b = 0; b < 4; ++b) {
        double pair = 1.0;
        for (int c = 0; c < 4; ++c)
          if (c != a && c != b) pair *= others[c];
        if (b != a) second[k] += pair / factorial[k];
      }
    }
  }
}

/* Five times about t within the stretch, h apart; t is s h from the middle one. */
static double choose_times(const sdr_motion *m, double t, double time[SAMPLES], double *s)
{
  const double h =
      fmin(fmax(1e-4 * (m->last - m->first), 1e-8 * fabs(t)), 0.25 * (m->last - m->first));
  const double middle = fmin(fmax(t, m->first + 2.0 * h), m->last - 2.0 * h);
  for (int k = 0; k < SAMPLES; ++k) time[k] = inside(m, middle + (k - 2) * h);
  *s = (t - middle) / h;
  return h;
}

static sdr_status find_support_rates(sdr_motion *m, double t)
{
  sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  double time[SAMPLES], first[SAMPLES], second[SAMPLES], s;
  const double h = choose_times(m, inside(m, t), time, &s);
  difference_weights(s, first, second);
  for (int n = 0; n < SAMPLES; ++n)
    SDR_TRY(sdr_supports_values(system->supports, time[n], m->sample[n]));
  SDR_TRY(sdr_supports_values(system->supports, inside(m, t), m->rate));
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    double slope = 0.0, bend = 0.0;
    /* differences from the value here: a constant has none at all */
    for (int n = 0; n < SAMPLES; ++n) {
      slope += first[n] * (m->sample[n][k] - m->rate[k]) / h;
      bend += second[n] * (m->sample[n][k] - m->rate[k]) / (h * h);
    }
    m->bend[k] = list[k].is_velocity ? slope : bend;
    if (!list[k].is_velocity) m->rate[k] = slope;
  }
  return SDR_OK;
}

/* a' of layers, from where they stand at five times if the body rests. */
static sdr_status find_layer_rates(sdr_motion *m, double t)
{
  sdr_system *system = m->implicit->system;
  sdr_layers *layers = system->layers;
  const int components = system->components;
  const int32_t count = sdr_layers_count(layers), *points = sdr_layers_points(layers);
  double time[SAMPLES], first[SAMPLES], second[SAMPLES], s;
  const double h = choose_times(m, inside(m, t), time, &s);
  difference_weights(s, first, second);
  memset(m->layer_rate, 0, (size_t)(count * components) * sizeof(double));
  for (int n = 0; n < SAMPLES; ++n) {
    SDR_TRY(sdr_layers_values(layers, time[n]));
    sdr_layers_follow(layers, m->slack);
    for (int32_t k = 0; k < count; ++k)
      for (int a = 0; a < components; ++a)
        m->layer_rate[k * components + a] += first[n] * m->slack[a][points[k]] / h;
  }
  return sdr_layers_values(layers, inside(m, m->at));
}

static sdr_status find_rates(sdr_motion *m, double t)
{
  if (m->rates_at == t) return SDR_OK;
  sdr_system *system = m->implicit->system;
  m->rates_at = NAN;
  if (sdr_supports_count(system->supports) > 0) SDR_TRY(find_support_rates(m, t));
  if (system->layers) SDR_TRY(find_layer_rates(m, t));
  m->rates_at = t;
  return SDR_OK;
}

static sdr_status stand_at(sdr_motion *m, double t)
{
  sdr_system *system = m->implicit->system;
  if (m->at == t) return SDR_OK;
  m->at = NAN;
  SDR_TRY(sdr_loads_evaluate(system->loads, inside(m, t)));
  if (sdr_supports_count(system->supports) > 0) SDR_TRY(find_positions(m, t));
  if (system->layers) SDR_TRY(sdr_layers_values(system->layers, inside(m, t)));
  m->at = t;
  return SDR_OK;
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
static void spread(const sdr_motion *m, const double *from, double *const to[3])
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
    if (!isnan(m->position[k])) system->u[list[k].component][list[k].point] = m->position[k];
  if (system->layers) sdr_layers_follow(system->layers, system->u);
}

sdr_status sdr_motion_place(sdr_motion *motion, double t, const double *q)
{
  SDR_TRY(stand_at(motion, t));
  spread(motion, q, motion->implicit->system->u);
  put_positions(motion);
  return SDR_OK;
}

/* Velocities of prescribed components and layers, where free ones have theirs. */
static void put_velocities(const sdr_motion *m)
{
  sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  const int components = system->components;
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    if (!isnan(m->position[k])) system->v[list[k].component][list[k].point] = m->rate[k];
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
}

/* ---- what comes from outside ----------------------------------------------------------------- */

int sdr_motion_driven(const sdr_motion *motion)
{
  const sdr_system *system = motion->implicit->system;
  return sdr_loads_count(system->loads) > 0 || sdr_supports_count(system->supports) > 0 ||
         system->layers != NULL;
}

/* Add a force on component a of point i that does work at `velocity` to the rates. */
static void add_force(const sdr_system *system, int32_t i, int a, double force, double velocity,
                      double rates[SDR_MOTION_RATES])
{
  double x[3] = {0.0};
  for (int c = 0; c < system->components; ++c)
    x[c] = system->model->points->x[c][i] + system->u[c][i];
  const int b = (a + 1) % 3, c = (a + 2) % 3;
  rates[0] += force * velocity;
  rates[1 + a] += force;
  rates[4 + b] += x[c] * force;
  rates[4 + c] -= x[b] * force;
}

static void add_loads(const sdr_motion *m, double rates[SDR_MOTION_RATES])
{
  const sdr_system *system = m->implicit->system;
  const int32_t *loaded = sdr_loads_points(system->loads);
  const uint8_t *prescribed = sdr_motion_constraints(m)->prescribed;
  for (int32_t k = 0; k < sdr_loads_count(system->loads); ++k)
    for (int a = 0; a < system->components; ++a) {
      if (prescribed[loaded[k] * system->components + a]) continue; /* the support bears it */
      add_force(system, loaded[k], a, sdr_loads_force(system->loads, a)[k], system->v[a][loaded[k]],
                rates);
    }
}

/* A support balances the model's force; what the prescribed mass takes up is a difference of
   states, but for the part of its moment that turns with it: d(x cross m v) = x cross F dt + v
   cross m v dt.
 */
static void add_supports(const sdr_motion *m, double rates[SDR_MOTION_RATES])
{
  const sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    const int a = list[k].component, b = (a + 1) % 3, c = (a + 2) % 3;
    const int32_t i = list[k].point;
    if (isnan(m->position[k])) continue;
    double v[3] = {0.0};
    for (int n = 0; n < system->components; ++n) v[n] = system->v[n][i];
    add_force(system, i, a, -system->f[a][i], m->rate[k], rates);
    rates[4 + b] -= system->mass[i] * v[c] * v[a];
    rates[4 + c] += system->mass[i] * v[b] * v[a];
  }
}

/* What layers hand on comes from outside, and so does what keeps them on their way. Where a support
   prescribes the point that is handed something, it bears that. */
static void add_layers(const sdr_motion *m, double rates[SDR_MOTION_RATES])
{
  const sdr_system *system = m->implicit->system;
  const int components = system->components;
  const int32_t *touched = sdr_layers_touched(system->layers);
  for (int32_t k = 0; k < sdr_layers_touched_count(system->layers); ++k)
    for (int a = 0; a < components; ++a) {
      const int32_t i = touched[k];
      const double change = system->f[a][i] - m->raw[k * components + a];
      add_force(system, i, a, change, system->v[a][i], rates);
    }
}

sdr_status sdr_motion_outside(sdr_motion *motion, double t, const double *w,
                              double rates[SDR_MOTION_RATES])
{
  sdr_system *system = motion->implicit->system;
  memset(rates, 0, SDR_MOTION_RATES * sizeof *rates);
  SDR_TRY(find_rates(motion, t));
  spread(motion, w, system->v);
  put_velocities(motion);
  add_loads(motion, rates);
  add_supports(motion, rates);
  if (system->layers) add_layers(motion, rates);
  return SDR_OK;
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
  return SDR_OK;
}

/* What prescribed components hold of kinetic energy and momenta. */
static void sum_held(const sdr_motion *m, double sum[SDR_MOTION_RATES])
{
  const sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  memset(sum, 0, SDR_MOTION_RATES * sizeof *sum);
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    if (isnan(m->position[k])) continue;
    const double p = system->mass[list[k].point] * m->rate[k];
    add_force(system, list[k].point, list[k].component, p, 0.5 * m->rate[k], sum);
  }
}

/* Into the system's books. */
static void book(sdr_system *system, const double change[SDR_MOTION_RATES])
{
  system->external_work += change[0];
  for (int a = 0; a < 3; ++a) {
    system->impulse[a] += change[1 + a];
    system->angular_impulse[a] += change[4 + a];
  }
}

static void sum_body(sdr_system *system, double sum[SDR_MOTION_RATES])
{
  sdr_balance balance;
  sdr_system_balance(system, &balance);
  sum[0] = balance.kinetic + balance.model.stored + balance.model.dissipated;
  for (int a = 0; a < 3; ++a) {
    sum[1 + a] = balance.momentum[a];
    sum[4 + a] = balance.angular[a];
  }
}

/* 1 if a prescribed component or layer is elsewhere, or faster, than it should be. */
static int is_jump(const sdr_motion *m)
{
  const sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    if (!isnan(m->position[k]) && (m->position[k] != system->u[list[k].component][list[k].point] ||
                                   m->rate[k] != system->v[list[k].component][list[k].point]))
      return 1;
  return system->layers != NULL;
}

sdr_status sdr_motion_jump(sdr_motion *motion, int silent)
{
  sdr_system *system = motion->implicit->system;
  double before[SDR_MOTION_RATES], after[SDR_MOTION_RATES];
  SDR_TRY(stand_at(motion, system->time));
  SDR_TRY(find_rates(motion, system->time));
  const int jumps = is_jump(motion), books = jumps && !silent;
  if (books) sum_body(system, before);
  put_positions(motion);
  put_velocities(motion);
  if (jumps || silent) system->model->ops->commit(system->model, system->u);
  if (books) sum_body(system, after);
  for (int k = 0; books && k < SDR_MOTION_RATES; ++k) after[k] -= before[k];
  if (books) book(system, after);
  sdr_implicit_accept(motion->implicit);
  motion->at = NAN; /* velocities act from here on */
  SDR_TRY(stand_at(motion, system->time));
  sum_held(motion, motion->held);
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
    const double total = system->mass[list[k].point] * m->bend[k];
    system->reaction[k] = total - *f;
    *f = total;
  }
  spread(m, g, system->f);
}

sdr_status sdr_motion_accept(sdr_motion *motion, double t, const double *q, const double *w,
                             const double *g, const double outside[SDR_MOTION_RATES])
{
  sdr_system *system = motion->implicit->system;
  double held[SDR_MOTION_RATES], change[SDR_MOTION_RATES];
  SDR_TRY(sdr_motion_place(motion, t, q));
  SDR_TRY(find_rates(motion, t));
  spread(motion, w, system->v);
  put_velocities(motion);
  put_forces(motion, g);
  sum_held(motion, held);
  for (int k = 0; k < SDR_MOTION_RATES; ++k) {
    change[k] = outside[k] + held[k] - motion->held[k];
    motion->held[k] = held[k];
  }
  book(system, change);
  system->velocity_offset = 0.0;
  system->time = t;
  ++system->step;
  system->model->ops->commit(system->model, system->u);
  sdr_implicit_accept(motion->implicit);
  return SDR_OK;
}

sdr_status sdr_motion_show(sdr_motion *motion)
{
  const int32_t count = sdr_motion_constraints(motion)->free;
  double *g = sdr_alloc((size_t)count, sizeof *g);
  if (!g) return SDR_RUN_FAILED;
  const sdr_status status = stand_at(motion, motion->implicit->system->time);
  if (status == SDR_OK) {
    sdr_motion_force(motion, g);
    put_forces(motion, g);
  }
  sdr_free(g);
  return status;
}
