#include "geometry/import.h"

#include "geometry/layer_points.h"
#include "geometry/point_values.h"
#include "geometry/text.h"
#include "scene/import.h"

/* The file's own horizons. */
static sdr_status take_horizons(const sdr_scene *scene, sdr_points *points)
{
  const sdr_import *import = scene->points.imported;
  for (int32_t i = 0; i < points->count; ++i) {
    char horizon[SDR_LENGTH_TEXT], spacing[SDR_LENGTH_TEXT];
    points->horizon[i] = import->horizon[i];
    if (points->horizon[i] >= points->spacing[i] * (1.0 - 1e-9)) continue;
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: in line %d of the imported file the horizon %s is below the spacing %s, "
                    "so no bond exists; give at least 1 spacing",
                    sdr_origin_text(scene->points.origin), import->line[i],
                    sdr_length_text(points->horizon[i], horizon),
                    sdr_length_text(points->spacing[i], spacing));
  }
  return SDR_OK;
}

sdr_status sdr_imported_points(const sdr_scene *scene, sdr_points **out)
{
  const sdr_import *import = scene->points.imported;
  const double across = scene->points.thickness;
  sdr_points *points = NULL;
  SDR_TRY(sdr_points_create(import->count, import->components, 0, &points));
  points->irregular = 1;
  points->lattice_spacing = scene->points.spacing;
  for (int32_t i = 0; i < points->count; ++i) {
    for (int c = 0; c < import->components; ++c) points->x[c][i] = import->x[c][i];
    points->spacing[i] = sdr_import_spacing(import, i, across);
    points->volume[i] = sdr_import_volume(import, i, across);
  }
  sdr_status status =
      import->horizon ? take_horizons(scene, points) : sdr_points_set_horizon(scene, points);
  if (status == SDR_OK) status = sdr_points_set_material(scene, points);
  if (status == SDR_OK) status = sdr_layer_points(scene, &points);
  if (status == SDR_OK)
    *out = points;
  else
    sdr_points_destroy(&points);
  return status;
}
