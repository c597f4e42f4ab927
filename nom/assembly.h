/* Sparse systems from operators: quadratic functionals (symmetric) and collocation (general).
   A field of m components on `count` points has the unknowns p count + i: component p at point i,
   so that u + p count is a scalar field. */
#ifndef SDR_NOM_ASSEMBLY_H
#define SDR_NOM_ASSEMBLY_H

#include "linalg/csr.h"
#include "nom/operator.h"

/* ---- quadratic functionals ---- */

/* 1/2 integral of c D_a u_p D_b u_q dV; a, b may be SDR_VALUE. Terms with a, p and b, q exchanged
   are the same term: give it once with twice the coefficient, or both. */
typedef struct {
  int a, p; /* derivative and component of the first factor */
  int b, q; /* and of the second */
  double coefficient;
  const double *by_point; /* multiplies the coefficient, one value a point; NULL: 1 */
} sdr_quadratic_term;

typedef struct {
  int fields; /* components of u, 1.. */
  int count;
  const sdr_quadratic_term *term;
} sdr_functional;

/* Add the second derivative K of the functional, so that it equals 1/2 u^T K u, to a builder of
   fields count rows and columns. */
sdr_status sdr_functional_add(const sdr_operator *op, const sdr_functional *functional,
                              sdr_csr_builder *matrix);

/* Prescribe unknowns of a symmetric system K u = f: rows and columns of those with fixed[k] != 0
   become those of the identity times a typical diagonal entry, and f follows, so that
   u[k] = value[k] and K stays symmetric. fixed, value, f: K->rows values. SDR_BAD_INPUT if a fixed
   row has no diagonal entry. */
sdr_status sdr_fix_unknowns(sdr_csr *matrix, const uint8_t *fixed, const double *value, double *f);

/* ---- collocation ---- */

/* One term c D_a u_p of an equation at a point; a may be SDR_VALUE. */
typedef struct {
  int a, p;
  double coefficient;
} sdr_term;

/* Add sum of terms at point i to one row: an equation inside, a condition on the boundary
   (Dirichlet: the value; Neumann: n_x D_x + n_y D_y), or both in any sum. The right-hand side is
   the caller's. */
sdr_status sdr_collocate(const sdr_operator *op, int32_t i, int count, const sdr_term *term,
                         int32_t row, sdr_csr_builder *matrix);

#endif
