/* What binds displacement components: u = a + B q, q the free ones (theory sec. 7, static).
   Components are numbered unknown = point * components + component throughout.

   A free component is one of q; a prescribed one is a constant, its row of B is empty; a slaved one
   (fictitious layers) is an affine function of others. Forces on u act on q as P^T f. P is B, so
   that they do the same work, but for slaves that say that theirs act on no point of the body. */
#ifndef SDR_MECHANICS_CONSTRAINTS_H
#define SDR_MECHANICS_CONSTRAINTS_H

#include "linalg/csr.h"
#include "mechanics/supports.h"

/* Slaved components, each once: u[unknown[k]] = constant[k] + sum over first[k] <= p < first[k + 1]
   of coefficient[p] u[master[p]]. Masters are free or prescribed, not slaved themselves. From
   sdr_alloc; whoever makes them destroys them. */
typedef struct {
  int32_t count;
  int32_t *unknown;
  double *constant; /* m */
  int64_t *first;   /* count + 1 */
  int32_t *master;
  double *coefficient;
  uint8_t *apart; /* 1: forces on it act on no point of the body; NULL: all act on their masters */
} sdr_slaves;
void sdr_slaves_destroy(sdr_slaves *slaves);

/* Append the slaves that keep the means of the supports: of each active one the first component
   follows the others, u_0 = N U - (u_1 + ...). `values`: of all entries of the supports' list at
   one time, m (NAN: not active). */
sdr_status sdr_slaves_of_means(const sdr_supports *supports, const double *values,
                               const sdr_points *points, sdr_slaves *slaves);

typedef struct {
  int32_t unknowns, free; /* entries of u and of q */
  double *offset;         /* a: `unknowns` values, m */
  int32_t *unknown;       /* per entry of q: the unknown that it is */
  sdr_csr map;            /* B: unknowns x free */
  int symmetric;          /* 1: P is B, and so B^T K B is symmetric if K is */
  sdr_csr force;          /* P; empty where it is B */
  uint8_t *prescribed;    /* per unknown: 1 if it is prescribed */
} sdr_constraints;

/* From the displacements of all entries of the supports' list at one time (m; NAN: not active, so
   free; of an entry that prescribes a velocity what that has come to) and the slaved components
   (NULL: none). A component that is both prescribed and slaved, or slaved twice, or slaved to a
   slave is SDR_BAD_INPUT. Borrows nothing. */
sdr_status sdr_constraints_create(const sdr_points *points, const sdr_supports *supports,
                                  const double *values, const sdr_slaves *slaves,
                                  sdr_constraints *out);
void sdr_constraints_destroy(sdr_constraints *constraints);

/* out = P^T K B, for K over all unknowns. */
sdr_status sdr_constraints_reduce(const sdr_constraints *constraints, const sdr_csr *k,
                                  sdr_csr *out);

/* u = a + B q. */
void sdr_constraints_expand(const sdr_constraints *constraints, const double *q, double *u);

/* g = P^T f. */
void sdr_constraints_project(const sdr_constraints *constraints, const double *f, double *g);

#endif
