#include "app/plot_ledger.h"

#include "app/plot_units.h"

#include <math.h>
#include <string.h>

/* An energy in history.csv: does it count in the sum, is it shown even where it is zero? */
typedef struct {
  const char *column, *name, *style;
  double width;
  int summed, always;
} curve;

static const curve curves[] = {
    {"kinetic", "kinetic", "lc '#0072b2' dt 1", 2.5, 1, 1},
    {"stored", "stored", "lc '#009e73' dt 1", 2.5, 1, 1},
    {"dissipated", "dissipated", "lc '#d55e00' dt 1", 2.5, 1, 1},
    {"viscous", "viscous", "lc '#cc79a7' dt 1", 2.5, 1, 0},
    {"contact", "contact", "lc '#7a5195' dt 1", 2.5, 1, 0},
    {"refinement", "refinement", "lc '#8c6d31' dt 1", 2.5, 1, 0},
    {"external_work", "external work", "lc '#000000' dt (9,6)", 2.5, 0, 1},
};
static const curve sum_curve = {NULL, "sum", "lc '#c4c4c4' dt 1", 6.0, 0, 1};
static const double legend_size = 0.95;
enum { CURVES = sizeof curves / sizeof curves[0], ROWS_SHOWN = 4000 };

static int shown(const sdr_rundata *run, const curve *what)
{
  const double *column = sdr_rundata_column(run, what->column);
  if (!column) return 0;
  for (int row = 0; row < run->history.row_count; ++row)
    if (what->always || column[row] != 0.0) return 1;
  return 0;
}

static double sum_at(const sdr_rundata *run, int row)
{
  double sum = 0.0;
  for (int k = 0; k < CURVES; ++k) {
    const double *column = sdr_rundata_column(run, curves[k].column);
    if (column && curves[k].summed) sum += column[row];
  }
  return sum;
}

static void widen(double range[2], double value)
{
  if (!isfinite(value)) return;
  range[0] = fmin(range[0], value);
  range[1] = fmax(range[1], value);
}

sdr_status sdr_ledger_range_of(const sdr_rundata *run, sdr_ledger_range *out)
{
  const double *time = sdr_rundata_column(run, "time");
  const double *imbalance = sdr_rundata_column(run, "imbalance");
  if (run->history.row_count == 0 || !time)
    return sdr_fail(SDR_BAD_INPUT, "%s/history.csv: %s, so there are no energies to draw",
                    run->directory, time ? "no rows" : "missing, or without a column \"time\"");
  sdr_ledger_range range = {{time[0], time[0]}, {0.0, 0.0}, {0.0, 0.0}, 0.0};
  for (int row = 0; row < run->history.row_count; ++row) {
    widen(range.time, time[row]);
    widen(range.energy, sum_at(run, row));
    range.largest = fmax(range.largest, sum_at(run, row));
    if (imbalance) widen(range.imbalance, imbalance[row]);
    for (int k = 0; k < CURVES; ++k) {
      const double *column = sdr_rundata_column(run, curves[k].column);
      if (column) widen(range.energy, column[row]);
    }
  }
  *out = range;
  return SDR_OK;
}

sdr_ledger_range sdr_ledger_range_merge(const sdr_ledger_range *a, const sdr_ledger_range *b)
{
  sdr_ledger_range both = *a;
  for (int c = 0; c < 2; ++c) {
    widen(both.time, b->time[c]);
    widen(both.energy, b->energy[c]);
    widen(both.imbalance, b->imbalance[c]);
  }
  both.largest = fmax(a->largest, b->largest);
  return both;
}

/* Time, the energies, their sum and the imbalance. */
static void write_row(sdr_picture *picture, const sdr_rundata *run, int row, double time_scale,
                      double energy_scale, double imbalance_scale)
{
  const double *imbalance = sdr_rundata_column(run, "imbalance");
  fprintf(picture->script, "%.9g", sdr_rundata_column(run, "time")[row] * time_scale);
  for (int k = 0; k < CURVES; ++k) {
    const double *column = sdr_rundata_column(run, curves[k].column);
    fprintf(picture->script, " %.9g", (column ? column[row] : (double)NAN) * energy_scale);
  }
  fprintf(picture->script, " %.9g %.9g\n", sum_at(run, row) * energy_scale,
          (imbalance ? imbalance[row] : (double)NAN) * imbalance_scale);
}

