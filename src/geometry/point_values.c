#include "geometry/point_values.h"

#include "geometry/place.h"
#include "geometry/text.h"

#include <string.h>

static void place_of(const sdr_points *points, int32_t i, double x[3])
{
  for (int c = 0; c < 3; ++c) x[c] = c < points->components ? points->x[c][i] : 0.0;
}

static sdr_status horizon_too_small(const sdr_scene *scene, const sdr_points *points, int32_t i)
{
  char horizon[SDR_LENGTH_TEXT], spacing[SDR_LENGTH_TEXT], where[SDR_PLACE_TEXT + 8] = "";
  if (scene->points.imported || (sdr_expression_uses(scene->horizon) & SDR_USES_SPACE)) {
    double x[3];
    place_of(points, i, x);
    memcpy(where, " at ", 5);
    sdr_place_text(x, points->components, where + 4);
  }
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: horizon %s is below the spacing %s%s, so no bond exists; give at least "
                  "1 spacing",
                  sdr_origin_text(scene->horizon_origin),
                  sdr_length_text(points->horizon[i], horizon),
                  sdr_length_text(points->spacing[i], spacing), where);
}

sdr_status sdr_points_set_horizon(const sdr_scene *scene, sdr_points *points)
{
  const int uses = sdr_expression_uses(scene->horizon);
  double x[3] = {0.0}, value = 0.0;
  if (uses & SDR_USES_TIME) {
    return sdr_fail(SDR_BAD_INPUT, "%s: the horizon cannot depend on t",
                    sdr_origin_text(scene->horizon_origin));
  }
  for (int32_t i = 0; i < points->count; ++i) {
    place_of(points, i, x);
    if ((i == 0 || (uses & SDR_USES_SPACE)) &&
        sdr_expression_value(scene->horizon, x, 0.0, &value) != SDR_OK) {
      return sdr_fail(SDR_BAD_INPUT, "%s: horizon: %s", sdr_origin_text(scene->horizon_origin),
                      sdr_error_message());
    }
    points->horizon[i] = scene->horizon_relative ? value * points->spacing[i] : value;
    if (!(points->horizon[i] >= points->spacing[i] * (1.0 - 1e-9))) {
      return horizon_too_small(scene, points, i);
    }
  }
  return SDR_OK;
}

static sdr_status check_every_material_used(const sdr_scene *scene, const int64_t used[256])
{
  for (int m = 0; m < scene->material_count; ++m) {
    if (used[m] > 0) continue;
    const char *why = scene->material[m].where.shape || scene->material[m].where.face[0]
                          ? "its place holds none, or later materials cover it"
                          : "later materials cover it";
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: material '%s' has no point: %s; mend the place or leave "
                    "the material out",
                    sdr_origin_text(scene->material[m].origin), scene->material[m].name, why);
  }
  return SDR_OK;
}

sdr_status sdr_points_set_material(const sdr_scene *scene, sdr_points *points)
{
  int64_t used[256] = {0};
  if (scene->material_count > 256) {
    return sdr_fail(SDR_BAD_INPUT, "%s: %d materials; at most 256 are possible",
                    sdr_origin_text(scene->material[256].origin), scene->material_count);
  }
  for (int32_t i = 0; i < points->count; ++i) {
    double x[3];
    place_of(points, i, x);
    int m = scene->material_count - 1;
    const double h = points->spacing[i];
    while (m > 0 && !sdr_place_holds(scene, &scene->material[m].where, x, h, h)) --m;
    points->material[i] = (uint8_t)m;
    ++used[m];
  }
  return check_every_material_used(scene, used);
}
