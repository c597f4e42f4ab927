#include "support/plain_reference.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "nom/neighbourhood.h"

#include <math.h>

enum { TASKS = 64 };

/* ---- the kernel ------------------------------------------------------------------------------ */

/* C_i (1-d_i)^2 + C_j (1-d_j)^2, or what the law has of it. */
static double stiffness_left(bench_plain *p, int32_t i, int32_t j, int64_t b, double s)
{
  const double ci = p->stiffness[i], cj = p->stiffness[j];
  const double qi = p->threshold[i], qj = p->threshold[j];
  if (p->law == SDR_LAW_VARIATIONAL) {
    if ((float)s > p->stretch[b]) p->stretch[b] = (float)s;
    const double k = (double)p->stretch[b];
    if (s <= 0.0) return ci + cj;
    const double intact_i = qi / (k * k + qi), intact_j = qj / (k * k + qj);
    return ci * intact_i * intact_i + cj * intact_j * intact_j;
  }
  if (p->law == SDR_LAW_CRITICAL_STRETCH) {
    if (s > 0.0 && s * s > qi) p->lost[b] |= 1;
    if (s > 0.0 && s * s > qj) p->lost[b] |= 2;
    return (p->lost[b] & 1 ? 0.0 : ci) + (p->lost[b] & 2 ? 0.0 : cj);
  }
  return ci + cj;
}

static void force_of_point(bench_plain *p, int32_t i)
{
  double sum[3] = {0.0};
  for (int64_t b = p->row[i]; b < p->row[i + 1]; ++b) {
    const int32_t j = p->column[b];
    double y[3], reference = 0.0, present = 0.0, grown = 0.0;
    for (int a = 0; a < p->components; ++a) {
      const double xi = p->x[a][j] - p->x[a][i], eta = p->u[a][j] - p->u[a][i];
      y[a] = xi + eta;
      reference += xi * xi;
      present += y[a] * y[a];
      grown += (2.0 * xi + eta) * eta;
    }
    const double length = sqrt(reference), now = sqrt(present);
    const double s = grown / (length * (length + now)); /* (now - length)/length */
    const double left = stiffness_left(p, i, j, b, s);
    const double share = left * s * p->volume[i] * p->volume[j] / now;
    for (int a = 0; a < p->components; ++a) sum[a] += share * y[a];
  }
  for (int a = 0; a < p->components; ++a) p->f[a][i] = sum[a];
}

static void force_task(void *context, int k)
{
  bench_plain *p = context;
  const int64_t count = p->count;
  for (int64_t i = count * k / TASKS; i < count * (k + 1) / TASKS; ++i)
    force_of_point(p, (int32_t)i);
}

void bench_plain_force(bench_plain *plain)
{
  sdr_parallel_for(0, TASKS, 1, force_task, plain);
}

typedef struct {
  bench_plain *plain;
  double dt;
} move_call;

static void move_task(void *context, int k)
{
  const move_call *call = context;
  const bench_plain *p = call->plain;
  const int64_t count = p->count;
  for (int a = 0; a < p->components; ++a)
    for (int64_t i = count * k / TASKS; i < count * (k + 1) / TASKS; ++i) {
      p->v[a][i] += call->dt * p->f[a][i] / p->mass[i];
      p->u[a][i] += call->dt * p->v[a][i];
    }
}

void bench_plain_step(bench_plain *plain, double dt)
{
  move_call call = {plain, dt};
  sdr_parallel_for(0, TASKS, 1, move_task, &call);
  bench_plain_force(plain);
}

/* ---- creation -------------------------------------------------------------------------------- */

static int alloc_points(bench_plain *p)
{
  const size_t n = (size_t)p->count;
  int failed = !(p->row = sdr_alloc(n + 1, sizeof *p->row));
  for (int a = 0; a < p->components; ++a) {
    failed |= !(p->x[a] = sdr_alloc(n, sizeof(double)));
    failed |= !(p->u[a] = sdr_alloc(n, sizeof(double)));
    failed |= !(p->v[a] = sdr_alloc(n, sizeof(double)));
    failed |= !(p->f[a] = sdr_alloc(n, sizeof(double)));
  }
  failed |= !(p->volume = sdr_alloc(n, sizeof(double)));
  failed |= !(p->mass = sdr_alloc(n, sizeof(double)));
  failed |= !(p->stiffness = sdr_alloc(n, sizeof(double)));
  failed |= !(p->threshold = sdr_alloc(n, sizeof(double)));
  return failed;
}

