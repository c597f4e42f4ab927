/* Noise that is the same on every machine. */
#ifndef SDR_TESTS_NOISE_H
#define SDR_TESTS_NOISE_H

#include <stdint.h>

/* Uniform in [-1, 1); `state` (not 0) moves on. */
static inline double noise(uint64_t *state)
{
  *state ^= *state << 13;
  *state ^= *state >> 7;
  *state ^= *state << 17;
  return (double)(*state >> 11) * 0x1p-52 - 1.0;
}

#endif
