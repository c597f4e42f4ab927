/* Points of nested lattices in groups whose bonds can lie on runs: one level, one horizon. */
#ifndef SDR_NOM_LATTICE_GROUPS_H
#define SDR_NOM_LATTICE_GROUPS_H

#include "nom/bonds.h"

enum { SDR_MOST_GROUPS = 64 };

typedef struct {
  int level;
  double spacing, horizon;
} sdr_lattice_group;

typedef struct {
  int count;
  sdr_lattice_group group[SDR_MOST_GROUPS];
  uint8_t *of_row;       /* 1 + the group of each row; 0: all its bonds are loose */
  uint8_t *of_point;     /* the same of each point */
  const uint8_t *border; /* of sdr_bonds_how, borrowed */
  int whole;             /* 1: all points are in one group, so that no bond is loose */
  int ragged;            /* 1: some row in a group has points that are not */
} sdr_lattice_groups;

/* The groups of arranged points that have rows. Points without a family, those that how->bulk
   leaves out, and those of rows too short to pay are in none; without how->levels no point is,
   unless all have one level and horizon. */
sdr_status sdr_lattice_groups_create(const sdr_points *points, const sdr_bonds_how *how,
                                     sdr_lattice_groups *out);
void sdr_lattice_groups_destroy(sdr_lattice_groups *groups);

/* 1 if runs hold the bond between two points, should they have one. */
static inline int sdr_on_run(const sdr_lattice_groups *groups, int32_t i, int32_t j)
{
  if (groups->border && groups->border[i] && groups->border[j]) return 0;
  return groups->of_point[i] != 0 && groups->of_point[i] == groups->of_point[j];
}

#endif
