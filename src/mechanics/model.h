/* The interface of a model: an energy functional over the bonds or points of a body, with damage.
   Whoever uses it sees points and arrays; bonds stay inside. */
#ifndef SDR_MECHANICS_MODEL_H
#define SDR_MECHANICS_MODEL_H

#include "base/status.h"
#include "mechanics/lost.h"
#include "mechanics/refine.h"
#include "nom/bonds.h"
#include "nom/points.h"

#include <stddef.h>
#include <stdint.h>

/* Energies of a state, J. */
typedef struct {
  double stored;
  double dissipated;
  double max_damage; /* largest damage of a bond, in [0, 1]; bonds cut at the start not counted */
  int64_t broken;    /* directed bonds grown past d = 0.5 since t = 0 */
} sdr_energies;

/* A block of memory that belongs to the state (history, flags), for checkpoints. */
typedef struct {
  const char *name;
  void *data;
  size_t bytes;
} sdr_state_block;

enum { SDR_STATE_BLOCKS = 8 };

typedef enum {
  SDR_FIELD_DAMAGE,         /* 1 component: mean over H_i of d_ij by volume */
  SDR_FIELD_ENERGY_DENSITY, /* 1: stored energy per volume, half of each bond's at both ends, J/m^3
                             */
  SDR_FIELD_DISSIPATED,     /* 1: likewise, J/m^3 */
  SDR_FIELD_STRESS,         /* xx, yy, xy | xx, yy, zz, yz, xz, xy | xx; Pa */
  SDR_FIELD_STRAIN,         /* as stress, small strain from the nonlocal gradient */
  SDR_FIELD_DILATATION      /* 1: trace of the strain */
} sdr_model_field;

typedef struct sdr_model sdr_model;

/* Mark of a pair before the run, from both reference positions: SDR_CUT, SDR_PROTECTED
   (damage/laws.h) or 0; the same for a, b and b, a. */
typedef int (*sdr_pair_mark)(const void *context, const double a[3], const double b[3]);

/* A mark and what it is called with; mark NULL: no pair has one. may: 0 if no pair within the box
   low[3] .. high[3] has one. */
typedef struct {
  sdr_pair_mark mark;
  const void *context;
  int (*may)(const void *context, const double low[3], const double high[3]);
} sdr_pair_mark_of;

/* What is left of the pair of i and j: 1 whole, 0 lost; where halves differ, of the weaker. */
typedef void (*sdr_held_visitor)(void *context, int32_t i, int32_t j, double intact);

/* Part of the Hessian of the energy: `block` holds (count components)^2 values, row major, over the
   displacement components of `point`[0], then of point[1] and so on. */
typedef void (*sdr_hessian_visitor)(void *context, int count, const int32_t *point,
                                    const double *block);

/* What a model is made of and what it leaves out: for `check` and the summary. */
typedef struct {
  const char *name;       /* as in the scene: "bond_based" */
  const char *isa;        /* instruction set of its kernels */
  const sdr_bonds *bonds; /* the model's */
  int mixed;              /* 1: float kernels are at work */
  int shared_moduli;      /* 1: no coefficients a point */
  size_t history_bytes;
  double moved; /* share of the stripes that something has reached, in [0, 1] */
  /* Non-ordinary bodies, else 0: P_s and P_n of the first point, Pa, and the largest ratio of
     eigenvalues of a shape tensor. */
  double control_shear, control_normal, condition;
} sdr_model_traits;

/* u and f: `components` arrays of points->count values, readable up to sdr_points_padded (kernels
   read whole vectors). Unused components are NULL. */
