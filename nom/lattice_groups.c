#include "nom/lattice_groups.h"

#include "base/memory.h"

#include <math.h>

/* A run costs about as much as this many loose pairs. Bodies of one lattice keep shorter ones, so
   that they have no loose pair. */
enum { LEAST_ROW = 4 };

static int same_group(const sdr_points *points, const sdr_row *row, const sdr_lattice_group *group)
{
  return row->level == group->level && points->horizon[row->first] == group->horizon;
}

/* 1 + the group of a row, made if it is new; 0 if there are too many. */
static int group_of(const sdr_points *points, const sdr_row *row, sdr_lattice_groups *groups)
{
  for (int g = 0; g < groups->count; ++g)
    if (same_group(points, row, &groups->group[g])) return g + 1;
  if (groups->count == SDR_MOST_GROUPS) return 0;
  groups->group[groups->count++] =
      (sdr_lattice_group){.level = row->level,
                          .spacing = ldexp(points->lattice_spacing, -row->level),
                          .horizon = points->horizon[row->first]};
  return groups->count;
}

static int is_one_lattice(const sdr_points *points)
{
  const sdr_row *rows = points->rows;
  for (int r = 1; r < points->row_count; ++r)
    if (rows[r].level != rows[0].level ||
        points->horizon[rows[r].first] != points->horizon[rows[0].first])
      return 0;
  return points->row_count > 0;
}

/* Put the points of a row that may be on runs into its group; returns how many they are. */
static int32_t fill_row(const sdr_points *points, const sdr_bonds_how *how, const sdr_row *row,
                        uint8_t group, uint8_t *of_point)
{
  int32_t in = 0;
  for (int32_t i = row->first; i < row->first + row->length; ++i) {
    if (!sdr_has_family(points, i) || (how->bulk && !how->bulk[i])) continue;
    of_point[i] = group;
    ++in;
  }
  return in;
}

static void fill_groups(const sdr_points *points, const sdr_bonds_how *how,
                        sdr_lattice_groups *groups)
{
  const int one = is_one_lattice(points);
  int32_t inside = 0;
  if (!one && !how->levels) return;
  for (int r = 0; r < points->row_count; ++r) {
    const sdr_row *row = &points->rows[r];
    if (!one && row->length < LEAST_ROW) continue;
    const uint8_t group = (uint8_t)group_of(points, row, groups);
    const int32_t in = group ? fill_row(points, how, row, group, groups->of_point) : 0;
    groups->of_row[r] = in > 0 ? group : 0;
    groups->ragged |= in > 0 && in < row->length;
    inside += in;
  }
  groups->ragged |= how->border != NULL;
  groups->whole = one && inside == points->count && !how->border;
}

sdr_status sdr_lattice_groups_create(const sdr_points *points, const sdr_bonds_how *how,
                                     sdr_lattice_groups *out)
{
  sdr_lattice_groups groups = {
      .border = how->border,
      .of_row = sdr_alloc((size_t)points->row_count, sizeof *groups.of_row),
      .of_point = sdr_alloc(sdr_points_padded(points), sizeof *groups.of_point)};
  if (!groups.of_row || !groups.of_point) {
    sdr_lattice_groups_destroy(&groups);
    return SDR_RUN_FAILED;
  }
  fill_groups(points, how, &groups);
  *out = groups;
  return SDR_OK;
}

void sdr_lattice_groups_destroy(sdr_lattice_groups *groups)
{
  sdr_free(groups->of_row);
  sdr_free(groups->of_point);
  *groups = (sdr_lattice_groups){0};
}
