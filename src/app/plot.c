#include "app/plot.h"

#include "app/plot_ledger.h"
#include "app/plot_panel.h"
#include "app/plot_units.h"

#include <math.h>
#include <string.h>

enum { PATH_ROOM = 4200, TARGET = 1150, LINE_WIDTH = 1280, LINE_HEIGHT = 760 };
enum { LEDGER_WIDTH = 1600, LEDGER_HEIGHT = 1250 };

/* Margins around the axes, in letters' sizes. */
static const double left = 5.6, right = 8.6, below = 4.0, above = 4.6;

static void write_heading(sdr_picture *picture, const sdr_rundata *run, const char *second)
{
  const double middle = 0.5 * picture->width, width = 0.96 * picture->width, em = picture->font;
  sdr_picture_text(picture, middle, picture->height - 1.3 * em, "center", 1.25, width,
                   sdr_panel_title(run));
  sdr_picture_text(picture, middle, picture->height - 3.0 * em, "center", 1.0, width, second);
}

/* Which frame `time` means; outside of the frames by more than half the last interval is an error.
 */
static sdr_status choose_frame(const sdr_rundata *run, double time, int *frame)
{
  char asked[64], first[64], last[64];
  const int count = run->frame_count;
  if (count == 0)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: no snapshots, so there is no field to draw; the scene's output.snapshots "
                    "must be above 0 (now perhaps \"output.snapshots: 0\")",
                    run->directory);
  *frame = isnan(time) ? count - 1 : sdr_rundata_nearest(run, time);
  if (isnan(time)) return SDR_OK;
  const double begin = run->frame_time[0], end = run->frame_time[count - 1];
  const double room = count > 1 ? 0.5 * (end - run->frame_time[count - 2]) : 1e-9 * fabs(end);
  if (time >= begin - room && time <= end + room) return SDR_OK;
  sdr_quantity(time, "s", 6, asked, sizeof asked);
  sdr_quantity(begin, "s", 6, first, sizeof first);
  sdr_quantity(end, "s", 6, last, sizeof last);
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: time %s is outside of the snapshots, which reach from %s to %s",
                  run->directory, asked, first, last);
}

static sdr_status draw_line(const sdr_rundata *run, const sdr_plot_field *field,
                            const char *subtitle, const char *png)
{
  sdr_picture picture;
  const double em = 30.0;
  double x[2] = {INFINITY, -INFINITY};
  for (int32_t i = 0; i < run->point_count; ++i) {
    x[0] = fmin(x[0], run->position[0][i]);
    x[1] = fmax(x[1], run->position[0][i]);
  }
  if (!(x[1] > x[0])) x[1] = x[0] + 1.0;
  const sdr_area area = {left * em, below * em, LINE_WIDTH, LINE_HEIGHT};
  SDR_TRY(sdr_picture_begin(&picture, (int)(LINE_WIDTH + (left + 2.0) * em),
                            (int)(LINE_HEIGHT + (below + above) * em), em));
  write_heading(&picture, run, subtitle);
  const sdr_status status = sdr_panel_line(&picture, area, run, field, x);
  if (status == SDR_OK) return sdr_picture_end(&picture, png);
  sdr_picture_drop(&picture);
  return status;
}

static sdr_status draw_raster(const sdr_rundata *run, const sdr_plot_field *field,
                              const char *subtitle, const sdr_raster *raster, const char *png)
{
  sdr_picture picture;
  const double width = raster->window.width, height = raster->window.height;
  const double em = floor(fmax(width, height) / 42.0);
  const double margin = fmax(0.0, 26.0 * em - width) / 2.0; /* room for the titles */
  const sdr_area area = {floor(left * em + margin), floor(below * em), width, height};
  const sdr_area bar = {area.left + width + floor(1.2 * em), area.bottom, floor(1.1 * em), height};
  SDR_TRY(sdr_picture_begin(&picture, (int)(width + (left + right) * em + 2.0 * margin),
                            (int)(height + (below + above) * em), em));
  write_heading(&picture, run, subtitle);
  const sdr_status status = sdr_panel_body(&picture, area, raster, field, run->dimension);
  if (status != SDR_OK) {
    sdr_picture_drop(&picture);
    return status;
  }
  sdr_panel_colours(&picture, bar, field);
  return sdr_picture_end(&picture, png);
}

