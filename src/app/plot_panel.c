#include "app/plot_panel.h"

#include "app/plot_units.h"
#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

sdr_cloud sdr_panel_cloud(const sdr_rundata *run)
{
  return (sdr_cloud){run->point_count,
                     run->dimension,
                     {run->position[0], run->position[1], run->position[2]},
                     run->volume};
}

const char *sdr_panel_title(const sdr_rundata *run)
{
  const char *title = sdr_rundata_text(run, "title");
  if (!title || !*title) title = sdr_rundata_text(run, "scene");
  return title && *title ? title : run->directory;
}

void sdr_panel_subtitle(const sdr_rundata *run, int frame, char *text, size_t room)
{
  char words[64] = "", time[64] = "";
  const char *law = sdr_rundata_text(run, "damage_law");
  const char *equation = sdr_rundata_text(run, "equation");
  if (equation) {
    snprintf(text, room, "%s, nonlocal operators of order %.0f, %s", equation,
             sdr_rundata_number(run, "order"), sdr_rundata_text(run, "form"));
    for (char *c = text; *c; ++c)
      if (*c == '_') *c = ' ';
    return;
  }
  if (law) snprintf(words, sizeof words, "%.40s damage", strcmp(law, "none") ? law : "no law of");
  for (char *c = words; *c; ++c)
    if (*c == '_') *c = ' ';
  if (frame >= 0) sdr_time_text(run->frame_time[frame], time, sizeof time);
  snprintf(text, room, "%s%s%s%s", words, *words && *time ? ", " : "", *time ? "t = " : "", time);
}

/* Numbers without a unit stand as they are unless they are small. */
static sdr_prefix prefix_of(const sdr_plot_field *field)
{
  const double largest = fmax(fabs(field->low), fabs(field->high));
  return sdr_prefix_for(!*field->unit && largest >= 0.01 && largest < 1e4 ? 1.0 : largest);
}

/* Opaque where there is body. */
static unsigned char *coloured(const sdr_raster *raster, const sdr_plot_field *field)
{
  const size_t count = (size_t)raster->window.width * (size_t)raster->window.height;
  unsigned char *rgba = sdr_alloc(count, 4);
  if (!rgba) return NULL;
  for (size_t k = 0; k < count; ++k) {
    if (isnan(raster->value[k])) continue;
    unsigned char *pixel = rgba + 4 * k;
    sdr_plot_field_colour(field, (double)raster->value[k], pixel);
    for (int c = 0; c < 3; ++c) pixel[c] = (unsigned char)((float)pixel[c] * raster->shade[k]);
    pixel[3] = 255;
  }
  return rgba;
}

/* Labels below and left of the axes, at a fixed distance. */
static void name_axes(sdr_picture *picture, sdr_area area, const char *below, const char *beside)
{
  const double em = picture->font;
  sdr_picture_text(picture, area.left + 0.5 * area.width, area.bottom - 3.1 * em, "center", 1.1,
                   area.width, below);
  sdr_picture_upright(picture, area.left - 5.0 * em, area.bottom + 0.5 * area.height, 1.1,
                      1.2 * area.height, beside);
  fputs("set xtics out nomirror\nset ytics out nomirror autofreq\n", picture->script);
}

/* 1, 2 or 5 times a power of ten, at most `largest`. */
static double round_length(double largest)
{
  const double power = pow(10.0, floor(log10(largest)));
  const double digit = largest / power;
  return power * (digit >= 5.0 ? 5.0 : digit >= 2.0 ? 2.0 : 1.0);
}

