/* Pieces of a body: connected components over pairs with damage below a threshold; through-cracks
   of a ring. */
#ifndef SDR_OUTPUT_FRAGMENTS_H
#define SDR_OUTPUT_FRAGMENTS_H

#include "mechanics/system.h"

/* component: points->count numbers, pieces numbered 0.. by falling size (ties: lowest point first).
 *count: how many; *largest: points in the largest; *single: pieces of one point only. */
typedef struct {
  int32_t count, largest, single;
} sdr_fragments;

sdr_status sdr_fragments_find(sdr_system *system, double threshold, int32_t *piece,
                              sdr_fragments *out);

/* Through-cracks of a ring around centre[3]: radial cracks that cut it from the inner to the outer
   surface, counted as the number of ring sectors that are separate pieces reaching both surfaces
   (within two spacings), or 1 if the ring is cut once and still one piece; see the .c file for the
   rule. */
sdr_status sdr_through_cracks(sdr_system *system, double threshold, const double centre[3],
                              int32_t *count);

#endif
