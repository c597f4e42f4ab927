/* how far `precision: mixed` strays from double: in 200 steps before breakage, and through it */
#include "app/find_scene.h"
#include "app/run.h"
#include "app/rundata.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "support/body.h"
#include "support/chart.h"
#include "support/report.h"
#include "time/integrator.h"

#include <math.h>
#include <string.h>

enum { STEPS = 200 };

/* Start velocities of smooth waves that strain the body to about `strain`: a tenth of what breaks
   bonds, or as much as makes their damage grow from the first step on. */
typedef struct {
  const char *name;
  sdr_law law;
  double strain;
} start;

static const start starts[] = {{"none", SDR_LAW_NONE, 1e-3},
                               {"variational, strain 1e-3", SDR_LAW_VARIATIONAL, 1e-3},
                               {"variational, strain 2e-3", SDR_LAW_VARIATIONAL, 2e-3},
                               {"critical, unbroken", SDR_LAW_CRITICAL_STRETCH, 1e-3}};
enum { STARTS = sizeof starts / sizeof *starts };

static const double target = 1e-7;

/* ---- before breakage ------------------------------------------------------------------------- */

/* From rest in place: waves as long as the body. */
static sdr_status set_moving(bench_body *body, double strain)
{
  sdr_system *system = body->system;
  const sdr_points *points = body->points;
  const double speed = strain * sqrt(210e9 / 7850.0), turn = 2.0 * acos(-1.0);
  double low = 0.0, high = 0.0;
  for (int32_t i = 0; i < points->count; ++i) {
    low = fmin(low, points->x[0][i]);
    high = fmax(high, points->x[0][i]);
  }
  for (int a = 0; a < system->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) {
      const int b = (a + 1) % system->components;
      const double along = points->x[a][i] / (high - low), across = points->x[b][i] / (high - low);
      system->u[a][i] = 0.0;
      system->v[a][i] = speed * sin(turn * along + 0.7 * a) * cos(0.5 * turn * across);
    }
  system->step = 0;
  system->time = 0.0;
  return sdr_leapfrog.start(system, body->step);
}

typedef struct {
  double error;  /* largest difference of a displacement over the largest displacement */
  double damage; /* the largest of a bond, double */
} stray;

static sdr_status follow(const bench_how *how, double strain, stray *out)
{
  bench_body body[2] = {{0}};
  sdr_energies energies = {0};
  sdr_status status = SDR_OK;
  for (int mixed = 0; status == SDR_OK && mixed < 2; ++mixed) {
    bench_how one = *how;
    one.mixed = mixed;
    status = bench_body_create(&one, &body[mixed]);
    if (status == SDR_OK) bench_body_forget(&body[mixed]);
    if (status == SDR_OK) status = set_moving(&body[mixed], strain);
    for (int step = 0; status == SDR_OK && step < STEPS; ++step)
      status = sdr_leapfrog.step(body[mixed].system, body[mixed].step);
  }
  double most = 0.0, error = 0.0;
  for (int a = 0; status == SDR_OK && a < body[0].system->components; ++a)
    for (int32_t i = 0; i < body[0].points->count; ++i) {
      const double right = body[0].system->u[a][i];
      most = fmax(most, fabs(right));
      error = fmax(error, fabs(body[1].system->u[a][i] - right));
    }
  if (status == SDR_OK) body[0].model->ops->energies(body[0].model, body[0].system->u, &energies);
  *out = (stray){error / most, energies.max_damage};
  for (int mixed = 0; mixed < 2; ++mixed) bench_body_destroy(&body[mixed]);
  return status;
}

/* Largest differences: a row a start, shared and scattered moduli in 2-D, then in 3-D. */
enum { BODIES = 4 };

static sdr_status before_breakage(FILE *csv, double errors[STARTS][BODIES])
{
  int missed = 0;
  printf(
      "After %d steps of smooth waves, largest difference over the largest displacement (at most "
      "%.0e)\n  %-28s %12s %12s %12s %12s %10s\n",
      STEPS, target, "", "2-D shared", "scattered", "3-D shared", "scattered", "damage");
  for (int k = 0; k < STARTS; ++k) {
    double damage = 0.0;
    printf("  %-28s", starts[k].name);
    for (int dimension = 2; dimension <= 3; ++dimension)
      for (int scattered = 0; scattered < 2; ++scattered) {
        const bench_how how = {.dimension = dimension,
                               .spacing = 1e-3,
                               .edge = 32,
                               .law = starts[k].law,
                               .scattered = scattered};
        stray s;
        SDR_TRY(follow(&how, starts[k].strain, &s));
        errors[k][2 * (dimension - 2) + scattered] = s.error;
        missed += s.error > target;
        damage = fmax(damage, s.damage);
        printf(" %11.1e%c", s.error, s.error > target ? '*' : ' ');
        fprintf(csv, "\"%s\",%d,%s,%.3e,%.4f\n", starts[k].name, dimension,
                scattered ? "scattered" : "shared", s.error, s.damage);
      }
    printf(" %9.3f\n", damage);
  }
  printf("  %d missed%s\n", missed, missed ? " (*)" : "");
  return SDR_OK;
}

