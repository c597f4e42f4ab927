#include "app/check.h"

#include "app/build.h"
#include "app/check_body.h"
#include "app/check_material.h"
#include "app/directory.h"
#include "app/figures.h"
#include "app/plot_units.h"
#include "app/run_equation.h"
#include "app/watch.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "damage/laws.h"
#include "output/rundir.h"
#include "time/tolerances.h"

#include <math.h>

static const char *const dimension_names[] = {"1d", "plane_stress", "plane_strain", "3d"};
static const char *const law_names[] = SDR_LAW_NAMES;

static void print_points(const sdr_built *built, FILE *out)
{
  const sdr_points *points = built->points;
  const sdr_bonds *bonds = built->bonds;
  double least = INFINITY, most = 0.0;
  for (int32_t i = 0; i < points->count; ++i) {
    least = fmin(least, points->horizon[i]);
    most = fmax(most, points->horizon[i]);
  }
  fprintf(out, "points              %d, spacing %s%g mm", (int)points->count,
          built->scene->points.imported ? "at most " : "", built->scene->points.spacing * 1e3);
  if (least == most)
    fprintf(out, ", horizon %g mm\n", least * 1e3);
  else
    fprintf(out, ", horizons %g to %g mm\n", least * 1e3, most * 1e3);
  fprintf(out, "bonds               %lld directed, %lld pairs: %lld in %lld runs, %lld loose\n",
          (long long)bonds->directed, (long long)bonds->pairs,
          (long long)(bonds->pairs - bonds->loose_pairs), (long long)bonds->run_count,
          (long long)bonds->loose_pairs);
  if (built->cut_bonds > 0)
    fprintf(out, "cut at the start    %lld directed bonds\n", (long long)built->cut_bonds);
}

/* Components that the supports take from the unknowns: a prescribed mean takes one of all its
   points'. */
static long long count_held(const sdr_supports *supports, const double *motion)
{
  const sdr_prescribed *list = sdr_supports_list(supports);
  const int32_t count = sdr_supports_count(supports);
  long long held = 0;
  for (int32_t k = 0; k < count; ++k) held += list[k].mean < 0 && !isnan(motion[k]);
  for (int mean = 0; mean < sdr_supports_means(supports); ++mean) {
    int32_t k = 0;
    while (k < count && (list[k].mean != mean || isnan(motion[k]))) ++k;
    held += k < count;
  }
  return held;
}

static sdr_status print_static(const sdr_built *built, FILE *out)
{
  sdr_system *system = built->system;
  const long long unknowns = (long long)system->count * system->components;
  SDR_TRY(sdr_supports_values(built->supports, built->step, system->motion));
  const long long held = count_held(built->supports, system->motion);
  if (built->scene->time.linear)
    fprintf(out, "static solution     at t = %g s", built->step);
  else
    fprintf(out, "static solutions    to t = %g s in increments of at most %g s",
            built->scene->time.end, built->step);
  fprintf(out, ": %lld components, %lld of them prescribed; solver %s\n", unknowns, held,
          built->scene->time.solver);
  if (built->warning[0]) fprintf(out, "warning             %s\n", built->warning);
  return SDR_OK;
}

/* The stable step, the step, and the end of a run, each with the unit that fits. */
typedef struct {
  char stable[32], step[32], end[32];
} moments;

static moments moments_of(const sdr_built *built)
{
  moments m = {"", "", ""};
  sdr_quantity(built->stable_step, "s", 5, m.stable, sizeof m.stable);
  sdr_quantity(built->step, "s", 5, m.step, sizeof m.step);
  sdr_quantity(built->scene->time.end, "s", 6, m.end, sizeof m.end);
  return m;
}

/* Of integrators that choose their steps and hold their error. */
static sdr_status print_adaptive(const sdr_built *built, FILE *out)
{
  sdr_tolerances tolerances;
  const moments m = moments_of(built);
  SDR_TRY(sdr_tolerances_choose(built->system, built->stable_step, &tolerances));
  fprintf(out, "stable step         %s; steps are chosen, at most %s long, to %s\n", m.stable,
          m.step, m.end);
  fprintf(out, "tolerances          %g of a value and %.4g m, %.4g m/s\n", tolerances.relative,
          tolerances.displacement, tolerances.velocity);
  if (built->warning[0]) fprintf(out, "warning             %s\n", built->warning);
  return SDR_OK;
}

static sdr_status print_step(const sdr_built *built, FILE *out)
{
  if (built->integrator->is_static) return print_static(built, out);
  if (built->integrator == &sdr_cvode || built->integrator == &sdr_ida)
    return print_adaptive(built, out);
  const moments m = moments_of(built);
  fprintf(out, "stable step         %s; step %s (%.3g of it), %lld steps to %s\n", m.stable, m.step,
          built->step / built->stable_step, (long long)built->steps, m.end);
  if (built->warning[0]) fprintf(out, "warning             %s\n", built->warning);
  return SDR_OK;
}

