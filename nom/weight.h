/* Weights b of a bond in the family of its owner. */
#ifndef SDR_NOM_WEIGHT_H
#define SDR_NOM_WEIGHT_H

enum {
  SDR_MONOMIALS = 15, /* of order 4 in 3-D; 5 in 2-D, 1 in 1-D */
  SDR_CUBICS = 10     /* of order 3 in 3-D; 4 in 2-D, 1 in 1-D */
};

/* Part of a neighbour's volume that lies inside the horizon (003 eq. 10): 1 up to half a spacing
   before it, falling to 1/2 on it. Lengths in one unit. */
static inline double sdr_partial_volume(double distance, double horizon, double spacing)
{
  const double inside = (horizon + 0.5 * spacing - distance) / spacing;
  return inside > 1.0 ? 1.0 : inside < 0.0 ? 0.0 : inside;
}

static inline int sdr_monomial_count(int components)
{
  return components == 1 ? 1 : components == 2 ? 5 : 15;
}

/* Monomials of order 4 of a unit vector: powers of n[0] falling first, then of n[1]. */
static inline int sdr_quartic(int components, const double n[3], double phi[SDR_MONOMIALS])
{
  int count = 0;
  for (int a = 4; a >= 0; --a)
    for (int b = 4 - a; b >= 0; --b) {
      const int c = 4 - a - b;
      if ((components < 3 && c > 0) || (components < 2 && b > 0)) continue;
      double value = 1.0;
      for (int k = 0; k < a; ++k) value *= n[0];
      for (int k = 0; k < b; ++k) value *= n[1];
      for (int k = 0; k < c; ++k) value *= n[2];
      phi[count++] = value;
    }
  return count;
}

/* 1 + lambda.phi, not under 0.2 (theory sec. 5). */
static inline double sdr_iso_weight(int components, const double lambda[SDR_MONOMIALS],
                                    const double n[3])
{
  double phi[SDR_MONOMIALS], shift = 0.0;
  const int count = sdr_quartic(components, n, phi);
  for (int k = 0; k < count; ++k) shift += lambda[k] * phi[k];
  return 1.0 + (shift > -0.8 ? shift : -0.8);
}

#endif
