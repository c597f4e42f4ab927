/* What ordinary and non-ordinary state-based bodies share (theory sec. 5): constants of the points,
   flags of the pairs, damage at the points, books of lost bonds, and the operations of a model that
   need no more than that. A concrete model has sdr_state_body as its first member, so that an
   sdr_model * is an sdr_state_body * too and the functions below fit sdr_model_ops.

   A point's energy density (J/m^3) is (1-d)^2 plus + minus + H d (1-d): `plus` is all that damage
   softens (control energy included), `minus` the rest; H is the largest `plus` so far and
   d = H/(H + Gc/ell), so that the last term is (Gc/ell) d^2, dissipated (theory sec. 5). Without
   the variational law d = 0. Lost and cut bonds are out of their families. */
#ifndef SDR_MECHANICS_STATE_BODY_H
#define SDR_MECHANICS_STATE_BODY_H

#include "damage/laws.h"
#include "mechanics/model.h"
#include "mechanics/state_based.h"

typedef struct sdr_state_body sdr_state_body;

/* What a concrete model tells the shared part. */
typedef struct {
  const char *(*isa)(const sdr_state_body *body);

  /* body->plus and body->minus of all points at u, over the bonds that the flags leave. */
  void (*split)(sdr_state_body *body, double *const u[3]);

  /* Pairs were marked: set up anew what depends on who is in which family. May be NULL. */
  sdr_status (*remake)(sdr_state_body *body);

  /* Critical stretch: add to body->release[i] what every point i with body->fresh[i] lost (J): its
     family lost the halves with a FRESH flag. e before the step is that at u - dt v (v NULL: at u).
     For an energy that is quadratic, E = 1/2 e A e, before, and 1/2 e A' e after, leapfrog loses
     1/2 e_n (A - A') e_(n+1); in general the mean of E - E' at both ends comes as close as the
     square of the step. sdr_state_visit_fresh hands out the pairs that matter. */
  void (*book)(sdr_state_body *body, double *const u[3], double *const v[3], double dt);

  /* Critical stretch: get ready to be asked overstretch at u (may be NULL); what is compared to
     s0^2 for the half that point i (else j) of a pair owns, 0 or more: the square of a positive
     stretch, and whatever else breaks bonds of the model. */
  void (*look)(sdr_state_body *body, double *const u[3]);
  double (*overstretch)(const sdr_state_body *body, const sdr_pair *pair, int from_i,
                        double *const u[3]);

  /* Points with body->fresh got the bonds of this step back: set up anew what depends on them. */
  void (*remake_fresh)(sdr_state_body *body);
} sdr_state_hooks;

struct sdr_state_body {
  sdr_model head;
  const sdr_state_hooks *hooks;
  sdr_bonds *bonds; /* owned */
  sdr_dimension dimension;
  sdr_law law;

  /* Constants of a point, padded. */
  double *bulk, *shear; /* Pa: K, n-dimensional, and G; 1-D: E and E/3 */
  double *ell;          /* m; variational, else NULL */
  double *softness;     /* m^3/J: ell/Gc; 0: never softens; variational, else NULL */
  double *threshold;    /* s0^2; critical_stretch, else NULL */

  /* State. */
  double *history;                  /* J/m^3: H of each point; variational, else NULL */
  sdr_flags *flags, *loose_flags;   /* a slot; NULL: none is ever set */
  uint8_t *run_flagged;             /* a run: 1 if one of its flags is set; NULL as `flags` */
  int loose_flagged;                /* 1 if some loose pair was cut or protected at the start */
  double *booked;                   /* J: energy of each point's lost bonds; critical_stretch */
  double *release;                  /* J: of those that a step loses */
  uint8_t *run_fresh, *chunk_fresh; /* 1: a FRESH flag in it. Kernels that break bonds set them,
                                       and run_flagged */
  uint8_t *fresh;                   /* a point: 1 while it loses bonds (during hooks->book) */

  double *plus, *minus;  /* J/m^3, what hooks->split fills */
  double *family_volume; /* m^3: sum of V_j over H_i, cut bonds included */
  int32_t *family_count; /* directed bonds of i that are not cut at the start */
  uint8_t *moved;        /* a stripe: 1 once some displacement in it was not zero */
  int keep_resting;
};

/* Fill a zeroed body in; takes the bonds over (they live as long as the body, also if this fails:
   call sdr_state_body_clear then). */
sdr_status sdr_state_body_init(sdr_state_body *body, const sdr_model_ops *ops,
                               const sdr_state_hooks *hooks, const sdr_points *points,
                               sdr_bonds *bonds, const sdr_state_based_how *how);
