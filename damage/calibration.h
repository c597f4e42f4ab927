/* Constants of a bond-based body from engineering ones (theory sec. 3). */
#ifndef SDR_DAMAGE_CALIBRATION_H
#define SDR_DAMAGE_CALIBRATION_H

#include "nom/family.h"
#include "scene/scene.h"

/* The Poisson ratio that bond-based bodies have: 1/3 in plane stress, 1/4 in plane strain and 3-D;
   0 in 1-D. */
double sdr_bond_poisson(sdr_dimension dimension);

/* Half micromodulus C, N/m^6 (thickness or area is in the volumes), for Young's modulus `young`. */
double sdr_micromodulus(sdr_dimension dimension, sdr_calibration_kind kind,
                        const sdr_family *family, double young);

/* s0^2 for the toughness Gc (J/m^2). */
double sdr_critical_stretch_squared(sdr_dimension dimension, sdr_calibration_kind kind,
                                    const sdr_family *family, double young, double toughness);

/* Stiffness of a uniform body with this C, by moment sums, and what an isotropic body with
   sdr_bond_poisson has (Pa): c11, c12, c66 = shear along the global axes. 1-D: c11 only. */
typedef struct {
  double c11, c12, c66, exact_c11, exact_c12, exact_c66;
} sdr_effective_stiffness;
sdr_effective_stiffness sdr_stiffness_of(sdr_dimension dimension, const sdr_family *family,
                                         double micromodulus, double young);

/* Energy that a plane cut with unit normal n[3] takes per area (J/m^2) if each directed bond
   absorbs 1/2 C |xi| q: sum over the stencil. `weight` of each stencil bond as in the family. */
sdr_status sdr_separation_energy(const sdr_families *families, const sdr_family *family,
                                 double micromodulus, double threshold, const double n[3],
                                 double *energy);

#endif
