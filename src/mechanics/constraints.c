#include "mechanics/constraints.h"

#include "base/memory.h"
#include "geometry/text.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FREE = 0, PRESCRIBED = 1, SLAVED = 2 };

void sdr_slaves_destroy(sdr_slaves *slaves)
{
  sdr_free(slaves->unknown);
  sdr_free(slaves->constant);
  sdr_free(slaves->first);
  sdr_free(slaves->master);
  sdr_free(slaves->coefficient);
  sdr_free(slaves->apart);
  *slaves = (sdr_slaves){0};
}

void sdr_constraints_destroy(sdr_constraints *constraints)
{
  sdr_free(constraints->offset);
  sdr_free(constraints->prescribed);
  sdr_free(constraints->unknown);
  sdr_csr_destroy(&constraints->map);
  sdr_csr_destroy(&constraints->force);
  *constraints = (sdr_constraints){0};
}

/* ---- means ----------------------------------------------------------------------------------- */

/* Room for one more slave with `masters` masters. */
static sdr_status grow(sdr_slaves *s, int64_t masters)
{
  const size_t count = (size_t)s->count + 1, old = s->first ? (size_t)s->first[s->count] : 0;
  const size_t length = old + (size_t)masters;
  int32_t *unknown = sdr_realloc(s->unknown, count, sizeof *unknown);
  if (unknown) s->unknown = unknown;
  double *constant = sdr_realloc(s->constant, count, sizeof *constant);
  if (constant) s->constant = constant;
  int64_t *first = sdr_realloc(s->first, count + 1, sizeof *first);
  if (first) s->first = first;
  int32_t *master = sdr_realloc(s->master, length, sizeof *master);
  if (master) s->master = master;
  double *coefficient = sdr_realloc(s->coefficient, length, sizeof *coefficient);
  if (coefficient) s->coefficient = coefficient;
  uint8_t *apart = sdr_realloc(s->apart, count, sizeof *apart);
  if (apart) s->apart = apart;
  const int whole = unknown && constant && first && master && coefficient && apart;
  return whole ? SDR_OK : SDR_RUN_FAILED;
}

sdr_status sdr_slaves_of_means(const sdr_supports *supports, const double *values,
                               const sdr_points *points, sdr_slaves *slaves)
{
  const sdr_prescribed *list = sdr_supports_list(supports);
  const int32_t entries = sdr_supports_count(supports);
  for (int mean = 0; mean < sdr_supports_means(supports); ++mean) {
    int32_t count = 0, leader = -1;
    for (int32_t k = 0; k < entries; ++k) count += list[k].mean == mean && !isnan(values[k]);
    if (count == 0) continue;
    SDR_TRY(grow(slaves, count - 1));
    int64_t at = slaves->first[slaves->count];
    for (int32_t k = 0; k < entries; ++k) {
      if (list[k].mean != mean || isnan(values[k])) continue;
      const int32_t unknown = list[k].point * points->components + list[k].component;
      if (leader < 0) {
        leader = k;
        slaves->unknown[slaves->count] = unknown;
        slaves->constant[slaves->count] = count * values[k];
        continue;
      }
      slaves->master[at] = unknown;
      slaves->coefficient[at++] = -1.0;
    }
    slaves->first[++slaves->count] = at;
  }
  return SDR_OK;
}

/* ---- making ---------------------------------------------------------------------------------- */

/* While the constraints are made: what each unknown is, and where a free one stands in q. */
typedef struct {
  const sdr_points *points;
  uint8_t *kind;
  int32_t *place;
} sorting;

static const char *name_of(const sdr_points *points, int32_t unknown, char text[SDR_PLACE_TEXT])
{
  double x[3] = {0.0};
  for (int a = 0; a < points->components; ++a) x[a] = points->x[a][unknown / points->components];
  return sdr_place_text(x, points->components, text);
}

static sdr_status refuse(const sorting *s, int32_t unknown, const char *what)
{
  char text[SDR_PLACE_TEXT];
  return sdr_fail(SDR_BAD_INPUT, "the %c component of the point at %s %s",
                  "xyz"[unknown % s->points->components], name_of(s->points, unknown, text), what);
}

static void prescribe(const sdr_supports *supports, const double *values, sorting *s,
                      sdr_constraints *c)
{
  const sdr_prescribed *list = sdr_supports_list(supports);
  for (int32_t k = 0; k < sdr_supports_count(supports); ++k) {
    if (isnan(values[k]) || list[k].mean >= 0) continue;
    const int32_t unknown = list[k].point * s->points->components + list[k].component;
    s->kind[unknown] = PRESCRIBED;
    c->prescribed[unknown] = 1;
    c->offset[unknown] = values[k];
  }
}