/* Release what the body holds, not the body itself. */
void sdr_state_body_clear(sdr_state_body *body);

/* ---- constants, by theory sec. 4-5 ----------------------------------------------------------- */

/* n-dimensional bulk modulus and shear modulus, Pa. 1-D: E and E/3, the bond-based bar. */
double sdr_state_bulk(sdr_dimension dimension, double young, double poisson);
double sdr_state_shear(sdr_dimension dimension, double young, double poisson);

/* s0^2 for Gc (J/m^2) and a horizon (m). */
double sdr_state_threshold(sdr_dimension dimension, double bulk, double shear, double toughness,
                           double horizon);

/* The length ell of point i, m: as given, or the band of points that a plane cut damages, for which
   see state_cut.h; 2 horizons of irregular points, which a body brings down to how far its families
   really reach. */
double sdr_state_ell(const sdr_points *points, const sdr_length *given, int32_t i);

/* What a model made of it, and s0^2, which a model may find by itself: of point i; NAN where its
   law has none. */
void sdr_state_constants(const sdr_model *model, int32_t i, double *ell, double *threshold);

/* ---- damage of points and pairs -------------------------------------------------------------- */

/* Damage of point i for H = max(history, plus). */
static inline double sdr_state_damage(const sdr_state_body *body, int32_t i, double plus)
{
  if (!body->history) return 0.0;
  const double h = plus > body->history[i] ? plus : body->history[i];
  const double x = h * body->softness[i];
  return x / (1.0 + x);
}

/* Halves of the pair that are lost at stretch s, as SDR_LOST_I | SDR_LOST_J. `grown`: 1 as the
   force sees it, bonds that s would break included; 0 by the flags alone. */
sdr_flags sdr_state_lost(const sdr_state_body *body, const sdr_pair *pair, double s, int grown);

/* ---- stripes --------------------------------------------------------------------------------- */

/* Loose chunks of stripe s: [*first, *end). */
void sdr_state_chunks(const sdr_state_body *body, int s, int64_t *first, int64_t *end);

/* Note in which stripes the first displacement has come. */
void sdr_state_watch(sdr_state_body *body, double *const u[3]);

/* 1 if no point of the stripes s - below .. s + above ever moved. A pass over a stripe's pairs that
   reads displacements only wants (0, 1); one that reads sums over the families of its points, which
   reach one stripe further on both sides, wants (1, 2). */
int sdr_state_rests(const sdr_state_body *body, int s, int below, int above);

/* ---- bonds that critical stretch loses ------------------------------------------------------- */

/* Book what the step lost once all flags are grown, clear FRESH flags and marks. v NULL: as if all
   happened at u. Nothing is done where no run_fresh or chunk_fresh is set. */
void sdr_state_book(sdr_state_body *body, double *const u[3], double *const v[3], double dt);

/* hooks->overstretch of bodies that break by stretch alone. */
double sdr_state_square_stretch(const sdr_state_body *body, const sdr_pair *pair, int from_i,
                                double *const u[3]);

/* Visit the slots of stripe s that have an end with body->fresh; of loose ones those of fresh
   points. */
void sdr_state_visit_fresh(const sdr_state_body *body, int s, sdr_pair_visitor visit,
                           void *context);

/* ---- operations of a model ------------------------------------------------------------------- */

void sdr_state_commit(sdr_model *model, double *const u[3]);
int64_t sdr_state_break_most(sdr_model *model, double *const u[3], double share);
void sdr_state_energies(sdr_model *model, double *const u[3], sdr_energies *out);
/* damage: d_i (variational), else the share of H_i by volume that is cut or lost; energy_density;
   dissipated. Other fields are the model's own. */
sdr_status sdr_state_field(sdr_model *model, double *const u[3], sdr_model_field which,
                           double *out);
/* Variational: 1 for cut pairs, else the mean of both points' damage. */
void sdr_state_visit_damage(sdr_model *model, double *const u[3],
                            void (*visit)(void *context, int32_t i, int32_t j, double damage),
                            void *context);
/* Cut pairs leave their families. A point whose own place is marked SDR_PROTECTED never softens
   (variational); a pair marked so never breaks (critical_stretch). */
sdr_status sdr_state_mark(sdr_model *model, sdr_pair_mark mark, const void *context,
                          int64_t *cut_bonds);
void sdr_state_visit_lost(const sdr_model *model, int s, sdr_lost_visitor visit, void *context);
void sdr_state_skip_rest(sdr_model *model, int skip);
void sdr_state_traits(const sdr_model *model, sdr_model_traits *out);
void sdr_state_blocks(sdr_model *model, sdr_state_block *blocks, int *count);

#endif
