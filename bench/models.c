/* What state-based bodies cost beside bond-based ones: one body, one law, steps of leapfrog of all
   models in turn, so that what disturbs the machine disturbs all alike. One core. Prints a table
   and writes it as CSV; --quick: a smaller body. */
#include "base/parallel.h"
#include "mechanics/isa.h"
#include "support/body.h"
#include "support/chart.h"
#include "support/report.h"
#include "time/integrator.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MODELS = 3, LAWS = 3, ROUNDS = 9, ROWS = 4 * LAWS };

static const char *const model_name[MODELS] = {"bond_based", "ordinary", "nonordinary"};
static const char *const law_name[LAWS] = {"none", "variational", "critical_stretch"};
/* What the project holds them to, over the bond-based cost. */
static const double limit[MODELS] = {1.0, 2.5, 4.0};

typedef struct {
  double least[MODELS], median[MODELS]; /* ns a directed bond and step */
  double ratio[MODELS]; /* median over rounds of the cost over the bond-based one of the round */
  int64_t bonds;
} row;

static int by_size(const void *a, const void *b)
{
  const double left = *(const double *)a, right = *(const double *)b;
  return (left > right) - (left < right);
}

static double middle(double values[ROUNDS])
{
  qsort(values, ROUNDS, sizeof(double), by_size);
  return values[ROUNDS / 2];
}

static sdr_status time_steps(bench_body *body, int steps, double *seconds)
{
  const double from = bench_processor_clock();
  for (int k = 0; k < steps; ++k) SDR_TRY(sdr_leapfrog.step(body->system, body->step));
  *seconds = (bench_processor_clock() - from) / steps;
  return SDR_OK;
}

static sdr_status measure(bench_body body[MODELS], row *out)
{
  double cost[MODELS][ROUNDS], ratio[MODELS][ROUNDS];
  int steps[MODELS];
  for (int m = 0; m < MODELS; ++m) {
    double seconds;
    SDR_TRY(time_steps(&body[m], 2, &seconds));
    steps[m] = (int)fmin(50.0, fmax(2.0, ceil(0.03 / seconds)));
  }
  out->bonds = body[0].model->bonds;
  for (int round = 0; round < ROUNDS; ++round)
    for (int m = 0; m < MODELS; ++m) {
      SDR_TRY(time_steps(&body[m], steps[m], &cost[m][round]));
      cost[m][round] *= 1e9 / (double)out->bonds;
      ratio[m][round] = cost[m][round] / cost[0][round];
    }
  for (int m = 0; m < MODELS; ++m) {
    out->median[m] = middle(cost[m]);
    out->least[m] = cost[m][0];
    out->ratio[m] = middle(ratio[m]);
  }
  return SDR_OK;
}

static sdr_status measure_case(bench_how how, row *out)
{
  bench_body body[MODELS];
  memset(body, 0, sizeof body);
  sdr_status status = SDR_OK;
  for (int m = 0; m < MODELS && status == SDR_OK; ++m) {
    how.model = (sdr_model_kind)m;
    status = bench_body_create(&how, &body[m]);
  }
  if (status == SDR_OK) status = measure(body, out);
  for (int m = 0; m < MODELS; ++m) bench_body_destroy(&body[m]);
  return status;
}

static void write_row(FILE *csv, const bench_how *how, const row *r)
{
  char name[64];
  snprintf(name, sizeof name, "%d-D %s%s", how->dimension, how->loose ? "loose, " : "",
           law_name[how->law]);
  printf("%-30s", name);
  for (int m = 0; m < MODELS; ++m) {
    printf("  %6.2f", r->median[m]);
    if (m > 0) printf(" (%.2f of %.1f)", r->ratio[m], limit[m]);
    fprintf(csv, "%d,%s,%s,%s,%lld,%.4g,%.4g,%.4g\n", how->dimension, how->loose ? "loose" : "runs",
            law_name[how->law], model_name[m], (long long)r->bonds, r->median[m], r->least[m],
            r->ratio[m]);
  }
  printf("\n");
}

static sdr_status measure_all(int quick, FILE *csv, row rows[ROWS])
{
  fprintf(csv, "dimension,bonds,law,model,directed,ns_median,ns_least,ratio\n");
  printf("%s\nns a directed bond and step, one core; over the bond-based cost\n%-30s  %s\n",
         bench_origin(), "", "bond   ordinary          nonordinary");
  bench_how how = {.spacing = quick ? 1e-3 : 0.5e-3, .edge = quick ? 32 : 48};
  for (how.dimension = 2; how.dimension <= 3; ++how.dimension)
    for (how.loose = 0; how.loose < 2; ++how.loose)
      for (int law = 0; law < LAWS; ++law) {
        row *r = rows++;
        how.law = (sdr_law)law;
        SDR_TRY(measure_case(how, r));
        write_row(csv, &how, r);
        fflush(stdout);
      }
  return SDR_OK;
}

/* A panel for each of: 2-D and 3-D, runs and loose pairs. */
static sdr_status draw(const row rows[ROWS], const char *directory)
{
  static const bench_bar bars[MODELS] = {
      {"bond-based", "#999999"}, {"ordinary", "#56b4e9"}, {"non-ordinary, linear", "#d55e00"}};
  char path[2 * BENCH_PATH], title[64];
  double value[ROWS * MODELS];
  sdr_picture picture;
  for (int k = 0; k < ROWS * MODELS; ++k) value[k] = rows[k / MODELS].median[k % MODELS];
  SDR_TRY(sdr_picture_begin(&picture, 1500, 960, 20.0));
  for (int panel = 0; panel < 4; ++panel) {
    const int loose = panel % 2;
    snprintf(title, sizeof title, "%s, %s", panel < 2 ? "plane stress" : "3-D",
             loose ? "loose pairs" : "runs");
    const bench_chart chart = {.title = title,
                               .unit = "ns a directed bond and step, one core",
                               .groups = LAWS,
                               .bars = MODELS,
                               .group = law_name,
                               .bar = bars,
                               .value = value + panel * LAWS * MODELS,
                               .format = "%.2f",
                               .columns = MODELS};
    bench_draw_bars(&picture, &chart,
                    (sdr_area){90 + 750 * (panel / 2), 540 - 480 * loose, 640, 360});
  }
  snprintf(path, sizeof path, "%s/models.png", directory);
  return sdr_picture_end(&picture, path);
}

int main(int argc, char **argv)
{
  const int quick = argc > 1 && strcmp(argv[1], "--quick") == 0;
  char directory[BENCH_PATH];
  FILE *csv = NULL;
  row rows[ROWS] = {0};
  sdr_set_threads(1);
  sdr_status status = bench_directory("models", directory);
  if (status == SDR_OK) status = bench_csv(directory, "models", &csv);
  if (status == SDR_OK) status = measure_all(quick, csv, rows);
  if (csv && fclose(csv) != 0 && status == SDR_OK)
    status = sdr_fail(SDR_IO_ERROR, "%s: disk full", directory);
  if (status == SDR_OK) status = draw(rows, directory);
  if (status == SDR_OK) printf("%s/models.csv\n%s/models.png\n", directory, directory);
  if (status != SDR_OK) fprintf(stderr, "models: %s\n", sdr_error_message());
  return (int)status;
}
