#include "app/build.h"

#include "app/body.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "damage/calibration.h"
#include "damage/laws.h"
#include "geometry/cracks.h"
#include "geometry/import.h"
#include "geometry/lattice.h"
#include "geometry/place.h"
#include "time/stable_step.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- marks: pre-cracks and protected zones --------------------------------------------------- */

static int protects(const sdr_scene *scene, const double x[3])
{
  const sdr_damage_scene *damage = &scene->damage;
  for (int k = 0; k < damage->protect_count; ++k)
    if (sdr_place_holds(scene, &damage->protect[k], x, scene->points.spacing,
                        scene->points.spacing))
      return 1;
  return 0;
}

static int mark_of_pair(const void *context, const double a[3], const double b[3])
{
  const sdr_scene *scene = context;
  if (scene->crack_count > 0 && sdr_cracks_cut(scene, a, b, 1e-9 * scene->points.spacing))
    return SDR_CUT;
  return protects(scene, a) || protects(scene, b) ? SDR_PROTECTED : 0;
}

static int may_mark(const void *context, const double low[3], const double high[3])
{
  const sdr_scene *scene = context;
  return scene->damage.protect_count > 0 ||
         sdr_cracks_near(scene, low, high, 1e-9 * scene->points.spacing);
}

sdr_pair_mark_of sdr_built_mark(const sdr_scene *scene)
{
  const int protect = scene->damage.law != SDR_LAW_NONE && scene->damage.protect_count > 0;
  const int any = scene->crack_count > 0 || protect;
  return (sdr_pair_mark_of){any ? mark_of_pair : NULL, scene, may_mark};
}

/* SDR_BAD_INPUT if no point lies in a place. */
static sdr_status check_place(const sdr_built *built, const sdr_place *place, const char *what)
{
  const sdr_points *points = built->points;
  for (int32_t i = 0; i < points->count; ++i) {
    double x[3] = {0.0};
    if (!sdr_in_body(points, i)) continue;
    for (int a = 0; a < points->components; ++a) x[a] = points->x[a][i];
    if (sdr_place_holds(built->scene, place, x, points->spacing[i], points->spacing[i]))
      return SDR_OK;
  }
  return sdr_fail(SDR_BAD_INPUT, "%s: %s '%s' meets no point; choose a place in the body",
                  sdr_origin_text(place->origin), what, place->text);
}

static sdr_status mark_bonds(sdr_built *built)
{
  const sdr_scene *scene = built->scene;
  const int protect = scene->damage.law != SDR_LAW_NONE && scene->damage.protect_count > 0;
  for (int k = 0; k < scene->damage.protect_count; ++k)
    SDR_TRY(check_place(built, &scene->damage.protect[k], "the protected zone"));
  if (scene->crack_count == 0 && !protect) return SDR_OK;
  SDR_TRY(built->model->ops->mark(built->model, mark_of_pair, scene, &built->cut_bonds));
  if (scene->crack_count > 0 && built->cut_bonds == 0)
    return sdr_fail(SDR_BAD_INPUT, "%s: the cracks cut no bond; do they lie in the body?",
                    sdr_origin_text(scene->crack[0].origin));
  return SDR_OK;
}

/* ---- parts ----------------------------------------------------------------------------------- */

static sdr_status make_points(sdr_built *built)
{
  const sdr_points_scene *wanted = &built->scene->points;
  SDR_TRY(
      (wanted->imported ? sdr_imported_points : sdr_lattice_points)(built->scene, &built->points));
  for (int k = 0; k < wanted->refine_count; ++k)
    SDR_TRY(check_place(built, &wanted->refine[k].where, "the refined place"));
  return sdr_points_arrange(built->points);
}

sdr_status sdr_built_model(sdr_built *built, const double *young, const double *share)
{
  SDR_TRY(
      sdr_body_create(built->scene, built->points, young, share, &built->families, &built->model));
  built->model->ops->traits(built->model, &built->traits);
  built->bonds = built->traits.bonds;
  return SDR_OK;
}

