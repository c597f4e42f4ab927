/* Isotropic linear elasticity: the tensor C, shared by the equations that have one. */
#ifndef SDR_EQUATION_ELASTIC_H
#define SDR_EQUATION_ELASTIC_H

#include "equation/problem.h"

/* Lame's constants of the scene's state (`young` and `poisson` are the first two numbers); plane
   stress has its own lambda, in 1-D lambda + 2 mu is Young's modulus. */
typedef struct {
  double lambda, mu;
} sdr_lame;
sdr_lame sdr_lame_of(const sdr_problem *problem);

/* C_ijkl = lambda d_ij d_kl + mu (d_ik d_jl + d_il d_jk). */
static inline double sdr_elastic_tensor(sdr_lame lame, int i, int j, int k, int l)
{
  return lame.lambda * (i == j && k == l) + lame.mu * ((i == k && j == l) + (i == l && j == k));
}

int sdr_elastic_fields(int components);
double sdr_elastic_stiffness(const sdr_problem *problem); /* mu */
int sdr_elastic_condition(const sdr_problem *problem, int which, int c, const double normal[3],
                          sdr_term *term, int *row);
/* Terms of strain : C : strain. */
int sdr_elastic_functional(const sdr_problem *problem, sdr_quadratic_term *term);

#endif
