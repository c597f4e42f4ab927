/* A limited memory of how a gradient changes along steps (L-BFGS): of the last few steps s and
   changes of the gradient y with s.y > 0. With an approximation H of the inverse Hessian, given as
   a function, they make a better one, that answers y with s for the last pair:

     H' = (I - r s y^T) H (I - r y s^T) + r s s^T,   r = 1/(s.y),   pair after pair

   Positive definite if H is, so its directions descend. */
#ifndef SDR_TIME_SECANT_PAIRS_H
#define SDR_TIME_SECANT_PAIRS_H

#include "base/status.h"

#include <stdint.h>

typedef struct sdr_secant_pairs sdr_secant_pairs;

/* z = H r, positive definite; each of `count` values. */
typedef sdr_status (*sdr_secant_start)(void *context, const double *r, double *z);

/* For vectors of at most `room` values. Owner: the caller. */
sdr_status sdr_secant_pairs_create(int32_t room, sdr_secant_pairs **out);
void sdr_secant_pairs_destroy(sdr_secant_pairs **pairs); /* NULL-safe */

/* Forget all; vectors have `count` values from now on. */
void sdr_secant_pairs_clear(sdr_secant_pairs *pairs, int32_t count);
int sdr_secant_pairs_known(const sdr_secant_pairs *pairs); /* how many are kept */

/* The next point q and the gradient there; not the first since the last clearing: a pair. */
void sdr_secant_pairs_note(sdr_secant_pairs *pairs, const double *q, const double *gradient);

/* direction = -H' gradient */
sdr_status sdr_secant_pairs_descend(sdr_secant_pairs *pairs, const double *gradient,
                                    sdr_secant_start start, void *context, double *direction);

#endif
