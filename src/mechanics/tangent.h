/* The tangent stiffness of a model as a sparse matrix. */
#ifndef SDR_MECHANICS_TANGENT_H
#define SDR_MECHANICS_TANGENT_H

#include "linalg/csr.h"
#include "mechanics/model.h"

/* The Hessian of the model's energy at u, summed up from its parts (visit_hessian), over all
   displacement components: unknown = point * components + component. Every point has its diagonal
   block, also one without bonds; blocks that happen to be zero are kept. Owner: the caller. */
sdr_status sdr_tangent_assemble(sdr_model *model, double *const u[3], sdr_csr *out);

#endif
