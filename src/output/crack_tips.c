/* While the run goes on only the time is kept at which each point's damage passed the threshold.
   Everything else follows from these times in the end, so that the state is small, survives points
   that split, and looks cost no more than a field of damage. */
#include "output/crack_tips.h"

#include "base/memory.h"
#include "damage/calibration.h"
#include "output/crack_file.h"
#include "output/crack_path.h"

#include <math.h>
#include <string.h>

typedef struct {
  sdr_observer head;
  const sdr_scene *scene;
  const sdr_points *points;
  double threshold, every; /* s between looks; 0: every step */
  sdr_crack_how how;
  double spacing, horizon;   /* m, the largest at the start */
  double looked;             /* s, latest look; state */
  double *arrival;           /* per point, s; NAN: not yet, -1: from the start; state */
  float *first;              /* per point: damage at t = 0; state */
  double *damage;            /* scratch */
  sdr_crack_report *reports; /* NULL until the end */
} tips;

static tips *of(sdr_observer *observer)
{
  return (tips *)(void *)observer;
}

/* ---- while the run goes on ------------------------------------------------------------------- */

static int due(const sdr_observer *observer, const sdr_moment *moment, int *wants_balance)
{
  const tips *t = (const tips *)(const void *)observer;
  (void)wants_balance;
  return moment->step == 0 || moment->last ||
         moment->time + moment->step_size > (t->looked + t->every) * (1.0 + 1e-12);
}

static sdr_status look(sdr_observer *observer, const sdr_moment *moment)
{
  tips *t = of(observer);
  const int at_start = moment->step == 0;
  SDR_TRY(sdr_system_field(moment->system, "damage", t->damage));
  t->looked = moment->time;
  for (int32_t i = 0; i < t->points->count; ++i)
    if (isnan(t->arrival[i]) && t->damage[i] >= t->threshold)
      t->arrival[i] = at_start ? -1.0 : moment->time;
  for (int32_t i = 0; at_start && i < t->points->count; ++i) t->first[i] = (float)t->damage[i];
  return SDR_OK;
}

static void state(sdr_observer *observer, sdr_state_block *blocks, int *count)
{
  tips *t = of(observer);
  const size_t points = (size_t)t->points->count;
  blocks[0] = (sdr_state_block){"looked", &t->looked, sizeof t->looked};
  blocks[1] = (sdr_state_block){"arrival", t->arrival, points * sizeof *t->arrival};
  blocks[2] = (sdr_state_block){"first", t->first, points * sizeof *t->first};
  *count = 3;
}

/* Children take over what is known of their parent. */
static sdr_status points_changed(sdr_observer *observer, const sdr_moment *moment,
                                 const sdr_point_map *map)
{
  tips *t = of(observer);
  const size_t now = (size_t)map->now;
  double *arrival = sdr_alloc(now, sizeof *arrival), *damage = sdr_alloc(now, sizeof *damage);
  float *first = sdr_alloc(now, sizeof *first);
  if (!arrival || !damage || !first) {
    sdr_free(arrival);
    sdr_free(damage);
    sdr_free(first);
    return SDR_RUN_FAILED;
  }
  for (int32_t i = 0; i < map->now; ++i) {
    arrival[i] = t->arrival[map->parent[i]];
    first[i] = t->first[map->parent[i]];
  }
  sdr_free(t->arrival);
  sdr_free(t->damage);
  sdr_free(t->first);
  t->arrival = arrival;
  t->damage = damage;
  t->first = first;
  t->points = moment->system->model->points;
  return SDR_OK;
}

/* ---- when it is over ------------------------------------------------------------------------- */

/* The points that were damaged on the way, apart from the others. */
typedef struct {
  sdr_points *points;
  sdr_point_grid *grid;
  double *arrival;
  int32_t *owner; /* the first crack that each belongs to; -1 */
  sdr_crack_sites sites;
} gathered;

static void gathered_clear(gathered *g)
{
  sdr_point_grid_destroy(&g->grid);
  sdr_points_destroy(&g->points);
  sdr_free(g->arrival);
  sdr_free(g->owner);
}

static int is_site(const tips *t, int32_t i)
{
  return t->arrival[i] >= 0.0 && sdr_in_body(t->points, i); /* NAN is not */
}

