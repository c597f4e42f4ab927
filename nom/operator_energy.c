#include "nom/operator_energy.h"

#include "base/memory.h"

#include <math.h>

/* V_i P_i / m_i. */
static double factor_at(const sdr_shape_tensors *shape, const double *coefficient, int32_t i)
{
  const sdr_support *support = shape->support;
  double m = 0.0, p[SDR_MOST_TERMS], r[3];
  for (int64_t k = support->row[i]; k < support->row[i + 1]; ++k) {
    const double w = sdr_shape_entry(shape, i, k, r, p);
    m += w * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
  }
  return coefficient[i] * (support->cloud.volume ? support->cloud.volume[i] : 1.0) / m;
}

/* ---- of a field ------------------------------------------------------------------------------ */

/* The scaled derivatives h^|a|/a! D_a u at i. */
static void taylor_at(const sdr_shape_tensors *shape, int32_t i, const double *u, double *x)
{
  const sdr_support *support = shape->support;
  double p[SDR_MOST_TERMS], r[3];
  for (int a = 0; a < shape->set.count; ++a) x[a] = 0.0;
  for (int64_t k = support->row[i]; k < support->row[i + 1]; ++k) {
    const double w = sdr_shape_entry(shape, i, k, r, p) * (u[support->column[k]] - u[i]);
    for (int a = 0; a < shape->set.count; ++a) x[a] += w * p[a];
  }
  sdr_shape_solve(shape, i, x, x);
}

/* w V_j and what of u_j - u_i the Taylor polynomial leaves, for the k-th entry. */
static double residual(const sdr_shape_tensors *shape, int32_t i, int64_t k, const double *u,
                       const double *taylor, double *w)
{
  double p[SDR_MOST_TERMS], r[3];
  *w = sdr_shape_entry(shape, i, k, r, p);
  double left = u[shape->support->column[k]] - u[i];
  for (int a = 0; a < shape->set.count; ++a) left -= p[a] * taylor[a];
  return left;
}

double sdr_operator_energy(const sdr_shape_tensors *shape, const double *coefficient,
                           const double *u)
{
  const sdr_support *support = shape->support;
  double energy = 0.0;
  for (int32_t i = 0; i < support->cloud.count; ++i) {
    double taylor[SDR_MOST_TERMS], squares = 0.0;
    taylor_at(shape, i, u, taylor);
    for (int64_t k = support->row[i]; k < support->row[i + 1]; ++k) {
      double w;
      const double left = residual(shape, i, k, u, taylor, &w);
      squares += w * left * left;
    }
    energy += 0.5 * factor_at(shape, coefficient, i) * squares;
  }
  return energy;
}

void sdr_operator_energy_gradient(const sdr_shape_tensors *shape, const double *coefficient,
                                  const double *u, double *gradient)
{
  const sdr_support *support = shape->support;
  for (int32_t i = 0; i < support->cloud.count; ++i) {
    double taylor[SDR_MOST_TERMS];
    const double factor = factor_at(shape, coefficient, i);
    taylor_at(shape, i, u, taylor);
    for (int64_t k = support->row[i]; k < support->row[i + 1]; ++k) {
      double w;
      const double push = factor * residual(shape, i, k, u, taylor, &w) * w;
      gradient[support->column[k]] += push;
      gradient[i] -= push;
    }
  }
}

/* ---- its matrix ------------------------------------------------------------------------------ */

/* Second derivative of the energy of point i by u of its neighbours and, last, its own:
   `size` = neighbours + 1 rows. y: scratch, `size` times terms values and as many weights. */
static void local_matrix(const sdr_shape_tensors *shape, int32_t i, double factor, double *y,
                         double *local)
{
  const int n = shape->set.count;
  const int64_t first = shape->support->row[i], neighbours = shape->support->row[i + 1] - first;
  const int64_t size = neighbours + 1;
  double *w = y + neighbours * n, r[3], p[SDR_MOST_TERMS];
  for (int64_t k = 0; k < neighbours; ++k) {
    w[k] = sdr_shape_entry(shape, i, first + k, r, p);
    sdr_shape_solve(shape, i, p, y + k * n);
  }
  for (int64_t e = 0; e < size * size; ++e) local[e] = 0.0;
  for (int64_t k = 0; k < neighbours; ++k) {
    sdr_shape_entry(shape, i, first + k, r, p);
    for (int64_t l = 0; l <= k; ++l) {
      double projection = 0.0;
      for (int a = 0; a < n; ++a) projection += p[a] * y[l * n + a];
      const double value = factor * w[k] * ((k == l ? 1.0 : 0.0) - w[l] * projection);
      local[k * size + l] = local[l * size + k] = value;
    }
  }
  for (int64_t k = 0; k < neighbours; ++k) { /* constants have no energy */
    double sum = 0.0;
    for (int64_t l = 0; l < neighbours; ++l) sum += local[k * size + l];
    local[k * size + neighbours] = local[neighbours * size + k] = -sum;
    local[size * size - 1] += sum;
  }
}

static sdr_status scatter(const sdr_support *support, int32_t i, int field, const double *local,
                          sdr_csr_builder *matrix)
{
  const int64_t first = support->row[i], neighbours = support->row[i + 1] - first;
  const int32_t shift = field * support->cloud.count;
  for (int64_t k = 0; k <= neighbours; ++k)
    for (int64_t l = 0; l <= neighbours; ++l) {
      const int32_t row = k < neighbours ? support->column[first + k] : i;
      const int32_t column = l < neighbours ? support->column[first + l] : i;
      SDR_TRY(sdr_csr_builder_add(matrix, shift + row, shift + column,
                                  local[k * (neighbours + 1) + l]));
    }
  return SDR_OK;
}

sdr_status sdr_operator_energy_add(const sdr_shape_tensors *shape, const double *coefficient,
                                   int fields, sdr_csr_builder *matrix)
{
  const sdr_support *support = shape->support;
  int64_t most = 0;
  for (int32_t i = 0; i < support->cloud.count; ++i) {
    const int64_t neighbours = support->row[i + 1] - support->row[i];
    if (neighbours > most) most = neighbours;
  }
  const size_t size = (size_t)most + 1;
  double *y = sdr_alloc(size * (size_t)(shape->set.count + 1), sizeof *y);
  double *local = sdr_alloc(size * size, sizeof *local);
  sdr_status status = y && local ? SDR_OK : SDR_RUN_FAILED;
  for (int32_t i = 0; i < support->cloud.count && status == SDR_OK; ++i) {
    const double factor = factor_at(shape, coefficient, i);
    if (factor == 0.0) continue;
    local_matrix(shape, i, factor, y, local);
    for (int p = 0; p < fields && status == SDR_OK; ++p)
      status = scatter(support, i, p, local, matrix);
  }
  sdr_free(y);
  sdr_free(local);
  return status;
}
