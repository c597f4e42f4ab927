/* how the error of the vibrating bar falls with more points and with other horizons */
#include "app/find_scene.h"
#include "app/plot_gnuplot.h"
#include "app/run.h"
#include "app/rundata.h"
#include "support/report.h"

#include <math.h>
#include <string.h>

/* Variants of bar_vibration: relative L2 error of the bar's displacement at 4 ms, and the largest
   error of its middle up to then. The step shrinks with the spacing, 0.2 us at 1000 points. */
typedef struct {
  const char *variant, *name, *colour;
} series;

static const series all[] = {
    {NULL, "mirror, partial volumes, surface factors", "#0072b2"},
    {"plain", "mirror, family sums only", "#009e73"},
    {"zero", "u = 0, partial volumes, surface factors", "#e69f00"},
    {"uncorrected", "u = 0, nothing corrected", "#d55e00"},
};
static const int counts[] = {125, 250, 500, 1000, 2000, 4000};
static const int horizons[] = {2, 3, 4, 5, 6, 8};
enum {
  SERIES = sizeof all / sizeof *all,
  COUNTS = sizeof counts / sizeof *counts,
  HORIZONS = sizeof horizons / sizeof *horizons,
  USUAL_COUNT = 1000,
  USUAL_HORIZON = 3
};

typedef struct {
  double bar, middle; /* relative L2; mm */
} outcome;

typedef struct {
  char directory[BENCH_PATH];
  outcome by_count[SERIES][COUNTS], by_horizon[SERIES][HORIZONS];
} study;

/* What the error at 4 ms becomes with `count` points in the bar. The points held at u = 0 reach as
   far as the horizon. */
static sdr_status run_bar(const char *directory, const series *s, int count, int horizon,
                          outcome *out)
{
  char path[SDR_SCENE_PATH], sets[5][160];
  const char *given[5];
  const double spacing = 1e3 / count; /* mm */
  const int is_held = s->variant && strcmp(s->variant, "plain") != 0;
  sdr_rundata *data = NULL;
  SDR_TRY(sdr_find_scene("bar_vibration", path));
  snprintf(sets[0], sizeof sets[0], "points.spacing=%.17g mm", spacing);
  snprintf(sets[1], sizeof sets[1], "horizon=%d spacing", horizon);
  snprintf(sets[2], sizeof sets[2], "time.step=%.17g us", 0.2 * spacing);
  snprintf(sets[3], sizeof sets[3], "points.shape.interval.from=%.17g mm", -horizon * spacing);
  snprintf(sets[4], sizeof sets[4], "supports.0.on.interval.from=%.17g mm", -horizon * spacing);
  for (int k = 0; k < 5; ++k) given[k] = sets[k];
  const sdr_run_options options = {.scene = path,
                                   .variant = s->variant,
                                   .directory = directory,
                                   .set_count = is_held ? 5 : 3,
                                   .sets = given,
                                   .threads = 1,
                                   .quiet = 1};
  FILE *silent = fopen("/dev/null", "w");
  sdr_status status = sdr_run(&options, silent ? silent : stderr);
  if (silent) fclose(silent);
  if (status == SDR_OK) status = sdr_rundata_open(directory, &data);
  if (status != SDR_OK) return status;
  out->bar = sdr_rundata_number(data, "figures.error_bar.value");
  out->middle = 1e3 * sdr_rundata_number(data, "figures.error.value");
  sdr_rundata_destroy(&data);
  return SDR_OK;
}

static void put(FILE *csv, const series *s, int count, int horizon, const outcome *o)
{
  printf("  %-42s %6d %8d %12.4g %12.4g\n", s->name, count, horizon, o->bar, o->middle);
  fprintf(csv, "%s,%d,%d,%.9g,%.9g\n", s->variant ? s->variant : "", count, horizon, o->bar,
          o->middle);
  fflush(stdout);
}

