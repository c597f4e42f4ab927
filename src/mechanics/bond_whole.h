/* How large the whole numbers of mixed precision are, for bond_loop.h: from their bits, which cost
   one operation each. */
#ifndef SDR_MECHANICS_BOND_WHOLE_H
#define SDR_MECHANICS_BOND_WHOLE_H

enum { SDR_WHOLES = 16 }; /* whole numbers that are looked at together */

SDR_INLINE int32_t amount_bits(int32_t x)
{
  /* gcc and clang shift the sign in; x < 0 ? ~x : x says the same. */
  /* cppcheck-suppress shiftTooManyBitsSigned */
  return x ^ (x >> 31);
}

/* All bits that the amounts of a block's forces have; behind its pairs stand zeros. */
SDR_INLINE int32_t bits_of(const int components, int32_t *const F[3], int count)
{
  const int n = (count + SDR_WHOLES - 1) / SDR_WHOLES * SDR_WHOLES;
  int32_t bits = 0;
#pragma omp simd reduction(| : bits)
  for (int k = 0; k < n; ++k) {
    bits |= amount_bits(F[0][k]);
    if (components > 1) bits |= amount_bits(F[1][k]);
    if (components > 2) bits |= amount_bits(F[2][k]);
  }
  return bits;
}

#endif
