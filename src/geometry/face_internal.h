/* What the files about faces share. */
#ifndef SDR_GEOMETRY_FACE_INTERNAL_H
#define SDR_GEOMETRY_FACE_INTERNAL_H

#include "geometry/face.h"

enum { FACE_NAMES = 6, ROUND_INNER = 0, ROUND_OUTER, ROUND_BOTTOM, ROUND_TOP, ROUND_ENDS };

/* A face of one primitive; flip: the primitive is taken away, so its normals turn round. */
typedef struct {
  const sdr_shape *shape;
  int index, flip;
} sdr_found_face;

/* Number of primitives with a face of that name; the first one goes to *found. */
int sdr_face_find(const sdr_shape *shape, const char *name, int flip, sdr_found_face *found);

#endif
