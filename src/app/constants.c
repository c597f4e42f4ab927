#include "app/constants.h"

#include "mechanics/state_body.h"

#include <math.h>

/* The first point of a material; 0 if it has none. */
static int32_t first_point(const sdr_points *points, int material)
{
  for (int32_t i = 0; i < points->count; ++i)
    if (points->material[i] == material) return i;
  return 0;
}

sdr_material_constants sdr_constants_of(const sdr_built *built, int index)
{
  const sdr_scene *scene = built->scene;
  const sdr_material *material = &scene->material[index];
  const double nu =
      isnan(material->poisson) ? 0.0 : material->poisson; /* a bar has no use for it */
  const int controlled = scene->model == SDR_NONORDINARY;
  sdr_material_constants out = {
      .poisson = nu,
      .bulk = sdr_state_bulk(scene->dimension, material->young, nu),
      .shear = sdr_state_shear(scene->dimension, material->young, nu),
      .control_shear = controlled ? built->traits.control_shear : (double)NAN,
      .control_normal = controlled ? built->traits.control_normal : (double)NAN,
      .condition = controlled ? built->traits.condition : (double)NAN};
  double threshold;
  sdr_state_constants(built->model, first_point(built->points, index), &out.ell, &threshold);
  out.critical_stretch = sqrt(threshold);
  return out;
}
