#include "app/plot.h"

#include "app/plot_frame.h"
#include "app/plot_ledger.h"
#include "app/plot_movie.h"
#include "app/plot_panel.h"
#include "app/plot_reactions.h"
#include "app/plot_units.h"

#include <math.h>
#include <string.h>

enum { PATH_ROOM = 4200 };
enum { LEDGER_WIDTH = 1600, LEDGER_HEIGHT = 1270 };

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
                         LEDGER_HEIGHT - (sdr_frame_below + sdr_frame_above + 2.5) * em};
  sdr_panel_ledger(&picture, area, run, &range);
  SDR_TRY(sdr_picture_end(&picture, png));
  fprintf(out, "%s: energies over time\n", png);
  return SDR_OK;
}

/* The field to draw where none is named; a first one that is not there is said. NULL: no frames. */
static const char *choose_field(const sdr_rundata *run, FILE *out)
{
  static const char *const names[] = {"damage", "displacement", "velocity", "stress", "strain"};
  const char *first = sdr_rundata_text(run, "equation") ? "error" : names[0];
  const int last = run->frame_count - 1;
  if (last < 0 || sdr_rundata_has(run, last, first)) return first;
  for (size_t k = 1; k < sizeof names / sizeof *names; ++k)
    if (sdr_rundata_has(run, last, names[k])) {
      fprintf(out, "%s: no field %s; drawing %s\n", run->directory, first, names[k]);
      return names[k];
    }
  return first;
}

/* What the options ask for that no picture of this run can show. */
static sdr_status check_options(const sdr_rundata *run, const sdr_plot_options *options)
{
  const size_t length = options->png ? strlen(options->png) : 0;
  if (options->png && !options->movie &&
      (length < 4 || strcmp(options->png + length - 4, ".png") != 0))
    return sdr_fail(SDR_BAD_INPUT, "%s: a picture is a PNG; let its name end with .png",
                    options->png);
  if (options->slice_axis > 0 && run->frame_count > 0 && run->dimension < 3)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: only a solid body has slices, and this one has %d dimension%s; leave out "
                    "--slice",
                    run->directory, run->dimension, run->dimension == 1 ? "" : "s");
  return SDR_OK;
}

/* DIRECTORY/FIELD.png; of a time that was asked for, FIELD_at_45us.png. */
static sdr_status name_picture(const sdr_rundata *run, const sdr_plot_options *options,
                               const char *name, char path[PATH_ROOM])
{
  char time[64] = "", at[72] = "";
  int frame = 0;
  if (strchr(name, '/') || strlen(name) > 200)
    return sdr_fail(SDR_BAD_INPUT, "\"%s\" is not the name of a field", name);
  if (!isnan(options->time)) {
    SDR_TRY(choose_frame(run, options->time, &frame));
    sdr_quantity(run->frame_time[frame], "s", 6, time, sizeof time);
    char *blank = strchr(time, ' ');
    if (blank) memmove(blank, blank + 1, strlen(blank));
    snprintf(at, sizeof at, "_at_%s", time);
  }
  snprintf(path, PATH_ROOM, "%s/%s%s.png", run->directory, name, at);
  return SDR_OK;
}

static sdr_status draw(sdr_rundata *run, const sdr_plot_options *options, FILE *out)
{
  char path[PATH_ROOM];
  const int is_equation = sdr_rundata_text(run, "equation") != NULL;
  SDR_TRY(check_options(run, options));
  const char *name = options->field && *options->field ? options->field : choose_field(run, out);
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
    SDR_TRY(sdr_plot_reactions(run, out));
  } else if (!is_equation) {
    fprintf(out, "%s: no rows in history.csv, so no picture of the energies\n", run->directory);
  }
  SDR_TRY(name_picture(run, options, name, path));
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
