/* Who may touch whom: exposed points in cells, and what bonds have lost. */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/contact_internal.h"
#include "nom/cells.h"
#include "nom/neighbourhood.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double sdr_contact_reach(const sdr_contact *contact, int32_t i, int32_t j, double reference_square)
{
  const sdr_points *points = contact->points;
  const double range = 0.5 * contact->range * (points->spacing[i] + points->spacing[j]);
  return range * range < reference_square ? range : sqrt(reference_square);
}

/* ---- spots ----------------------------------------------------------------------------------- */

/* A block grown by half again, at least to `wanted`; 0 if memory ran out. */
static int grow(void **block, size_t wanted, size_t size)
{
  void *grown = sdr_realloc(*block, wanted, size);
  if (grown) *block = grown;
  return grown != NULL;
}

static sdr_status make_room(sdr_contact *contact, int32_t count)
{
  const int32_t chunks = count / SDR_CONTACT_CHUNK + 1;
  if (count > contact->room) {
    const size_t room = (size_t)count + (size_t)count / 2 + SDR_CONTACT_CHUNK;
    if (!grow((void **)&contact->point, room, sizeof *contact->point) ||
        !grow((void **)&contact->place, 3 * room, sizeof *contact->place) ||
        !grow((void **)&contact->searched, 3 * room, sizeof *contact->searched))
      return SDR_RUN_FAILED;
    contact->room = (int32_t)room;
  }
  if (chunks > contact->chunk_room) {
    const size_t room = (size_t)chunks + (size_t)chunks / 2;
    if (!grow((void **)&contact->chunks, room, sizeof *contact->chunks)) return SDR_RUN_FAILED;
    contact->chunk_room = (int32_t)room;
  }
  return SDR_OK;
}

sdr_status sdr_contact_expose(sdr_contact *contact, int32_t i)
{
  const int32_t spot = contact->count, chunk = spot / SDR_CONTACT_CHUNK;
  const int32_t local = spot % SDR_CONTACT_CHUNK;
  SDR_TRY(make_room(contact, spot + 1));
  sdr_contact_rows *rows = &contact->chunks[chunk];
  if (local == 0) rows->row[0] = 0;
  rows->row[local + 1] = rows->row[local];
  contact->exposed[i] = 1;
  contact->spot_of[i] = spot;
  contact->point[spot] = i;
  for (int a = 0; a < 3; ++a) {
    const int there = a < contact->points->components;
    contact->place[3 * spot + a] = there ? contact->points->x[a][i] + contact->u[a][i] : 0.0;
    contact->searched[3 * spot + a] = contact->place[3 * spot + a];
  }
  contact->count = spot + 1;
  contact->chunk_count = chunk + 1;
  return SDR_OK;
}

/* All exposed points, in their order. */
static sdr_status number_spots(sdr_contact *contact)
{
  contact->count = contact->chunk_count = 0;
  for (int32_t i = 0; i < contact->points->count; ++i) {
    contact->spot_of[i] = -1;
    if (contact->exposed[i]) SDR_TRY(sdr_contact_expose(contact, i));
  }
  return SDR_OK;
}

static void follow_chunk(void *context, int c)
{
  sdr_contact *contact = context;
  const sdr_points *points = contact->points;
  const int32_t first = c * SDR_CONTACT_CHUNK;
  const int32_t end =
      first + SDR_CONTACT_CHUNK < contact->count ? first + SDR_CONTACT_CHUNK : contact->count;
  double most = 0.0;
  for (int32_t spot = first; spot < end; ++spot) {
    const int32_t i = contact->point[spot];
    double square = 0.0;
    for (int a = 0; a < points->components; ++a) {
      const double y = points->x[a][i] + contact->u[a][i];
      const double way = y - contact->searched[3 * spot + a];
      contact->place[3 * spot + a] = y;
      square += way * way;
    }
    most = fmax(most, square);
  }
  contact->chunks[c].moved = most;
}

double sdr_contact_follow(sdr_contact *contact, double *const u[3])
{
  double most = 0.0;
  contact->u = u;
  sdr_parallel_for(0, contact->chunk_count, 1, follow_chunk, contact);
  for (int32_t c = 0; c < contact->chunk_count; ++c) most = fmax(most, contact->chunks[c].moved);
  return sqrt(most);
}

