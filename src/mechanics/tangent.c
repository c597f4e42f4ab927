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

/* Add a block of m x m values, whose rows are `width` apart, where rows are `stride` apart. */
static inline void add_rows(double *to, int64_t stride, const double *from, size_t width, int m)
{
  for (int c = 0; c < m; ++c)
    for (int d = 0; d < m; ++d) to[c * stride + d] += from[(size_t)c * width + (size_t)d];
}

/* Add block (r, s) of a part of `count` points at the place of the neighbour in row i. */
static inline void add_block(assembly *a, int32_t i, int64_t place, const double *block, int count,
                             int r, int s)
{
  const int m = a->components;
  const size_t width = (size_t)count * (size_t)m;
  const double *from = block + (size_t)(r * m) * width + (size_t)(s * m);
  const int64_t stride = (a->row[i + 1] - a->row[i]) * m;
  double *to = a->out.value + a->out.row[i * m] + place * m;
  if (m == 1) add_rows(to, stride, from, width, 1);
  if (m == 2) add_rows(to, stride, from, width, 2);
  if (m == 3) add_rows(to, stride, from, width, 3);
}

static void add_part(void *context, int count, const int32_t *point, const double *block)
{
  assembly *a = context;
  for (int r = 0; r < count; ++r)
    for (int s = 0; s < count; ++s)
      add_block(a, point[r], place_of(a, point[r], point[s]), block, count, r, s);
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

/* ---- many states ----------------------------------------------------------------------------- */

struct sdr_tangent {
  sdr_model *model;
  sdr_tangent_kind kind;
  assembly a;      /* with the points of all parts */
  int64_t *blocks; /* of each part: where its places start */
  int32_t *place;  /* of its blocks, row by row: where each stands in its point's row */
  int64_t next;    /* the part that is expected next */
};

static sdr_status visit(const sdr_tangent *t, double *const u0[3], double *const u[3],
                        sdr_hessian_visitor visitor, void *context)
{
  const sdr_model_ops *ops = t->model->ops;
  if (t->kind == SDR_TANGENT_MEAN)
    return ops->visit_mean_tangent(t->model, u0, u, visitor, context);
  return t->kind == SDR_TANGENT_SECANT ? ops->visit_secant(t->model, u, visitor, context)
                                       : ops->visit_hessian(t->model, u, visitor, context);
}

static sdr_status check_kind(const sdr_model *model, sdr_tangent_kind kind)
{
  const sdr_model_ops *ops = model->ops;
  if (kind == SDR_TANGENT_MEAN && !ops->visit_mean_tangent)
    return sdr_fail(SDR_BAD_INPUT, "the model %s has no mean force of a step", ops->name);
  if (kind == SDR_TANGENT_SECANT && !ops->visit_secant)
    return sdr_fail(SDR_BAD_INPUT, "the model %s has no secant stiffness", ops->name);
  return SDR_OK;
}

/* Part k joins these points. */
static int is_part(const assembly *a, int64_t k, int count, const int32_t *point)
{
  if (k >= a->count || a->first[k + 1] - a->first[k] != count) return 0;
  const int32_t *own = a->point + a->first[k];
  int same = 1;
  for (int p = 0; p < count; ++p) same &= own[p] == point[p];
  return same;
}

/* A model may leave out what has been lost since: the part is looked for a little further on. -1 if
   it is none of those. */
static int64_t find_part(const sdr_tangent *t, int count, const int32_t *point)
{
  enum { FAR = 64 };
  for (int64_t k = t->next; k < t->next + FAR; ++k)
    if (is_part(&t->a, k, count, point)) return k;
  return -1;
}

static int is_joined(const assembly *a, int32_t i, int32_t j)
{
  return a->neighbour[a->row[i] + place_of(a, i, j)] == j;
}

/* A part that lost some of its points: the places of the others are looked up. */
static void add_remains(assembly *a, int count, const int32_t *point, const double *block)
{
  for (int r = 0; r < count; ++r)
    for (int s = 0; s < count; ++s)
      if (!is_joined(a, point[r], point[s])) {
        a->failed = 1;
        return;
      }
  add_part(a, count, point, block);
}

static void replay_part(void *context, int count, const int32_t *point, const double *block)
{
  sdr_tangent *t = context;
  const int64_t k = find_part(t, count, point);
  if (k < 0) {
    add_remains(&t->a, count, point, block);
    return;
  }
  const int32_t *place = t->place + t->blocks[k];
  for (int r = 0; r < count; ++r)
    for (int s = 0; s < count; ++s) add_block(&t->a, point[r], *place++, block, count, r, s);
  t->next = k + 1;
}

static sdr_status record_places(sdr_tangent *t)
{
  const assembly *a = &t->a;
  t->blocks = sdr_alloc((size_t)a->count + 1, sizeof *t->blocks);
  if (!t->blocks) return SDR_RUN_FAILED;
  for (int64_t k = 0; k < a->count; ++k) {
    const int64_t count = a->first[k + 1] - a->first[k];
    t->blocks[k + 1] = t->blocks[k] + count * count;
  }
  t->place = sdr_alloc((size_t)t->blocks[a->count], sizeof *t->place);
  if (!t->place) return SDR_RUN_FAILED;
  int32_t *to = t->place;
  for (int64_t k = 0; k < a->count; ++k)
    for (int64_t r = a->first[k]; r < a->first[k + 1]; ++r)
      for (int64_t s = a->first[k]; s < a->first[k + 1]; ++s)
        *to++ = (int32_t)place_of(a, a->point[r], a->point[s]);
  return SDR_OK;
}

/* The parts of the body at rest are all there are. */
static sdr_status note_parts(sdr_tangent *t)
{
  const sdr_points *points = t->model->points;
  const size_t padded = sdr_points_padded(points);
  double *still = sdr_alloc(padded, sizeof *still);
  double *u[3] = {NULL, NULL, NULL};
  for (int a = 0; a < points->components; ++a) u[a] = still;
  sdr_status status = still && make_room(&t->a, 0) ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) status = visit(t, u, u, note_part, &t->a);
  if (status == SDR_OK && t->a.failed) status = SDR_RUN_FAILED;
  sdr_free(still);
  return status;
}

