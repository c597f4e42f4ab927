#include "mechanics/system.h"

#include "base/memory.h"
#include "base/parallel.h"

#include <math.h>
#include <string.h>

static int alloc_state(sdr_system *system, size_t padded)
{
  int failed = !(system->mass = sdr_alloc(padded, sizeof(double)));
  for (int a = 0; a < system->components; ++a) {
    failed |= !(system->u[a] = sdr_alloc(padded, sizeof(double)));
    failed |= !(system->v[a] = sdr_alloc(padded, sizeof(double)));
    failed |= !(system->f[a] = sdr_alloc(padded, sizeof(double)));
  }
  return failed;
}

static int alloc_conditions(sdr_system *system)
{
  const size_t loaded = (size_t)sdr_loads_count(system->loads);
  const size_t held = (size_t)sdr_supports_count(system->supports);
  int failed = 0;
  for (int a = 0; a < system->components; ++a)
    failed |= !(system->load_before[a] = sdr_alloc(loaded, sizeof(double)));
  failed |= !(system->reaction = sdr_alloc(held, sizeof(double)));
  failed |= !(system->motion = sdr_alloc(held, sizeof(double)));
  failed |= !(system->next_motion = sdr_alloc(held, sizeof(double)));
  return failed;
}

sdr_status sdr_system_create(sdr_model *model, const double *density, sdr_loads *loads,
                             sdr_supports *supports, sdr_system **out)
{
  sdr_system *system = sdr_alloc(1, sizeof *system);
  if (!system) return SDR_RUN_FAILED;
  const sdr_points *points = model->points;
  system->count = points->count;
  system->components = points->components;
  system->model = model;
  system->loads = loads;
  system->supports = supports;
  if (alloc_state(system, sdr_points_padded(points)) || alloc_conditions(system)) {
    sdr_system_destroy(&system);
    return SDR_RUN_FAILED;
  }
  for (int32_t i = 0; i < points->count; ++i)
    system->mass[i] = density[points->material[i]] * points->volume[i];
  *out = system;
  return SDR_OK;
}

sdr_status sdr_system_attach(sdr_system *system, sdr_layers *layers)
{
  if (!layers) return SDR_OK;
  const size_t n = (size_t)system->components;
  system->layers = layers;
  system->layer_u = sdr_alloc(n * (size_t)sdr_layers_count(layers), sizeof(double));
  const size_t touched = n * (size_t)sdr_layers_touched_count(layers);
  system->layer_pull = sdr_alloc(touched, sizeof(double));
  system->layer_scratch = sdr_alloc(touched, sizeof(double));
  return system->layer_u && system->layer_pull && system->layer_scratch ? SDR_OK : SDR_RUN_FAILED;
}

void sdr_system_destroy(sdr_system **system)
{
  sdr_system *s = *system;
  if (!s) return;
  if (s->work) s->end_work(s->work);
  for (int a = 0; a < 3; ++a) {
    sdr_free(s->u[a]);
    sdr_free(s->v[a]);
    sdr_free(s->f[a]);
    sdr_free(s->load_before[a]);
  }
  sdr_free(s->mass);
  sdr_free(s->reaction);
  sdr_free(s->motion);
  sdr_free(s->next_motion);
  sdr_free(s->layer_u);
  sdr_free(s->layer_pull);
  sdr_free(s->layer_scratch);
  sdr_free(s);
  *system = NULL;
}

/* ---- what acts from outside ------------------------------------------------------------------ */

/* Book a force on point i over the step of length dt that led to the present positions: `before`
   and `now` at its ends. v is the step's velocity, so dt v is the way. */
