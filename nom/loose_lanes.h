/* Which point each lane of the loose pairs has. */
#ifndef SDR_NOM_LOOSE_LANES_H
#define SDR_NOM_LOOSE_LANES_H

#include "nom/bonds.h"

/* Lanes of the points by how many loose pairs each has (`pairs`), and how long chunks are: fills
   point, lane, stripe_chunk, chunk_count, chunk_slot and slot_count of `loose`, whose owner frees
   them, also on failure. in_order as in sdr_bonds_how; else `all`: points without a loose pair get
   lanes too. */
sdr_status sdr_loose_lanes(const sdr_points *points, const int32_t *pairs, int in_order, int all,
                           sdr_loose *loose);

#endif
