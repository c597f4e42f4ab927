/* what each feature that a scene does not need would cost it */
#include "app/build.h"
#include "app/find_scene.h"
#include "app/plot_gnuplot.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/tangent.h"
#include "nom/neighbourhood.h"
#include "support/body.h"
#include "support/report.h"
#include "time/integrator.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 9, MOST_CASES = 24 };

/* One feature: seconds of the same work with it and without it, round by round. */
typedef struct {
  const char *feature, *scene, *unit;
  double with[ROUNDS], without[ROUNDS];
  double bytes; /* a point, that the feature would hold beside; NAN: not measured */
} row;

typedef struct {
  row rows[MOST_CASES];
  int count;
} table;

static int by_size(const void *a, const void *b)
{
  const double left = *(const double *)a, right = *(const double *)b;
  return (left > right) - (left < right);
}

static double median(const double values[ROUNDS])
{
  double sorted[ROUNDS];
  memcpy(sorted, values, sizeof sorted);
  qsort(sorted, ROUNDS, sizeof *sorted, by_size);
  return sorted[ROUNDS / 2];
}

/* Share of the time with the feature that leaving it out saves: median, and the least and largest
   of the rounds. */
typedef struct {
  double median, least, most;
} saving;

static saving saving_of(const row *r)
{
  double share[ROUNDS];
  for (int k = 0; k < ROUNDS; ++k) share[k] = 1.0 - r->without[k] / r->with[k];
  qsort(share, ROUNDS, sizeof *share, by_size);
  return (saving){share[ROUNDS / 2], share[0], share[ROUNDS - 1]};
}

static row *new_row(table *t, const char *feature, const char *scene, const char *unit)
{
  row *r = &t->rows[t->count++];
  *r = (row){.feature = feature, .scene = scene, .unit = unit, .bytes = (double)NAN};
  fprintf(stderr, "%s, %s ...\n", feature, scene);
  return r;
}

/* ---- steps of bodies ------------------------------------------------------------------------- */

/* Seconds a directed bond of one step, over about 20 ms. */
static sdr_status time_steps(bench_body *body, int steps, double *seconds)
{
  const double from = bench_processor_clock();
  for (int k = 0; k < steps; ++k) SDR_TRY(sdr_leapfrog.step(body->system, body->step));
  *seconds = (bench_processor_clock() - from) / steps / (double)body->model->bonds;
  return SDR_OK;
}

static sdr_status time_pair(bench_body *with, bench_body *without, row *r)
{
  double once;
  int steps = 1;
  for (int round = -1; round < ROUNDS; ++round) {
    SDR_TRY(time_steps(with, steps, round < 0 ? &once : &r->with[round]));
    SDR_TRY(time_steps(without, steps, round < 0 ? &once : &r->without[round]));
    if (round < 0) steps = (int)fmax(1.0, fmin(200.0, 0.03 / (once * (double)with->model->bonds)));
  }
  return SDR_OK;
}

/* A body's bytes a point while it stands. */
static sdr_status create(const bench_how *how, sdr_status (*prepare)(bench_body *),
                         bench_body *body, double *bytes)
{
  const double before = (double)sdr_memory_now();
  SDR_TRY(bench_body_create(how, body));
  if (prepare) SDR_TRY(prepare(body));
  *bytes = ((double)sdr_memory_now() - before) / body->points->count;
  return SDR_OK;
}

/* Measure the body of `with`, made ready by `prepare` (NULL: as it is), beside that of `without`.
 */
static sdr_status compare(const bench_how *with, sdr_status (*prepare)(bench_body *),
                          const bench_how *without, row *r)
{
  bench_body a = {0}, b = {0};
  double a_bytes = 0.0, b_bytes = 0.0;
  sdr_status status = create(with, prepare, &a, &a_bytes);
  if (status == SDR_OK) status = create(without, NULL, &b, &b_bytes);
  if (status == SDR_OK) status = time_pair(&a, &b, r);
  r->bytes = a_bytes - b_bytes;
  bench_body_destroy(&a);
  bench_body_destroy(&b);
  return status;
}

static sdr_status give_moduli_to_points(bench_body *body)
{
  sdr_bond_body *bonds = &((sdr_bond_model *)body->model)->body;
  const size_t padded = sdr_points_padded(body->points);
  bonds->stiffness_at = sdr_alloc(padded, sizeof(double));
  bonds->threshold_at = sdr_alloc(padded, sizeof(double));
  if (!bonds->stiffness_at || !bonds->threshold_at) return SDR_RUN_FAILED;
  for (size_t i = 0; i < padded; ++i) {
    bonds->stiffness_at[i] = bonds->stiffness;
    bonds->threshold_at[i] = bonds->threshold;
  }
  return SDR_OK;
}