static sdr_status draw(double errors[STARTS][BODIES], const char *directory)
{
  static const bench_bar bars[BODIES] = {{"2-D, shared moduli", "#56b4e9"},
                                         {"2-D, scattered", "#0072b2"},
                                         {"3-D, shared", "#f0a070"},
                                         {"3-D, scattered", "#d55e00"}};
  const char *groups[STARTS];
  char path[2 * BENCH_PATH];
  sdr_picture picture;
  for (int k = 0; k < STARTS; ++k) groups[k] = starts[k].name;
  const bench_chart chart = {
      .title = "mixed against double after 200 steps of smooth waves (dashed: what is aimed at)",
      .unit = "largest difference / largest displacement",
      .groups = STARTS,
      .bars = BODIES,
      .group = groups,
      .bar = bars,
      .value = errors[0],
      .format = "%.1e",
      .columns = BODIES,
      .limit = target,
      .logarithmic = 1};
  SDR_TRY(sdr_picture_begin(&picture, 1300, 560, 20.0));
  bench_draw_bars(&picture, &chart, (sdr_area){130, 60, 1140, 420});
  snprintf(path, sizeof path, "%s/mixed.png", directory);
  return sdr_picture_end(&picture, path);
}

/* ---- through breakage ------------------------------------------------------------------------ */

static sdr_status run_cylinder(const char *variant, int mixed, const char *directory,
                               sdr_rundata **out)
{
  char scene[SDR_SCENE_PATH], path[2 * BENCH_PATH];
  SDR_TRY(sdr_find_scene("thick_cylinder", scene));
  snprintf(path, sizeof path, "%s/%s-%s", directory, variant ? variant : "variational",
           mixed ? "mixed" : "double");
  const char *sets[] = {"points.spacing=1 mm", mixed ? "precision=mixed" : "precision=double",
                        "output.snapshots=1", "output.fields=[damage, displacement]"};
  const sdr_run_options options = {.scene = scene,
                                   .variant = variant,
                                   .directory = path,
                                   .set_count = 4,
                                   .sets = sets,
                                   .threads = 1,
                                   .quiet = 1};
  FILE *silent = fopen("/dev/null", "w");
  const sdr_status status = sdr_run(&options, silent ? silent : stderr);
  if (silent) fclose(silent);
  return status == SDR_OK ? sdr_rundata_open(path, out) : status;
}

/* Difference of a field at the end: over all its numbers. */
typedef struct {
  double rms, most, share; /* share of numbers that differ by more than 0.1 */
} difference;

static sdr_status compare(sdr_rundata *const data[2], const char *field, difference *out)
{
  float *value[2] = {NULL, NULL};
  int components = 0;
  sdr_status status = SDR_OK;
  for (int k = 0; status == SDR_OK && k < 2; ++k)
    status = sdr_rundata_field(data[k], data[k]->frame_count - 1, field, &value[k], &components);
  *out = (difference){0};
  const int64_t count = (int64_t)data[0]->point_count * components;
  for (int64_t i = 0; status == SDR_OK && i < count; ++i) {
    const double d = fabs((double)value[0][i] - (double)value[1][i]);
    out->rms += d * d / (double)count;
    out->most = fmax(out->most, d);
    out->share += (d > 0.1) / (double)count;
  }
  out->rms = sqrt(out->rms);
  sdr_free(value[0]);
  sdr_free(value[1]);
  return status;
}

static sdr_status through_breakage(const char *directory)
{
  static const char *const variants[] = {NULL, "critical_stretch_half"};
  printf("\nThe thick cylinder at 1 mm, 100 us, mixed against double\n  %-22s %10s %10s %10s %12s "
         "%23s %15s\n",
         "", "damage rms", "largest", "above 0.1", "u rms, m", "dissipated, J", "fragments");
  for (int k = 0; k < 2; ++k) {
    sdr_rundata *data[2] = {NULL, NULL};
    difference damage, motion;
    for (int mixed = 0; mixed < 2; ++mixed)
      SDR_TRY(run_cylinder(variants[k], mixed, directory, &data[mixed]));
    sdr_status status = compare(data, "damage", &damage);
    if (status == SDR_OK) status = compare(data, "displacement", &motion);
    if (status == SDR_OK)
      printf("  %-22s %10.1e %10.1e %10.1e %12.1e %11.1f %11.1f %7.0f %7.0f\n",
             variants[k] ? variants[k] : "variational", damage.rms, damage.most, damage.share,
             motion.rms, sdr_rundata_number(data[0], "energy.dissipated"),
             sdr_rundata_number(data[1], "energy.dissipated"),
             sdr_rundata_number(data[0], "fragments.count"),
             sdr_rundata_number(data[1], "fragments.count"));
    for (int mixed = 0; mixed < 2; ++mixed) sdr_rundata_destroy(&data[mixed]);
    SDR_TRY(status);
  }
  return SDR_OK;
}

int main(int count, char **words)
{
  char directory[BENCH_PATH];
  double errors[STARTS][BODIES];
  FILE *csv = NULL;
  (void)words;
  if (count > 1) {
    fputs("usage: bench_mixed\n", stderr);
    return SDR_BAD_INPUT;
  }
  sdr_set_threads(1);
  sdr_status status = bench_directory("mixed", directory);
  if (status == SDR_OK) status = bench_csv(directory, "mixed", &csv);
  if (status == SDR_OK) {
    fputs("law,dimension,moduli,error,largest_damage\n", csv);
    status = before_breakage(csv, errors);
    if (fclose(csv) != 0 && status == SDR_OK)
      status = sdr_fail(SDR_IO_ERROR, "%s: disk full", directory);
  }
  if (status == SDR_OK) status = draw(errors, directory);
  if (status == SDR_OK) status = through_breakage(directory);
  if (status == SDR_OK)
    printf("%s\n%s/mixed.csv\n%s/mixed.png\n", bench_origin(), directory, directory);
  if (status != SDR_OK) fprintf(stderr, "mixed: %s\n", sdr_error_message());
  return (int)status;
}
