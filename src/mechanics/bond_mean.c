#include "mechanics/bond_mean.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "mechanics/bond_internal.h"
#include "mechanics/bond_mean_loop.h"
#include "mechanics/isa.h"

#include <string.h>

struct sdr_mean_kept {
  double *run_g, *run_h, *loose_g, *loose_h;
  double *at[3];    /* m: of tangent_keep, where the tangent is taken; NULL: never */
  double *block[9]; /* components^2 numbers a point: its diagonal block */
};

static const sdr_mean_kernels *best(void)
{
#ifdef SDR_HAVE_X86_KERNELS
  const int level = sdr_isa_level();
  if (level == 2) return &sdr_mean_kernels_avx512;
  if (level == 1) return &sdr_mean_kernels_avx2;
#endif
  return &sdr_mean_kernels_baseline;
}

/* ---- what is kept ---------------------------------------------------------------------------- */

void sdr_mean_kept_destroy(sdr_mean_kept **kept)
{
  sdr_mean_kept *k = *kept;
  if (!k) return;
  sdr_free(k->run_g);
  sdr_free(k->run_h);
  sdr_free(k->loose_g);
  sdr_free(k->loose_h);
  for (int c = 0; c < 9; ++c) sdr_free(k->block[c]);
  for (int a = 0; a < 3; ++a) sdr_free(k->at[a]);
  sdr_free(k);
  *kept = NULL;
}

static sdr_status make_kept(sdr_bond_model *model)
{
  const size_t runs = (size_t)model->bonds->run_slots;
  const size_t loose = (size_t)model->bonds->loose.slot_count;
  if (model->mean) return SDR_OK;
  sdr_mean_kept *kept = sdr_alloc(1, sizeof *kept);
  if (!kept) return SDR_RUN_FAILED;
  kept->run_g = sdr_alloc(runs, sizeof(double));
  kept->run_h = sdr_alloc(runs, sizeof(double));
  kept->loose_g = sdr_alloc(loose, sizeof(double));
  kept->loose_h = sdr_alloc(loose, sizeof(double));
  int failed = !kept->run_g || !kept->run_h || !kept->loose_g || !kept->loose_h;
  for (int c = 0; c < model->head.points->components * model->head.points->components; ++c)
    failed |= !(kept->block[c] = sdr_alloc(sdr_points_padded(model->head.points), sizeof(double)));
  if (failed) {
    sdr_mean_kept_destroy(&kept);
    return SDR_RUN_FAILED;
  }
  model->mean = kept;
  return SDR_OK;
}

/* ---- forces and products --------------------------------------------------------------------- */

typedef struct {
  const sdr_bond_model *model;
  sdr_mean_kernel runs, loose;
  sdr_mean_step step;
} mean_call;

static void runs_of_stripe(void *context, int s)
{
  const mean_call *call = context;
  const int64_t *stripe = call->model->bonds->stripe_run;
  call->runs(&call->model->body, stripe[s], stripe[s + 1], &call->step);
}

static void loose_of_stripe(void *context, int s)
{
  const mean_call *call = context;
  int64_t first, end;
  sdr_stripe_chunks(&call->model->body, s, &first, &end);
  call->loose(&call->model->body, first, end, &call->step);
}

/* Even stripes first, then odd ones, which add to the next; chunks add to their own points only. */
static void run_call(mean_call *call)
{
  const sdr_points *points = call->model->head.points;
  for (int a = 0; a < points->components; ++a)
    memset(call->step.out[a], 0, (size_t)points->count * sizeof(double));
  sdr_each_stripe(points, runs_of_stripe, call);
  if (call->model->bonds->loose.chunk_count > 0)
    sdr_parallel_for(0, points->stripe_count, 1, loose_of_stripe, call);
}

static void compute(const sdr_bond_model *model, int keep, double *const u0[3], double *const u1[3],
                    double *const f[3])
{
  const sdr_mean_kernels *kernels = best();
  const sdr_bond_body *body = &model->body;
  const int n = model->head.points->components, each = body->stiffness_at != NULL;
  const sdr_mean_kept *kept = model->mean;
  mean_call call = {.model = model,
                    .runs = kernels->run_force[body->law][n - 1][each][keep],
                    .loose = kernels->loose_force[body->law][n - 1][each][keep],
                    .step = {.u0 = u0, .u1 = u1, .out = f}};
  if (keep) {
    call.step.run_g = kept->run_g;
    call.step.run_h = kept->run_h;
    call.step.loose_g = kept->loose_g;
    call.step.loose_h = kept->loose_h;
  }
  run_call(&call);
}

