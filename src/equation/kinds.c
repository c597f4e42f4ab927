#include "equation/problem.h"

static const sdr_equation_ops *const kinds[] = {
    [SDR_POISSON] = &sdr_equation_poisson,
    [SDR_PLATE] = &sdr_equation_plate,
    [SDR_ELASTICITY] = &sdr_equation_elasticity,
    [SDR_GRADIENT_ELASTICITY] = &sdr_equation_gradient_elasticity,
};

const sdr_equation_ops *sdr_equation_ops_of(sdr_equation_kind kind)
{
  return kinds[kind];
}
