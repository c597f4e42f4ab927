/* Generalised shape tensors (002 eq. 14-17; theory, "Nonlocal operators"):
       M_i = sum_j w(r/h_i) V_j p p^T,   p = all monomials r^a/h_i^|a|, r = X_j - X_i,
   kept as its inverse. */
#ifndef SDR_NOM_SHAPE_TENSOR_H
#define SDR_NOM_SHAPE_TENSOR_H

#include "nom/influence.h"
#include "nom/multi_index.h"
#include "nom/support.h"

typedef struct {
  int order; /* of the operators, 1..SDR_MOST_ORDER */
  sdr_influence influence;
  double most_condition; /* of a tensor that counts as regular; 0: 1e12, which costs at most six
                            digits of a derivative's sixteen */
  int enlarge;           /* 1: supports of singular tensors grow until regular; 0: they stop */
} sdr_shape_how;

typedef struct {
  const sdr_support *support; /* borrowed */
  sdr_influence influence;
  sdr_multi_indices set; /* the rows of p */
  double *root;          /* by point terms (terms + 1) / 2 values: upper triangle T by rows, with
                            M_i^-1 = T T^T */
  double *condition;     /* by point: 1-norm condition number of M_i */
  int32_t worst;         /* the point with the largest */
  int32_t enlarged;      /* supports that grew */
} sdr_shape_tensors;

/* The tensors of all points, threaded. With how->enlarge the support may change. SDR_BAD_INPUT
   names the first point whose tensor is singular (or would be with all points in its support).
   The support is borrowed for as long as the tensors live. Owner: the caller. */
sdr_status sdr_shape_tensors_create(sdr_support *support, const sdr_shape_how *how,
                                    sdr_shape_tensors *out);
void sdr_shape_tensors_destroy(sdr_shape_tensors *shape);

/* w(|r|/h_i) V_j and p of the k-th entry of the support's table, a neighbour of i; p holds
   set.count values, r (m) 3. */
double sdr_shape_entry(const sdr_shape_tensors *shape, int32_t i, int64_t k, double r[3],
                       double *p);

/* x = M_i^-1 g, set.count values each; x may be g. */
void sdr_shape_solve(const sdr_shape_tensors *shape, int32_t i, const double *g, double *x);

#endif