static sdr_status enslave(const sdr_slaves *slaves, sorting *s)
{
  for (int32_t k = 0; k < slaves->count; ++k) {
    uint8_t *kind = &s->kind[slaves->unknown[k]];
    if (*kind == PRESCRIBED)
      return refuse(s, slaves->unknown[k],
                    "is prescribed by a support and follows a fictitious layer as well");
    if (*kind == SLAVED)
      return refuse(s, slaves->unknown[k], "follows two fictitious layers at once");
    *kind = SLAVED;
  }
  for (int64_t p = 0; slaves->count > 0 && p < slaves->first[slaves->count]; ++p)
    if (s->kind[slaves->master[p]] == SLAVED)
      return refuse(s, slaves->master[p],
                    "leads a fictitious layer and follows one: layers must follow the body");
  return SDR_OK;
}

/* A slave's constant takes in what its prescribed masters give. */
static void make_offsets(const sdr_slaves *slaves, const sorting *s, sdr_constraints *c)
{
  for (int32_t k = 0; k < slaves->count; ++k) {
    double sum = slaves->constant[k];
    for (int64_t p = slaves->first[k]; p < slaves->first[k + 1]; ++p)
      if (s->kind[slaves->master[p]] == PRESCRIBED)
        sum += slaves->coefficient[p] * c->offset[slaves->master[p]];
    c->offset[slaves->unknown[k]] = sum;
  }
}

/* Rows of B, or of P: those of slaves with forces apart are empty. */
static sdr_status add_rows(const sdr_slaves *slaves, const sorting *s, const sdr_constraints *c,
                           int forces, sdr_csr_builder *builder)
{
  for (int32_t k = 0; k < c->free; ++k)
    SDR_TRY(sdr_csr_builder_add(builder, c->unknown[k], k, 1.0));
  for (int32_t k = 0; slaves && k < slaves->count; ++k) {
    if (forces && slaves->apart[k]) continue;
    for (int64_t p = slaves->first[k]; p < slaves->first[k + 1]; ++p)
      if (s->kind[slaves->master[p]] == FREE)
        SDR_TRY(sdr_csr_builder_add(builder, slaves->unknown[k], s->place[slaves->master[p]],
                                    slaves->coefficient[p]));
  }
  return SDR_OK;
}

static sdr_status make_map(const sdr_slaves *slaves, const sorting *s, const sdr_constraints *c,
                           int forces, sdr_csr *out)
{
  sdr_csr_builder *builder = NULL;
  SDR_TRY(sdr_csr_builder_create(c->unknowns, c->free, &builder));
  sdr_status status = add_rows(slaves, s, c, forces, builder);
  if (status == SDR_OK) status = sdr_csr_builder_finish(builder, out);
  sdr_csr_builder_destroy(&builder);
  return status;
}

static sdr_status make_maps(const sdr_slaves *slaves, sorting *s, sdr_constraints *c)
{
  for (int32_t r = 0; r < c->unknowns; ++r)
    if (s->kind[r] == FREE) s->place[r] = c->free++;
  c->unknown = sdr_alloc((size_t)c->free, sizeof *c->unknown);
  if (!c->unknown) return SDR_RUN_FAILED;
  for (int32_t r = 0; r < c->unknowns; ++r)
    if (s->kind[r] == FREE) c->unknown[s->place[r]] = r;
  if (slaves) make_offsets(slaves, s, c);
  c->symmetric = 1;
  for (int32_t k = 0; slaves && slaves->apart && k < slaves->count; ++k)
    if (slaves->apart[k]) c->symmetric = 0;
  SDR_TRY(make_map(slaves, s, c, 0, &c->map));
  return c->symmetric ? SDR_OK : make_map(slaves, s, c, 1, &c->force);
}

sdr_status sdr_constraints_create(const sdr_points *points, const sdr_supports *supports,
                                  const double *values, const sdr_slaves *slaves,
                                  sdr_constraints *out)
{
  sdr_constraints c = {.unknowns = points->count * points->components};
  const size_t unknowns = (size_t)c.unknowns;
  sorting s = {points, sdr_alloc(unknowns, sizeof *s.kind), sdr_alloc(unknowns, sizeof *s.place)};
  c.offset = sdr_alloc(unknowns, sizeof *c.offset);
  c.prescribed = sdr_alloc(unknowns, sizeof *c.prescribed);
  sdr_status status = s.kind && s.place && c.offset && c.prescribed ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) prescribe(supports, values, &s, &c);
  if (status == SDR_OK && slaves) status = enslave(slaves, &s);
  if (status == SDR_OK) status = make_maps(slaves, &s, &c);
  sdr_free(s.kind);
  sdr_free(s.place);
  if (status == SDR_OK)
    *out = c;
  else
    sdr_constraints_destroy(&c);
  return status;
}

/* ---- use ------------------------------------------------------------------------------------- */

void sdr_constraints_expand(const sdr_constraints *constraints, const double *q, double *u)
{
  sdr_csr_times(&constraints->map, q, u);
  for (int32_t r = 0; r < constraints->unknowns; ++r) u[r] += constraints->offset[r];
}

