/* The instances of the passes of non-ordinary bodies, and their table. Compiled once for each
   instruction set; what the passes are made of is not inlined into each of them. */
#include "mechanics/nonordinary_find.h"
#include "mechanics/nonordinary_point.h"

#ifndef SDR_ISA
#define SDR_ISA baseline
#endif
#define SDR_JOIN_(a, b) a##b
#define SDR_JOIN(a, b) SDR_JOIN_(a, b)
#define SDR_TEXT_(a) #a
#define SDR_TEXT(a) SDR_TEXT_(a)

#define SDR_PART static __attribute__((noinline)) void

/* ---- parts ----------------------------------------------------------------------------------- */

#define SDR_GATHER(n, finite, sums)                                                                \
  SDR_PART gather_##n##finite##sums(const sdr_lanes_points *at, sdr_lanes_sums *out)               \
  {                                                                                                \
    gather(n, finite, sums, at, out);                                                              \
  }
/* With finite strain pass A gathers no sums. */
#define SDR_GATHER_SAME(n)                                                                         \
  static inline void gather_##n##11(const sdr_lanes_points *at, sdr_lanes_sums *out)               \
  {                                                                                                \
    gather_##n##10(at, out);                                                                       \
  }
#define SDR_CONTROL(n, sums)                                                                       \
  SDR_PART control_##n##sums(const sdr_lanes_points *at, const sdr_lanes *g, sdr_lanes_sums *out)  \
  {                                                                                                \
    control(n, sums, at, g, out);                                                                  \
  }
#define SDR_ONE_LAW(n, elasticity, split)                                                          \
  SDR_PART law_##n##_##elasticity##_##split(const sdr_nonordinary_body *body, int64_t i,           \
                                            const sdr_lanes *g, sdr_lanes_stress *out)             \
  {                                                                                                \
    law_of_lanes(n, elasticity, split, body, i, g, out);                                           \
  }
#define SDR_SPLITS_OF(n, elasticity)                                                               \
  SDR_ONE_LAW(n, elasticity, SDR_SPLIT_WHOLE)                                                      \
  SDR_ONE_LAW(n, elasticity, SDR_SPLIT_DILATATION)                                                 \
  SDR_ONE_LAW(n, elasticity, SDR_SPLIT_SPECTRAL)
#define SDR_SPREAD(n, finite)                                                                      \
  SDR_PART spread_##n##finite(const sdr_lanes_points *at, const sdr_bearing *bearing,              \
                              double *const f[3])                                                  \
  {                                                                                                \
    spread(n, finite, at, bearing, f);                                                             \
  }
#define SDR_PARTS(n)                                                                               \
  SDR_GATHER(n, 0, 0)                                                                              \
  SDR_GATHER(n, 0, 1)                                                                              \
  SDR_GATHER(n, 1, 0)                                                                              \
  SDR_GATHER_SAME(n)                                                                               \
  SDR_SPREAD(n, 0)                                                                                 \
  SDR_SPREAD(n, 1)                                                                                 \
  SDR_CONTROL(n, 0)                                                                                \
  SDR_CONTROL(n, 1)                                                                                \
  SDR_SPLITS_OF(n, SDR_LINEAR)                                                                     \
  SDR_SPLITS_OF(n, SDR_SAINT_VENANT_KIRCHHOFF)                                                     \
  SDR_SPLITS_OF(n, SDR_NEO_HOOKEAN)

SDR_PARTS(1)
SDR_PARTS(2)
SDR_PARTS(3)

