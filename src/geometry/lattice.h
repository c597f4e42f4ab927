/* The points of a scene: a lattice clipped by a shape, refined, jittered. */
#ifndef SDR_GEOMETRY_LATTICE_H
#define SDR_GEOMETRY_LATTICE_H

#include "nom/points.h"
#include "scene/scene.h"

/* Generate the scene's points, with volume, spacing, horizon, material (and cell on one lattice),
   not yet arranged. No point, a horizon below the spacing, more than 2^31 - 9 points, a material
   without points: SDR_BAD_INPUT with the origin. Owner: the caller. */
sdr_status sdr_lattice_points(const sdr_scene *scene, sdr_points **out);

#endif
