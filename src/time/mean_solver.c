#include "time/mean_solver.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

struct sdr_mean_solver {
  sdr_reduced_solver *reduced;
  const sdr_motion *motion;
  int means, acting; /* of the scene; now */
  int *which;        /* of each that acts: which mean it is */
  double *answer;    /* of each that acts: A^-1 e, `size` values */
  double *right;
  double *shift;        /* of each that acts: what x has of it, m */
  double *schur, *pull; /* e_m . A^-1 e_n; right-hand side and solution with it */
  int32_t size;
  double key;       /* of the answers */
  int64_t tangents; /* likewise; -1: there are none */
};

void sdr_mean_solver_destroy(sdr_mean_solver **solver)
{
  sdr_mean_solver *s = *solver;
  if (!s) return;
  sdr_free(s->which);
  sdr_free(s->answer);
  sdr_free(s->right);
  sdr_free(s->shift);
  sdr_free(s->schur);
  sdr_free(s->pull);
  sdr_free(s);
  *solver = NULL;
}

sdr_status sdr_mean_solver_create(sdr_reduced_solver *reduced, const sdr_motion *motion,
                                  sdr_mean_solver **out)
{
  sdr_mean_solver *s = sdr_alloc(1, sizeof *s);
  if (!s) return SDR_RUN_FAILED;
  const size_t means = (size_t)sdr_motion_means(motion);
  const size_t size = means > 0 ? (size_t)sdr_motion_constraints(motion)->unknowns : 0;
  *s = (sdr_mean_solver){.reduced = reduced, .motion = motion, .means = (int)means, .tangents = -1};
  s->which = sdr_alloc(means, sizeof *s->which);
  s->answer = sdr_alloc(means * size, sizeof(double));
  s->right = sdr_alloc(size, sizeof(double));
  s->shift = sdr_alloc(means, sizeof(double));
  s->schur = sdr_alloc(means * means, sizeof(double));
  s->pull = sdr_alloc(means, sizeof(double));
  if (s->which && s->answer && s->right && s->shift && s->schur && s->pull)
    *out = s;
  else
    sdr_mean_solver_destroy(&s);
  return s ? SDR_OK : SDR_RUN_FAILED;
}

static double sum_over(const sdr_mean_solver *s, int n, const double *x)
{
  int32_t count;
  const int32_t *place = sdr_motion_mean(s->motion, s->which[n], &count);
  double sum = 0.0;
  for (int32_t k = 0; k < count; ++k) sum += x[place[k]];
  return sum;
}

static void find_acting(sdr_mean_solver *s)
{
  s->acting = 0;
  for (int mean = 0; mean < s->means; ++mean) {
    int32_t count;
    (void)sdr_motion_mean(s->motion, mean, &count);
    if (count > 0) s->which[s->acting++] = mean;
  }
  s->size = sdr_motion_constraints(s->motion)->free;
}

/* A^-1 e of each mean, to far below what the steps ask for. */
static sdr_reduced find_answers(sdr_mean_solver *s, const sdr_reduced_aim *aim)
{
  const size_t size = (size_t)s->size;
  for (int n = 0; n < s->acting; ++n) {
    int32_t count;
    const int32_t *place = sdr_motion_mean(s->motion, s->which[n], &count);
    memset(s->right, 0, size * sizeof *s->right);
    for (int32_t k = 0; k < count; ++k) s->right[place[k]] = 1.0;
    const sdr_reduced_aim own = {aim->diagonal, NULL, 1e-10 * sqrt((double)count / s->size)};
    const sdr_reduced result =
        sdr_reduced_solver_solve(s->reduced, &own, s->right, s->answer + (size_t)n * size);
    if (result != SDR_REDUCED_OK) return result;
  }
  return SDR_REDUCED_OK;
}

/* a x = b for b, by elimination with the largest pivot of a column. 0: singular. */
static int eliminate(double *a, double *b, int n)
{
  for (int c = 0; c < n; ++c) {
    int best = c;
    for (int r = c + 1; r < n; ++r)
      if (fabs(a[r * n + c]) > fabs(a[best * n + c])) best = r;
    if (!(fabs(a[best * n + c]) > 0.0)) return 0;
    for (int k = 0; k < n; ++k) {
      const double kept = a[c * n + k];
      a[c * n + k] = a[best * n + k];
      a[best * n + k] = kept;
    }
    const double kept = b[c];
    b[c] = b[best];
    b[best] = kept;
    for (int r = c + 1; r < n; ++r) {
      const double share = a[r * n + c] / a[c * n + c];
      for (int k = c; k < n; ++k) a[r * n + k] -= share * a[c * n + k];
      b[r] -= share * b[c];
    }
  }
  for (int r = n - 1; r >= 0; --r) {
    for (int k = r + 1; k < n; ++k) b[r] -= a[r * n + k] * b[k];
    b[r] /= a[r * n + r];
  }
  return 1;
}

/* The mean that each part of x has in the end, e.x = e.D^-1 r, and the right-hand side of the rest.
 */
static void take_means(sdr_mean_solver *s, const double *diagonal, const double *r)
{
  double *shift = s->shift;
  memcpy(s->right, r, (size_t)s->size * sizeof *r);
  for (int n = 0; n < s->acting; ++n) {
    int32_t count;
    const int32_t *place = sdr_motion_mean(s->motion, s->which[n], &count);
    shift[n] = 0.0;
    for (int32_t k = 0; k < count; ++k) shift[n] += r[place[k]] / diagonal[place[k]] / count;
    for (int32_t k = 0; k < count; ++k) s->right[place[k]] -= diagonal[place[k]] * shift[n];
  }
}

/* x += the pulls that leave no mean in it. */
static sdr_reduced remove_means(sdr_mean_solver *s, double *x)
{
  const size_t size = (size_t)s->size;
  for (int m = 0; m < s->acting; ++m) {
    s->pull[m] = -sum_over(s, m, x);
    for (int n = 0; n < s->acting; ++n)
      s->schur[m * s->acting + n] = sum_over(s, m, s->answer + (size_t)n * size);
  }
  if (!eliminate(s->schur, s->pull, s->acting)) return SDR_REDUCED_SMALLER_STEP;
  for (int n = 0; n < s->acting; ++n) {
    const double *answer = s->answer + (size_t)n * size;
    for (size_t k = 0; k < size; ++k) x[k] += s->pull[n] * answer[k];
  }
  return SDR_REDUCED_OK;
}

sdr_reduced sdr_mean_solver_solve(sdr_mean_solver *solver, const sdr_reduced_aim *aim, double key,
                                  const double *r, double *x)
{
  sdr_mean_solver *s = solver;
  const int64_t tangents = sdr_reduced_solver_report(s->reduced).tangents;
  sdr_reduced result = SDR_REDUCED_OK;
  if (s->means > 0) find_acting(s);
  if (s->acting == 0) return sdr_reduced_solver_solve(s->reduced, aim, r, x);
  if (s->tangents != tangents || s->key != key) result = find_answers(s, aim);
  s->tangents = result == SDR_REDUCED_OK ? tangents : -1;
  s->key = key;
  if (result != SDR_REDUCED_OK) return result;
  take_means(s, aim->diagonal, r);
  result = sdr_reduced_solver_solve(s->reduced, aim, s->right, x);
  if (result == SDR_REDUCED_OK) result = remove_means(s, x);
  for (int n = 0; n < s->acting; ++n) {
    int32_t count;
    const int32_t *place = sdr_motion_mean(s->motion, s->which[n], &count);
    for (int32_t k = 0; k < count; ++k) x[place[k]] += s->shift[n];
  }
  return result;
}
