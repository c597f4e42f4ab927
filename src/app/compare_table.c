#include "app/compare_parts.h"

#include "app/plot_units.h"
#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { NAME_WIDTH = 26, VALUE_WIDTH = 22, CELL = 96 };

/* A number of both summaries. `column`: of history.csv, whose last row stands in while a run has no
   summary. unit "": a plain number; "%": a share. */
typedef struct {
  const char *name, *path, *column, *unit;
} quantity;

static const quantity set_up[] = {
    {"points", "points", NULL, ""},        {"bonds", "bonds", NULL, ""},
    {"step", "step", NULL, "s"},           {"steps", "steps", NULL, ""},
    {"end time", "time_end", "time", "s"},
};
static const quantity outcome[] = {
    {"onset of damage", "damage.onset_time", NULL, "s"},
    {"largest damage", "damage.max", NULL, ""},
    {"mean damage", "damage.mean", NULL, ""},
    {"fragments", "fragments.count", NULL, ""},
};
static const quantity energies[] = {
    {"kinetic energy", "energy.kinetic", "kinetic", "J"},
    {"stored energy", "energy.stored", "stored", "J"},
    {"dissipated energy", "energy.dissipated", "dissipated", "J"},
    {"external work", "energy.external_work", "external_work", "J"},
    {"imbalance", "energy.imbalance", "imbalance", "J"},
    {"imbalance, relative", "energy.imbalance_relative", NULL, ""},
    {"imbalance, largest", "energy.imbalance_largest", NULL, ""},
    {"momentum residual", "momentum.linear", NULL, ""},
    {"angular residual", "momentum.angular", NULL, ""},
};
static const quantity costs[] = {
    {"wall time", "wall_seconds.total", NULL, "s"},
    {"wall time of the steps", "wall_seconds.integrate", NULL, "s"},
    {"time per bond and step", "ns_per_bond_step", NULL, "ns"},
    {"peak memory", "peak_memory_bytes", NULL, "B"},
};
#define LENGTH(list) ((int)(sizeof(list) / sizeof((list)[0])))

/* Left-aligned text in a column; a longer one is cut at its front (the end tells runs apart). */
static void put_text(FILE *out, const char *text, int width)
{
  const int length = (int)strlen(text);
  if (length <= width)
    fprintf(out, "%-*s", width, text);
  else
    fprintf(out, "..%s", text + (length - width + 2));
}

static void print_text(FILE *out, const char *name, const char *a, const char *b)
{
  fprintf(out, "%-*s", NAME_WIDTH, name);
  put_text(out, a ? a : "-", VALUE_WIDTH - 2);
  fputs("  ", out);
  put_text(out, b ? b : "-", VALUE_WIDTH - 2);
  fputs(a && b && strcmp(a, b) != 0 ? "  differs\n" : "\n", out);
}

/* Whole numbers in full, others with five digits. */
static void number_text(double value, const char *unit, char text[CELL])
{
  if (*unit == '\0' && isfinite(value) && value == floor(value) && fabs(value) < 1e15)
    snprintf(text, CELL, "%.0f", value);
  else if (strcmp(unit, "%") == 0 && isfinite(value))
    snprintf(text, CELL, "%.2f %%", 100.0 * (fabs(value) < 5e-5 ? 0.0 : value));
  else if (strcmp(unit, "ns") == 0 && isfinite(value))
    snprintf(text, CELL, "%.4g ns", value);
  else
    sdr_quantity(value, unit, 5, text, CELL);
}

static void print_numbers(FILE *out, const char *name, double a, double b, const char *unit)
{
  char left[CELL], right[CELL], change[CELL], ratio[CELL];
  number_text(a, unit, left);
  number_text(b, unit, right);
  number_text(b - a, unit, change);
  if (isfinite(a) && isfinite(b) && a != 0.0)
    snprintf(ratio, sizeof ratio, "%.4g", b / a);
  else
    snprintf(ratio, sizeof ratio, "-");
  fprintf(out, "%-*s%-*s%-*s%-*s%s\n", NAME_WIDTH, name, VALUE_WIDTH, left, VALUE_WIDTH, right, 16,
          change, ratio);
}

static double value_of(const sdr_rundata *run, const quantity *what)
{
  const double value = sdr_rundata_number(run, what->path);
  return isnan(value) && what->column && !run->summary ? sdr_rundata_last(run, what->column)
                                                       : value;
}

static void print_all(FILE *out, const sdr_rundata *a, const sdr_rundata *b, const quantity *list,
                      int count)
{
  for (int k = 0; k < count; ++k) {
    const double left = value_of(a, &list[k]), right = value_of(b, &list[k]);
    print_numbers(out, list[k].name, left, right, list[k].unit);
  }
}

