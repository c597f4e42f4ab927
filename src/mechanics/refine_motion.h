/* How points that split hand over where they are and how fast they go. */
#ifndef SDR_MECHANICS_REFINE_MOTION_H
#define SDR_MECHANICS_REFINE_MOTION_H

#include "mechanics/system.h"

/* Set u, v (at the system's time: velocity_offset 0), time, step and the sums of `now` from
   `before`, whose points have split as `map` says; both systems' time is the same then.

   Children at the reference offsets d get u + G d and v + L d, G and L the gradients over the pairs
   of their parent that still hold, near ones most (weight V/|xi|^4). Since the offsets cancel,
   mass, linear momentum and the centre of mass stay. The spin that L gives to the children of each
   parent is taken back from all of them together as one turn about their common centre, so that the
   angular momentum stays too. Theory, "Points that split". */
sdr_status sdr_refine_motion(const sdr_system *before, const sdr_point_map *map, sdr_system *now);

#endif
