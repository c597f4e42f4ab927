#include "nom/bonds.h"

#include "base/memory.h"
#include "nom/lattice_runs.h"
#include "nom/loose_pairs.h"

#include <math.h>

static sdr_status make_bonds(const sdr_points *points, const sdr_bonds_how *how, sdr_bonds *bonds)
{
  if (points->row_count == 0 || how->force_loose) return sdr_loose_pairs(points, how, NULL, bonds);
  sdr_lattice_groups groups;
  SDR_TRY(sdr_lattice_groups_create(points, how, &groups));
  sdr_status status = SDR_OK;
  if (groups.count > 0) status = sdr_lattice_runs(points, how, &groups, bonds);
  if (status == SDR_OK && !groups.whole)
    status = sdr_loose_pairs(points, how, groups.count > 0 ? &groups : NULL, bonds);
  sdr_lattice_groups_destroy(&groups);
  return status;
}

sdr_status sdr_bonds_create(const sdr_points *points, const sdr_bonds_how *how, sdr_bonds **out)
{
  sdr_bonds *bonds = sdr_alloc(1, sizeof *bonds);
  if (!bonds) return SDR_RUN_FAILED;
  bonds->components = points->components;
  bonds->stripe_run = sdr_alloc((size_t)points->stripe_count + 1, sizeof *bonds->stripe_run);
  sdr_status status = bonds->stripe_run ? SDR_OK : SDR_RUN_FAILED;
  bonds->one_sided = how->one_sided;
  if (status == SDR_OK) status = make_bonds(points, how, bonds);
  if (status == SDR_OK && bonds->pairs == 0)
    status = sdr_fail(SDR_BAD_INPUT, "no two points are within a horizon of each other, so the "
                                     "body has no bond; enlarge the horizon or the body");
  if (status != SDR_OK) {
    sdr_bonds_destroy(&bonds);
    return status;
  }
  *out = bonds;
  return SDR_OK;
}

void sdr_bonds_destroy(sdr_bonds **bonds)
{
  sdr_bonds *b = *bonds;
  if (!b) return;
  sdr_free(b->classes);
  sdr_free(b->runs);
  sdr_free(b->stripe_run);
  sdr_free(b->loose.chunk_slot);
  sdr_free(b->loose.point);
  sdr_free(b->loose.lane);
  sdr_free(b->loose.stripe_chunk);
  sdr_free(b->loose.j);
  for (int a = 0; a < 3; ++a) sdr_free(b->loose.xi[a]);
  sdr_free(b->loose.weight_ij);
  sdr_free(b->loose.weight_ji);
  sdr_free(b);
  *bonds = NULL;
}

void sdr_bonds_visit_run(const sdr_bonds *bonds, const sdr_bond_run *run, sdr_pair_visitor visit,
                         void *context)
{
  const sdr_bond_class *class = &bonds->classes[run->class_index];
  sdr_pair pair = {.primary = 1,
                   .xi = {class->xi[0], class->xi[1], class->xi[2]},
                   .length = class->length,
                   .weight_ij = class->weight_ij,
                   .weight_ji = class->weight_ji};
  for (int32_t k = 0; k < run->length; ++k) {
    pair.i = run->i0 + k;
    pair.j = run->j0 + k;
    pair.slot = run->slot + k;
    visit(context, &pair);
  }
}

void sdr_bonds_visit_loose_point(const sdr_bonds *bonds, int32_t i, sdr_pair_visitor visit,
                                 void *context)
{
  const sdr_loose *loose = &bonds->loose;
  int64_t slot;
  for (const int64_t end = sdr_loose_slots(loose, i, &slot); slot < end; slot += SDR_LANES) {
    if (loose->j[slot] == i) continue; /* padding */
    sdr_pair pair = {.i = i,
                     .j = loose->j[slot],
                     .slot = slot,
                     .loose = 1,
                     .primary =
                         (bonds->one_sided && loose->weight_ji[slot] == 0.0) || i < loose->j[slot],
                     .weight_ij = loose->weight_ij[slot],
                     .weight_ji = loose->weight_ji[slot]};
    double square = 0.0;
    for (int a = 0; a < bonds->components; ++a) {
      pair.xi[a] = loose->xi[a][slot];
      square += pair.xi[a] * pair.xi[a];
    }
    pair.length = sqrt(square);
    visit(context, &pair);
  }
}

void sdr_bonds_visit_stripe(const sdr_bonds *bonds, const sdr_points *points, int s,
                            sdr_pair_visitor visit, void *context)
{
  for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r)
    sdr_bonds_visit_run(bonds, &bonds->runs[r], visit, context);
  if (bonds->loose.chunk_count > 0)
    for (int32_t i = points->stripe_first[s]; i < points->stripe_first[s + 1]; ++i)
      sdr_bonds_visit_loose_point(bonds, i, visit, context);
}

void sdr_bonds_visit(const sdr_bonds *bonds, const sdr_points *points, sdr_pair_visitor visit,
                     void *context)
{
  for (int s = 0; s < points->stripe_count; ++s)
    sdr_bonds_visit_stripe(bonds, points, s, visit, context);
}
