/* The energy that statics minimises over the free components q (theory sec. 7), u = a + B q:

     Pi(q) = E(u) - f.u + 1/2 sum over unknowns of pull (u - target)^2,   g = dPi/dq = P^T (...)

   E: what the body stores and has dissipated, its damage the larger of the committed one and that
   of u; f: loads. The springs are those of motion (static_motion.c). The matrix of g is the exact
   tangent; what preconditions it is a factor of the secant stiffness, which may be stale. */
#ifndef SDR_TIME_EQUILIBRIUM_H
#define SDR_TIME_EQUILIBRIUM_H

#include "linalg/solver.h"
#include "mechanics/reduction.h"
#include "mechanics/tangent.h"
#include "time/mean_border.h"

typedef struct {
  sdr_implicit *implicit;        /* borrowed */
  sdr_tangent *tangent, *secant; /* secant NULL: the model has none */
  const sdr_csr *matrix;         /* of the products: what was assembled last */
  sdr_mean_border *border;       /* means stay out of what is factored */
  sdr_reduction *reduction;
  sdr_solver *solver;
  int careful;  /* 1: only steps that follow the tangent are taken, to the minimum close by */
  int factored; /* 1: the solver has a factor for the present free components */
  const double *pull, *target; /* an unknown: N/m, m; NULL: none */
  double largest;              /* of `scale` so far, N */
  double scale;         /* of forces at the last look: sqrt of sum of loads and reactions squared */
  double stiffest;      /* entry on the diagonal of a stiffness so far, N/m */
  double rounding;      /* of the last residual, N: nothing below it means anything */
  double *internal;     /* an unknown: the model's force at the last look, N */
  double *wide, *wider; /* an unknown each: scratch */
  double *still[3];     /* zeros, as the model takes them */
} sdr_equilibrium;

/* `solver`: of linear equations, by name. Owner: the caller. */
sdr_status sdr_equilibrium_create(sdr_implicit *implicit, const char *solver,
                                  sdr_equilibrium **out);
void sdr_equilibrium_destroy(sdr_equilibrium **equilibrium); /* NULL-safe */

/* Other components are free than before: factors are of no use. */
void sdr_equilibrium_renumber(sdr_equilibrium *equilibrium);

/* Pi at u (m, over unknowns), J, and the size of its terms, by which rounding goes. */
double sdr_equilibrium_energy(sdr_equilibrium *e, const double *u, double *size);

/* g at u into gradient (N, over q); its norm. Also e->internal and e->scale. */
double sdr_equilibrium_gradient(sdr_equilibrium *e, const double *u, double *gradient);

/* The norm of g that counts as equilibrium: 1e-6 of the forces that act from outside (at least 1e-4
   of the largest there were), or rounding. */
double sdr_equilibrium_tolerance(const sdr_equilibrium *e);

/* Assemble the exact tangent, or the secant stiffness (the tangent where there is none), at u. */
sdr_status sdr_equilibrium_linearise(sdr_equilibrium *e, const double *u, int secant);

/* out = P^T (K + pull) B p over q, for the matrix assembled last. */
void sdr_equilibrium_times(sdr_equilibrium *e, const double *p, double *out);

/* Factor the secant stiffness at u: what preconditions from now on. Where the model has none, or it
   is not positive definite, the stiffness of the body at rest. Replaces the assembled matrix. */
sdr_status sdr_equilibrium_factor(sdr_equilibrium *e, const double *u);
sdr_status sdr_equilibrium_precondition(sdr_equilibrium *e, const double *r, double *z);

/* A dot product over q. */
double sdr_equilibrium_dot(const sdr_equilibrium *e, const double *x, const double *y);

#endif
