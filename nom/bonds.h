/* Bonds as unordered pairs, each once, with both ends' weights: runs on lattices, loose elsewhere.
   Design sec. 2; theory sec. 1. Nothing here knows damage: histories are arrays over slots that
   others own. */
#ifndef SDR_NOM_BONDS_H
#define SDR_NOM_BONDS_H

#include "nom/points.h"

/* What all pairs of a run share. weight_ij = b_ij V_i V_j if j in H_i, else 0; weight_ji likewise
   (m^6; b the bond's weight in its owner's family). */
typedef struct {
  double xi[3]; /* X_j - X_i, m */
  double length;
  double weight_ij, weight_ji;
  double inverse_square;             /* 1/length^2 */
  double by_length_ij, by_length_ji; /* weights over length */
} sdr_bond_class;

/* The pairs (i0 + k, j0 + k), 0 <= k < length; pair k has the slot `slot` + k. */
typedef struct {
  int32_t class_index, i0, j0, length;
  int64_t slot;
} sdr_bond_run;

enum { SDR_LANES = 8 };

/* Loose pairs, by both of their points: chunk c has eight lanes, 8 c .. 8 c + 7, a point each, and
   the slots chunk_slot[c] .. chunk_slot[c + 1] - 1, a column of eight after the other, one of each
   lane: a lane has as many as the one with the most neighbours. A pair {i, j} so has two slots, one
   in i's lane, one in j's. Padding has j = i, weights 0 and xi = (1, 0, 0). Only points with a
   loose pair have a lane; points with equally many share chunks; a chunk has points of one stripe.
   Lanes that are left over repeat the point before and are all padding, so that adding to it what
   they sum to, 0, does nothing. */
typedef struct {
  int32_t chunk_count; /* 0: no loose pairs */
  int64_t *chunk_slot; /* chunk_count + 1 */
  int64_t slot_count;
  int32_t *point;        /* of a lane */
  int32_t *lane;         /* of a point; -1: none */
  int32_t *stripe_chunk; /* stripe_count + 1: stripe s has chunks [stripe_chunk[s], ... [s + 1]) */
  int in_order;          /* see sdr_bonds_how */
  int32_t *j;
  double *xi[3];
  double *weight_ij, *weight_ji; /* of the lane's point i and the neighbour j */
  double shared_weight;          /* both weights of every pair (not of padding); 0: they differ */
} sdr_loose;

typedef struct {
  int components;
  int class_count;
  sdr_bond_class *classes;
  int64_t run_count;
  sdr_bond_run *runs;  /* by stripe, then in storage order of their rows */
  int64_t *stripe_run; /* stripe_count + 1: stripe s owns runs [stripe_run[s], stripe_run[s+1]) */
  int64_t run_slots;   /* slots of runs; loose slots are numbered from 0 again */
  sdr_loose loose;
  int64_t directed; /* sum over i of |H_i| */
  int64_t pairs;    /* unordered pairs, runs and loose */
  int64_t loose_pairs;
  int one_sided; /* see sdr_bonds_how: a loose pair outside one of the families has one slot */
} sdr_bonds;

/* How the bonds are to be made. */
typedef struct {
  int force_loose; /* 1: no runs even on a lattice (tests) */
  /* 1: lane i of the loose pairs is point i, whether it has one or not, and the lanes beyond the
     last point are padding; a chunk belongs to the stripe that it begins in */
  int in_order;
  /* 1: runs within each level of nested lattices, for who asks a class for nothing but what it
     holds; 0: runs only if all points have one level and one horizon */
  int levels;
  /* Weight b of the bond i -> j in the family of i; NULL: 1. For points on a lattice it is asked
     once per class, with i and j two points of that class. `xi` has 3 entries. */
  double (*weight)(const void *context, int32_t i, int32_t j, const double xi[3]);
  const void *context;
  /* A point: runs join points with 1 here only, other pairs are loose; NULL: all points. So a
     weight may depend on more than xi at the others. */
  const uint8_t *bulk;
  /* A point: pairs of two points with 1 here are loose, since their weights depend on more than xi;
     NULL: none. */
  const uint8_t *border;
  /* 1: no dual horizon: i interacts with its own H_i only, as without the other half of a bond
     whose ends have different horizons. Momentum is not kept: to show ghost forces. */
  int one_sided;
} sdr_bonds_how;

/* Make all bonds of the arranged points. Ties |xi| = horizon count as inside (theory sec. 1).
   A body without any bond is SDR_BAD_INPUT. Owner: the caller. */
sdr_status sdr_bonds_create(const sdr_points *points, const sdr_bonds_how *how, sdr_bonds **out);
void sdr_bonds_destroy(sdr_bonds **bonds); /* NULL-safe */

/* One slot, for whoever walks over them. */
typedef struct {
  int32_t i, j;
  int64_t slot;
  int loose;   /* which slot numbering */
  int primary; /* 1 for one slot of each unordered pair: all of runs; loose with i < j, or with
                  the only slot there is */
  double xi[3];
  double length;
  double weight_ij, weight_ji;
} sdr_pair;

typedef void (*sdr_pair_visitor)(void *context, const sdr_pair *pair);

/* Visit the slots of stripe s (runs of the stripe, then loose slots of its points), in a fixed
   order. Padding is not visited. */
void sdr_bonds_visit_stripe(const sdr_bonds *bonds, const sdr_points *points, int s,
                            sdr_pair_visitor visit, void *context);
/* The pairs of one run. */
void sdr_bonds_visit_run(const sdr_bonds *bonds, const sdr_bond_run *run, sdr_pair_visitor visit,
                         void *context);
/* Slots of point i: *first, *first + SDR_LANES, ... below the returned end (there must be loose
   pairs). */
static inline int64_t sdr_loose_slots(const sdr_loose *loose, int32_t i, int64_t *first)
{
  const int32_t lane = loose->lane[i];
  *first = 0;
  if (lane < 0) return 0;
  *first = loose->chunk_slot[lane / SDR_LANES] + lane % SDR_LANES;
  return loose->chunk_slot[lane / SDR_LANES + 1];
}
/* The loose slots of point i (there must be loose pairs). */
void sdr_bonds_visit_loose_point(const sdr_bonds *bonds, int32_t i, sdr_pair_visitor visit,
                                 void *context);
/* All stripes in order. */
void sdr_bonds_visit(const sdr_bonds *bonds, const sdr_points *points, sdr_pair_visitor visit,
                     void *context);

#endif
