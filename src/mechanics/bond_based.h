/* Bond-based dual-horizon bodies: every directed bond i -> j (j in H_i) carries an energy with the
   constants of i (theory sec. 1-4). */
#ifndef SDR_MECHANICS_BOND_BASED_H
#define SDR_MECHANICS_BOND_BASED_H

#include "damage/calibration.h"
#include "mechanics/model.h"
#include "nom/bonds.h"

typedef struct {
  sdr_dimension dimension;
  sdr_law law;
  sdr_calibration_kind calibration;
  sdr_length ell;          /* variational, at1: relative to the point's horizon, or m */
  const double *young;     /* Pa, a point */
  const double *toughness; /* J/m^2, a material index */
  const double *strength;  /* Pa, a material index; for cohesive, else NULL is enough */
  const double *share;     /* a point: what its family is to store under uniform dilation, over what
                              a full one does, by a factor on its stiffness (points that split);
                              NULL: what it does by itself */
  int mixed;               /* 1: explicit forces of runs in float arithmetic */
  int precise;             /* 1: histories in double, for implicit integrators */
} sdr_bond_based_how;

/* A body over the points; it takes the bonds over (and destroys them, even if it fails). The
   families calibrate it; they and `how` are needed only here. Owner: the caller, through ops. */
sdr_status sdr_bond_based_create(const sdr_points *points, sdr_bonds *bonds,
                                 const sdr_families *families, const sdr_bond_based_how *how,
                                 sdr_model **out);

#endif