static void book(sdr_system *system, int32_t i, const double before[3], const double now[3],
                 double dt)
{
  const double *const *x = (const double *const *)system->model->points->x;
  double here[3] = {0.0}, there[3] = {0.0};
  for (int a = 0; a < system->components; ++a) {
    const double way = dt * system->v[a][i];
    here[a] = x[a][i] + system->u[a][i];
    there[a] = here[a] - way;
    system->external_work += 0.5 * (before[a] + now[a]) * way;
    system->impulse[a] += 0.5 * dt * (before[a] + now[a]);
  }
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    system->angular_impulse[c] +=
        0.5 * dt *
        (there[a] * before[b] - there[b] * before[a] + here[a] * now[b] - here[b] * now[a]);
  }
}

static sdr_status add_loads(sdr_system *system, double dt)
{
  SDR_TRY(sdr_loads_evaluate(system->loads, system->time));
  const int32_t *loaded = sdr_loads_points(system->loads);
  for (int32_t k = 0; k < sdr_loads_count(system->loads); ++k) {
    double before[3] = {0.0}, now[3] = {0.0};
    for (int a = 0; a < system->components; ++a) {
      before[a] = system->load_before[a][k];
      now[a] = sdr_loads_force(system->loads, a)[k];
      system->load_before[a][k] = now[a];
      system->f[a][loaded[k]] += now[a];
    }
    if (dt > 0.0) book(system, loaded[k], before, now, dt);
  }
  return SDR_OK;
}

/* Velocities prescribed for the step from the present time on, into system->motion; NAN: free. */
static sdr_status prescribed_velocities(sdr_system *system, double dt_next)
{
  const int32_t count = sdr_supports_count(system->supports);
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  SDR_TRY(sdr_supports_values(system->supports, system->time + 0.5 * dt_next, system->motion));
  SDR_TRY(sdr_supports_values(system->supports, system->time + dt_next, system->next_motion));
  for (int32_t k = 0; k < count; ++k) {
    if (list[k].is_velocity) continue;
    const double u = system->u[list[k].component][list[k].point];
    system->motion[k] = (system->next_motion[k] - u) / dt_next;
  }
  return SDR_OK;
}

/* Forces that bring the means to their velocities, the same on every point of one, in place of the
   next motion of its entries. */
static void find_pulls(sdr_system *system, double kick)
{
  const int32_t count = sdr_supports_count(system->supports);
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int mean = 0; mean < sdr_supports_means(system->supports); ++mean) {
    double missing = 0.0, by_mass = 0.0;
    for (int32_t k = 0; k < count; ++k) {
      if (list[k].mean != mean || isnan(system->motion[k])) continue;
      const int a = list[k].component;
      const int32_t i = list[k].point;
      missing += system->motion[k] - system->v[a][i] - kick * system->f[a][i] / system->mass[i];
      by_mass += 1.0 / system->mass[i];
    }
    for (int32_t k = 0; k < count; ++k)
      if (list[k].mean == mean) system->next_motion[k] = missing / (kick * by_mass);
  }
}

static sdr_status hold_supports(sdr_system *system, double dt, double dt_next, double kick)
{
  const int32_t count = sdr_supports_count(system->supports);
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  if (count == 0) return SDR_OK;
  SDR_TRY(prescribed_velocities(system, dt_next));
  find_pulls(system, kick);
  for (int32_t k = 0; k < count; ++k) {
    const int a = list[k].component;
    const int32_t i = list[k].point;
    double before[3] = {0.0}, now[3] = {0.0};
    before[a] = system->reaction[k];
    if (list[k].mean >= 0 && !isnan(system->motion[k])) {
      now[a] = system->next_motion[k];
      system->f[a][i] += now[a];
    } else if (!isnan(system->motion[k])) {
      const double total = system->mass[i] * (system->motion[k] - system->v[a][i]) / kick;
      now[a] = total - system->f[a][i];
      system->f[a][i] = total;
    }
    system->reaction[k] = now[a];
    if (dt > 0.0 && (before[a] != 0.0 || now[a] != 0.0)) book(system, i, before, now, dt);
  }
  return SDR_OK;
}

/* Bring the layers' points to the present time; their velocity is that of the step of length dt, at
   the start that of the points they follow. */
