/* Shared by the files that make up the non-ordinary model. */
#ifndef SDR_MECHANICS_NONORDINARY_INTERNAL_H
#define SDR_MECHANICS_NONORDINARY_INTERNAL_H

#include "mechanics/nonordinary_body.h"
#include "mechanics/state_body.h"
#include "mechanics/stress.h"

/* A directed bond in the list of its owner, for the exact tangent. */
typedef struct {
  int32_t j;
  int32_t loose;
  int64_t slot;
  double xi[3], weight; /* W */
} sdr_member;

typedef struct {
  sdr_state_body state;
  sdr_nonordinary_body body;
  const sdr_nonordinary_kernels *kernels;
  sdr_elasticity elasticity;
  int local;             /* 1: bonds reach from one stripe into the next, no further */
  int split;             /* SDR_SPLIT_WHOLE unless variational */
  double *lambda, *mu;   /* Pa, of the law */
  double *control_shear; /* Pa: P_s and P_n */
  double *control_normal;
  double condition; /* largest ratio of eigenvalues of a shape tensor, before any bond breaks */
  double *whole;    /* trace of each shape tensor before any bond breaks */
  double *least;    /* of its least eigenvalue: below it the point's moduli fade */
  double *whole_lambda, *whole_mu;         /* Pa, of the law, before any bond breaks */
  double *reference_lambda, *reference_mu; /* Pa, of the law for small strains */
  double *limit;                           /* critical_stretch: s0 (2 + s0) */
  uint8_t *found, *found_loose;            /* a run, a chunk */
  uint8_t *torn;                           /* a point: 1 if it has lost bonds since the start */
  int32_t stale; /* 1: the flags may have been read from a checkpoint (critical_stretch) */

  /* Made when a tangent is first asked for. */
  int64_t *first; /* count + 1: the members of point i are first[i] .. first[i + 1] - 1 */
  sdr_member *member;
  int most;      /* members of the largest family */
  double *space; /* for the families that tangent_times has at work, one a stripe */
} sdr_nonordinary_model;

/* What one evaluation is to do. */
typedef struct {
  sdr_nonordinary_model *model;
  sdr_nonordinary_body body;
  int linear; /* 1: passes of small strain */
  int skip;   /* 1: resting stripes are left out */
  sdr_nonordinary_states states;
  double *const *u, *const *f;
} sdr_nonordinary_call;

/* The blocks of the body, from its runs. */
sdr_status sdr_nonordinary_bundles(sdr_nonordinary_model *model);

/* plus and minus of point i, not split, from the sums M in gradient, Q in moment (linear; the kept
   values) and those in square and along of W |eta|^2 and W (eta.n)^2, or of z (finite, with G in
   gradient). */
void sdr_nonordinary_energy(const sdr_nonordinary_model *model, int32_t i);
/* Finite: G in gradient from M in it; sums of z start at zero. */
void sdr_nonordinary_gradient(const sdr_nonordinary_model *model, int32_t i);

/* Shape tensors, moments and control of all families as the flags leave them. A point without an
   invertible shape tensor is named in the error; `may_fail`: it carries nothing instead. */
sdr_status sdr_nonordinary_families(sdr_nonordinary_model *model, int may_fail);
/* K^-1 (upper half; zero where K has none) and the share that stays of K's stiffness: 1, less where
   its least eigenvalue is below `least`, 0 where it cannot be inverted. Moduli go with its square.
 */
double sdr_nonordinary_share(int n, const double k[6], double least, double inverse[6]);
/* `least` of a family that starts with K. */
double sdr_nonordinary_least(int n, const double k[6]);
/* All families, for flags that have come from a checkpoint. */
void sdr_nonordinary_refresh(sdr_nonordinary_model *model);
void sdr_nonordinary_remake_fresh(sdr_state_body *state);

/* s0^2 of every point, such that a plane cut takes Gc (J/m^2, a material index), as nearly as can
   be for cuts in any direction. */
sdr_status sdr_nonordinary_set_threshold(sdr_nonordinary_model *model, const double *toughness);

/* Break what u stretches too far (critical_stretch). */
void sdr_nonordinary_break(sdr_nonordinary_model *model, double *const u[3]);
/* hooks->look and hooks->overstretch: of families that lost bonds z across the bond counts too. */
void sdr_nonordinary_look(sdr_state_body *state, double *const u[3]);
double sdr_nonordinary_overstretch(const sdr_state_body *state, const sdr_pair *pair, int from_i,
                                   double *const u[3]);
/* See sdr_state_hooks. */
void sdr_nonordinary_book(sdr_state_body *state, double *const u[3], double *const v[3], double dt);

/* See sdr_model_ops. */
sdr_status sdr_nonordinary_tangent_times(sdr_model *model, double *const u[3], double *const v[3],
                                         double *const out[3]);
sdr_status sdr_nonordinary_tangent_diagonal(sdr_model *model, double *const u[3], double *out);
sdr_status sdr_nonordinary_visit_hessian(sdr_model *model, double *const u[3],
                                         sdr_hessian_visitor visitor, void *context);
sdr_status sdr_nonordinary_visit_secant(sdr_model *model, double *const u[3],
                                        sdr_hessian_visitor visitor, void *context);
sdr_status sdr_nonordinary_field(sdr_model *model, double *const u[3], sdr_model_field which,
                                 double *out);

#endif
