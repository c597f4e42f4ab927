#include "linalg/csr.h"

#include "base/memory.h"
#include "base/parallel.h"

#include <stdlib.h>

enum { CHUNK = 1 << 18 };

/* Entries are kept in blocks, so that growing copies nothing and blocks go as they are used. */
typedef struct chunk {
  struct chunk *next;
  int32_t count;
  int32_t row[CHUNK], column[CHUNK];
  double value[CHUNK];
} chunk;

struct sdr_csr_builder {
  int32_t rows, columns;
  int64_t count;
  chunk *first, *last;
};

void sdr_csr_destroy(sdr_csr *matrix)
{
  sdr_free(matrix->row);
  sdr_free(matrix->column);
  sdr_free(matrix->value);
  *matrix = (sdr_csr){0};
}

sdr_status sdr_csr_builder_create(int32_t rows, int32_t columns, sdr_csr_builder **out)
{
  sdr_csr_builder *builder = sdr_alloc(1, sizeof *builder);
  if (!builder) return SDR_RUN_FAILED;
  builder->rows = rows;
  builder->columns = columns;
  *out = builder;
  return SDR_OK;
}

static void drop_first(sdr_csr_builder *builder)
{
  chunk *next = builder->first->next;
  sdr_free(builder->first);
  builder->first = next;
}

void sdr_csr_builder_destroy(sdr_csr_builder **builder)
{
  if (!*builder) return;
  while ((*builder)->first) drop_first(*builder);
  sdr_free(*builder);
  *builder = NULL;
}

static sdr_status append_chunk(sdr_csr_builder *builder)
{
  chunk *fresh = sdr_alloc(1, sizeof *fresh);
  if (!fresh) return SDR_RUN_FAILED;
  if (builder->last)
    builder->last->next = fresh;
  else
    builder->first = fresh;
  builder->last = fresh;
  return SDR_OK;
}

sdr_status sdr_csr_builder_add(sdr_csr_builder *builder, int32_t row, int32_t column, double value)
{
  if (row < 0 || row >= builder->rows || column < 0 || column >= builder->columns)
    return sdr_fail(SDR_RUN_FAILED, "the entry (%d, %d) lies outside a matrix of %d x %d", (int)row,
                    (int)column, (int)builder->rows, (int)builder->columns);
  if (!builder->last || builder->last->count == CHUNK) SDR_TRY(append_chunk(builder));
  chunk *to = builder->last;
  to->row[to->count] = row;
  to->column[to->count] = column;
  to->value[to->count++] = value;
  ++builder->count;
  return SDR_OK;
}

/* ---- summing up ------------------------------------------------------------------------------ */

static void count_rows(const sdr_csr_builder *builder, int64_t *start)
{
  for (const chunk *c = builder->first; c; c = c->next)
    for (int32_t k = 0; k < c->count; ++k) ++start[c->row[k] + 1];
  for (int32_t r = 0; r < builder->rows; ++r) start[r + 1] += start[r];
}

/* Into their rows, in the order of the calls. start[r] then is where row r ends. */
static void scatter(sdr_csr_builder *builder, int64_t *start, int32_t *column, double *value)
{
  while (builder->first) {
    const chunk *c = builder->first;
    for (int32_t k = 0; k < c->count; ++k) {
      const int64_t place = start[c->row[k]]++;
      column[place] = c->column[k];
      value[place] = c->value[k];
    }
    drop_first(builder);
  }
  builder->last = NULL;
}

static int ascending(const void *a, const void *b)
{
  const int32_t left = *(const int32_t *)a, right = *(const int32_t *)b;
  return (left > right) - (left < right);
}

/* Scratch of the summation: per column the sum, and the last row (+ 1) that used it. */
typedef struct {
  double *sum;
  int32_t *used;
} sums;

/* Sum the entries [from, end) of row r into places from `to` on; how many remain. */
static int64_t merge_row(sdr_csr *a, sums *s, int32_t r, int64_t from, int64_t end, int64_t to)
{
  int64_t distinct = 0;
  for (int64_t k = from; k < end; ++k) {
    const int32_t c = a->column[k];
    if (s->used[c] != r + 1) {
      s->used[c] = r + 1;
      s->sum[c] = 0.0;
      a->column[to + distinct++] = c; /* to + distinct <= k: read before it is overwritten */
    }
    s->sum[c] += a->value[k];
  }
  if (distinct > 1) qsort(a->column + to, (size_t)distinct, sizeof *a->column, ascending);
  for (int64_t k = 0; k < distinct; ++k) a->value[to + k] = s->sum[a->column[to + k]];
  return distinct;
}

static void merge_rows(sdr_csr *a, sums *s)
{
  int64_t from = 0, to = 0;
  for (int32_t r = 0; r < a->rows; ++r) {
    const int64_t end = a->row[r];
    a->row[r] = to;
    to += merge_row(a, s, r, from, end, to);
    from = end;
  }
  a->row[a->rows] = to;
}

static sdr_status shrink(sdr_csr *a)
{
  const size_t count = (size_t)a->row[a->rows];
  int32_t *column = sdr_realloc(a->column, count, sizeof *column);
  if (!column) return SDR_RUN_FAILED;
  a->column = column;
  double *value = sdr_realloc(a->value, count, sizeof *value);
  if (!value) return SDR_RUN_FAILED;
  a->value = value;
  return SDR_OK;
}

sdr_status sdr_csr_builder_finish(sdr_csr_builder *builder, sdr_csr *out)
{
  sdr_status status = SDR_RUN_FAILED;
  sdr_csr a = {.rows = builder->rows, .columns = builder->columns};
  sums s = {sdr_alloc((size_t)a.columns, sizeof(double)),
            sdr_alloc((size_t)a.columns, sizeof(int32_t))};
  a.row = sdr_alloc((size_t)a.rows + 1, sizeof *a.row);
  a.column = sdr_alloc((size_t)builder->count, sizeof *a.column);
  a.value = sdr_alloc((size_t)builder->count, sizeof *a.value);
  if (s.sum && s.used && a.row && a.column && a.value) {
    count_rows(builder, a.row);
    scatter(builder, a.row, a.column, a.value);
    merge_rows(&a, &s);
    status = shrink(&a);
  }
  sdr_free(s.sum);
  sdr_free(s.used);
  if (status == SDR_OK)
    *out = a;
  else
    sdr_csr_destroy(&a);
  return status;
}

/* ---- product --------------------------------------------------------------------------------- */

enum { TASK_ROWS = 2048 };

typedef struct {
  const sdr_csr *matrix;
  const double *x;
  double *y;
} product;

static void times_rows(void *context, int task)
{
  const product *p = context;
  const sdr_csr *a = p->matrix;
  const int32_t first = task * TASK_ROWS;
  const int32_t end = a->rows - first < TASK_ROWS ? a->rows : first + TASK_ROWS;
  for (int32_t r = first; r < end; ++r) {
    double sum = 0.0;
    for (int64_t k = a->row[r]; k < a->row[r + 1]; ++k) sum += a->value[k] * p->x[a->column[k]];
    p->y[r] = sum;
  }
}

void sdr_csr_times(const sdr_csr *matrix, const double *x, double *y)
{
  product p = {matrix, x, y};
  const int tasks = matrix->rows / TASK_ROWS + (matrix->rows % TASK_ROWS != 0);
  sdr_parallel_for(0, tasks, 1, times_rows, &p);
}
