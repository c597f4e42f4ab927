/* The matrix P^T K B over free components (mechanics/constraints.h), again and again for one K
   whose values change. */
#ifndef SDR_MECHANICS_REDUCTION_H
#define SDR_MECHANICS_REDUCTION_H

#include "mechanics/constraints.h"

typedef struct sdr_reduction sdr_reduction;

/* `k` is borrowed: its values may change, its pattern may not. Owner: the caller. */
sdr_status sdr_reduction_create(const sdr_csr *k, sdr_reduction **out);
void sdr_reduction_destroy(sdr_reduction **reduction); /* NULL-safe */

/* P^T K B for the present values of K. Where B only selects (no slaved components) this copies
   them; else it is sdr_constraints_reduce. *renewed = 1 if the pattern of the result is another
   than before, so that solvers must analyse it anew (sdr_solver_factor, else sdr_solver_refactor).
 */
sdr_status sdr_reduction_update(sdr_reduction *reduction, const sdr_constraints *constraints,
                                int *renewed);

/* Add P^T D B to it for a diagonal D (a value for each unknown); where B does not only select, its
   diagonal alone: good enough for a preconditioner. */
void sdr_reduction_add_diagonal(sdr_reduction *reduction, const sdr_constraints *constraints,
                                const double *diagonal);

/* What the last update made; owned by the reduction. */
const sdr_csr *sdr_reduction_matrix(const sdr_reduction *reduction);

#endif
