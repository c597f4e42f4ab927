/* The same model written as plainly as can be: a directed table of neighbours, one bond after the
   other, square roots and divisions where the formulas have them, nothing stored that can be
   computed. What every faster form is compared with, in its time and in its answer. */
#ifndef SDR_BENCH_PLAIN_REFERENCE_H
#define SDR_BENCH_PLAIN_REFERENCE_H

#include "support/body.h"

typedef struct {
  int32_t count;
  int components;
  sdr_law law;
  int64_t *row; /* count + 1 */
  int32_t *column;
  double *x[3], *u[3], *v[3], *f[3], *volume, *mass, *stiffness, *threshold; /* a point */
  float *stretch;                                                            /* a directed bond */
  uint8_t *lost;     /* a directed bond: 1: i -> j, 2: j -> i */
  int32_t *original; /* of each point: the body's; NULL: the same */
} bench_plain;

/* The model and state of the body; shuffled: points stay in random order. Owner: the caller. */
sdr_status bench_plain_create(const bench_body *body, int shuffled, bench_plain *out);
void bench_plain_destroy(bench_plain *plain);

/* Force with the history taken in. */
void bench_plain_force(bench_plain *plain);

/* One step of leapfrog of length dt (s). */
void bench_plain_step(bench_plain *plain, double dt);

#endif
