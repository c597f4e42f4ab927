/* Pieces of a body: connected components over pairs with damage below a threshold; through-cracks
   of a ring. */
#ifndef SDR_OUTPUT_FRAGMENTS_H
#define SDR_OUTPUT_FRAGMENTS_H

#include "mechanics/system.h"

/* count: how many pieces; largest: points in the largest; single: pieces of one point only. */
typedef struct {
  int32_t count, largest, single;
  double effective; /* 1 over the sum of squares of the mass shares; 0: not known (pieces.h) */
} sdr_fragments;

/* piece: points->count numbers out, or NULL; pieces are numbered 0.. by falling size, equal ones by
   their lowest point. A pair with damage >= threshold holds nothing together. Points of fictitious
   layers belong to none: -1. */
sdr_status sdr_fragments_find(sdr_system *system, double threshold, int32_t *piece,
                              sdr_fragments *out);

/* A ring around centre[3] (in x-y; a tube's axis is z); fragments.c has the rules. 0 in 1-D.
   Through-cracks: clusters of points with at least `threshold` damage that reach from the inner to
   the outer surface. */
sdr_status sdr_through_cracks(sdr_system *system, double threshold, const double centre[3],
                              int32_t *count);

/* Cuts that part the ring for good: its sectors, held together by pairs with damage < threshold;
   1 if it is cut once and so still one piece, 0 if it closes around the centre. */
sdr_status sdr_ring_sectors(sdr_system *system, double threshold, const double centre[3],
                            int32_t *count);

#endif
