/* A thin plate in bending, D lap lap w = q, as two equations of second order for the deflection w
   and the moment sum m = -D lap w (m_x + m_y over 1 + nu): -lap m = q. On a straight simply
   supported edge both are 0, whatever Poisson's ratio is. */
#include "equation/problem.h"

enum { DEFLECTION, MOMENT };

static int fields(int components)
{
  (void)components;
  return 2;
}

static int inside(const sdr_problem *problem, int p, sdr_term *term)
{
  const double factor = p == DEFLECTION ? problem->equation->number[0] : -1.0;
  for (int a = 0; a < 2; ++a) term[a] = (sdr_term){problem->dd[a][a], p, factor};
  term[2] = (sdr_term){SDR_VALUE, MOMENT, 1.0};
  return p == DEFLECTION ? 3 : 2;
}

static int condition(const sdr_problem *problem, int which, int c, const double normal[3],
                     sdr_term *term, int *row)
{
  (void)problem;
  (void)c;
  (void)normal;
  *row = which;
  term[0] = (sdr_term){SDR_VALUE, which, 1.0};
  return 1;
}

const sdr_equation_ops sdr_equation_plate = {
    .fields = fields, .source_row = MOMENT, .inside = inside, .condition = condition};
