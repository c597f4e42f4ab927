/* Runs of a body with histories in double take a step in. Few bonds reach a new largest stretch k:
   s > k where z = (1 + s)^2 - 1 > k (2 + k), which takes no root. */
#include "mechanics/bond_internal.h"

#include <math.h>

enum { BLOCK = 256 };
static const double slack = 1e-12; /* more than rounding: the stretch itself decides */

/* z of consecutive pairs, times |xi|^2. */
static void find_squares(const sdr_bond_class *class, int components, const sdr_bond_run *run,
                         int32_t start, int count, double *const u[3], double z[BLOCK])
{
  for (int k = 0; k < count; ++k) z[k] = 0.0;
  for (int a = 0; a < components; ++a) {
    const double *const ui = u[a] + run->i0 + start, *const uj = u[a] + run->j0 + start;
    const double twice = 2.0 * class->xi[a];
#pragma omp simd
    for (int k = 0; k < count; ++k) {
      const double eta = uj[k] - ui[k];
      z[k] += (twice + eta) * eta;
    }
  }
}

void sdr_bond_commit_run(const sdr_bond_body *body, const sdr_bond_run *run, double *const u[3])
{
  const sdr_bond_class *class = &body->bonds->classes[run->class_index];
  const double square = class->length * class->length, share = (1.0 + slack) / square;
  for (int32_t start = 0; start < run->length; start += BLOCK) {
    const int count = run->length - start < BLOCK ? run->length - start : BLOCK;
    double *const history = body->history + run->slot + start;
    double z[BLOCK];
    int any = 0;
    find_squares(class, body->points->components, run, start, count, u, z);
#pragma omp simd reduction(| : any)
    for (int k = 0; k < count; ++k) any |= z[k] * share > history[k] * (2.0 + history[k]);
    for (int k = 0; any && k < count; ++k) {
      if (!(z[k] * share > history[k] * (2.0 + history[k])) || history[k] < 0.0) continue;
      const double here = z[k] / square, s = here / (1.0 + sqrt(fmax(1.0 + here, 1e-200)));
      if (s > history[k]) history[k] = s;
    }
  }
}