static sdr_status draw_body(const sdr_rundata *run, const sdr_plot_field *field,
                            const char *subtitle, const char *png)
{
  const sdr_cloud cloud = sdr_panel_cloud(run);
  sdr_extent extent;
  sdr_raster raster;
  SDR_TRY(sdr_raster_measure(&cloud, &extent));
  const sdr_window window = sdr_raster_window(&extent, 1, TARGET);
  SDR_TRY(sdr_raster_paint(&cloud, &extent, field->value, &window, &raster));
  const sdr_status status = draw_raster(run, field, subtitle, &raster, png);
  sdr_raster_clear(&raster);
  return status;
}

static sdr_status draw_field(sdr_rundata *run, const sdr_plot_options *options, const char *name,
                             const char *png, FILE *out)
{
  int frame = 0;
  sdr_plot_field field;
  char subtitle[256], time[64];
  SDR_TRY(choose_frame(run, options->time, &frame));
  SDR_TRY(sdr_rundata_use(run, frame));
  SDR_TRY(sdr_plot_field_read(run, frame, name, &field));
  sdr_panel_subtitle(run, frame, subtitle, sizeof subtitle);
  const sdr_status status = run->dimension == 1 ? draw_line(run, &field, subtitle, png)
                                                : draw_body(run, &field, subtitle, png);
  if (status == SDR_OK) {
    sdr_quantity(run->frame_time[frame], "s", 6, time, sizeof time);
    fprintf(out, "%s: %s at %s, frame %d of %d\n", png, field.label, time, frame + 1,
            run->frame_count);
  }
  sdr_plot_field_clear(&field);
  return status;
}

static sdr_status draw_ledger(const sdr_rundata *run, const char *png, FILE *out)
{
  sdr_picture picture;
  sdr_ledger_range range;
  char subtitle[256];
  const double em = 30.0;
  SDR_TRY(sdr_ledger_range_of(run, &range));
  SDR_TRY(sdr_picture_begin(&picture, LEDGER_WIDTH, LEDGER_HEIGHT, em));
  sdr_panel_subtitle(run, -1, subtitle, sizeof subtitle);
  write_heading(&picture, run, subtitle);
  const sdr_area area = {left * em, below * em, LEDGER_WIDTH - (left + 6.6) * em,
                         LEDGER_HEIGHT - (below + above + 1.8) * em};
  sdr_panel_ledger(&picture, area, run, &range);
  SDR_TRY(sdr_picture_end(&picture, png));
  fprintf(out, "%s: energies over time\n", png);
  return SDR_OK;
}

static sdr_status draw(sdr_rundata *run, const sdr_plot_options *options, FILE *out)
{
  char path[PATH_ROOM];
  const int is_equation = sdr_rundata_text(run, "equation") != NULL;
  const char *fallback = is_equation ? "error" : "damage";
  const char *name = options->field && *options->field ? options->field : fallback;
  if (!run->summary)
    fprintf(out, "%s: no summary.json, so this run has not finished; drawing what is there\n",
            run->directory);
  if (options->png) return draw_field(run, options, name, options->png, out);
  if (run->history.row_count > 0) {
    snprintf(path, sizeof path, "%s/ledger.png", run->directory);
    SDR_TRY(draw_ledger(run, path, out));
  } else if (!is_equation) {
    fprintf(out, "%s: no rows in history.csv, so no picture of the energies\n", run->directory);
  }
  if (strchr(name, '/') || strlen(name) > 200)
    return sdr_fail(SDR_BAD_INPUT, "\"%s\" is not the name of a field", name);
  snprintf(path, sizeof path, "%s/%s.png", run->directory, name);
  return draw_field(run, options, name, path, out);
}

sdr_status sdr_plot(const sdr_plot_options *options, FILE *out)
{
  sdr_rundata *run = NULL;
  SDR_TRY(sdr_rundata_open(options->directory, &run));
  const sdr_status status = draw(run, options, out);
  sdr_rundata_destroy(&run);
  return status;
}
