/* What the kernels of non-ordinary bodies read and write (theory sec. 11). All arrays are over the
   points, padded. Weights of pairs are W_ij = omega_ij V_i V_j, so sums over a family carry V_i. */
#ifndef SDR_MECHANICS_NONORDINARY_BODY_H
#define SDR_MECHANICS_NONORDINARY_BODY_H

#include "damage/laws.h"
#include "nom/bonds.h"

#include <stdint.h>

/* A class of bonds as seen from one of its ends, whose W it has; xi leads to the other end.
   Products of xi in the order of sdr_upper. */
typedef struct {
  double xi[3], by_square; /* 1/xi^2 */
  double own, own_xi[3];   /* W, W xi */
  double along_xi[3];      /* W xi/xi^2 */
  double own_normal[6];    /* W xi (x) xi/xi^2 */
  double twice[6];         /* xi (x) xi; doubled off the diagonal */
} sdr_direction;

/* Bonds of one class from points of a block to points `offset` further on: lanes of the points that
   have one. */
typedef struct {
  int32_t offset, run;
  int32_t direction; /* 2 class_index + side */
  int32_t lanes;
} sdr_bundle;

/* The bonds of block b, points 8 b .. 8 b + 7, on runs: bundles[first] .. bundles[first + count -
   1]. Blocks inside a row share theirs. */
typedef struct {
  int64_t first;
  int32_t count;
} sdr_block_bundles;

typedef struct {
  const sdr_points *points;
  const sdr_bonds *bonds;
  sdr_direction *directions;
  sdr_bundle *bundles;
  sdr_block_bundles *blocks;
  int plane_stress;
  int elasticity, split;

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

  /* What loose pairs read of points (NULL: there are none), side by side a point: displacements;
     and what the state pass makes of a point and bears on its bonds, by sdr_bearing_size. */
  double *places, *bearings;

  double *gradient[9];    /* after energies: G = F - I (finite) or sym G (linear), n x n */
  double *moment[9];      /* scratch of families */
  double *plus, *minus;   /* J/m^3 */
  double *square, *along; /* sum W |z|^2 and W (z.n)^2; of points whose energy is booked */
} sdr_nonordinary_body;

/* Blocks of eight points [first, end): their states, and the forces of their families on runs added
   to f (NULL: no forces). u NULL: all of them and what they see rest. */
typedef void (*sdr_nonordinary_states)(const sdr_nonordinary_body *body, int64_t first, int64_t end,
                                       double *const u[3], double *const f[3]);
/* Forces of loose pairs on the points of blocks [first, end), added to f. */
typedef sdr_nonordinary_states sdr_nonordinary_forces;

/* Runs or chunks [first, end): 1 in found[r] where a half is stretched beyond its point's limit, s0
   (2 + s0) in (l^2 - xi^2)/xi^2, and neither lost nor protected. */
typedef void (*sdr_nonordinary_find)(const sdr_nonordinary_body *body, int64_t first, int64_t end,
                                     double *const u[3], const double *limit, uint8_t *found);

/* What becomes of a point's sums. */
typedef enum {
  SDR_POINT_ELASTIC, /* stress of an undamaged point */
  SDR_POINT_DAMAGED, /* stress by the variational law */
  SDR_POINT_ENERGY   /* plus, minus and the gradient only */
} sdr_point_task;

/* The kernels of one instruction set. Indices: components - 1, linear 0 or finite 1 strain. */
typedef struct {
  const char *name;
  sdr_nonordinary_states state[3][2][3]; /* [components][strain][task] */
  sdr_nonordinary_forces force[3][2];
  sdr_nonordinary_find find[3], find_loose[3]; /* by run, by chunk */
} sdr_nonordinary_kernels;

extern const sdr_nonordinary_kernels sdr_nonordinary_kernels_baseline;
#ifdef SDR_HAVE_X86_KERNELS
extern const sdr_nonordinary_kernels sdr_nonordinary_kernels_avx2, sdr_nonordinary_kernels_avx512;
#endif

/* Numbers that one record of `bearings` has, filled up to whole SDR_RECORDs: u, soft, stiff, A,
   then G (finite) or the upper half of stiff sym G (linear): T = W (A xi + soft eta + ...). */
static inline int sdr_bearing_size(int n, int finite)
{
  const int entries = finite ? n * n : n * (n + 1) / 2;
  return (n + 2 + n * n + entries + 3) / 4 * 4;
}

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