static double largest_share(const sdr_rundata *run)
{
  return sdr_rundata_number(run, "fragments.largest") / sdr_rundata_number(run, "points");
}

static double figure_number(const sdr_rundata *run, const char *figure, const char *key)
{
  char path[256];
  snprintf(path, sizeof path, "figures.%.160s.%s", figure, key);
  return sdr_rundata_number(run, path);
}

/* 1 if the value lies outside of the range that the scene accepts. */
static int off(const sdr_rundata *run, const char *figure)
{
  const double value = figure_number(run, figure, "value");
  return value < figure_number(run, figure, "low") || value > figure_number(run, figure, "high");
}

static void print_range(FILE *out, const sdr_rundata *run, char which, const char *figure)
{
  const double low = figure_number(run, figure, "low"), high = figure_number(run, figure, "high");
  if (!off(run, figure)) return;
  if (isnan(high))
    fprintf(out, "    %c is outside of its range, at least %g\n", which, low);
  else if (isnan(low))
    fprintf(out, "    %c is outside of its range, at most %g\n", which, high);
  else
    fprintf(out, "    %c is outside of its range, %g to %g\n", which, low, high);
}

static void print_figure(FILE *out, const sdr_rundata *a, const sdr_rundata *b, const char *figure)
{
  char name[NAME_WIDTH + 1];
  snprintf(name, sizeof name, "  %.*s", NAME_WIDTH - 4, figure);
  print_numbers(out, name, figure_number(a, figure, "value"), figure_number(b, figure, "value"),
                "");
  print_range(out, a, 'A', figure);
  print_range(out, b, 'B', figure);
}

static int has_figure(const sdr_rundata *run, const char *figure)
{
  const char *name = NULL;
  for (int k = 0; (name = sdr_rundata_figure(run, k)); ++k)
    if (strcmp(name, figure) == 0) return 1;
  return 0;
}

static void print_figures(FILE *out, const sdr_rundata *a, const sdr_rundata *b)
{
  const char *name = NULL;
  if (sdr_rundata_figure(a, 0) || sdr_rundata_figure(b, 0)) fputs("figures (SI)\n", out);
  for (int k = 0; (name = sdr_rundata_figure(a, k)); ++k) print_figure(out, a, b, name);
  for (int k = 0; (name = sdr_rundata_figure(b, k)); ++k)
    if (!has_figure(a, name)) print_figure(out, a, b, name);
}

static void print_texts(FILE *out, const sdr_rundata *a, const sdr_rundata *b)
{
  static const char *const texts[][2] = {{"scene", "scene"},           {"variant", "variant"},
                                         {"dimension", "dimension"},   {"model", "model"},
                                         {"damage law", "damage_law"}, {"integrator", "integrator"},
                                         {"precision", "precision"}};
  print_text(out, "directory", a->directory, b->directory);
  for (size_t k = 0; k < sizeof texts / sizeof texts[0]; ++k) {
    const char *left = sdr_rundata_text(a, texts[k][1]), *right = sdr_rundata_text(b, texts[k][1]);
    if (left || right || k == 0) print_text(out, texts[k][0], left, right);
  }
}

void sdr_compare_table(const sdr_rundata *a, const sdr_rundata *b, FILE *out)
{
  const char *title_a = sdr_rundata_text(a, "title"), *title_b = sdr_rundata_text(b, "title");
  fprintf(out, "A: %s\nB: %s\n\n", title_a && *title_a ? title_a : a->directory,
          title_b && *title_b ? title_b : b->directory);
  fprintf(out, "%-*s%-*s%-*s%-16s%s\n", NAME_WIDTH, "", VALUE_WIDTH, "A", VALUE_WIDTH, "B", "B - A",
          "B / A");
  print_texts(out, a, b);
  print_all(out, a, b, set_up, LENGTH(set_up));
  fputc('\n', out);
  print_all(out, a, b, outcome, LENGTH(outcome));
  print_numbers(out, "largest fragment", largest_share(a), largest_share(b), "%");
  print_figures(out, a, b);
  fputs("\nat the end\n", out);
  print_all(out, a, b, energies, LENGTH(energies));
  fputc('\n', out);
  print_all(out, a, b, costs, LENGTH(costs));
}

/* ---- fields ---- */

sdr_frames sdr_compare_frames(const sdr_rundata *a, const sdr_rundata *b)
{
  sdr_frames last = {{a->frame_count - 1, b->frame_count - 1}, 0};
  double step = fmax(sdr_rundata_number(a, "step"), sdr_rundata_number(b, "step"));
  if (a->frame_count == 0 || b->frame_count == 0) return last;
  /* a frame lies on the step nearest to its time, half a step off at most in either run */
  if (!(step > 0.0)) step = 1e-6 * fabs(a->frame_time[a->frame_count - 1]);
  for (int k = a->frame_count - 1; k >= 0; --k) {
    const int other = sdr_rundata_nearest(b, a->frame_time[k]);
    if (fabs(b->frame_time[other] - a->frame_time[k]) <= 1.001 * step)
      return (sdr_frames){{k, other}, 1};
  }
  return last;
}

