#include "linalg/krylov.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

/* r residual, shadow the fixed vector that residuals are made orthogonal to, p direction, v = A M p
   and t = A M s with the preconditioner M; best: the x of the least residual. */
struct sdr_krylov {
  int32_t size;
  double *r, *shadow, *p, *v, *t, *mp, *ms, *best;
};

void sdr_krylov_destroy(sdr_krylov **krylov)
{
  sdr_krylov *k = *krylov;
  if (!k) return;
  sdr_free(k->r); /* one block for all */
  sdr_free(k);
  *krylov = NULL;
}

sdr_status sdr_krylov_create(int32_t size, sdr_krylov **out)
{
  sdr_krylov *k = sdr_alloc(1, sizeof *k);
  if (!k) return SDR_RUN_FAILED;
  const size_t stride = ((size_t)size + 7) / 8 * 8;
  double *block = sdr_alloc(8 * stride, sizeof *block);
  if (!block) {
    sdr_free(k);
    return SDR_RUN_FAILED;
  }
  double **const part[8] = {&k->r, &k->shadow, &k->p, &k->v, &k->t, &k->mp, &k->ms, &k->best};
  for (size_t n = 0; n < 8; ++n) *part[n] = block + n * stride;
  k->size = size;
  *out = k;
  return SDR_OK;
}

static double dot(int32_t n, const double *a, const double *b)
{
  double sum = 0.0;
#pragma omp simd reduction(+ : sum)
  for (int32_t k = 0; k < n; ++k) sum += a[k] * b[k];
  return sum;
}

/* y += a x */
static void add(int32_t n, double a, const double *x, double *y)
{
#pragma omp simd
  for (int32_t k = 0; k < n; ++k) y[k] += a * x[k];
}

/* p = r + beta (p - omega v) */
static void turn(const sdr_krylov *k, double beta, double omega)
{
  double *const p = k->p;
  const double *const r = k->r, *const v = k->v;
#pragma omp simd
  for (int32_t n = 0; n < k->size; ++n) p[n] = r[n] + beta * (p[n] - omega * v[n]);
}

/* Where an iteration stands. */
typedef struct {
  double rho, alpha, omega; /* of the iteration before */
  double residual, least;
} progress;

static void restart(const sdr_krylov *k, progress *at)
{
  memcpy(k->shadow, k->r, (size_t)k->size * sizeof *k->r);
  memset(k->p, 0, (size_t)k->size * sizeof *k->p);
  memset(k->v, 0, (size_t)k->size * sizeof *k->v);
  at->rho = at->alpha = at->omega = 1.0;
}

/* One iteration; *broken = 1 if it cannot go on with these vectors. */
static sdr_status iterate(sdr_krylov *k, const sdr_krylov_how *how, double *x, progress *at,
                          int *broken)
{
  const int32_t n = k->size;
  const double rho = dot(n, k->shadow, k->r);
  *broken = 1;
  if (!(fabs(rho) > 1e-30 * at->residual * at->residual)) return SDR_OK;
  turn(k, rho / at->rho * (at->alpha / at->omega), at->omega);
  SDR_TRY(how->precondition(how->context, k->p, k->mp));
  SDR_TRY(how->times(how->context, k->mp, k->v));
  const double along = dot(n, k->shadow, k->v);
  if (!(fabs(along) > 0.0)) return SDR_OK;
  at->rho = rho;
  at->alpha = rho / along;
  add(n, -at->alpha, k->v, k->r); /* r is s of the usual names from here on */
  add(n, at->alpha, k->mp, x);
  SDR_TRY(how->precondition(how->context, k->r, k->ms));
  SDR_TRY(how->times(how->context, k->ms, k->t));
  const double tt = dot(n, k->t, k->t), ts = dot(n, k->t, k->r);
  at->omega = tt > 0.0 ? ts / tt : 0.0;
  add(n, at->omega, k->ms, x);
  add(n, -at->omega, k->t, k->r);
  at->residual = sqrt(dot(n, k->r, k->r));
  *broken = !(fabs(at->omega) > 0.0);
  return SDR_OK;
}

static void keep_best(const sdr_krylov *k, const double *x, progress *at)
{
  if (!(at->residual < at->least)) return;
  at->least = at->residual;
  memcpy(k->best, x, (size_t)k->size * sizeof *x);
}

sdr_status sdr_krylov_solve(sdr_krylov *k, const sdr_krylov_how *how, const double *b, double *x,
                            double *reached, int32_t *iterations)
{
  const size_t bytes = (size_t)k->size * sizeof *b;
  const double size = sqrt(dot(k->size, b, b));
  progress at = {.residual = size, .least = size};
  int32_t count = 0;
  int broken = 0, restarted = 1;
  memset(x, 0, bytes);
  memset(k->best, 0, bytes);
  memcpy(k->r, b, bytes);
  restart(k, &at);
  while (count < how->most && at.residual > how->tolerance * size) {
    SDR_TRY(iterate(k, how, x, &at, &broken));
    ++count;
    keep_best(k, x, &at);
    if (!isfinite(at.residual) || (broken && restarted)) break;
    restarted = broken;
    if (broken) restart(k, &at);
  }
  if (at.residual > at.least || !isfinite(at.residual)) memcpy(x, k->best, bytes);
  *reached = size > 0.0 ? at.least / size : 0.0;
  *iterations = count;
  return SDR_OK;
}
