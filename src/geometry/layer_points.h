/* Layers of fictitious points outside flat faces (004 sec. 3): where they lie. What moves them is
   in mechanics/layers.h. */
#ifndef SDR_GEOMETRY_LAYER_POINTS_H
#define SDR_GEOMETRY_LAYER_POINTS_H

#include "nom/points.h"
#include "scene/scene.h"

/* A support or load that acts through a layer. */
typedef struct {
  sdr_layer_kind kind;
  int index; /* of the support or of the load in the scene */
  const sdr_place *on;
  sdr_length depth;
  char name[SDR_NAME_MAX + 16]; /* for messages: "support 'clamp'", "traction" */
  sdr_origin origin;
} sdr_layer;

/* The layer of that index: those of the supports come first, in the order of the scene. 0: there
   are fewer. *out points into the scene. */
int sdr_scene_layer(const sdr_scene *scene, int index, sdr_layer *out);

/* Add the points of all layers to the generated points, which are replaced: the mirror images of
   the points that lie within the layer's depth under its face (a relative depth: times the largest
   horizon there), each with its point's volume, spacing, horizon, material and level. A later layer
   mirrors the points of earlier ones too, so that corners are filled. Images that fall into the
   body are left out. A scene without layers keeps its points.

   SDR_BAD_INPUT with the origin: a face that is not flat, not along the lattice or not halfway
   between two of its rows, jittered points, a layer without points or in the place of another. */
sdr_status sdr_layer_points(const sdr_scene *scene, sdr_points **points);

/* Mirror x[3] on the plane of the layer's face. */
void sdr_layer_mirror(const sdr_scene *scene, const sdr_layer *layer, const double x[3],
                      double image[3]);

#endif
