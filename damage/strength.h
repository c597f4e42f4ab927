/* Strength of a homogeneous bond-based body: the largest stress that it bears in uniaxial stress,
   all of it stretched alike (theory sec. 4). */
#ifndef SDR_DAMAGE_STRENGTH_H
#define SDR_DAMAGE_STRENGTH_H

#include "nom/family.h"
#include "scene/scene.h"

/* A law and its constants: C (half, N/m^6), q and r as in damage/bond_law.h. */
typedef struct {
  int law; /* one that softens */
  double c, q, r;
} sdr_strength_law;

/* Largest stress (Pa) along the unit vector n[3], the other stresses in the body's plane or space
   zero, by sums over the full stencil; families of irregular points are taken as isotropic. *strain
   (or NULL): the strain along n there. */
sdr_status sdr_strength_along(const sdr_families *families, const sdr_family *family,
                              const sdr_strength_law *law, const double n[3], double *stress,
                              double *strain);

/* Mean, least and largest strength over directions: in 2-D every 5 degrees from the lattice's axis
   to its diagonal, in 3-D 28 directions between an axis, a face's and the space diagonal. */
typedef struct {
  double mean, least, most;
} sdr_strength_range;
sdr_status sdr_strength_over_directions(const sdr_families *families, const sdr_family *family,
                                        const sdr_strength_law *law, sdr_strength_range *out);

/* The law's beta: strength over E s_e of `cohesive` (q = s_e), mean in 2-D of the directions at 0,
   22.5 and 45 degrees to the lattice's axis, in 3-D of those above. */
sdr_status sdr_cohesive_beta(const sdr_families *families, const sdr_family *family, double c,
                             double young, double *beta);

/* Constants of `cohesive` for a strength f_t: s_e and B2 (damage/bond_law.h) from s0^2 of the
   toughness. SDR_BAD_INPUT if the horizon is too large for both. */
sdr_status sdr_cohesive_constants(double horizon, double young, double critical_squared,
                                  double strength, double beta, double *s_e, double *decline);

#endif