static sdr_status make_model(sdr_built *built)
{
  double *young = sdr_alloc(sdr_points_padded(built->points), sizeof *young);
  sdr_status status = young ? sdr_body_young(built->scene, built->points, young) : SDR_RUN_FAILED;
  if (status == SDR_OK) status = sdr_built_model(built, young, NULL);
  sdr_free(young);
  return status;
}

sdr_status sdr_built_system(sdr_built *built)
{
  const sdr_scene *scene = built->scene;
  double density[256] = {0.0};
  for (int m = 0; m < scene->material_count; ++m) density[m] = scene->material[m].density;
  SDR_TRY(sdr_loads_create(scene, built->points, &built->loads));
  SDR_TRY(sdr_supports_create(scene, built->points, &built->supports));
  SDR_TRY(sdr_layers_create(scene, built->points, &built->layers));
  SDR_TRY(sdr_system_create(built->model, density, built->loads, built->supports, &built->system));
  built->system->how = &scene->time;
  SDR_TRY(sdr_contact_create(scene, built->model, &built->contact));
  built->system->contact = built->contact;
  return sdr_system_attach(built->system, built->layers);
}

/* Set the point's value of `field` where the scene gives one. */
static sdr_status set_initial_point(const sdr_initial *initial, const double x[3], int components,
                                    double *const *field, int32_t i)
{
  for (int a = 0; a < components; ++a)
    if (initial->value[a] &&
        sdr_expression_value(initial->value[a], x, 0.0, &field[a][i]) != SDR_OK)
      return sdr_fail(
          SDR_BAD_INPUT, "%s: initial %s, %c component: %s", sdr_origin_text(initial->origin),
          initial->velocity ? "velocity" : "displacement", "xyz"[a], sdr_error_message());
  return SDR_OK;
}

static sdr_status set_initial(sdr_built *built, const sdr_initial *initial)
{
  sdr_system *system = built->system;
  double *const *field = initial->velocity ? system->v : system->u;
  int32_t met = 0;
  for (int32_t i = 0; i < system->count; ++i) {
    double x[3] = {0.0};
    if (!sdr_in_body(built->points, i)) continue;
    for (int a = 0; a < system->components; ++a) x[a] = built->points->x[a][i];
    const double spacing = built->points->spacing[i];
    if (!sdr_place_holds(built->scene, &initial->on, x, spacing, spacing)) continue;
    ++met;
    SDR_TRY(set_initial_point(initial, x, system->components, field, i));
  }
  if (met == 0)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: the initial %s on '%s' meets no point; choose a place in the body",
                    sdr_origin_text(initial->origin),
                    initial->velocity ? "velocity" : "displacement", initial->on.text);
  return SDR_OK;
}

/* Add to what the user should know before the run. */
SDR_PRINTF(2, 3) static void warn(sdr_built *built, const char *format, ...)
{
  const size_t used = strlen(built->warning), room = sizeof built->warning - used;
  const int written = snprintf(built->warning + used, room, "%s", used ? "; " : "");
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(built->warning + used + written, room - (size_t)written, format, arguments);
  va_end(arguments);
}

/* Bonds along the axes of a lattice only, as within a horizon of one spacing, resist no shear. */
static void warn_of_shear(sdr_built *built)
{
  const sdr_scene *scene = built->scene;
  if (scene->model != SDR_BOND_BASED || scene->dimension == SDR_1D) return;
  for (int k = 0; k < built->families->count; ++k) {
    const sdr_family *family = &built->families->family[k];
    const sdr_effective_stiffness s = sdr_stiffness_of(scene->dimension, family, 1.0, 1.0);
    if (s.c66 > 0.01 * s.c11) continue;
    warn(built,
         "the body has no shear stiffness: a horizon of %.4g times the spacing holds bonds along "
         "the axes "
         "of the lattice only; give at least 1.5 spacings, 3.015 as a rule (horizon)",
         family->horizon / family->spacing);
    return;
  }
}