/* About ROWS_SHOWN rows, the last among them. */
static void write_rows(sdr_picture *picture, const sdr_rundata *run, double time_scale,
                       double energy_scale, double imbalance_scale)
{
  const int last = run->history.row_count - 1, stride = last / ROWS_SHOWN + 1;
  fputs("$ledger << EOD\n", picture->script);
  for (int row = 0; row < last; row += stride)
    write_row(picture, run, row, time_scale, energy_scale, imbalance_scale);
  write_row(picture, run, last, time_scale, energy_scale, imbalance_scale);
  fputs("EOD\n", picture->script);
}

static double larger(const double range[2])
{
  return fmax(fabs(range[0]), fabs(range[1]));
}

/* A range with room at both ends, never empty. */
static void write_range(sdr_picture *picture, const char *axis, const double range[2], double room,
                        double scale)
{
  double low = range[0], high = range[1];
  const double extra = room * (high - low);
  if (!(high > low)) {
    low -= 1.0 / scale;
    high += 1.0 / scale;
  }
  fprintf(picture->script, "set %srange [%.9g:%.9g]\n", axis,
          (low < 0.0 || room == 0.0 ? low - extra : low) * scale, (high + extra) * scale);
}

static void write_label(sdr_picture *picture, sdr_area area, const char *name, const char *unit,
                        sdr_prefix prefix)
{
  char label[128];
  sdr_axis_label(name, unit, prefix, label, sizeof label);
  sdr_picture_upright(picture, area.left - 5.0 * picture->font, area.bottom + 0.5 * area.height,
                      1.1, 1.5 * area.height, label);
}

/* About `count` tics at round numbers over the length of a range. */
static double tic_step(const double range[2], double scale, int count)
{
  const double rough = (range[1] - range[0]) * scale / count;
  if (!(rough > 0.0)) return 1.0;
  const double power = pow(10.0, floor(log10(rough)));
  const double digit = rough / power;
  return power * (digit > 5.0 ? 10.0 : digit > 2.0 ? 5.0 : digit > 1.0 ? 2.0 : 1.0);
}

/* The imbalance over the largest energy, at the right. */
static void write_share(sdr_picture *picture, sdr_area area, const sdr_ledger_range *range)
{
  char label[128];
  if (!(range->largest > 0.0) || !(larger(range->imbalance) > 0.0)) return;
  const sdr_prefix prefix = sdr_prefix_for(larger(range->imbalance) / range->largest);
  const double scale = prefix.scale / range->largest;
  write_range(picture, "y2", range->imbalance, 0.12, scale);
  fprintf(picture->script, "set y2tics out %.9g\n", tic_step(range->imbalance, scale, 4));
  sdr_axis_label("of its largest energy", "", prefix, label, sizeof label);
  sdr_picture_upright(picture, area.left + area.width + 5.2 * picture->font,
                      area.bottom + 0.5 * area.height, 0.85, 2.4 * area.height, label);
}

/* One entry of the legend at x, y px: a piece of the line and its name. */
static void write_entry(sdr_picture *picture, double x, double y, const char *style,
                        const char *name)
{
  const double em = picture->font;
  fprintf(picture->script, "set arrow from screen %.6f,%.6f to screen %.6f,%.6f nohead %s front\n",
          x / picture->width, y / picture->height, (x + 1.8 * em) / picture->width,
          y / picture->height, style);
  sdr_picture_text(picture, x + 2.2 * em, y, "left", legend_size, 20.0 * em, name);
}

static double entry_width(const sdr_picture *picture, const char *name)
{
  return (3.6 + 0.56 * legend_size * (double)strlen(name)) * picture->font;
}

