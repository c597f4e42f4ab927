#include "app/compare_parts.h"

#include "app/plot_ledger.h"
#include "app/plot_panel.h"
#include "app/plot_units.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { TARGET = 900, LINE_WIDTH = 1100, LINE_HEIGHT = 600 };

/* Margins and gaps in letters' sizes. */
static const double left = 6.2, right = 8.6, between = 12.4, above = 2.4, heading = 4.2, axis = 4.6,
                    legend = 2.6;

/* What is drawn for the two runs. */
typedef struct {
  const sdr_rundata *run[2];
  int frame[2];
  int fields; /* 1: the upper panels are there */
  sdr_plot_field field[2];
  int dimension;
  sdr_raster raster[2];
  double x[2];   /* in one dimension: the range */
  int ledger[2]; /* which run has one */
  sdr_ledger_range range;
  double largest[2]; /* energy of each run */
} scene;

/* Where things stand, px. */
typedef struct {
  double em, width, height; /* of one field panel */
  double cell;              /* width of a column */
  double ledger;            /* height */
  int canvas[2];
} layout;

static void clear(scene *all)
{
  for (int k = 0; k < 2; ++k) {
    sdr_plot_field_clear(&all->field[k]);
    sdr_raster_clear(&all->raster[k]);
  }
}

/* Paint both bodies in one window, so that they have one scale. */
static sdr_status paint(scene *all)
{
  sdr_cloud cloud[2];
  sdr_extent extent[2];
  for (int k = 0; k < 2; ++k) {
    cloud[k] = sdr_panel_cloud(all->run[k]);
    cloud[k].dimension = all->dimension;
    SDR_TRY(sdr_raster_measure(&cloud[k], &extent[k]));
  }
  const sdr_window window = sdr_raster_window(extent, 2, TARGET);
  for (int k = 0; k < 2; ++k)
    SDR_TRY(sdr_raster_paint(&cloud[k], &extent[k], all->field[k].value, &window, &all->raster[k]));
  return SDR_OK;
}

static void find_range(scene *all)
{
  all->x[0] = INFINITY;
  all->x[1] = -INFINITY;
  for (int k = 0; k < 2; ++k)
    for (int32_t i = 0; i < all->run[k]->point_count; ++i) {
      all->x[0] = fmin(all->x[0], all->run[k]->position[0][i]);
      all->x[1] = fmax(all->x[1], all->run[k]->position[0][i]);
    }
  if (!(all->x[1] > all->x[0])) all->x[1] = all->x[0] + 1.0;
}

/* Damage, or the displacement where a run's snapshots hold no damage. NULL: nothing common. */
static const char *common_field(const scene *all)
{
  static const char *const names[] = {"damage", "displacement"};
  for (int k = 0; k < 2; ++k)
    if (sdr_rundata_has(all->run[0], all->frame[0], names[k]) &&
        sdr_rundata_has(all->run[1], all->frame[1], names[k]))
      return names[k];
  return NULL;
}

static sdr_status prepare_fields(scene *all, FILE *out)
{
  const sdr_frames frames = sdr_compare_frames(all->run[0], all->run[1]);
  memcpy(all->frame, frames.frame, sizeof all->frame);
  if (all->frame[0] < 0 || all->frame[1] < 0) return SDR_OK;
  const char *name = common_field(all);
  if (!name) {
    fprintf(out, "no picture of fields: the snapshots hold neither damage nor displacement in both "
                 "(output.fields)\n");
    return SDR_OK;
  }
  for (int k = 0; k < 2; ++k)
    SDR_TRY(sdr_plot_field_read(all->run[k], all->frame[k], name, &all->field[k]));
  sdr_plot_field_share(&all->field[0], &all->field[1]);
  const int a = all->run[0]->dimension, b = all->run[1]->dimension;
  all->dimension = a > b ? a : b;
  all->fields = 1;
  if (all->dimension > 1) return paint(all);
  find_range(all);
  return SDR_OK;
}

static sdr_status prepare_ledgers(scene *all, FILE *out)
{
  sdr_ledger_range range[2];
  for (int k = 0; k < 2; ++k) {
    all->ledger[k] = all->run[k]->history.row_count > 0;
    if (all->ledger[k])
      SDR_TRY(sdr_ledger_range_of(all->run[k], &range[k]));
    else
      fprintf(out, "%s: no rows in history.csv, so no picture of its energies\n",
              all->run[k]->directory);
  }
  for (int k = 0; k < 2; ++k)
    if (all->ledger[k]) all->largest[k] = range[k].largest;
  if (all->ledger[0] && all->ledger[1])
    all->range = sdr_ledger_range_merge(&range[0], &range[1]);
  else if (all->ledger[0])
    all->range = range[0];
  else if (all->ledger[1])
    all->range = range[1];
  return SDR_OK;
}

