/* Material points: component-major arrays in an order that kernels like. */
#ifndef SDR_NOM_POINTS_H
#define SDR_NOM_POINTS_H

#include "base/status.h"

#include <stddef.h>
#include <stdint.h>

/* Consecutive points of one lattice row: first .. first + length - 1, of one level and
   horizon, at the coordinates cell, cell + e, cell + 2 e, ... in the lattice of their level, with e
   the unit step along the points' row_axis. */
typedef struct {
  int32_t first, length;
  int32_t cell[3];
  int32_t level;
} sdr_row;

enum { SDR_NO_FAMILY = 0x80, SDR_LAYERS = 0x7f };

/* Owned points come first, ghosts (copies of another process's points; none on one machine) after
   them. Arrays are 64-byte aligned and padded with zeros to a multiple of 16 beyond `count + 15`:
   kernels read whole vectors. */
typedef struct {
  int32_t count;   /* owned points */
  int32_t ghosts;  /* 0 */
  int components;  /* 1, 2 or 3; unused components of x are NULL */
  double *x[3];    /* m, reference positions */
  double *volume;  /* m^3, thickness or area included */
  double *spacing; /* m */
  double *horizon; /* m */
  uint8_t *material;
  uint8_t *level; /* refinement level, 0 coarsest; NULL: all 0 */
  /* Fictitious points outside the body, that follow points of the body: 1 + the index of their
     layer, SDR_NO_FAMILY added where they have no family of their own (they stand in others'). 0:
     a point of the body. NULL: all are. */
  uint8_t *layer;
  int irregular;      /* 1: positions lie on no lattice of their own spacing (jittered, imported) */
  int32_t *generated; /* index in the order of generation; NULL: the same order. Random numbers are
                         drawn in that order, so that they do not depend on the storage order */

  /* On one lattice, or on nested ones that halve from level to level (no jitter), else row_count =
     0. The cells of level L have the size lattice_spacing / 2^L; a point lies in the middle of its
     cell c, at corner + sum over a of axes[a] (c_a + 1/2) size, with one corner for all levels, so
     that the children of c are 2 c + {0, 1} a component. Points of any level may lie anywhere; two
     points of a level never share a cell, and all of a level have the same volume. */
  int32_t *cell;          /* 3 a point; consumed (freed) by sdr_points_arrange */
  double lattice_spacing; /* of level 0 */
  double axes[3][3];      /* axes[a]: unit vector of lattice axis a; identity if not turned */
  int row_axis;
  int row_count;
  sdr_row *rows; /* in storage order; a row never crosses a stripe */

  /* Contiguous stripes of points; every bond that runs store joins a stripe to itself or to the
     next one. stripe k holds points stripe_first[k] .. stripe_first[k + 1] - 1. */
  int stripe_count;
  int32_t *stripe_first;
} sdr_points;

/* Allocate `count` points (>= 1) with `components` components; `lattice` != 0 gives `cell` too.
   All values are zero, axes the identity. The caller fills them in, then calls
   sdr_points_arrange. Owner: the caller, who destroys. */
sdr_status sdr_points_create(int32_t count, int components, int lattice, sdr_points **out);
void sdr_points_destroy(sdr_points **points); /* NULL-safe */

/* Elements that an array over the points must hold: owned and ghosts, padded with whole lanes. */
size_t sdr_points_padded(const sdr_points *points);

/* Bring the points into storage order (lattices: slab by slab, in a slab level by level, in a level
   row by row; else along a space-filling curve), set `generated`, rows and stripes. Needs x and
   horizon, and on a lattice cell and, where some point is not of level 0, level. */
sdr_status sdr_points_arrange(sdr_points *points);

/* 1 if point i is one of the body, not of a layer outside it. */
static inline int sdr_in_body(const sdr_points *points, int32_t i)
{
  return !points->layer || points->layer[i] == 0;
}

/* 1 if point i has a family of its own. */
static inline int sdr_has_family(const sdr_points *points, int32_t i)
{
  return !points->layer || !(points->layer[i] & SDR_NO_FAMILY);
}

/* Index of the body's point nearest to at[3]; ties go to the lowest generated index. Linear
   search. */
int32_t sdr_points_nearest(const sdr_points *points, const double at[3]);

#endif
