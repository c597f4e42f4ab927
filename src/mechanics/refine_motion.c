#include "mechanics/refine_motion.h"

#include "base/memory.h"
#include "base/small.h"

#include <math.h>
#include <string.h>

/* Sums over the pairs of a point that splits: xi xi^T, eta xi^T and the same of velocities. */
typedef struct {
  double shape[9], displacement[9], velocity[9];
} moments;

typedef struct {
  const sdr_system *before;
  int32_t *index; /* of each split point in `sums` */
  moments *sums;
} gradient_call;

/* Velocity at the system's time. */
static double velocity_now(const sdr_system *system, int a, int32_t i)
{
  if (system->velocity_offset == 0.0) return system->v[a][i];
  return system->v[a][i] - system->velocity_offset * system->f[a][i] / system->mass[i];
}

static void add_pair(void *context, int32_t i, int32_t j, double intact)
{
  const gradient_call *call = context;
  const sdr_system *system = call->before;
  const sdr_points *points = system->model->points;
  const int n = system->components;
  moments *sum = &call->sums[call->index[i]];
  double xi[3], v[3], square = 0.0;
  for (int a = 0; a < n; ++a) {
    xi[a] = points->x[a][j] - points->x[a][i];
    v[a] = velocity_now(system, a, j) - velocity_now(system, a, i);
    square += xi[a] * xi[a];
  }
  const double weight = intact * points->volume[j] / (square * square);
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      sum->shape[3 * a + b] += weight * xi[a] * xi[b];
      sum->displacement[3 * a + b] += weight * (system->u[a][j] - system->u[a][i]) * xi[b];
      sum->velocity[3 * a + b] += weight * v[a] * xi[b];
    }
}

/* The gradients in place of the moments; 0 where too few pairs hold. */
static void solve(int n, moments *sum)
{
  double inverse[9], k[9] = {0.0};
  for (int a = 0; a < 3; ++a) k[4 * a] = 1.0;
  const double trace = sum->shape[0] + sum->shape[4] + sum->shape[8];
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) k[3 * a + b] = sum->shape[3 * a + b] / (trace > 0.0 ? trace : 1.0);
  const double det = sdr_invert3(k, inverse);
  if (!(det > 1e-6)) {
    memset(sum, 0, sizeof *sum);
    return;
  }
  double *const both[2] = {sum->displacement, sum->velocity};
  for (int f = 0; f < 2; ++f) {
    double g[9] = {0.0};
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b)
        for (int c = 0; c < n; ++c) g[3 * a + b] += both[f][3 * a + c] * inverse[3 * c + b] / trace;
    memcpy(both[f], g, sizeof g);
  }
}

static sdr_status find_gradients(gradient_call *call, const sdr_point_map *map)
{
  const sdr_model *model = call->before->model;
  uint8_t *at = sdr_alloc((size_t)map->before, 1);
  int32_t count = 0;
  call->index = sdr_alloc((size_t)map->before, sizeof *call->index);
  for (int32_t p = 0; at && call->index && p < map->before; ++p)
    if (sdr_splits(map, p)) {
      at[p] = 1;
      call->index[p] = count++;
    }
  call->sums = sdr_alloc((size_t)count, sizeof *call->sums);
  const int failed = !at || !call->index || !call->sums;
  if (!failed) {
    model->ops->visit_held(model, call->before->u, at, add_pair, call);
    for (int32_t k = 0; k < count; ++k) solve(call->before->components, &call->sums[k]);
  }
  sdr_free(at);
  return failed ? SDR_RUN_FAILED : SDR_OK;
}

static void set_children(const gradient_call *call, const sdr_point_map *map, sdr_system *now)
{
  const sdr_system *before = call->before;
  double *const *x = now->model->points->x, *const *x_before = before->model->points->x;
  for (int32_t i = 0; i < now->count; ++i) {
    const int32_t p = map->parent[i];
    const moments *sum = sdr_is_child(map, i) ? &call->sums[call->index[p]] : NULL;
    for (int a = 0; a < now->components; ++a) {
      now->u[a][i] = before->u[a][p];
      now->v[a][i] = velocity_now(before, a, p);
      for (int b = 0; sum && b < now->components; ++b) {
        const double d = x[b][i] - x_before[b][p];
        now->u[a][i] += sum->displacement[3 * a + b] * d;
        now->v[a][i] += sum->velocity[3 * a + b] * d;
      }
    }
  }
}

