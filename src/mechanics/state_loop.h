/* What the kernels of state-based bodies share: blocks of a run's pairs, and a pair's stretch. Like
   bond_loop.h, but passes over a block hand on what they found in buffers of the first-level
   cache, so that i and j sides, which overlap where a run lies along its own row, are added apart.
 */
#ifndef SDR_MECHANICS_STATE_LOOP_H
#define SDR_MECHANICS_STATE_LOOP_H

#include "nom/bonds.h"

#include <math.h>

#ifndef SDR_INLINE
#define SDR_INLINE static inline __attribute__((always_inline))
#endif

enum { SDR_STATE_PAIRS = 256 }; /* a block at most */

/* Pairs (i + k, j + k), slots slot + k, 0 <= k < count, of one class. */
typedef struct {
  int64_t i, j, slot;
  int32_t class_index;
  int count;
} sdr_state_pairs;

SDR_INLINE sdr_state_pairs sdr_state_pairs_of(const sdr_bond_run *run, int32_t start)
{
  const int32_t left = run->length - start;
  return (sdr_state_pairs){run->i0 + start, run->j0 + start, run->slot + start, run->class_index,
                           left < SDR_STATE_PAIRS ? left : SDR_STATE_PAIRS};
}

/* 1 if i and j points of a run overlap. */
SDR_INLINE int sdr_state_overlap(const sdr_bond_run *run)
{
  return (run->j0 > run->i0 ? run->j0 - run->i0 : run->i0 - run->j0) < run->length;
}

/* Stretch s and r = 1 + s from z = (2 xi.eta + eta^2)/xi^2, both to full precision (theory sec. 2):
   r - 1 lacks only digits that s^2 + 2 s = z gives back. */
typedef struct {
  double s, r;
} sdr_state_stretch;

SDR_INLINE sdr_state_stretch sdr_state_stretch_of(double z)
{
  const double square = 1.0 + z;
  const double r = sqrt(square > 1e-18 ? square : 1e-18); /* l = 0 but for rounding: no force */
  const double rough = r - 1.0;
  return (sdr_state_stretch){rough + 0.5 * (z - rough * (rough + 2.0)), r};
}

#endif