static int alloc_bonds(bench_plain *p, int64_t bonds)
{
  int failed = !(p->column = sdr_alloc((size_t)bonds, sizeof *p->column));
  if (p->law == SDR_LAW_VARIATIONAL)
    failed |= !(p->stretch = sdr_alloc((size_t)bonds, sizeof *p->stretch));
  if (p->law == SDR_LAW_CRITICAL_STRETCH) failed |= !(p->lost = sdr_alloc((size_t)bonds, 1));
  return failed;
}

/* Point k of `p` is the body's point i. */
static void copy_point(bench_plain *p, int32_t k, const bench_body *body, int32_t i)
{
  const sdr_bond_body *bonds = &((const sdr_bond_model *)body->model)->body;
  for (int a = 0; a < p->components; ++a) {
    p->x[a][k] = body->points->x[a][i];
    p->u[a][k] = body->system->u[a][i];
  }
  p->volume[k] = body->points->volume[i];
  p->mass[k] = body->system->mass[i];
  p->stiffness[k] = sdr_body_stiffness(bonds, i);
  p->threshold[k] = sdr_body_threshold(bonds, i);
}

static void copy_rows(bench_plain *p, const sdr_neighbourhood *near, const int32_t *place)
{
  for (int32_t k = 0; k < p->count; ++k) {
    const int32_t i = p->original ? p->original[k] : k;
    int64_t b = p->row[k];
    for (int64_t c = near->row[i]; c < near->row[i + 1]; ++c)
      p->column[b++] = place ? place[near->column[c]] : near->column[c];
    p->row[k + 1] = b;
  }
}

static sdr_status fill(bench_plain *p, const bench_body *body, const sdr_neighbourhood *near)
{
  int32_t *place = NULL; /* of the body's points, in `p` */
  if (alloc_points(p) || alloc_bonds(p, near->row[p->count])) return SDR_RUN_FAILED;
  if (p->original) {
    if (!(place = sdr_alloc((size_t)p->count, sizeof *place))) return SDR_RUN_FAILED;
    for (int32_t k = 0; k < p->count; ++k) place[p->original[k]] = k;
  }
  for (int32_t k = 0; k < p->count; ++k) copy_point(p, k, body, p->original ? p->original[k] : k);
  copy_rows(p, near, place);
  sdr_free(place);
  return SDR_OK;
}

sdr_status bench_plain_create(const bench_body *body, int shuffled, bench_plain *out)
{
  bench_plain p = {.count = body->points->count,
                   .components = body->points->components,
                   .law = ((const sdr_bond_model *)body->model)->body.law};
  sdr_neighbourhood near = {0};
  sdr_status status = sdr_neighbourhood_create(body->points, &near);
  if (status == SDR_OK && shuffled && !(p.original = bench_shuffle(p.count)))
    status = SDR_RUN_FAILED;
  if (status == SDR_OK) status = fill(&p, body, &near);
  sdr_neighbourhood_destroy(&near);
  if (status != SDR_OK) {
    bench_plain_destroy(&p);
    return status;
  }
  bench_plain_force(&p);
  *out = p;
  return SDR_OK;
}

void bench_plain_destroy(bench_plain *plain)
{
  sdr_free(plain->row);
  sdr_free(plain->column);
  for (int a = 0; a < 3; ++a) {
    sdr_free(plain->x[a]);
    sdr_free(plain->u[a]);
    sdr_free(plain->v[a]);
    sdr_free(plain->f[a]);
  }
  sdr_free(plain->volume);
  sdr_free(plain->mass);
  sdr_free(plain->stiffness);
  sdr_free(plain->threshold);
  sdr_free(plain->stretch);
  sdr_free(plain->lost);
  sdr_free(plain->original);
  *plain = (bench_plain){0};
}