/* ---- lost bonds ------------------------------------------------------------------------------ */

typedef struct {
  sdr_contact *contact;
  int stripe;
} lost_call;

static void take_lost(void *context, int32_t i, int32_t j)
{
  const lost_call *call = context;
  sdr_contact *contact = call->contact;
  const sdr_points *points = contact->points;
  double square = 0.0;
  if (!sdr_in_body(points, i) || !sdr_in_body(points, j)) return;
  /* threads write the same 1 */
  __atomic_store_n(&contact->exposed[i], 1, __ATOMIC_RELAXED);
  __atomic_store_n(&contact->exposed[j], 1, __ATOMIC_RELAXED);
  for (int a = 0; a < points->components; ++a) {
    const double apart = points->x[a][j] - points->x[a][i] + contact->u[a][j] - contact->u[a][i];
    square += apart * apart;
  }
  const double far =
      0.5 * contact->range * (points->spacing[i] + points->spacing[j]) + contact->skin;
  if (square < far * far) sdr_lost_add(&contact->near, call->stripe, i, j);
}

static void lost_of_stripe(void *context, int s)
{
  lost_call call = {context, s};
  const sdr_model *model = call.contact->model;
  model->ops->visit_lost(model, s, take_lost, &call);
}

/* Partners by lost bonds: torn[torn_row[a]] .. torn[torn_row[a + 1] - 1] of spot a. */
static sdr_status sort_lost(sdr_contact *contact)
{
  const size_t pairs = (size_t)sdr_lost_count(&contact->near);
  const size_t rows = (size_t)contact->count + 2;
  if (rows + 2 * pairs > contact->torn_room) {
    const size_t room = rows + 2 * pairs + (rows + 2 * pairs) / 2;
    if (!grow((void **)&contact->torn_row, room, sizeof *contact->torn_row) ||
        !grow((void **)&contact->torn, room, sizeof *contact->torn))
      return SDR_RUN_FAILED;
    contact->torn_room = room;
  }
  int32_t *row = contact->torn_row;
  memset(row, 0, rows * sizeof *row);
  for (int pass = 0; pass < 2; ++pass) {
    for (int s = 0; s < SDR_LOST_STRIPES; ++s)
      for (int32_t k = 0; k < contact->near.stripe[s].count; ++k) {
        const sdr_lost_pair pair = contact->near.stripe[s].pair[k];
        const int32_t a = contact->spot_of[pair.i], b = contact->spot_of[pair.j];
        if (pass == 0) {
          ++row[a + 2];
          ++row[b + 2];
        } else {
          contact->torn[row[a + 1]++] = b;
          contact->torn[row[b + 1]++] = a;
        }
      }
    for (size_t a = 2; pass == 0 && a < rows; ++a) row[a] += row[a - 1];
  }
  return SDR_OK;
}

/* ---- cells ----------------------------------------------------------------------------------- */

static int32_t coordinate(const sdr_contact *contact, int a, double x)
{
  const double c = (x - contact->low[a]) / contact->cell;
  return c <= 0.0 ? 0 : c >= contact->cells[a] ? contact->cells[a] - 1 : (int32_t)c;
}

static int32_t cell_of(const sdr_contact *contact, int32_t spot)
{
  const double *y = contact->place + 3 * (size_t)spot;
  const int32_t *n = contact->cells;
  return (coordinate(contact, 2, y[2]) * n[1] + coordinate(contact, 1, y[1])) * n[0] +
         coordinate(contact, 0, y[0]);
}

/* Cells of at least the distance at which pairs are kept. */
static void lay_cells(sdr_contact *contact)
{
  double high[3], extent[3];
  for (int a = 0; a < 3; ++a) {
    contact->low[a] = high[a] = contact->place[a];
    for (int32_t spot = 1; spot < contact->count; ++spot) {
      contact->low[a] = fmin(contact->low[a], contact->place[3 * (size_t)spot + (size_t)a]);
      high[a] = fmax(high[a], contact->place[3 * (size_t)spot + (size_t)a]);
    }
    extent[a] = high[a] - contact->low[a];
  }
  contact->cell = contact->most_range + contact->skin;
  while (sdr_cells_count(extent, contact->cell, contact->cells) > 8.0 * contact->count + 64.0)
    contact->cell *= 1.25;
}

