/* Loose pairs of points in any position, by both of their points, in padded rows of 8. */
#ifndef SDR_NOM_LOOSE_PAIRS_H
#define SDR_NOM_LOOSE_PAIRS_H

#include "nom/bonds.h"
#include "nom/lattice_groups.h"

/* Add the loose part and its counts to `bonds`: all pairs {i, j} with j in H_i or i in H_j, but not
   those that runs hold (`groups`; NULL: none). */
sdr_status sdr_loose_pairs(const sdr_points *points, const sdr_bonds_how *how,
                           const sdr_lattice_groups *groups, sdr_bonds *bonds);

#endif
