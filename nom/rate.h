/* Rate form (000 eq. 47-49): gradients by the present configuration, without a shape tensor:
       L_i = (sum_j w V_j (v_j - v_i) (x) xi) (sum_j w V_j (y_j - y_i) (x) xi)^-1,  xi = X_j - X_i.
   With v a velocity L is the velocity gradient; with v an increment of displacement and y the
   positions before it, I + L is the increment of the deformation gradient. */
#ifndef SDR_NOM_RATE_H
#define SDR_NOM_RATE_H

#include "nom/influence.h"
#include "nom/support.h"

/* L at all points: out holds 9 values a point, row-major, dv_a/dy_b at 3 a + b; what lies beyond
   the components is 0. y, v: `components` arrays of one value a point. SDR_RUN_FAILED names the
   first point whose present configuration has collapsed or whose support is too small; out then
   holds the others'. */
sdr_status sdr_rate_gradient(const sdr_support *support, sdr_influence influence,
                             const double *const y[3], const double *const v[3], double *out);

#endif
