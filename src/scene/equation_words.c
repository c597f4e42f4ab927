#include "scene/equation.h"

#include <math.h>
#include <stddef.h>

#define PLAIN                                                                                      \
  {                                                                                                \
    0, 0, 0, 0                                                                                     \
  }
#define METRE                                                                                      \
  {                                                                                                \
    1, 0, 0, 0                                                                                     \
  }
#define PASCAL                                                                                     \
  {                                                                                                \
    -1, 1, -2, 0                                                                                   \
  }

#define YOUNG                                                                                      \
  {                                                                                                \
    "young", PASCAL, 0, INFINITY, 1, NULL, 1                                                       \
  }
#define POISSON                                                                                    \
  {                                                                                                \
    "poisson", PLAIN, -1, 0.5, 1, NULL, 2                                                          \
  }
#define DISPLACEMENT                                                                               \
  {                                                                                                \
    "displacement", METRE, 1, 0                                                                    \
  }
#define TRACTION                                                                                   \
  {                                                                                                \
    "traction", PASCAL, 0, 1                                                                       \
  }

const sdr_equation_words sdr_equations[] = {
    [SDR_POISSON] = {.word = "poisson",
                     .formula = "-k lap u = source",
                     .solution = "value",
                     .symbol = "1",
                     .least_order = {2, 1},
                     .number = {{"conductivity", PLAIN, 0, INFINITY, 1, "1", 1}},
                     .condition = {{"value", PLAIN, 1, 0}, {"flux", PLAIN, 0, 1}}},
    [SDR_PLATE] = {.word = "plate",
                   .formula = "-lap m = source, -D lap w = m",
                   .solution = "deflection",
                   .unit = METRE,
                   .symbol = "m",
                   .in_plane = 1,
                   .least_order = {2, 0},
                   .source_unit = PASCAL,
                   .number = {{"rigidity", {2, 1, -2, 0}, 0, INFINITY, 1, NULL, 1}},
                   .condition = {{"deflection", METRE, 1, 0}, {"moment", {1, 1, -2, 0}, 0, 0}}},
    [SDR_ELASTICITY] = {.word = "elasticity",
                        .formula = "-div stress = source, stress = C : strain",
                        .solution = "displacement",
                        .unit = METRE,
                        .symbol = "m",
                        .is_vector = 1,
                        .has_stress = 1,
                        .least_order = {2, 1},
                        .source_unit = {-2, 1, -2, 0},
                        .number = {YOUNG, POISSON},
                        .condition = {DISPLACEMENT, TRACTION}},
    [SDR_GRADIENT_ELASTICITY] = {.word = "gradient_elasticity",
                                 .formula =
                                     "energy 1/2 (strain : C : strain + length^2 grad strain "
                                     ": C : grad strain)",
                                 .solution = "displacement",
                                 .unit = METRE,
                                 .symbol = "m",
                                 .is_vector = 1,
                                 .least_order = {0, 2},
                                 .source_unit = {-2, 1, -2, 0},
                                 .number = {YOUNG,
                                            POISSON,
                                            {"length", METRE, 0, INFINITY, 0, NULL, 1}},
                                 .condition = {DISPLACEMENT, TRACTION}},
    {.word = NULL}};
