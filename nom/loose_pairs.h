/* Loose pairs of points in any position, by both of their points, in padded rows of 8. */
#ifndef SDR_NOM_LOOSE_PAIRS_H
#define SDR_NOM_LOOSE_PAIRS_H

#include "nom/bonds.h"

/* Add the loose part and its counts to `bonds`: all pairs {i, j} with j in H_i or i in H_j, but not
   those between two points of `bulk` (NULL: no such point), which are in runs. */
sdr_status sdr_loose_pairs(const sdr_points *points, const sdr_bonds_how *how, const uint8_t *bulk,
                           sdr_bonds *bonds);

#endif
