#include "app/run.h"

#include "app/adapt.h"
#include "app/build.h"
#include "app/constants.h"
#include "app/directory.h"
#include "app/figures.h"
#include "app/plot_units.h"
#include "app/run_equation.h"
#include "app/stop.h"
#include "app/watch.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "output/checkpoint.h"
#include "output/crack_tips.h"
#include "output/fragments.h"
#include "output/ledger.h"
#include "output/measures.h"
#include "output/onset.h"
#include "output/pieces.h"
#include "output/rundir.h"
#include "output/summary.h"

#include <math.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#ifndef SUNDER_COMMIT
#define SUNDER_COMMIT "unknown"
#endif

typedef struct {
  sdr_built built;
  char directory[SDR_DIRECTORY];
  int lock;
  sdr_watchers watch;
  sdr_moment moment;
  int64_t steps_before;          /* taken before a resume */
  double written;                /* s: when the last checkpoint was */
  double started, setup, output; /* s of wall time */
  int overridden;                /* 1: --set changed the scene */
  char resting[96];              /* for the summary's list of what was skipped */
} run;

static double wall(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- set-up ---------------------------------------------------------------------------------- */

/* Not at the end: there is no step any more that methods could look ahead to. */
static sdr_status restart(run *r)
{
  const sdr_built *built = &r->built;
  if (!built->integrator->restart || sdr_built_is_over(built)) return SDR_OK;
  return built->integrator->restart(built->system, built->step);
}

static sdr_status begin(run *r, const sdr_run_options *options)
{
  if (!options->resume) return r->built.integrator->start(r->built.system, r->built.step);
  if (r->watch.adapt) SDR_TRY(sdr_adapt_resume(r->watch.adapt, options->resume));
  SDR_TRY(sdr_checkpoint_read(options->resume, &r->moment, r->built.traits.isa, r->watch.list,
                              r->watch.count));
  r->steps_before = r->moment.step;
  r->written = r->moment.time;
  r->built.step = r->moment.step_size;
  return restart(r);
}

/* ---- the loop -------------------------------------------------------------------------------- */

/* Chosen steps may be far shorter than the longest, within which a checkpoint is due: one will do.
 */
static int is_new(const run *r)
{
  const sdr_moment *moment = &r->moment;
  return !r->built.integrator->chooses || moment->last ||
         moment->time - r->written > moment->step_size;
}

/* A run that goes on and one that is resumed here must do the same. */
static sdr_status write_checkpoint(run *r)
{
  const sdr_built *built = &r->built;
  r->written = r->moment.time;
  SDR_TRY(sdr_checkpoint_write(r->directory, &r->moment, built->traits.isa, r->watch.list,
                               r->watch.count));
  return restart(r);
}

static sdr_status observe(run *r)
{
  const double from = wall();
  sdr_moment *moment = &r->moment;
  sdr_balance balance;
  int due[SDR_WATCHERS] = {0}, wants = 0;
  moment->time = r->built.system->time;
  moment->step = r->built.system->step;
  moment->last = sdr_built_is_over(&r->built);
  moment->balance = NULL;
  for (int k = 0; k < r->watch.count; ++k)
    due[k] =
        r->watch.list[k]->ops->due && r->watch.list[k]->ops->due(r->watch.list[k], moment, &wants);
  if (wants) {
    sdr_system_balance(r->built.system, &balance);
    moment->balance = &balance;
  }
  sdr_status status = SDR_OK;
  for (int k = 0; k < r->watch.count && status == SDR_OK; ++k)
    if (due[k]) status = r->watch.list[k]->ops->look(r->watch.list[k], moment);
  if (status == SDR_OK && sdr_checkpoint_due(moment) && is_new(r)) status = write_checkpoint(r);
  moment->balance = NULL;
  r->output += wall() - from;
  return status;
}

/* Where no checkpoint was due, methods that remember earlier steps begin anew, so only those
   without such a memory keep the bits of a run that nobody stopped. */
static sdr_status stop(run *r, const char *signal)
{
  const sdr_moment *moment = &r->moment;
  if (moment->step == r->steps_before)
    return sdr_fail(SDR_STOPPED, "stopped by %s before the first step", signal);
  if (r->written < moment->time) SDR_TRY(write_checkpoint(r)); /* else it is there */
  return sdr_fail(SDR_STOPPED,
                  "stopped by %s at t = %g s, after %lld steps; to go on, give the same command "
                  "with --resume %s/checkpoint.h5",
                  signal, moment->time, (long long)moment->step, r->directory);
}

static sdr_status integrate(run *r, int resumed)
{
  const char *signal;
  if (!resumed) SDR_TRY(observe(r));
  while (!sdr_built_is_over(&r->built)) {
    if ((signal = sdr_stop_asked()) != NULL) return stop(r, signal);
    SDR_TRY(sdr_built_step(&r->built));
    SDR_TRY(observe(r));
  }
  for (int k = 0; k < r->watch.count; ++k)
    if (r->watch.list[k]->ops->finish)
      SDR_TRY(r->watch.list[k]->ops->finish(r->watch.list[k], &r->moment));
  return SDR_OK;
}

/* ---- what came out --------------------------------------------------------------------------- */

static sdr_status damage_of_points(const run *r, sdr_summary *summary)
{
  const sdr_points *points = r->built.points;
  int32_t count = 0;
  double *damage = sdr_alloc((size_t)points->count, sizeof *damage);
  if (!damage) return SDR_RUN_FAILED;
  const sdr_status status = sdr_system_field(r->built.system, "damage", damage);
  for (int32_t i = 0; status == SDR_OK && i < points->count; ++i) {
    if (!sdr_in_body(points, i)) continue;
    summary->damage_max = fmax(summary->damage_max, damage[i]);
    summary->damage_mean += damage[i];
    ++count;
  }
  summary->damage_mean /= count;
  sdr_free(damage);
  return status;
}

static sdr_status find_pieces(const run *r, sdr_summary *summary, sdr_ring_counts *ring)
{
  const sdr_output_scene *output = &r->built.scene->output;
  sdr_system *system = r->built.system;
  if (output->fragments) {
    SDR_TRY(
        sdr_pieces_write(r->directory, system, output->fragment_threshold, &summary->fragments));
    summary->fragments_known = 1;
  }
  ring->known = output->ring;
  if (!output->ring) return SDR_OK;
  SDR_TRY(sdr_through_cracks(system, r->built.plane_cut, output->ring_centre, &ring->cracks));
  SDR_TRY(
      sdr_ring_sectors(system, output->fragment_threshold, output->ring_centre, &ring->sectors));
  return SDR_OK;
}

/* Of solutions step by step. */
static void print_steps(const sdr_summary *s, const sdr_solve_record *solve, FILE *out)
{
  fprintf(out, "solver              %s: %lld unknowns, %lld factorisations, %lld iterations\n",
          solve->name, (long long)solve->unknowns, (long long)solve->factorisations,
          (long long)solve->iterations);
  fprintf(out, "steps               %lld accepted, %lld cut, %lld Newton iterations",
          (long long)solve->accepted, (long long)solve->cuts, (long long)solve->newton);
  if (solve->fallbacks > 0)
    fprintf(out, "; motion had to help %lld time%s", (long long)solve->fallbacks,
            solve->fallbacks == 1 ? "" : "s");
  fprintf(out, "\ntime                %.2f s, of it %.2f s in factors\n", s->wall_total,
          solve->factor_seconds);
}

/* What it cost. */
static void print_time(const sdr_summary *s, const sdr_solve_record *solve, FILE *out)
{
  const double steps = (double)(s->steps_run ? s->steps_run : 1);
  if (!solve->name) {
    fprintf(out, "time                %.2f s, %.3f ns per bond and step (%s, %d thread%s)\n",
            s->wall_total, s->wall_integrate * 1e9 / ((double)s->bonds * steps), s->instruction_set,
            s->threads, s->threads == 1 ? "" : "s");
    return;
  }
  if (solve->accepted > 0) {
    print_steps(s, solve, out);
    return;
  }
  fprintf(out, "solver              %s: %lld unknowns, %lld nonzeros, residual %.1e", solve->name,
          (long long)solve->unknowns, (long long)solve->nonzeros, solve->residual);
  if (solve->iterations > 0) fprintf(out, ", %lld iterations", (long long)solve->iterations);
  fprintf(out, "\nbent body's forces  differ by %.1e from the linear ones\n", solve->nonlinearity);
  fprintf(out,
          "time                %.2f s: assembled in %.2f s, factored in %.2f s, solved in %.2f s\n",
          s->wall_total, solve->assemble_seconds, solve->factor_seconds, solve->solve_seconds);
}

/* How a method that chooses its steps came through. */
static void print_method(const sdr_method_record *m, FILE *out)
{
  if (!m->name) return;
  fprintf(out, "method              %s: %lld forces, %lld iterations, order %d at the end\n",
          m->name, (long long)m->evaluations, (long long)m->iterations, m->order);
  if (m->solver)
    fprintf(out, "linear solver       %s: %lld tangents, %lld factors, %lld iterations\n",
            m->solver, (long long)m->tangents, (long long)m->factors,
            (long long)m->linear_iterations);
  fprintf(out, "steps taken back    %lld for their error, %lld for the iteration\n",
          (long long)m->error_failures, (long long)m->iteration_failures);
}

/* What an adaptive run did. */
static void print_adapt(const run *r, const sdr_summary *s, FILE *out)
{
  if (!r->watch.adapt) return;
  const sdr_adapt_record a = sdr_adapt_look(r->watch.adapt);
  fprintf(out, "points split        %lld times, from %d to %lld points; energy changed by %.2g J",
          (long long)a.events, (int)a.first_points, (long long)s->points, a.energy);
  fprintf(out, "; %.3f s, and %.3f s to choose\n", a.seconds, a.looking);
}

static void print_results(const run *r, const sdr_summary *s, const sdr_ring_counts *ring,
                          FILE *out)
{
  char time[32];
  sdr_quantity(s->time_end, "s", 6, time, sizeof time);
  fprintf(out, "%s: %lld points, %lld bonds, %lld steps to %s\n", s->scene->title,
          (long long)s->points, (long long)s->bonds, (long long)s->steps, time);
  if (r->watch.onset && isnan(s->onset_time)) fprintf(out, "onset of damage     never\n");
  sdr_quantity(s->onset_time, "s", 4, time, sizeof time);
  if (!isnan(s->onset_time)) fprintf(out, "onset of damage     %s\n", time);
  if (s->fragments_known)
    fprintf(
        out,
        "fragments           %d, the largest with %.3g %% of the points; like %.3g equal ones\n",
        (int)s->fragments.count, 100.0 * (double)s->fragments.largest / (double)s->points,
        s->fragments.effective);
  if (ring->known)
    fprintf(out, "through-cracks      %d; sectors that have come apart: %d\n", (int)ring->cracks,
            (int)ring->sectors);
  fprintf(out,
          "energy              kinetic %.5g J, stored %.5g J, dissipated %.5g J, work %.5g J\n",
          s->books.kinetic, s->books.stored, s->books.dissipated, s->books.external_work);
  fprintf(
      out,
      "imbalance           %.2e of the run's largest energy (on the way up to %.2e of the largest "
      "until then)\n",
      s->books.imbalance_relative, s->books.imbalance_largest);
  print_adapt(r, s, out);
  print_method(&r->built.system->method, out);
  print_time(s, &r->built.system->solve, out);
  sdr_figures_print(s, out);
  if (r->overridden && s->scene->figure_count > 0)
    fprintf(out, "  accepted ranges are of the scene's own settings, which --set changed\n");
  fprintf(out, "results             %s\n", r->directory);
}

/* Stripes that nothing ever reached were never computed. */
static void list_resting(run *r)
{
  sdr_built *built = &r->built;
  built->model->ops->traits(built->model, &built->traits);
  const double moved = built->traits.moved;
  if (moved >= 1.0 || built->skipped_count >= SDR_SKIPPED_MAX) return;
  snprintf(r->resting, sizeof r->resting, "regions at rest: nothing reached %.0f %% of the stripes",
           100.0 * (1.0 - moved));
  built->skipped[built->skipped_count++] = r->resting;
}

static double closest_contact(const sdr_contact *contact)
{
  sdr_contact_state state;
  if (!contact) return (double)NAN;
  sdr_contact_look(contact, &state);
  return state.closest;
}

static sdr_status summarise(run *r, FILE *out)
{
  const sdr_built *built = &r->built;
  list_resting(r);
  const double from = wall();
  sdr_ring_counts ring = {0};
  sdr_measured *measured = NULL;
  const int state_based = built->scene->model != SDR_BOND_BASED;
  sdr_material_constants constants = {0};
  if (state_based) constants = sdr_constants_of(built, 0);
  sdr_summary summary = {.scene = built->scene,
                         .constants = state_based ? &constants : NULL,
                         .commit = SUNDER_COMMIT,
                         .instruction_set = built->traits.isa,
                         .threads = sdr_threads(),
                         .points = built->points->count,
                         .bonds = built->bonds->directed,
                         .pairs = built->bonds->pairs,
                         .runs = built->bonds->run_count,
                         .loose = built->bonds->loose_pairs,
                         .steps = built->system->step,
                         .steps_run = built->system->step - r->steps_before,
                         .step_size = built->step,
                         .time_end = built->system->time,
                         .stable_step = built->stable_step,
                         .books = sdr_ledger_books(r->watch.ledger),
                         .contact_closest = closest_contact(built->contact),
                         .onset_time =
                             r->watch.onset ? sdr_onset_time(r->watch.onset) : (double)NAN,
                         .cracks = r->watch.cracks ? sdr_crack_tips_reports(r->watch.cracks) : NULL,
                         .skipped = built->skipped,
                         .skipped_count = built->skipped_count,
                         .solve = &built->system->solve,
                         .method = &built->system->method};
  SDR_TRY(damage_of_points(r, &summary));
  SDR_TRY(find_pieces(r, &summary, &ring));
  SDR_TRY(sdr_figures_measured(built->scene, &summary, &ring, r->watch.measures, &measured,
                               &summary.measured_count));
  summary.measured = measured;
  summary.wall_setup = r->setup;
  summary.wall_output = r->output + (wall() - from);
  summary.wall_total = wall() - r->started;
  summary.wall_integrate = summary.wall_total - summary.wall_setup - summary.wall_output;
  const sdr_status status = sdr_summary_write(r->directory, &summary);
  if (status == SDR_OK) print_results(r, &summary, &ring, out);
  sdr_free(measured);
  return status;
}

/* 1 if the directory holds results of another scene. */
static int holds_another(const run *r)
{
  char path[sizeof r->directory + 16];
  sdr_scene *there = NULL;
  snprintf(path, sizeof path, "%s/used.yaml", r->directory);
  if (access(path, F_OK) != 0) return 0;
  const int same =
      sdr_scene_load(path, NULL, 0, NULL, &there) == SDR_OK && there->hash == r->built.scene->hash;
  sdr_scene_destroy(&there);
  return !same;
}

/* A resumed run goes on with the history and snapshots in its directory: they must be its own. */
static sdr_status check_same_scene(const run *r)
{
  if (!holds_another(r)) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "the results in %s are of another scene, so they cannot be continued; give the "
                  "scene, --variant and --set that they were made with (see used.yaml there), or "
                  "another directory with -o",
                  r->directory);
}

