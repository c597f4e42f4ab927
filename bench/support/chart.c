#include "support/chart.h"

#include <math.h>

static void write_values(FILE *script, const bench_chart *chart, double range[2])
{
  range[0] = chart->limit > 0.0 ? chart->limit : (double)INFINITY;
  range[1] = chart->limit;
  fputs("$bars << E\n", script);
  for (int g = 0; g < chart->groups; ++g) {
    fprintf(script, "\"%s\"", chart->group[g]);
    for (int k = 0; k < chart->bars; ++k) {
      const double value = chart->value[g * chart->bars + k];
      fprintf(script, " %.6g", value);
      if (value > 0.0) range[0] = fmin(range[0], value);
      range[1] = fmax(range[1], value);
    }
    fputc('\n', script);
  }
  fputs("E\n", script);
}

/* Room for the legend above the highest bar. */
static void write_axes(FILE *script, const bench_chart *chart, const double range[2])
{
  fputs("set xtics nomirror\nset ytics nomirror\nset grid y lc '#e0e0e0'\nset border 3\n"
        "set style data histograms\nset style histogram clustered gap 1.5\n"
        "set style fill solid 1 noborder\nset key top center horizontal font ',11' samplen 1\n",
        script);
  if (chart->logarithmic)
    fprintf(script, "set logscale y\nset format y '%%.0e'\nset yrange [%g:%g]\n", 0.3 * range[0],
            range[1] * pow(range[1] / range[0], 0.4));
  else
    fprintf(script, "unset logscale y\nset format y '%%g'\nset yrange [0:%g]\n", 1.3 * range[1]);
  fprintf(script, "set xrange [-0.6:%g]\nset key maxcols %d\nset title \"%s\"\nset ylabel \"%s\"\n",
          chart->groups - 0.4, chart->columns, chart->title, chart->unit);
}

void bench_draw_bars(sdr_picture *picture, const bench_chart *chart, sdr_area area)
{
  FILE *script = picture->script;
  double range[2];
  sdr_picture_place(picture, area);
  write_values(script, chart, range);
  write_axes(script, chart, range);
  fputs("plot ", script);
  for (int k = 0; k < chart->bars; ++k)
    fprintf(script, "$bars using %d:xtic(1) lc '%s' t \"%s\", ", k + 2, chart->bar[k].colour,
            chart->bar[k].title);
  if (chart->limit > 0.0)
    fprintf(script, "%g with lines dt 2 lc '#000000' notitle, ", chart->limit);
  for (int k = 0; k < chart->bars; ++k)
    fprintf(script,
            "$bars using ($0 + %g):%d:(sprintf('%s', $%d)) with labels font ',10' "
            "offset 0,0.5 notitle, ",
            (k - 0.5 * (chart->bars - 1)) / (chart->bars + 1.5), k + 2, chart->format, k + 2);
  fputc('\n', script);
}
