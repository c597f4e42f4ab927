/* Records of points: what kernels of loose pairs read of the other end of a pair, side by side, so
   that one cache line has it all and it comes in whole vectors. Gathering the same numbers one by
   one from an array each takes three times as long. */
#ifndef SDR_MECHANICS_RECORDS_H
#define SDR_MECHANICS_RECORDS_H

#include "mechanics/lanes.h"
#include "nom/bonds.h"

/* Four numbers; a point may have several records, each with the points' ones behind another. */
enum { SDR_RECORD = 4 };

/* out[k] = number k of the records at from + stride j[lane]; records begin at multiples of their
   size. */
SDR_INLINE void record_lanes(const double *from, const int stride, const int32_t *j,
                             sdr_lanes out[SDR_RECORD])
{
#if defined(__AVX512F__)
  const __m512i low = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
  const __m512i high = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
  __m512d r[4]; /* records k and k + 4 */
  for (int k = 0; k < 4; ++k) {
    const __m512d one = _mm512_castpd256_pd512(_mm256_load_pd(from + (int64_t)stride * j[k]));
    r[k] = _mm512_insertf64x4(one, _mm256_load_pd(from + (int64_t)stride * j[k + 4]), 1);
  }
  const __m512d even[2] = {_mm512_unpacklo_pd(r[0], r[1]), _mm512_unpacklo_pd(r[2], r[3])};
  const __m512d odd[2] = {_mm512_unpackhi_pd(r[0], r[1]), _mm512_unpackhi_pd(r[2], r[3])};
  out[0] = (sdr_lanes)_mm512_permutex2var_pd(even[0], low, even[1]);
  out[1] = (sdr_lanes)_mm512_permutex2var_pd(odd[0], low, odd[1]);
  out[2] = (sdr_lanes)_mm512_permutex2var_pd(even[0], high, even[1]);
  out[3] = (sdr_lanes)_mm512_permutex2var_pd(odd[0], high, odd[1]);
#elif defined(__AVX__)
  __m256d r[4];
  for (int k = 0; k < 4; ++k) r[k] = _mm256_load_pd(from + (int64_t)stride * j[k]);
  const __m256d even[2] = {_mm256_unpacklo_pd(r[0], r[1]), _mm256_unpacklo_pd(r[2], r[3])};
  const __m256d odd[2] = {_mm256_unpackhi_pd(r[0], r[1]), _mm256_unpackhi_pd(r[2], r[3])};
  out[0] = (sdr_lanes)_mm256_permute2f128_pd(even[0], even[1], 0x20);
  out[1] = (sdr_lanes)_mm256_permute2f128_pd(odd[0], odd[1], 0x20);
  out[2] = (sdr_lanes)_mm256_permute2f128_pd(even[0], even[1], 0x31);
  out[3] = (sdr_lanes)_mm256_permute2f128_pd(odd[0], odd[1], 0x31);
#else
  for (int k = 0; k < SDR_RECORD; ++k)
    out[k] = (sdr_lanes){from[(int64_t)stride * j[0] + k], from[(int64_t)stride * j[1] + k]};
#endif
}

/* The same of eight lanes, out[k][lane]; rows of out begin at multiples of their size. */
SDR_INLINE void gather_records(const double *from, const int stride, const int32_t *j,
                               double out[SDR_RECORD][SDR_LANES])
{
  for (int lane = 0; lane < SDR_LANES; lane += SDR_WIDTH) {
    sdr_lanes record[SDR_RECORD];
    record_lanes(from, stride, j + lane, record);
    for (int k = 0; k < SDR_RECORD; ++k) store_lanes(out[k] + lane, record[k]);
  }
}

/* out[lane] = from[j[lane]], where nothing else is needed of these points. */
SDR_INLINE void gather_points(const double *from, const int32_t *j, double out[SDR_LANES])
{
  for (int lane = 0; lane < SDR_LANES; lane += SDR_WIDTH)
    store_lanes(out + lane, gather_lanes(from, j + lane));
}

/* out[lane] = from[point[lane]] */
SDR_INLINE void load_points(const double *from, const int32_t *point, double out[SDR_LANES])
{
  for (int lane = 0; lane < SDR_LANES; ++lane) out[lane] = from[point[lane]];
}

/* to[point[lane]] += from[lane], one lane after the other: lanes may repeat a point. */
SDR_INLINE void add_to_points(const double from[SDR_LANES], const int32_t *point, double *to)
{
  for (int lane = 0; lane < SDR_LANES; ++lane) to[point[lane]] += from[lane];
}

#endif
