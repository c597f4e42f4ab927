#include "mechanics/tangent.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* The parts of the Hessian are visited twice: for the points that they join, then for their
   values. */
typedef struct {
  int32_t points;
  int components;
  int failed;
  int64_t count, capacity; /* parts */
  int64_t length, room;    /* of `point` */
  int64_t *first;          /* of each part: where its points start */
  int32_t *point;
  int64_t *start; /* points + 1: the parts that a point is in ... */
  int64_t *part;
  int64_t *row; /* points + 1: ... and the points that it is joined to, ascending */
  int32_t *neighbour;
  sdr_csr out;
} assembly;

static void assembly_destroy(assembly *a)
{
  sdr_free(a->first);
  sdr_free(a->point);
  sdr_free(a->start);
  sdr_free(a->part);
  sdr_free(a->row);
  sdr_free(a->neighbour);
  sdr_csr_destroy(&a->out);
}

/* ---- which points are joined ----------------------------------------------------------------- */

static int make_room(assembly *a, int count)
{
  if (a->count + 1 >= a->capacity) {
    const int64_t capacity = a->capacity ? 2 * a->capacity : 1024;
    int64_t *first = sdr_realloc(a->first, (size_t)capacity, sizeof *first);
    if (!first) return 0;
    a->first = first;
    a->capacity = capacity;
  }
  if (a->length + count > a->room) {
    const int64_t room = a->room ? 2 * a->room + count : 4096 + count;
    int32_t *point = sdr_realloc(a->point, (size_t)room, sizeof *point);
    if (!point) return 0;
    a->point = point;
    a->room = room;
  }
  return 1;
}

static void note_part(void *context, int count, const int32_t *point, const double *block)
{
  assembly *a = context;
  (void)block;
  if (a->failed || !make_room(a, count)) {
    a->failed = 1;
    return;
  }
  a->first[a->count++] = a->length;
  memcpy(a->point + a->length, point, (size_t)count * sizeof *point);
  a->length += count;
  a->first[a->count] = a->length;
}

/* The parts of each point. */
static sdr_status invert(assembly *a)
{
  a->start = sdr_alloc((size_t)a->points + 2, sizeof *a->start);
  a->part = sdr_alloc((size_t)a->length, sizeof *a->part);
  if (!a->start || !a->part) return SDR_RUN_FAILED;
  int64_t *next = a->start + 1; /* next[i] moves on to where i ends */
  for (int64_t k = 0; k < a->length; ++k) ++next[a->point[k] + 1];
  for (int32_t i = 0; i < a->points; ++i) next[i + 1] += next[i];
  for (int64_t p = 0; p < a->count; ++p)
    for (int64_t k = a->first[p]; k < a->first[p + 1]; ++k) a->part[next[a->point[k]]++] = p;
  return SDR_OK;
}

/* Points that share a part with i, and i itself, into `found`; how many. `seen` is scratch. */
static int32_t find_neighbours(const assembly *a, int32_t i, int32_t *seen, int32_t *found)
{
  int32_t count = 0;
  found[count++] = i;
  seen[i] = i + 1;
  for (int64_t p = a->start[i]; p < a->start[i + 1]; ++p)
    for (int64_t k = a->first[a->part[p]]; k < a->first[a->part[p] + 1]; ++k) {
      const int32_t j = a->point[k];
      if (seen[j] == i + 1) continue;
      seen[j] = i + 1;
      found[count++] = j;
    }
  return count;
}

static int ascending(const void *left, const void *right)
{
  const int32_t i = *(const int32_t *)left, j = *(const int32_t *)right;
  return (i > j) - (i < j);
}

static sdr_status make_rows(assembly *a, int32_t *seen, int32_t *found)
{
  for (int32_t i = 0; i < a->points; ++i)
    a->row[i + 1] = a->row[i] + find_neighbours(a, i, seen, found);
  a->neighbour = sdr_alloc((size_t)a->row[a->points], sizeof *a->neighbour);
  if (!a->neighbour) return SDR_RUN_FAILED;
  memset(seen, 0, (size_t)a->points * sizeof *seen);
  for (int32_t i = 0; i < a->points; ++i) {
    int32_t *row = a->neighbour + a->row[i];
    const int32_t count = find_neighbours(a, i, seen, found);
    memcpy(row, found, (size_t)count * sizeof *row);
    qsort(row, (size_t)count, sizeof *row, ascending);
  }
  return SDR_OK;
}

