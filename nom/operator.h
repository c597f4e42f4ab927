/* Nonlocal derivatives of every multi-index up to an order (002 eq. 14; theory, "Nonlocal
   operators"):
       D_a u(X_i) = a!/h_i^|a| [M_i^-1 sum_j w V_j p (u_j - u_i)]_a .
   Exact for polynomials up to the order on any points whose shape tensors are regular. */
#ifndef SDR_NOM_OPERATOR_H
#define SDR_NOM_OPERATOR_H

#include "linalg/csr.h"
#include "nom/shape_tensor.h"

/* ---- matrix-free: no weights are stored ---- */

/* All derivatives of u at point i: out holds set.count values. u: one value a point. */
void sdr_derivatives_at(const sdr_shape_tensors *shape, int32_t i, const double *u, double *out);

/* One derivative (an index into shape->set, or SDR_VALUE) at all points, threaded. out may not be
   u. */
void sdr_derivative(const sdr_shape_tensors *shape, int derivative, const double *u, double *out);

/* ---- row weights ---- */

typedef struct {
  const sdr_shape_tensors *shape; /* borrowed */
  int terms;                      /* shape->set.count */
  double
      *weight; /* D_a u(X_i) = sum_k weight[k terms + a] u[column[k]] + centre[i terms + a] u_i */
  double *centre; /* minus the row's sum */
} sdr_operator;

/* The weights of all derivatives, threaded. The shape tensors are borrowed for as long as the
   operator lives. Owner: the caller. */
sdr_status sdr_operator_create(const sdr_shape_tensors *shape, sdr_operator *out);
void sdr_operator_destroy(sdr_operator *op);

/* Index of a derivative by name ("xx", "xy"; "1": the field itself), as sdr_multi_index_find. */
sdr_status sdr_operator_find(const sdr_operator *op, const char *name, int *out);

/* One derivative at all points, or at one. */
void sdr_operator_apply(const sdr_operator *op, int derivative, const double *u, double *out);
double sdr_operator_at(const sdr_operator *op, int derivative, int32_t i, const double *u);

/* One derivative as a sparse matrix. Owner: the caller. */
sdr_status sdr_operator_matrix(const sdr_operator *op, int derivative, sdr_csr *out);

#endif
