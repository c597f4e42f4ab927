#include "nom/shape_tensor.h"

#include "base/memory.h"
#include "base/parallel.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdio.h>

enum { BLOCK = 64 }; /* points a task */

/* Index of T[r][c], r <= c, in an upper triangle of n rows, by rows. */
static inline size_t at(int n, int r, int c)
{
  return (size_t)(r * n - r * (r - 1) / 2 + c - r);
}

static inline size_t triangle(int n)
{
  return (size_t)(n * (n + 1) / 2);
}

double sdr_shape_entry(const sdr_shape_tensors *shape, int32_t i, int64_t k, double r[3], double *p)
{
  const sdr_cloud *cloud = &shape->support->cloud;
  const int32_t j = shape->support->column[k];
  const double h = shape->support->radius[i];
  double square = 0.0;
  for (int a = 0; a < 3; ++a) r[a] = 0.0;
  for (int a = 0; a < cloud->components; ++a) {
    r[a] = cloud->x[a][j] - cloud->x[a][i];
    square += r[a] * r[a];
  }
  sdr_monomials(&shape->set, r, h, p);
  return sdr_influence_at(shape->influence, sqrt(square) / h) *
         (cloud->volume ? cloud->volume[j] : 1.0);
}

void sdr_shape_solve(const sdr_shape_tensors *shape, int32_t i, const double *g, double *x)
{
  const int n = shape->set.count;
  const double *root = shape->root + triangle(n) * (size_t)i;
  double y[SDR_MOST_TERMS];
  for (int c = 0; c < n; ++c) { /* y = T^T g */
    y[c] = 0.0;
    for (int r = 0; r <= c; ++r) y[c] += root[at(n, r, c)] * g[r];
  }
  for (int r = 0; r < n; ++r) {
    x[r] = 0.0;
    for (int c = r; c < n; ++c) x[r] += root[at(n, r, c)] * y[c];
  }
}

/* ---- one tensor ------------------------------------------------------------------------------ */

/* Rows sqrt(w V) p of the neighbours, whose Gram matrix is M: their QR factorisation gives the
   Cholesky factor of M without squaring its condition. rows: neighbours n values. */
static void fill_rows(const sdr_shape_tensors *shape, int32_t i, double *rows)
{
  const sdr_support *support = shape->support;
  const int n = shape->set.count;
  for (int64_t k = support->row[i]; k < support->row[i + 1]; ++k) {
    double r[3], *row = rows + (k - support->row[i]) * n;
    const double root = sqrt(sdr_shape_entry(shape, i, k, r, row));
    for (int a = 0; a < n; ++a) row[a] *= root;
  }
}

/* 1-norm of R^T R (whole = 0) or of T T^T (1), each of an upper triangle U. */
static double gram_norm(int n, const double *upper, int whole)
{
  double largest = 0.0;
  for (int a = 0; a < n; ++a) {
    double sum = 0.0;
    for (int b = 0; b < n; ++b) {
      const int low = a < b ? a : b, high = a < b ? b : a;
      double entry = 0.0;
      if (whole)
        for (int c = high; c < n; ++c) entry += upper[at(n, a, c)] * upper[at(n, b, c)];
      else
        for (int c = 0; c <= low; ++c) entry += upper[at(n, c, a)] * upper[at(n, c, b)];
      sum += fabs(entry);
    }
    largest = fmax(largest, sum);
  }
  return largest;
}

static void pack(int n, const double *rows, double *upper)
{
  for (int r = 0; r < n; ++r)
    for (int c = r; c < n; ++c) upper[at(n, r, c)] = rows[r * n + c];
}

