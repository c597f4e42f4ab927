#include "time/mean_border.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

struct sdr_mean_border {
  const sdr_constraints *closed; /* with means; NULL: none was taken */
  sdr_constraints own;           /* without; if there are means */
  int32_t means;
  int32_t *place;  /* an entry of q: where it stands without means */
  int32_t *leader; /* a mean: where its leader stands there */
  double *mean;    /* c_m, one behind the other, each over q and leaders */
  double *answer;  /* S c_m and S e_m likewise, those of a mean side by side */
  double *spring;  /* k_m, N/m */
  double *matrix;  /* of (p_1, w_1, p_2, ...): (2 means)^2 ... */
  double *small;   /* ... and room for it and a right side */
  double *f, *x;   /* over q and leaders */
};

/* ---- making ---------------------------------------------------------------------------------- */

sdr_status sdr_mean_border_create(sdr_mean_border **out)
{
  sdr_mean_border *border = sdr_alloc(1, sizeof *border);
  if (!border) return SDR_RUN_FAILED;
  *out = border;
  return SDR_OK;
}

static void drop(sdr_mean_border *b)
{
  sdr_constraints_destroy(&b->own);
  sdr_free(b->place);
  sdr_free(b->leader);
  sdr_free(b->mean);
  sdr_free(b->answer);
  sdr_free(b->spring);
  sdr_free(b->matrix);
  sdr_free(b->small);
  sdr_free(b->f);
  sdr_free(b->x);
  *b = (sdr_mean_border){0};
}

void sdr_mean_border_destroy(sdr_mean_border **border)
{
  if (!*border) return;
  drop(*border);
  sdr_free(*border);
  *border = NULL;
}

static sdr_status allocate(sdr_mean_border *b)
{
  const size_t free_count = (size_t)b->own.free, means = (size_t)b->means;
  b->place = sdr_alloc(free_count, sizeof *b->place);
  b->leader = sdr_alloc(means, sizeof *b->leader);
  b->mean = sdr_alloc(means * free_count, sizeof *b->mean);
  b->answer = sdr_alloc(2 * means * free_count, sizeof *b->answer);
  b->spring = sdr_alloc(means, sizeof *b->spring);
  b->matrix = sdr_alloc(4 * means * means, sizeof *b->matrix);
  b->small = sdr_alloc(4 * means * means + 2 * means, sizeof *b->small);
  b->f = sdr_alloc(free_count, sizeof *b->f);
  b->x = sdr_alloc(free_count, sizeof *b->x);
  const int whole = b->place && b->leader && b->mean && b->answer && b->spring && b->matrix &&
                    b->small && b->f && b->x;
  return whole ? SDR_OK : SDR_RUN_FAILED;
}

/* Both lists of free components ascend. */
static void find_places(sdr_mean_border *b)
{
  for (int32_t q = 0, k = 0; k < b->own.free; ++k)
    if (q < b->closed->free && b->closed->unknown[q] == b->own.unknown[k]) b->place[q++] = k;
}

static int32_t place_of(const sdr_constraints *c, int32_t unknown)
{
  int32_t low = 0, high = c->free;
  while (low < high) {
    const int32_t middle = low + (high - low) / 2;
    if (c->unknown[middle] < unknown)
      low = middle + 1;
    else
      high = middle;
  }
  return low < c->free && c->unknown[low] == unknown ? low : -1;
}

static void find_means(sdr_mean_border *b, const sdr_slaves *slaves)
{
  for (int32_t m = 0; m < b->means; ++m) {
    const int32_t k = slaves->count - b->means + m;
    double *c = b->mean + (size_t)m * (size_t)b->own.free;
    b->leader[m] = place_of(&b->own, slaves->unknown[k]);
    c[b->leader[m]] = 1.0;
    for (int64_t p = slaves->first[k]; p < slaves->first[k + 1]; ++p) {
      const int32_t at = place_of(&b->own, slaves->master[p]);
      if (at >= 0) c[at] = -slaves->coefficient[p];
    }
  }
}

sdr_status sdr_mean_border_take(sdr_mean_border *border, const sdr_implicit *implicit)
{
  const sdr_system *system = implicit->system;
  sdr_slaves others = implicit->slaves; /* means come last */
  drop(border);
  border->closed = &implicit->constraints;
  border->means = implicit->means;
  if (border->means == 0) return SDR_OK;
  others.count -= border->means;
  SDR_TRY(sdr_constraints_create(system->model->points, system->supports, system->motion,
                                 others.count > 0 ? &others : NULL, &border->own));
  SDR_TRY(allocate(border));
  find_places(border);
  find_means(border, &implicit->slaves);
  return SDR_OK;
}

const sdr_constraints *sdr_mean_border_open(const sdr_mean_border *border)
{
  return border->means > 0 ? &border->own : border->closed;
}

