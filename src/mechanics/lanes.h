/* Doubles side by side, as wide as the instruction set that a file is compiled for has registers:
   arithmetic on sdr_lanes is done on each lane for itself, so results do not depend on the width.
   For kernels whose small matrices keep a compiler from seeing the vectors by itself. */
#ifndef SDR_MECHANICS_LANES_H
#define SDR_MECHANICS_LANES_H

#include <math.h>
#include <stdint.h>
#include <string.h>
#ifdef __AVX__
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

/* One bit a lane. */
enum { SDR_ALL_LANES = (1 << SDR_WIDTH) - 1 };

SDR_INLINE sdr_lanes all_lanes(double x)
{
#if defined(__AVX512F__)
  return (sdr_lanes){x, x, x, x, x, x, x, x};
#elif defined(__AVX__)
  return (sdr_lanes){x, x, x, x};
#else
  return (sdr_lanes){x, x};
#endif
}

/* a b + c, rounded once where the processor can. */
SDR_INLINE sdr_lanes fma_lanes(sdr_lanes a, sdr_lanes b, sdr_lanes c)
{
#if defined(__AVX512F__)
  return (sdr_lanes)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
#elif defined(__FMA__)
  return (sdr_lanes)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
#else
  return a * b + c;
#endif
}

SDR_INLINE sdr_lanes load_lanes(const double *p)
{
  sdr_lanes v;
  memcpy(&v, p, sizeof v);
  return v;
}

SDR_INLINE void store_lanes(double *p, sdr_lanes v)
{
  memcpy(p, &v, sizeof v);
}

SDR_INLINE sdr_lanes root_lanes(sdr_lanes v)
{
#if defined(__AVX512F__)
  return (sdr_lanes)_mm512_sqrt_pd((__m512d)v);
#elif defined(__AVX__)
  return (sdr_lanes)_mm256_sqrt_pd((__m256d)v);
#else
  for (int l = 0; l < SDR_WIDTH; ++l) v[l] = sqrt(v[l]);
  return v;
#endif
}

/* ---- some lanes, the others 0 ---------------------------------------------------------------- */

/* What is not in the mask is not read. */
SDR_INLINE sdr_lanes load_some(const double *p, unsigned mask)
{
#if defined(__AVX512F__)
  return (sdr_lanes)_mm512_maskz_loadu_pd((__mmask8)mask, p);
#else
  if (mask == SDR_ALL_LANES) return load_lanes(p);
  double part[SDR_WIDTH];
  for (int l = 0; l < SDR_WIDTH; ++l) part[l] = mask >> l & 1u ? p[l] : 0.0;
  return load_lanes(part);
#endif
}

SDR_INLINE sdr_lanes only_lanes(unsigned mask, sdr_lanes v)
{
#if defined(__AVX512F__)
  return (sdr_lanes)_mm512_maskz_mov_pd((__mmask8)mask, (__m512d)v);
#else
  if (mask == SDR_ALL_LANES) return v;
  for (int l = 0; l < SDR_WIDTH; ++l)
    if (!(mask >> l & 1u)) v[l] = 0.0;
  return v;
#endif
}

SDR_INLINE sdr_lanes subtract_some(unsigned mask, sdr_lanes a, sdr_lanes b)
{
#if defined(__AVX512F__)
  return (sdr_lanes)_mm512_maskz_sub_pd((__mmask8)mask, (__m512d)a, (__m512d)b);
#else
  return only_lanes(mask, a - b);
#endif
}

/* a + b in some lanes, a in the others. */
SDR_INLINE sdr_lanes add_some(unsigned mask, sdr_lanes a, sdr_lanes b)
{
#if defined(__AVX512F__)
  return (sdr_lanes)_mm512_mask_add_pd((__m512d)a, (__mmask8)mask, (__m512d)a, (__m512d)b);
#else
  return a + only_lanes(mask, b);
#endif
}

/* Some lanes of p; the others are not touched. */
SDR_INLINE void store_some(double *p, unsigned mask, sdr_lanes v)
{
#if defined(__AVX512F__)
  _mm512_mask_storeu_pd(p, (__mmask8)mask, (__m512d)v);
#else
  if (mask == SDR_ALL_LANES) {
    store_lanes(p, v);
    return;
  }
  for (int l = 0; l < SDR_WIDTH; ++l)
    if (mask >> l & 1u) p[l] = v[l];
#endif
}

/* p[index[lane]] */
SDR_INLINE sdr_lanes gather_lanes(const double *p, const int32_t *index)
{
#if defined(__AVX512F__)
  __mmask8 all = 0xff;
  __asm__("" : "+k"(all)); /* known to be all lanes, gcc 12 has it wait for the gather before */
  return (sdr_lanes)_mm512_mask_i32gather_pd(_mm512_setzero_pd(), all,
                                             _mm256_loadu_si256((const __m256i *)index), p, 8);
#else
  double part[SDR_WIDTH];
  for (int l = 0; l < SDR_WIDTH; ++l) part[l] = p[index[l]];
  return load_lanes(part);
#endif
}

/* Bits of lanes: all or none of them, as a mask. */
typedef int64_t sdr_lanes_bits __attribute__((vector_size(8 * SDR_WIDTH)));

/* a where all bits of the mask are set, b where none is. */
SDR_INLINE sdr_lanes where_set(sdr_lanes_bits mask, sdr_lanes a, sdr_lanes b)
{
  return (sdr_lanes)((mask & (sdr_lanes_bits)a) | (~mask & (sdr_lanes_bits)b));
}

/* a where x > y, else b. */
SDR_INLINE sdr_lanes where_above(sdr_lanes x, sdr_lanes y, sdr_lanes a, sdr_lanes b)
{
  return where_set(x > y, a, b);
}

/* ---- lanes of four bytes --------------------------------------------------------------------- */

typedef float sdr_lanes_float __attribute__((vector_size(4 * SDR_WIDTH)));
typedef int32_t sdr_lanes_int __attribute__((vector_size(4 * SDR_WIDTH)));

SDR_INLINE sdr_lanes_float load_floats(const float *p)
{
  sdr_lanes_float v;
  memcpy(&v, p, sizeof v);
  return v;
}

SDR_INLINE sdr_lanes_int load_ints(const int32_t *p)
{
  sdr_lanes_int v;
  memcpy(&v, p, sizeof v);
  return v;
}

SDR_INLINE sdr_lanes_float floats_of(sdr_lanes v)
{
  return __builtin_convertvector(v, sdr_lanes_float);
}

SDR_INLINE sdr_lanes lanes_of_floats(sdr_lanes_float v)
{
  return __builtin_convertvector(v, sdr_lanes);
}

/* Whole numbers with their sign. */
SDR_INLINE sdr_lanes_int ints_of(sdr_lanes_bits v)
{
  return __builtin_convertvector(v, sdr_lanes_int);
}

SDR_INLINE sdr_lanes_bits bits_of_ints(sdr_lanes_int v)
{
  return __builtin_convertvector(v, sdr_lanes_bits);
}

/* 1 if some lane is not 0. */
SDR_INLINE int any_ints(sdr_lanes_int v)
{
#if defined(__AVX512F__)
  return !_mm256_testz_si256((__m256i)v, (__m256i)v);
#elif defined(__AVX__)
  return !_mm_testz_si128((__m128i)v, (__m128i)v);
#else
  return (v[0] | v[1]) != 0;
#endif
}

SDR_INLINE sdr_lanes_int some_ints(sdr_lanes_int mask, sdr_lanes_int a, sdr_lanes_int b)
{
  return (mask & a) | (~mask & b);
}

#endif
