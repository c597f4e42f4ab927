/* The points of a scene whose body comes from a file. */
#ifndef SDR_GEOMETRY_IMPORT_H
#define SDR_GEOMETRY_IMPORT_H

#include "nom/points.h"
#include "scene/scene.h"

/* The points of scene->points.imported, in the file's order, with volume, spacing, horizon and
   material, not yet arranged; on no lattice. SDR_BAD_INPUT with the place in the scene or the file:
   a horizon below the spacing, a material without points. Owner of *out: the caller. */
sdr_status sdr_imported_points(const sdr_scene *scene, sdr_points **out);

#endif
