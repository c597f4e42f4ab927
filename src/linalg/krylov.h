/* Iteration for A x = b with A as an operator, symmetric or not: BiCGStab, preconditioned from the
   right. */
#ifndef SDR_LINALG_KRYLOV_H
#define SDR_LINALG_KRYLOV_H

#include "base/status.h"

#include <stdint.h>

/* out = operator times x. */
typedef sdr_status (*sdr_krylov_operator)(void *context, const double *x, double *out);

typedef struct sdr_krylov sdr_krylov;

/* Room for vectors of `size` numbers. Owner: the caller. */
sdr_status sdr_krylov_create(int32_t size, sdr_krylov **out);
void sdr_krylov_destroy(sdr_krylov **krylov); /* NULL-safe */

typedef struct {
  sdr_krylov_operator times, precondition; /* precondition: roughly the inverse of A */
  void *context;                           /* of both */
  double tolerance;                        /* stop once |b - A x| <= tolerance |b| */
  int32_t most;                            /* iterations (two products each) */
} sdr_krylov_how;

/* Solve from x = 0. *reached: |b - A x|/|b|, above the tolerance if `most` iterations were not
   enough or the iteration broke down; x is then the best that was met. An operator that fails ends
   it with its status. *iterations: how many were made. */
sdr_status sdr_krylov_solve(sdr_krylov *krylov, const sdr_krylov_how *how, const double *b,
                            double *x, double *reached, int32_t *iterations);

#endif
