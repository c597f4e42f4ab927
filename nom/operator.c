#include "nom/operator.h"

#include "base/memory.h"
#include "base/parallel.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 256 }; /* points a task */

/* a!/h^|a| */
static double scale_of(const sdr_multi_indices *set, int a, double h)
{
  double power = 1.0;
  for (int k = 0; k < set->degree[a]; ++k) power *= h;
  return set->factorial[a] / power;
}

static int32_t block_end(int32_t count, int32_t first)
{
  return first + BLOCK < count ? first + BLOCK : count;
}

/* ---- matrix-free ----------------------------------------------------------------------------- */

/* x = M_i^-1 sum w V p (u_j - u_i): the scaled derivatives h^|a|/a! D_a u. */
static void scaled_derivatives(const sdr_shape_tensors *shape, int32_t i, const double *u,
                               double *x)
{
  const sdr_support *support = shape->support;
  const int n = shape->set.count;
  double g[SDR_MOST_TERMS] = {0.0}, p[SDR_MOST_TERMS], r[3];
  for (int64_t k = support->row[i]; k < support->row[i + 1]; ++k) {
    const double w = sdr_shape_entry(shape, i, k, r, p) * (u[support->column[k]] - u[i]);
    for (int a = 0; a < n; ++a) g[a] += w * p[a];
  }
  sdr_shape_solve(shape, i, g, x);
}

void sdr_derivatives_at(const sdr_shape_tensors *shape, int32_t i, const double *u, double *out)
{
  scaled_derivatives(shape, i, u, out);
  for (int a = 0; a < shape->set.count; ++a)
    out[a] *= scale_of(&shape->set, a, shape->support->radius[i]);
}

typedef struct {
  const sdr_shape_tensors *shape;
  const sdr_operator *op;
  int derivative;
  const double *u;
  double *out;
} application;

static void derivative_block(void *context, int block)
{
  const application *apply = context;
  const int32_t end = block_end(apply->shape->support->cloud.count, block * BLOCK);
  for (int32_t i = block * BLOCK; i < end; ++i) {
    double all[SDR_MOST_TERMS];
    sdr_derivatives_at(apply->shape, i, apply->u, all);
    apply->out[i] = all[apply->derivative];
  }
}

void sdr_derivative(const sdr_shape_tensors *shape, int derivative, const double *u, double *out)
{
  const int32_t count = shape->support->cloud.count;
  if (derivative == SDR_VALUE) {
    memcpy(out, u, (size_t)count * sizeof *out);
    return;
  }
  application apply = {.shape = shape, .derivative = derivative, .u = u, .out = out};
  sdr_parallel_for(0, (count + BLOCK - 1) / BLOCK, 1, derivative_block, &apply);
}

/* ---- row weights ----------------------------------------------------------------------------- */

/* w M^-1 p of each neighbour, and B = sum of w M^-1 p p^T, which should be the identity. */
static void raw_weights(const sdr_operator *op, int32_t i, double *b)
{
  const sdr_shape_tensors *shape = op->shape;
  const int n = op->terms;
  for (int e = 0; e < n * n; ++e) b[e] = 0.0;
  for (int64_t k = shape->support->row[i]; k < shape->support->row[i + 1]; ++k) {
    double p[SDR_MOST_TERMS], r[3], *weight = op->weight + k * n;
    const double w = sdr_shape_entry(shape, i, k, r, p);
    sdr_shape_solve(shape, i, p, weight);
    for (int a = 0; a < n; ++a) {
      weight[a] *= w;
      for (int c = 0; c < n; ++c) b[a * n + c] += weight[a] * p[c];
    }
  }
}

/* Weights of one point. (2 I - B) times the raw ones takes the defect I - B to its square, so that
   the condition of M_i costs no digits of the polynomials' exactness. b: scratch of n n. */
static void weights_of(const sdr_operator *op, int32_t i, double *b)
{
  const sdr_support *support = op->shape->support;
  const int n = op->terms;
  double *centre = op->centre + (size_t)i * (size_t)n, scale[SDR_MOST_TERMS];
  raw_weights(op, i, b);
  for (int a = 0; a < n; ++a) scale[a] = scale_of(&op->shape->set, a, support->radius[i]);
  for (int64_t k = support->row[i]; k < support->row[i + 1]; ++k) {
    double *weight = op->weight + k * n, fine[SDR_MOST_TERMS];
    for (int a = 0; a < n; ++a) {
      double sum = 0.0;
      for (int c = 0; c < n; ++c) sum += b[a * n + c] * weight[c];
      fine[a] = (2.0 * weight[a] - sum) * scale[a];
    }
    for (int a = 0; a < n; ++a) {
      weight[a] = fine[a];
      centre[a] -= fine[a];
    }
  }
}