/* Points that may split, and what that makes of the step. */
static void print_adapt(const sdr_built *built, FILE *out)
{
  const sdr_adapt_scene *adapt = built->scene->points.adapt;
  if (!adapt) return;
  double horizon = 0.0;
  for (int32_t i = 0; i < built->points->count; ++i)
    horizon = fmax(horizon, built->points->horizon[i]);
  const sdr_length lengths[] = {adapt->neighbours, adapt->ahead};
  double reach[2];
  for (int k = 0; k < 2; ++k)
    reach[k] = lengths[k].relative ? lengths[k].value * horizon : lengths[k].value;
  fprintf(out, "points may split    ");
  if (adapt->levels == 1)
    fprintf(out, "once");
  else
    fprintf(out, "%d times", adapt->levels);
  fprintf(out, ", to %g mm, above", ldexp(built->points->lattice_spacing, -adapt->levels) * 1e3);
  if (!isinf(adapt->energy)) fprintf(out, " %g J/m^3", adapt->energy);
  if (!isinf(adapt->energy) && !isinf(adapt->damage)) fprintf(out, " or");
  if (!isinf(adapt->damage)) fprintf(out, " a damage of %g", adapt->damage);
  fprintf(out, "; with all within %g mm, and %g mm ahead of tips\n", reach[0] * 1e3,
          reach[1] * 1e3);
}

static void print_memory(const sdr_built *built, FILE *out)
{
  const double held = (double)sdr_memory_now();
  fprintf(out, "memory              %.1f MB (%.0f bytes a point), of it %.1f MB damage history\n",
          held / 1e6, held / (double)built->points->count,
          (double)built->traits.history_bytes / 1e6);
}

static void print_lists(const sdr_built *built, FILE *out)
{
  const sdr_scene *scene = built->scene;
  fprintf(out, "skipped\n");
  for (int k = 0; k < built->skipped_count; ++k) fprintf(out, "  %s\n", built->skipped[k]);
  if (scene->idle_count > 0) fprintf(out, "without effect\n");
  for (int k = 0; k < scene->idle_count; ++k) fprintf(out, "  %s\n", scene->idle[k]);
  fprintf(out, "defaults\n");
  for (int k = 0; k < scene->default_count; ++k) fprintf(out, "  %s\n", scene->defaults[k]);
}

/* What a run would refuse besides. */
static sdr_status check_run(sdr_built *built)
{
  char directory[SDR_DIRECTORY];
  sdr_watchers watch;
  SDR_TRY(sdr_figures_known(built->scene));
  SDR_TRY(sdr_name_directory(built->scene, NULL, NULL, directory));
  SDR_TRY(sdr_rundir_try(directory));
  sdr_moment moment = sdr_watch_moment(built, directory);
  sdr_status status = sdr_watchers_create(built, &moment, 0, &watch);
  sdr_watchers_destroy(&watch);
  if (status == SDR_OK && built->integrator->held)
    status = built->integrator->held(built->system, built->step);
  return status;
}

static sdr_status print_all(const sdr_built *built, FILE *out)
{
  const sdr_scene *scene = built->scene;
  fprintf(out, "%s\n", scene->title);
  if (*scene->variants) fprintf(out, "variants            %s\n", scene->variants);
  fprintf(out, "model               %s, %s, damage %s, integrator %s\n", built->traits.name,
          dimension_names[scene->dimension], law_names[scene->damage.law], scene->time.integrator);
  fprintf(out, "kernels             %s, %s precision, %d thread%s\n", built->traits.isa,
          scene->mixed ? "mixed" : "double", sdr_threads(), sdr_threads() == 1 ? "" : "s");
  print_points(built, out);
  sdr_check_body(built, out);
  SDR_TRY(print_step(built, out));
  print_adapt(built, out);
  print_memory(built, out);
  SDR_TRY(sdr_check_materials(built, out));
  if (scene->damage.law != SDR_LAW_NONE)
    fprintf(out, "onset               at a point's damage of %.4g\n", built->onset);
  print_lists(built, out);
  return SDR_OK;
}

sdr_status sdr_check(const char *path, const char *variant, int set_count, const char *const *sets,
                     FILE *out)
{
  sdr_built built;
  sdr_scene *scene = NULL;
  SDR_TRY(sdr_scene_load(path, variant, set_count, sets, &scene));
  if (scene->equation) {
    const sdr_status checked = sdr_check_equation(scene, out);
    sdr_scene_destroy(&scene);
    return checked;
  }
  SDR_TRY(sdr_build_scene(&scene, &built));
  sdr_status status = check_run(&built);
  if (status == SDR_OK) status = print_all(&built, out);
  sdr_built_destroy(&built);
  return status;
}