static sdr_status follow_layers(sdr_system *system, double dt)
{
  const int32_t count = sdr_layers_count(system->layers);
  const int32_t *points = sdr_layers_points(system->layers);
  SDR_TRY(sdr_layers_values(system->layers, system->time));
  sdr_layers_follow(system->layers, system->u);
  if (!(dt > 0.0)) sdr_layers_extend(system->layers, SDR_LAYER_MOTION, system->v);
  for (int32_t k = 0; k < count; ++k)
    for (int a = 0; a < system->components; ++a) {
      double *const before = &system->layer_u[k * system->components + a];
      const double now = system->u[a][points[k]];
      if (dt > 0.0) system->v[a][points[k]] = (now - *before) / dt;
      *before = now;
    }
  return SDR_OK;
}

/* Forces on layers go to the points they act on. What that takes and gives comes from outside: it
   is booked like a load on every point that it changes. */
static void pull_layers(sdr_system *system, double dt)
{
  const int32_t count = sdr_layers_touched_count(system->layers), n = system->components;
  const int32_t *touched = sdr_layers_touched(system->layers);
  double *const pull = system->layer_pull, *const own = system->layer_scratch;
  for (int32_t k = 0; k < count; ++k)
    for (int a = 0; a < n; ++a) own[k * n + a] = system->f[a][touched[k]];
  sdr_layers_pull(system->layers, system->f);
  for (int32_t k = 0; k < count; ++k) {
    double before[3] = {0.0}, now[3] = {0.0};
    for (int a = 0; a < n; ++a) {
      before[a] = pull[k * n + a];
      now[a] = pull[k * n + a] = system->f[a][touched[k]] - own[k * n + a];
    }
    if (dt > 0.0) book(system, touched[k], before, now, dt);
  }
}

double sdr_system_mean(const sdr_system *system, int mean, double *const from[3])
{
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  double sum = 0.0;
  int32_t points = 0;
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    if (list[k].mean != mean) continue;
    sum += from[list[k].component][list[k].point];
    ++points;
  }
  return points > 0 ? sum / points : 0.0;
}

/* Means at t = 0: their points keep what differs from the mean. */
static void start_means(sdr_system *system, double dt)
{
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int mean = 0; mean < sdr_supports_means(system->supports); ++mean) {
    const double u = sdr_system_mean(system, mean, system->u);
    const double v = sdr_system_mean(system, mean, system->v);
    for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
      if (list[k].mean != mean || isnan(system->motion[k])) continue;
      const int a = list[k].component;
      const double ahead = system->next_motion[k] - system->motion[k];
      const double rate = isnan(ahead) ? 0.0 : ahead / dt;
      system->v[a][list[k].point] += (list[k].is_velocity ? system->motion[k] : rate) - v;
      if (!list[k].is_velocity) system->u[a][list[k].point] += system->motion[k] - u;
    }
  }
}

sdr_status sdr_system_start(sdr_system *system, double dt)
{
  const int32_t count = sdr_supports_count(system->supports);
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  if (count == 0) return SDR_OK;
  SDR_TRY(sdr_supports_values(system->supports, 0.0, system->motion));
  SDR_TRY(sdr_supports_values(system->supports, dt, system->next_motion));
  for (int32_t k = 0; k < count; ++k) {
    if (isnan(system->motion[k]) || list[k].mean >= 0) continue;
    double *u = &system->u[list[k].component][list[k].point];
    double *v = &system->v[list[k].component][list[k].point];
    if (list[k].is_velocity) {
      *v = system->motion[k];
      continue;
    }
    *u = system->motion[k];
    *v = isnan(system->next_motion[k]) ? 0.0 : (system->next_motion[k] - *u) / dt;
  }
  start_means(system, dt);
  return SDR_OK;
}

sdr_status sdr_system_force(sdr_system *system, double dt, double dt_next, double kick)
{
  if (system->layers) SDR_TRY(follow_layers(system, dt));
  system->model->ops->force_commit(system->model, system->u, system->v, dt, system->f);
  if (system->layers) pull_layers(system, dt);
  if (system->contact) SDR_TRY(sdr_contact_force(system->contact, system->u, system->f));
  SDR_TRY(add_loads(system, dt));
  return hold_supports(system, dt, dt_next, kick);
}

