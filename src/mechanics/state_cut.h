/* Plane cuts through families: directions to try, and families to try them on. */
#ifndef SDR_MECHANICS_STATE_CUT_H
#define SDR_MECHANICS_STATE_CUT_H

#include "nom/bonds.h"

enum {
  SDR_CUT_DIRECTIONS = 203, /* at most */
  SDR_CUT_TRIED = 1024,     /* points looked at for complete families, where bonds are loose */
  SDR_CUT_ENOUGH = 2048     /* bonds of complete families that are enough */
};

/* Unit normals: the lattice's axes, then others even over half of all directions. Returns how
   many. */
int sdr_cut_directions(const sdr_points *points, double normal[SDR_CUT_DIRECTIONS][3]);

/* Sample k of the points, any number of them spread evenly over their storage. */
int32_t sdr_cut_sample(const sdr_points *points, int k);

/* 1 if the family of point i, whose bonds are loose, is the lattice's full stencil, or, of
   irregular points, fills its ball and lies around it. */
int sdr_cut_complete(const sdr_points *points, const sdr_bonds *bonds, int32_t i);

/* How far from a cut points lose bonds, over the horizon: the largest xi.n of a family, mean over
   the directions n; but so much more that no cut along an axis of the lattice reaches over 4 %
   farther. A lattice's family reaches farthest there, and there its cracks like to run. Of the full
   family of a lattice: */
double sdr_cut_lattice_reach(const sdr_points *points, int32_t i);
/* Of complete families of loose bonds, mean over a few; 1 if none is complete. */
double sdr_cut_reach(const sdr_points *points, const sdr_bonds *bonds);

#endif