static void weights_block(void *context, int block)
{
  const sdr_operator *op = context;
  double b[SDR_MOST_TERMS * SDR_MOST_TERMS];
  const int32_t end = block_end(op->shape->support->cloud.count, block * BLOCK);
  for (int32_t i = block * BLOCK; i < end; ++i) weights_of(op, i, b);
}

sdr_status sdr_operator_create(const sdr_shape_tensors *shape, sdr_operator *out)
{
  const int32_t count = shape->support->cloud.count;
  const size_t terms = (size_t)shape->set.count;
  sdr_operator made = {.shape = shape, .terms = shape->set.count};
  made.weight = sdr_alloc((size_t)shape->support->row[count] * terms, sizeof *made.weight);
  made.centre = sdr_alloc((size_t)count * terms, sizeof *made.centre);
  if (!made.weight || !made.centre) {
    sdr_operator_destroy(&made);
    return SDR_RUN_FAILED;
  }
  sdr_parallel_for(0, (count + BLOCK - 1) / BLOCK, 1, weights_block, &made);
  *out = made;
  return SDR_OK;
}

void sdr_operator_destroy(sdr_operator *op)
{
  sdr_free(op->weight);
  sdr_free(op->centre);
  *op = (sdr_operator){0};
}

sdr_status sdr_operator_find(const sdr_operator *op, const char *name, int *out)
{
  return sdr_multi_index_find(&op->shape->set, name, out);
}

double sdr_operator_at(const sdr_operator *op, int derivative, int32_t i, const double *u)
{
  const sdr_support *support = op->shape->support;
  if (derivative == SDR_VALUE) return u[i];
  double sum = 0.0;
  for (int64_t k = support->row[i]; k < support->row[i + 1]; ++k)
    sum += op->weight[k * op->terms + derivative] * (u[support->column[k]] - u[i]);
  return sum;
}

static void apply_block(void *context, int block)
{
  const application *apply = context;
  const int32_t end = block_end(apply->op->shape->support->cloud.count, block * BLOCK);
  for (int32_t i = block * BLOCK; i < end; ++i)
    apply->out[i] = sdr_operator_at(apply->op, apply->derivative, i, apply->u);
}

void sdr_operator_apply(const sdr_operator *op, int derivative, const double *u, double *out)
{
  application apply = {.op = op, .derivative = derivative, .u = u, .out = out};
  const int32_t count = op->shape->support->cloud.count;
  sdr_parallel_for(0, (count + BLOCK - 1) / BLOCK, 1, apply_block, &apply);
}

/* One row of a derivative's matrix: the neighbours with i among them, ascending. */
static int64_t fill_row(const sdr_operator *op, int derivative, int32_t i, int64_t at, sdr_csr *m)
{
  const sdr_support *support = op->shape->support;
  int64_t k = support->row[i];
  for (int own = 0; k < support->row[i + 1] || !own; ++at) {
    if (!own && (k == support->row[i + 1] || support->column[k] > i)) {
      own = 1;
      m->column[at] = i;
      m->value[at] = derivative == SDR_VALUE
                         ? 1.0
                         : op->centre[(size_t)i * (size_t)op->terms + (size_t)derivative];
    } else {
      m->column[at] = support->column[k];
      m->value[at] = derivative == SDR_VALUE ? 0.0 : op->weight[k * op->terms + derivative];
      ++k;
    }
  }
  return at;
}

sdr_status sdr_operator_matrix(const sdr_operator *op, int derivative, sdr_csr *out)
{
  const sdr_support *support = op->shape->support;
  const int32_t count = support->cloud.count;
  const size_t entries = (size_t)(support->row[count] + count);
  sdr_csr made = {.rows = count, .columns = count};
  made.row = sdr_alloc((size_t)count + 1, sizeof *made.row);
  made.column = sdr_alloc(entries, sizeof *made.column);
  made.value = sdr_alloc(entries, sizeof *made.value);
  if (!made.row || !made.column || !made.value) {
    sdr_csr_destroy(&made);
    return SDR_RUN_FAILED;
  }
  for (int32_t i = 0; i < count; ++i)
    made.row[i + 1] = fill_row(op, derivative, i, made.row[i], &made);
  *out = made;
  return SDR_OK;
}
