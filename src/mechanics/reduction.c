#include "mechanics/reduction.h"

#include "base/memory.h"

#include <string.h>

struct sdr_reduction {
  const sdr_csr *k;
  int32_t *place; /* an unknown: where it stands in q, -1: it is not free */
  int32_t *unknown;
  int32_t free; /* as many as `unknown` holds; -1: `matrix` is not that of a selection */
  sdr_csr matrix;
};

sdr_status sdr_reduction_create(const sdr_csr *k, sdr_reduction **out)
{
  sdr_reduction *r = sdr_alloc(1, sizeof *r);
  if (!r) return SDR_RUN_FAILED;
  r->k = k;
  r->free = -1;
  r->place = sdr_alloc((size_t)k->rows, sizeof *r->place);
  r->unknown = sdr_alloc((size_t)k->rows, sizeof *r->unknown);
  if (r->place && r->unknown)
    *out = r;
  else
    sdr_reduction_destroy(&r);
  return r ? SDR_OK : SDR_RUN_FAILED;
}

void sdr_reduction_destroy(sdr_reduction **reduction)
{
  sdr_reduction *r = *reduction;
  if (!r) return;
  sdr_free(r->place);
  sdr_free(r->unknown);
  sdr_csr_destroy(&r->matrix);
  sdr_free(r);
  *reduction = NULL;
}

/* Every free component has a row of its own in B with a 1: no more entries, no slaves. */
static int selects(const sdr_constraints *c)
{
  return c->symmetric && c->map.row[c->unknowns] == c->free;
}

static int same_selection(const sdr_reduction *r, const sdr_constraints *c)
{
  return r->free == c->free &&
         memcmp(r->unknown, c->unknown, (size_t)c->free * sizeof *c->unknown) == 0;
}

static int64_t count_row(const sdr_reduction *r, int32_t unknown)
{
  int64_t count = 0;
  for (int64_t p = r->k->row[unknown]; p < r->k->row[unknown + 1]; ++p)
    count += r->place[r->k->column[p]] >= 0;
  return count;
}

static sdr_status find_pattern(sdr_reduction *r, const sdr_constraints *c)
{
  sdr_csr a = {.rows = c->free, .columns = c->free};
  memset(r->place, 0xff, (size_t)c->unknowns * sizeof *r->place);
  for (int32_t q = 0; q < c->free; ++q) r->place[c->unknown[q]] = q;
  a.row = sdr_alloc((size_t)c->free + 1, sizeof *a.row);
  if (!a.row) return SDR_RUN_FAILED;
  for (int32_t q = 0; q < c->free; ++q) a.row[q + 1] = a.row[q] + count_row(r, c->unknown[q]);
  a.column = sdr_alloc((size_t)a.row[c->free], sizeof *a.column);
  a.value = sdr_alloc((size_t)a.row[c->free], sizeof *a.value);
  if (!a.column || !a.value) {
    sdr_csr_destroy(&a);
    return SDR_RUN_FAILED;
  }
  for (int32_t q = 0; q < c->free; ++q) {
    int32_t *to = a.column + a.row[q];
    for (int64_t p = r->k->row[c->unknown[q]]; p < r->k->row[c->unknown[q] + 1]; ++p)
      if (r->place[r->k->column[p]] >= 0) *to++ = r->place[r->k->column[p]];
  }
  sdr_csr_destroy(&r->matrix);
  r->matrix = a;
  r->free = c->free;
  memcpy(r->unknown, c->unknown, (size_t)c->free * sizeof *c->unknown);
  return SDR_OK;
}

static void copy_values(const sdr_reduction *r)
{
  double *to = r->matrix.value;
  for (int32_t q = 0; q < r->free; ++q)
    for (int64_t p = r->k->row[r->unknown[q]]; p < r->k->row[r->unknown[q] + 1]; ++p)
      if (r->place[r->k->column[p]] >= 0) *to++ = r->k->value[p];
}

static int same_pattern(const sdr_csr *a, const sdr_csr *b)
{
  if (a->rows != b->rows || !a->row) return 0;
  if (memcmp(a->row, b->row, ((size_t)a->rows + 1) * sizeof *a->row) != 0) return 0;
  return memcmp(a->column, b->column, (size_t)a->row[a->rows] * sizeof *a->column) == 0;
}

/* With slaves: entries of the product may come and go with their coefficients. */
static sdr_status reduce(sdr_reduction *r, const sdr_constraints *c, int *renewed)
{
  sdr_csr a = {0};
  SDR_TRY(sdr_constraints_reduce(c, r->k, &a));
  *renewed = !same_pattern(&r->matrix, &a);
  sdr_csr_destroy(&r->matrix);
  r->matrix = a;
  r->free = -1;
  return SDR_OK;
}

sdr_status sdr_reduction_update(sdr_reduction *reduction, const sdr_constraints *constraints,
                                int *renewed)
{
  if (!selects(constraints)) return reduce(reduction, constraints, renewed);
  const int fresh = !same_selection(reduction, constraints);
  if (fresh) SDR_TRY(find_pattern(reduction, constraints));
  copy_values(reduction);
  *renewed = fresh;
  return SDR_OK;
}

void sdr_reduction_add_diagonal(sdr_reduction *reduction, const sdr_constraints *constraints,
                                const double *diagonal)
{
  const sdr_csr *b = &constraints->map, *a = &reduction->matrix;
  const sdr_csr *p = constraints->symmetric ? b : &constraints->force;
  for (int32_t r = 0; r < b->rows; ++r)
    for (int64_t k = b->row[r]; k < b->row[r + 1]; ++k) {
      const int32_t q = b->column[k];
      double pair = 0.0; /* of P and B at (r, q) */
      for (int64_t l = p->row[r]; l < p->row[r + 1]; ++l)
        if (p->column[l] == q) pair = p->value[l] * b->value[k];
      for (int64_t l = a->row[q]; l < a->row[q + 1]; ++l)
        if (a->column[l] == q) a->value[l] += pair * diagonal[r];
    }
}

const sdr_csr *sdr_reduction_matrix(const sdr_reduction *reduction)
{
  return &reduction->matrix;
}
