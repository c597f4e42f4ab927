/* Bulk families: the moments of a full family at (spacing, horizon), which calibrate the constants
   of a model, and the weights b of its bonds. */
#ifndef SDR_NOM_FAMILY_H
#define SDR_NOM_FAMILY_H

#include "nom/points.h"
#include "nom/weight.h"

typedef enum { SDR_FAMILY_PLAIN, SDR_FAMILY_PARTIAL_VOLUME, SDR_FAMILY_ISO } sdr_family_weight;

/* Where the moments come from. */
typedef enum {
  SDR_MOMENTS_STENCIL,  /* the lattice's full stencil */
  SDR_MOMENTS_MEAN,     /* mean over the points whose families are complete (irregular points) */
  SDR_MOMENTS_CONTINUUM /* integrals over the ball: irregular points, none complete */
} sdr_moments_source;

typedef struct {
  double spacing, horizon, volume; /* what its points share: m, m, m^3 */
  sdr_moments_source source;
  int neighbours;                /* of the full stencil */
  double first;                  /* sum b |xi| V, m^4 */
  double second;                 /* sum b xi^2 V, m^5 */
  double quartic[SDR_MONOMIALS]; /* sum b |xi| V times each quartic monomial of xi/|xi|, m^4 */
  double cut_share;              /* volume share that a plane cut half a spacing off removes */
  double lambda[SDR_MONOMIALS];  /* iso weights */
} sdr_family;

typedef struct {
  const sdr_points *points;
  sdr_family_weight weight;
  int count;
  sdr_family *family;
  int32_t *of_point; /* index of each point's family; NULL: all have family 0 */
  double *lambda;    /* irregular points with iso weights: SDR_MONOMIALS a point, from their own
                        families; else NULL */
} sdr_families;

/* The families of arranged points; points with equal spacing, horizon and volume share one.
   Owner: the caller; borrows the points. */
sdr_status sdr_families_create(const sdr_points *points, sdr_family_weight weight,
                               sdr_families **out);
void sdr_families_destroy(sdr_families **families); /* NULL-safe */

static inline const sdr_family *sdr_family_of(const sdr_families *families, int32_t i)
{
  return &families->family[families->of_point ? families->of_point[i] : 0];
}

/* Weight b of the bond i -> j with the reference vector xi[3]; fits sdr_bonds_how. */
double sdr_families_weight(const void *families, int32_t i, int32_t j, const double xi[3]);

/* The same for any bond vector xi[3] of a family with the given iso weights `lambda`. */
double sdr_family_bond_weight(const sdr_families *families, const sdr_family *family,
                              const double lambda[SDR_MONOMIALS], const double xi[3]);

/* The vector xi[3] of a stencil step at this spacing, along the points' lattice axes. */
void sdr_stencil_vector(const sdr_points *points, double spacing, const int32_t step[3],
                        double xi[3]);

/* Solve for the iso weights (theory sec. 5): `gram` is sum V r phi phi^T (count x count, row
   major), `moment` sum V r phi, m sum V r. Least squares; lambda gets count values. */
sdr_status sdr_iso_solve(int components, const double *gram, const double *moment, double m,
                         double lambda[SDR_MONOMIALS]);

#endif
