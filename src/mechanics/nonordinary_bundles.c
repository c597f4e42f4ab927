/* The bonds of runs by blocks of eight points, as the kernels take them. */
#include "base/memory.h"
#include "mechanics/nonordinary_internal.h"

#include <stdlib.h>
#include <string.h>

/* ---- directions ------------------------------------------------------------------------------ */

static sdr_direction direction_of(const sdr_bond_class *class, int n, int side)
{
  sdr_direction d = {.by_square = class->inverse_square};
  int k = 0;
  d.own = side ? class->weight_ji : class->weight_ij;
  for (int a = 0; a < n; ++a) {
    d.xi[a] = side ? -class->xi[a] : class->xi[a];
    d.own_xi[a] = d.own * d.xi[a];
    d.along_xi[a] = d.own_xi[a] * d.by_square;
  }
  for (int a = 0; a < n; ++a)
    for (int b = a; b < n; ++b) {
      d.own_normal[k] = d.own_xi[a] * d.xi[b] * d.by_square;
      d.twice[k++] = (a == b ? 1.0 : 2.0) * d.xi[a] * d.xi[b];
    }
  return d;
}

/* ---- blocks ---------------------------------------------------------------------------------- */

/* Counts bundles, or writes them where a block's next one goes. */
typedef struct {
  sdr_block_bundles *blocks;
  sdr_bundle *bundles; /* NULL: count */
} bundle_list;

static void add_side(const bundle_list *list, const sdr_bond_run *run, int32_t index, int side)
{
  const int32_t from = side ? run->j0 : run->i0, to = side ? run->i0 : run->j0;
  const int32_t end = from + run->length;
  for (int32_t b = from / SDR_LANES; b <= (end - 1) / SDR_LANES; ++b) {
    sdr_block_bundles *block = &list->blocks[b];
    const int32_t start = SDR_LANES * b, low = from > start ? from - start : 0;
    const int32_t high = end < start + SDR_LANES ? end - start : SDR_LANES;
    if (list->bundles)
      list->bundles[block->first + block->count] =
          (sdr_bundle){.offset = to - from,
                       .run = index,
                       .direction = 2 * run->class_index + side,
                       .lanes = (1 << high) - (1 << low)};
    ++block->count;
  }
}

static void add_runs(const sdr_bonds *bonds, const bundle_list *list)
{
  for (int64_t r = 0; r < bonds->run_count; ++r)
    for (int side = 0; side < 2; ++side) add_side(list, &bonds->runs[r], (int32_t)r, side);
}

/* By the shift along rows, then in the order of runs: bundles that lead to the same row lie apart,
   so that a force is stored before it is read again. */
static int by_shift(const void *left, const void *right, void *context)
{
  const sdr_nonordinary_body *body = context;
  const sdr_bundle *a = left, *b = right;
  const int axis = body->points->row_axis;
  const double x = body->directions[a->direction].xi[axis];
  const double y = body->directions[b->direction].xi[axis];
  if (x != y) return x < y ? -1 : 1;
  return a->run != b->run ? (a->run < b->run ? -1 : 1) : a->direction - b->direction;
}

/* Blocks with the same bundles as the one before take that one's; returns how many are left. */
static int64_t share(sdr_block_bundles *blocks, int64_t count, sdr_bundle *bundles)
{
  int64_t used = 0;
  for (int64_t b = 0; b < count; ++b) {
    sdr_block_bundles *block = &blocks[b], *before = b > 0 ? block - 1 : NULL;
    const size_t size = (size_t)block->count * sizeof *bundles;
    if (before && before->count == block->count &&
        memcmp(bundles + before->first, bundles + block->first, size) == 0) {
      block->first = before->first;
      continue;
    }
    memmove(bundles + used, bundles + block->first, size);
    block->first = used;
    used += block->count;
  }
  return used;
}

/* One allocation for all bundles, then one for those that are left. */
static sdr_status make_bundles(sdr_nonordinary_body *body, int64_t count)
{
  const sdr_bonds *bonds = body->bonds;
  bundle_list list = {body->blocks, NULL};
  int64_t total = 0;
  add_runs(bonds, &list);
  for (int64_t b = 0; b < count; ++b) {
    body->blocks[b].first = total;
    total += body->blocks[b].count;
    body->blocks[b].count = 0;
  }
  list.bundles = sdr_alloc((size_t)total + 1, sizeof *list.bundles);
  if (!list.bundles) return SDR_RUN_FAILED;
  add_runs(bonds, &list);
  for (int64_t b = 0; b < count; ++b)
    qsort_r(list.bundles + body->blocks[b].first, (size_t)body->blocks[b].count,
            sizeof *list.bundles, by_shift, body);
  const int64_t used = share(body->blocks, count, list.bundles);
  body->bundles = sdr_alloc((size_t)used + 1, sizeof *body->bundles);
  if (body->bundles) memcpy(body->bundles, list.bundles, (size_t)used * sizeof *list.bundles);
  sdr_free(list.bundles);
  return body->bundles ? SDR_OK : SDR_RUN_FAILED;
}

/* 1 if loose pairs join points of one stripe or of two neighbours, as runs do. */
static int is_local(const sdr_points *points, const sdr_loose *loose)
{
  const int32_t *stripe = points->stripe_first;
  for (int s = 0; loose->chunk_count > 0 && s < points->stripe_count; ++s) {
    const int32_t low = stripe[s > 0 ? s - 1 : 0];
    const int32_t high = stripe[s + 2 < points->stripe_count ? s + 2 : points->stripe_count];
    for (int32_t i = stripe[s]; i < stripe[s + 1]; ++i) {
      const int64_t chunk = i / SDR_LANES, end = loose->chunk_slot[chunk + 1];
      for (int64_t k = loose->chunk_slot[chunk] + i % SDR_LANES; k < end; k += SDR_LANES)
        if (loose->j[k] < low || loose->j[k] >= high) return 0;
    }
  }
  return 1;
}

sdr_status sdr_nonordinary_bundles(sdr_nonordinary_model *model)
{
  sdr_nonordinary_body *body = &model->body;
  const sdr_bonds *bonds = body->bonds;
  const int64_t count = (int64_t)sdr_points_padded(body->points) / SDR_LANES;
  body->blocks = sdr_alloc((size_t)count, sizeof *body->blocks);
  body->directions = sdr_alloc(2 * (size_t)bonds->class_count + 1, sizeof *body->directions);
  if (!body->blocks || !body->directions) return SDR_RUN_FAILED;
  for (int c = 0; c < bonds->class_count; ++c)
    for (int side = 0; side < 2; ++side)
      body->directions[2 * c + side] =
          direction_of(&bonds->classes[c], body->points->components, side);
  model->local = is_local(body->points, &bonds->loose);
  return make_bundles(body, count);
}
