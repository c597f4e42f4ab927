/* Faces of shapes: found by name, cut into pieces, measured from. */
#ifndef SDR_GEOMETRY_FACE_H
#define SDR_GEOMETRY_FACE_H

#include "base/status.h"
#include "scene/scene.h"

/* Faces by primitive:
     box       left right (x), bottom top (y), back front (z), low side first; turned with the box
     disc      rim
     annulus   inner outer
     sphere    inner outer
     cylinder  inner outer bottom top (z), ends: bottom and top
     polygon   rim
     facets    surface
   A face that has no extent (y and z of a box in fewer dimensions, inner of a full body) does not
   exist. A combination has the faces of its parts; what a difference takes away has its normals
   turned round, since they point out of the body. */

/* 1 if the shape (or, for a combination, exactly one primitive of it) has a face of that name. */
int sdr_shape_has_face(const sdr_shape *shape, const char *face);

/* The names of the shape's faces, for messages, like "left, right", each once, in text[size];
   "none" if there are none. Returns `text`. */
const char *sdr_shape_faces(const sdr_shape *shape, char *text, int size);

/* A piece of a face: its middle, its unit normal out of the shape and its measure
   (m in 2-D, m^2 in 3-D, 1 in 1-D). */
typedef struct {
  double x[3], normal[3], measure;
} sdr_piece;

typedef void (*sdr_piece_visitor)(void *context, const sdr_piece *piece);

/* Cut `face` of the shape into pieces no longer than `size` (m) and visit each, in a fixed order.
   The measures add up to the exact measure of the face. Pieces of circles come in eight mirrored
   parts about the axes and diagonals, those of straight edges are equal. Of a face of a
   combination only the pieces on the combination's surface are visited (judged by their middle).
   A face that is missing or not unique is SDR_BAD_INPUT (no origin in the message). */
sdr_status sdr_face_pieces(const sdr_shape *shape, const char *face, sdr_dimension dimension,
                           double size, sdr_piece_visitor visit, void *context);

/* The plane of a flat face (of a box, an end of a cylinder): a place x[3] on it (m) and its unit
   normal out of the body. 0, and nothing written, if the face is round or of several planes, or
   there is none. */
int sdr_face_plane(const sdr_shape *shape, const char *face, double x[3], double normal[3]);

/* Distance of x[3] from the face, m, whole as its primitive has it; INFINITY if there is none. */
double sdr_face_distance(const sdr_shape *shape, const char *face, sdr_dimension dimension,
                         const double x[3]);

#endif
