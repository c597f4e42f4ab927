/* Sums over one family, bond by bond: shared by the files that make families. */
#ifndef SDR_NOM_FAMILY_SUMS_H
#define SDR_NOM_FAMILY_SUMS_H

#include "nom/family.h"
#include "nom/neighbourhood.h"
#include "nom/stencil.h"

typedef struct {
  int components, state_based;
  double first, second, moment, volume; /* see sdr_family; sum V */
  double offset[3];                     /* sum xi V: far from 0 if the family is one-sided */
  double quartic[SDR_MONOMIALS];
  double gram[SDR_MONOMIALS * SDR_MONOMIALS]; /* sum V r phi phi^T */
} sdr_family_sums;

/* How a bond is weighed in a sum. */
typedef enum {
  SDR_WEIGHED_PLAIN, /* influence and partial volume */
  SDR_WEIGHED_FULL   /* with the corrections known so far */
} sdr_weighing;

/* Sums over the full stencil of a family. */
sdr_family_sums sdr_sum_stencil(const sdr_families *families, const sdr_family *family,
                                const sdr_stencil *stencil, sdr_weighing weighing);
/* Sums over the neighbours of point i. */
sdr_family_sums sdr_sum_neighbours(const sdr_families *families, const sdr_neighbourhood *near,
                                   int32_t i, sdr_weighing weighing);

/* Moments of the means of irregular points' complete families, else of the continuum. */
sdr_status sdr_irregular_moments(sdr_families *families, const sdr_neighbourhood *near);

/* Integral of r over the ball with constant weight 1: what continuum formulas build on. */
double sdr_continuum_moment(const sdr_points *points, const sdr_family *family, int state_based);

/* What each point's own family asks for: lambda, scale, axial and bulk of the families. */
sdr_status sdr_own_iso_weights(sdr_families *families, const sdr_neighbourhood *near);
sdr_status sdr_own_scales(sdr_families *families, const sdr_neighbourhood *near);
sdr_status sdr_own_axial_factors(sdr_families *families, const sdr_neighbourhood *near);
/* The border's weights: border and cubic of the families, if points of several spacings are near
   each other. */
sdr_status sdr_border_weights(sdr_families *families, const sdr_neighbourhood *near);
/* Factor of the weights of a bond between two points of the border along n, from i to j. */
double sdr_border_factor(const sdr_families *families, int32_t i, int32_t j, const double n[3]);
/* Monomials of order 3 of a unit vector; returns how many. */
int sdr_cubic(int components, const double n[3], double phi[SDR_CUBICS]);
/* Factors of the axes that these sums over a full family ask for. */
void sdr_axial_factors(const sdr_families *families, const sdr_family *family,
                       const double quartic[SDR_MONOMIALS], double factor[3]);

#endif
