/* Bodies to measure on: a ring in plane stress and a cube, in motion, with points and bonds stored
   in the ways that are to be compared. */
#ifndef SDR_BENCH_BODY_H
#define SDR_BENCH_BODY_H

#include "mechanics/bond_internal.h"
#include "mechanics/system.h"

typedef struct {
  int dimension;        /* 2: the thick cylinder's ring; 3: a cube */
  double spacing;       /* m; of the cube: 1 mm whatever is given here */
  int edge;             /* points along an edge of the cube */
  sdr_model_kind model; /* SDR_BOND_BASED if not said */
  sdr_law law;
  int scattered; /* 1: every point has its own modulus */
  int shuffled; /* 1: points come in random order, without lattice, and are sorted by the library */
  int loose;    /* 1: no runs */
  int layer;    /* 1: the ring as one layer of a body in three components */
  int mixed;    /* 1: forces of runs in float arithmetic */
} bench_how;

typedef struct {
  sdr_points *points;
  sdr_families *families;
  sdr_model *model;
  sdr_loads *loads;       /* none */
  sdr_supports *supports; /* none */
  sdr_system *system;
  double step;       /* s, a stable one */
  int32_t *original; /* of each point: its index in the body that is not shuffled; NULL: the same */
} bench_body;

/* Build a body with displacements of a few spacings' wave length that strain its bonds to a tenth
   of what breaks them; force computed, ready to step. Owner: the caller. */
sdr_status bench_body_create(const bench_how *how, bench_body *out);
void bench_body_destroy(bench_body *body);

/* Put the displacements of the start back, velocities to zero, and compute the force. */
sdr_status bench_body_restart(bench_body *body);

/* Take the damage back that the start has left in the model. */
void bench_body_forget(bench_body *body);

/* A permutation of 0 .. count - 1, the same every time. Caller: sdr_free. NULL: out of memory. */
int32_t *bench_shuffle(int32_t count);

#endif
