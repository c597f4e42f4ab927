/* The full family of a point inside a lattice: all lattice vectors within a horizon. */
#ifndef SDR_NOM_STENCIL_H
#define SDR_NOM_STENCIL_H

#include "base/status.h"

#include <stdint.h>

typedef struct {
  int count;
  int32_t *step; /* 3 a neighbour: lattice vector, in units of the spacing; 0 beyond components */
} sdr_stencil;

/* Vectors d != 0 with |d|^2 <= (horizon/spacing)^2 (1 + 1e-9), z slowest, x fastest, so that
   neighbour k and count - 1 - k are opposite. Owner: the caller. */
sdr_status sdr_stencil_create(int components, double spacing, double horizon, sdr_stencil *out);
void sdr_stencil_destroy(sdr_stencil *stencil);

#endif
