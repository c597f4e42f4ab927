#include "geometry/place.h"

#include "geometry/face.h"
#include "geometry/shape.h"

const sdr_shape *sdr_place_shape(const sdr_scene *scene, const sdr_place *place)
{
  return place->shape ? place->shape : scene->points.shape;
}

int sdr_place_holds(const sdr_scene *scene, const sdr_place *place, const double x[3],
                    double spacing, double depth)
{
  if (!place->face[0]) return sdr_shape_contains(place->shape, x, SDR_SHAPE_TOLERANCE * spacing);
  const double distance =
      sdr_face_distance(sdr_place_shape(scene, place), place->face, scene->dimension, x);
  return distance <= depth * (1.0 + SDR_SHAPE_TOLERANCE);
}
