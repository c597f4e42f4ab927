/* Mean forces of bond-based bodies over a step, and their tangent (theory sec. 7): the ops
   mean_force, mean_keep, mean_times, mean_diagonal and visit_mean_tangent. */
#ifndef SDR_MECHANICS_BOND_MEAN_H
#define SDR_MECHANICS_BOND_MEAN_H

#include "mechanics/bond_body.h"
#include "mechanics/model.h"

/* What the kernels read and write. `out` is added to. */
typedef struct {
  double *const *u0, *const *u1; /* m */
  double *const *v;              /* of a product with the tangent, else unused */
  double *const *out;            /* N; of diagonal blocks components^2 arrays, N/m */
  double *run_g, *run_h;         /* a slot of runs: g (N/m) and h (N/m^3); NULL: not kept */
  double *loose_g, *loose_h;     /* a loose slot */
} sdr_mean_step;

/* Runs, or chunks of loose points, [first, end). */
typedef void (*sdr_mean_kernel)(const sdr_bond_body *body, int64_t first, int64_t end,
                                const sdr_mean_step *step);

typedef struct {
  /* [law][components - 1][moduli a point: 1, shared: 0][g and h kept] */
  sdr_mean_kernel run_force[SDR_LAW_COUNT][3][2][2], loose_force[SDR_LAW_COUNT][3][2][2];
  sdr_mean_kernel run_times[3], loose_times[3], run_diagonal[3]; /* [components - 1] */
} sdr_mean_kernels;

extern const sdr_mean_kernels sdr_mean_kernels_baseline;
#ifdef SDR_HAVE_X86_KERNELS
extern const sdr_mean_kernels sdr_mean_kernels_avx2, sdr_mean_kernels_avx512;
#endif

void sdr_bond_mean_force(sdr_model *model, double *const u0[3], double *const u1[3],
                         double *const f[3]);
sdr_status sdr_bond_mean_keep(sdr_model *model, double *const u0[3], double *const u1[3],
                              double *const f[3]);
void sdr_bond_mean_times(sdr_model *model, double *const u0[3], double *const u1[3],
                         double *const v[3], double *const out[3]);
void sdr_bond_mean_diagonal(sdr_model *model, double *const u0[3], double *const u1[3],
                            double *out);
sdr_status sdr_bond_visit_mean_tangent(sdr_model *model, double *const u0[3], double *const u1[3],
                                       sdr_hessian_visitor visit, void *context);

/* The exact tangent of a state, kept in the same places: b I + (a - b) n (x) n of a pair is
   g I + 2 h y (x) y with g = b, h = (a - b)/(2 l^2). */
sdr_status sdr_bond_tangent_keep(sdr_model *model, double *const u[3]);
void sdr_bond_kept_times(sdr_model *model, double *const v[3], double *const out[3]);
void sdr_bond_kept_diagonal(sdr_model *model, double *out);

/* What mean_keep keeps; belongs to a model. */
typedef struct sdr_mean_kept sdr_mean_kept;
void sdr_mean_kept_destroy(sdr_mean_kept **kept); /* NULL-safe */

#endif