/* The same points in the same order, to a millionth of the body? */
static int same_points(const sdr_rundata *a, const sdr_rundata *b)
{
  if (a->point_count != b->point_count || a->dimension != b->dimension) return 0;
  double low = INFINITY, high = -INFINITY;
  for (int32_t i = 0; i < a->point_count; ++i) {
    low = fmin(low, a->position[0][i]);
    high = fmax(high, a->position[0][i]);
  }
  for (int c = 0; c < 3; ++c)
    for (int32_t i = 0; i < a->point_count; ++i)
      if (fabs(a->position[c][i] - b->position[c][i]) > 1e-6 * (high - low)) return 0;
  return 1;
}

typedef struct {
  double largest, rms;
  int32_t over; /* points that differ by more than 0.1 */
} difference;

/* Of vectors: the length of their difference. */
static difference differ(const float *a, const float *b, int32_t count, int components)
{
  difference found = {0.0, 0.0, 0};
  for (int32_t i = 0; i < count; ++i) {
    double square = 0.0;
    for (int c = 0; c < components; ++c) {
      const size_t k = (size_t)i * (size_t)components + (size_t)c;
      square += ((double)b[k] - (double)a[k]) * ((double)b[k] - (double)a[k]);
    }
    found.largest = fmax(found.largest, sqrt(square));
    found.rms += square;
    found.over += sqrt(square) > 0.1;
  }
  found.rms = sqrt(found.rms / count);
  return found;
}

static void print_difference(FILE *out, const char *field, const char *unit, difference found)
{
  char largest[CELL], rms[CELL];
  sdr_quantity(found.largest, unit, 4, largest, sizeof largest);
  sdr_quantity(found.rms, unit, 4, rms, sizeof rms);
  fprintf(out, "%-*slargest %-14sRMS %s\n", NAME_WIDTH, field, largest, rms);
}

static sdr_status compare_field(const sdr_rundata *a, const sdr_rundata *b, sdr_frames frames,
                                const char *field, const char *unit, FILE *out)
{
  float *left = NULL, *right = NULL;
  int left_width = 0, right_width = 0;
  if (!sdr_rundata_has(a, frames.frame[0], field) || !sdr_rundata_has(b, frames.frame[1], field)) {
    fprintf(out, "%-*snot in the snapshots of both\n", NAME_WIDTH, field);
    return SDR_OK;
  }
  sdr_status status = sdr_rundata_field(a, frames.frame[0], field, &left, &left_width);
  if (status == SDR_OK) status = sdr_rundata_field(b, frames.frame[1], field, &right, &right_width);
  if (status == SDR_OK && left_width != right_width)
    status = sdr_fail(SDR_BAD_INPUT, "field \"%s\" has %d components in A and %d in B", field,
                      left_width, right_width);
  if (status == SDR_OK) {
    const difference found = differ(left, right, a->point_count, left_width);
    print_difference(out, field, unit, found);
    if (strcmp(field, "damage") == 0)
      fprintf(out, "%-*s%.2f %% (%d of %d)\n", NAME_WIDTH, "points off by over 0.1",
              100.0 * found.over / a->point_count, found.over, a->point_count);
  }
  sdr_free(left);
  sdr_free(right);
  return status;
}

sdr_status sdr_compare_fields(const sdr_rundata *a, const sdr_rundata *b, FILE *out)
{
  const sdr_frames frames = sdr_compare_frames(a, b);
  char time[CELL], other[CELL];
  if (frames.frame[0] < 0 || frames.frame[1] < 0) {
    fprintf(out, "\nno differences of fields: %s has no snapshots (output.snapshots: 0)\n",
            frames.frame[0] < 0 ? a->directory : b->directory);
    return SDR_OK;
  }
  if (!frames.common || !same_points(a, b)) {
    fprintf(out, "\nno differences of fields: the runs have %s\n",
            frames.common ? "different points" : "no snapshots at a common time");
    return SDR_OK;
  }
  sdr_quantity(a->frame_time[frames.frame[0]], "s", 6, time, sizeof time);
  sdr_quantity(b->frame_time[frames.frame[1]], "s", 6, other, sizeof other);
  fprintf(out, "\ndifferences at %s%s%s\n", time, strcmp(time, other) ? " and " : "",
          strcmp(time, other) ? other : "");
  SDR_TRY(compare_field(a, b, frames, "damage", "", out));
  return compare_field(a, b, frames, "displacement", "m", out);
}
