#include "nom/loose_pairs.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "nom/loose_lanes.h"
#include "nom/neighbourhood.h"

#include <string.h>

enum { BLOCK = 128 }; /* chunks a task */

/* H_i and, where horizons differ, the dual-only neighbours {j : i in H_j, j not in H_i}. */
typedef struct {
  const sdr_points *points;
  const sdr_bonds_how *how;
  sdr_neighbourhood family, dual_only;
  sdr_loose *loose;
} loose_builder;

/* Visit all (j, i) with i in H_j but j not in H_i: count into row[i + 1], or place j. */
static void each_dual_only(const loose_builder *build, int64_t *row, int64_t *cursor,
                           int32_t *column)
{
  for (int32_t j = 0; j < build->points->count; ++j)
    for (int64_t k = build->family.row[j]; k < build->family.row[j + 1]; ++k) {
      const int32_t i = build->family.column[k];
      if (sdr_in_horizon(build->points, i, sdr_distance_squared(build->points, i, j))) continue;
      if (column)
        column[cursor[i]++] = j;
      else
        ++row[i + 1];
    }
}

static sdr_status find_dual_only(loose_builder *build)
{
  const size_t count = (size_t)build->points->count;
  sdr_neighbourhood *dual = &build->dual_only;
  dual->row = sdr_alloc(count + 1, sizeof *dual->row);
  if (!dual->row) return SDR_RUN_FAILED;
  each_dual_only(build, dual->row, NULL, NULL);
  for (size_t i = 0; i < count; ++i) dual->row[i + 1] += dual->row[i];
  dual->column = sdr_alloc((size_t)dual->row[count], sizeof *dual->column);
  int64_t *cursor = sdr_alloc(count, sizeof *cursor);
  if (dual->column && cursor) {
    memcpy(cursor, dual->row, count * sizeof *cursor);
    each_dual_only(build, NULL, cursor, dual->column);
  }
  sdr_free(cursor);
  return dual->column && cursor ? SDR_OK : SDR_RUN_FAILED;
}

/* Without the dual horizon a point knows its own family only. */
static void forget_dual_only(loose_builder *build)
{
  const size_t count = (size_t)build->points->count;
  memset(build->dual_only.row, 0, (count + 1) * sizeof *build->dual_only.row);
}

static int32_t degree(const loose_builder *build, int32_t i)
{
  return (int32_t)(build->family.row[i + 1] - build->family.row[i] + build->dual_only.row[i + 1] -
                   build->dual_only.row[i]);
}

static sdr_status size_chunks(const loose_builder *build)
{
  sdr_loose *loose = build->loose;
  const int32_t count = build->points->count;
  int32_t *pairs = sdr_alloc((size_t)count, sizeof *pairs);
  for (int32_t i = 0; pairs && i < count; ++i) pairs[i] = degree(build, i);
  /* One-sided: a point may be a neighbour and have none. */
  const sdr_status status = pairs ? sdr_loose_lanes(build->points, pairs, build->how->in_order,
                                                    build->how->one_sided, loose)
                                  : SDR_RUN_FAILED;
  sdr_free(pairs);
  SDR_TRY(status);
  const size_t slots = (size_t)loose->slot_count;
  int failed = !(loose->j = sdr_alloc(slots, sizeof *loose->j));
  for (int a = 0; a < build->points->components; ++a)
    failed |= !(loose->xi[a] = sdr_alloc(slots, sizeof(double)));
  failed |= !(loose->weight_ij = sdr_alloc(slots, sizeof(double)));
  failed |= !(loose->weight_ji = sdr_alloc(slots, sizeof(double)));
  return failed ? SDR_RUN_FAILED : SDR_OK;
}

