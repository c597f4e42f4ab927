#include "time/implicit.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

/* ---- constraints and loads at a time --------------------------------------------------------- */

/* Where supports want their components to be, into system->motion. */
static sdr_status prescribe(sdr_implicit *implicit)
{
  sdr_system *system = implicit->system;
  const double since = implicit->time - system->time;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  SDR_TRY(sdr_supports_values(system->supports, implicit->time, system->motion));
  SDR_TRY(sdr_supports_values(system->supports, system->time + 0.5 * since, system->next_motion));
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k)
    if (list[k].is_velocity) {
      const double velocity = since != 0.0 ? system->next_motion[k] : 0.0 * system->motion[k];
      system->motion[k] = implicit->reached[k] + since * velocity; /* NAN: free */
    }
  return SDR_OK;
}

static sdr_status constrain(sdr_implicit *implicit)
{
  sdr_system *system = implicit->system;
  sdr_slaves_destroy(&implicit->slaves);
  SDR_TRY(prescribe(implicit));
  if (system->layers) {
    SDR_TRY(sdr_layers_values(system->layers, implicit->time));
    SDR_TRY(sdr_layers_slaves(system->layers, &implicit->slaves));
  }
  const int32_t others = implicit->slaves.count;
  if (!implicit->free_means)
    SDR_TRY(sdr_slaves_of_means(system->supports, system->motion, system->model->points,
                                &implicit->slaves));
  implicit->means = implicit->slaves.count - others;
  return sdr_constraints_create(system->model->points, system->supports, system->motion,
                                implicit->slaves.count > 0 ? &implicit->slaves : NULL,
                                &implicit->constraints);
}

static void find_held(sdr_implicit *implicit)
{
  const sdr_constraints *c = &implicit->constraints;
  const sdr_slaves *slaves = &implicit->slaves;
  memset(implicit->held, 1, (size_t)implicit->unknowns);
  for (int32_t k = 0; k < c->free; ++k) implicit->held[c->unknown[k]] = 0;
  for (int64_t p = 0; slaves->count > 0 && p < slaves->first[slaves->count]; ++p)
    implicit->held[slaves->master[p]] = 1;
}

static sdr_status take_loads(sdr_implicit *implicit)
{
  const sdr_system *system = implicit->system;
  const int m = system->components;
  const int32_t *points = sdr_loads_points(system->loads);
  SDR_TRY(sdr_loads_evaluate(system->loads, implicit->time));
  for (int32_t k = 0; k < sdr_loads_count(system->loads); ++k)
    for (int a = 0; a < m; ++a)
      implicit->load[points[k] * m + a] = sdr_loads_force(system->loads, a)[k];
  return SDR_OK;
}

/* 1 if the same components are free in both. */
static int same_free(const sdr_constraints *a, const sdr_constraints *b)
{
  return a->free == b->free && (a->free == 0 || memcmp(a->unknown, b->unknown,
                                                       (size_t)a->free * sizeof *a->unknown) == 0);
}

sdr_status sdr_implicit_move(sdr_implicit *implicit, double time, int *renumbered)
{
  sdr_constraints before = implicit->constraints;
  implicit->constraints = (sdr_constraints){0};
  implicit->time = time;
  sdr_status status = constrain(implicit);
  if (status == SDR_OK) {
    *renumbered = !same_free(&before, &implicit->constraints);
    implicit->free = implicit->constraints.free;
    find_held(implicit);
    status = take_loads(implicit);
  }
  sdr_constraints_destroy(&before);
  return status;
}

double sdr_implicit_next_event(const sdr_implicit *implicit, double t)
{
  const sdr_system *system = implicit->system;
  return fmin(sdr_loads_next_event(system->loads, t), sdr_supports_next_event(system->supports, t));
}

static void set_masses(sdr_implicit *implicit)
{
  const sdr_system *system = implicit->system;
  for (int32_t i = 0; i < system->count; ++i)
    for (int a = 0; a < system->components; ++a)
      implicit->mass[i * system->components + a] =
          sdr_in_body(system->model->points, i) ? system->mass[i] : 0.0;
}

void sdr_implicit_accept(sdr_implicit *implicit)
{
  const sdr_system *system = implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  const int32_t count = sdr_supports_count(system->supports);
  for (int32_t k = 0; k < count; ++k)
    implicit->reached[k] = system->u[list[k].component][list[k].point];
  for (int mean = 0; mean < sdr_supports_means(system->supports); ++mean) {
    const double reached = sdr_system_mean(system, mean, system->u);
    for (int32_t k = 0; k < count; ++k)
      if (list[k].mean == mean) implicit->reached[k] = reached;
  }
}