void sdr_system_state(sdr_system *system, sdr_state_block *blocks, int *count)
{
  static const char *const names[3] = {"load_before.x", "load_before.y", "load_before.z"};
  const size_t held = (size_t)sdr_supports_count(system->supports) * sizeof(double);
  const size_t loaded = (size_t)sdr_loads_count(system->loads) * sizeof(double);
  int n = 0;
  blocks[n++] = (sdr_state_block){"reaction", system->reaction, held};
  for (int a = 0; a < system->components; ++a)
    blocks[n++] = (sdr_state_block){names[a], system->load_before[a], loaded};
  if (system->layers) {
    const size_t each = (size_t)system->components * sizeof(double);
    blocks[n++] = (sdr_state_block){"layer_u", system->layer_u,
                                    each * (size_t)sdr_layers_count(system->layers)};
    blocks[n++] = (sdr_state_block){"layer_pull", system->layer_pull,
                                    each * (size_t)sdr_layers_touched_count(system->layers)};
  }
  *count = n;
}

double sdr_system_reaction(const sdr_system *system, int support, int component)
{
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  double sum = system->layers ? sdr_layers_reaction(system->layers, support, component) : 0.0;
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    if (list[k].support == support && list[k].component == component) sum += system->reaction[k];
  return sum;
}

/* ---- energies and momenta -------------------------------------------------------------------- */

typedef struct {
  const sdr_system *system;
  sdr_balance *part; /* a stripe */
} balance_call;

/* Velocity of point i at the system's time. */
static void velocity_now(const sdr_system *system, int32_t i, double v[3])
{
  const double back =
      system->velocity_offset != 0.0 ? system->velocity_offset / system->mass[i] : 0.0;
  for (int a = 0; a < system->components; ++a) v[a] = system->v[a][i] - back * system->f[a][i];
}

static void balance_of_stripe(void *context, int s)
{
  const balance_call *call = context;
  const sdr_system *system = call->system;
  const sdr_points *points = system->model->points;
  sdr_balance *sum = &call->part[s];
  for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i) {
    double v[3] = {0.0}, x[3] = {0.0}, vv = 0.0, xx = 0.0;
    const double m = system->mass[i];
    if (!sdr_in_body(points, i)) continue;
    velocity_now(system, i, v);
    for (int a = 0; a < system->components; ++a) {
      x[a] = points->x[a][i] + system->u[a][i];
      vv += v[a] * v[a];
      xx += x[a] * x[a];
      sum->momentum[a] += m * v[a];
    }
    for (int c = 0; c < 3; ++c) {
      const int a = (c + 1) % 3, b = (c + 2) % 3;
      sum->angular[c] += m * (x[a] * v[b] - x[b] * v[a]);
    }
    sum->kinetic += 0.5 * m * vv;
    sum->momentum_scale += m * sqrt(vv);
    sum->angular_scale += m * sqrt(xx * vv);
  }
}

void sdr_system_balance(sdr_system *system, sdr_balance *out)
{
  enum { MOST_STRIPES = 256 };
  static _Thread_local sdr_balance part[MOST_STRIPES];
  memset(part, 0, sizeof part);
  balance_call call = {system, part};
  const int stripes = system->model->points->stripe_count;
  sdr_parallel_for(0, stripes, 1, balance_of_stripe, &call);
  *out = (sdr_balance){0};
  for (int s = 0; s < stripes; ++s) {
    out->kinetic += part[s].kinetic;
    out->momentum_scale += part[s].momentum_scale;
    out->angular_scale += part[s].angular_scale;
    for (int c = 0; c < 3; ++c) {
      out->momentum[c] += part[s].momentum[c];
      out->angular[c] += part[s].angular[c];
    }
  }
  system->model->ops->energies(system->model, system->u, &out->model);
  if (system->contact) out->contact = sdr_contact_energy(system->contact);
}

