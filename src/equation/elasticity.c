/* Linear elasticity: -div stress = source, stress = C : grad u. Conditions: displacement, and
   traction stress.n. */
#include "equation/elastic.h"

#include <math.h>

enum { HELD, PULLED };

sdr_lame sdr_lame_of(const sdr_problem *problem)
{
  const double young = problem->equation->number[0], nu = problem->equation->number[1];
  if (problem->components == 1) return (sdr_lame){0.0, 0.5 * young};
  const int is_stress = problem->scene->dimension == SDR_PLANE_STRESS;
  return (sdr_lame){young * nu / ((1.0 + nu) * (is_stress ? 1.0 - nu : 1.0 - 2.0 * nu)),
                    0.5 * young / (1.0 + nu)};
}

int sdr_elastic_fields(int components)
{
  return components;
}

double sdr_elastic_stiffness(const sdr_problem *problem)
{
  return sdr_lame_of(problem).mu;
}

static int inside(const sdr_problem *problem, int i, sdr_term *term)
{
  const sdr_lame lame = sdr_lame_of(problem);
  int count = 0;
  for (int j = 0; j < problem->components; ++j)
    for (int k = 0; k < problem->components; ++k)
      for (int l = 0; l < problem->components; ++l) {
        const double c = sdr_elastic_tensor(lame, i, j, k, l);
        if (c != 0.0) term[count++] = (sdr_term){problem->dd[l][j], k, -c};
      }
  return count;
}

int sdr_elastic_condition(const sdr_problem *problem, int which, int i, const double normal[3],
                          sdr_term *term, int *row)
{
  const sdr_lame lame = sdr_lame_of(problem);
  int count = 0;
  *row = i;
  term[0] = (sdr_term){SDR_VALUE, i, 1.0};
  if (which == HELD) return 1;
  for (int j = 0; j < problem->components; ++j)
    for (int k = 0; k < problem->components; ++k)
      for (int l = 0; l < problem->components; ++l) {
        const double c = normal[j] * sdr_elastic_tensor(lame, i, j, k, l);
        if (c != 0.0) term[count++] = (sdr_term){problem->d[l], k, c};
      }
  return count;
}

int sdr_elastic_functional(const sdr_problem *problem, sdr_quadratic_term *term)
{
  const sdr_lame lame = sdr_lame_of(problem);
  const int n = problem->components;
  int count = 0;
  for (int ij = 0; ij < n * n; ++ij)
    for (int kl = 0; kl < n * n; ++kl) {
      const int i = ij / n, j = ij % n, k = kl / n, l = kl % n;
      const double c = sdr_elastic_tensor(lame, i, j, k, l);
      if (c != 0.0)
        term[count++] = (sdr_quadratic_term){problem->d[j], i, problem->d[l], k, c, NULL};
    }
  return count;
}

static void stress(const sdr_problem *problem, double gradient[3][3], double *out)
{
  static const int first[6] = {0, 1, 2, 1, 0, 0}, second[6] = {0, 1, 2, 2, 2, 1};
  static const int plane[3] = {0, 1, 5};
  const sdr_lame lame = sdr_lame_of(problem);
  const int n = problem->components, width = n * (n + 1) / 2;
  for (int s = 0; s < width; ++s) {
    const int at = n == 2 ? plane[s] : s;
    out[s] = 0.0;
    for (int k = 0; k < n; ++k)
      for (int l = 0; l < n; ++l)
        out[s] += sdr_elastic_tensor(lame, first[at], second[at], k, l) * gradient[k][l];
  }
}

const sdr_equation_ops sdr_equation_elasticity = {.fields = sdr_elastic_fields,
                                                  .inside = inside,
                                                  .condition = sdr_elastic_condition,
                                                  .functional = sdr_elastic_functional,
                                                  .stiffness = sdr_elastic_stiffness,
                                                  .stress = stress};