sdr_status sdr_implicit_create(sdr_system *system, sdr_implicit **out)
{
  sdr_implicit *implicit = sdr_alloc(1, sizeof *implicit);
  if (!implicit) return SDR_RUN_FAILED;
  const size_t unknowns = (size_t)system->count * (size_t)system->components;
  int renumbered;
  implicit->system = system;
  implicit->unknowns = (int32_t)unknowns;
  implicit->load = sdr_alloc(unknowns, sizeof *implicit->load);
  implicit->mass = sdr_alloc(unknowns, sizeof *implicit->mass);
  implicit->held = sdr_alloc(unknowns, sizeof *implicit->held);
  implicit->reached =
      sdr_alloc((size_t)sdr_supports_count(system->supports), sizeof *implicit->reached);
  if (system->layers) implicit->scratch = sdr_alloc(unknowns, sizeof *implicit->scratch);
  const int whole = implicit->load && implicit->mass && implicit->held && implicit->reached &&
                    !implicit->scratch == !system->layers;
  sdr_status status = whole ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) {
    set_masses(implicit);
    sdr_implicit_accept(implicit);
    status = sdr_implicit_move(implicit, system->time, &renumbered);
  }
  if (status == SDR_OK)
    *out = implicit;
  else
    sdr_implicit_destroy(&implicit);
  return status;
}

void sdr_implicit_destroy(sdr_implicit **implicit)
{
  sdr_implicit *i = *implicit;
  if (!i) return;
  sdr_constraints_destroy(&i->constraints);
  sdr_slaves_destroy(&i->slaves);
  sdr_free(i->load);
  sdr_free(i->mass);
  sdr_free(i->scratch);
  sdr_free(i->held);
  sdr_free(i->reached);
  sdr_free(i);
  *implicit = NULL;
}

/* ---- forces ---------------------------------------------------------------------------------- */

void sdr_implicit_gather(const sdr_implicit *implicit, double *const from[3], double *to)
{
  const int m = implicit->system->components;
  for (int a = 0; a < m; ++a)
    for (int32_t i = 0; i < implicit->system->count; ++i) to[i * m + a] = from[a][i];
}

void sdr_implicit_scatter(const sdr_implicit *implicit, const double *from, double *const to[3])
{
  const int m = implicit->system->components;
  for (int a = 0; a < m; ++a)
    for (int32_t i = 0; i < implicit->system->count; ++i) to[a][i] = from[i * m + a];
}

void sdr_implicit_force(sdr_implicit *implicit, const double *u, double *force)
{
  sdr_system *system = implicit->system;
  sdr_implicit_scatter(implicit, u, system->u);
  system->model->ops->force(system->model, system->u, system->f);
  sdr_implicit_gather(implicit, system->f, force);
}

/* What the layers of supports pull with where the model's force is `internal`. */
static void note_layer_reactions(sdr_implicit *implicit, const double *internal)
{
  sdr_system *system = implicit->system;
  sdr_implicit_gather(implicit, system->f, implicit->scratch);
  sdr_implicit_scatter(implicit, internal, system->f);
  sdr_layers_pull(system->layers, system->f);
  sdr_implicit_scatter(implicit, implicit->scratch, system->f);
}

void sdr_implicit_outside(sdr_implicit *implicit, const double *internal, const double *total,
                          double *out)
{
  sdr_system *system = implicit->system;
  const int m = system->components;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int32_t r = 0; r < implicit->unknowns; ++r)
    out[r] = implicit->held[r] ? (total ? total[r] : 0.0) - internal[r] : implicit->load[r];
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    const int32_t r = list[k].point * m + list[k].component;
    const int acts = !isnan(system->motion[k]);
    system->reaction[k] = acts ? out[r] - implicit->load[r] : 0.0;
  }
  if (system->layers) note_layer_reactions(implicit, internal);
}

/* ---- books ----------------------------------------------------------------------------------- */

static void book_point(sdr_implicit *implicit, int32_t i, const double *way, const double *before,
                       const double *now, double dt)
{
  sdr_system *system = implicit->system;
  const int m = system->components;
  double here[3] = {0.0}, there[3] = {0.0}, f0[3] = {0.0}, f1[3] = {0.0};
  for (int a = 0; a < m; ++a) {
    const int32_t r = i * m + a;
    f0[a] = before[r];
    f1[a] = now[r];
    here[a] = system->model->points->x[a][i] + system->u[a][i];
    there[a] = here[a] - way[r];
    system->external_work += 0.5 * (f0[a] + f1[a]) * way[r];
    system->impulse[a] += 0.5 * dt * (f0[a] + f1[a]);
  }
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    system->angular_impulse[c] +=
        0.5 * dt * (there[a] * f0[b] - there[b] * f0[a] + here[a] * f1[b] - here[b] * f1[a]);
  }
}

void sdr_implicit_book(sdr_implicit *implicit, const double *way, const double *before,
                       const double *now, double dt)
{
  for (int32_t i = 0; i < implicit->system->count; ++i)
    book_point(implicit, i, way, before, now, dt);
}
