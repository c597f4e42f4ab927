#include "nom/own_share.h"

#include <string.h>

/* Weights hold both volumes: share[] sums b |xi| V_i V_j. */
static void add_run(const sdr_bonds *bonds, const sdr_bond_run *run, double *share)
{
  const sdr_bond_class *class = &bonds->classes[run->class_index];
  const double at_i = class->weight_ij * class->length, at_j = class->weight_ji * class->length;
  for (int32_t k = 0; k < run->length; ++k) share[run->i0 + k] += at_i;
  for (int32_t k = 0; k < run->length; ++k) share[run->j0 + k] += at_j;
}

static void add_loose(void *context, const sdr_pair *pair)
{
  double *share = context;
  share[pair->i] += pair->weight_ij * pair->length;
}

void sdr_own_shares(const sdr_bonds *bonds, const sdr_families *families, double *share)
{
  const sdr_points *points = families->points;
  memset(share, 0, (size_t)points->count * sizeof *share);
  for (int64_t r = 0; r < bonds->run_count; ++r) add_run(bonds, &bonds->runs[r], share);
  if (bonds->loose.chunk_count > 0)
    for (int32_t i = 0; i < points->count; ++i)
      sdr_bonds_visit_loose_point(bonds, i, add_loose, share);
  for (int32_t i = 0; i < points->count; ++i)
    share[i] /= points->volume[i] * sdr_family_of(families, i)->moment;
}