/* ---- fields ---------------------------------------------------------------------------------- */

typedef enum { SCALAR, VECTOR, TENSOR } field_kind;

/* The fields that a model makes, and those of the system itself (model_field -1). */
static const struct {
  const char *name;
  field_kind kind;
  int model_field;
} fields[] = {{"displacement", VECTOR, -1},
              {"velocity", VECTOR, -1},
              {"acceleration", VECTOR, -1},
              {"force", VECTOR, -1},
              {"reaction", VECTOR, -1},
              {"material", SCALAR, -1},
              {"horizon", SCALAR, -1},
              {"spacing", SCALAR, -1},
              {"level", SCALAR, -1},
              {"damage", SCALAR, SDR_FIELD_DAMAGE},
              {"energy_density", SCALAR, SDR_FIELD_ENERGY_DENSITY},
              {"dissipated", SCALAR, SDR_FIELD_DISSIPATED},
              {"stress", TENSOR, SDR_FIELD_STRESS},
              {"strain", TENSOR, SDR_FIELD_STRAIN},
              {"dilatation", SCALAR, SDR_FIELD_DILATATION}};

static int find_field(const char *name)
{
  const int count = (int)(sizeof fields / sizeof *fields);
  for (int k = 0; k < count; ++k)
    if (strcmp(fields[k].name, name) == 0) return k;
  return -1;
}

int sdr_field_components(const char *name, int components)
{
  const int k = find_field(name);
  if (k < 0) return 0;
  if (fields[k].kind == VECTOR) return components;
  return fields[k].kind == TENSOR ? components * (components + 1) / 2 : 1;
}

static void reactions(const sdr_system *system, double *out)
{
  const size_t count = (size_t)system->count;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  memset(out, 0, (size_t)system->components * count * sizeof *out);
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    out[(size_t)list[k].component * count + (size_t)list[k].point] += system->reaction[k];
}

/* A vector field of point i. */
static void vector_at(const sdr_system *system, char first, int32_t i, double value[3])
{
  if (first == 'v') velocity_now(system, i, value);
  for (int a = 0; a < system->components; ++a) {
    if (first == 'd') value[a] = system->u[a][i];
    if (first == 'f') value[a] = system->f[a][i];
    if (first == 'a') value[a] = system->mass[i] > 0.0 ? system->f[a][i] / system->mass[i] : 0.0;
  }
}

static double scalar_at(const sdr_points *points, char first, int32_t i)
{
  if (first == 'm') return points->material[i];
  if (first == 'h') return points->horizon[i];
  if (first == 's') return points->spacing[i];
  return points->level ? points->level[i] : 0.0;
}

int sdr_system_point(const sdr_system *system, const char *name, int32_t i, double value[3])
{
  const int k = find_field(name);
  if (k < 0 || fields[k].kind != VECTOR || !strchr("dvaf", name[0])) return 0;
  vector_at(system, name[0], i, value);
  return 1;
}

sdr_status sdr_system_field(sdr_system *system, const char *name, double *out)
{
  const int k = find_field(name);
  if (k < 0) return sdr_fail(SDR_BAD_INPUT, "there is no field '%s'", name);
  if (fields[k].model_field >= 0)
    return system->model->ops->field(system->model, system->u,
                                     (sdr_model_field)fields[k].model_field, out);
  if (strcmp(name, "reaction") == 0) {
    reactions(system, out);
    return SDR_OK;
  }
  for (int32_t i = 0; i < system->count; ++i) {
    double value[3] = {0.0};
    if (fields[k].kind == SCALAR)
      value[0] = scalar_at(system->model->points, name[0], i);
    else
      vector_at(system, name[0], i, value);
    for (int a = 0; a < (fields[k].kind == SCALAR ? 1 : system->components); ++a)
      out[(size_t)a * (size_t)system->count + (size_t)i] = value[a];
  }
  return SDR_OK;
}
