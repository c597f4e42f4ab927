/* The instances of the bond loops, and their table. Compiled once for each instruction set. */
#include "mechanics/bond_loop.h"
#include "mechanics/bond_loose.h"

#ifndef SDR_ISA
#define SDR_ISA baseline
#endif
#define SDR_JOIN_(a, b) a##b
#define SDR_JOIN(a, b) SDR_JOIN_(a, b)
#define SDR_TEXT_(a) #a
#define SDR_TEXT(a) SDR_TEXT_(a)

/* One force instance: law, components, moduli a point. */
#define SDR_FORCE(law, code, n, each)                                                              \
  static void force_##law##_##n##each(const sdr_bond_body *body, int64_t first, int64_t end,       \
                                      double *const u[3], double *const f[3])                      \
  {                                                                                                \
    force_of_runs_double(n, code, each, body, first, end, u, f);                                   \
  }                                                                                                \
  static void loose_##law##_##n##each(const sdr_bond_body *body, int64_t first, int64_t end,       \
                                      double *const u[3], double *const f[3])                      \
  {                                                                                                \
    force_of_loose(n, code, each, body, first, end, u, f);                                         \
  }
#define SDR_MIXED(law, code, n, each)                                                              \
  static int32_t mixed_##law##_##n##each(const sdr_bond_body *body, int64_t first, int64_t end,    \
                                         double *const u[3], double *const f[3])                   \
  {                                                                                                \
    return force_of_runs_float(n, code, each, body, first, end, u, f);                             \
  }
#define SDR_ENERGIES(law, code, n, each)                                                           \
  static void energies_##law##_##n##each(const sdr_bond_body *body, int64_t first, int64_t end,    \
                                         double *const u[3], sdr_stripe_energies *sum)             \
  {                                                                                                \
    energies_of_runs(n, code, each, body, first, end, u, sum);                                     \
  }
#define SDR_DAMAGE(law, code, n, each)                                                             \
  static void damage_##law##_##n##each(const sdr_bond_body *body, int64_t first, int64_t end,      \
                                       double *const u[3], double *sum)                            \
  {                                                                                                \
    damage_of_runs(n, code, each, body, first, end, u, sum);                                       \
  }
#define SDR_APART(n)                                                                               \
  static int32_t apart_##n(const sdr_bond_body *body, int64_t first, int64_t end)                  \
  {                                                                                                \
    return apart_of_runs(n, body, first, end);                                                     \
  }
#define SDR_REFERENCE(n, each)                                                                     \
  static void reference_##n##each(const sdr_bond_body *body, int64_t first, int64_t end,           \
                                  double *const v[3], double *const f[3])                          \
  {                                                                                                \
    reference_of_runs(n, each, body, first, end, v, f);                                            \
  }
#define SDR_EACH_MODULI(law, code, n)                                                              \
  SDR_FORCE(law, code, n, 0)                                                                       \
  SDR_FORCE(law, code, n, 1)                                                                       \
  SDR_ENERGIES(law, code, n, 0)                                                                    \
  SDR_ENERGIES(law, code, n, 1)                                                                    \
  SDR_DAMAGE(law, code, n, 0)                                                                      \
  SDR_DAMAGE(law, code, n, 1)
#define SDR_EACH_DIMENSION(law, code)                                                              \
  SDR_EACH_MODULI(law, code, 1)                                                                    \
  SDR_EACH_MODULI(law, code, 2)                                                                    \
  SDR_EACH_MODULI(law, code, 3)

#define SDR_EACH_MIXED(law, code)                                                                  \
  SDR_MIXED(law, code, 1, 0)                                                                       \
  SDR_MIXED(law, code, 1, 1)                                                                       \
  SDR_MIXED(law, code, 2, 0)                                                                       \
  SDR_MIXED(law, code, 2, 1)                                                                       \
  SDR_MIXED(law, code, 3, 0)                                                                       \
  SDR_MIXED(law, code, 3, 1)

SDR_LAWS(SDR_EACH_DIMENSION)
SDR_MIXED_LAWS(SDR_EACH_MIXED)
SDR_APART(1)
SDR_APART(2)
SDR_APART(3)
SDR_REFERENCE(1, 0)
SDR_REFERENCE(1, 1)
SDR_REFERENCE(2, 0)
SDR_REFERENCE(2, 1)
SDR_REFERENCE(3, 0)
SDR_REFERENCE(3, 1)

#define SDR_ROW(kind, law, code)                                                                   \
  [code] = {{kind##_##law##_10, kind##_##law##_11},                                                \
            {kind##_##law##_20, kind##_##law##_21},                                                \
            {kind##_##law##_30, kind##_##law##_31}},
#define SDR_FORCE_ROW(law, code) SDR_ROW(force, law, code)
#define SDR_LOOSE_ROW(law, code) SDR_ROW(loose, law, code)
#define SDR_ENERGIES_ROW(law, code) SDR_ROW(energies, law, code)
#define SDR_MIXED_ROW(law, code) SDR_ROW(mixed, law, code)
#define SDR_DAMAGE_ROW(law, code) SDR_ROW(damage, law, code)

const sdr_bond_kernels SDR_JOIN(sdr_bond_kernels_, SDR_ISA) = {
    .name = SDR_TEXT(SDR_ISA),
    .run_force = {SDR_LAWS(SDR_FORCE_ROW)},
    .loose_force = {SDR_LAWS(SDR_LOOSE_ROW)},
    .run_energies = {SDR_LAWS(SDR_ENERGIES_ROW)},
    .mixed_run_force = {SDR_MIXED_LAWS(SDR_MIXED_ROW)},
    .run_damage = {SDR_LAWS(SDR_DAMAGE_ROW)},
    .run_apart = {apart_1, apart_2, apart_3},
    .run_reference = {
        {reference_10, reference_11}, {reference_20, reference_21}, {reference_30, reference_31}}};
