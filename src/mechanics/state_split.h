/* What it takes to split full families by planes, for models whose critical stretch follows from
   it. */
#ifndef SDR_MECHANICS_STATE_SPLIT_H
#define SDR_MECHANICS_STATE_SPLIT_H

#include "mechanics/state_cut.h"
#include "nom/bonds.h"

/* The bonds of a full family: xi (m, 3 a bond) and omega V_j (m^3, times their unit). */
typedef struct {
  int components, count;
  double *xi, *weight;
  double horizon, thickness;
  int one_of_many; /* 1: others are averaged with it */
  double *space;   /* SDR_SPLIT_SPACE doubles a bond, for whoever needs some */
} sdr_full_family;

enum { SDR_SPLIT_SPACE = 12 };

/* Energy per area that a plane with the unit normal `normal` takes from both its sides, where it
   may lie anywhere: over whatever unit the caller has. */
typedef double (*sdr_split_cost)(const void *context, const sdr_full_family *family,
                                 const double normal[3]);

/* The middle between the cheapest and the dearest of many directions; of at most `directions` of
   them. Loose bonds: means over a few complete families; if there is none, the full stencil of a
   point. */
sdr_status sdr_split_middle(const sdr_points *points, const sdr_bonds *bonds, int directions,
                            sdr_split_cost cost, const void *context, double *out);

#endif