/* One step, as long as the run. */
static void choose_static(sdr_built *built)
{
  const sdr_scene *scene = built->scene;
  built->stable_step = (double)NAN;
  built->step = scene->time.end;
  built->steps = 1;
  if (!isnan(scene->time.step)) warn(built, "time.step does not matter to a static solution");
  if (scene->model == SDR_NONORDINARY && scene->elasticity != SDR_LINEAR)
    warn(built, "the static solution is linear: finite strain (material.elasticity) acts only "
                "through its stiffness at rest");
}

/* The longest step of an integrator that chooses its own. */
static void choose_longest(sdr_built *built)
{
  const sdr_time_scene *time = &built->scene->time;
  built->step = isnan(time->step) ? time->end / 100.0 : fmin(time->step, time->end);
  built->steps = 0;
  if (time->step > time->end)
    warn(built, "time.step (%g s) is longer than the run (%g s)", time->step, time->end);
}

/* Of a time.end, or a material, with a wrong unit. */
static void warn_of_steps(sdr_built *built)
{
  const sdr_time_scene *time = &built->scene->time;
  if (built->step > time->end * (1.0 + 1e-12))
    warn(built,
         "one step of %.4g s is longer than the run (%g s); are the units of time.end, young and "
         "density right?",
         built->step, time->end);
  if (built->steps > 20000000)
    warn(built, "the run takes %lld steps; is the unit of time.end (%g s) right?",
         (long long)built->steps, time->end);
}

static sdr_status choose_step(sdr_built *built)
{
  const sdr_time_scene *time = &built->scene->time;
  if (time->linear) {
    choose_static(built);
    return SDR_OK;
  }
  built->stable_step = (double)NAN;
  if (built->integrator->is_static) {
    choose_longest(built);
    return SDR_OK;
  }
  SDR_TRY(sdr_stable_step(built->system, &built->stable_step));
  if (built->integrator->chooses) {
    choose_longest(built);
    return SDR_OK;
  }
  const double share = built->integrator->is_explicit ? time->safety : built->integrator->reach;
  built->step = isnan(time->step) ? share * built->stable_step : time->step;
  const double steps = ceil(time->end / built->step * (1.0 - 1e-12));
  if (!(steps < 1e15))
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: %g s in steps of %g s are %.1e steps; at most 1e15 are possible, so take "
                    "a longer step or an earlier end",
                    sdr_origin_text(time->step_origin), time->end, built->step, steps);
  built->steps = (int64_t)steps;
  warn_of_steps(built);
  if (!built->integrator->is_explicit || built->step <= built->stable_step) return SDR_OK;
  if (!time->allow_unstable)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: the step %.4g us is above the stability limit %.4g us; give at most that, "
                    "`auto` (%.4g us), or time.allow_unstable: true to try",
                    sdr_origin_text(time->step_origin), built->step * 1e6, built->stable_step * 1e6,
                    time->safety * built->stable_step * 1e6);
  warn(built, "the step %.4g us is above the stability limit %.4g us (time.allow_unstable)",
       built->step * 1e6, built->stable_step * 1e6);
  return SDR_OK;
}

/* ---- what is skipped ------------------------------------------------------------------------- */

static void skip(sdr_built *built, int condition, const char *what)
{
  if (condition && built->skipped_count < SDR_SKIPPED_MAX)
    built->skipped[built->skipped_count++] = what;
}

