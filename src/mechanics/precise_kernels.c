/* The instances of the loops with double histories, and their table. Compiled once for each
   instruction set. */
#include "mechanics/bond_precise.h"

#ifndef SDR_ISA
#define SDR_ISA baseline
#endif
#define SDR_JOIN_(a, b) a##b
#define SDR_JOIN(a, b) SDR_JOIN_(a, b)

#define SDR_PRECISE(law, code, n, each)                                                            \
  static void force_##law##_##n##each(const sdr_bond_body *body, int64_t first, int64_t end,       \
                                      double *const u[3], double *const f[3])                      \
  {                                                                                                \
    precise_force_of_runs(n, code, each, body, first, end, u, f);                                  \
  }                                                                                                \
  static void loose_##law##_##n##each(const sdr_bond_body *body, int64_t first, int64_t end,       \
                                      double *const u[3], double *const f[3])                      \
  {                                                                                                \
    precise_force_of_loose(n, code, each, body, first, end, u, f);                                 \
  }                                                                                                \
  static void energies_##law##_##n##each(const sdr_bond_body *body, int64_t first, int64_t end,    \
                                         double *const u[3], sdr_stripe_energies *sum)             \
  {                                                                                                \
    precise_energies_of_runs(n, code, each, body, first, end, u, sum);                             \
  }                                                                                                \
  static void loose_energies_##law##_##n##each(const sdr_bond_body *body, int64_t first,           \
                                               int64_t end, double *const u[3],                    \
                                               sdr_stripe_energies *sum)                           \
  {                                                                                                \
    precise_energies_of_loose(n, code, each, body, first, end, u, sum);                            \
  }
#define SDR_PRECISE_LAW(law, code)                                                                 \
  SDR_PRECISE(law, code, 1, 0)                                                                     \
  SDR_PRECISE(law, code, 1, 1)                                                                     \
  SDR_PRECISE(law, code, 2, 0)                                                                     \
  SDR_PRECISE(law, code, 2, 1)                                                                     \
  SDR_PRECISE(law, code, 3, 0)                                                                     \
  SDR_PRECISE(law, code, 3, 1)

SDR_LAWS(SDR_PRECISE_LAW)

#define SDR_PRECISE_COMMIT(n)                                                                      \
  static void commit_##n(const sdr_bond_body *body, int64_t first, int64_t end,                    \
                         double *const u[3])                                                       \
  {                                                                                                \
    precise_commit_of_runs(n, body, first, end, u);                                                \
  }
SDR_PRECISE_COMMIT(1)
SDR_PRECISE_COMMIT(2)
SDR_PRECISE_COMMIT(3)

#define SDR_PRECISE_ROW(kind, law, code)                                                           \
  [code] = {{kind##_##law##_10, kind##_##law##_11},                                                \
            {kind##_##law##_20, kind##_##law##_21},                                                \
            {kind##_##law##_30, kind##_##law##_31}},
#define SDR_PRECISE_FORCE_ROW(law, code) SDR_PRECISE_ROW(force, law, code)
#define SDR_PRECISE_LOOSE_ROW(law, code) SDR_PRECISE_ROW(loose, law, code)
#define SDR_PRECISE_ENERGIES_ROW(law, code) SDR_PRECISE_ROW(energies, law, code)
#define SDR_LOOSE_ENERGIES_ROW(law, code) SDR_PRECISE_ROW(loose_energies, law, code)

const sdr_precise_kernels SDR_JOIN(sdr_precise_kernels_,
                                   SDR_ISA) = {.run_force = {SDR_LAWS(SDR_PRECISE_FORCE_ROW)},
                                               .loose_force = {SDR_LAWS(SDR_PRECISE_LOOSE_ROW)},
                                               .run_energies = {SDR_LAWS(SDR_PRECISE_ENERGIES_ROW)},
                                               .loose_energies = {SDR_LAWS(SDR_LOOSE_ENERGIES_ROW)},
                                               .run_commit = {commit_1, commit_2, commit_3}};
