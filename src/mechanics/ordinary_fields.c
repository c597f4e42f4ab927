/* Fields of ordinary bodies over their points: what energies share, and stress, strain and
   dilatation. */
#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/ordinary.h"

#include <math.h>
#include <string.h>

/* Places of xx, yy, xy | xx, yy, zz, yz, xz, xy | xx. */
static const int order[3][6][2] = {
    {{0, 0}}, {{0, 0}, {1, 1}, {0, 1}}, {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};

typedef struct {
  const sdr_ordinary *o;
  double *const *u;
  double *sum[9]; /* n^2 accumulators over points */
  double *shape[9];
} field_call;

static void sums_of_stripe(const field_call *call, int s, sdr_pair_visitor visit)
{
  sdr_bonds_visit_stripe(call->o->body.bonds, call->o->body.head.points, s, visit,
                         (void *)(uintptr_t)call);
}

/* ---- stress ---------------------------------------------------------------------------------- */

/* The stress of a point is the derivative of its own energy density by a strain of its family: sum
   of (dE/ds n/|xi|) (x) xi over H_i, per volume, symmetric part. Forces of neighbours' energies on
   it are theirs. */
static void add_half_stress(const field_call *call, const sdr_pair *pair, int32_t point,
                            double weight)
{
  const sdr_ordinary *o = call->o;
  const int n = o->body.head.points->components;
  const double s = sdr_pair_stretch(pair, n, call->u), l = pair->length * (1.0 + s);
  const double pull = sdr_ordinary_p(o, pair, weight) * o->along[point] +
                      sdr_ordinary_q(o, pair, weight) * o->across[point] * s;
  if (!(l > 0.0)) return;
  double f[3] = {0.0};
  for (int a = 0; a < n; ++a)
    f[a] = pull / (pair->length * l) * (pair->xi[a] + call->u[a][pair->j] - call->u[a][pair->i]);
  for (int k = 0; k < n * (n + 1) / 2; ++k) {
    const int a = order[n - 1][k][0], b = order[n - 1][k][1];
    call->sum[k][point] += 0.5 * (f[a] * pair->xi[b] + f[b] * pair->xi[a]);
  }
}

static void add_stress(void *context, const sdr_pair *pair)
{
  const field_call *call = context;
  const sdr_flags lost = sdr_state_lost(&call->o->body, pair, 0.0, 0);
  if (!(lost & SDR_LOST_I)) add_half_stress(call, pair, pair->i, pair->weight_ij);
  if (!(lost & SDR_LOST_J) && !pair->loose) add_half_stress(call, pair, pair->j, pair->weight_ji);
}

static void stress_of_stripe(void *context, int s)
{
  sums_of_stripe(context, s, add_stress);
}

static void stress(sdr_ordinary *o, field_call *call, double *out)
{
  const sdr_points *points = o->body.head.points;
  const int n = points->components;
  sdr_ordinary_sum(o, call->u, SDR_FLAGS_KEEP, 1);
  o->kernels->points[o->body.law](o, 0, points->count, 0);
  sdr_each_stripe(points, stress_of_stripe, call);
  for (int k = 0; k < n * (n + 1) / 2; ++k)
    for (int32_t i = 0; i < points->count; ++i)
      out[(size_t)k * (size_t)points->count + (size_t)i] = call->sum[k][i] / points->volume[i];
}

/* ---- strain ---------------------------------------------------------------------------------- */

/* sum of w xi (x) xi and of w eta (x) xi over the bonds that are left. */
static void add_half_gradient(const field_call *call, const sdr_pair *pair, int32_t point,
                              double weight)
{
  const int n = call->o->body.head.points->components;
  for (int a = 0; a < n; ++a) {
    const double eta = call->u[a][pair->j] - call->u[a][pair->i];
    for (int b = 0; b < n; ++b) {
      call->sum[a * n + b][point] += weight * eta * pair->xi[b];
      call->shape[a * n + b][point] += weight * pair->xi[a] * pair->xi[b];
    }
  }
}

static void add_gradient(void *context, const sdr_pair *pair)
{
  const field_call *call = context;
  const sdr_flags lost = sdr_state_lost(&call->o->body, pair, 0.0, 0);
  if (!(lost & SDR_LOST_I)) add_half_gradient(call, pair, pair->i, pair->weight_ij);
  if (!(lost & SDR_LOST_J) && !pair->loose) add_half_gradient(call, pair, pair->j, pair->weight_ji);
}

static void gradient_of_stripe(void *context, int s)
{
  sums_of_stripe(context, s, add_gradient);
}

/* x K = g for a symmetric K of n rows, by elimination with row exchange; 0 if K is singular. */
static int solve(int n, const double *k, const double *g, double *x)
{
  double m[3][6];
  double trace = 0.0;
  for (int a = 0; a < n; ++a) {
    trace += k[a * n + a];
    for (int b = 0; b < n; ++b) {
      m[a][b] = k[a * n + b];
      m[a][n + b] = g[b * n + a];
    }
  }
  for (int c = 0; c < n; ++c) {
    int most = c;
    for (int r = c + 1; r < n; ++r)
      if (fabs(m[r][c]) > fabs(m[most][c])) most = r;
    if (!(fabs(m[most][c]) > 1e-10 * trace)) return 0;
    for (int b = 0; b < 2 * n; ++b) {
      const double kept = m[c][b];
      m[c][b] = m[most][b];
      m[most][b] = kept;
    }
    for (int r = 0; r < n; ++r) {
      const double factor = m[r][c] / m[c][c];
      for (int b = c; r != c && b < 2 * n; ++b) m[r][b] -= factor * m[c][b];
    }
  }
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) x[a * n + b] = m[b][n + a] / m[b][b];
  return 1;
}

