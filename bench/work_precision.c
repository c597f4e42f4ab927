/* what each integrator costs for the error that it makes */
#include "app/build.h"
#include "app/plot_gnuplot.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/tangent.h"
#include "support/report.h"

#include <gsl/gsl_eigen.h>
#include <math.h>
#include <string.h>

/* Processor time of the steps alone, on one thread; errors at the end, relative root mean squares
   against the reference; |energy - start - work| over the energy. */
typedef struct {
  double seconds, motion, damage, imbalance;
  long long steps, evaluations;
} outcome;

typedef struct {
  const char *name, *title, *text;
  int has_damage;
} problem;

#define RING                                                                                       \
  "dimension: plane_stress\n"                                                                      \
  "points: {shape: {annulus: {inner: 81 mm, outer: 149 mm}}, spacing: 5 mm}\n"                     \
  "material: {young: 210 GPa, density: 7850 kg/m^3, toughness: 2e4 J/m^2}\n"                       \
  "loads: [{pressure: {on: inner, value: 400 MPa * exp(-t/(100 us))}}]\n"                          \
  "output: {snapshots: 0}\n"

static const problem problems[] = {
    {"bar", "elastic bar, against its series",
     "dimension: 1d\n"
     "points: {shape: {interval: {from: 0 m, to: 1 m}}, spacing: 5 mm}\n"
     "material: {young: 200 GPa, density: 7800 kg/m^3}\n"
     "initial: {displacement: [\"1 mm * (sin(1.570796327 * x/(1 m)) + 0.2 * sin(7.853981634 * x/(1 "
     "m)))\"]}\n"
     "supports: [{on: left, displacement: {x: 0}}]\n"
     "output: {snapshots: 0}\n"
     "time: {end: 1 ms}\n",
     0},
    {"ring", "elastic ring, suddenly loaded", RING "time: {end: 60 us}\n", 0},
    {"broken", "ring with variational damage",
     RING "damage: {law: variational, ell: 2 horizon}\n"
          "time: {end: 60 us}\n",
     1},
};

/* Series of one picture. Levels are shares of leapfrog's limit, or tolerances. */
typedef struct {
  const char *name, *how, *colour;
  int by_step;
  double level[6];
  double
      allowed[3]; /* times leapfrog's cost at equal error, by the prototypes, times 1.3; 0: none */
} series;

static const series all[] = {
    {"leapfrog", "leapfrog", "#000000", 1, {0.9, 0.45, 0.22, 0.1, 0.05, 0.02}, {0, 0, 0}},
    {"energy_momentum", "energy_momentum", "#cc79a7", 1, {1.6, 0.8, 0.4, 0.2}, {0, 0, 0}},
    {"CVODE Adams",
     "cvode, method: adams",
     "#0072b2",
     0,
     {1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8},
     {0, 0, 19.5}},
    {"CVODE BDF 2, pcg", "cvode", "#882255", 0, {1e-3, 1e-4, 1e-5, 1e-6}, {0, 0, 0}},
    {"CVODE BDF, pcg",
     "cvode, order: 5",
     "#d55e00",
     0,
     {1e-3, 1e-4, 1e-5, 1e-6, 1e-7},
     {0, 0, 5.0}},
    {"CVODE BDF, stale",
     "cvode, order: 5, solver: stale",
     "#e69f00",
     0,
     {1e-3, 1e-4, 1e-5},
     {0, 0, 13.0}},
    {"CVODE BDF, cholmod",
     "cvode, order: 5, solver: cholmod",
     "#56b4e9",
     0,
     {1e-3, 1e-4, 1e-5},
     {0, 0, 13.0}},
    {"CVODE BDF, klu", "cvode, order: 5, solver: klu", "#999999", 0, {1e-3, 1e-4}, {0, 0, 0}},
    {"CVODE BDF, umfpack",
     "cvode, order: 5, solver: umfpack",
     "#bbaa66",
     0,
     {1e-3, 1e-4},
     {0, 0, 0}},
    {"IDA, pcg", "ida", "#009e73", 0, {1e-3, 1e-4, 1e-5, 1e-6}, {0, 0, 19.5}},
};
enum {
  PROBLEMS = sizeof problems / sizeof *problems,
  SERIES = sizeof all / sizeof *all,
  LEVELS = 6
};

typedef struct {
  char directory[BENCH_PATH];
  FILE *csv;
  double limit; /* s: leapfrog's */
  int32_t count, components;
  double *motion, *damage; /* the reference: u by components; damage of points */
  outcome out[PROBLEMS][SERIES][LEVELS];
  int known[PROBLEMS][SERIES][LEVELS];
} study;

