/* What a scene says about each point beside its place: horizon and material. */
#ifndef SDR_GEOMETRY_POINT_VALUES_H
#define SDR_GEOMETRY_POINT_VALUES_H

#include "nom/points.h"
#include "scene/scene.h"

/* Set horizon (m) from x and spacing. A horizon below the spacing is SDR_BAD_INPUT: no bond. */
sdr_status sdr_points_set_horizon(const sdr_scene *scene, sdr_points *points);

/* Set the material index: the last material whose place holds the point, else 0. A material that
   gets no point is SDR_BAD_INPUT. */
sdr_status sdr_points_set_material(const sdr_scene *scene, sdr_points *points);

#endif