/* T = R^-1 into `root`; the condition number of M = R^T R, INFINITY if it has no inverse. */
static double invert(int n, double *rows, double *root)
{
  for (int a = 0; a < n; ++a)
    if (!(fabs(rows[a * n + a]) > 0.0)) return INFINITY;
  pack(n, rows, root);
  const double norm = gram_norm(n, root, 0);
  gsl_matrix_view view = gsl_matrix_view_array(rows, (size_t)n, (size_t)n);
  if (gsl_linalg_tri_invert(CblasUpper, CblasNonUnit, &view.matrix) != GSL_SUCCESS) return INFINITY;
  pack(n, rows, root);
  const double condition = norm * gram_norm(n, root, 1);
  if (isfinite(condition)) return condition;
  return INFINITY;
}

/* rows: scratch of neighbours n + n values. */
static void shape_of(const sdr_shape_tensors *shape, int32_t i, double *rows)
{
  const int n = shape->set.count;
  const int64_t neighbours = shape->support->row[i + 1] - shape->support->row[i];
  double *root = shape->root + triangle(n) * (size_t)i;
  shape->condition[i] = INFINITY;
  if (neighbours < n) return;
  fill_rows(shape, i, rows);
  gsl_matrix_view view = gsl_matrix_view_array(rows, (size_t)neighbours, (size_t)n);
  gsl_vector_view tau = gsl_vector_view_array(rows + neighbours * n, (size_t)n);
  if (gsl_linalg_QR_decomp(&view.matrix, &tau.vector) != GSL_SUCCESS) return;
  shape->condition[i] = invert(n, rows, root);
}

/* ---- all of them ----------------------------------------------------------------------------- */

typedef struct {
  const sdr_shape_tensors *shape;
  const int32_t *wanted; /* only points with wanted[i] > 0; NULL: all */
  uint8_t *failed;       /* by block: no memory */
} many;

static void shape_block(void *context, int block)
{
  const many *m = context;
  const sdr_support *support = m->shape->support;
  const int32_t count = support->cloud.count, first = block * BLOCK;
  const int32_t end = first + BLOCK < count ? first + BLOCK : count;
  int64_t most = 0;
  for (int32_t i = first; i < end; ++i) {
    const int64_t neighbours = support->row[i + 1] - support->row[i];
    if (neighbours > most) most = neighbours;
  }
  double *rows = sdr_alloc((size_t)(most + 1) * (size_t)m->shape->set.count, sizeof *rows);
  if (!rows) {
    m->failed[block] = 1;
    return;
  }
  for (int32_t i = first; i < end; ++i)
    if (!m->wanted || m->wanted[i] > 0) shape_of(m->shape, i, rows);
  sdr_free(rows);
}

static sdr_status shape_many(const sdr_shape_tensors *shape, const int32_t *wanted)
{
  const int32_t count = shape->support->cloud.count;
  const int blocks = (count + BLOCK - 1) / BLOCK;
  uint8_t *failed = sdr_alloc((size_t)blocks, 1);
  if (!failed) return SDR_RUN_FAILED;
  many m = {shape, wanted, failed};
  sdr_parallel_for(0, blocks, 1, shape_block, &m);
  sdr_status status = SDR_OK;
  for (int b = 0; b < blocks && status == SDR_OK; ++b)
    if (failed[b]) status = sdr_fail(SDR_RUN_FAILED, "out of memory for shape tensors");
  sdr_free(failed);
  return status;
}

/* Neighbours that a support may grow to. */
static int32_t most_neighbours(const sdr_support *support)
{
  const int32_t others = support->cloud.count - 1;
  return others < SDR_MOST_NEAREST ? others : SDR_MOST_NEAREST;
}

static int32_t neighbours_of(const sdr_support *support, int32_t i)
{
  return (int32_t)(support->row[i + 1] - support->row[i]);
}

