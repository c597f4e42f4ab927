#include "app/plot_reactions.h"

#include "app/plot_columns.h"
#include "app/plot_frame.h"
#include "app/plot_gnuplot.h"
#include "app/plot_panel.h"
#include "app/plot_units.h"

#include <math.h>
#include <string.h>

enum { PATH_ROOM = 4200, MOST_PANELS = 24, ROWS_SHOWN = 4000, WIDTH = 900, HEIGHT = 480 };

/* Of the grid, in letters' sizes. */
static const double em = 26.0, left = 6.2, right = 1.8, below = 4.4, above = 2.2, heading = 4.4;

static double largest_of(const double *values, int count)
{
  double most = 0.0;
  for (int k = 0; k < count; ++k)
    if (isfinite(values[k])) most = fmax(most, fabs(values[k]));
  return most;
}

/* Numbers without a unit stand as they are unless they are small. */
static sdr_prefix prefix_of(const sdr_column_panel *panel, int rows)
{
  double most = 0.0;
  for (int k = 0; k < panel->count; ++k) most = fmax(most, largest_of(panel->value[k], rows));
  return sdr_prefix_for(!*panel->unit && most >= 0.01 && most < 1e4 ? 1.0 : most);
}

static void put(sdr_picture *picture, double value, char after)
{
  if (isfinite(value))
    fprintf(picture->script, "%.9g%c", value, after);
  else
    fprintf(picture->script, "NaN%c", after);
}

/* About ROWS_SHOWN rows, the last among them: what is across, then the curves. */
static void write_rows(sdr_picture *picture, const sdr_column_panel *panel, const double *across,
                       int rows, double across_scale, double scale)
{
  const int last = rows - 1, stride = last / ROWS_SHOWN + 1;
  fputs("$panel << EOD\n", picture->script);
  for (int row = 0;; row = row + stride < last ? row + stride : last) {
    put(picture, across[row] * across_scale, ' ');
    for (int k = 0; k < panel->count; ++k)
      put(picture, panel->value[k][row] * scale, k + 1 < panel->count ? ' ' : '\n');
    if (row == last) break;
  }
  fputs("EOD\n", picture->script);
}

static void write_curves(sdr_picture *picture, const sdr_column_panel *panel)
{
  static const char *const colours[SDR_PANEL_CURVES] = {"#0072b2", "#d55e00", "#009e73",
                                                        "#cc79a7", "#7a5195", "#8c6d31"};
  for (int k = 0; k < panel->count; ++k) {
    fprintf(picture->script, "%s $panel using 1:%d with lines lw 2.5 lc '%s' ", k ? "," : "plot",
            k + 2, colours[k]);
    if (panel->count > 1) {
      fputs("title ", picture->script);
      sdr_picture_quote(picture, panel->part[k], 8);
    } else {
      fputs("notitle", picture->script);
    }
  }
  fputc('\n', picture->script);
}

/* "upper: reaction y". */
static void write_title(sdr_picture *picture, sdr_area area, const sdr_column_panel *panel)
{
  char text[2 * SDR_PANEL_NAME];
  const char *part = panel->count == 1 ? panel->part[0] : "";
  snprintf(text, sizeof text, "%s: %s%s%s%s", panel->name, panel->field, *part ? " " : "", part,
           panel->moved ? " over displacement" : "");
  for (char *c = text + strlen(panel->name); *c; ++c)
    if (*c == '_') *c = ' ';
  sdr_picture_text(picture, area.left, area.bottom + area.height + 0.9 * em, "left", 1.0,
                   0.75 * area.width, text);
}

