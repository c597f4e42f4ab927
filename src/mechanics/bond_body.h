/* What the kernels of bond-based bodies read and write: arrays, and nothing else. */
#ifndef SDR_MECHANICS_BOND_BODY_H
#define SDR_MECHANICS_BOND_BODY_H

#include "damage/laws.h"
#include "nom/bonds.h"

#include <stddef.h>

/* What the pairs of a class share, for float arithmetic (bond_mixed.c). */
typedef struct {
  float xi[3], inverse_square, wij, wji, rest; /* rest: of their product, lost in rounding */
} sdr_terms_float;

/* Histories are indexed by slot. Which of them exist depends on the law: a stretch with those that
   soften (sdr_law_softens), flags with critical_stretch and, if some pair is cut, with none. The
   stretch is in `history` for implicit integrators (`precise`), in `stretch` for explicit ones. */
typedef struct {
  const sdr_points *points;
  const sdr_bonds *bonds;
  sdr_law law;
  double stiffness, threshold;         /* C and q where all points share them */
  double *stiffness_at, *threshold_at; /* a point; NULL: shared */
  double decline, *decline_at;         /* r of bond_law.h (cohesive), likewise */
  float *stretch, *loose_stretch;      /* k, or SDR_STRETCH_CUT, SDR_STRETCH_PROTECTED */
  int precise;
  double *history, *loose_history; /* the same in double */
  double *records; /* of points, for explicit kernels of loose pairs: u, C and, if it fits, q */
  sdr_flags *flags, *loose_flags; /* SDR_LOST_I ... */
  uint8_t *run_marked; /* a run: 1 if one of its pairs is cut or protected; NULL: none is */
  int loose_marked;    /* 1 if some loose pair is */
  /* precision mixed: displacements over length_unit as whole numbers modulo 2^32, C over
     `stiffness` and q of each point (NULL: shared), and the unit of forces as whole numbers (N);
     per_length_unit is 1/length_unit; stiffest: a bond's force is at most that times the distance
     its ends moved apart, N/m */
  int mixed, watch; /* watch: kernels tell the bits of forces in this step */
  int32_t *place[3];
  sdr_terms_float *float_terms; /* a class, in these units */
  float *relative_stiffness, *float_threshold;
  double length_unit, force_unit, per_length_unit, stiffest;
  uint8_t *run_fresh, *chunk_fresh; /* critical: 1 if a bond was lost that is not booked yet */
  uint8_t *run_flagged;             /* critical: a run: 0 if none of its flags is set */
  double *run_limit; /* critical: a run: z = (l/|xi|)^2 - 1 up to which none of its bonds breaks */
  int commit;        /* 1: histories take in what force kernels see */
} sdr_bond_body;

/* Energies of a stripe. */
typedef struct {
  double stored, dissipated, max_damage;
  int64_t broken;
} sdr_stripe_energies;

/* Runs [first, end): f += force. body->commit has the history take the state in. */
typedef void (*sdr_run_force)(const sdr_bond_body *body, int64_t first, int64_t end,
                              double *const u[3], double *const f[3]);
/* The same in whole numbers (mixed): all bits that some force has, if
   body->watch asks for them, to tell how large they are. */
typedef int32_t (*sdr_mixed_force)(const sdr_bond_body *body, int64_t first, int64_t end,
                                   double *const u[3], double *const f[3]);
/* Chunks [first, end) of loose points: f += force. */
typedef void (*sdr_loose_force)(const sdr_bond_body *body, int64_t first, int64_t end,
                                double *const u[3], double *const f[3]);
typedef void (*sdr_run_energies)(const sdr_bond_body *body, int64_t first, int64_t end,
                                 double *const u[3], sdr_stripe_energies *sum);

/* Runs [first, end): sum over each point's bonds of damage times the neighbour's volume. */
typedef void (*sdr_run_damage)(const sdr_bond_body *body, int64_t first, int64_t end,
                               double *const u[3], double *sum);

/* Runs [first, end): the most that the places of a bond's ends differ in a component (mixed). */
typedef int32_t (*sdr_run_apart)(const sdr_bond_body *body, int64_t first, int64_t end);

/* The kernels of one instruction set. */
typedef struct {
  const char *name; /* "avx512", "avx2", "baseline" */
  /* [law][components - 1][moduli a point: 1, shared: 0] */
  sdr_run_force run_force[SDR_LAW_COUNT][3][2];
  sdr_mixed_force mixed_run_force[SDR_LAW_COUNT][3][2]; /* these commit; NULL: the law has none */
  sdr_loose_force loose_force[SDR_LAW_COUNT][3][2];
  sdr_run_energies run_energies[SDR_LAW_COUNT][3][2];
  sdr_run_damage run_damage[SDR_LAW_COUNT][3][2];
  sdr_run_apart run_apart[3]; /* [components - 1] */
  /* f += K v with the tangent K of the reference shape, damage aside: [components - 1][moduli] */
  sdr_run_force run_reference[3][2];
} sdr_bond_kernels;

/* Those of bodies with histories in double: [law][components - 1][moduli a point]. */
typedef struct {
  sdr_run_force run_force[SDR_LAW_COUNT][3][2];
  sdr_loose_force loose_force[SDR_LAW_COUNT][3][2];
  sdr_run_energies run_energies[SDR_LAW_COUNT][3][2];
  sdr_run_energies loose_energies[SDR_LAW_COUNT][3][2]; /* of chunks [first, end) */
  /* Histories of runs [first, end) take u in: laws that soften. */
  void (*run_commit[3])(const sdr_bond_body *body, int64_t first, int64_t end, double *const u[3]);
} sdr_precise_kernels;

extern const sdr_bond_kernels sdr_bond_kernels_baseline;
extern const sdr_precise_kernels sdr_precise_kernels_baseline;
#ifdef SDR_HAVE_X86_KERNELS
extern const sdr_bond_kernels sdr_bond_kernels_avx2, sdr_bond_kernels_avx512;
extern const sdr_precise_kernels sdr_precise_kernels_avx2, sdr_precise_kernels_avx512;
#endif

/* The kernels for the best instruction set that this processor and sdr_isa_limit allow. */
const sdr_bond_kernels *sdr_bond_kernels_best(void);
const sdr_precise_kernels *sdr_precise_kernels_best(void);

/* Lower the instruction set: "avx512", "avx2", "baseline". SDR_BAD_INPUT for another name or one
   that this processor lacks. */
sdr_status sdr_isa_limit(const char *name);

#endif
