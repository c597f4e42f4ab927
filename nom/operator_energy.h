/* Operator energy: what an operator of an order cannot see of a field, squared (hourglass control).
       E = sum_i V_i P_i/(2 m_i) sum_j w V_j (u_j - u_i - sum_a r^a/a! D_a u_i)^2,
       m_i = sum_j w V_j |r|^2 .
   It vanishes for polynomials up to the order and holds what the operators let pass, as the
   checkerboard. Its form is W - W p M^-1 p^T W, a projection, so no weights are needed (theory,
   "Nonlocal operators"). */
#ifndef SDR_NOM_OPERATOR_ENERGY_H
#define SDR_NOM_OPERATOR_ENERGY_H

#include "linalg/csr.h"
#include "nom/shape_tensor.h"

/* The energy of one scalar field. coefficient: P_i (unit of the functional's own coefficient), one
   value a point. */
double sdr_operator_energy(const sdr_shape_tensors *shape, const double *coefficient,
                           const double *u);

/* gradient[i] += dE/du_i. */
void sdr_operator_energy_gradient(const sdr_shape_tensors *shape, const double *coefficient,
                                  const double *u, double *gradient);

/* Add the second derivative of E, the same for each of `fields` components of a field, to the
   matrix; unknown p count + i is component p at point i, as in assembly.h. */
sdr_status sdr_operator_energy_add(const sdr_shape_tensors *shape, const double *coefficient,
                                   int fields, sdr_csr_builder *matrix);

#endif
