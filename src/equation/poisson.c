/* Poisson's equation -k lap u = f; its energy is 1/2 k |grad u|^2 - f u. Conditions: the value, and
   the flux k du/dn into the body. */
#include "equation/problem.h"

enum { VALUE, FLUX };

static double conductivity(const sdr_problem *problem)
{
  return problem->equation->number[0];
}

static int fields(int components)
{
  (void)components;
  return 1;
}

static int inside(const sdr_problem *problem, int p, sdr_term *term)
{
  for (int a = 0; a < problem->components; ++a)
    term[a] = (sdr_term){problem->dd[a][a], p, -conductivity(problem)};
  return problem->components;
}

static int condition(const sdr_problem *problem, int which, int c, const double normal[3],
                     sdr_term *term, int *row)
{
  *row = c;
  term[0] = (sdr_term){SDR_VALUE, 0, 1.0};
  if (which == VALUE) return 1;
  for (int a = 0; a < problem->components; ++a)
    term[a] = (sdr_term){problem->d[a], 0, conductivity(problem) * normal[a]};
  return problem->components;
}

static int functional(const sdr_problem *problem, sdr_quadratic_term *term)
{
  for (int a = 0; a < problem->components; ++a)
    term[a] = (sdr_quadratic_term){problem->d[a], 0, problem->d[a], 0, conductivity(problem), NULL};
  return problem->components;
}

const sdr_equation_ops sdr_equation_poisson = {.fields = fields,
                                               .inside = inside,
                                               .condition = condition,
                                               .functional = functional,
                                               .stiffness = conductivity};