/* Above the area: in one row, or in two where that is too narrow. */
static void write_legend(sdr_picture *picture, sdr_area area, const sdr_rundata *run)
{
  const curve *entries[CURVES + 1];
  int count = 0;
  double total = 0.0;
  entries[count++] = &sum_curve;
  for (int k = 0; k < CURVES; ++k)
    if (shown(run, &curves[k])) entries[count++] = &curves[k];
  for (int k = 0; k < count; ++k) total += entry_width(picture, entries[k]->name);
  const int columns = total <= area.width ? count : (count + 1) / 2;
  const double top = area.bottom + area.height + 0.8 * picture->font;
  double x = area.left;
  for (int k = 0; k < count; ++k) {
    char style[96];
    const int lower = columns == count || k >= columns;
    if (k == columns) x = area.left;
    snprintf(style, sizeof style, "lw %.1f %s", entries[k]->width, entries[k]->style);
    write_entry(picture, x, lower ? top : top + 1.2 * picture->font, style, entries[k]->name);
    x += columns == count
             ? entry_width(picture, entries[k]->name) + (area.width - total) / fmax(1.0, count - 1)
             : area.width / columns;
  }
}

static void draw_energies(sdr_picture *picture, const sdr_rundata *run)
{
  fprintf(picture->script, "plot $ledger using 1:%d with lines lw %.1f %s notitle", CURVES + 2,
          sum_curve.width, sum_curve.style);
  for (int k = 0; k < CURVES; ++k)
    if (shown(run, &curves[k]))
      fprintf(picture->script, ", $ledger using 1:%d with lines lw %.1f %s notitle", k + 2,
              curves[k].width, curves[k].style);
  fputs("\n", picture->script);
}

static void draw_upper(sdr_picture *picture, sdr_area area, const sdr_rundata *run,
                       const sdr_ledger_range *range)
{
  const sdr_prefix energy = sdr_prefix_for(larger(range->energy));
  fputs("set xtics out nomirror format ''\nset ytics out nomirror autofreq\n", picture->script);
  write_range(picture, "y", range->energy, 0.05, energy.scale);
  write_label(picture, area, "energy", "J", energy);
  write_legend(picture, area, run);
  sdr_picture_place(picture, area);
  draw_energies(picture, run);
  fputs("unset label\nunset arrow\n", picture->script);
}

static void draw_lower(sdr_picture *picture, sdr_area area, const sdr_ledger_range *range)
{
  char label[64];
  const sdr_prefix imbalance = sdr_prefix_for(larger(range->imbalance));
  sdr_axis_label("time", "s", sdr_prefix_for(larger(range->time)), label, sizeof label);
  sdr_picture_text(picture, area.left + 0.5 * area.width, area.bottom - 3.1 * picture->font,
                   "center", 1.1, area.width, label);
  write_label(picture, area, "imbalance", "J", imbalance);
  write_range(picture, "y", range->imbalance, 0.12, imbalance.scale);
  fprintf(picture->script, "set xtics format '%% h'\nset ytics out nomirror %.9g\n",
          tic_step(range->imbalance, imbalance.scale, 4));
  write_share(picture, area, range);
  sdr_picture_place(picture, area);
  fprintf(picture->script,
          "plot $ledger using 1:(0) with lines lw 1.2 lc '#808080' notitle, "
          "$ledger using 1:%d with lines lw 2.5 lc '#a8272f' notitle\n",
          CURVES + 3);
}

void sdr_panel_ledger(sdr_picture *picture, sdr_area area, const sdr_rundata *run,
                      const sdr_ledger_range *range)
{
  const double below = 0.33 * area.height, gap = 0.045 * area.height;
  const sdr_area upper = {area.left, area.bottom + below + gap, area.width,
                          area.height - below - gap};
  const sdr_area lower = {area.left, area.bottom, area.width, below};
  const double time_scale = sdr_prefix_for(larger(range->time)).scale;
  write_rows(picture, run, time_scale, sdr_prefix_for(larger(range->energy)).scale,
             sdr_prefix_for(larger(range->imbalance)).scale);
  fputs("set grid lt 1 lw 0.8 lc rgb '#c8c8c8'\n", picture->script);
  write_range(picture, "x", range->time, 0.0, time_scale);
  draw_upper(picture, upper, run, range);
  draw_lower(picture, lower, range);
  sdr_picture_clear_axes(picture);
}
