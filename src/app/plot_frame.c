#include "app/plot_frame.h"

#include "app/plot_panel.h"
#include "app/plot_units.h"
#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* px; films are about half as wide and take a third of the time. */
enum { TARGET = 1150, SLICE_TARGET = 800, FILM_TARGET = 600, FILM_SLICE_TARGET = 420 };
enum { LINE_WIDTH = 1280, LINE_HEIGHT = 760 };

const double sdr_frame_left = 6.0, sdr_frame_right = 8.6, sdr_frame_below = 4.0,
             sdr_frame_above = 4.6;

void sdr_frame_heading(sdr_picture *picture, const sdr_rundata *run, const char *second)
{
  const double middle = 0.5 * picture->width, width = 0.96 * picture->width, em = picture->font;
  sdr_picture_text(picture, middle, picture->height - 1.3 * em, "center", 1.25, width,
                   sdr_panel_title(run));
  sdr_picture_text(picture, middle, picture->height - 3.0 * em, "center", 1.0, width, second);
}

/* ---- what frames share ----------------------------------------------------------------------- */

static void widen(sdr_extent *all, const sdr_extent *one, int first)
{
  if (first) {
    *all = *one;
    return;
  }
  for (int c = 0; c < 2; ++c) {
    all->low[c] = fmin(all->low[c], one->low[c]);
    all->high[c] = fmax(all->high[c], one->high[c]);
  }
  all->spacing = fmin(all->spacing, one->spacing);
}

static void widen_line(const sdr_rundata *run, sdr_frame_scale *scale)
{
  for (int32_t i = 0; i < run->point_count; ++i) {
    const double x = run->position[0][i];
    if (scale->frames == 0 && i == 0) scale->line[0] = scale->line[1] = x;
    scale->line[0] = fmin(scale->line[0], x);
    scale->line[1] = fmax(scale->line[1], x);
  }
}

static void widen_field(sdr_frame_scale *scale, sdr_plot_field *field)
{
  if (scale->frames == 0) {
    scale->field = *field;
    scale->field.value = NULL;
  } else {
    sdr_plot_field_share(&scale->field, field);
  }
}

sdr_status sdr_frame_measure(sdr_rundata *run, int frame, const char *name, const sdr_view_how *how,
                             sdr_frame_scale *scale)
{
  sdr_plot_field field;
  sdr_plot_view view = {0};
  SDR_TRY(sdr_rundata_use(run, frame));
  SDR_TRY(sdr_plot_field_read(run, frame, name, &field));
  sdr_status status = SDR_OK;
  if (run->dimension == 1)
    widen_line(run, scale);
  else
    status = sdr_plot_view_make(run, frame, how, &view);
  if (status == SDR_OK) {
    widen(&scale->body, &view.extent, scale->frames == 0);
    widen(&scale->slice, &view.slice_extent, scale->frames == 0);
    widen_field(scale, &field);
    ++scale->frames;
  }
  sdr_plot_view_clear(&view);
  sdr_plot_field_clear(&field);
  return status;
}

/* ---- drawing --------------------------------------------------------------------------------- */

static sdr_status draw_line(const sdr_rundata *run, const sdr_plot_field *field,
                            const sdr_frame_scale *scale, const char *subtitle, const char *png)
{
  sdr_picture picture;
  const double em = 30.0;
  double x[2] = {scale->line[0], scale->line[1]};
  if (!(x[1] > x[0])) x[1] = x[0] + 1.0;
  const sdr_area area = {sdr_frame_left * em, sdr_frame_below * em, LINE_WIDTH, LINE_HEIGHT};
  SDR_TRY(sdr_picture_begin(&picture, (int)(LINE_WIDTH + (sdr_frame_left + 2.0) * em),
                            (int)(LINE_HEIGHT + (sdr_frame_below + sdr_frame_above) * em), em));
  sdr_frame_heading(&picture, run, subtitle);
  const sdr_status status = sdr_panel_line(&picture, area, run, field, x);
  if (status == SDR_OK) return sdr_picture_end(&picture, png);
  sdr_picture_drop(&picture);
  return status;
}

/* The rasters of a picture; the slice's is empty if there is none. */
typedef struct {
  sdr_raster body, slice;
  int slice_axis;
  double slice_at;
} painted;

static sdr_status draw_slice(sdr_picture *picture, const painted *p, double left, double middle,
                             const sdr_plot_field *field)
{
  static const char *const names[3][2] = {{"y", "z"}, {"x", "z"}, {"x", "y"}};
  const double width = p->slice.window.width, height = p->slice.window.height;
  const sdr_area area = {floor(left), floor(middle - 0.5 * height), width, height};
  char at[64], text[96];
  sdr_quantity(p->slice_at, "m", 4, at, sizeof at);
  snprintf(text, sizeof text, "slice %c = %s", "xyz"[p->slice_axis], at);
  sdr_picture_text(picture, area.left + 0.5 * width, area.bottom + height + picture->font, "center",
                   1.0, width + 10.0 * picture->font, text);
  return sdr_panel_slice(picture, area, &p->slice, field, names[p->slice_axis]);
}