void sdr_mean_border_add_springs(sdr_mean_border *border, double stiff, double *diagonal)
{
  for (int32_t m = 0; m < border->means; ++m) {
    border->spring[m] = stiff;
    diagonal[border->own.unknown[border->leader[m]]] += stiff;
  }
}

/* ---- use ------------------------------------------------------------------------------------- */

static double dot(const sdr_mean_border *b, const double *x, const double *y)
{
  double sum = 0.0;
  for (int32_t k = 0; k < b->own.free; ++k) sum += x[k] * y[k];
  return sum;
}

static const double *mean_of(const sdr_mean_border *b, int32_t m)
{
  return b->mean + (size_t)m * (size_t)b->own.free;
}

/* What the equations of mean m say of x: c_m^T x, and e_m^T x. */
static void look_at(const sdr_mean_border *b, int32_t m, const double *x, double of[2])
{
  of[0] = dot(b, mean_of(b, m), x);
  of[1] = x[b->leader[m]];
}

static void set_matrix(sdr_mean_border *b)
{
  const int32_t size = 2 * b->means;
  for (int32_t m = 0; m < b->means; ++m)
    for (int32_t column = 0; column < size; ++column) {
      const double sign = column % 2 ? 1.0 : -1.0;
      double of[2];
      look_at(b, m, b->answer + (size_t)column * (size_t)b->own.free, of);
      b->matrix[2 * m * size + column] = sign * of[0];
      b->matrix[(2 * m + 1) * size + column] =
          sign * of[1] - (column == 2 * m + 1 ? 1.0 / b->spring[m] : 0.0);
    }
}

sdr_status sdr_mean_border_factor(sdr_mean_border *border, sdr_solver *solver)
{
  sdr_mean_border *b = border;
  const size_t length = (size_t)b->own.free;
  for (int32_t m = 0; m < b->means; ++m) {
    double *of_mean = b->answer + 2 * (size_t)m * length, *of_leader = of_mean + length;
    SDR_TRY(sdr_solver_precondition(solver, mean_of(b, m), of_mean));
    memset(b->f, 0, length * sizeof *b->f);
    b->f[b->leader[m]] = 1.0;
    SDR_TRY(sdr_solver_precondition(solver, b->f, of_leader));
  }
  if (b->means > 0) set_matrix(b);
  return SDR_OK;
}

/* Gauss with the largest pivot of each column; `right` becomes the answer. A column without a pivot
   answers 0. */
static void eliminate(int32_t n, double *a, double *right)
{
  for (int32_t c = 0; c < n; ++c) {
    int32_t best = c;
    for (int32_t r = c + 1; r < n; ++r)
      if (fabs(a[r * n + c]) > fabs(a[best * n + c])) best = r;
    for (int32_t k = 0; k < n && best != c; ++k) {
      const double kept = a[c * n + k];
      a[c * n + k] = a[best * n + k];
      a[best * n + k] = kept;
    }
    const double swapped = right[best];
    right[best] = right[c];
    right[c] = swapped;
    if (a[c * n + c] == 0.0) continue;
    for (int32_t r = c + 1; r < n; ++r) {
      const double by = a[r * n + c] / a[c * n + c];
      for (int32_t k = c; k < n; ++k) a[r * n + k] -= by * a[c * n + k];
      right[r] -= by * right[c];
    }
  }
  for (int32_t r = n - 1; r >= 0; --r) {
    for (int32_t k = r + 1; k < n; ++k) right[r] -= a[r * n + k] * right[k];
    right[r] = a[r * n + r] == 0.0 ? 0.0 : right[r] / a[r * n + r];
  }
}

sdr_status sdr_mean_border_solve(sdr_mean_border *border, sdr_solver *solver, const double *r,
                                 double *z)
{
  sdr_mean_border *b = border;
  const int32_t size = 2 * b->means;
  if (b->means == 0) return sdr_solver_precondition(solver, r, z);
  memset(b->f, 0, (size_t)b->own.free * sizeof *b->f);
  for (int32_t q = 0; q < b->closed->free; ++q) b->f[b->place[q]] = r[q];
  SDR_TRY(sdr_solver_precondition(solver, b->f, b->x));
  double *const part = b->small + size * size;
  memcpy(b->small, b->matrix, (size_t)(size * size) * sizeof *b->small);
  for (int32_t m = 0; m < b->means; ++m) {
    look_at(b, m, b->x, part + 2 * m);
    part[2 * m] = -part[2 * m];
    part[2 * m + 1] = -part[2 * m + 1];
  }
  eliminate(size, b->small, part);
  for (int32_t column = 0; column < size; ++column) {
    const double *s = b->answer + (size_t)column * (size_t)b->own.free;
    const double by = column % 2 ? part[column] : -part[column];
    for (int32_t k = 0; k < b->own.free; ++k) b->x[k] += by * s[k];
  }
  for (int32_t q = 0; q < b->closed->free; ++q) z[q] = b->x[b->place[q]];
  return SDR_OK;
}
