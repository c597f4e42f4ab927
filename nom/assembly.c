#include "nom/assembly.h"

#include "base/memory.h"

#include <math.h>

/* ---- quadratic functionals ------------------------------------------------------------------- */

/* What one point adds: rows and columns are component p of the neighbours and, last, of the point
   itself, at p size + k. */
typedef struct {
  int fields;
  int64_t size; /* neighbours + 1 */
  double *value;
  uint8_t *used; /* fields fields: blocks that some term touches */
} local_matrix;

static double weight_at(const sdr_operator *op, int32_t i, int64_t k, int derivative)
{
  const sdr_support *support = op->shape->support;
  const int64_t neighbours = support->row[i + 1] - support->row[i];
  if (derivative == SDR_VALUE) return k == neighbours ? 1.0 : 0.0;
  if (k == neighbours) return op->centre[(size_t)i * (size_t)op->terms + (size_t)derivative];
  return op->weight[(support->row[i] + k) * op->terms + derivative];
}

/* c (weights of a) (x) (weights of b) into block (p, q). */
static void add_product(const sdr_operator *op, int32_t i, const sdr_quadratic_term *t, double c,
                        local_matrix *local)
{
  const int64_t size = local->size, width = size * local->fields;
  for (int64_t k = 0; k < size; ++k) {
    const double left = c * weight_at(op, i, k, t->a);
    if (left == 0.0) continue;
    double *row = local->value + (t->p * size + k) * width + t->q * size;
    for (int64_t l = 0; l < size; ++l) row[l] += left * weight_at(op, i, l, t->b);
  }
  local->used[t->p * local->fields + t->q] = 1;
}

static void fill_local(const sdr_operator *op, const sdr_functional *functional, int32_t i,
                       local_matrix *local)
{
  const sdr_cloud *cloud = &op->shape->support->cloud;
  const int64_t width = local->size * local->fields;
  const double volume = cloud->volume ? cloud->volume[i] : 1.0;
  for (int64_t e = 0; e < width * width; ++e) local->value[e] = 0.0;
  for (int n = 0; n < functional->count; ++n) {
    const sdr_quadratic_term *t = functional->term + n;
    const double c = 0.5 * volume * t->coefficient * (t->by_point ? t->by_point[i] : 1.0);
    const sdr_quadratic_term exchanged = {.a = t->b, .p = t->q, .b = t->a, .q = t->p};
    add_product(op, i, t, c, local);
    add_product(op, i, &exchanged, c, local);
  }
}

static sdr_status scatter_block(const sdr_support *support, int32_t i, const local_matrix *local,
                                int p, int q, sdr_csr_builder *matrix)
{
  const int64_t size = local->size, width = size * local->fields, first = support->row[i];
  const int32_t count = support->cloud.count;
  for (int64_t k = 0; k < size; ++k)
    for (int64_t l = 0; l < size; ++l) {
      const int32_t row = p * count + (k + 1 < size ? support->column[first + k] : i);
      const int32_t column = q * count + (l + 1 < size ? support->column[first + l] : i);
      SDR_TRY(sdr_csr_builder_add(matrix, row, column,
                                  local->value[(p * size + k) * width + q * size + l]));
    }
  return SDR_OK;
}

static sdr_status check_functional(const sdr_operator *op, const sdr_functional *functional)
{
  const int fields = functional->fields;
  if (fields < 1 || (int64_t)fields * op->shape->support->cloud.count > INT32_MAX)
    return sdr_fail(SDR_BAD_INPUT, "a functional of %d components over %d points: too %s", fields,
                    (int)op->shape->support->cloud.count, fields < 1 ? "few" : "many unknowns");
  for (int n = 0; n < functional->count; ++n) {
    const sdr_quadratic_term *t = functional->term + n;
    if (t->a < SDR_VALUE || t->a >= op->terms || t->b < SDR_VALUE || t->b >= op->terms ||
        t->p < 0 || t->p >= fields || t->q < 0 || t->q >= fields)
      return sdr_fail(SDR_BAD_INPUT,
                      "term %d of a functional: derivatives are -1..%d and components 0..%d, not "
                      "%d of %d with %d of %d",
                      n, op->terms - 1, fields - 1, t->a, t->p, t->b, t->q);
  }
  return SDR_OK;
}

static int64_t most_neighbours(const sdr_support *support)
{
  int64_t most = 0;
  for (int32_t i = 0; i < support->cloud.count; ++i) {
    const int64_t neighbours = support->row[i + 1] - support->row[i];
    if (neighbours > most) most = neighbours;
  }
  return most;
}