/* Counting sort, spots ascending within a cell. */
static sdr_status fill_cells(sdr_contact *contact)
{
  const int32_t *n = contact->cells;
  const size_t cells = (size_t)n[0] * (size_t)n[1] * (size_t)n[2];
  if (cells + 2 > contact->first_room || (size_t)contact->count > contact->first_room) {
    const size_t room = cells + cells / 2 + (size_t)contact->count + 2;
    if (!grow((void **)&contact->first, room, sizeof *contact->first) ||
        !grow((void **)&contact->member, room, sizeof *contact->member))
      return SDR_RUN_FAILED;
    contact->first_room = room;
  }
  memset(contact->first, 0, (cells + 2) * sizeof *contact->first);
  for (int32_t spot = 0; spot < contact->count; ++spot)
    ++contact->first[cell_of(contact, spot) + 2];
  for (size_t c = 2; c < cells + 2; ++c) contact->first[c] += contact->first[c - 1];
  for (int32_t spot = 0; spot < contact->count; ++spot)
    contact->member[contact->first[cell_of(contact, spot) + 1]++] = spot;
  return SDR_OK;
}

/* ---- rows ------------------------------------------------------------------------------------ */

/* Room for `wanted` partners; 0 if memory ran out. */
static int make_row_room(sdr_contact_rows *rows, int32_t wanted)
{
  const size_t room = (size_t)wanted + (size_t)wanted / 2 + SDR_CONTACT_CHUNK;
  if (wanted <= rows->room) return 1;
  if (!grow((void **)&rows->partner, room, sizeof *rows->partner) ||
      !grow((void **)&rows->distance, room, sizeof *rows->distance)) {
    rows->failed = 1;
    return 0;
  }
  rows->room = (int32_t)room;
  return 1;
}

static void add_partner(sdr_contact_rows *rows, int32_t *used, int32_t b)
{
  if (make_row_room(rows, *used + 1)) rows->partner[(*used)++] = b;
}

/* Sort the partners [first, end) of spot a, whose points ascend with their numbers. */
static void settle_row(const sdr_contact *contact, sdr_contact_rows *rows, int32_t a, int32_t first,
                       int32_t end)
{
  for (int32_t k = first; k < end; ++k) {
    const int32_t b = rows->partner[k];
    int32_t at = k;
    for (; at > first && rows->partner[at - 1] > b; --at) rows->partner[at] = rows->partner[at - 1];
    rows->partner[at] = b;
  }
  for (int32_t k = first; k < end; ++k) {
    const int32_t i = contact->point[a], j = contact->point[rows->partner[k]];
    const double square = sdr_distance_squared(contact->points, i, j);
    rows->distance[k] = sdr_contact_reach(contact, i, j, square);
  }
}

/* From the end, so that what is there moves but once. */
static void merge(const sdr_contact *contact, int32_t chunk, const sdr_contact_entry *entry,
                  int32_t count)
{
  sdr_contact_rows *rows = &contact->chunks[chunk];
  const int32_t first = chunk * SDR_CONTACT_CHUNK;
  const int32_t spots =
      contact->count - first < SDR_CONTACT_CHUNK ? contact->count - first : SDR_CONTACT_CHUNK;
  int32_t end = rows->row[spots] + count, e = count - 1;
  if (!make_row_room(rows, end)) return;
  for (int32_t local = spots - 1; local >= 0; --local) {
    int32_t k = rows->row[local + 1] - 1;
    const int32_t begin = rows->row[local];
    rows->row[local + 1] = end;
    while (k >= begin || (e >= 0 && entry[e].a == first + local)) {
      const int fresh = e >= 0 && entry[e].a == first + local &&
                        (k < begin || entry[e].point > contact->point[rows->partner[k]]);
      rows->partner[--end] = fresh ? entry[e].b : rows->partner[k];
      rows->distance[end] = fresh ? entry[e].distance : rows->distance[k];
      e -= fresh;
      k -= !fresh;
    }
  }
}

static int by_spot(const void *left, const void *right)
{
  const sdr_contact_entry *a = left, *b = right;
  if (a->a != b->a) return a->a < b->a ? -1 : 1;
  return (a->point > b->point) - (a->point < b->point);
}