void sdr_bond_mean_force(sdr_model *model, double *const u0[3], double *const u1[3],
                         double *const f[3])
{
  compute((const sdr_bond_model *)model, 0, u0, u1, f);
}

sdr_status sdr_bond_mean_keep(sdr_model *model, double *const u0[3], double *const u1[3],
                              double *const f[3])
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  SDR_TRY(make_kept(bond));
  compute(bond, 1, u0, u1, f);
  return SDR_OK;
}

void sdr_bond_mean_times(sdr_model *model, double *const u0[3], double *const u1[3],
                         double *const v[3], double *const out[3])
{
  const sdr_bond_model *bond = (const sdr_bond_model *)model;
  const sdr_mean_kernels *kernels = best();
  const sdr_mean_kept *kept = bond->mean;
  const int n = model->points->components;
  mean_call call = {.model = bond,
                    .runs = kernels->run_times[n - 1],
                    .loose = kernels->loose_times[n - 1],
                    .step = {.u0 = u0,
                             .u1 = u1,
                             .v = v,
                             .out = out,
                             .run_g = kept->run_g,
                             .run_h = kept->run_h,
                             .loose_g = kept->loose_g,
                             .loose_h = kept->loose_h}};
  run_call(&call);
}

/* ---- tangent of a state ---------------------------------------------------------------------- */

static void keep_pair(void *context, const sdr_pair *pair)
{
  const sdr_bond_model *model = context;
  const sdr_mean_kept *kept = model->mean;
  double n[3], a, b, square = 0.0;
  sdr_bond_pair_tangent(&model->body, pair, kept->at, n, &a, &b);
  for (int c = 0; c < model->head.points->components; ++c) {
    const double y = pair->xi[c] + kept->at[c][pair->j] - kept->at[c][pair->i];
    square += y * y;
  }
  (pair->loose ? kept->loose_g : kept->run_g)[pair->slot] = b;
  (pair->loose ? kept->loose_h : kept->run_h)[pair->slot] =
      square > 0.0 ? 0.5 * (a - b) / square : 0.0;
}

static void keep_stripe(void *context, int s)
{
  const sdr_bond_model *model = context;
  sdr_bonds_visit_stripe(model->bonds, model->head.points, s, keep_pair, context);
}

sdr_status sdr_bond_tangent_keep(sdr_model *model, double *const u[3])
{
  sdr_bond_model *bond = (sdr_bond_model *)model;
  const sdr_points *points = model->points;
  const size_t padded = sdr_points_padded(points);
  SDR_TRY(make_kept(bond));
  for (int a = 0; a < points->components; ++a) {
    double **at = &bond->mean->at[a];
    if (!*at && !(*at = sdr_alloc(padded, sizeof **at))) return SDR_RUN_FAILED;
    memcpy(*at, u[a], padded * sizeof **at);
  }
  sdr_parallel_for(0, points->stripe_count, 1, keep_stripe, bond);
  return SDR_OK;
}

void sdr_bond_kept_times(sdr_model *model, double *const v[3], double *const out[3])
{
  const sdr_mean_kept *kept = ((const sdr_bond_model *)model)->mean;
  sdr_bond_mean_times(model, kept->at, kept->at, v, out);
}

void sdr_bond_kept_diagonal(sdr_model *model, double *out)
{
  const sdr_mean_kept *kept = ((const sdr_bond_model *)model)->mean;
  sdr_bond_mean_diagonal(model, kept->at, kept->at, out);
}

/* ---- blocks ---------------------------------------------------------------------------------- */

typedef struct {
  const sdr_bond_model *model;
  double *const *u0, *const *u1;
  sdr_hessian_visitor visit;
  void *context;
} block_call;

/* [g I + h (y0 + y1) (x) y1] of a pair. */
static void fill_block(const block_call *call, const sdr_pair *pair, double g, double h,
                       double block[9])
{
  const int m = call->model->head.points->components;
  double sum[3], now[3];
  for (int a = 0; a < m; ++a) {
    const double e1 = call->u1[a][pair->j] - call->u1[a][pair->i];
    now[a] = pair->xi[a] + e1;
    sum[a] = now[a] + pair->xi[a] + (call->u0[a][pair->j] - call->u0[a][pair->i]);
  }
  for (int r = 0; r < m; ++r)
    for (int c = 0; c < m; ++c) block[r * m + c] = (r == c ? g : 0.0) + h * sum[r] * now[c];
}

