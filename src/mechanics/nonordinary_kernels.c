/* The instances of the passes of non-ordinary bodies, and their table. Compiled once for each
   instruction set. */
#include "mechanics/nonordinary_loose.h"
#include "mechanics/nonordinary_point.h"

#ifndef SDR_ISA
#define SDR_ISA baseline
#endif
#define SDR_JOIN_(a, b) a##b
#define SDR_JOIN(a, b) SDR_JOIN_(a, b)
#define SDR_TEXT_(a) #a
#define SDR_TEXT(a) SDR_TEXT_(a)

#define SDR_PASS_ARGUMENTS                                                                         \
  const sdr_nonordinary_body *body, int64_t first, int64_t end, double *const u[3],                \
      double *const f[3]

#define SDR_GATHER(n, finite, sums)                                                                \
  static void gather_##n##finite##sums(SDR_PASS_ARGUMENTS)                                         \
  {                                                                                                \
    (void)f;                                                                                       \
    gather_runs(n, finite, sums, body, first, end, u);                                             \
  }                                                                                                \
  static void gather_loose_##n##finite##sums(SDR_PASS_ARGUMENTS)                                   \
  {                                                                                                \
    (void)f;                                                                                       \
    gather_chunks(n, finite, sums, body, first, end, u);                                           \
  }
#define SDR_FORCE(n, finite)                                                                       \
  static void force_##n##finite(SDR_PASS_ARGUMENTS)                                                \
  {                                                                                                \
    force_runs(n, finite, body, first, end, u, f);                                                 \
  }                                                                                                \
  static void force_loose_##n##finite(SDR_PASS_ARGUMENTS)                                          \
  {                                                                                                \
    force_chunks(n, finite, body, first, end, u, f);                                               \
  }
#define SDR_POINT(n, elasticity, split, task)                                                      \
  static void point_##n##_##elasticity##_##split##_##task(const sdr_nonordinary_body *body,        \
                                                          int32_t first, int32_t end)              \
  {                                                                                                \
    points_of(n, elasticity, split, task, body, first, end);                                       \
  }
#define SDR_POINTS(n, elasticity)                                                                  \
  SDR_POINT(n, elasticity, SDR_SPLIT_WHOLE, SDR_POINT_ELASTIC)                                     \
  SDR_POINT(n, elasticity, SDR_SPLIT_WHOLE, SDR_POINT_ENERGY)                                      \
  SDR_POINT(n, elasticity, SDR_SPLIT_DILATATION, SDR_POINT_DAMAGED)                                \
  SDR_POINT(n, elasticity, SDR_SPLIT_DILATATION, SDR_POINT_ENERGY)                                 \
  SDR_POINT(n, elasticity, SDR_SPLIT_SPECTRAL, SDR_POINT_DAMAGED)                                  \
  SDR_POINT(n, elasticity, SDR_SPLIT_SPECTRAL, SDR_POINT_ENERGY)
#define SDR_ALL(n)                                                                                 \
  SDR_GATHER(n, 0, 0)                                                                              \
  SDR_GATHER(n, 0, 1)                                                                              \
  SDR_GATHER(n, 1, 0)                                                                              \
  SDR_FORCE(n, 0)                                                                                  \
  SDR_FORCE(n, 1)                                                                                  \
  SDR_POINTS(n, SDR_LINEAR)                                                                        \
  SDR_POINTS(n, SDR_SAINT_VENANT_KIRCHHOFF)                                                        \
  SDR_POINTS(n, SDR_NEO_HOOKEAN)                                                                   \
  static void gradients_##n(const sdr_nonordinary_body *body, int32_t first, int32_t end)          \
  {                                                                                                \
    gradients_of(n, body, first, end);                                                             \
  }                                                                                                \
  static void control_##n(SDR_PASS_ARGUMENTS)                                                      \
  {                                                                                                \
    (void)f;                                                                                       \
    control_runs(n, body, first, end, u);                                                          \
  }                                                                                                \
  static void control_loose_##n(SDR_PASS_ARGUMENTS)                                                \
  {                                                                                                \
    (void)f;                                                                                       \
    control_chunks(n, body, first, end, u);                                                        \
  }                                                                                                \
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

SDR_ALL(1)
SDR_ALL(2)
SDR_ALL(3)

#define SDR_GATHER_ROW(kind, n)                                                                    \
  {                                                                                                \
    {kind##_##n##00, kind##_##n##01},                                                              \
    {                                                                                              \
      kind##_##n##10, kind##_##n##10                                                               \
    }                                                                                              \
  }
#define SDR_TASKS(n, elasticity)                                                                   \
  [elasticity] = {                                                                                 \
      [SDR_SPLIT_WHOLE] = {[SDR_POINT_ELASTIC] =                                                   \
                               point_##n##_##elasticity##_SDR_SPLIT_WHOLE_SDR_POINT_ELASTIC,       \
                           [SDR_POINT_ENERGY] =                                                    \
                               point_##n##_##elasticity##_SDR_SPLIT_WHOLE_SDR_POINT_ENERGY},       \
      [SDR_SPLIT_DILATATION] =                                                                     \
          {[SDR_POINT_DAMAGED] =                                                                   \
               point_##n##_##elasticity##_SDR_SPLIT_DILATATION_SDR_POINT_DAMAGED,                  \
           [SDR_POINT_ENERGY] = point_##n##_##elasticity##_SDR_SPLIT_DILATATION_SDR_POINT_ENERGY}, \
      [SDR_SPLIT_SPECTRAL] = {                                                                     \
          [SDR_POINT_DAMAGED] = point_##n##_##elasticity##_SDR_SPLIT_SPECTRAL_SDR_POINT_DAMAGED,   \
          [SDR_POINT_ENERGY] = point_##n##_##elasticity##_SDR_SPLIT_SPECTRAL_SDR_POINT_ENERGY}},
#define SDR_ALL_TASKS(n)                                                                           \
  {                                                                                                \
    SDR_TASKS(n, SDR_LINEAR)                                                                       \
    SDR_TASKS(n, SDR_SAINT_VENANT_KIRCHHOFF) SDR_TASKS(n, SDR_NEO_HOOKEAN)                         \
  }

const sdr_nonordinary_kernels SDR_JOIN(sdr_nonordinary_kernels_, SDR_ISA) = {
    .name = SDR_TEXT(SDR_ISA),
    .gather = {SDR_GATHER_ROW(gather, 1), SDR_GATHER_ROW(gather, 2), SDR_GATHER_ROW(gather, 3)},
    .gather_loose = {SDR_GATHER_ROW(gather_loose, 1), SDR_GATHER_ROW(gather_loose, 2),
                     SDR_GATHER_ROW(gather_loose, 3)},
    .gradients = {gradients_1, gradients_2, gradients_3},
    .control = {control_1, control_2, control_3},
    .control_loose = {control_loose_1, control_loose_2, control_loose_3},
    .point = {SDR_ALL_TASKS(1), SDR_ALL_TASKS(2), SDR_ALL_TASKS(3)},
    .force = {{force_10, force_11}, {force_20, force_21}, {force_30, force_31}},
    .force_loose = {{force_loose_10, force_loose_11},
                    {force_loose_20, force_loose_21},
                    {force_loose_30, force_loose_31}},
    .find = {find_1, find_2, find_3},
    .find_loose = {find_loose_1, find_loose_2, find_loose_3}};
