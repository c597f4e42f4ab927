/* What the kernels of non-ordinary bodies read and write (theory sec. 11). All arrays are over the
   points, padded. Weights of pairs are W_ij = omega_ij V_i V_j, so sums over a family carry V_i. */
#ifndef SDR_MECHANICS_NONORDINARY_BODY_H
#define SDR_MECHANICS_NONORDINARY_BODY_H

#include "damage/laws.h"
#include "nom/bonds.h"

#include <stdint.h>

typedef struct {
  const sdr_points *points;
  const sdr_bonds *bonds;
  int plane_stress;

  /* Of the families as the flags leave them. A point whose shape tensor cannot be inverted has
     zeros here: it carries nothing. */
  double *inverse[6];     /* K^-1, K = sum W xi (x) xi: xx | xx xy yy | xx xy xz yy yz zz */
  double *quartic[15];    /* sum W xi^2 times each quartic monomial of xi/|xi| (sdr_quartic) */
  double *shear, *normal; /* V P_s/m, V P_n/m, m = tr K: control of an undamaged point */
  const double *lambda, *mu;

  /* Variational. */
  double *history;        /* J/m^3 */
  const double *softness; /* m^3/J */
  int commit;             /* 1: points take their history in */

  /* Flags as in sdr_state_body. */
  const sdr_flags *flags, *loose_flags;
  const uint8_t *run_flagged;
  int loose_flagged;

  /* Work. Pass A: M = sum W eta (x) xi; then G = F - I (linear: its symmetric part). n x n. */
  double *gradient[9];
  /* Pass A (linear): Q = sum W (eta.n) n (x) xi, upper half without its last value, which the trace
     of M gives; then A, what bears on xi: T = W (A xi + soft eta + ...). n x n. */
  double *bearing[9];
  double *square, *along; /* sum W |eta|^2 and sum W (eta.n)^2 (linear), of z and z.n (finite) */
  double *soft, *stiff;   /* control times (1-d)^2 */
  double *plus, *minus;   /* J/m^3 */
} sdr_nonordinary_body;

/* Runs [first, end): add to points. */
typedef void (*sdr_nonordinary_runs)(const sdr_nonordinary_body *body, int64_t first, int64_t end,
                                     double *const u[3], double *const f[3]);
/* Chunks [first, end) of loose points. */
typedef sdr_nonordinary_runs sdr_nonordinary_loose;
/* Points [first, end). */
typedef void (*sdr_nonordinary_points)(const sdr_nonordinary_body *body, int32_t first,
                                       int32_t end);
/* Runs or chunks [first, end): 1 in found[r] where a half is stretched beyond its point's limit, s0
   (2 + s0) in (l^2 - xi^2)/xi^2, and neither lost nor protected. */
typedef void (*sdr_nonordinary_find)(const sdr_nonordinary_body *body, int64_t first, int64_t end,
                                     double *const u[3], const double *limit, uint8_t *found);

/* What a pass over pairs gathers: without or with the sums that energies need. */
enum { SDR_SUMS_NO, SDR_SUMS };

/* What becomes of a point's sums. */
typedef enum {
  SDR_POINT_ELASTIC, /* stress of an undamaged point */
  SDR_POINT_DAMAGED, /* stress by the variational law */
  SDR_POINT_ENERGY   /* plus and minus only */
} sdr_point_task;

/* The kernels of one instruction set. Indices: components - 1, linear 0 or finite 1 strain. */
typedef struct {
  const char *name;
  sdr_nonordinary_runs gather[3][2][2]; /* [components][strain][sums]: pass A */
  sdr_nonordinary_loose gather_loose[3][2][2];
  sdr_nonordinary_points gradients[3]; /* finite: G of M, work of pass A2 zeroed */
  sdr_nonordinary_runs control[3];     /* finite: pass A2 */
  sdr_nonordinary_loose control_loose[3];
  sdr_nonordinary_points point[3][3][3][3]; /* [components][elasticity][split][task] */
  sdr_nonordinary_runs force[3][2];         /* pass B */
  sdr_nonordinary_loose force_loose[3][2];
  sdr_nonordinary_find find[3], find_loose[3]; /* by run, by chunk */
} sdr_nonordinary_kernels;

extern const sdr_nonordinary_kernels sdr_nonordinary_kernels_baseline;
#ifdef SDR_HAVE_X86_KERNELS
extern const sdr_nonordinary_kernels sdr_nonordinary_kernels_avx2, sdr_nonordinary_kernels_avx512;
#endif

/* Index of a product of four coordinates in the order of sdr_quartic. */
static inline int sdr_quartic_index(int n, int a, int b, int c, int d)
{
  const int beyond = (a > 0) + (b > 0) + (c > 0) + (d > 0);
  const int third = (a > 1) + (b > 1) + (c > 1) + (d > 1);
  return n < 3 ? beyond : beyond * (beyond + 1) / 2 + third;
}

/* Index of K^-1 at row a, column b. */
static inline int sdr_upper(int n, int a, int b)
{
  const int low = a < b ? a : b, high = a < b ? b : a;
  return low * n - low * (low - 1) / 2 + high - low;
}

#endif
