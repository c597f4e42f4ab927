#include "time/secant_pairs.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

enum { MOST = 10 }; /* more gained nothing on bodies that soften */

struct sdr_secant_pairs {
  int32_t count;
  int known, last;                             /* pairs; where the last one stands */
  int begun;                                   /* 1: there is a point to go on from */
  double *step[MOST], *change[MOST], by[MOST]; /* s, y, 1/(s.y) */
  double *q, *gradient;                        /* of the last point */
  double *right;
};

sdr_status sdr_secant_pairs_create(int32_t room, sdr_secant_pairs **out)
{
  sdr_secant_pairs *p = sdr_alloc(1, sizeof *p);
  if (!p) return SDR_RUN_FAILED;
  const size_t length = (size_t)room;
  int whole = 1;
  for (int k = 0; k < MOST; ++k) {
    whole &= (p->step[k] = sdr_alloc(length, sizeof(double))) != NULL;
    whole &= (p->change[k] = sdr_alloc(length, sizeof(double))) != NULL;
  }
  p->q = sdr_alloc(length, sizeof(double));
  p->gradient = sdr_alloc(length, sizeof(double));
  p->right = sdr_alloc(length, sizeof(double));
  if (whole && p->q && p->gradient && p->right)
    *out = p;
  else
    sdr_secant_pairs_destroy(&p);
  return p ? SDR_OK : SDR_RUN_FAILED;
}

void sdr_secant_pairs_destroy(sdr_secant_pairs **pairs)
{
  sdr_secant_pairs *p = *pairs;
  if (!p) return;
  for (int k = 0; k < MOST; ++k) {
    sdr_free(p->step[k]);
    sdr_free(p->change[k]);
  }
  sdr_free(p->q);
  sdr_free(p->gradient);
  sdr_free(p->right);
  sdr_free(p);
  *pairs = NULL;
}

void sdr_secant_pairs_clear(sdr_secant_pairs *pairs, int32_t count)
{
  pairs->count = count;
  pairs->known = pairs->begun = 0;
}

int sdr_secant_pairs_known(const sdr_secant_pairs *pairs)
{
  return pairs->known;
}

static double dot(const sdr_secant_pairs *p, const double *x, const double *y)
{
  double sum = 0.0;
  for (int32_t k = 0; k < p->count; ++k) sum += x[k] * y[k];
  return sum;
}

void sdr_secant_pairs_note(sdr_secant_pairs *pairs, const double *q, const double *gradient)
{
  sdr_secant_pairs *p = pairs;
  const size_t bytes = (size_t)p->count * sizeof *q;
  const int next = (p->last + 1) % MOST;
  double *s = p->step[next], *y = p->change[next];
  for (int32_t k = 0; p->begun && k < p->count; ++k) {
    s[k] = q[k] - p->q[k];
    y[k] = gradient[k] - p->gradient[k];
  }
  memcpy(p->q, q, bytes);
  memcpy(p->gradient, gradient, bytes);
  const int first = !p->begun;
  p->begun = 1;
  if (first) return;
  const double along = dot(p, s, y);
  if (!(along > 1e-10 * sqrt(dot(p, s, s) * dot(p, y, y)))) return; /* no pair of a minimum */
  p->by[next] = 1.0 / along;
  p->last = next;
  if (p->known < MOST) ++p->known;
}

sdr_status sdr_secant_pairs_descend(sdr_secant_pairs *pairs, const double *gradient,
                                    sdr_secant_start start, void *context, double *direction)
{
  sdr_secant_pairs *p = pairs;
  double *const r = p->right, *const z = direction, part[MOST];
  for (int32_t k = 0; k < p->count; ++k) r[k] = -gradient[k];
  for (int back = 0; back < p->known; ++back) {
    const int m = (p->last - back + MOST) % MOST;
    part[m] = p->by[m] * dot(p, p->step[m], r);
    for (int32_t k = 0; k < p->count; ++k) r[k] -= part[m] * p->change[m][k];
  }
  SDR_TRY(start(context, r, z));
  for (int back = p->known - 1; back >= 0; --back) {
    const int m = (p->last - back + MOST) % MOST;
    const double rest = part[m] - p->by[m] * dot(p, p->change[m], z);
    for (int32_t k = 0; k < p->count; ++k) z[k] += rest * p->step[m][k];
  }
  return SDR_OK;
}
