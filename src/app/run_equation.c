#include "app/run_equation.h"

#include "app/directory.h"
#include "app/equation_files.h"
#include "app/figures.h"
#include "base/parallel.h"
#include "output/rundir.h"

#include <math.h>
#include <time.h>

#ifndef SUNDER_COMMIT
#define SUNDER_COMMIT "unknown"
#endif

enum { FIGURES = 6, MOST_LEVELS = SDR_EQUATION_COARSER + 1 };

typedef struct {
  sdr_problem *problem;
  sdr_solution solution;
  char directory[SDR_DIRECTORY];
  int lock, level_count;
  sdr_study_level level[MOST_LEVELS];
  sdr_measured measured[FIGURES];
} state;

static double wall(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- figures --------------------------------------------------------------------------------- */

/* log of the errors' ratio over that of the spacings. */
static double order_of(double coarse, double fine, double coarse_spacing, double fine_spacing)
{
  return log(coarse / fine) / log(coarse_spacing / fine_spacing);
}

/* Values are NAN before the run, and where there is nothing to measure. */
static void measure(state *s, const sdr_equation *equation)
{
  const int is_exact = equation->exact[0] != NULL, is_study = equation->coarser_count > 0;
  const int is_stress = equation->exact_stress[0] != NULL;
  const sdr_study_level none = {.error_l2 = NAN, .error_max = NAN, .error_stress = NAN};
  const sdr_study_level last = s->level_count > 0 ? s->level[s->level_count - 1] : none;
  const sdr_study_level before = s->level_count > 1 ? s->level[s->level_count - 2] : none;
  const double order = order_of(before.error_l2, last.error_l2, before.spacing, last.spacing);
  const double stress_order =
      order_of(before.error_stress, last.error_stress, before.spacing, last.spacing);
  const sdr_shape_tensors *shape = s->problem ? &s->problem->shape : NULL;
  const double worst = shape ? shape->condition[shape->worst] : (double)NAN;
  const sdr_measured measured[FIGURES] = {{"error_l2", last.error_l2, is_exact},
                                          {"error_max", last.error_max, 0},
                                          {"error_stress", last.error_stress, is_stress},
                                          {"order", order, is_exact && is_study},
                                          {"order_stress", stress_order, is_stress && is_study},
                                          {"condition_worst", worst, 0}};
  for (int k = 0; k < FIGURES; ++k) s->measured[k] = measured[k];
}

/* ---- solving --------------------------------------------------------------------------------- */

static void remember(state *s, const sdr_problem *problem, const sdr_solution *solution)
{
  s->level[s->level_count++] = (sdr_study_level){
      .spacing = problem->scene->points.spacing,
      .points = problem->points->count,
      .error_l2 = solution->error_l2,
      .error_max = solution->error_max,
      .error_stress = solution->error_stress,
  };
}

/* The same scene at a coarser spacing; only its errors are kept. */
static sdr_status solve_coarser(state *s, const sdr_scene *scene, double spacing)
{
  sdr_scene coarser = *scene;
  sdr_problem *problem = NULL;
  sdr_solution solution = {0};
  coarser.points.spacing = spacing;
  SDR_TRY(sdr_problem_create(&coarser, &problem));
  const sdr_status status = sdr_problem_solve(problem, &solution);
  if (status == SDR_OK) remember(s, problem, &solution);
  sdr_solution_destroy(&solution);
  sdr_problem_destroy(&problem);
  return status;
}

static sdr_status solve(state *s, const sdr_scene *scene)
{
  const sdr_equation *equation = scene->equation;
  for (int k = 0; k < equation->coarser_count; ++k)
    SDR_TRY(solve_coarser(s, scene, equation->coarser[k]));
  SDR_TRY(sdr_problem_solve(s->problem, &s->solution));
  remember(s, s->problem, &s->solution);
  measure(s, equation);
  return SDR_OK;
}

/* ---- in words -------------------------------------------------------------------------------- */

static void print_operators(const sdr_problem *p, FILE *out)
{
  const sdr_equation *e = p->equation;
  const double neighbours = (double)p->support.row[p->points->count] / (double)p->points->count;
  fprintf(out, "equation            %s: %s\n", p->words->word, p->words->formula);
  fprintf(out, "form                %s", e->variational ? "variational" : "collocation");
  if (e->variational) fprintf(out, ", operator energy %.4g", e->penalty);
  fprintf(out, "\noperators           of order %d, %.1f neighbours a point, weight %s\n", e->order,
          neighbours, sdr_influence_name(p->shape.influence));
  fprintf(out, "condition numbers   %.3g on average, %.3g at %s", sdr_problem_mean_condition(p),
          p->shape.condition[p->shape.worst],
          sdr_point_named(&p->support.cloud, p->shape.worst).text);
  if (p->shape.enlarged > 0) fprintf(out, "; %d supports enlarged", (int)p->shape.enlarged);
  fputc('\n', out);
}

static void print_level(const state *s, int k, FILE *out)
{
  const sdr_study_level *level = &s->level[k], *before = k > 0 ? level - 1 : level;
  fprintf(out, "spacing %-11.4g %d points", level->spacing, (int)level->points);
  if (!isnan(level->error_l2)) fprintf(out, ", error %.3e", level->error_l2);
  if (k > 0 && !isnan(level->error_l2))
    fprintf(out, " (order %.2f)",
            order_of(before->error_l2, level->error_l2, before->spacing, level->spacing));
  if (!isnan(level->error_stress)) fprintf(out, ", of the stress %.3e", level->error_stress);
  if (k > 0 && !isnan(level->error_stress))
    fprintf(out, " (order %.2f)",
            order_of(before->error_stress, level->error_stress, before->spacing, level->spacing));
  fputc('\n', out);
}

static void print_results(const state *s, const sdr_equation_run *run, FILE *out)
{
  const sdr_scene *scene = s->problem->scene;
  const sdr_solution *solution = &s->solution;
  const sdr_summary figures = {
      .scene = scene, .measured = run->measured, .measured_count = run->measured_count};
  fprintf(out, "%s: %d points\n", scene->title, (int)s->problem->points->count);
  print_operators(s->problem, out);
  fprintf(out, "solver              %s: %lld unknowns, %lld nonzeros, residual %.1e\n",
          solution->solver.name, (long long)solution->unknowns, (long long)solution->nonzeros,
          solution->solver.residual);
  for (int k = 0; k < s->level_count; ++k) print_level(s, k, out);
  fprintf(out, "time                %.2f s: set up in %.2f s, solved in %.2f s\n",
          run->total_seconds, run->setup_seconds, run->solve_seconds);
  sdr_figures_print(&figures, out);
  fprintf(out, "results             %s\n", s->directory);
}

/* ---- the run --------------------------------------------------------------------------------- */

static sdr_status set_up(state *s, sdr_scene *scene, const sdr_run_options *options)
{
  if (options->resume)
    return sdr_fail(SDR_BAD_INPUT,
                    "--resume: an equation is solved at once, so there is nothing to go on with; "
                    "run the scene without it");
  if (scene->threads > 0 && options->threads == 0) sdr_set_threads(scene->threads);
  measure(s, scene->equation);
  SDR_TRY(sdr_figures_check(scene, s->measured, FIGURES));
  SDR_TRY(sdr_name_directory(scene, options->directory, NULL, s->directory));
  SDR_TRY(sdr_problem_create(scene, &s->problem));
  SDR_TRY(sdr_rundir_open(s->directory, 0, &s->lock));
  return sdr_rundir_write(s->directory, "used.yaml", scene->used_yaml);
}

static sdr_status write_all(state *s, double started, double set, double solved, FILE *out)
{
  sdr_equation_run run = {.problem = s->problem,
                          .solution = &s->solution,
                          .directory = s->directory,
                          .commit = SUNDER_COMMIT,
                          .threads = sdr_threads(),
                          .level_count = s->level_count,
                          .level = s->level,
                          .measured = s->measured,
                          .measured_count = FIGURES,
                          .setup_seconds = set - started,
                          .solve_seconds = solved - set};
  if (s->problem->scene->output.snapshots > 0) SDR_TRY(sdr_equation_write_frame(&run));
  run.output_seconds = wall() - solved;
  run.total_seconds = wall() - started;
  SDR_TRY(sdr_equation_write_summary(&run));
  print_results(s, &run, out);
  return SDR_OK;
}

sdr_status sdr_run_equation(sdr_scene *scene, const sdr_run_options *options, FILE *out)
{
  const double started = wall();
  double set = started;
  state s = {.lock = -1};
  sdr_status status = set_up(&s, scene, options);
  if (status == SDR_OK) {
    set = wall();
    status = solve(&s, scene);
  }
  if (status == SDR_OK) status = write_all(&s, started, set, wall(), out);
  sdr_solution_destroy(&s.solution);
  sdr_problem_destroy(&s.problem);
  sdr_rundir_close(s.directory, s.lock);
  return status;
}

sdr_status sdr_check_equation(sdr_scene *scene, FILE *out)
{
  state s = {.lock = -1};
  if (scene->threads > 0) sdr_set_threads(scene->threads);
  measure(&s, scene->equation);
  SDR_TRY(sdr_figures_check(scene, s.measured, FIGURES));
  SDR_TRY(sdr_name_directory(scene, NULL, NULL, s.directory));
  SDR_TRY(sdr_problem_create(scene, &s.problem));
  const sdr_status status = sdr_rundir_try(s.directory);
  if (status != SDR_OK) {
    sdr_problem_destroy(&s.problem);
    return status;
  }
  const int32_t count = s.problem->points->count;
  fprintf(out, "%s\n", scene->title);
  print_operators(s.problem, out);
  fprintf(out, "points              %d, spacing %g mm, %lld unknowns; solver %s\n", (int)count,
          scene->points.spacing * 1e3, (long long)count * s.problem->fields,
          scene->equation->solver);
  for (int k = 0; k < scene->equation->coarser_count; ++k)
    fprintf(out, "before that         spacing %g mm\n", scene->equation->coarser[k] * 1e3);
  fprintf(out, "defaults\n");
  for (int k = 0; k < scene->default_count; ++k) fprintf(out, "  %s\n", scene->defaults[k]);
  sdr_problem_destroy(&s.problem);
  return SDR_OK;
}
