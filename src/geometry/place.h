/* What `on:` and `where:` name: a volume or a face of the scene. */
#ifndef SDR_GEOMETRY_PLACE_H
#define SDR_GEOMETRY_PLACE_H

#include "scene/scene.h"

/* The shape of a place; the body's own if the place names none. */
const sdr_shape *sdr_place_shape(const sdr_scene *scene, const sdr_place *place);

/* 1 if a point at x[3] with that spacing (m) belongs to the place: it lies in the volume, or within
   `depth` (m) of the face. The whole body holds every point. */
int sdr_place_holds(const sdr_scene *scene, const sdr_place *place, const double x[3],
                    double spacing, double depth);

#endif