static sdr_status draw_rasters(const sdr_rundata *run, const sdr_plot_field *field,
                               const char *subtitle, const painted *p, const char *png)
{
  sdr_picture picture;
  const int sliced = p->slice.value != NULL;
  const double width = p->body.window.width, height = p->body.window.height;
  const double beside = sliced ? p->slice.window.width : 0.0;
  const double high = sliced ? fmax(height, p->slice.window.height) : height;
  const double em = floor(fmax(fmax(width, beside), high) / 42.0);
  const double gap = sliced ? floor((sdr_frame_left + 1.0) * em) : 0.0, all = width + gap + beside;
  const double margin = fmax(0.0, 26.0 * em - all) / 2.0; /* room for the titles */
  const double bottom = floor(sdr_frame_below * em), top = sdr_frame_above + (sliced ? 1.0 : 0.0);
  const sdr_area area = {floor(sdr_frame_left * em + margin), floor(bottom + 0.5 * (high - height)),
                         width, height};
  const sdr_area bar = {area.left + all + floor(1.2 * em), bottom, floor(1.1 * em), high};
  SDR_TRY(sdr_picture_begin(&picture,
                            (int)(all + (sdr_frame_left + sdr_frame_right) * em + 2.0 * margin),
                            (int)(high + (sdr_frame_below + top) * em), em));
  sdr_frame_heading(&picture, run, subtitle);
  sdr_status status = sdr_panel_body(&picture, area, &p->body, field, run->dimension);
  if (status == SDR_OK && sliced)
    status = draw_slice(&picture, p, area.left + width + gap, bottom + 0.5 * high, field);
  if (status != SDR_OK) {
    sdr_picture_drop(&picture);
    return status;
  }
  sdr_panel_colours(&picture, bar, field);
  return sdr_picture_end(&picture, png);
}

static sdr_status paint(const sdr_plot_view *view, const sdr_plot_field *field,
                        const sdr_frame_scale *scale, painted *out)
{
  const sdr_window window = sdr_raster_window(&scale->body, 1, scale->film ? FILM_TARGET : TARGET);
  SDR_TRY(sdr_raster_paint(&view->cloud, &view->extent, field->value, &window, &out->body));
  out->slice_axis = view->slice_axis;
  out->slice_at = view->slice_at;
  if (!view->has_slice) return SDR_OK;
  const sdr_window across =
      sdr_raster_window(&scale->slice, 1, scale->film ? FILM_SLICE_TARGET : SLICE_TARGET);
  float *value = sdr_plot_view_values(view, field->value);
  if (!value) return SDR_RUN_FAILED;
  const sdr_status status =
      sdr_raster_paint(&view->slice, &view->slice_extent, value, &across, &out->slice);
  sdr_free(value);
  return status;
}

static sdr_status draw_body(const sdr_rundata *run, int frame, const sdr_plot_field *field,
                            const sdr_view_how *how, const sdr_frame_scale *scale,
                            const char *subtitle, const char *png)
{
  sdr_plot_view view;
  painted p = {0};
  SDR_TRY(sdr_plot_view_make(run, frame, how, &view));
  sdr_status status = paint(&view, field, scale, &p);
  if (status == SDR_OK) status = draw_rasters(run, field, subtitle, &p, png);
  sdr_raster_clear(&p.body);
  sdr_raster_clear(&p.slice);
  sdr_plot_view_clear(&view);
  return status;
}

sdr_status sdr_frame_draw(sdr_rundata *run, int frame, const char *name, const sdr_view_how *how,
                          const sdr_frame_scale *scale, const char *png)
{
  sdr_plot_field field;
  char subtitle[256];
  SDR_TRY(sdr_rundata_use(run, frame));
  SDR_TRY(sdr_plot_field_read(run, frame, name, &field));
  field.low = scale->field.low;
  field.high = scale->field.high;
  field.least = scale->field.least;
  field.most = scale->field.most;
  field.palette = scale->field.palette;
  sdr_panel_subtitle(run, frame, subtitle, sizeof subtitle);
  if (how->deformed != 0.0 && run->dimension > 1) {
    const size_t length = strlen(subtitle);
    snprintf(subtitle + length, sizeof subtitle - length, ", displacements × %.4g", how->deformed);
  }
  const sdr_status status = run->dimension == 1
                                ? draw_line(run, &field, scale, subtitle, png)
                                : draw_body(run, frame, &field, how, scale, subtitle, png);
  sdr_plot_field_clear(&field);
  return status;
}
