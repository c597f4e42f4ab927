/* Logarithms and exponentials of lanes, each lane for itself: errors of two units in the last place
   at most. */
#ifndef SDR_MECHANICS_LANES_LOG_H
#define SDR_MECHANICS_LANES_LOG_H

#include "mechanics/lanes.h"

#define SDR_LN2_HIGH 0x1.62e42fee00000p-1 /* its products with exponents are exact */
#define SDR_LN2_LOW 0x1.a39ef35793c76p-33

/* ln(1 + x), x > -1 and not denormally close to it. With 1 + x = 2^k (1 + f), 1 + f between
   sqrt(1/2) and sqrt(2), and s = f/(2 + f): ln(1 + f) = 2 (s + s^3/3 + s^5/5 ...), of which the
   first terms are f - f^2/2 + s f^2/2 exactly. f is x itself where k = 0, so that small x lose
   nothing. */
SDR_INLINE sdr_lanes log1p_lanes(sdr_lanes x)
{
  const sdr_lanes at = 1.0 + x;
  const sdr_lanes_bits bits = (sdr_lanes_bits)at, zero = {0};
  const sdr_lanes_bits k = (bits - 0x3fe6a09e667f3bcdLL) >> 52;
  const sdr_lanes exponent = __builtin_convertvector(k, sdr_lanes);
  const sdr_lanes rest = (sdr_lanes)(bits - (k << 52)) - 1.0;
  const sdr_lanes f = where_set(k == zero, x, rest);
  const sdr_lanes s = f / (2.0 + f), z = s * s, half = 0.5 * f * f;
  sdr_lanes sum = all_lanes(2.0 / 19.0);
  sum = fma_lanes(sum, z, all_lanes(2.0 / 17.0));
  sum = fma_lanes(sum, z, all_lanes(2.0 / 15.0));
  sum = fma_lanes(sum, z, all_lanes(2.0 / 13.0));
  sum = fma_lanes(sum, z, all_lanes(2.0 / 11.0));
  sum = fma_lanes(sum, z, all_lanes(2.0 / 9.0));
  sum = fma_lanes(sum, z, all_lanes(2.0 / 7.0));
  sum = fma_lanes(sum, z, all_lanes(2.0 / 5.0));
  sum = fma_lanes(sum, z, all_lanes(2.0 / 3.0));
  const sdr_lanes tail = fma_lanes(s, fma_lanes(sum, z, half), exponent * SDR_LN2_LOW);
  return exponent * SDR_LN2_HIGH - ((half - tail) - f);
}

/* exp(x) - 1, |x| < 700. With x = k ln 2 + r, |r| <= ln(2)/2: 2^k (exp(r) - 1) + (2^k - 1). */
SDR_INLINE sdr_lanes expm1_lanes(sdr_lanes x)
{
  const double shift = 0x1.8p52; /* adding it rounds to a whole number, in the lowest bits */
  const sdr_lanes moved = x * 0x1.71547652b82fep0 + shift, k = moved - shift;
  const sdr_lanes r = fma_lanes(k, all_lanes(-SDR_LN2_LOW), x - k * SDR_LN2_HIGH);
  const sdr_lanes scale = (sdr_lanes)(((sdr_lanes_bits)moved + 1023) << 52);
  sdr_lanes sum = all_lanes(1.0 / 6227020800.0); /* 1/13! */
  sum = fma_lanes(sum, r, all_lanes(1.0 / 479001600.0));
  sum = fma_lanes(sum, r, all_lanes(1.0 / 39916800.0));
  sum = fma_lanes(sum, r, all_lanes(1.0 / 3628800.0));
  sum = fma_lanes(sum, r, all_lanes(1.0 / 362880.0));
  sum = fma_lanes(sum, r, all_lanes(1.0 / 40320.0));
  sum = fma_lanes(sum, r, all_lanes(1.0 / 5040.0));
  sum = fma_lanes(sum, r, all_lanes(1.0 / 720.0));
  sum = fma_lanes(sum, r, all_lanes(1.0 / 120.0));
  sum = fma_lanes(sum, r, all_lanes(1.0 / 24.0));
  sum = fma_lanes(sum, r, all_lanes(1.0 / 6.0));
  sum = fma_lanes(sum, r, all_lanes(0.5));
  const sdr_lanes small = fma_lanes(r * r, sum, r);
  return fma_lanes(scale, small, scale - 1.0);
}

#endif