#define SDR_ROW_OF_LAWS(n, elasticity)                                                             \
  [elasticity] = {[SDR_SPLIT_WHOLE] = law_##n##_##elasticity##_SDR_SPLIT_WHOLE,                    \
                  [SDR_SPLIT_DILATATION] = law_##n##_##elasticity##_SDR_SPLIT_DILATATION,          \
                  [SDR_SPLIT_SPECTRAL] = law_##n##_##elasticity##_SDR_SPLIT_SPECTRAL},
#define SDR_TABLE_OF_LAWS(n)                                                                       \
  {                                                                                                \
    SDR_ROW_OF_LAWS(n, SDR_LINEAR)                                                                 \
    SDR_ROW_OF_LAWS(n, SDR_SAINT_VENANT_KIRCHHOFF) SDR_ROW_OF_LAWS(n, SDR_NEO_HOOKEAN)             \
  }

/* [components - 1][elasticity][split] */
static const sdr_lanes_law laws[3][3][3] = {SDR_TABLE_OF_LAWS(1), SDR_TABLE_OF_LAWS(2),
                                            SDR_TABLE_OF_LAWS(3)};

/* ---- passes ---------------------------------------------------------------------------------- */

/* DO(at) for all lanes of blocks [first, end). */
#define SDR_ALL_BLOCKS(DO)                                                                         \
  for (int64_t i = SDR_LANES * first; i < SDR_LANES * end; i += SDR_WIDTH) {                       \
    const sdr_lanes_points at = {body, u, i, (int)(i % SDR_LANES)};                                \
    DO(&at)                                                                                        \
  }

#define SDR_STATE(n, finite, sums, task)                                                           \
  static void state_##n##finite##_##task(const sdr_nonordinary_body *body, int64_t first,          \
                                         int64_t end, double *const u[3], double *const f[3])      \
  {                                                                                                \
    const sdr_lanes_law law = laws[(n)-1][body->elasticity][body->split];                          \
    for (int64_t i = SDR_LANES * first; i < SDR_LANES * end; i += SDR_WIDTH) {                     \
      const sdr_lanes_points at = {body, u, i, (int)(i % SDR_LANES)};                              \
      state_of(n, finite, task, gather_##n##finite##sums, control_##n##sums, spread_##n##finite,   \
               law, f, &at);                                                                       \
    }                                                                                              \
  }
#define SDR_FORCE(n, finite)                                                                       \
  static void force_##n##finite(const sdr_nonordinary_body *body, int64_t first, int64_t end,      \
                                double *const u[3], double *const f[3])                            \
  {                                                                                                \
    for (int64_t i = SDR_LANES * first; i < SDR_LANES * end; i += SDR_WIDTH) {                     \
      const sdr_lanes_points at = {body, u, i, (int)(i % SDR_LANES)};                              \
      force_of_lanes(n, finite, &at, f);                                                           \
    }                                                                                              \
  }
#define SDR_PASSES(n)                                                                              \
  SDR_STATE(n, 0, 0, SDR_POINT_ELASTIC)                                                            \
  SDR_STATE(n, 0, 1, SDR_POINT_DAMAGED)                                                            \
  SDR_STATE(n, 0, 1, SDR_POINT_ENERGY)                                                             \
  SDR_STATE(n, 1, 0, SDR_POINT_ELASTIC)                                                            \
  SDR_STATE(n, 1, 1, SDR_POINT_DAMAGED)                                                            \
  SDR_STATE(n, 1, 1, SDR_POINT_ENERGY)                                                             \
  SDR_FORCE(n, 0)                                                                                  \
  SDR_FORCE(n, 1)                                                                                  \
  static void find_##n(const sdr_nonordinary_body *body, int64_t first, int64_t end,               \
                       double *const u[3], const double *limit, uint8_t *found)                    \
  {                                                                                                \
    find_runs(n, body, first, end, u, limit, found);                                               \
  }                                                                                                \
  static void find_loose_##n(const sdr_nonordinary_body *body, int64_t first, int64_t end,         \
                             double *const u[3], const double *limit, uint8_t *found)              \
  {                                                                                                \
    find_chunks(n, body, first, end, u, limit, found);                                             \
  }

SDR_PASSES(1)
SDR_PASSES(2)
SDR_PASSES(3)

/* In the order of sdr_point_task. */
#define SDR_TASKS(kind)                                                                            \
  {                                                                                                \
    kind##_SDR_POINT_ELASTIC, kind##_SDR_POINT_DAMAGED, kind##_SDR_POINT_ENERGY                    \
  }
#define SDR_STRAINS(n)                                                                             \
  {                                                                                                \
    SDR_TASKS(state_##n##0), SDR_TASKS(state_##n##1)                                               \
  }

const sdr_nonordinary_kernels SDR_JOIN(sdr_nonordinary_kernels_, SDR_ISA) = {
    .name = SDR_TEXT(SDR_ISA),
    .state = {SDR_STRAINS(1), SDR_STRAINS(2), SDR_STRAINS(3)},
    .force = {{force_10, force_11}, {force_20, force_21}, {force_30, force_31}},
    .find = {find_1, find_2, find_3},
    .find_loose = {find_loose_1, find_loose_2, find_loose_3}};