/* Zero where the family determines no gradient. */
static void strain(sdr_ordinary *o, field_call *call, double *out)
{
  const sdr_points *points = o->body.head.points;
  const int n = points->components;
  sdr_each_stripe(points, gradient_of_stripe, call);
  for (int32_t i = 0; i < points->count; ++i) {
    double k[9], moment[9], g[9] = {0.0};
    for (int c = 0; c < n * n; ++c) {
      k[c] = call->shape[c][i];
      moment[c] = call->sum[c][i];
    }
    if (!solve(n, k, moment, g)) memset(g, 0, sizeof g);
    for (int c = 0; c < n * (n + 1) / 2; ++c) {
      const int a = order[n - 1][c][0], b = order[n - 1][c][1];
      out[(size_t)c * (size_t)points->count + (size_t)i] = 0.5 * (g[a * n + b] + g[b * n + a]);
    }
  }
}

/* theta of theory sec. 5, of the bonds that are left. */
static void dilatation(sdr_ordinary *o, double *const u[3], double *out)
{
  sdr_ordinary_sum(o, u, SDR_FLAGS_KEEP, 1);
  for (int32_t i = 0; i < o->body.head.points->count; ++i) {
    const double left = o->lost ? o->whole[i] - o->lost[i] : o->whole[i];
    out[i] = left > 1e-12 * o->whole[i] ? o->t[i] * o->sum[i] * o->whole[i] / left : 0.0;
  }
}

sdr_status sdr_ordinary_field(sdr_model *model, double *const u[3], sdr_model_field which,
                              double *out)
{
  sdr_ordinary *o = (sdr_ordinary *)model;
  const size_t padded = sdr_points_padded(model->points);
  if (which == SDR_FIELD_DILATATION) {
    dilatation(o, u, out);
    return SDR_OK;
  }
  if (which != SDR_FIELD_STRESS && which != SDR_FIELD_STRAIN)
    return sdr_state_field(model, u, which, out);
  double *store = sdr_alloc(18 * padded, sizeof *store);
  if (!store) return SDR_RUN_FAILED;
  field_call call = {.o = o, .u = u};
  for (size_t k = 0; k < 9; ++k) {
    call.sum[k] = store + k * padded;
    call.shape[k] = store + (9 + k) * padded;
  }
  if (which == SDR_FIELD_STRESS)
    stress(o, &call, out);
  else
    strain(o, &call, out);
  sdr_free(store);
  return SDR_OK;
}
