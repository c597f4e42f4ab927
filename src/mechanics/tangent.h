/* The tangent stiffness of a model as a sparse matrix. */
#ifndef SDR_MECHANICS_TANGENT_H
#define SDR_MECHANICS_TANGENT_H

#include "linalg/csr.h"
#include "mechanics/model.h"

/* The Hessian of the model's energy at u, summed up from its parts (visit_hessian), over all
   displacement components: unknown = point * components + component. Every point has its diagonal
   block, also one without bonds; blocks that happen to be zero are kept. Owner: the caller. */
sdr_status sdr_tangent_assemble(sdr_model *model, double *const u[3], sdr_csr *out);

/* The same for many states: what is joined to what, and where each part's values go, is found once.
   A part must join the same points, in the same order, at every visit of one kind; parts, and
   points of a part, may be left out (those that damage cut off). */
typedef struct sdr_tangent sdr_tangent;

typedef enum {
  SDR_TANGENT_EXACT,  /* visit_hessian */
  SDR_TANGENT_SECANT, /* visit_secant */
  SDR_TANGENT_MEAN    /* visit_mean_tangent */
} sdr_tangent_kind;

/* Owner: the caller. SDR_BAD_INPUT if the model has no such tangent. */
sdr_status sdr_tangent_create(sdr_model *model, sdr_tangent_kind kind, sdr_tangent **out);
void sdr_tangent_destroy(sdr_tangent **tangent); /* NULL-safe */

/* Values at u (mean: of the step from u0 to u; NULL otherwise). */
sdr_status sdr_tangent_update(sdr_tangent *tangent, double *const u0[3], double *const u[3]);

/* The matrix at the last update; its pattern never changes. Owned by the tangent. */
const sdr_csr *sdr_tangent_matrix(const sdr_tangent *tangent);

#endif
