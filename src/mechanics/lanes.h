/* Doubles side by side, as wide as the instruction set that a file is compiled for has registers:
   arithmetic on sdr_lanes is done on each lane for itself, so results do not depend on the width.
   For kernels whose small matrices keep a compiler from seeing the vectors by itself. */
#ifndef SDR_MECHANICS_LANES_H
#define SDR_MECHANICS_LANES_H

#include <math.h>
#include <stdint.h>
#include <string.h>
#ifdef __AVX512F__
#include <immintrin.h>
#endif

#define SDR_INLINE static inline __attribute__((always_inline))

/* All functions below are inlined, so how lanes would be passed does not matter. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wpsabi"
#endif

#if defined(__AVX512F__)
#define SDR_WIDTH 8
#elif defined(__AVX__)
#define SDR_WIDTH 4
#else
#define SDR_WIDTH 2
#endif
typedef double sdr_lanes __attribute__((vector_size(8 * SDR_WIDTH)));

SDR_INLINE sdr_lanes all_lanes(double x)
{
  const sdr_lanes zero = {0.0};
  return x + zero;
}

/* The first `count` lanes from p, the others 0. */
SDR_INLINE sdr_lanes load_lanes(const double *p, int count)
{
  double part[SDR_WIDTH] = {0.0};
  sdr_lanes v;
  if (count == SDR_WIDTH) {
    memcpy(&v, p, sizeof v);
  } else {
    for (int l = 0; l < count; ++l) part[l] = p[l];
    memcpy(&v, part, sizeof v);
  }
  return v;
}

SDR_INLINE void store_lanes(double *p, int count, sdr_lanes v)
{
  if (count == SDR_WIDTH)
    memcpy(p, &v, sizeof v);
  else
    for (int l = 0; l < count; ++l) p[l] = v[l];
}

SDR_INLINE void add_lanes(double *p, int count, sdr_lanes v)
{
  store_lanes(p, count, load_lanes(p, count) + v);
}

/* p[index[lane]] */
SDR_INLINE sdr_lanes gather_lanes(const double *p, const int32_t *index)
{
#if defined(__AVX512F__)
  return (sdr_lanes)_mm512_i32gather_pd(_mm256_loadu_si256((const __m256i *)index), p, 8);
#else
  double part[SDR_WIDTH];
  for (int l = 0; l < SDR_WIDTH; ++l) part[l] = p[index[l]];
  return load_lanes(part, SDR_WIDTH);
#endif
}

SDR_INLINE sdr_lanes root_lanes(sdr_lanes x)
{
#if defined(__AVX512F__)
  return (sdr_lanes)_mm512_sqrt_pd((__m512d)x);
#else
  double part[SDR_WIDTH];
  memcpy(part, &x, sizeof x);
  for (int l = 0; l < SDR_WIDTH; ++l) part[l] = sqrt(part[l]);
  return load_lanes(part, SDR_WIDTH);
#endif
}

/* a where x > y, else b. */
SDR_INLINE sdr_lanes where_above(sdr_lanes x, sdr_lanes y, sdr_lanes a, sdr_lanes b)
{
  typedef int64_t lane_bits __attribute__((vector_size(8 * SDR_WIDTH)));
  const lane_bits mask = x > y;
  return (sdr_lanes)((mask & (lane_bits)a) | (~mask & (lane_bits)b));
}

#endif