/* ---- angular momentum ------------------------------------------------------------------------ */

static void current(const sdr_system *system, int32_t i, double y[3], double v[3])
{
  for (int a = 0; a < 3; ++a) {
    const int there = a < system->components;
    y[a] = there ? system->model->points->x[a][i] + system->u[a][i] : 0.0;
    v[a] = there ? system->v[a][i] : 0.0;
  }
}

/* Mass and centre of all children, and the spin that they have over their parents, which is that of
   each family about its own centre. */
static void sum_spin(const sdr_point_map *map, const sdr_system *now, double centre[3],
                     double spin[3])
{
  double mass = 0.0;
  for (int32_t p = 0; p < map->before; ++p) {
    double middle[3] = {0.0}, family = 0.0, y[3], v[3], c[3];
    if (!sdr_splits(map, p)) continue;
    for (int32_t k = map->first_child[p]; k < map->first_child[p + 1]; ++k) {
      const int32_t i = map->child[k];
      current(now, i, y, v);
      for (int a = 0; a < 3; ++a) middle[a] += now->mass[i] * y[a];
      family += now->mass[i];
    }
    mass += family;
    for (int a = 0; a < 3; ++a) {
      centre[a] += middle[a];
      middle[a] /= family;
    }
    for (int32_t k = map->first_child[p]; k < map->first_child[p + 1]; ++k) {
      const int32_t i = map->child[k];
      current(now, i, y, v);
      for (int a = 0; a < 3; ++a) y[a] -= middle[a];
      sdr_cross3(y, v, c);
      for (int a = 0; a < 3; ++a) spin[a] += now->mass[i] * c[a];
    }
  }
  for (int a = 0; a < 3; ++a) centre[a] /= mass > 0.0 ? mass : 1.0;
}

static void add_inertia(const sdr_system *now, int32_t i, const double centre[3], double inertia[9])
{
  double y[3], v[3];
  current(now, i, y, v);
  for (int a = 0; a < 3; ++a) y[a] -= centre[a];
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      inertia[3 * a + b] +=
          now->mass[i] * ((a == b ? y[0] * y[0] + y[1] * y[1] + y[2] * y[2] : 0.0) - y[a] * y[b]);
}

/* Turn all children about their centre so that their spin is gone. In 2-D about z only. */
static void take_spin(const sdr_point_map *map, sdr_system *now)
{
  double centre[3] = {0.0}, spin[3] = {0.0}, inertia[9] = {0.0}, inverse[9], turn[3] = {0.0};
  if (now->components < 2) return;
  sum_spin(map, now, centre, spin);
  for (int32_t i = 0; i < now->count; ++i)
    if (sdr_is_child(map, i)) add_inertia(now, i, centre, inertia);
  if (now->components == 2) {
    turn[2] = inertia[8] > 0.0 ? spin[2] / inertia[8] : 0.0;
  } else {
    if (sdr_invert3(inertia, inverse) == 0.0) return;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) turn[a] += inverse[3 * a + b] * spin[b];
  }
  for (int32_t i = 0; i < now->count; ++i) {
    double y[3], v[3], c[3];
    if (!sdr_is_child(map, i)) continue;
    current(now, i, y, v);
    for (int a = 0; a < 3; ++a) y[a] -= centre[a];
    sdr_cross3(turn, y, c);
    for (int a = 0; a < now->components; ++a) now->v[a][i] -= c[a];
  }
}

static void copy_sums(const sdr_system *before, sdr_system *now)
{
  now->time = before->time;
  now->step = before->step;
  now->time_since = before->time_since;
  now->step_since = before->step_since;
  now->how = before->how;
  now->external_work = before->external_work;
  now->refinement = before->refinement;
  now->viscous = before->viscous;
  memcpy(now->impulse, before->impulse, sizeof now->impulse);
  memcpy(now->angular_impulse, before->angular_impulse, sizeof now->angular_impulse);
}

sdr_status sdr_refine_motion(const sdr_system *before, const sdr_point_map *map, sdr_system *now)
{
  gradient_call call = {.before = before};
  const sdr_status status = find_gradients(&call, map);
  if (status == SDR_OK) {
    set_children(&call, map, now);
    take_spin(map, now);
    copy_sums(before, now);
    now->velocity_offset = 0.0;
  }
  sdr_free(call.index);
  sdr_free(call.sums);
  return status;
}