static sdr_status gather(const tips *t, int32_t count, gathered *g)
{
  const sdr_points *points = t->points;
  int32_t k = 0;
  SDR_TRY(sdr_points_create(count, points->components, 0, &g->points));
  g->arrival = sdr_alloc((size_t)count, sizeof *g->arrival);
  g->owner = sdr_alloc((size_t)count, sizeof *g->owner);
  if (!g->arrival || !g->owner) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < points->count; ++i) {
    if (!is_site(t, i)) continue;
    for (int c = 0; c < points->components; ++c) g->points->x[c][k] = points->x[c][i];
    g->points->spacing[k] = points->spacing[i];
    g->points->horizon[k] = points->horizon[i];
    g->owner[k] = -1;
    g->arrival[k++] = t->arrival[i];
  }
  SDR_TRY(sdr_point_grid_create(g->points, &g->grid));
  g->sites = (sdr_crack_sites){g->points, g->grid, g->arrival};
  return SDR_OK;
}

static double metres(const tips *t, sdr_length length)
{
  return length.relative ? length.value * t->spacing : length.value;
}

/* Longer than a tip, slower than Rayleigh waves, takes over two horizons. */
static double longest_lag(const tips *t)
{
  return 2.0 * t->horizon / t->how.rayleigh + 2.0 * t->every;
}

static sdr_status report_on(tips *t, sdr_system *system, gathered *g, sdr_crack_growth *growth)
{
  const sdr_cracks_output *cracks = &t->scene->output.cracks;
  const int count = cracks->tip_count;
  sdr_crack_surface *surface = sdr_alloc((size_t)count, sizeof *surface);
  sdr_status status = surface ? SDR_OK : SDR_RUN_FAILED;
  for (int k = 0; status == SDR_OK && k < count; ++k) {
    status = sdr_crack_grow(&g->sites, cracks->tip[k].start, longest_lag(t), &growth[k]);
    for (int32_t n = 0; n < growth[k].count; ++n)
      if (g->owner[growth[k].site[n]] < 0) g->owner[growth[k].site[n]] = k;
  }
  if (status == SDR_OK)
    status = sdr_crack_surfaces(system, &g->sites, g->owner, t->first, count, surface);
  for (int k = 0; status == SDR_OK && k < count; ++k) {
    const sdr_crack_tip *tip = &cracks->tip[k];
    const double fit[2] = {metres(t, tip->fit[0]), metres(t, tip->fit[1])};
    status = sdr_crack_report_make(&g->sites, &growth[k], &t->how, tip->direction, fit, surface[k],
                                   &t->reports[k]);
  }
  sdr_free(surface);
  return status;
}

/* Nothing was damaged: no times and places, no surface. */
static void report_nothing(tips *t)
{
  for (int k = 0; k < t->scene->output.cracks.tip_count; ++k) {
    double *f = t->reports[k].figure;
    for (int n = 0; n < SDR_CRACK_FIGURES; ++n) f[n] = (double)NAN;
    f[SDR_CRACK_TIPS] = f[SDR_CRACK_BRANCHES] = 0.0;
    f[SDR_CRACK_LENGTH] = f[SDR_CRACK_AREA] = f[SDR_CRACK_ENERGY] = 0.0;
  }
}

static sdr_status report_all(tips *t, sdr_system *system)
{
  const int count = t->scene->output.cracks.tip_count;
  int32_t sites = 0;
  for (int32_t i = 0; i < t->points->count; ++i) sites += is_site(t, i);
  if (sites == 0) {
    report_nothing(t);
    return SDR_OK;
  }
  gathered g = {0};
  sdr_crack_growth *growth = sdr_alloc((size_t)count, sizeof *growth);
  sdr_status status = growth ? gather(t, sites, &g) : SDR_RUN_FAILED;
  if (status == SDR_OK) status = report_on(t, system, &g, growth);
  for (int k = 0; growth && k < count; ++k) sdr_crack_growth_clear(&growth[k]);
  sdr_free(growth);
  gathered_clear(&g);
  return status;
}

static sdr_status finish(sdr_observer *observer, const sdr_moment *moment)
{
  tips *t = of(observer);
  const sdr_cracks_output *cracks = &t->scene->output.cracks;
  t->reports = sdr_alloc((size_t)cracks->tip_count, sizeof *t->reports);
  if (!t->reports) return SDR_RUN_FAILED;
  SDR_TRY(report_all(t, moment->system));
  return sdr_crack_file_write(moment->directory, cracks, t->reports, t->how.window);
}