/* A solid body has no axes around it: arrows for the directions and a bar for the size, below. */
static void draw_compass(sdr_picture *picture, sdr_area area, const sdr_window *window)
{
  static const double unit[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  static const char *const names[3] = {"x", "y", "z"};
  const double length = 3.0 * picture->font;
  const double at[2] = {area.left + length, area.bottom - 0.35 * length};
  for (int c = 0; c < 3; ++c) {
    double plane[2], depth;
    sdr_raster_project(unit[c], 3, plane, &depth);
    fprintf(picture->script,
            "set arrow from screen %.6f,%.6f to screen %.6f,%.6f lw 2 lc '#303030' filled front\n",
            at[0] / picture->width, at[1] / picture->height,
            (at[0] + length * plane[0]) / picture->width,
            (at[1] + length * plane[1]) / picture->height);
    sdr_picture_text(picture, at[0] + 1.35 * length * plane[0], at[1] + 1.35 * length * plane[1],
                     "center", 1.1, 200, names[c]);
  }
  char text[64];
  const double bar = round_length(0.25 * window->width * window->pixel);
  const double right = area.left + area.width - picture->font;
  const double left = right - bar / (window->width * window->pixel) * area.width;
  const double y = area.bottom - 1.2 * picture->font;
  fprintf(picture->script,
          "set arrow from screen %.6f,%.6f to screen %.6f,%.6f nohead lw 5 lc '#303030' front\n",
          left / picture->width, y / picture->height, right / picture->width, y / picture->height);
  sdr_quantity(bar, "m", 6, text, sizeof text);
  sdr_picture_text(picture, 0.5 * (left + right), y - picture->font, "center", 1.0, 400, text);
}

/* names: of the components to the right and up; NULL: a solid body, seen obliquely. */
static sdr_status draw_raster(sdr_picture *picture, sdr_area area, const sdr_raster *raster,
                              const sdr_plot_field *field, const char *const names[2])
{
  unsigned char *rgba = coloured(raster, field);
  if (!rgba) return SDR_RUN_FAILED;
  const sdr_window *window = &raster->window;
  double x[2] = {window->left, window->left + window->width * window->pixel};
  double y[2] = {window->bottom, window->bottom + window->height * window->pixel};
  const sdr_prefix prefix =
      sdr_prefix_for(fmax(fmax(fabs(x[0]), fabs(x[1])), fmax(fabs(y[0]), fabs(y[1]))));
  for (int c = 0; c < 2; ++c) {
    x[c] *= prefix.scale;
    y[c] *= prefix.scale;
  }
  sdr_picture_place(picture, area);
  if (names) {
    char below[64], beside[64];
    sdr_axis_label(names[0], "m", prefix, below, sizeof below);
    sdr_axis_label(names[1], "m", prefix, beside, sizeof beside);
    name_axes(picture, area, below, beside);
  } else {
    fputs("unset border\n", picture->script);
    draw_compass(picture, area, window);
  }
  sdr_picture_image(picture, window->width, window->height, x, y, rgba);
  sdr_picture_clear_axes(picture);
  sdr_free(rgba);
  return SDR_OK;
}

sdr_status sdr_panel_body(sdr_picture *picture, sdr_area area, const sdr_raster *raster,
                          const sdr_plot_field *field, int dimension)
{
  static const char *const plane[2] = {"x", "y"};
  return draw_raster(picture, area, raster, field, dimension == 3 ? NULL : plane);
}

sdr_status sdr_panel_slice(sdr_picture *picture, sdr_area area, const sdr_raster *raster,
                           const sdr_plot_field *field, const char *const names[2])
{
  return draw_raster(picture, area, raster, field, names);
}

typedef struct {
  double x;
  float value;
} sample;

static int rising(const void *a, const void *b)
{
  const double x = ((const sample *)a)->x, y = ((const sample *)b)->x;
  return (x > y) - (x < y);
}

sdr_status sdr_panel_line(sdr_picture *picture, sdr_area area, const sdr_rundata *run,
                          const sdr_plot_field *field, const double x[2])
{
  const int32_t count = run->point_count;
  sample *samples = sdr_alloc((size_t)count, sizeof *samples);
  if (!samples) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < count; ++i) samples[i] = (sample){run->position[0][i], field->value[i]};
  qsort(samples, (size_t)count, sizeof *samples, rising);
  const sdr_prefix along = sdr_prefix_for(fmax(fabs(x[0]), fabs(x[1])));
  const sdr_prefix up = prefix_of(field);
  fputs("$line << EOD\n", picture->script);
  for (int32_t i = 0; i < count; ++i)
    fprintf(picture->script, "%.9g %.9g\n", samples[i].x * along.scale,
            (double)samples[i].value * up.scale);
  fputs("EOD\n", picture->script);
  sdr_free(samples);
  sdr_picture_place(picture, area);
  char below[64], beside[400];
  sdr_axis_label("x", "m", along, below, sizeof below);
  sdr_axis_label(field->label, field->unit, up, beside, sizeof beside);
  name_axes(picture, area, below, beside);
  const double low = fmin(field->low, field->least), high = fmax(field->high, field->most);
  const double border = 0.03 * (high - low);
  fprintf(picture->script,
          "set grid lt 1 lw 0.8 lc rgb '#c8c8c8'\n"
          "plot [%.9g:%.9g][%.9g:%.9g] $line using 1:2 with %s lw 2 lc '#0b5394' pt 7 ps %.2f "
          "notitle\n",
          x[0] * along.scale, x[1] * along.scale, (low - border) * up.scale,
          (high + border) * up.scale, count <= 200 ? "linespoints" : "lines", picture->font / 40.0);
  sdr_picture_clear_axes(picture);
  return SDR_OK;
}