static int mark_nothing(const void *context, const double a[3], const double b[3])
{
  (void)context;
  (void)a;
  (void)b;
  return 0;
}

static sdr_status look_at_every_flag(bench_body *body)
{
  int64_t cut;
  sdr_bond_model *model = (sdr_bond_model *)body->model;
  SDR_TRY(body->model->ops->mark(body->model, mark_nothing, NULL, &cut));
  if (model->body.law != SDR_LAW_VARIATIONAL) SDR_TRY(sdr_bond_alloc_flags(model));
  const size_t runs = (size_t)model->bonds->run_count;
  if (!model->body.run_marked) model->body.run_marked = sdr_alloc(runs, 1);
  if (!model->body.run_marked) return SDR_RUN_FAILED;
  memset(model->body.run_marked, 1, runs);
  if (model->body.run_flagged) memset(model->body.run_flagged, 1, runs);
  return SDR_OK;
}

static sdr_status measure_bodies(table *t)
{
  const bench_how none = {.dimension = 2, .spacing = 0.5e-3, .edge = 48};
  const char *const ns = "ns a directed bond and step";
  static const char *const with_law[] = {"", "variational", "critical stretch"};
  for (int law = SDR_LAW_VARIATIONAL; law <= SDR_LAW_CRITICAL_STRETCH; ++law) {
    bench_how damaged = none;
    damaged.law = (sdr_law)law;
    row *r = new_row(t,
                     law == SDR_LAW_VARIATIONAL ? "history of variational damage"
                                                : "flags of critical stretch",
                     "ring, 2-D, no damage", ns);
    SDR_TRY(compare(&damaged, NULL, &none, r));
    r = new_row(t, "tests for cut pairs", with_law[law], ns);
    SDR_TRY(compare(&damaged, look_at_every_flag, &damaged, r));
    r = new_row(t, "moduli a point", with_law[law], ns);
    SDR_TRY(compare(&damaged, give_moduli_to_points, &damaged, r));
    bench_how other = damaged;
    other.layer = 1;
    r = new_row(t, "third component", with_law[law], ns);
    SDR_TRY(compare(&other, NULL, &damaged, r));
    other = damaged;
    other.loose = 1;
    r = new_row(t, "index lists, both directions", with_law[law], ns);
    SDR_TRY(compare(&other, NULL, &damaged, r));
  }
  return SDR_OK;
}

/* ---- stripes at rest ------------------------------------------------------------------------- */

static sdr_status time_run(const char *path, const char *variant, int skip, double *seconds)
{
  sdr_built built;
  SDR_TRY(sdr_build(path, variant, 0, NULL, &built));
  built.model->ops->skip_rest(built.model, skip);
  const double from = bench_processor_clock();
  sdr_status status = built.integrator->start(built.system, built.step);
  for (int64_t n = 0; n < built.steps && status == SDR_OK; ++n)
    status = built.integrator->step(built.system, built.step);
  *seconds = (bench_processor_clock() - from) / (double)built.model->bonds / (double)built.steps;
  sdr_built_destroy(&built);
  return status;
}

static sdr_status time_rest(const char *path, const char *variant, row *r)
{
  double unused;
  SDR_TRY(time_run(path, variant, 1, &unused));
  for (int round = 0; round < ROUNDS; ++round) {
    SDR_TRY(time_run(path, variant, 0, &r->with[round]));
    SDR_TRY(time_run(path, variant, 1, &r->without[round]));
  }
  return SDR_OK;
}

/* A pulse that runs a metre into a bar, as a scene. */
static sdr_status write_bar(const char *directory, int metres, char path[SDR_SCENE_PATH])
{
  snprintf(path, SDR_SCENE_PATH, "%s/bar_%dm.yaml", directory, metres);
  FILE *file = fopen(path, "w");
  if (!file) return sdr_fail(SDR_IO_ERROR, "%s cannot be written", path);
  fprintf(file,
          "dimension: plane_stress\n"
          "points: {shape: {box: {from: [0, 0], to: [%d m, 20 mm]}}, spacing: 2 mm}\n"
          "material: {young: 70 GPa, density: 2700 kg/m^3, toughness: 1e4 J/m^2}\n"
          "damage: {law: variational}\n"
          "loads: [{traction: {on: left, value: [1 MPa, 0], until: 20 us}}]\n"
          "time: {step: 0.2 us, end: 200 us}\n",
          metres);
  return fclose(file) == 0 ? SDR_OK : sdr_fail(SDR_IO_ERROR, "%s: disk full", path);
}

