/* Points in shapes, and faces of shapes cut into pieces. */
#ifndef SDR_GEOMETRY_SHAPE_H
#define SDR_GEOMETRY_SHAPE_H

#include "nom/points.h"
#include "scene/scene.h"

/* 1 if x lies in the shape or within `tolerance` (m) of it (shapes are closed). shape NULL: 1. */
int sdr_shape_contains(const sdr_shape *shape, const double x[3], double tolerance);

/* Smallest box around the shape: low[3], high[3]; unbounded sides are +-INFINITY. */
void sdr_shape_bounds(const sdr_shape *shape, double low[3], double high[3]);

/* 1 if the shape (or, for a combination, exactly one primitive of it) has a face of that name. */
int sdr_shape_has_face(const sdr_shape *shape, const char *face);

/* A piece of a face: its middle, its outward unit normal (out of the shape) and its measure
   (m in 2-D, m^2 in 3-D, 1 in 1-D). */
typedef struct {
  double x[3], normal[3], measure;
} sdr_piece;

typedef void (*sdr_piece_visitor)(void *context, const sdr_piece *piece);

/* Cut `face` of the shape into pieces no longer than `size` and visit each. The measures add up to
   the exact measure of the face, and equal pieces come in symmetric positions. */
sdr_status sdr_face_pieces(const sdr_shape *shape, const char *face, sdr_dimension dimension,
                           double size, sdr_piece_visitor visit, void *context);

/* Distance of x from a face, m (from its bounded extent). */
double sdr_face_distance(const sdr_shape *shape, const char *face, sdr_dimension dimension,
                         const double x[3]);

#endif
