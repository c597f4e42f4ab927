/* What the machine itself allows: memory bandwidth, and the kernels' loads and stores without
   their arithmetic. */
#ifndef SDR_BENCH_FLOOR_H
#define SDR_BENCH_FLOOR_H

#include "support/body.h"

/* Bytes per second of a(i) = b(i) + s c(i) on arrays beyond all caches, counted as 24 an element,
   on the threads set; the best of several. Negative: out of memory. */
double bench_triad(void);

/* One step of the body's runs with all loads and stores of the real one and no other arithmetic
   than the sums that keep the compiler from dropping them. Spoils forces, nothing else. */
void bench_floor_step(bench_body *body);

#endif