/* ---- runs ------------------------------------------------------------------------------------ */

static sdr_status build(const study *s, const problem *p, const char *how, sdr_built *out)
{
  char path[2 * BENCH_PATH];
  snprintf(path, sizeof path, "%s/%s.yaml", s->directory, p->name);
  FILE *file = fopen(path, "w");
  if (!file) return sdr_fail(SDR_IO_ERROR, "cannot write %s", path);
  const char *time = strstr(p->text, "time: {") + strlen("time: {");
  fprintf(file, "%.*s%s, %s", (int)(time - p->text), p->text, how, time);
  if (fclose(file) != 0) return sdr_fail(SDR_IO_ERROR, "cannot write %s", path);
  return sdr_build(path, NULL, 0, NULL, out);
}

static double energy_of(sdr_system *system)
{
  sdr_balance balance;
  sdr_system_balance(system, &balance);
  return balance.kinetic + balance.model.stored + balance.model.dissipated;
}

/* To the end of the run, which steps of a fixed length must divide. */
static sdr_status integrate(sdr_built *run, outcome *out)
{
  sdr_system *system = run->system;
  const double end = run->scene->time.end, from = bench_processor_clock();
  SDR_TRY(run->integrator->start(system, run->step));
  const double start = energy_of(system);
  while (system->time < end * (1.0 - 1e-9)) SDR_TRY(run->integrator->step(system, run->step));
  out->seconds = bench_processor_clock() - from;
  out->steps = (long long)system->step;
  out->evaluations = system->method.name ? (long long)system->method.evaluations : out->steps;
  const double energy = energy_of(system);
  out->imbalance = fabs(energy - start - system->external_work) / energy;
  return SDR_OK;
}

static double compare(const double *a, const double *b, int32_t count)
{
  double over = 0.0, whole = 0.0;
  for (int32_t k = 0; k < count; ++k) {
    over += (a[k] - b[k]) * (a[k] - b[k]);
    whole += b[k] * b[k];
  }
  return whole > 0.0 ? sqrt(over / whole) : 0.0;
}

/* u and damage of a run that has come to its end. */
static sdr_status look(sdr_built *run, double *motion, double *damage)
{
  SDR_TRY(sdr_system_field(run->system, "displacement", motion));
  return sdr_system_field(run->system, "damage", damage);
}

static sdr_status judge(const study *s, sdr_built *run, outcome *out)
{
  double *motion = sdr_alloc((size_t)(s->count * s->components), sizeof *motion);
  double *damage = sdr_alloc((size_t)s->count, sizeof *damage);
  sdr_status status = motion && damage ? look(run, motion, damage) : SDR_RUN_FAILED;
  if (status == SDR_OK) {
    out->motion = compare(motion, s->motion, s->count * s->components);
    out->damage = compare(damage, s->damage, s->count);
  }
  sdr_free(motion);
  sdr_free(damage);
  return status;
}

static sdr_status run_level(const study *s, const problem *p, const series *r, double level,
                            outcome *out)
{
  char how[160];
  sdr_built run;
  const double end = p->has_damage || strcmp(p->name, "ring") == 0 ? 60e-6 : 1e-3;
  if (r->by_step) {
    const double steps = ceil(end / (level * s->limit));
    snprintf(how, sizeof how, "integrator: %s, step: %.17g s", r->how, end / steps);
  } else {
    snprintf(how, sizeof how, "integrator: %s, tolerance: %g", r->how, level);
  }
  SDR_TRY(build(s, p, how, &run));
  sdr_status status = integrate(&run, out);
  if (status == SDR_OK) status = judge(s, &run, out);
  sdr_built_destroy(&run);
  return status;
}

/* ---- references ------------------------------------------------------------------------------ */

/* M^-1/2 K M^-1/2 over the free components of a bar whose first `held` points rest. */
static sdr_status fill_matrix(sdr_built *run, int32_t held, gsl_matrix *matrix)
{
  sdr_csr k = {0};
  SDR_TRY(sdr_tangent_assemble(run->model, run->system->u, &k));
  for (int32_t r = held; r < k.rows; ++r)
    for (int64_t p = k.row[r]; p < k.row[r + 1]; ++p) {
      const int32_t c = k.column[p];
      if (c >= held)
        gsl_matrix_set(matrix, (size_t)(r - held), (size_t)(c - held),
                       k.value[p] / sqrt(run->system->mass[r] * run->system->mass[c]));
    }
  sdr_csr_destroy(&k);
  return SDR_OK;
}

