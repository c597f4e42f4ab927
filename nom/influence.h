/* Weights (influence functions) of a neighbour at distance r in a support of radius h, as functions
   of q = r/h, by name (theory, "Nonlocal operators"). */
#ifndef SDR_NOM_INFLUENCE_H
#define SDR_NOM_INFLUENCE_H

#include <math.h>

typedef enum {
  SDR_INFLUENCE_CONSTANT,
  SDR_INFLUENCE_INVERSE,
  SDR_INFLUENCE_INVERSE_SQUARE,
  SDR_INFLUENCE_LINEAR,
  SDR_INFLUENCE_CUBIC,
  SDR_INFLUENCE_GAUSSIAN,
  SDR_INFLUENCES /* how many there are */
} sdr_influence;

/* The weight at q = r/h, 0 < q. `linear` and `cubic` are 0 at q = 1 and beyond; no weight is
   negative. */
static inline double sdr_influence_at(sdr_influence influence, double q)
{
  switch (influence) {
  case SDR_INFLUENCE_INVERSE:
    return 1.0 / q;
  case SDR_INFLUENCE_INVERSE_SQUARE:
    return 1.0 / (q * q);
  case SDR_INFLUENCE_LINEAR:
    return q < 1.0 ? 1.0 - q : 0.0;
  case SDR_INFLUENCE_CUBIC:
    return q < 1.0 ? (1.0 + 2.0 * q) * (1.0 - q) * (1.0 - q) : 0.0; /* 1 - 3 q^2 + 2 q^3 */
  case SDR_INFLUENCE_GAUSSIAN:
    return exp(-6.25 * q * q); /* exp(-(q/0.4)^2) */
  default:
    return 1.0;
  }
}

/* "constant", "1/r", "1/r^2", "linear", "cubic", "gaussian"; NULL for any other value. */
const char *sdr_influence_name(sdr_influence influence);

/* 1 and *out if `name` is one of the names, else 0. */
int sdr_influence_named(const char *name, sdr_influence *out);

#endif