typedef struct {
  const char *name;

  /* f = -d(energy)/du, with each bond's history the larger of the committed and the present one;
     changes nothing in the model. N. */
  void (*force)(sdr_model *model, double *const u[3], double *const f[3]);

  /* The same, and the history is committed as it goes (explicit schemes accept every step).
     v: velocity of the step that led to u and its length dt, so that u - dt v is the state before;
     critical stretch books what the scheme loses with it (theory sec. 4). */
  void (*force_commit)(sdr_model *model, double *const u[3], double *const v[3], double dt,
                       double *const f[3]);

  /* Accept u: damage history takes it in. */
  void (*commit)(sdr_model *model, double *const u[3]);

  /* Energies with history = max(committed, present). */
  void (*energies)(sdr_model *model, double *const u[3], sdr_energies *out);

  /* out = K v with the tangent K of the undeformed, undamaged body: for the stable step. */
  void (*reference_times)(sdr_model *model, double *const v[3], double *const out[3]);

  /* out = -d f/du v at u, exact away from kinks (theory sec. 4). N/m times m. */
  sdr_status (*tangent_times)(sdr_model *model, double *const u[3], double *const v[3],
                              double *const out[3]);

  /* Diagonal blocks of the tangent at u: components^2 values a point, row major. */
  sdr_status (*tangent_diagonal)(sdr_model *model, double *const u[3], double *out);

  /* A field over points: out holds points->count values per component, component-major. */
  sdr_status (*field)(sdr_model *model, double *const u[3], sdr_model_field which, double *out);

  /* Each unordered pair once, with the mean damage of its directed bonds (1: cut or broken). */
  void (*visit_damage)(sdr_model *model, double *const u[3],
                       void (*visit)(void *context, int32_t i, int32_t j, double damage),
                       void *context);

  /* Hand out the Hessian of the energy at u (the tangent, symmetric), in parts that sum up to it.
   */
  sdr_status (*visit_hessian)(sdr_model *model, double *const u[3], sdr_hessian_visitor visit,
                              void *context);

  /* The same of the secant stiffness: positive semidefinite, damage as it is at u, without what
     turning of the forces adds. It preconditions the tangent. NULL: the model has none. */
  sdr_status (*visit_secant)(sdr_model *model, double *const u[3], sdr_hessian_visitor visit,
                             void *context);

  /* Critical stretch under static loads: of the bonds that u stretches beyond their s0, lose those
     with s/s0 above `share` of the largest, and book their energy at u. Returns how many directed
     bonds are lost by this; 0: none is overstretched. NULL: the model breaks in commit only. */
  int64_t (*break_most)(sdr_model *model, double *const u[3], double share);

  /* Keep what products with the tangent at u take, for many of them: kept_times is tangent_times,
     kept_diagonal is tangent_diagonal at that u. In place of what mean_keep kept. NULL: the model
     keeps nothing. */
  sdr_status (*tangent_keep)(sdr_model *model, double *const u[3]);
  void (*kept_times)(sdr_model *model, double *const v[3], double *const out[3]);
  void (*kept_diagonal)(sdr_model *model, double *out);

  /* Mean force of a step from the committed state u0 to u1 (theory sec. 7): its work along u1 - u0
     is exactly minus what the energy, dissipated included, grows by, and it balances linear and
     angular momentum. Changes nothing in the model. NULL: the model has none. */
  void (*mean_force)(sdr_model *model, double *const u0[3], double *const u1[3],
                     double *const f[3]);
  /* The mean force, and what mean_times and mean_diagonal of the same step (u0, u1) need of it. */
  sdr_status (*mean_keep)(sdr_model *model, double *const u0[3], double *const u1[3],
                          double *const f[3]);
  /* out = -d(mean_force)/d(u1) v, exact away from kinks. N/m times m. */
  void (*mean_times)(sdr_model *model, double *const u0[3], double *const u1[3], double *const v[3],
                     double *const out[3]);
  /* Its diagonal blocks: components^2 values a point, row major. */
  void (*mean_diagonal)(sdr_model *model, double *const u0[3], double *const u1[3], double *out);
  /* -d(mean_force)/d(u1) in parts; not symmetric. */
  sdr_status (*visit_mean_tangent)(sdr_model *model, double *const u0[3], double *const u1[3],
                                   sdr_hessian_visitor visit, void *context);

  /* Mark all pairs; *cut_bonds: how many directed bonds are cut now. Before the first step only. */
  sdr_status (*mark)(sdr_model *model, sdr_pair_mark mark, const void *context, int64_t *cut_bonds);

  /* Whether stripes in which nothing has moved yet are skipped (they are at first): the answer has
     the same bits either way. A model that never skips ignores it. */
  void (*skip_rest)(sdr_model *model, int skip);

  /* Visit the pairs of stripe s that hold nothing any more, not even under compression: cut, or
     lost in each half; each once. NULL: the model loses none. */
  void (*visit_lost)(const sdr_model *model, int s, sdr_lost_visitor visit, void *context);

  /* What decides where points split: of each point the stored energy per volume (as
     SDR_FIELD_ENERGY_DENSITY; `energy` NULL: not asked for, which saves most of the work) and the
     damage without what was cut at the start. NULL if inherit is. */
  sdr_status (*split_state)(sdr_model *model, double *const u[3], double *energy, double *damage);
  /* Take over, after points have split, what `before` (a model of this kind) has: histories,
     energies booked. Pairs of points that split are marked as before a run. NULL: points of such a
     body cannot split. */
  sdr_status (*inherit)(sdr_model *model, const sdr_model *before, const sdr_point_map *map,
                        const sdr_pair_mark_of *mark);
  /* Visit every pair of the points i with at[i] != 0, from each such end: i is the chosen one. NULL
     if inherit is. */
  void (*visit_held)(const sdr_model *model, double *const u[3], const uint8_t *at,
                     sdr_held_visitor visit, void *context);

  void (*traits)(const sdr_model *model, sdr_model_traits *out);

  /* The blocks that a checkpoint must hold; *count <= SDR_STATE_BLOCKS. */
  void (*state)(sdr_model *model, sdr_state_block *blocks, int *count);

  void (*destroy)(sdr_model *model);
} sdr_model_ops;

/* The head of every model; concrete models have it as their first member. */
struct sdr_model {
  const sdr_model_ops *ops;
  const sdr_points *points;
  int64_t bonds;  /* directed, cut ones included */
  sdr_lost *lost; /* borrowed; force_commit and commit note pairs there that come to hold nothing;
                     NULL: nobody asks */
};

#endif
