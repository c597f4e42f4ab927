#include "app/plot.h"

#include "app/plot_frame.h"
#include "app/plot_ledger.h"
#include "app/plot_movie.h"
#include "app/plot_panel.h"
#include "app/plot_units.h"

#include <math.h>
#include <string.h>

enum { PATH_ROOM = 4200 };
enum { LEDGER_WIDTH = 1600, LEDGER_HEIGHT = 1250 };

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

/* How points are shown, as asked for. */
static sdr_view_how view_how(const sdr_plot_options *options)
{
  return (sdr_view_how){options->deformed, options->slice_axis, options->slice_at};
}

static sdr_status draw_field(sdr_rundata *run, const sdr_plot_options *options, const char *name,
                             const char *png, FILE *out)
{
  int frame = 0;
  sdr_frame_scale scale = {0};
  char time[64];
  const sdr_view_how how = view_how(options);
  SDR_TRY(choose_frame(run, options->time, &frame));
  SDR_TRY(sdr_frame_measure(run, frame, name, &how, &scale));
  SDR_TRY(sdr_frame_draw(run, frame, name, &how, &scale, png));
  sdr_quantity(run->frame_time[frame], "s", 6, time, sizeof time);
  fprintf(out, "%s: %s at %s, frame %d of %d\n", png, scale.field.label, time, frame + 1,
          run->frame_count);
  return SDR_OK;
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
  sdr_frame_heading(&picture, run, subtitle);
  const sdr_area area = {sdr_frame_left * em, sdr_frame_below * em,
                         LEDGER_WIDTH - (sdr_frame_left + 6.6) * em,
                         LEDGER_HEIGHT - (sdr_frame_below + sdr_frame_above + 1.8) * em};
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
  if (options->movie) {
    const sdr_view_how how = view_how(options);
    int last;
    if (!isnan(options->time))
      return sdr_fail(SDR_BAD_INPUT, "a movie shows all times; leave out --time or --movie");
    SDR_TRY(choose_frame(run, (double)NAN, &last));
    return sdr_plot_movie(run, name, &how, options->png, out);
  }
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
