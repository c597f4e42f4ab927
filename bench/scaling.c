/* cost of a bond and step, set-up and memory from a thousand points to millions */
#include "app/plot_gnuplot.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "support/body.h"
#include "support/report.h"
#include "time/integrator.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIZES = 14, ROUNDS = 5, THREADS = 2 };

static const double enough = 0.12; /* s a measurement: many steps of small bodies */

/* Points of the ring, then edges of the cube. */
static const int32_t ring[] = {1000, 3000, 10000, 30000, 100000, 300000, 1000000, 3000000};
static const int edge[] = {14, 22, 32, 46, 68, 100};
enum { RINGS = sizeof ring / sizeof *ring, CUBES = sizeof edge / sizeof *edge };

typedef struct {
  int dimension;
  int32_t points;
  int64_t bonds;
  double ns[THREADS], least[THREADS]; /* a directed bond and step: median, least */
  double setup;                       /* ns a directed bond, with the first force */
  double bytes;                       /* a point */
} size_row;

typedef struct {
  size_row rows[SIZES];
  int count, threads;
} table;

static int by_size(const void *a, const void *b)
{
  const double left = *(const double *)a, right = *(const double *)b;
  return (left > right) - (left < right);
}

/* On one thread processor time, which does not count what others do on this machine. */
static double clock_for(int threads)
{
  return threads == 1 ? bench_processor_clock() : bench_clock();
}

static sdr_status time_steps(bench_body *body, int threads, int steps, double *seconds)
{
  const double from = clock_for(threads);
  for (int k = 0; k < steps; ++k) SDR_TRY(sdr_leapfrog.step(body->system, body->step));
  *seconds = (clock_for(threads) - from) / steps;
  return SDR_OK;
}

static sdr_status measure_steps(bench_body *body, int threads, size_row *out)
{
  double seconds[ROUNDS], once;
  sdr_set_threads(threads);
  SDR_TRY(time_steps(body, threads, 2, &once));
  const int steps = (int)fmin(20000.0, fmax(2.0, ceil(enough / once)));
  for (int round = 0; round < ROUNDS; ++round)
    SDR_TRY(time_steps(body, threads, steps, &seconds[round]));
  qsort(seconds, ROUNDS, sizeof *seconds, by_size);
  out->ns[threads - 1] = seconds[ROUNDS / 2] * 1e9 / (double)out->bonds;
  out->least[threads - 1] = seconds[0] * 1e9 / (double)out->bonds;
  return SDR_OK;
}

static sdr_status measure_size(const bench_how *how, int threads, size_row *out)
{
  bench_body body = {0};
  sdr_set_threads(1);
  const double before = (double)sdr_memory_now(), from = bench_processor_clock();
  SDR_TRY(bench_body_create(how, &body));
  const double seconds = bench_processor_clock() - from;
  *out = (size_row){.dimension = how->dimension,
                    .points = body.points->count,
                    .bonds = body.model->bonds,
                    .bytes = ((double)sdr_memory_now() - before) / body.points->count,
                    .setup = seconds * 1e9 / (double)body.model->bonds};
  fprintf(stderr, "%d-D, %d points ...\n", how->dimension, out->points);
  sdr_status status = SDR_OK;
  for (int t = 1; status == SDR_OK && t <= threads; ++t) status = measure_steps(&body, t, out);
  bench_body_destroy(&body);
  return status;
}

static sdr_status measure_all(table *t)
{
  const double area = acos(-1.0) * (149e-3 * 149e-3 - 81e-3 * 81e-3);
  t->threads = sdr_threads() > 1 ? 2 : 1;
  for (int k = 0; k < RINGS + CUBES; ++k) {
    bench_how how = {.dimension = 3, .law = SDR_LAW_VARIATIONAL, .scattered = 1};
    if (k < RINGS) {
      how.dimension = 2;
      how.spacing = sqrt(area / ring[k]);
    } else {
      how.edge = edge[k - RINGS];
    }
    SDR_TRY(measure_size(&how, t->threads, &t->rows[t->count]));
    ++t->count;
  }
  return SDR_OK;
}

/* ---- report ---------------------------------------------------------------------------------- */

/* Of the sizes of a dimension from 1e4 points on: the exponent of cost over points by least
   squares, and the largest cost over the least. */
static void flatness(const table *t, int dimension, int threads, double *exponent, double *ratio)
{
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, low = INFINITY, high = 0.0;
  for (int k = 0; k < t->count; ++k) {
    const size_row *r = &t->rows[k];
    const double ns = r->ns[threads - 1], a = log(r->points), b = log(ns);
    if (r->dimension != dimension || r->points < 9000) continue;
    n += 1.0;
    x += a;
    y += b;
    xx += a * a;
    xy += a * b;
    low = fmin(low, ns);
    high = fmax(high, ns);
  }
  *exponent = (n * xy - x * y) / (n * xx - x * x);
  *ratio = high / low;
}