sdr_status sdr_tangent_create(sdr_model *model, sdr_tangent_kind kind, sdr_tangent **out)
{
  SDR_TRY(check_kind(model, kind));
  sdr_tangent *t = sdr_alloc(1, sizeof *t);
  if (!t) return SDR_RUN_FAILED;
  t->model = model;
  t->kind = kind;
  t->a.points = model->points->count;
  t->a.components = model->points->components;
  sdr_status status = note_parts(t);
  if (status == SDR_OK) status = find_pattern(&t->a);
  if (status == SDR_OK) status = expand_pattern(&t->a);
  sdr_free(t->a.start);
  sdr_free(t->a.part);
  t->a.start = t->a.part = NULL;
  if (status == SDR_OK) status = record_places(t);
  if (status == SDR_OK)
    *out = t;
  else
    sdr_tangent_destroy(&t);
  return status;
}

void sdr_tangent_destroy(sdr_tangent **tangent)
{
  sdr_tangent *t = *tangent;
  if (!t) return;
  assembly_destroy(&t->a);
  sdr_free(t->blocks);
  sdr_free(t->place);
  sdr_free(t);
  *tangent = NULL;
}

sdr_status sdr_tangent_update(sdr_tangent *tangent, double *const u0[3], double *const u[3])
{
  assembly *a = &tangent->a;
  memset(a->out.value, 0, (size_t)a->out.row[a->out.rows] * sizeof *a->out.value);
  tangent->next = 0;
  a->failed = 0;
  SDR_TRY(visit(tangent, u0, u, replay_part, tangent));
  if (!a->failed) return SDR_OK;
  return sdr_fail(SDR_RUN_FAILED,
                  "the tangent of the model %s joins points that were not joined at rest",
                  tangent->model->ops->name);
}

const sdr_csr *sdr_tangent_matrix(const sdr_tangent *tangent)
{
  return &tangent->a.out;
}
