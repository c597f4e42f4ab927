#include "nom/loose_lanes.h"

#include "base/memory.h"

#include <string.h>

/* Points are brought together by their number of pairs within so many neighbours in storage: more
   would spread what a chunk reads. */
enum { WINDOW = 256 };

typedef struct {
  const sdr_points *points;
  const int32_t *pairs;
  int32_t most;
  int32_t *start; /* scratch: most + 2 */
  int32_t window[WINDOW];
} lane_sorter;

/* Columns that chunks of so many points take, one after the other. */
static int64_t columns_of(const lane_sorter *sort, const int32_t *point, int32_t count)
{
  int64_t columns = 0;
  for (int32_t from = 0; from < count; from += SDR_LANES) {
    int32_t widest = 0;
    for (int32_t k = from; k < from + SDR_LANES && k < count; ++k)
      if (sort->pairs[point[k]] > widest) widest = sort->pairs[point[k]];
    columns += widest;
  }
  return columns;
}

/* Points with the most pairs first, equal ones as they stood; as it was where that saves less than
   one column in thirty. */
static void sort_window(lane_sorter *sort, int32_t *point, int32_t count)
{
  memset(sort->start, 0, ((size_t)sort->most + 2) * sizeof *sort->start);
  for (int32_t k = 0; k < count; ++k) ++sort->start[sort->most - sort->pairs[point[k]] + 1];
  for (int32_t p = 0; p < sort->most; ++p) sort->start[p + 1] += sort->start[p];
  for (int32_t k = 0; k < count; ++k)
    sort->window[sort->start[sort->most - sort->pairs[point[k]]]++] = point[k];
  const int64_t before = columns_of(sort, point, count);
  const int64_t after = columns_of(sort, sort->window, count);
  if (30 * (before - after) > before) memcpy(point, sort->window, (size_t)count * sizeof *point);
}

static int32_t most_pairs(const sdr_points *points, const int32_t *pairs)
{
  int32_t most = 0;
  for (int32_t i = 0; i < points->count; ++i)
    if (pairs[i] > most) most = pairs[i];
  return most;
}

/* ---- lanes ----------------------------------------------------------------------------------- */

static void take_in_order(const sdr_points *points, sdr_loose *loose)
{
  const int32_t *stripe = points->stripe_first;
  for (int32_t k = 0; k < SDR_LANES * loose->chunk_count; ++k) loose->point[k] = k;
  for (int s = 0; s <= points->stripe_count; ++s)
    loose->stripe_chunk[s] = (stripe[s] + SDR_LANES - 1) / SDR_LANES;
}

/* Points of each stripe that get a lane, in whole chunks. */
static void take_stripes(lane_sorter *sort, int all, sdr_loose *loose)
{
  const int32_t *stripe = sort->points->stripe_first;
  int32_t lanes = 0;
  for (int s = 0; s < sort->points->stripe_count; ++s) {
    const int32_t first = lanes;
    loose->stripe_chunk[s] = lanes / SDR_LANES;
    for (int32_t i = stripe[s]; i < stripe[s + 1]; ++i)
      if (all || sort->pairs[i] > 0) loose->point[lanes++] = i;
    for (int32_t k = first; k < lanes; k += WINDOW)
      sort_window(sort, loose->point + k, lanes - k < WINDOW ? lanes - k : WINDOW);
    for (; lanes % SDR_LANES != 0; ++lanes) loose->point[lanes] = loose->point[lanes - 1];
  }
  loose->stripe_chunk[sort->points->stripe_count] = loose->chunk_count = lanes / SDR_LANES;
}

/* Lanes that repeat a point are not its own. */
static void invert(const sdr_points *points, sdr_loose *loose)
{
  for (int32_t i = 0; i < points->count; ++i) loose->lane[i] = -1;
  for (int32_t k = SDR_LANES * loose->chunk_count - 1; k >= 0; --k)
    if (loose->point[k] < points->count) loose->lane[loose->point[k]] = k;
}

static sdr_status measure_chunks(const sdr_points *points, const int32_t *pairs, sdr_loose *loose)
{
  loose->chunk_slot = sdr_alloc((size_t)loose->chunk_count + 1, sizeof *loose->chunk_slot);
  if (!loose->chunk_slot) return SDR_RUN_FAILED;
  for (int32_t c = 0; c < loose->chunk_count; ++c) {
    int32_t widest = 0;
    for (int lane = 0; lane < SDR_LANES; ++lane) {
      const int32_t i = loose->point[c * SDR_LANES + lane];
      if (i < points->count && pairs[i] > widest) widest = pairs[i];
    }
    loose->chunk_slot[c + 1] = loose->chunk_slot[c] + SDR_LANES * (int64_t)widest;
  }
  loose->slot_count = loose->chunk_slot[loose->chunk_count];
  return SDR_OK;
}

sdr_status sdr_loose_lanes(const sdr_points *points, const int32_t *pairs, int in_order, int all,
                           sdr_loose *loose)
{
  const size_t count = (size_t)points->count, stripes = (size_t)points->stripe_count;
  lane_sorter sort = {.points = points, .pairs = pairs, .most = most_pairs(points, pairs)};
  const size_t at_most = count + SDR_LANES * stripes; /* a stripe's last chunk may be broken */
  loose->in_order = in_order;
  loose->chunk_count = (points->count + SDR_LANES - 1) / SDR_LANES;
  int failed = !(loose->point = sdr_alloc(at_most, sizeof *loose->point));
  failed |= !(loose->lane = sdr_alloc(count, sizeof *loose->lane));
  failed |= !(loose->stripe_chunk = sdr_alloc(stripes + 1, sizeof *loose->stripe_chunk));
  failed |= !(sort.start = sdr_alloc((size_t)sort.most + 2, sizeof *sort.start));
  if (!failed && in_order)
    take_in_order(points, loose);
  else if (!failed)
    take_stripes(&sort, all, loose);
  sdr_free(sort.start);
  if (failed) return SDR_RUN_FAILED;
  invert(points, loose);
  return measure_chunks(points, pairs, loose);
}