sdr_status sdr_functional_add(const sdr_operator *op, const sdr_functional *functional,
                              sdr_csr_builder *matrix)
{
  SDR_TRY(check_functional(op, functional));
  const sdr_support *support = op->shape->support;
  const int fields = functional->fields;
  const size_t width = ((size_t)most_neighbours(support) + 1) * (size_t)fields;
  local_matrix local = {.fields = fields};
  local.value = sdr_alloc(width * width, sizeof *local.value);
  local.used = sdr_alloc((size_t)fields * (size_t)fields, 1);
  sdr_status status = local.value && local.used ? SDR_OK : SDR_RUN_FAILED;
  for (int32_t i = 0; i < support->cloud.count && status == SDR_OK; ++i) {
    local.size = support->row[i + 1] - support->row[i] + 1;
    fill_local(op, functional, i, &local);
    for (int p = 0; p < fields && status == SDR_OK; ++p)
      for (int q = 0; q < fields && status == SDR_OK; ++q)
        if (local.used[p * fields + q]) status = scatter_block(support, i, &local, p, q, matrix);
  }
  sdr_free(local.value);
  sdr_free(local.used);
  return status;
}

/* Mean size of the diagonal entries, 1 if there are none. */
static double typical_diagonal(const sdr_csr *matrix)
{
  double sum = 0.0;
  int32_t found = 0;
  for (int32_t r = 0; r < matrix->rows; ++r)
    for (int64_t k = matrix->row[r]; k < matrix->row[r + 1]; ++k)
      if (matrix->column[k] == r && matrix->value[k] != 0.0) {
        sum += fabs(matrix->value[k]);
        ++found;
      }
  return found > 0 ? sum / found : 1.0;
}

static sdr_status check_diagonal(const sdr_csr *matrix, const uint8_t *fixed)
{
  for (int32_t r = 0; r < matrix->rows; ++r) {
    int has = !fixed[r];
    for (int64_t k = matrix->row[r]; k < matrix->row[r + 1] && !has; ++k)
      has = matrix->column[k] == r;
    if (!has)
      return sdr_fail(SDR_BAD_INPUT,
                      "unknown %d cannot be prescribed: its row has no diagonal entry", (int)r);
  }
  return SDR_OK;
}

sdr_status sdr_fix_unknowns(sdr_csr *matrix, const uint8_t *fixed, const double *value, double *f)
{
  SDR_TRY(check_diagonal(matrix, fixed));
  const double typical = typical_diagonal(matrix);
  for (int32_t r = 0; r < matrix->rows; ++r) {
    for (int64_t k = matrix->row[r]; k < matrix->row[r + 1]; ++k) {
      const int32_t c = matrix->column[k];
      if (!fixed[r] && !fixed[c]) continue;
      if (!fixed[r]) f[r] -= matrix->value[k] * value[c];
      matrix->value[k] = r == c ? typical : 0.0;
    }
    if (fixed[r]) f[r] = typical * value[r];
  }
  return SDR_OK;
}

/* ---- collocation ----------------------------------------------------------------------------- */

/* Sum of the terms of component p for the k-th neighbour. */
static double combined(const sdr_operator *op, int32_t i, int64_t k, int p, int count,
                       const sdr_term *term)
{
  double sum = 0.0;
  for (int t = 0; t < count; ++t)
    if (term[t].p == p) sum += term[t].coefficient * weight_at(op, i, k, term[t].a);
  return sum;
}

static sdr_status collocate_field(const sdr_operator *op, int32_t i, int p, int count,
                                  const sdr_term *term, int32_t row, sdr_csr_builder *matrix)
{
  const sdr_support *support = op->shape->support;
  const int64_t neighbours = support->row[i + 1] - support->row[i];
  for (int64_t k = 0; k <= neighbours; ++k) {
    const int32_t j = k < neighbours ? support->column[support->row[i] + k] : i;
    const double value = combined(op, i, k, p, count, term);
    if (value != 0.0 || j == i)
      SDR_TRY(sdr_csr_builder_add(matrix, row, p * support->cloud.count + j, value));
  }
  return SDR_OK;
}

sdr_status sdr_collocate(const sdr_operator *op, int32_t i, int count, const sdr_term *term,
                         int32_t row, sdr_csr_builder *matrix)
{
  for (int t = 0; t < count; ++t) {
    int seen = 0;
    if (term[t].a < SDR_VALUE || term[t].a >= op->terms || term[t].p < 0)
      return sdr_fail(SDR_BAD_INPUT,
                      "term %d of an equation: derivatives are -1..%d and components from 0, not "
                      "%d of %d",
                      t, op->terms - 1, term[t].a, term[t].p);
    for (int s = 0; s < t; ++s) seen |= term[s].p == term[t].p;
    if (!seen) SDR_TRY(collocate_field(op, i, term[t].p, count, term, row, matrix));
  }
  return SDR_OK;
}