static void warn(const sdr_scene *scene, const char *warning)
{
  if (warning[0]) fprintf(stderr, "sunder: warning: %s\n", warning);
  for (int k = 0; k < scene->idle_count; ++k)
    fprintf(stderr, "sunder: without effect: %s\n", scene->idle[k]);
}

static sdr_status set_up(run *r, sdr_scene **scene, const sdr_run_options *options)
{
  SDR_TRY(sdr_build_scene(scene, &r->built));
  if (options->threads > 0) sdr_set_threads(options->threads);
  SDR_TRY(sdr_figures_known(r->built.scene));
  SDR_TRY(sdr_name_directory(r->built.scene, options->directory, options->resume, r->directory));
  if (options->resume) SDR_TRY(check_same_scene(r));
  const int replaces = !options->resume && !options->quiet && holds_another(r);
  SDR_TRY(sdr_rundir_open(r->directory, options->resume != NULL, &r->lock));
  if (replaces)
    fprintf(stderr, "sunder: the results of another scene in %s are replaced\n", r->directory);
  if (!options->quiet) warn(r->built.scene, r->built.warning);
  r->moment = sdr_watch_moment(&r->built, r->directory);
  SDR_TRY(sdr_watchers_create(&r->built, &r->moment, !options->quiet, &r->watch));
  SDR_TRY(begin(r, options));
  /* Not before a checkpoint is known to fit: what lies there may be another scene's. */
  SDR_TRY(sdr_rundir_write(r->directory, "used.yaml", r->built.scene->used_yaml));
  r->setup = wall() - r->started;
  return SDR_OK;
}