static void draw_panel(sdr_picture *picture, sdr_area area, const sdr_rundata *run,
                       const sdr_column_panel *panel)
{
  const int rows = run->history.row_count;
  const double *across = panel->moved ? panel->moved : sdr_rundata_column(run, "time");
  const sdr_prefix under = sdr_prefix_for(largest_of(across, rows)), up = prefix_of(panel, rows);
  char text[2 * SDR_PANEL_NAME];
  write_rows(picture, panel, across, rows, under.scale, up.scale);
  write_title(picture, area, panel);
  sdr_axis_label(panel->moved ? "displacement" : "time", panel->moved ? "m" : "s", under, text,
                 sizeof text);
  sdr_picture_text(picture, area.left + 0.5 * area.width, area.bottom - 3.0 * em, "center", 1.0,
                   area.width, text);
  sdr_axis_label(panel->field, panel->unit, up, text, sizeof text);
  for (char *c = text; *c; ++c)
    if (*c == '_') *c = ' ';
  sdr_picture_upright(picture, area.left - 4.9 * em, area.bottom + 0.5 * area.height, 1.0,
                      1.2 * area.height, text);
  fputs("set grid lt 1 lw 0.8 lc rgb '#c8c8c8'\nset xtics out nomirror\nset ytics out nomirror "
        "autofreq\nset offsets graph 0, graph 0, graph 0.05, graph 0.05\n"
        "set key at graph 1, graph 1.06 right center horizontal samplen 2\n",
        picture->script);
  if (strcmp(panel->field, "damage") == 0) fputs("set yrange [0:1]\n", picture->script);
  sdr_picture_place(picture, area);
  write_curves(picture, panel);
  fputs("unset offsets\n", picture->script);
  sdr_picture_clear_axes(picture);
}

static sdr_status draw(const sdr_rundata *run, const sdr_column_panels *panels, const char *png)
{
  const int count = panels->count < MOST_PANELS ? panels->count : MOST_PANELS;
  const int columns = count > 1 ? 2 : 1, lines = (count + columns - 1) / columns;
  const double wide = WIDTH + (left + right) * em, high = HEIGHT + (below + above) * em;
  sdr_picture picture;
  char subtitle[256];
  SDR_TRY(
      sdr_picture_begin(&picture, (int)(columns * wide), (int)(lines * high + heading * em), em));
  sdr_panel_subtitle(run, -1, subtitle, sizeof subtitle);
  sdr_frame_heading(&picture, run, subtitle);
  for (int k = 0; k < count; ++k) {
    const double line = lines - 1 - k / columns;
    const sdr_area area = {floor((k % columns) * wide + left * em), floor(line * high + below * em),
                           WIDTH, HEIGHT};
    draw_panel(&picture, area, run, &panels->panel[k]);
  }
  return sdr_picture_end(&picture, png);
}

static void print_line(const sdr_column_panels *panels, const char *png, FILE *out)
{
  int reactions = 0, probes = 0, moved = 0;
  for (int k = 0; k < panels->count; ++k) {
    const int is_reaction = strcmp(panels->panel[k].field, "reaction") == 0;
    reactions += is_reaction;
    probes += !is_reaction;
    moved += panels->panel[k].moved != NULL;
  }
  fprintf(out, "%s: %s%s%s over time%s", png, reactions ? "reactions" : "",
          reactions && probes ? " and " : "", probes ? "probes" : "",
          moved ? ", and over the prescribed displacement" : "");
  if (panels->count > MOST_PANELS)
    fprintf(out, "; the first %d of %d panels", MOST_PANELS, panels->count);
  fputc('\n', out);
}

sdr_status sdr_plot_reactions(const sdr_rundata *run, FILE *out)
{
  char path[PATH_ROOM];
  sdr_column_panels panels = {0};
  if (run->history.row_count < 2 || !sdr_rundata_column(run, "time")) return SDR_OK;
  SDR_TRY(sdr_column_panels_find(run, &panels));
  sdr_status status = SDR_OK;
  if (panels.count > 0) {
    snprintf(path, sizeof path, "%s/reactions.png", run->directory);
    status = draw(run, &panels, path);
    if (status == SDR_OK) print_line(&panels, path, out);
  }
  sdr_column_panels_clear(&panels);
  return status;
}