static void fill_slot(const loose_builder *build, int64_t slot, int32_t i, int32_t j, int in_h_i)
{
  const sdr_points *points = build->points;
  const sdr_bonds_how *how = build->how;
  sdr_loose *loose = build->loose;
  double xi[3] = {0.0}, back[3] = {0.0};
  for (int a = 0; a < points->components; ++a) {
    loose->xi[a][slot] = xi[a] = points->x[a][j] - points->x[a][i];
    back[a] = -xi[a];
  }
  const int in_h_j = sdr_in_horizon(points, j, sdr_distance_squared(points, i, j));
  const double volumes = points->volume[i] * points->volume[j];
  loose->j[slot] = j;
  if (in_h_i)
    loose->weight_ij[slot] = volumes * (how->weight ? how->weight(how->context, i, j, xi) : 1.0);
  if (in_h_j)
    loose->weight_ji[slot] = volumes * (how->weight ? how->weight(how->context, j, i, back) : 1.0);
}

static void fill_lane(const loose_builder *build, int32_t lane, int64_t slot, int64_t end)
{
  const sdr_neighbourhood *family = &build->family, *dual = &build->dual_only;
  const int32_t i = build->loose->point[lane];
  if (i < build->points->count && build->loose->lane[i] == lane) {
    for (int64_t k = family->row[i]; k < family->row[i + 1]; ++k, slot += SDR_LANES)
      fill_slot(build, slot, i, family->column[k], 1);
    for (int64_t k = dual->row[i]; k < dual->row[i + 1]; ++k, slot += SDR_LANES)
      fill_slot(build, slot, i, dual->column[k], 0);
  }
  for (; slot < end; slot += SDR_LANES) { /* padding */
    build->loose->j[slot] = i;
    build->loose->xi[0][slot] = 1.0;
  }
}

static void fill_block(void *context, int block)
{
  const loose_builder *build = context;
  const sdr_loose *loose = build->loose;
  for (int32_t c = block * BLOCK; c < (block + 1) * BLOCK && c < loose->chunk_count; ++c)
    for (int32_t lane = 0; lane < SDR_LANES; ++lane)
      fill_lane(build, c * SDR_LANES + lane, loose->chunk_slot[c] + lane, loose->chunk_slot[c + 1]);
}

/* The weight that all pairs have both ways; 0 if they differ. */
static double shared_weight(const sdr_loose *loose)
{
  double shared = 0.0;
  for (int32_t c = 0; c < loose->chunk_count; ++c)
    for (int64_t slot = loose->chunk_slot[c]; slot < loose->chunk_slot[c + 1]; ++slot) {
      const double wij = loose->weight_ij[slot], wji = loose->weight_ji[slot];
      if (loose->j[slot] == loose->point[c * SDR_LANES + slot % SDR_LANES]) continue; /* padding */
      if (shared == 0.0) shared = wij;
      if (wij != shared || wji != shared) return 0.0;
    }
  return shared;
}

sdr_status sdr_loose_pairs(const sdr_points *points, const sdr_bonds_how *how,
                           const sdr_lattice_groups *groups, sdr_bonds *bonds)
{
  loose_builder build = {.points = points, .how = how, .loose = &bonds->loose};
  int64_t one_sided = 0; /* pairs outside one of the families */
  sdr_status status = sdr_neighbourhood_beside(points, groups, &build.family);
  if (status == SDR_OK) status = find_dual_only(&build);
  if (status == SDR_OK) {
    one_sided = build.dual_only.row[points->count];
    if (how->one_sided) forget_dual_only(&build);
    status = size_chunks(&build);
  }
  if (status == SDR_OK) {
    sdr_parallel_for(0, (bonds->loose.chunk_count + BLOCK - 1) / BLOCK, 1, fill_block, &build);
    bonds->loose.shared_weight = shared_weight(&bonds->loose);
    const int64_t directed = build.family.row[points->count];
    bonds->directed += directed;
    bonds->loose_pairs = (directed + one_sided) / 2; /* each counted twice */
    bonds->pairs += bonds->loose_pairs;
  }
  sdr_neighbourhood_destroy(&build.family);
  sdr_neighbourhood_destroy(&build.dual_only);
  return status;
}
