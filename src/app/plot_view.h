/* The points that a picture of a body shows: where they were, or moved by their displacement; of a
   solid body those of a slice besides. */
#ifndef SDR_APP_PLOT_VIEW_H
#define SDR_APP_PLOT_VIEW_H

#include "app/raster.h"
#include "app/rundata.h"

enum { SDR_SLICE_NONE = -1, SDR_SLICE_MIDDLE = 0 };

typedef struct {
  double deformed; /* times their displacement; 0: where they were at the start */
  int slice_axis;  /* of a solid body: 1, 2, 3: x, y, z = slice_at (m); SDR_SLICE_MIDDLE: through
                      the middle, across the direction in which it is thinnest; SDR_SLICE_NONE */
  double slice_at;
} sdr_view_how;

typedef struct {
  sdr_cloud cloud;
  sdr_extent extent;
  int has_slice, slice_axis; /* 0, 1, 2 */
  double slice_at;
  sdr_cloud slice; /* in the plane of the other two components, in their order */
  sdr_extent slice_extent;
  int32_t *slice_point; /* of the slice's points in the cloud */
  double *owned[6];     /* behind the arrays above */
} sdr_plot_view;

/* The view of a frame that the run was brought to (sdr_rundata_use). SDR_BAD_INPUT: a slice without
   points, or no displacement in the frame where points are to be moved. The caller clears *out. */
sdr_status sdr_plot_view_make(const sdr_rundata *run, int frame, const sdr_view_how *how,
                              sdr_plot_view *out);
void sdr_plot_view_clear(sdr_plot_view *view);

/* Values of the cloud's points for those of the slice; NULL: out of memory. Caller: sdr_free. */
float *sdr_plot_view_values(const sdr_plot_view *view, const float *value);

#endif