/* Name the first singular point; with `grown` the first that can grow no more. */
static sdr_status singular(const sdr_shape_tensors *shape, double most_condition, int grown)
{
  const sdr_support *support = shape->support;
  const sdr_multi_indices *set = &shape->set;
  int32_t first = -1, others = -1;
  for (int32_t i = 0; i < support->cloud.count; ++i) {
    if (shape->condition[i] <= most_condition) continue;
    if (first < 0 && (!grown || neighbours_of(support, i) >= most_neighbours(support))) first = i;
    ++others;
  }
  const int neighbours = neighbours_of(support, first);
  const sdr_point_name name = sdr_point_named(&support->cloud, first);
  char more[60] = "";
  if (others > 0) snprintf(more, sizeof more, " (and %d more points)", (int)others);
  const char *mend = grown ? "these points bear no operators of that order"
                           : "give more neighbours or a lower order";
  if (neighbours < set->count)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s has %d neighbours, and operators of order %d in %d-D need at least "
                    "%d%s: %s",
                    name.text, neighbours, set->order, set->components, set->count, more, mend);
  return sdr_fail(SDR_BAD_INPUT,
                  "%s has a singular shape tensor: condition number %.1e with %d neighbours, at "
                  "most %.1e for operators of order %d%s: %s",
                  name.text, shape->condition[first], neighbours, most_condition, set->order, more,
                  mend);
}

/* How many neighbours each singular point asks for next, 0 for the others; *any: some are
   singular; *stuck: of those one has all points already. */
static void ask_for_more(const sdr_shape_tensors *shape, double most_condition, int32_t *wanted,
                         int *any, int *stuck)
{
  const sdr_support *support = shape->support;
  *any = *stuck = 0;
  for (int32_t i = 0; i < support->cloud.count; ++i) {
    wanted[i] = 0;
    if (shape->condition[i] <= most_condition) continue;
    const int32_t have = neighbours_of(support, i), more = have + have / 4 + 1;
    *any = 1;
    if (have >= most_neighbours(support)) *stuck = 1;
    wanted[i] = more > shape->set.count ? more : shape->set.count;
  }
}

static sdr_status make_regular(sdr_support *support, const sdr_shape_how *how,
                               sdr_shape_tensors *made)
{
  const double most_condition = how->most_condition > 0.0 ? how->most_condition : 1e12;
  const size_t count = (size_t)support->cloud.count;
  int32_t *wanted = sdr_alloc(2 * count, sizeof *wanted);
  if (!wanted) return SDR_RUN_FAILED;
  int32_t *grown = wanted + count;
  sdr_status status = shape_many(made, NULL);
  while (status == SDR_OK) {
    int any, stuck;
    ask_for_more(made, most_condition, wanted, &any, &stuck);
    if (!any) break;
    if (!how->enlarge || stuck) {
      status = singular(made, most_condition, stuck && how->enlarge);
      break;
    }
    for (size_t i = 0; i < count; ++i) grown[i] |= wanted[i] > 0;
    status = sdr_support_enlarge(support, wanted);
    if (status == SDR_OK) status = shape_many(made, wanted);
  }
  for (size_t i = 0; i < count; ++i) made->enlarged += grown[i];
  sdr_free(wanted);
  return status;
}

sdr_status sdr_shape_tensors_create(sdr_support *support, const sdr_shape_how *how,
                                    sdr_shape_tensors *out)
{
  sdr_shape_tensors made = {.support = support, .influence = how->influence};
  SDR_TRY(sdr_multi_indices_of(support->cloud.components, how->order, &made.set));
  gsl_set_error_handler_off();
  const size_t count = (size_t)support->cloud.count;
  sdr_status status = SDR_RUN_FAILED;
  made.root = sdr_alloc(count * triangle(made.set.count), sizeof *made.root);
  made.condition = sdr_alloc(count, sizeof *made.condition);
  if (!made.root || !made.condition) goto cleanup;
  status = make_regular(support, how, &made);
  if (status != SDR_OK) goto cleanup;
  for (int32_t i = 1; i < support->cloud.count; ++i)
    if (made.condition[i] > made.condition[made.worst]) made.worst = i;
  *out = made;
  made = (sdr_shape_tensors){0};
cleanup:
  sdr_shape_tensors_destroy(&made);
  return status;
}

void sdr_shape_tensors_destroy(sdr_shape_tensors *shape)
{
  sdr_free(shape->root);
  sdr_free(shape->condition);
  *shape = (sdr_shape_tensors){0};
}