const sdr_crack_report *sdr_crack_tips_reports(const sdr_observer *observer)
{
  return ((const tips *)(const void *)observer)->reports;
}

/* ---- set-up ---------------------------------------------------------------------------------- */

static void destroy(sdr_observer *observer)
{
  tips *t = of(observer);
  for (int k = 0; t->reports && k < t->scene->output.cracks.tip_count; ++k)
    sdr_crack_report_clear(&t->reports[k]);
  sdr_free(t->reports);
  sdr_free(t->arrival);
  sdr_free(t->first);
  sdr_free(t->damage);
  sdr_free(t);
}

static const sdr_observer_ops ops = {.name = "cracks",
                                     .due = due,
                                     .look = look,
                                     .finish = finish,
                                     .state = state,
                                     .points_changed = points_changed,
                                     .destroy = destroy};

static sdr_status check_starts(const tips *t)
{
  const sdr_cracks_output *cracks = &t->scene->output.cracks;
  for (int k = 0; k < cracks->tip_count; ++k) {
    const sdr_crack_tip *tip = &cracks->tip[k];
    const int32_t i = sdr_points_nearest(t->points, tip->start);
    double square = 0.0;
    for (int c = 0; c < t->points->components; ++c)
      square += pow(t->points->x[c][i] - tip->start[c], 2.0);
    if (!(sqrt(square) <= t->points->horizon[i]))
      return sdr_fail(SDR_BAD_INPUT,
                      "%s: tip %s: its start lies outside the body: the nearest point is %.4g mm "
                      "away, beyond its horizon of %.4g mm",
                      sdr_origin_text(tip->origin), tip->name, 1e3 * sqrt(square),
                      1e3 * t->points->horizon[i]);
  }
  return SDR_OK;
}

static void choose(tips *t, double plane_cut)
{
  const sdr_scene *scene = t->scene;
  const sdr_cracks_output *cracks = &scene->output.cracks;
  const sdr_material *material = &scene->material[0];
  const double poisson =
      scene->model == SDR_BOND_BASED ? sdr_bond_poisson(scene->dimension) : material->poisson;
  for (int32_t i = 0; i < t->points->count; ++i) {
    t->spacing = fmax(t->spacing, t->points->spacing[i]);
    t->horizon = fmax(t->horizon, t->points->horizon[i]);
  }
  t->how = (sdr_crack_how){
      .moved = metres(t, cracks->moved),
      .window = metres(t, cracks->window),
      .shortest = metres(t, cracks->shortest),
      .count_at = cracks->count_at,
      .rayleigh = sdr_rayleigh_speed(material->young, poisson, material->density),
      .toughness = material->toughness,
      .thickness = scene->dimension == SDR_3D ? (double)NAN : scene->points.thickness};
  t->threshold = isnan(cracks->threshold) ? plane_cut : cracks->threshold;
  t->every = isnan(cracks->every) ? 2.0 * t->spacing / t->how.rayleigh : cracks->every;
  /* Time orders increments only; massless bodies have no waves. */
  if (strcmp(scene->time.integrator, "static") == 0 || !(material->density > 0.0)) t->every = 0.0;
}

sdr_status sdr_crack_tips_create(const sdr_scene *scene, const sdr_points *points, double plane_cut,
                                 sdr_observer **out)
{
  const size_t count = (size_t)points->count;
  tips *t = sdr_alloc(1, sizeof *t);
  if (!t) return SDR_RUN_FAILED;
  *t = (tips){.head.ops = &ops, .scene = scene, .points = points};
  t->arrival = sdr_alloc(count, sizeof *t->arrival);
  t->first = sdr_alloc(count, sizeof *t->first);
  t->damage = sdr_alloc(count, sizeof *t->damage);
  sdr_status status = t->arrival && t->first && t->damage ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) status = check_starts(t);
  if (status != SDR_OK) {
    destroy(&t->head);
    return status;
  }
  for (int32_t i = 0; i < points->count; ++i) t->arrival[i] = (double)NAN;
  choose(t, plane_cut);
  *out = &t->head;
  return SDR_OK;
}
