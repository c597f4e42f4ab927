/* Products with the tangent of a state without a matrix, over components of points that are free:
   models that keep what they need do them faster than a matrix would be read. */
#ifndef SDR_TIME_KEPT_TANGENT_H
#define SDR_TIME_KEPT_TANGENT_H

#include "mechanics/constraints.h"
#include "mechanics/model.h"

typedef struct sdr_kept_tangent sdr_kept_tangent;

/* 1 if the model can, and the constraints only select (no slaves). */
int sdr_kept_tangent_fits(const sdr_model *model, const sdr_constraints *constraints);

/* Borrows the model. Owner: the caller. */
sdr_status sdr_kept_tangent_create(sdr_model *model, sdr_kept_tangent **out);
void sdr_kept_tangent_destroy(sdr_kept_tangent **kept); /* NULL-safe */

/* Take the tangent at u; borrows the constraints until the next call. */
sdr_status sdr_kept_tangent_take(sdr_kept_tangent *kept, const sdr_constraints *constraints,
                                 double *const u[3]);

/* y = (D + P^T K B) x over the free components, for a diagonal D. */
void sdr_kept_tangent_times(sdr_kept_tangent *kept, const double *d, const double *x, double *y);

/* out = P^T K z, for z over all components. */
void sdr_kept_tangent_pull(sdr_kept_tangent *kept, const double *z, double *out);

/* Entry of free components k and l of one point. */
double sdr_kept_tangent_entry(const sdr_kept_tangent *kept, int32_t k, int32_t l);

#endif
