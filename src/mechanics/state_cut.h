/* Plane cuts through families: directions to try, and families to try them on. */
#ifndef SDR_MECHANICS_STATE_CUT_H
#define SDR_MECHANICS_STATE_CUT_H

#include "nom/bonds.h"

enum {
  SDR_CUT_DIRECTIONS = 203, /* at most */
  SDR_CUT_TRIED = 512,      /* points looked at for complete families, where bonds are loose */
  SDR_CUT_ENOUGH = 16       /* complete families that are enough */
};

/* Unit normals: the lattice's axes, then others even over half of all directions. Returns how
   many. */
int sdr_cut_directions(const sdr_points *points, double normal[SDR_CUT_DIRECTIONS][3]);

/* Sample k of the points, any number of them spread evenly over their storage. */
int32_t sdr_cut_sample(const sdr_points *points, int k);

/* 1 if the family of point i, whose bonds are loose, is the lattice's full stencil, or, of
   irregular points, fills its ball and lies around it. */
int sdr_cut_complete(const sdr_points *points, const sdr_bonds *bonds, int32_t i);

/* How far families of loose bonds reach across a plane, over the horizon: mean over complete
   families and directions of the largest xi.n; 1 if no family is complete. Points nearer to a cut
   than that lose bonds. */
double sdr_cut_reach(const sdr_points *points, const sdr_bonds *bonds);

#endif