static sdr_status run_all(study *s)
{
  char directory[BENCH_PATH + 16];
  FILE *csv;
  SDR_TRY(bench_directory("bar_convergence", s->directory));
  SDR_TRY(bench_csv(s->directory, "bar_convergence", &csv));
  snprintf(directory, sizeof directory, "%s/run", s->directory);
  fputs("variant,points,horizon_over_spacing,l2_bar,largest_error_middle_mm\n", csv);
  printf("  %-42s %6s %8s %12s %12s\n", "bar at 4 ms", "points", "horizon", "L2 error",
         "middle, mm");
  sdr_status status = SDR_OK;
  for (int k = 0; k < SERIES && status == SDR_OK; ++k) {
    for (int c = 0; c < COUNTS && status == SDR_OK; ++c) {
      outcome *o = &s->by_count[k][c];
      status = run_bar(directory, &all[k], counts[c], USUAL_HORIZON, o);
      if (status == SDR_OK) put(csv, &all[k], counts[c], USUAL_HORIZON, o);
    }
    for (int h = 0; h < HORIZONS && status == SDR_OK; ++h) {
      outcome *o = &s->by_horizon[k][h];
      status = run_bar(directory, &all[k], USUAL_COUNT, horizons[h], o);
      if (status == SDR_OK) put(csv, &all[k], USUAL_COUNT, horizons[h], o);
    }
  }
  if (fclose(csv) != 0 && status == SDR_OK)
    status = sdr_fail(SDR_IO_ERROR, "%s: disk full", s->directory);
  return status;
}

/* ---- picture --------------------------------------------------------------------------------- */

static void put_data(FILE *script, const study *s)
{
  for (int k = 0; k < SERIES; ++k) {
    fprintf(script, "$c%d << E\n", k);
    for (int c = 0; c < COUNTS; ++c) fprintf(script, "%d %g\n", counts[c], s->by_count[k][c].bar);
    fprintf(script, "E\n$h%d << E\n", k);
    for (int h = 0; h < HORIZONS; ++h)
      fprintf(script, "%d %g\n", horizons[h], s->by_horizon[k][h].bar);
    fputs("E\n", script);
  }
}

static void plot_series(FILE *script, char which)
{
  fputs("plot ", script);
  for (int k = 0; k < SERIES; ++k)
    fprintf(script, "%s$%c%d w lp lw 2 pt 7 lc '%s' t '%s'", k ? ", " : "", which, k, all[k].colour,
            all[k].name);
}

static sdr_status draw(const study *s)
{
  char path[2 * BENCH_PATH];
  sdr_picture picture;
  SDR_TRY(sdr_picture_begin(&picture, 1500, 640, 18.0));
  FILE *script = picture.script;
  put_data(script, s);
  fputs("set border 3\nset ytics nomirror out\nset grid lc '#dddddd'\nset logscale y\n"
        "set format y '%.0e'\nset yrange [1e-4:300]\nset key top right\n",
        script);
  sdr_picture_place(&picture, (sdr_area){120, 90, 600, 480});
  fputs("set title 'L2 error of the bar at 4 ms, horizon 3 spacings'\nset xlabel 'points'\n"
        "set logscale x\nset xtics nomirror (125, 250, 500, 1000, 2000, 4000)\nset xrange "
        "[110:4500]\n",
        script);
  plot_series(script, 'c');
  fputs(", 1.9*x**-1 w l lw 1.5 dt 3 lc '#888888' t 'order 1'\n", script);
  sdr_picture_place(&picture, (sdr_area){850, 90, 600, 480});
  fputs("set title '1000 points'\nset xlabel 'horizon / spacing'\nunset logscale x\n"
        "set xtics nomirror 1\nset xrange [1.8:8.2]\n",
        script);
  plot_series(script, 'h');
  fputc('\n', script);
  snprintf(path, sizeof path, "%s/bar_convergence.png", s->directory);
  SDR_TRY(sdr_picture_end(&picture, path));
  printf("table: %s/bar_convergence.csv, picture: %s\n", s->directory, path);
  return SDR_OK;
}

int main(void)
{
  static study s;
  sdr_status status = run_all(&s);
  if (status == SDR_OK) status = draw(&s);
  if (status != SDR_OK) fprintf(stderr, "bar_convergence: %s\n", sdr_error_message());
  printf("%s\n", bench_origin());
  return (int)status;
}
