/* Gradient elasticity: beside the strain its gradient stores energy, over a length of the material,
       1/2 (e : C : e + length^2 grad e : C : grad e),   e = sym grad u.
   Written down as it stands: the first part is that of linear elasticity, the second the same with
   one derivative more. Edges without a condition are free of double tractions. */
#include "equation/elastic.h"

static int functional(const sdr_problem *problem, sdr_quadratic_term *term)
{
  const sdr_lame lame = sdr_lame_of(problem);
  const double length = problem->equation->number[2];
  const int n = problem->components;
  int count = sdr_elastic_functional(problem, term);
  for (int ij = 0; ij < n * n; ++ij)
    for (int kl = 0; kl < n * n; ++kl) {
      const int i = ij / n, j = ij % n, k = kl / n, l = kl % n;
      const double c = length * length * sdr_elastic_tensor(lame, i, j, k, l);
      for (int m = 0; m < n && c != 0.0; ++m)
        term[count++] = (sdr_quadratic_term){problem->dd[j][m], i, problem->dd[l][m], k, c, NULL};
    }
  return count;
}

const sdr_equation_ops sdr_equation_gradient_elasticity = {.fields = sdr_elastic_fields,
                                                           .condition = sdr_elastic_condition,
                                                           .functional = functional,
                                                           .stiffness = sdr_elastic_stiffness};