/* Before anything is printed. */
static void end_progress(sdr_watchers *watch)
{
  if (watch->progress) watch->progress->ops->destroy(watch->progress);
  watch->progress = NULL;
}

static sdr_status run_body(sdr_scene **scene, double started, const sdr_run_options *options,
                           FILE *out)
{
  run r = {.lock = -1,
           .started = started,
           .written = (double)-INFINITY,
           .overridden = options->set_count > 0};
  if (options->stoppable) sdr_stop_watch();
  sdr_status status = set_up(&r, scene, options);
  if (status == SDR_OK) status = integrate(&r, options->resume != NULL);
  if (options->stoppable) sdr_stop_unwatch();
  end_progress(&r.watch);
  if (status == SDR_OK) status = summarise(&r, out);
  sdr_watchers_destroy(&r.watch);
  sdr_rundir_close(r.directory, r.lock);
  sdr_built_destroy(&r.built);
  return status;
}

sdr_status sdr_run(const sdr_run_options *options, FILE *out)
{
  const double started = wall();
  sdr_scene *scene = NULL;
  if (options->threads > 0) sdr_set_threads(options->threads);
  SDR_TRY(
      sdr_scene_load(options->scene, options->variant, options->set_count, options->sets, &scene));
  const sdr_status status = scene->equation ? sdr_run_equation(scene, options, out)
                                            : run_body(&scene, started, options, out);
  sdr_scene_destroy(&scene);
  return status;
}
