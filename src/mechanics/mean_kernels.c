/* The instances of the loops of mean forces, and their table. Compiled once for each instruction
   set. */
#include "mechanics/bond_mean_loop.h"

#ifndef SDR_ISA
#define SDR_ISA baseline
#endif
#define SDR_JOIN_(a, b) a##b
#define SDR_JOIN(a, b) SDR_JOIN_(a, b)

#define SDR_MEAN(law, code, n, each, kept)                                                         \
  static void force_##law##_##n##each##kept(const sdr_bond_body *body, int64_t first, int64_t end, \
                                            const sdr_mean_step *step)                             \
  {                                                                                                \
    mean_force_of_runs(n, code, each, kept, body, first, end, step);                               \
  }                                                                                                \
  static void loose_##law##_##n##each##kept(const sdr_bond_body *body, int64_t first, int64_t end, \
                                            const sdr_mean_step *step)                             \
  {                                                                                                \
    mean_of_loose(n, code, each, kept, 0, body, first, end, step);                                 \
  }
#define SDR_MEAN_MODULI(law, code, n)                                                              \
  SDR_MEAN(law, code, n, 0, 0)                                                                     \
  SDR_MEAN(law, code, n, 0, 1)                                                                     \
  SDR_MEAN(law, code, n, 1, 0)                                                                     \
  SDR_MEAN(law, code, n, 1, 1)
#define SDR_MEAN_LAW(law, code)                                                                    \
  SDR_MEAN_MODULI(law, code, 1)                                                                    \
  SDR_MEAN_MODULI(law, code, 2)                                                                    \
  SDR_MEAN_MODULI(law, code, 3)
#define SDR_MEAN_TIMES(n)                                                                          \
  static void times_##n(const sdr_bond_body *body, int64_t first, int64_t end,                     \
                        const sdr_mean_step *step)                                                 \
  {                                                                                                \
    mean_times_of_runs(n, body, first, end, step);                                                 \
  }                                                                                                \
  static void diagonal_##n(const sdr_bond_body *body, int64_t first, int64_t end,                  \
                           const sdr_mean_step *step)                                              \
  {                                                                                                \
    mean_diagonal_of_runs(n, body, first, end, step);                                              \
  }                                                                                                \
  static void loose_times_##n(const sdr_bond_body *body, int64_t first, int64_t end,               \
                              const sdr_mean_step *step)                                           \
  {                                                                                                \
    mean_of_loose(n, SDR_LAW_NONE, 0, 0, 1, body, first, end, step);                               \
  }

SDR_LAWS(SDR_MEAN_LAW)
SDR_MEAN_TIMES(1)
SDR_MEAN_TIMES(2)
SDR_MEAN_TIMES(3)

#define SDR_MEAN_ENTRY(kind, law, n)                                                               \
  {                                                                                                \
    {kind##_##law##_##n##00, kind##_##law##_##n##01},                                              \
    {                                                                                              \
      kind##_##law##_##n##10, kind##_##law##_##n##11                                               \
    }                                                                                              \
  }
#define SDR_MEAN_ROW(kind, law, code)                                                              \
  [code] = {SDR_MEAN_ENTRY(kind, law, 1), SDR_MEAN_ENTRY(kind, law, 2),                            \
            SDR_MEAN_ENTRY(kind, law, 3)},
#define SDR_MEAN_FORCE_ROW(law, code) SDR_MEAN_ROW(force, law, code)
#define SDR_MEAN_LOOSE_ROW(law, code) SDR_MEAN_ROW(loose, law, code)

const sdr_mean_kernels SDR_JOIN(sdr_mean_kernels_, SDR_ISA) = {
    .run_force = {SDR_LAWS(SDR_MEAN_FORCE_ROW)},
    .loose_force = {SDR_LAWS(SDR_MEAN_LOOSE_ROW)},
    .run_times = {times_1, times_2, times_3},
    .run_diagonal = {diagonal_1, diagonal_2, diagonal_3},
    .loose_times = {loose_times_1, loose_times_2, loose_times_3}};
