#include "support/floor.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "support/report.h"

#include <string.h>

#if defined(__x86_64__)
#define WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define WIDE
#endif

enum { BLOCK = 256, TASKS = 64, TRIES = 5 };

/* ---- triad ----------------------------------------------------------------------------------- */

static const int64_t triad_length = 12 * 1024 * 1024; /* 96 MiB an array */

typedef struct {
  double *a, *b, *c;
  int64_t length;
} triad;

WIDE static void triad_part(double *restrict a, const double *restrict b, const double *restrict c,
                            int64_t count)
{
#pragma omp simd
  for (int64_t i = 0; i < count; ++i) a[i] = b[i] + 3.0 * c[i];
}

static void triad_task(void *context, int k)
{
  const triad *t = context;
  const int64_t first = t->length * k / TASKS, end = t->length * (k + 1) / TASKS;
  triad_part(t->a + first, t->b + first, t->c + first, end - first);
}

double bench_triad(void)
{
  const size_t n = (size_t)triad_length;
  triad t = {sdr_alloc(n, sizeof(double)), sdr_alloc(n, sizeof(double)),
             sdr_alloc(n, sizeof(double)), triad_length};
  double best = -1.0;
  for (int k = 0; t.a && t.b && t.c && k <= TRIES; ++k) {
    const double from = bench_clock();
    sdr_parallel_for(0, TASKS, 1, triad_task, &t);
    const double rate = 24.0 * (double)t.length / (bench_clock() - from);
    if (k > 0 && rate > best) best = rate; /* the first one touches the pages */
  }
  sdr_free(t.a);
  sdr_free(t.b);
  sdr_free(t.c);
  return best;
}

/* ---- the kernels' traffic -------------------------------------------------------------------- */

/* Sums of what a block reads: displacements of both ends, and moduli if every point has its own. */
WIDE static void read_block(const double *ui, const double *uj, const double *restrict *constants,
                            int count, double *restrict F)
{
  if (constants) {
    const double *restrict ci = constants[0], *restrict cj = constants[1];
    const double *restrict qi = constants[2], *restrict qj = constants[3];
#pragma omp simd
    for (int k = 0; k < count; ++k) F[k] = (ui[k] + uj[k]) + (ci[k] + cj[k]) + (qi[k] + qj[k]);
    return;
  }
#pragma omp simd
  for (int k = 0; k < count; ++k) F[k] = ui[k] + uj[k];
}

WIDE static void write_block(double *fi, double *fj, const double *F, int count)
{
#pragma omp simd
  for (int k = 0; k < count; ++k) fi[k] += F[k];
#pragma omp simd
  for (int k = 0; k < count; ++k) fj[k] -= F[k];
}

/* Read and write the history: 4 bytes a pair in both laws. */
WIDE static void touch_block(int32_t *history, int32_t mask, int count)
{
#pragma omp simd
  for (int k = 0; k < count; ++k) history[k] &= mask;
}

static void floor_of_run(const bench_body *body, const sdr_bond_run *run)
{
  const sdr_bond_body *bonds = &((const sdr_bond_model *)body->model)->body;
  const sdr_system *system = body->system;
  static volatile int32_t all = -1; /* volatile: the compiler must not see through it */
  const int32_t mask = all;
  double F[3][BLOCK];
  for (int32_t start = 0; start < run->length; start += BLOCK) {
    const int count = run->length - start < BLOCK ? run->length - start : BLOCK;
    const int64_t i = run->i0 + start, j = run->j0 + start, slot = run->slot + start;
    if (bonds->stretch) touch_block((int32_t *)(void *)(bonds->stretch + slot), mask, count);
    if (bonds->flags) touch_block(bonds->flags + slot, mask, count);
    for (int a = 0; a < system->components; ++a) {
      const double *restrict constants[4] = {NULL};
      if (bonds->stiffness_at && a == 0) {
        constants[0] = bonds->stiffness_at + i;
        constants[1] = bonds->stiffness_at + j;
        constants[2] = bonds->threshold_at + i;
        constants[3] = bonds->threshold_at + j;
      }
      read_block(system->u[a] + i, system->u[a] + j, constants[0] ? constants : NULL, count, F[a]);
    }
    for (int a = 0; a < system->components; ++a)
      write_block(system->f[a] + i, system->f[a] + j, F[a], count);
  }
}

static void floor_task(void *context, int s)
{
  const bench_body *body = context;
  const sdr_points *points = body->points;
  const sdr_bonds *bonds = ((const sdr_bond_model *)body->model)->bonds;
  for (int k = s; s % 2 == 0 && k < s + 2 && k < points->stripe_count; ++k)
    for (int a = 0; a < points->components; ++a)
      memset(body->system->f[a] + points->stripe_first[k], 0,
             (size_t)(points->stripe_first[k + 1] - points->stripe_first[k]) * sizeof(double));
  for (int64_t r = bonds->stripe_run[s]; r < bonds->stripe_run[s + 1]; ++r)
    floor_of_run(body, &bonds->runs[r]);
}

/* What a step reads and writes to move the points; dt = 0 leaves them where they are. */
WIDE static void move_part(double *restrict u, double *restrict v, const double *restrict f,
                           const double *restrict mass, double dt, int64_t count)
{
#pragma omp simd
  for (int64_t i = 0; i < count; ++i) {
    v[i] += dt * (f[i] + mass[i]);
    u[i] += dt * v[i];
  }
}

static void move_task(void *context, int s)
{
  const bench_body *body = context;
  const sdr_system *system = body->system;
  const int64_t first = body->points->stripe_first[s], end = body->points->stripe_first[s + 1];
  for (int a = 0; a < system->components; ++a)
    move_part(system->u[a] + first, system->v[a] + first, system->f[a] + first,
              system->mass + first, 0.0, end - first);
}

void bench_floor_step(bench_body *body)
{
  const int stripes = body->points->stripe_count;
  sdr_parallel_for(0, stripes, 1, move_task, body);
  sdr_parallel_for(0, stripes, 2, floor_task, body);
  sdr_parallel_for(1, stripes, 2, floor_task, body);
}
