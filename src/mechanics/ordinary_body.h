/* Ordinary state-based bodies (theory sec. 5; 000 eq. 42, 004 eq. 8-17), as their kernels see them.

   With s the stretch of a bond, w = omega_ij V_i V_j its weight, and per directed bond P and Q,
   a point i has
       S = sum P s,  Q = sum Q s^2,  theta = t S,
       energy density  1/2 K theta^2 + (B Q - A theta^2),
   dilatation and the rest. Each bond pulls with
       dE_i/ds = a P + c Q s,  a = V t theta (K - 2 A),  c = 2 B V    (undamaged)
   along its present direction, over |xi|.

       standard         P = Q = w xi^2, M = sum P, t = n/M, B = n (n+2) G/(2 M), A = (n+2) G/(2 n)
       madenci_oterkus  P = w, Q = w |xi|, t = d delta/V, B = b delta/V, A = G  (2-D, printed b, d)

   Damage: (1-d)^2 on B Q - A theta^2, and on 1/2 K theta^2 where theta > 0. Lost bonds: see
   sdr_ordinary_torn. */
#ifndef SDR_MECHANICS_ORDINARY_BODY_H
#define SDR_MECHANICS_ORDINARY_BODY_H

#include "mechanics/state_body.h"

/* What the pairs of a run share. */
typedef struct {
  double xi[3], inverse_square;      /* 1/xi^2 */
  double p_ij, p_ji, q_ij, q_ji;     /* P and Q of both halves */
  double pf_ij, pf_ji, qf_ij, qf_ji; /* over xi^2: for forces */
  double r_ij, r_ji;                 /* P^2/Q */
} sdr_ordinary_class;

typedef struct sdr_ordinary_kernels sdr_ordinary_kernels;

enum { SDR_ORDINARY_BOOKS = 8 };

typedef struct {
  sdr_state_body body;
  const sdr_ordinary_kernels *kernels;
  sdr_ordinary_form form;
  sdr_ordinary_class *classes; /* one for each of the bonds' */
  /* Constants of a point with all its bonds; 0 where it has none. */
  double *t, *a, *b; /* t, A, B above */
  double *whole;     /* sum P^2/Q */
  double weakest;    /* critical_stretch: the least s0^2 */
  int one_threshold; /* 1: it is every point's */
  /* Of the present state, scratch: S, Q, sum P^2/Q of halves lost since the start
     (critical_stretch), and the coefficients of the forces. */
  double *sum, *square, *lost;
  double *along, *across; /* a and c above, damage included */
  double *records;  /* of points with loose pairs (NULL: none): u, along and, if it fits, across */
  double *slope[2]; /* tangents: what a and c change by; made when first asked for */
  double *book[SDR_ORDINARY_BOOKS]; /* critical_stretch: see ordinary_book.c */
} sdr_ordinary;

/* Which bonds a pass counts: those that the flags leave; those that present stretches leave too,
   and flags take it in. */
typedef enum { SDR_FLAGS_KEEP, SDR_FLAGS_COMMIT } sdr_flags_use;

/* Add to S, lost and, with squares, Q. Runs or chunks [first, end). */
typedef void (*sdr_ordinary_sums)(sdr_ordinary *body, int64_t first, int64_t end,
                                  double *const u[3]);
/* f += force (N). */
typedef void (*sdr_ordinary_force)(const sdr_ordinary *body, int64_t first, int64_t end,
                                   double *const u[3], double *const f[3]);
/* Coefficients of the points [first, end) from their sums; `commit`: the history takes them in. */
typedef void (*sdr_ordinary_points)(sdr_ordinary *body, int64_t first, int64_t end, int commit);

struct sdr_ordinary_kernels {
  const char *name; /* "avx512", "avx2", "baseline" */
  /* [components - 1][sdr_flags_use]; squares come with KEEP only */
  sdr_ordinary_sums run_sums[3][2], loose_sums[3][2];
  sdr_ordinary_sums run_squares[3], loose_squares[3];
  sdr_ordinary_force run_force[3], loose_force[3]; /* [components - 1] */
  sdr_ordinary_points points[3];                   /* [law] */
  /* The same for a small displacement v of the reference shape: S of linear stretches, and
     f += K v. [components - 1] */
  sdr_ordinary_sums run_linear_sums[3], loose_linear_sums[3];
  sdr_ordinary_force run_linear_force[3], loose_linear_force[3];
};

extern const sdr_ordinary_kernels sdr_ordinary_kernels_baseline;
#ifdef SDR_HAVE_X86_KERNELS
extern const sdr_ordinary_kernels sdr_ordinary_kernels_avx2, sdr_ordinary_kernels_avx512;
#endif

/* t, A and B of point i as its bonds stand. */
typedef struct {
  double t, a, b;
} sdr_ordinary_constants;

/* A of a family that has lost halves with sum P^2/Q = `lost`. Their stretches no longer hang on
   displacements and take the values that cost least: with k = K - 2 A

     min over lost s of 1/2 k t^2 (S + sum P s)^2 + B sum Q s^2 = 1/2 k' t^2 S^2,
     k' = k/(1 + k t^2 lost/(2 B)).

   So no loss can raise the energy of any state, nor any stiffness (theory sec. 9). */
static inline double sdr_ordinary_torn(const sdr_ordinary_constants *of, double bulk, double lost)
{
  const double over = bulk - 2.0 * of->a;
  const double left = over / (1.0 + 0.5 * over * of->t * of->t * lost / of->b);
  return lost > 0.0 ? 0.5 * (bulk - left) : of->a;
}

/* The state of a point from its sums. Q is read with variational damage only. */
typedef struct {
  double theta, plus, minus;
} sdr_ordinary_point;

static inline sdr_ordinary_point sdr_ordinary_point_of(const sdr_ordinary_constants *of,
                                                       double bulk, double sum, double square)
{
  const double theta = of->t * sum, volumetric = 0.5 * bulk * theta * theta;
  const double shape = of->b * square - of->a * theta * theta;
  return (sdr_ordinary_point){theta, theta > 0.0 ? shape + volumetric : shape,
                              theta > 0.0 ? 0.0 : volumetric};
}

/* Constants of point i: sums over lost halves must be those of the last pass. */
static inline sdr_ordinary_constants sdr_ordinary_now(const sdr_ordinary *o, int32_t i)
{
  sdr_ordinary_constants of = {o->t[i], o->a[i], o->b[i]};
  if (o->lost) of.a = sdr_ordinary_torn(&of, o->body.bulk[i], o->lost[i]);
  return of;
}

#endif