sdr_status sdr_contact_merge(sdr_contact *contact)
{
  sdr_contact_entry *late = contact->late;
  if (contact->late_count == 0) return SDR_OK;
  qsort(late, (size_t)contact->late_count, sizeof *late, by_spot);
  for (int32_t first = 0, end; first < contact->late_count; first = end) {
    const int32_t chunk = late[first].a / SDR_CONTACT_CHUNK;
    for (end = first; end < contact->late_count && late[end].a / SDR_CONTACT_CHUNK == chunk;) ++end;
    merge(contact, chunk, late + first, end - first);
    if (contact->chunks[chunk].failed) return SDR_RUN_FAILED;
  }
  contact->late_count = 0;
  return SDR_OK;
}

/* Those of a cell that no bond ever joined to spot a. */
static void look_into(const sdr_contact *contact, sdr_contact_rows *rows, int32_t *used, int32_t a,
                      int32_t cell)
{
  const sdr_points *points = contact->points;
  const int32_t i = contact->point[a];
  const double *y = contact->place + 3 * (size_t)a;
  for (int32_t k = contact->first[cell]; k < contact->first[cell + 1]; ++k) {
    const int32_t b = contact->member[k], j = contact->point[b];
    const double *z = contact->place + 3 * (size_t)b;
    const double x0 = z[0] - y[0], x1 = z[1] - y[1], x2 = z[2] - y[2];
    const double far = 0.5 * contact->range * (points->spacing[i] + points->spacing[j]);
    const double kept = far + contact->skin, square = x0 * x0 + x1 * x1 + x2 * x2;
    if (!(square < kept * kept) || b == a) continue;
    const double reference = sdr_distance_squared(points, i, j);
    if (sdr_in_horizon(points, i, reference) || sdr_in_horizon(points, j, reference)) continue;
    add_partner(rows, used, b);
  }
}

static void rows_of_chunk(void *context, int c)
{
  const sdr_contact *contact = context;
  sdr_contact_rows *rows = &contact->chunks[c];
  const int32_t *n = contact->cells, first = c * SDR_CONTACT_CHUNK;
  int32_t used = 0;
  rows->row[0] = 0;
  for (int32_t local = 0; local < SDR_CONTACT_CHUNK; ++local) {
    const int32_t a = first + local;
    int32_t at[3];
    if (a >= contact->count) break;
    for (int32_t k = contact->torn_row[a]; k < contact->torn_row[a + 1]; ++k)
      add_partner(rows, &used, contact->torn[k]);
    for (int d = 0; d < 3; ++d)
      at[d] = coordinate(contact, d, contact->place[3 * (size_t)a + (size_t)d]);
    for (int32_t z = at[2] > 0 ? at[2] - 1 : 0; z <= at[2] + 1 && z < n[2]; ++z)
      for (int32_t y = at[1] > 0 ? at[1] - 1 : 0; y <= at[1] + 1 && y < n[1]; ++y)
        for (int32_t x = at[0] > 0 ? at[0] - 1 : 0; x <= at[0] + 1 && x < n[0]; ++x)
          look_into(contact, rows, &used, a, (z * n[1] + y) * n[0] + x);
    settle_row(contact, rows, a, rows->row[local], used);
    rows->row[local + 1] = used;
  }
}

sdr_status sdr_contact_search(sdr_contact *contact, double *const u[3])
{
  contact->u = u;
  sdr_lost_empty(&contact->near);
  if (contact->model->ops->visit_lost)
    sdr_parallel_for(0, contact->points->stripe_count, 1, lost_of_stripe, contact);
  SDR_TRY(sdr_lost_check(&contact->near));
  SDR_TRY(number_spots(contact));
  SDR_TRY(sort_lost(contact));
  if (contact->count > 0) {
    lay_cells(contact);
    SDR_TRY(fill_cells(contact));
  }
  sdr_parallel_for(0, contact->chunk_count, 1, rows_of_chunk, contact);
  for (int32_t c = 0; c < contact->chunk_count; ++c)
    if (contact->chunks[c].failed)
      return sdr_fail(SDR_RUN_FAILED, "out of memory: the lists of contact cannot grow");
  sdr_lost_empty(&contact->lost);
  contact->late_count = 0;
  contact->since = contact->late_at = 0;
  contact->stale = 0;
  ++contact->searches;
  return SDR_OK;
}