/* Of a loose slot, to its own point: the other has a slot as well. */
static void diagonal_of_slot(void *context, const sdr_pair *pair)
{
  const block_call *call = context;
  const sdr_mean_kept *kept = call->model->mean;
  const int m = call->model->head.points->components;
  double block[9];
  if (!pair->loose) return;
  fill_block(call, pair, kept->loose_g[pair->slot], kept->loose_h[pair->slot], block);
  for (int c = 0; c < m * m; ++c) kept->block[c][pair->i] += block[c];
}

static void loose_diagonal_of_stripe(void *context, int s)
{
  const block_call *call = context;
  const int32_t *first = call->model->head.points->stripe_first;
  for (int32_t i = first[s]; i < first[s + 1]; ++i)
    sdr_bonds_visit_loose_point(call->model->bonds, i, diagonal_of_slot, context);
}

void sdr_bond_mean_diagonal(sdr_model *model, double *const u0[3], double *const u1[3], double *out)
{
  const sdr_bond_model *bond = (const sdr_bond_model *)model;
  const sdr_points *points = model->points;
  const sdr_mean_kept *kept = bond->mean;
  const int m = points->components;
  mean_call call = {
      .model = bond,
      .runs = best()->run_diagonal[m - 1],
      .step = {.u0 = u0, .u1 = u1, .out = kept->block, .run_g = kept->run_g, .run_h = kept->run_h}};
  block_call slots = {.model = bond, .u0 = u0, .u1 = u1};
  for (int c = 0; c < m * m; ++c) memset(kept->block[c], 0, (size_t)points->count * sizeof(double));
  sdr_each_stripe(points, runs_of_stripe, &call);
  if (bond->bonds->loose.chunk_count > 0)
    sdr_parallel_for(0, points->stripe_count, 1, loose_diagonal_of_stripe, &slots);
  for (int32_t i = 0; i < points->count; ++i)
    for (int c = 0; c < m * m; ++c) out[i * (m * m) + c] = kept->block[c][i];
}

static void pair_constants(const sdr_bond_body *body, const sdr_pair *pair, sdr_mean_pair *out)
{
  const double *history = pair->loose ? body->loose_history : body->history;
  const sdr_flags *flags = pair->loose ? body->loose_flags : body->flags;
  *out = (sdr_mean_pair){.length = pair->length,
                         .wi = pair->weight_ij * sdr_body_stiffness(body, pair->i),
                         .wj = pair->weight_ji * sdr_body_stiffness(body, pair->j),
                         .qi = sdr_body_threshold(body, pair->i),
                         .qj = sdr_body_threshold(body, pair->j),
                         .ri = sdr_body_decline(body, pair->i),
                         .rj = sdr_body_decline(body, pair->j),
                         .before = history ? history[pair->slot] : 0.0,
                         .flags = flags ? flags[pair->slot] : 0};
}

/* Relative displacement of a pair. */
static sdr_precise_vector motion_of(const sdr_pair *pair, int m, double *const u[3])
{
  double e[3] = {0.0};
  for (int a = 0; a < m; ++a) e[a] = u[a][pair->j] - u[a][pair->i];
  return (sdr_precise_vector){e[0], e[1], e[2]};
}

static void block_of_pair(void *context, const sdr_pair *pair)
{
  const block_call *call = context;
  const int m = call->model->head.points->components;
  const int32_t ends[2] = {pair->i, pair->j};
  const double square = 1.0 / (pair->length * pair->length);
  const sdr_precise_vector xi = {pair->xi[0], pair->xi[1], pair->xi[2]};
  double own[9], block[36];
  sdr_mean_pair constants;
  if (!pair->primary) return;
  pair_constants(&call->model->body, pair, &constants);
  const sdr_mean_factors of_step =
      mean_of_pair((int)call->model->body.law, 1, 1, &constants,
                   mean_stretch(m, xi, motion_of(pair, m, call->u0), square),
                   mean_stretch(m, xi, motion_of(pair, m, call->u1), square));
  fill_block(call, pair, of_step.g, of_step.h, own);
  for (int r = 0; r < m; ++r)
    for (int c = 0; c < m; ++c) {
      const double k = own[r * m + c];
      block[r * 2 * m + c] = block[(r + m) * 2 * m + c + m] = k;
      block[r * 2 * m + c + m] = block[(r + m) * 2 * m + c] = -k;
    }
  call->visit(call->context, 2, ends, block);
}

sdr_status sdr_bond_visit_mean_tangent(sdr_model *model, double *const u0[3], double *const u1[3],
                                       sdr_hessian_visitor visit, void *context)
{
  block_call call = {.model = (const sdr_bond_model *)model,
                     .u0 = u0,
                     .u1 = u1,
                     .visit = visit,
                     .context = context};
  sdr_bonds_visit(call.model->bonds, model->points, block_of_pair, &call);
  return SDR_OK;
}