/* u(t) = sum over the modes of cos(omega t) phi (phi . M u(0)): strain is linear in 1-D. */
static void sum_series(const sdr_built *run, int32_t held, const gsl_vector *value,
                       const gsl_matrix *mode, double *u)
{
  const size_t n = value->size;
  const double *mass = run->system->mass + held, *start = run->system->u[0] + held;
  for (size_t m = 0; m < n; ++m) {
    double share = 0.0;
    for (size_t i = 0; i < n; ++i) share += gsl_matrix_get(mode, i, m) * sqrt(mass[i]) * start[i];
    share *= cos(sqrt(gsl_vector_get(value, m)) * run->scene->time.end);
    for (size_t i = 0; i < n; ++i)
      u[held + (int32_t)i] += share * gsl_matrix_get(mode, i, m) / sqrt(mass[i]);
  }
}

static sdr_status bar_reference(study *s, sdr_built *run)
{
  const int32_t held = sdr_supports_count(run->supports);
  const size_t n = (size_t)(run->system->count - held);
  gsl_matrix *matrix = gsl_matrix_calloc(n, n), *mode = gsl_matrix_alloc(n, n);
  gsl_vector *value = gsl_vector_alloc(n);
  gsl_eigen_symmv_workspace *space = gsl_eigen_symmv_alloc(n);
  for (int32_t i = 0; i < held; ++i) run->system->u[0][i] = 0.0;
  const sdr_status status = fill_matrix(run, held, matrix);
  if (status == SDR_OK) {
    gsl_eigen_symmv(matrix, value, mode, space);
    sum_series(run, held, value, mode, s->motion);
  }
  gsl_eigen_symmv_free(space);
  gsl_vector_free(value);
  gsl_matrix_free(mode);
  gsl_matrix_free(matrix);
  return status;
}

/* Adams at a tiny tolerance where nothing breaks, else leapfrog at a tiny step. */
static sdr_status make_reference(study *s, const problem *p)
{
  sdr_built run;
  outcome unused;
  SDR_TRY(build(s, p,
                p->has_damage ? "integrator: leapfrog, step: 0.002 us"
                              : "integrator: cvode, method: adams, tolerance: 1e-12",
                &run));
  s->limit = run.stable_step;
  s->count = run.system->count;
  s->components = run.system->components;
  sdr_free(s->motion);
  sdr_free(s->damage);
  s->motion = sdr_alloc((size_t)(s->count * s->components), sizeof(double));
  s->damage = sdr_alloc((size_t)s->count, sizeof(double));
  sdr_status status = s->motion && s->damage ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK && s->components == 1)
    status = bar_reference(s, &run);
  else if (status == SDR_OK) {
    status = integrate(&run, &unused);
    if (status == SDR_OK) status = look(&run, s->motion, s->damage);
  }
  sdr_built_destroy(&run);
  return status;
}

/* ---- table ----------------------------------------------------------------------------------- */

/* What leapfrog costs for an error, by its own runs: between them, and beyond by its order. Larger
   errors than that of its longest step it cannot have. */
static double leapfrog_cost(const study *s, int p, double error)
{
  const outcome *o = s->out[p][0];
  if (error >= o[0].motion) return o[0].seconds;
  for (int k = 1; k < LEVELS; ++k)
    if (s->known[p][0][k] && error >= o[k].motion) {
      const double share = log(o[k - 1].motion / error) / log(o[k - 1].motion / o[k].motion);
      return o[k - 1].seconds * pow(o[k].seconds / o[k - 1].seconds, share);
    }
  return o[LEVELS - 1].seconds * sqrt(o[LEVELS - 1].motion / error);
}

static void put(study *s, int p, int r, int k)
{
  const outcome *o = &s->out[p][r][k];
  const double ratio = o->seconds / leapfrog_cost(s, p, o->motion);
  const double allowed = all[r].allowed[p];
  fprintf(s->csv, "%s,%s,%g,%.6g,%.4e,%.4e,%.4e,%lld,%lld,%.4g\n", problems[p].name, all[r].name,
          all[r].level[k], o->seconds, o->motion, o->damage, o->imbalance, o->steps, o->evaluations,
          ratio);
  fflush(s->csv);
  printf("  %-19s %8g %9.3f %9.1e %9.1e %9.1e %7lld %8lld %8.2f", all[r].name, all[r].level[k],
         o->seconds, o->motion, o->damage, o->imbalance, o->steps, o->evaluations, ratio);
  if (allowed > 0.0 && o->motion < 1e-2)
    printf("  %s %.3g", ratio <= allowed ? "<=" : "> ", allowed);
  printf("\n");
  fflush(stdout);
}