static layout lay_out(const scene *all)
{
  layout plan = {.width = LINE_WIDTH, .height = all->fields ? LINE_HEIGHT : 0.0};
  if (all->fields && all->dimension > 1) {
    plan.width = all->raster[0].window.width;
    plan.height = all->raster[0].window.height;
  }
  plan.em = floor(fmax(plan.width, plan.height) / 31.0);
  plan.cell = fmax(plan.width, floor(22.0 * plan.em));
  if (all->ledger[0] || all->ledger[1]) plan.ledger = floor(0.74 * plan.cell);
  const double field_room = all->fields ? plan.height + axis * plan.em : 0.0;
  const double ledger_room = plan.ledger > 0.0 ? plan.ledger + (axis + legend) * plan.em : 0.0;
  plan.canvas[0] = (int)(2.0 * plan.cell + (left + between + right) * plan.em);
  plan.canvas[1] = (int)(field_room + ledger_room + (heading + above) * plan.em);
  return plan;
}

static double column_left(const layout *plan, int k)
{
  return floor(left * plan->em + k * (plan->cell + between * plan->em));
}

/* The directory's own name, which tells variants of a scene apart. */
static const char *last_name(const char *directory)
{
  const char *name = directory;
  for (const char *c = directory; *c; ++c)
    if (*c == '/' && c[1] && c[1] != '/') name = c + 1;
  return name;
}

/* "A: title" over each column, below it directory, law and time. */
static void write_heading(sdr_picture *picture, const scene *all, const layout *plan, int k)
{
  char text[600], second[400], state[256];
  const double middle = column_left(plan, k) + 0.5 * plan->cell;
  const double width = plan->cell + 0.9 * between * plan->em;
  snprintf(text, sizeof text, "%c: %s", 'A' + k, sdr_panel_title(all->run[k]));
  sdr_picture_text(picture, middle, plan->canvas[1] - 1.5 * plan->em, "center", 1.2, width, text);
  sdr_panel_subtitle(all->run[k], all->fields ? all->frame[k] : -1, state, sizeof state);
  snprintf(second, sizeof second, "%.120s%s%s", last_name(all->run[k]->directory),
           *state ? ": " : "", state);
  sdr_picture_text(picture, middle, plan->canvas[1] - 3.2 * plan->em, "center", 1.0, width, second);
}

static sdr_status draw_field(sdr_picture *picture, const scene *all, const layout *plan, int k)
{
  const double bottom = plan->canvas[1] - floor((heading + 0.4) * plan->em) - plan->height;
  const sdr_area area = {column_left(plan, k) + floor(0.5 * (plan->cell - plan->width)), bottom,
                         plan->width, plan->height};
  if (all->dimension == 1)
    return sdr_panel_line(picture, area, all->run[k], &all->field[k], all->x);
  SDR_TRY(sdr_panel_body(picture, area, &all->raster[k], &all->field[k], all->dimension));
  const sdr_area bar = {area.left + area.width + floor(1.2 * plan->em), bottom,
                        floor(1.1 * plan->em), area.height};
  if (k == 1) sdr_panel_colours(picture, bar, &all->field[k]);
  return SDR_OK;
}

static sdr_status draw(sdr_picture *picture, const scene *all, const layout *plan)
{
  for (int k = 0; k < 2; ++k) write_heading(picture, all, plan, k);
  for (int k = 0; k < 2 && all->fields; ++k) SDR_TRY(draw_field(picture, all, plan, k));
  for (int k = 0; k < 2; ++k) {
    const sdr_area area = {column_left(plan, k), floor(axis * plan->em), plan->cell, plan->ledger};
    sdr_ledger_range range = all->range;
    range.largest = all->largest[k]; /* a share is of the run's own */
    if (all->ledger[k]) sdr_panel_ledger(picture, area, all->run[k], &range);
  }
  return SDR_OK;
}

static sdr_status draw_to(const scene *all, const char *png, FILE *out)
{
  sdr_picture picture;
  const layout plan = lay_out(all);
  SDR_TRY(sdr_picture_begin(&picture, plan.canvas[0], plan.canvas[1], plan.em));
  const sdr_status status = draw(&picture, all, &plan);
  if (status != SDR_OK) {
    sdr_picture_drop(&picture);
    return status;
  }
  SDR_TRY(sdr_picture_end(&picture, png));
  fprintf(out, "%s: %s\n", png,
          !all->fields                       ? "energies of both runs"
          : all->ledger[0] || all->ledger[1] ? "fields and energies of both runs"
                                             : "fields of both runs");
  return SDR_OK;
}

sdr_status sdr_compare_picture(const sdr_rundata *a, const sdr_rundata *b, const char *png,
                               FILE *out)
{
  scene all = {.run = {a, b}};
  sdr_status status = prepare_fields(&all, out);
  if (status == SDR_OK) status = prepare_ledgers(&all, out);
  if (status == SDR_OK) {
    if (all.fields || all.ledger[0] || all.ledger[1])
      status = draw_to(&all, png, out);
    else
      fprintf(out, "nothing common to draw, so no picture\n");
  }
  clear(&all);
  return status;
}
