/* Conjugate gradients for positive definite matrices, preconditioned by the inverses of the
   diagonal blocks: one block for the components of a point. */
#include "base/memory.h"
#include "linalg/solver_ops.h"

#include <math.h>
#include <string.h>

enum { MOST_BLOCK = 6 };
static const double tolerance = 1e-12; /* of |b - A x|/|b| */

/* Block k: rows first[k] .. first[k + 1] - 1, its Cholesky factor in MOST_BLOCK^2 values. */
typedef struct {
  const sdr_csr *matrix;
  int32_t count, *first;
  double *block;
  double *residual, *direction, *product, *scaled;
} state;

static void destroy(void *given)
{
  state *s = given;
  sdr_free(s->first);
  sdr_free(s->block);
  sdr_free(s->residual);
  sdr_free(s->direction);
  sdr_free(s->product);
  sdr_free(s->scaled);
  sdr_free(s);
}

/* ---- preconditioner -------------------------------------------------------------------------- */

/* Rows with the same columns, at most MOST_BLOCK together. */
static void split(const sdr_csr_groups *groups, state *s)
{
  s->count = 0;
  for (int32_t g = 0; g < groups->count; ++g)
    for (int32_t r = groups->first[g]; r < groups->first[g + 1]; r += MOST_BLOCK)
      s->first[s->count++] = r;
  s->first[s->count] = groups->first[groups->count];
}

static double *block_of(const state *s, int32_t k)
{
  return s->block + (size_t)k * (MOST_BLOCK * MOST_BLOCK);
}

static void copy_block(const state *s, int32_t k)
{
  double *block = block_of(s, k);
  const sdr_csr *a = s->matrix;
  const int32_t first = s->first[k], end = s->first[k + 1];
  for (int32_t r = first; r < end; ++r)
    for (int64_t p = a->row[r]; p < a->row[r + 1]; ++p)
      if (a->column[p] >= first && a->column[p] < end)
        block[(r - first) * MOST_BLOCK + a->column[p] - first] = a->value[p];
}

/* Cholesky factor in place (lower triangle); the first row without a positive pivot, or -1. */
static int32_t factor_block(double *block, int32_t size)
{
  for (int32_t r = 0; r < size; ++r) {
    double *row = block + r * MOST_BLOCK;
    const double whole = row[r];
    for (int32_t c = 0; c <= r; ++c) {
      const double *other = block + c * MOST_BLOCK;
      double sum = row[c];
      for (int32_t p = 0; p < c; ++p) sum -= row[p] * other[p];
      if (c < r) {
        row[c] = sum / other[c];
      } else if (sum > 1e-14 * whole && whole > 0.0) {
        row[c] = sqrt(sum);
      } else {
        return r;
      }
    }
  }
  return -1;
}

/* z = (L L^T)^-1 r, block by block. */
static void precondition(const state *s, const double *r, double *z)
{
  for (int32_t k = 0; k < s->count; ++k) {
    const double *block = block_of(s, k);
    const int32_t first = s->first[k], size = s->first[k + 1] - first;
    double y[MOST_BLOCK];
    for (int32_t p = 0; p < size; ++p) {
      y[p] = r[first + p];
      for (int32_t q = 0; q < p; ++q) y[p] -= block[p * MOST_BLOCK + q] * y[q];
      y[p] /= block[p * MOST_BLOCK + p];
    }
    for (int32_t p = size - 1; p >= 0; --p) {
      for (int32_t q = p + 1; q < size; ++q) y[p] -= block[q * MOST_BLOCK + p] * y[q];
      y[p] /= block[p * MOST_BLOCK + p];
      z[first + p] = y[p];
    }
  }
}

static sdr_status make_blocks(state *s, sdr_solver_report *report)
{
  sdr_csr_groups groups;
  SDR_TRY(sdr_csr_groups_find(s->matrix, &groups));
  split(&groups, s);
  sdr_csr_groups_destroy(&groups);
  s->block = sdr_alloc((size_t)s->count * MOST_BLOCK * MOST_BLOCK, sizeof *s->block);
  if (!s->block) return SDR_RUN_FAILED;
  for (int32_t k = 0; k < s->count; ++k) {
    copy_block(s, k);
    const int32_t bad = factor_block(block_of(s, k), s->first[k + 1] - s->first[k]);
    if (bad >= 0)
      return sdr_solver_singular(report, s->matrix, s->first[k] + bad,
                                 "singular or not positive definite");
  }
  return SDR_OK;
}