static const sdr_csr *force_map(const sdr_constraints *constraints)
{
  return constraints->symmetric ? &constraints->map : &constraints->force;
}

void sdr_constraints_project(const sdr_constraints *constraints, const double *f, double *g)
{
  const sdr_csr *p = force_map(constraints);
  memset(g, 0, (size_t)constraints->free * sizeof *g);
  for (int32_t r = 0; r < p->rows; ++r)
    for (int64_t k = p->row[r]; k < p->row[r + 1]; ++k) g[p->column[k]] += p->value[k] * f[r];
}

/* P^T: for each entry of q the unknowns whose forces act on it. */
static sdr_status transpose(const sdr_csr *b, sdr_csr *out)
{
  sdr_csr_builder *builder = NULL;
  SDR_TRY(sdr_csr_builder_create(b->columns, b->rows, &builder));
  sdr_status status = SDR_OK;
  for (int32_t r = 0; r < b->rows && status == SDR_OK; ++r)
    for (int64_t k = b->row[r]; k < b->row[r + 1] && status == SDR_OK; ++k)
      status = sdr_csr_builder_add(builder, b->column[k], r, b->value[k]);
  if (status == SDR_OK) status = sdr_csr_builder_finish(builder, out);
  sdr_csr_builder_destroy(&builder);
  return status;
}

/* Of a product: one row at a time in `sum`, its columns in `touched`. */
typedef struct {
  const sdr_csr *b, *k, *pt;
  double *sum;
  int32_t *used, *touched;
} product;

/* Row i of P^T K B; how many columns it has. */
static int32_t make_row(product *p, int32_t i)
{
  const sdr_csr *b = p->b, *k = p->k, *pt = p->pt;
  int32_t count = 0;
  for (int64_t m = pt->row[i]; m < pt->row[i + 1]; ++m)
    for (int64_t n = k->row[pt->column[m]]; n < k->row[pt->column[m] + 1]; ++n) {
      const double here = pt->value[m] * k->value[n];
      for (int64_t l = b->row[k->column[n]]; l < b->row[k->column[n] + 1]; ++l) {
        const int32_t j = b->column[l];
        if (p->used[j] != i + 1) {
          p->used[j] = i + 1;
          p->sum[j] = 0.0;
          p->touched[count++] = j;
        }
        p->sum[j] += here * b->value[l];
      }
    }
  return count;
}

static int ascending(const void *a, const void *b)
{
  const int32_t left = *(const int32_t *)a, right = *(const int32_t *)b;
  return (left > right) - (left < right);
}

static void keep_row(const product *p, int32_t count, int32_t *column, double *value)
{
  int sorted = 1;
  for (int32_t m = 1; m < count; ++m) sorted &= p->touched[m - 1] < p->touched[m];
  if (!sorted) qsort(p->touched, (size_t)count, sizeof *p->touched, ascending);
  for (int32_t m = 0; m < count; ++m) {
    column[m] = p->touched[m];
    value[m] = p->sum[p->touched[m]];
  }
}

static sdr_status multiply(product *p, sdr_csr *out)
{
  out->row = sdr_alloc((size_t)out->rows + 1, sizeof *out->row);
  if (!out->row) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < out->rows; ++i) out->row[i + 1] = out->row[i] + make_row(p, i);
  const size_t count = (size_t)out->row[out->rows];
  out->column = sdr_alloc(count, sizeof *out->column);
  out->value = sdr_alloc(count, sizeof *out->value);
  if (!out->column || !out->value) return SDR_RUN_FAILED;
  memset(p->used, 0, (size_t)out->rows * sizeof *p->used);
  for (int32_t i = 0; i < out->rows; ++i)
    keep_row(p, make_row(p, i), out->column + out->row[i], out->value + out->row[i]);
  return SDR_OK;
}

sdr_status sdr_constraints_reduce(const sdr_constraints *constraints, const sdr_csr *k,
                                  sdr_csr *out)
{
  const size_t free_count = (size_t)constraints->free;
  sdr_csr pt = {0}, a = {.rows = constraints->free, .columns = constraints->free};
  product p = {.b = &constraints->map, .k = k, .pt = &pt};
  p.sum = sdr_alloc(free_count, sizeof *p.sum);
  p.used = sdr_alloc(free_count, sizeof *p.used);
  p.touched = sdr_alloc(free_count, sizeof *p.touched);
  sdr_status status = p.sum && p.used && p.touched ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) status = transpose(force_map(constraints), &pt);
  if (status == SDR_OK) status = multiply(&p, &a);
  sdr_free(p.sum);
  sdr_free(p.used);
  sdr_free(p.touched);
  sdr_csr_destroy(&pt);
  if (status == SDR_OK)
    *out = a;
  else
    sdr_csr_destroy(&a);
  return status;
}
