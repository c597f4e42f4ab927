#include "app/plot_view.h"

#include "app/plot_units.h"
#include "base/memory.h"

#include <math.h>

enum { MOVED = 0, SLICE = 3, SLICE_VOLUME = 5 };

static sdr_cloud cloud_of(const sdr_rundata *run)
{
  return (sdr_cloud){run->point_count,
                     run->dimension,
                     {run->position[0], run->position[1], run->position[2]},
                     run->volume};
}

/* Move the cloud's points; what a displacement lacks (a bar in the plane) stays. */
static sdr_status move(const sdr_rundata *run, int frame, double factor, sdr_plot_view *view)
{
  float *u = NULL;
  int components = 0;
  SDR_TRY(sdr_rundata_field(run, frame, "displacement", &u, &components));
  sdr_status status = SDR_OK;
  for (int c = 0; c < run->dimension && c < components && status == SDR_OK; ++c) {
    double *place = sdr_alloc((size_t)run->point_count, sizeof *place);
    view->owned[MOVED + c] = place;
    if (!place) status = SDR_RUN_FAILED;
    for (int32_t i = 0; place && i < run->point_count; ++i)
      place[i] =
          run->position[c][i] + factor * (double)u[(size_t)i * (size_t)components + (size_t)c];
    if (place) view->cloud.position[c] = place;
  }
  sdr_free(u);
  return status;
}

static void reach(const sdr_rundata *run, int axis, double *low, double *high)
{
  *low = INFINITY;
  *high = -INFINITY;
  for (int32_t i = 0; i < run->point_count; ++i) {
    *low = fmin(*low, run->position[axis][i]);
    *high = fmax(*high, run->position[axis][i]);
  }
}

static void choose_middle(const sdr_rundata *run, sdr_plot_view *view)
{
  double thinnest = INFINITY;
  for (int axis = 2; axis >= 0; --axis) {
    double low, high;
    reach(run, axis, &low, &high);
    if (!(high - low < thinnest)) continue;
    thinnest = high - low;
    view->slice_axis = axis;
    view->slice_at = 0.5 * (low + high);
  }
}

/* Where the point nearest to the slice lies along its axis; of two the one beyond. NAN: none is
   near. A thin body's spacing comes out too large, so that a layer is told by its points. */
static double layer_of(const sdr_rundata *run, const sdr_plot_view *view)
{
  const double *x = run->position[view->slice_axis];
  double nearest = INFINITY, at = (double)NAN;
  for (int32_t i = 0; i < run->point_count; ++i) {
    const double off = x[i] - view->slice_at, slack = 1e-6 * view->extent.spacing;
    if (!(fabs(off) < nearest - slack || (fabs(off) < nearest + slack && off > 0.0))) continue;
    nearest = fabs(off);
    at = x[i];
  }
  return nearest < 0.75 * view->extent.spacing ? at : (double)NAN;
}

static sdr_status no_slice(const sdr_rundata *run, const sdr_plot_view *view)
{
  char at[64], from[64], to[64];
  double low, high;
  reach(run, view->slice_axis, &low, &high);
  sdr_quantity(view->slice_at, "m", 6, at, sizeof at);
  sdr_quantity(low, "m", 6, from, sizeof from);
  sdr_quantity(high, "m", 6, to, sizeof to);
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: the slice %c = %s meets no point; the points lie from %s to %s",
                  run->directory, "xyz"[view->slice_axis], at, from, to);
}

static sdr_status cut(const sdr_rundata *run, sdr_plot_view *view)
{
  static const int others[3][2] = {{1, 2}, {0, 2}, {0, 1}};
  const size_t count = (size_t)run->point_count;
  const double layer = layer_of(run, view), thick = 0.3 * view->extent.spacing;
  int32_t found = 0;
  view->slice_point = sdr_alloc(count, sizeof *view->slice_point);
  for (int k = SLICE; k <= SLICE_VOLUME; ++k) view->owned[k] = sdr_alloc(count, sizeof(double));
  if (!view->slice_point || !view->owned[SLICE] || !view->owned[SLICE + 1] ||
      !view->owned[SLICE_VOLUME])
    return SDR_RUN_FAILED;
  for (int32_t i = 0; i < run->point_count; ++i) {
    if (!(fabs(run->position[view->slice_axis][i] - layer) <= thick)) continue;
    for (int c = 0; c < 2; ++c)
      view->owned[SLICE + c][found] = view->cloud.position[others[view->slice_axis][c]][i];
    view->owned[SLICE_VOLUME][found] = run->volume ? run->volume[i] : 1.0;
    view->slice_point[found++] = i;
  }
  if (found == 0) return no_slice(run, view);
  view->has_slice = 1;
  view->slice = (sdr_cloud){found,
                            2,
                            {view->owned[SLICE], view->owned[SLICE + 1], NULL},
                            run->volume ? view->owned[SLICE_VOLUME] : NULL};
  return sdr_raster_measure(&view->slice, &view->slice_extent);
}

/* Moved points lie on no lattice, and their spacing is that of the start: pieces may be far apart.
 */
static sdr_status measure(const sdr_rundata *run, const sdr_view_how *how, sdr_plot_view *view)
{
  const sdr_cloud start = cloud_of(run);
  sdr_extent moved;
  SDR_TRY(sdr_raster_measure(&start, &view->extent));
  if (how->deformed == 0.0) return SDR_OK;
  SDR_TRY(sdr_raster_measure(&view->cloud, &moved));
  moved.spacing = view->extent.spacing;
  moved.volume = view->extent.volume;
  moved.lattice = 0;
  moved.squares = view->extent.lattice;
  view->extent = moved;
  return SDR_OK;
}

sdr_status sdr_plot_view_make(const sdr_rundata *run, int frame, const sdr_view_how *how,
                              sdr_plot_view *out)
{
  sdr_plot_view view = {.cloud = cloud_of(run)};
  sdr_status status = SDR_OK;
  if (how->deformed != 0.0) status = move(run, frame, how->deformed, &view);
  if (status == SDR_OK) status = measure(run, how, &view);
  if (status == SDR_OK && run->dimension == 3 && how->slice_axis != SDR_SLICE_NONE) {
    view.slice_axis = how->slice_axis - 1;
    view.slice_at = how->slice_at;
    if (how->slice_axis == SDR_SLICE_MIDDLE) choose_middle(run, &view);
    status = cut(run, &view);
    if (how->deformed != 0.0) {
      view.slice_extent.lattice = 0;
      view.slice_extent.squares = view.extent.squares;
    }
    view.slice_extent.spacing = view.extent.spacing;
  }
  if (status != SDR_OK) {
    sdr_plot_view_clear(&view);
    return status;
  }
  *out = view;
  return SDR_OK;
}

void sdr_plot_view_clear(sdr_plot_view *view)
{
  for (int k = 0; k < 6; ++k) sdr_free(view->owned[k]);
  sdr_free(view->slice_point);
  *view = (sdr_plot_view){0};
}

float *sdr_plot_view_values(const sdr_plot_view *view, const float *value)
{
  float *out = sdr_alloc((size_t)view->slice.count, sizeof *out);
  for (int32_t k = 0; out && k < view->slice.count; ++k) out[k] = value[view->slice_point[k]];
  return out;
}