static sdr_status measure_rest(const char *directory, table *t)
{
  char path[SDR_SCENE_PATH];
  const char *const ns = "ns a directed bond and step";
  SDR_TRY(write_bar(directory, 4, path));
  SDR_TRY(time_rest(path, NULL, new_row(t, "stripes at rest", "pulse in a bar of 4 m", ns)));
  SDR_TRY(write_bar(directory, 16, path));
  SDR_TRY(time_rest(path, NULL, new_row(t, "stripes at rest", "pulse in a bar of 16 m", ns)));
  SDR_TRY(sdr_find_scene("thick_cylinder", path));
  return time_rest(path, "coarse_1mm", new_row(t, "stripes at rest", "thick cylinder at 1 mm", ns));
}

/* ---- what only observers and implicit runs need ---------------------------------------------- */

static sdr_status measure_watching(table *t)
{
  static const char *const what[] = {"energies each step", "damage field each step"};
  const bench_how how = {.dimension = 2, .spacing = 0.5e-3, .law = SDR_LAW_VARIATIONAL};
  bench_body body = {0};
  sdr_status status = bench_body_create(&how, &body);
  double *values = status == SDR_OK ? sdr_alloc((size_t)body.points->count, sizeof *values) : NULL;
  for (int k = 0; k < 2 && values; ++k) {
    row *r = new_row(t, what[k], "variational", "ns a directed bond and step");
    for (int round = 0; round < ROUNDS && status == SDR_OK; ++round) {
      sdr_balance balance;
      status = time_steps(&body, 5, &r->without[round]);
      const double from = bench_processor_clock();
      for (int n = 0; n < 5 && status == SDR_OK; ++n)
        if (k == 0)
          sdr_system_balance(body.system, &balance);
        else
          status = sdr_system_field(body.system, "damage", values);
      r->with[round] =
          r->without[round] + (bench_processor_clock() - from) / 5 / (double)body.model->bonds;
    }
  }
  sdr_free(values);
  bench_body_destroy(&body);
  return status;
}

/* Points, bonds and model of the ring, and the directed neighbourhood that they do without. */
static sdr_status measure_neighbourhood(table *t)
{
  const bench_how how = {.dimension = 2, .spacing = 0.5e-3};
  row *r = new_row(t, "neighbourhood", "set-up of the ring, no damage", "ns a directed bond");
  for (int round = 0; round < ROUNDS; ++round) {
    bench_body body;
    sdr_neighbourhood near;
    double from = bench_processor_clock();
    SDR_TRY(bench_body_create(&how, &body));
    r->without[round] = (bench_processor_clock() - from) / (double)body.model->bonds;
    const double before = (double)sdr_memory_now();
    from = bench_processor_clock();
    sdr_status status = sdr_neighbourhood_create(body.points, &near);
    if (status == SDR_OK) {
      r->with[round] =
          r->without[round] + (bench_processor_clock() - from) / (double)body.model->bonds;
      r->bytes = ((double)sdr_memory_now() - before) / body.points->count;
      sdr_neighbourhood_destroy(&near);
    }
    bench_body_destroy(&body);
    SDR_TRY(status);
  }
  return SDR_OK;
}

/* Pattern and values of the tangent, which explicit runs never ask for. */
static sdr_status measure_jacobian(table *t)
{
  const bench_how how = {.dimension = 2, .spacing = 1e-3};
  row *r = new_row(t, "Jacobian", "set-up of the ring at 1 mm, no damage", "ns a directed bond");
  for (int round = 0; round < ROUNDS; ++round) {
    bench_body body;
    sdr_tangent *tangent = NULL;
    double from = bench_processor_clock();
    SDR_TRY(bench_body_create(&how, &body));
    r->without[round] = (bench_processor_clock() - from) / (double)body.model->bonds;
    const double before = (double)sdr_memory_now();
    from = bench_processor_clock();
    sdr_status status = sdr_tangent_create(body.model, SDR_TANGENT_EXACT, &tangent);
    if (status == SDR_OK) status = sdr_tangent_update(tangent, NULL, body.system->u);
    r->with[round] =
        r->without[round] + (bench_processor_clock() - from) / (double)body.model->bonds;
    r->bytes = ((double)sdr_memory_now() - before) / body.points->count;
    sdr_tangent_destroy(&tangent);
    bench_body_destroy(&body);
    SDR_TRY(status);
  }
  return SDR_OK;
}

/* ---- report ---------------------------------------------------------------------------------- */

