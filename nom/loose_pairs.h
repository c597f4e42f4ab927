/* Loose pairs of points in any position, by both of their points, in padded rows of 8. */
#ifndef SDR_NOM_LOOSE_PAIRS_H
#define SDR_NOM_LOOSE_PAIRS_H

#include "nom/bonds.h"

/* Fill in the loose part and the counts of an empty `bonds`: all pairs {i, j} with j in H_i or i in
   H_j. */
sdr_status sdr_loose_pairs(const sdr_points *points, const sdr_bonds_how *how, sdr_bonds *bonds);

#endif