static void print_table(const table *t)
{
  printf("\nVariational damage, scattered moduli; ns a directed bond and step, median of %d (least "
         "in brackets)\n\n  %-4s %9s %11s %16s %16s %11s %9s %9s\n  %-4s %9s %11s %16s %16s %11s "
         "%9s %9s\n",
         ROUNDS, "", "", "directed", "one core,", "two cores,", "set-up, ns", "bytes", "bytes", "",
         "points", "bonds", "processor time", "wall", "a bond", "a point", "a bond");
  for (int k = 0; k < t->count; ++k) {
    const size_row *r = &t->rows[k];
    printf("  %d-D  %9d %11lld %8.2f (%5.2f) %8.2f (%5.2f) %11.1f %9.0f %9.1f\n", r->dimension,
           r->points, (long long)r->bonds, r->ns[0], r->least[0], r->ns[1], r->least[1], r->setup,
           r->bytes, r->bytes * r->points / (double)r->bonds);
  }
  for (int dimension = 2; dimension <= 3; ++dimension)
    for (int threads = 1; threads <= t->threads; ++threads) {
      double exponent, ratio;
      flatness(t, dimension, threads, &exponent, &ratio);
      printf("  %d-D, %s from 1e4 points on: cost goes with points^%.3f; dearest over cheapest "
             "%.2f%s\n",
             dimension, threads == 1 ? "one core," : "two cores,", exponent, ratio,
             ratio > 1.3 ? " (more than 1.3)" : "");
    }
}

static sdr_status write_csv(const table *t, const char *directory)
{
  FILE *csv;
  SDR_TRY(bench_csv(directory, "scaling", &csv));
  fputs("dimension,points,bonds,one_core_ns,one_core_least_ns,two_cores_ns,two_cores_least_ns,"
        "setup_ns,bytes_a_point\n",
        csv);
  for (int k = 0; k < t->count; ++k) {
    const size_row *r = &t->rows[k];
    fprintf(csv, "%d,%d,%lld,%.4f,%.4f,%.4f,%.4f,%.2f,%.1f\n", r->dimension, r->points,
            (long long)r->bonds, r->ns[0], r->least[0], r->ns[1], r->least[1], r->setup, r->bytes);
  }
  return fclose(csv) == 0 ? SDR_OK : sdr_fail(SDR_IO_ERROR, "%s: disk full", directory);
}

static sdr_status draw(const table *t, const char *directory)
{
  char path[2 * BENCH_PATH];
  sdr_picture picture;
  SDR_TRY(sdr_picture_begin(&picture, 1500, 620, 20.0));
  for (int dimension = 2; dimension <= 3; ++dimension) {
    fprintf(picture.script, "$d%d << E\n", dimension);
    for (int k = 0; k < t->count; ++k) {
      const size_row *r = &t->rows[k];
      if (r->dimension == dimension)
        fprintf(picture.script, "%d %g %g %g %g\n", r->points, r->ns[0],
                t->threads > 1 ? r->ns[1] : (double)NAN, r->setup, r->bytes);
    }
    fputs("E\n", picture.script);
  }
  fputs("set logscale x\nset format x '%.0s%c'\nset tics nomirror\nset xtics\nset ytics\n"
        "set grid lc '#e0e0e0'\nset border 3\nset xlabel 'points'\nset yrange [0:*]\n"
        "set size 0.5,1\nset origin 0,0\nset key top right\n"
        "set ylabel 'ns a directed bond and step'\n"
        "plot $d2 using 1:2 with linespoints lw 2 pt 7 lc '#0072b2' t '2-D, one core', "
        "$d2 using 1:3 with linespoints lw 2 pt 6 lc '#56b4e9' t '2-D, two cores', "
        "$d3 using 1:2 with linespoints lw 2 pt 7 lc '#d55e00' t '3-D, one core', "
        "$d3 using 1:3 with linespoints lw 2 pt 6 lc '#f0a070' t '3-D, two cores'\n"
        "set origin 0.5,0\nset ylabel 'set-up, ns a directed bond'\n"
        "set y2label 'bytes a point'\nset y2tics\nset y2range [0:*]\n"
        "plot $d2 using 1:4 with linespoints lw 2 pt 7 lc '#0072b2' t '2-D, set-up', "
        "$d3 using 1:4 with linespoints lw 2 pt 7 lc '#d55e00' t '3-D, set-up', "
        "$d2 using 1:5 axes x1y2 with linespoints lw 2 dt 2 pt 4 lc '#0072b2' t '2-D, bytes', "
        "$d3 using 1:5 axes x1y2 with linespoints lw 2 dt 2 pt 4 lc '#d55e00' t '3-D, bytes'\n",
        picture.script);
  snprintf(path, sizeof path, "%s/scaling.png", directory);
  return sdr_picture_end(&picture, path);
}

int main(int count, char **words)
{
  static table t;
  char directory[BENCH_PATH];
  (void)words;
  if (count > 1) {
    fputs("usage: bench_scaling\n", stderr);
    return SDR_BAD_INPUT;
  }
  sdr_status status = bench_directory("scaling", directory);
  if (status == SDR_OK) status = measure_all(&t);
  if (status == SDR_OK) {
    print_table(&t);
    status = write_csv(&t, directory);
  }
  if (status == SDR_OK) status = draw(&t, directory);
  if (status == SDR_OK)
    printf("\n%s\n%s/scaling.csv\n%s/scaling.png\n", bench_origin(), directory, directory);
  else
    fprintf(stderr, "scaling: %s\n", sdr_error_message());
  return (int)status;
}
