/* Bulk families: the moments of a full family at (spacing, horizon), which calibrate the constants
   of a model, and the weights b of bonds in the family of their owner. */
#ifndef SDR_NOM_FAMILY_H
#define SDR_NOM_FAMILY_H

#include "nom/influence.h"
#include "nom/points.h"
#include "nom/weight.h"

/* What corrects a lattice's anisotropy or a surface's missing neighbours (theory sec. 5). */
typedef enum {
  SDR_CORRECTION_NONE,
  SDR_CORRECTION_ISO,             /* fourth moments of the lattice's full stencil isotropic */
  SDR_CORRECTION_SURFACE_ISO,     /* of each point's own family, and its sum the full stencil's */
  SDR_CORRECTION_MADENCI_OTERKUS, /* uniaxial strain along x, y, z stores the exact energy */
  SDR_CORRECTIONS                 /* how many there are */
} sdr_correction;

/* A bond's weight is influence function times partial volume times correction. */
typedef struct {
  sdr_influence influence;
  int partial_volume; /* 1: neighbours that the edge of the horizon cuts count partly */
  sdr_correction correction;
  int state_based; /* moments of corrections: 1: r = b xi^2, 0: r = b |xi| (bond-based) */
  int balance; /* 1: bonds between points near the border of two spacings are reweighted, so that
                  uniform strain is in equilibrium there (bond-based; nested lattices with
                  correction none or iso) */
  int printed; /* 1: the model's constants are the continuum's, which madenci_oterkus heeds */
} sdr_families_how;

/* Where the moments come from. */
typedef enum {
  SDR_MOMENTS_STENCIL,  /* the lattice's full stencil */
  SDR_MOMENTS_MEAN,     /* mean over the points whose families are complete (irregular points) */
  SDR_MOMENTS_CONTINUUM /* integrals over the ball: irregular points, none complete */
} sdr_moments_source;

typedef struct {
  double spacing, horizon, volume; /* what its points share: m, m, m^3 */
  sdr_moments_source source;
  int neighbours; /* of the full stencil */
  double first;   /* sum b |xi| V, m^4; b without the factors of madenci_oterkus, which bring
                     energies of axial strains, not of dilation, to what this sum promises */
  double second;  /* sum b xi^2 V, m^5 */
  double moment;  /* sum r V, like `first` without those factors */
  double quartic[SDR_MONOMIALS]; /* sum r V times each quartic monomial of xi/|xi| */
  double cut_share;              /* volume share that a plane cut half a spacing off removes */
  double lambda[SDR_MONOMIALS];  /* iso weights */
  double axial[3];               /* madenci_oterkus: factor of each axis in the bulk */
} sdr_family;

typedef struct {
  const sdr_points *points;
  sdr_families_how how;
  int count;
  sdr_family *family;
  int32_t *of_point; /* index of each point's family; NULL: all have family 0 */
  double *lambda;    /* iso on irregular points, surface_iso: SDR_MONOMIALS a point, from their own
                        families; else NULL */
  double *scale;     /* surface_iso: a point; else NULL */
  double *axial;     /* madenci_oterkus: `components` a point; else NULL */
  uint8_t *border;   /* balance: 1 for points that see, or are seen by, one of another spacing;
                        weights of bonds between two of them are their own. NULL: no such point */
  double *cubic;     /* balance: multipliers, SDR_CUBICS or fewer a point (sdr_cubic) */
  uint8_t *bulk;     /* surface corrections of a lattice: 1 where a family is the full stencil, so
                        that weights between two such points depend on xi only; else NULL */
} sdr_families;

/* The families of arranged points; points with equal spacing, horizon and volume share one.
   Owner: the caller; borrows the points. */
sdr_status sdr_families_create(const sdr_points *points, const sdr_families_how *how,
                               sdr_families **out);
void sdr_families_destroy(sdr_families **families); /* NULL-safe */

static inline const sdr_family *sdr_family_of(const sdr_families *families, int32_t i)
{
  return &families->family[families->of_point ? families->of_point[i] : 0];
}

/* Weight b of the bond i -> j with the reference vector xi[3]; fits sdr_bonds_how. */
double sdr_families_weight(const void *families, int32_t i, int32_t j, const double xi[3]);

/* The same for any bond vector xi[3] of a full family. */
double sdr_family_bond_weight(const sdr_families *families, const sdr_family *family,
                              const double xi[3]);

/* Influence function and partial volume of a bond of this length to a point with this spacing,
   without a correction. */
double sdr_family_plain_weight(const sdr_families *families, const sdr_family *family,
                               double spacing, double length);

/* The vector xi[3] of a stencil step at this spacing, along the points' lattice axes. */
void sdr_stencil_vector(const sdr_points *points, double spacing, const int32_t step[3],
                        double xi[3]);

/* Mean over all directions of each quartic monomial of a unit vector, in the order of
   sdr_quartic. */
void sdr_quartic_means(int components, double mean[SDR_MONOMIALS]);

/* Solve for the iso weights (theory sec. 5): `gram` is sum V r phi phi^T (count x count, row
   major), `moment` sum V r phi, m sum V r. Least squares; lambda gets count values. */
sdr_status sdr_iso_solve(int components, const double *gram, const double *moment, double m,
                         double lambda[SDR_MONOMIALS]);

#endif