static sdr_status find_pattern(assembly *a)
{
  int32_t *seen = sdr_alloc((size_t)a->points, sizeof *seen);
  int32_t *found = sdr_alloc((size_t)a->points, sizeof *found);
  a->row = sdr_alloc((size_t)a->points + 1, sizeof *a->row);
  sdr_status status = seen && found && a->row ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) status = invert(a);
  if (status == SDR_OK) status = make_rows(a, seen, found);
  sdr_free(seen);
  sdr_free(found);
  return status;
}

/* ---- the matrix ------------------------------------------------------------------------------ */

/* Every component of a point is joined to every one of its neighbours. */
static sdr_status expand_pattern(assembly *a)
{
  const int m = a->components;
  sdr_csr *out = &a->out;
  const size_t rows = (size_t)a->points * (size_t)m;
  const size_t entries = (size_t)a->row[a->points] * (size_t)(m * m);
  out->rows = out->columns = (int32_t)rows;
  out->row = sdr_alloc(rows + 1, sizeof *out->row);
  out->column = sdr_alloc(entries, sizeof *out->column);
  out->value = sdr_alloc(entries, sizeof *out->value);
  if (!out->row || !out->column || !out->value) return SDR_RUN_FAILED;
  int64_t at = 0;
  for (int32_t i = 0; i < a->points; ++i)
    for (int c = 0; c < m; ++c) {
      for (int64_t k = a->row[i]; k < a->row[i + 1]; ++k)
        for (int d = 0; d < m; ++d) out->column[at++] = a->neighbour[k] * m + d;
      out->row[i * m + c + 1] = at;
    }
  return SDR_OK;
}

/* Where j stands among the neighbours of i. */
static int64_t place_of(const assembly *a, int32_t i, int32_t j)
{
  int64_t low = a->row[i], high = a->row[i + 1] - 1;
  while (low < high) {
    const int64_t middle = (low + high) / 2;
    if (a->neighbour[middle] < j)
      low = middle + 1;
    else
      high = middle;
  }
  return low - a->row[i];
}

static void add_part(void *context, int count, const int32_t *point, const double *block)
{
  assembly *a = context;
  const int m = a->components, width = count * m;
  for (int r = 0; r < count; ++r)
    for (int s = 0; s < count; ++s) {
      const int64_t place = place_of(a, point[r], point[s]);
      for (int c = 0; c < m; ++c) {
        double *to = a->out.value + a->out.row[point[r] * m + c] + place * m;
        const double *from = block + (size_t)(r * m + c) * (size_t)width + s * m;
        for (int d = 0; d < m; ++d) to[d] += from[d];
      }
    }
}

static void drop_parts(assembly *a)
{
  sdr_free(a->first);
  sdr_free(a->point);
  sdr_free(a->start);
  sdr_free(a->part);
  a->first = a->start = a->part = NULL;
  a->point = NULL;
}

sdr_status sdr_tangent_assemble(sdr_model *model, double *const u[3], sdr_csr *out)
{
  assembly a = {.points = model->points->count, .components = model->points->components};
  sdr_status status = make_room(&a, 0) ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) status = model->ops->visit_hessian(model, u, note_part, &a);
  if (status == SDR_OK && a.failed) status = SDR_RUN_FAILED;
  if (status == SDR_OK) status = find_pattern(&a);
  drop_parts(&a);
  if (status == SDR_OK) status = expand_pattern(&a);
  if (status == SDR_OK) status = model->ops->visit_hessian(model, u, add_part, &a);
  if (status == SDR_OK) {
    *out = a.out;
    a.out = (sdr_csr){0};
  }
  assembly_destroy(&a);
  return status;
}