static void name_colours(sdr_picture *picture, sdr_area area, const char *label)
{
  sdr_picture_upright(picture, area.left + area.width + 5.0 * picture->font,
                      area.bottom + 0.5 * area.height, 1.1, 1.2 * area.height, label);
}

/* Name and unit; where a few values lie beyond the colours, also how far they go. */
static void colours_label(const sdr_plot_field *field, sdr_prefix prefix, char *text, size_t room)
{
  char beyond[96] = "";
  const double over = fmax(field->most - field->high, field->low - field->least);
  const double farthest = field->most - field->high == over ? field->most : field->least;
  if (over > 1e-3 * (field->high - field->low))
    snprintf(beyond, sizeof beyond, ", some up to %.*f",
             fabs(farthest * prefix.scale) < 10.0 ? 1 : 0, farthest * prefix.scale);
  sdr_axis_label(field->label, field->unit, prefix, text, room);
  const size_t length = strlen(text);
  snprintf(text + length, room - length, "%s", beyond);
}

/* A band for each number; beyond the first 13 the colours come round again. */
static void piece_colours(sdr_picture *picture, sdr_area area, const sdr_plot_field *field)
{
  enum { BANDS = 13 };
  unsigned char rgba[2 * 8 * BANDS];
  const int first = (int)field->least, all = (int)field->most - first + 1;
  const int count = all > BANDS ? BANDS : all;
  char label[400];
  for (int k = 0; k < 4 * count; ++k) {
    sdr_plot_field_colour(field, first + k / 4, rgba + 4 * k);
    rgba[4 * k + 3] = 255;
  }
  snprintf(label, sizeof label, "%s%s", field->label, all > BANDS ? ", colours repeat" : "");
  const double x[2] = {0.0, 1.0}, y[2] = {first - 0.5, first + count - 0.5};
  sdr_picture_place(picture, area);
  name_colours(picture, area, label);
  fprintf(picture->script, "set y2range [%.12g:%.12g]\nset y2tics out 1\n", y[0], y[1]);
  sdr_picture_image(picture, 2, 2 * count, x, y, rgba);
  sdr_picture_clear_axes(picture);
}

void sdr_panel_colours(sdr_picture *picture, sdr_area area, const sdr_plot_field *field)
{
  enum { STEPS = 512 };
  unsigned char rgba[8 * STEPS];
  if (field->pieces) {
    piece_colours(picture, area, field);
    return;
  }
  for (int k = 0; k < STEPS; ++k) {
    const double share = (k + 0.5) / STEPS;
    unsigned char *pixel = rgba + 8 * k;
    sdr_plot_field_colour(field, field->low + share * (field->high - field->low), pixel);
    pixel[3] = 255;
    memcpy(pixel + 4, pixel, 4);
  }
  const sdr_prefix prefix = prefix_of(field);
  const double x[2] = {0.0, 1.0};
  const double y[2] = {field->low * prefix.scale, field->high * prefix.scale};
  char label[400];
  colours_label(field, prefix, label, sizeof label);
  name_colours(picture, area, label);
  sdr_picture_place(picture, area);
  fprintf(picture->script, "set y2range [%.12g:%.12g]\nset y2tics out\n", y[0], y[1]);
  sdr_picture_image(picture, 2, STEPS, x, y, rgba);
  sdr_picture_clear_axes(picture);
}