static sdr_status run_problem(study *s, int p)
{
  SDR_TRY(make_reference(s, &problems[p]));
  printf("%s\n  %-19s %8s %9s %9s %9s %9s %7s %8s %8s\n", problems[p].title, "", "level", "cpu s",
         "error u", "damage", "imbalance", "steps", "forces", "leapfrog");
  for (int r = 0; r < SERIES; ++r)
    for (int k = 0; k < LEVELS && all[r].level[k] > 0.0; ++k) {
      const sdr_status status =
          run_level(s, &problems[p], &all[r], all[r].level[k], &s->out[p][r][k]);
      s->known[p][r][k] = status == SDR_OK;
      if (status == SDR_OK)
        put(s, p, r, k);
      else
        printf("  %-19s %8g %s\n", all[r].name, all[r].level[k], sdr_error_message());
    }
  return SDR_OK;
}

/* ---- picture --------------------------------------------------------------------------------- */

static void put_data(const study *s, FILE *script)
{
  for (int p = 0; p < PROBLEMS; ++p)
    for (int r = 0; r < SERIES; ++r) {
      fprintf(script, "$d%d%d << E\n", p, r);
      for (int k = 0; k < LEVELS; ++k)
        if (s->known[p][r][k])
          fprintf(script, "%g %g %g\n", s->out[p][r][k].seconds, s->out[p][r][k].motion,
                  s->out[p][r][k].imbalance);
      fputs("E\n", script);
    }
}

static void plot(FILE *script, int p, int column, int named)
{
  fputs("plot ", script);
  for (int r = 0; r < SERIES; ++r)
    fprintf(script, "%s$d%d%d u 1:%d w lp lw 2 pt 7 ps 0.8 lc '%s' %s%s%s", r ? ", " : "", p, r,
            column, all[r].colour, named ? "t '" : "notitle", named ? all[r].name : "",
            named ? "'" : "");
  fputc('\n', script);
}

static sdr_status draw(const study *s)
{
  char path[2 * BENCH_PATH];
  sdr_picture picture;
  SDR_TRY(sdr_picture_begin(&picture, 1800, 1000, 17.0));
  FILE *script = picture.script;
  put_data(s, script);
  fputs("set border 3\nset xtics nomirror out\nset ytics nomirror out\nset mxtics 1\nset mytics "
        "1\nset grid lc '#dddddd'\nset logscale xy\n"
        "set format '%.0e'\nset xtics 10\nset ytics 100\nset xlabel 'processor time, s'\n",
        script);
  for (int p = 0; p < PROBLEMS; ++p)
    for (int row = 0; row < 2; ++row) {
      sdr_picture_place(&picture, (sdr_area){130.0 + 590.0 * p, 590.0 - 500.0 * row, 430, 350});
      fprintf(script, "set title '%s'\nset ylabel '%s'\nset key %s\n",
              row == 0 ? problems[p].title : "", row == 0 ? "error of u" : "imbalance",
              p == 0 && row == 1 ? "left bottom font ',11' samplen 1.5 spacing 0.9" : "off");
      plot(script, p, 2 + row, p == 0 && row == 1);
    }
  snprintf(path, sizeof path, "%s/work_precision.png", s->directory);
  SDR_TRY(sdr_picture_end(&picture, path));
  printf("table: %s/work_precision.csv, picture: %s\n", s->directory, path);
  return SDR_OK;
}

static sdr_status run_all(study *s)
{
  SDR_TRY(bench_directory("work_precision", s->directory));
  SDR_TRY(bench_csv(s->directory, "work_precision", &s->csv));
  fputs("problem,integrator,step_or_tolerance,cpu_seconds,error_u,error_damage,imbalance,steps,"
        "force_evaluations,cost_over_leapfrog_at_equal_error\n",
        s->csv);
  sdr_set_threads(1);
  sdr_status status = SDR_OK;
  for (int p = 0; p < PROBLEMS && status == SDR_OK; ++p) status = run_problem(s, p);
  if (fclose(s->csv) != 0 && status == SDR_OK)
    status = sdr_fail(SDR_IO_ERROR, "%s: disk full", s->directory);
  return status == SDR_OK ? draw(s) : status;
}

int main(void)
{
  static study s;
  const sdr_status status = run_all(&s);
  if (status != SDR_OK) fprintf(stderr, "work_precision: %s\n", sdr_error_message());
  sdr_free(s.motion);
  sdr_free(s.damage);
  printf("%s\n", bench_origin());
  return (int)status;
}