static void list_skipped(sdr_built *built)
{
  const sdr_scene *scene = built->scene;
  skip(built, scene->damage.law == SDR_LAW_NONE, "history: no damage law");
  skip(built, built->traits.shared_moduli, "moduli per point: all points share theirs");
  skip(built, built->points->components < 3,
       built->points->components < 2 ? "second and third components: 1-D" : "third component: 2-D");
  const int all_runs = built->bonds->loose_pairs == 0;
  skip(built, all_runs, "index lists: bonds are runs of a lattice");
  skip(built, all_runs, "neighbourhood: bonds come from lattice rows");
  skip(built, built->bonds->run_count > 0, "dual-horizon bookkeeping: one horizon");
  skip(built, built->integrator->is_explicit, "Jacobian: explicit integrator");
  skip(built, scene->time.linear, "steps in time: static solution");
  skip(built, built->integrator->is_static && !scene->time.linear,
       "masses and velocities: static solution");
  skip(built, scene->crack_count == 0 && scene->damage.protect_count == 0,
       "tests for cut bonds: no pre-crack, no protected zone");
  skip(built, !scene->contact.on, "contact: not asked for");
  skip(built, scene->output.snapshots == 0, "fields: no snapshots asked");
}

/* Onset counts from a share of what a plane cut removes, unless the scene says. */
static void choose_onset(sdr_built *built)
{
  const double given = built->scene->damage.onset;
  built->plane_cut = 0.9 * built->families->family[0].cut_share;
  built->onset = isnan(given) ? built->plane_cut : given;
}

static sdr_status build_parts(sdr_built *built)
{
  SDR_TRY(make_points(built));
  SDR_TRY(make_model(built));
  SDR_TRY(mark_bonds(built));
  SDR_TRY(sdr_built_system(built));
  for (int k = 0; k < built->scene->initial_count; ++k)
    SDR_TRY(set_initial(built, &built->scene->initial[k]));
  const sdr_time_scene *time = &built->scene->time;
  built->integrator = sdr_integrator_find(time->linear ? "static_linear" : time->integrator);
  if (!built->integrator)
    return sdr_fail(SDR_BAD_INPUT, "there is no integrator '%s'", built->scene->time.integrator);
  if (built->scene->one_sided)
    warn(built, "family.dual is false: a point feels its own family only, so momentum is not kept");
  warn_of_shear(built);
  SDR_TRY(choose_step(built));
  choose_onset(built);
  list_skipped(built);
  return SDR_OK;
}

sdr_status sdr_build_scene(sdr_scene **scene, sdr_built *out)
{
  sdr_built built = {.scene = *scene};
  *scene = NULL;
  if (built.scene->threads > 0) sdr_set_threads(built.scene->threads);
  const sdr_status status = build_parts(&built);
  if (status != SDR_OK) {
    sdr_built_destroy(&built);
    return status;
  }
  *out = built;
  return SDR_OK;
}

sdr_status sdr_build(const char *path, const char *variant, int set_count, const char *const *sets,
                     sdr_built *out)
{
  sdr_scene *scene = NULL;
  SDR_TRY(sdr_scene_load(path, variant, set_count, sets, &scene));
  if (!scene->equation) return sdr_build_scene(&scene, out);
  sdr_scene_destroy(&scene);
  return sdr_fail(SDR_BAD_INPUT, "%s: a scene with an equation moves no body", path);
}

sdr_status sdr_built_start(sdr_built *built)
{
  if (built->scene->points.adapt)
    return sdr_fail(SDR_BAD_INPUT, "points.adapt: points split only in `sunder run`");
  return built->integrator->start(built->system, built->step);
}

sdr_status sdr_built_step(sdr_built *built)
{
  return built->integrator->step(built->system, built->step);
}

int sdr_built_is_over(const sdr_built *built)
{
  if (built->system->over) return 1;
  if (!built->integrator->chooses) return built->system->step >= built->steps;
  return built->system->time >= built->scene->time.end * (1.0 - 1e-12);
}

void sdr_built_destroy(sdr_built *built)
{
  sdr_system_destroy(&built->system);
  sdr_contact_destroy(&built->contact);
  sdr_layers_destroy(&built->layers);
  sdr_supports_destroy(&built->supports);
  sdr_loads_destroy(&built->loads);
  if (built->model) built->model->ops->destroy(built->model);
  sdr_families_destroy(&built->families);
  sdr_points_destroy(&built->points);
  sdr_scene_destroy(&built->scene);
  *built = (sdr_built){0};
}
