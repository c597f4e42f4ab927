#include "equation/solution.h"

#include "base/memory.h"
#include "equation/conditions.h"
#include "equation/equations.h"

#include <math.h>
#include <time.h>

static double wall(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- the linear system ----------------------------------------------------------------------- */

static sdr_status run_solver(const sdr_problem *problem, const sdr_equations_system *system,
                             sdr_solution *s)
{
  sdr_solver *solver = NULL;
  SDR_TRY(sdr_solver_create(problem->equation->solver, system->kind, &solver));
  sdr_status status = sdr_solver_factor(solver, &system->matrix);
  if (status == SDR_OK) status = sdr_solver_solve(solver, system->f, s->value);
  s->solver = sdr_solver_report_of(solver);
  sdr_solver_destroy(&solver);
  return status;
}

static sdr_status solve_system(const sdr_problem *problem, sdr_solution *s)
{
  sdr_equations_system system;
  const double started = wall();
  SDR_TRY(sdr_equations_assemble(problem, &system));
  const double assembled = wall();
  s->unknowns = system.matrix.rows;
  s->nonzeros = system.matrix.row[system.matrix.rows];
  const sdr_status status = run_solver(problem, &system, s);
  s->assemble_seconds = assembled - started;
  s->solve_seconds = wall() - assembled;
  sdr_equations_destroy(&system);
  return status;
}

/* ---- what is exact --------------------------------------------------------------------------- */

/* The formulas at all points; *out NULL if the first is not given. */
static sdr_status evaluate(const sdr_problem *problem, sdr_expression *const *formula, int width,
                           double **out)
{
  const int32_t count = problem->points->count;
  if (width == 0 || !formula[0]) return SDR_OK;
  *out = sdr_alloc((size_t)width * (size_t)count, sizeof **out);
  if (!*out) return SDR_RUN_FAILED;
  for (int c = 0; c < width; ++c)
    for (int32_t i = 0; i < count; ++i) {
      double x[3];
      sdr_problem_place(problem, i, x);
      SDR_TRY(sdr_equation_value(formula[c], problem->equation->origin, "the exact solution", x,
                                 &(*out)[c * count + i]));
    }
  return SDR_OK;
}

static void find_stress(const sdr_problem *problem, sdr_solution *s)
{
  const int32_t count = problem->points->count;
  for (int32_t i = 0; i < count; ++i) {
    double gradient[3][3] = {{0.0}}, stress[SDR_EQUATION_STRESSES];
    for (int c = 0; c < problem->components; ++c)
      for (int a = 0; a < problem->components; ++a)
        gradient[c][a] = sdr_operator_at(&problem->op, problem->d[a], i, s->value + c * count);
    problem->ops->stress(problem, gradient, stress);
    for (int k = 0; k < s->stresses; ++k) s->stress[k * count + i] = stress[k];
  }
}

/* ---- errors ---------------------------------------------------------------------------------- */

/* Of a field of `width` components, of which those from `twice` on stand for two. */
static double relative_error(const sdr_problem *problem, int width, int twice, const double *value,
                             const double *exact)
{
  const int32_t count = problem->points->count;
  double wrong = 0.0, all = 0.0;
  if (!exact) return (double)NAN;
  for (int c = 0; c < width; ++c)
    for (int32_t i = 0; i < count; ++i) {
      const double right = exact[c * count + i], off = value[c * count + i] - right;
      const double weight = problem->held[i] ? 0.0 : c >= twice ? 2.0 : 1.0;
      wrong += weight * off * off;
      all += weight * right * right;
    }
  return all > 0.0 ? sqrt(wrong / all) : (double)NAN;
}

static double largest_error(const sdr_problem *problem, const sdr_solution *s)
{
  const int32_t count = problem->points->count;
  double wrong = 0.0, all = 0.0;
  if (!s->exact) return (double)NAN;
  for (int32_t i = 0; i < count; ++i) {
    double off = 0.0, size = 0.0;
    for (int c = 0; c < s->width && !problem->held[i]; ++c) {
      off += pow(s->value[c * count + i] - s->exact[c * count + i], 2.0);
      size += pow(s->exact[c * count + i], 2.0);
    }
    wrong = fmax(wrong, off);
    all = fmax(all, size);
  }
  return all > 0.0 ? sqrt(wrong / all) : (double)NAN;
}

static void find_errors(const sdr_problem *problem, sdr_solution *s)
{
  s->error_l2 = relative_error(problem, s->width, s->width, s->value, s->exact);
  s->error_max = largest_error(problem, s);
  s->error_stress =
      relative_error(problem, s->stresses, problem->components, s->stress, s->exact_stress);
}

static sdr_status solve(const sdr_problem *problem, sdr_solution *s)
{
  const size_t count = (size_t)problem->points->count;
  s->value = sdr_alloc((size_t)problem->fields * count, sizeof *s->value);
  if (!s->value) return SDR_RUN_FAILED;
  SDR_TRY(evaluate(problem, problem->equation->exact, s->width, &s->exact));
  SDR_TRY(evaluate(problem, problem->equation->exact_stress, s->stresses, &s->exact_stress));
  SDR_TRY(solve_system(problem, s));
  if (s->stresses > 0) {
    s->stress = sdr_alloc((size_t)s->stresses * count, sizeof *s->stress);
    if (!s->stress) return SDR_RUN_FAILED;
    find_stress(problem, s);
  }
  find_errors(problem, s);
  return SDR_OK;
}

sdr_status sdr_problem_solve(const sdr_problem *problem, sdr_solution *out)
{
  const int n = problem->components;
  sdr_solution s = {.width = problem->words->is_vector ? n : 1,
                    .stresses = problem->ops->stress ? n * (n + 1) / 2 : 0};
  const sdr_status status = solve(problem, &s);
  if (status == SDR_OK)
    *out = s;
  else
    sdr_solution_destroy(&s);
  return status;
}

void sdr_solution_destroy(sdr_solution *solution)
{
  sdr_free(solution->value);
  sdr_free(solution->exact);
  sdr_free(solution->stress);
  sdr_free(solution->exact_stress);
  *solution = (sdr_solution){0};
}
