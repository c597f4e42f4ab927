/* State-based dual-horizon bodies: ordinary (000 eq. 42) and non-ordinary (correspondence with
   zero-energy control), theory sec. 5. Damage lives at the points. */
#ifndef SDR_MECHANICS_STATE_BASED_H
#define SDR_MECHANICS_STATE_BASED_H

#include "mechanics/model.h"
#include "nom/bonds.h"
#include "scene/scene.h"

typedef struct {
  sdr_dimension dimension;
  sdr_law law;    /* none, variational (at the point), critical_stretch (of bonds) */
  sdr_length ell; /* variational: relative to the point's horizon, or m; value 0: the band
                     of points that a plane cut damages */
  sdr_elasticity elasticity; /* non-ordinary */
  sdr_split split;
  sdr_ordinary_form form;               /* ordinary */
  double control_shear, control_normal; /* Pa, P_s and P_n of theory sec. 5; NAN: by the moduli */
  const double *young;                  /* Pa, a point */
  const double *poisson;                /* a material index */
  const double *toughness;              /* J/m^2, a material index */
  int precise; /* for implicit integrators: no matter, histories are in double always */
} sdr_state_based_how;

/* A body over the points; it takes the bonds over (and destroys them, even if it fails). The
   bonds' weights (influence function and corrections) are the omega of theory sec. 5. `how` is
   needed only here. Owner: the caller, through ops. */
sdr_status sdr_ordinary_create(const sdr_points *points, sdr_bonds *bonds,
                               const sdr_state_based_how *how, sdr_model **out);
sdr_status sdr_nonordinary_create(const sdr_points *points, sdr_bonds *bonds,
                                  const sdr_state_based_how *how, sdr_model **out);

#endif