static void print_table(const table *t)
{
  printf(
      "\nOne core, processor time, median of %d rounds; saved: share of the time with the feature\n"
      "(least and largest of the rounds); bytes a point that it would hold\n\n"
      "  %-30s %-31s %9s %9s   %-22s %s\n",
      ROUNDS, "feature", "where it is left out", "with, ns", "without", "saved", "bytes");
  for (int k = 0; k < t->count; ++k) {
    const row *r = &t->rows[k];
    const saving s = saving_of(r);
    char bytes[32] = "";
    if (!isnan(r->bytes)) snprintf(bytes, sizeof bytes, "%.0f", r->bytes);
    printf("  %-30s %-31s %9.2f %9.2f   %3.0f %% (%3.0f to %3.0f %%)   %6s\n", r->feature, r->scene,
           median(r->with) * 1e9, median(r->without) * 1e9, 100.0 * s.median, 100.0 * s.least,
           100.0 * s.most, bytes);
  }
}

static sdr_status write_csv(const table *t, const char *directory)
{
  FILE *csv;
  SDR_TRY(bench_csv(directory, "skip", &csv));
  fputs("feature,scene,unit,with,without,saved_median,saved_least,saved_most,bytes_a_point\n", csv);
  for (int k = 0; k < t->count; ++k) {
    const row *r = &t->rows[k];
    const saving s = saving_of(r);
    fprintf(csv, "\"%s\",\"%s\",%s,%.4f,%.4f,%.4f,%.4f,%.4f,%.1f\n", r->feature, r->scene, r->unit,
            median(r->with) * 1e9, median(r->without) * 1e9, s.median, s.least, s.most, r->bytes);
  }
  return fclose(csv) == 0 ? SDR_OK : sdr_fail(SDR_IO_ERROR, "%s: disk full", directory);
}

/* A line from the time without (dark) to that with (light) each feature, first on top. */
static sdr_status draw(const table *t, const char *directory)
{
  char path[2 * BENCH_PATH];
  sdr_picture picture;
  SDR_TRY(sdr_picture_begin(&picture, 1500, 900, 20.0));
  sdr_picture_place(&picture, (sdr_area){610, 80, 850, 790});
  FILE *script = picture.script;
  fputs("$d << E\n", script);
  for (int k = 0; k < t->count; ++k) {
    const row *r = &t->rows[t->count - 1 - k];
    fprintf(script, "\"%s (%s)\" %g %g %.0f\n", r->feature, r->scene, median(r->with) * 1e9,
            median(r->without) * 1e9, 100.0 * saving_of(r).median);
  }
  fprintf(script,
          "E\nset xtics nomirror\nset ytics nomirror scale 0\nset border 3\n"
          "set grid x lc '#e0e0e0'\nset logscale x\nset yrange [-0.7:%g]\nset xrange [0.1:300]\n"
          "set xlabel 'ns a directed bond (and step), one core; figures: share saved'\n"
          "set key top right\n"
          "plot $d using 3:0:($2-$3):(0):ytic(1) with vectors nohead lw 6 lc '#d0d0d0' notitle, "
          "$d using 2:0 with points pt 7 ps 1.6 lc '#d55e00' t 'with', "
          "$d using 3:0 with points pt 7 ps 1.6 lc '#0072b2' t 'without', "
          "$d using (1.15*($2>$3?$2:$3)):0:(sprintf('%%.0f %%%%', $4)) with labels left "
          "font ',11' notitle\n",
          t->count - 0.3);
  snprintf(path, sizeof path, "%s/skip.png", directory);
  return sdr_picture_end(&picture, path);
}

int main(int count, char **words)
{
  static table t;
  char directory[BENCH_PATH];
  (void)words;
  if (count > 1) {
    fputs("usage: bench_skip\n", stderr);
    return SDR_BAD_INPUT;
  }
  sdr_set_threads(1);
  sdr_status status = bench_directory("skip", directory);
  if (status == SDR_OK) status = measure_bodies(&t);
  if (status == SDR_OK) status = measure_rest(directory, &t);
  if (status == SDR_OK) status = measure_watching(&t);
  if (status == SDR_OK) status = measure_neighbourhood(&t);
  if (status == SDR_OK) status = measure_jacobian(&t);
  if (status == SDR_OK) {
    print_table(&t);
    status = write_csv(&t, directory);
  }
  if (status == SDR_OK) status = draw(&t, directory);
  if (status == SDR_OK)
    printf("\n%s\n%s/skip.csv\n%s/skip.png\n", bench_origin(), directory, directory);
  else
    fprintf(stderr, "skip: %s\n", sdr_error_message());
  return (int)status;
}