static sdr_status factor(sdr_matrix_kind kind, const sdr_csr *a, void **out,
                         sdr_solver_report *report)
{
  (void)kind;
  if (*out) destroy(*out); /* finding the blocks is quick */
  *out = NULL;
  state *s = sdr_alloc(1, sizeof *s);
  if (!s) return SDR_RUN_FAILED;
  *out = s;
  const size_t rows = (size_t)a->rows;
  s->matrix = a;
  s->first = sdr_alloc(rows + 1, sizeof *s->first);
  s->residual = sdr_alloc(rows, sizeof(double));
  s->direction = sdr_alloc(rows, sizeof(double));
  s->product = sdr_alloc(rows, sizeof(double));
  s->scaled = sdr_alloc(rows, sizeof(double));
  if (!s->first || !s->residual || !s->direction || !s->product || !s->scaled)
    return SDR_RUN_FAILED;
  SDR_TRY(make_blocks(s, report));
  report->bytes = (double)(rows * (sizeof(int32_t) + 4 * sizeof(double)) +
                           (size_t)s->count * MOST_BLOCK * MOST_BLOCK * sizeof(double));
  return SDR_OK;
}

/* ---- iteration ------------------------------------------------------------------------------- */

static double dot(const double *x, const double *y, int32_t count)
{
  double sum = 0.0;
  for (int32_t k = 0; k < count; ++k) sum += x[k] * y[k];
  return sum;
}

static sdr_status iterate(state *s, double *x, double target, sdr_solver_report *report)
{
  const int32_t rows = s->matrix->rows;
  const int64_t most = 1000 + 10 * (int64_t)rows;
  double rho = 0.0, least = INFINITY;
  int64_t since = 0; /* iterations without progress */
  for (int64_t n = 0; n < most && since < 2000; ++n, ++since) {
    const double size = sqrt(dot(s->residual, s->residual, rows));
    if (size < 0.9 * least) {
      least = size;
      since = 0;
    }
    if (size <= target) break;
    precondition(s, s->residual, s->scaled);
    const double before = rho;
    rho = dot(s->residual, s->scaled, rows);
    const double beta = n > 0 ? rho / before : 0.0;
    for (int32_t k = 0; k < rows; ++k) s->direction[k] = s->scaled[k] + beta * s->direction[k];
    sdr_csr_times(s->matrix, s->direction, s->product);
    const double curvature = dot(s->direction, s->product, rows);
    if (!(curvature > 0.0))
      return sdr_solver_singular(report, s->matrix, -1, "singular or not positive definite");
    const double alpha = rho / curvature;
    for (int32_t k = 0; k < rows; ++k) {
      x[k] += alpha * s->direction[k];
      s->residual[k] -= alpha * s->product[k];
    }
    ++report->iterations;
  }
  return SDR_OK;
}

static sdr_status solve(void *given, const double *b, double *x, sdr_solver_report *report)
{
  state *s = given;
  const size_t bytes = (size_t)s->matrix->rows * sizeof *b;
  memset(x, 0, bytes);
  memcpy(s->residual, b, bytes);
  memset(s->direction, 0, bytes);
  return iterate(s, x, tolerance * sqrt(dot(b, b, s->matrix->rows)), report);
}

static sdr_status apply_blocks(void *given, const double *b, double *x, sdr_solver_report *report)
{
  (void)report;
  precondition(given, b, x);
  return SDR_OK;
}

const sdr_solver_ops sdr_solver_pcg = {.name = "pcg",
                                       .direct = 0,
                                       .takes = {1, 0, 0},
                                       .factor = factor,
                                       .solve = solve,
                                       .precondition = apply_blocks,
                                       .destroy = destroy};
