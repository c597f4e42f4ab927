/* The instances of the loops of ordinary bodies, and their table. Compiled once for each
   instruction set. */
#include "mechanics/ordinary_loop.h"
#include "mechanics/ordinary_loose.h"

#ifndef SDR_ISA
#define SDR_ISA baseline
#endif
#define SDR_JOIN_(a, b) a##b
#define SDR_JOIN(a, b) SDR_JOIN_(a, b)
#define SDR_TEXT_(a) #a
#define SDR_TEXT(a) SDR_TEXT_(a)

/* Sums: components, squares, use of flags, linear. */
#define SDR_SUMS(n, squares, use, linear)                                                          \
  static void run_sums_##n##squares##use##linear(sdr_ordinary *o, int64_t first, int64_t end,      \
                                                 double *const u[3])                               \
  {                                                                                                \
    sums_of_runs(n, squares, use, linear, o, first, end, u);                                       \
  }                                                                                                \
  static void loose_sums_##n##squares##use##linear(sdr_ordinary *o, int64_t first, int64_t end,    \
                                                   double *const u[3])                             \
  {                                                                                                \
    if (o->body.loose_flags && (use) && o->one_threshold)                                          \
      sums_of_loose(n, squares, use, SDR_LOOSE_SHARED, linear, o, first, end, u);                  \
    else if (o->body.loose_flags)                                                                  \
      sums_of_loose(n, squares, use, SDR_LOOSE_FLAGGED, linear, o, first, end, u);                 \
    else                                                                                           \
      sums_of_loose(n, squares, 0, SDR_LOOSE_UNFLAGGED, linear, o, first, end, u);                 \
  }
#define SDR_FORCE(n, linear)                                                                       \
  static void run_force_##n##linear(const sdr_ordinary *o, int64_t first, int64_t end,             \
                                    double *const u[3], double *const f[3])                        \
  {                                                                                                \
    force_of_runs(n, linear, o, first, end, u, f);                                                 \
  }                                                                                                \
  static void loose_force_##n##linear(const sdr_ordinary *o, int64_t first, int64_t end,           \
                                      double *const u[3], double *const f[3])                      \
  {                                                                                                \
    if (o->body.loose_flags)                                                                       \
      force_of_loose(n, SDR_LOOSE_FLAGGED, linear, o, first, end, u, f);                           \
    else                                                                                           \
      force_of_loose(n, SDR_LOOSE_UNFLAGGED, linear, o, first, end, u, f);                         \
  }
#define SDR_EACH(n)                                                                                \
  SDR_SUMS(n, 0, 0, 0)                                                                             \
  SDR_SUMS(n, 0, 1, 0)                                                                             \
  SDR_SUMS(n, 1, 0, 0)                                                                             \
  SDR_SUMS(n, 0, 0, 1)                                                                             \
  SDR_FORCE(n, 0)                                                                                  \
  SDR_FORCE(n, 1)
SDR_EACH(1)
SDR_EACH(2)
SDR_EACH(3)

#define SDR_POINTS(law, code)                                                                      \
  static void points_##law(sdr_ordinary *o, int64_t first, int64_t end, int commit)                \
  {                                                                                                \
    if (commit)                                                                                    \
      coefficients_of_points(code, 1, o, first, end);                                              \
    else                                                                                           \
      coefficients_of_points(code, 0, o, first, end);                                              \
  }
SDR_STATE_LAWS(SDR_POINTS)

#define SDR_POINTS_ROW(law, code) [code] = points_##law,
#define SDR_USES(kind, n)                                                                          \
  {                                                                                                \
    kind##_sums_##n##000, kind##_sums_##n##010                                                     \
  }

const sdr_ordinary_kernels SDR_JOIN(sdr_ordinary_kernels_, SDR_ISA) = {
    .name = SDR_TEXT(SDR_ISA),
    .run_sums = {SDR_USES(run, 1), SDR_USES(run, 2), SDR_USES(run, 3)},
    .loose_sums = {SDR_USES(loose, 1), SDR_USES(loose, 2), SDR_USES(loose, 3)},
    .run_squares = {run_sums_1100, run_sums_2100, run_sums_3100},
    .loose_squares = {loose_sums_1100, loose_sums_2100, loose_sums_3100},
    .run_force = {run_force_10, run_force_20, run_force_30},
    .loose_force = {loose_force_10, loose_force_20, loose_force_30},
    .points = {SDR_STATE_LAWS(SDR_POINTS_ROW)},
    .run_linear_sums = {run_sums_1001, run_sums_2001, run_sums_3001},
    .loose_linear_sums = {loose_sums_1001, loose_sums_2001, loose_sums_3001},
    .run_linear_force = {run_force_11, run_force_21, run_force_31},
    .loose_linear_force = {loose_force_11, loose_force_21, loose_force_31}};
