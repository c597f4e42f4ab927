/* Truncated Newton with preconditioned conjugate gradients on the energy of equilibrium.h. */
#ifndef SDR_TIME_NEWTON_PCG_H
#define SDR_TIME_NEWTON_PCG_H

#include "time/equilibrium.h"

typedef struct sdr_newton sdr_newton;

typedef struct {
  int converged;   /* 1: the residual is within sdr_equilibrium_tolerance */
  int steps;       /* Newton iterations */
  int curved;      /* of them with negative curvature */
  int descents;    /* of them by pairs (secant_pairs.h): the answer may be farther than need be */
  double residual; /* N */
} sdr_newton_report;

/* Borrows e. Owner: the caller. */
sdr_status sdr_newton_create(sdr_equilibrium *e, sdr_newton **out);
void sdr_newton_destroy(sdr_newton **newton); /* NULL-safe */

/* A first iterate u for the constraints and loads of now, from the equilibrium `before` of others:
   the linear answer of the secant stiffness there to what has changed. Both over unknowns. */
sdr_status sdr_newton_predict(sdr_newton *newton, const double *before, double *u);

/* From u, whose held components are where they must be, to a minimum of the energy nearby. u keeps
   the best state where that fails. An error is one of memory or of the linear solver. */
sdr_status sdr_newton_solve(sdr_newton *newton, double *u, sdr_newton_report *report);

#endif
