/* Shared by the files that make up the bond-based model. */
#ifndef SDR_MECHANICS_BOND_INTERNAL_H
#define SDR_MECHANICS_BOND_INTERNAL_H

#include "damage/bond_law.h"
#include "mechanics/bond_based.h"
#include "mechanics/bond_body.h"
#include "mechanics/bond_mean.h"

typedef struct {
  sdr_model head;
  sdr_bonds *bonds;
  sdr_bond_body body;
  const sdr_bond_kernels *kernels;
  const sdr_precise_kernels *precise; /* at work if body.precise */
  double
      *family_volume; /* a point: sum of V_j over H_i, m^3; made when damage is first asked for */
  uint8_t *moved;     /* a stripe: 1 once some displacement in it was not zero */
  int keep_resting;   /* 1: compute resting stripes too (tests) */
  /* precision mixed, part of the state: no bond's ends have moved apart by more than `widest` (m),
     measured `steps` steps ago; `unit` is the body's length_unit, 0 before the first step; `force`:
     no bond's is larger, N */
  struct {
    double widest, unit, steps, force;
  } bound;
  double *booked;             /* a stripe: energy of bonds lost so far, J (critical_stretch) */
  struct sdr_mean_kept *mean; /* of mean_keep; NULL: never asked */
} sdr_bond_model;

/* C, q and r of point i. */
static inline double sdr_body_stiffness(const sdr_bond_body *body, int32_t i)
{
  return body->stiffness_at ? body->stiffness_at[i] : body->stiffness;
}
static inline double sdr_body_threshold(const sdr_bond_body *body, int32_t i)
{
  return body->threshold_at ? body->threshold_at[i] : body->threshold;
}

static inline double sdr_body_decline(const sdr_bond_body *body, int32_t i)
{
  return body->decline_at ? body->decline_at[i] : body->decline;
}

/* Stretch of a pair at u. */
double sdr_pair_stretch(const sdr_pair *pair, int components, double *const u[3]);

/* What both directed bonds of a pair answer at stretch s, their history taking it in. Bonds that
   critical stretch has not lost yet answer whole, however far they are stretched. Those cut at the
   start have damage 1. */
typedef struct {
  sdr_bond_answer ij, ji;
  int cut;
} sdr_pair_answer;
sdr_pair_answer sdr_pair_answer_at(const sdr_bond_body *body, const sdr_pair *pair, double s);

/* Loose chunks of a stripe: [*first, *end). */
void sdr_stripe_chunks(const sdr_bond_body *body, int s, int64_t *first, int64_t *end);

/* 1 if no bond that stripe s owns can be stretched: it and the next never moved. */
static inline int sdr_stripe_rests(const sdr_bond_model *model, int s)
{
  const int last = s + 1 >= model->head.points->stripe_count;
  return !model->keep_resting && !model->moved[s] && (last || !model->moved[s + 1]);
}

/* Note in which stripes the first displacement has come. */
void sdr_bond_watch(sdr_bond_model *model, double *const u[3]);

/* Call task for even stripes, then for odd ones, in parallel: pairs write to at most the next. */
void sdr_each_stripe(const sdr_points *points, void (*task)(void *, int), void *context);

/* Set run_flagged of runs [first, end), if the body has it, after their flags were changed. */
void sdr_bond_note_flags(sdr_bond_body *body, int64_t first, int64_t end);

/* Flags for all slots, zero, where they are not there yet. */
sdr_status sdr_bond_alloc_flags(sdr_bond_model *model);

/* precision mixed: make what its kernels need; set places and units for the displacements u, to
   which the velocities v led in a step of dt (0: the first). */
sdr_status sdr_bond_set_mixed(sdr_bond_body *body);
void sdr_bond_split(sdr_bond_model *model, double *const u[3], double *const v[3], double dt);

/* Note the bits that the forces have (sdr_mixed_force), if they were watched. */
void sdr_bond_take_bits(sdr_bond_model *model, int32_t bits);

/* Parts of the model in their own files. */
sdr_status sdr_bond_set_constants(sdr_bond_body *body, const sdr_families *families,
                                  const sdr_bond_based_how *how);
void sdr_bond_precise_force(sdr_bond_model *model, double *const u[3], double *const f[3]);
void sdr_bond_energies(sdr_model *model, double *const u[3], sdr_energies *out);
sdr_status sdr_bond_field(sdr_model *model, double *const u[3], sdr_model_field which, double *out);
/* Make family_volume if it is not there. */
sdr_status sdr_bond_find_family_volume(sdr_bond_model *model);
void sdr_bond_visit_damage(sdr_model *model, double *const u[3],
                           void (*visit)(void *context, int32_t i, int32_t j, double damage),
                           void *context);
sdr_status sdr_bond_mark(sdr_model *model, sdr_pair_mark mark, const void *context,
                         int64_t *cut_bonds);
void sdr_bond_visit_lost(const sdr_model *model, int s, sdr_lost_visitor visit, void *context);
sdr_status sdr_bond_split_state(sdr_model *model, double *const u[3], double *energy,
                                double *damage);
sdr_status sdr_bond_inherit(sdr_model *model, const sdr_model *before, const sdr_point_map *map,
                            const sdr_pair_mark_of *mark);
void sdr_bond_visit_held(const sdr_model *model, double *const u[3], const uint8_t *at,
                         sdr_held_visitor visit, void *context);
void sdr_bond_reference_times(sdr_model *model, double *const v[3], double *const out[3]);
sdr_status sdr_bond_tangent_times(sdr_model *model, double *const u[3], double *const v[3],
                                  double *const out[3]);
sdr_status sdr_bond_tangent_diagonal(sdr_model *model, double *const u[3], double *out);
void sdr_bond_pair_tangent(const sdr_bond_body *body, const sdr_pair *pair, double *const u[3],
                           double n[3], double *a, double *b);
sdr_status sdr_bond_visit_hessian(sdr_model *model, double *const u[3], sdr_hessian_visitor visit,
                                  void *context);

sdr_status sdr_bond_visit_secant(sdr_model *model, double *const u[3], sdr_hessian_visitor visit,
                                 void *context);
int64_t sdr_bond_break_most(sdr_model *model, double *const u[3], double share);

/* Book the energy of freshly lost bonds of stripe s (critical_stretch). */
void sdr_bond_book(sdr_bond_model *model, int s, double *const u[3], double *const v[3], double dt);

#endif
