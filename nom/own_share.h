/* What a point's own family, neighbours at surfaces and borders missing, stores beside a full one.
 */
#ifndef SDR_NOM_OWN_SHARE_H
#define SDR_NOM_OWN_SHARE_H

#include "nom/bonds.h"
#include "nom/family.h"

/* share[i] = sum over H_i of b |xi| V over that of the full stencil of its kind of points: the
   share of the energy that uniform dilation stores there (bond-based bodies, theory sec. 14);
   0 without a neighbour. By the pairs, however they are held. `share` has points->count values. */
void sdr_own_shares(const sdr_bonds *bonds, const sdr_families *families, double *share);

#endif
