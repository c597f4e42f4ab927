#include "time/rigid.h"

#include <math.h>
#include <string.h>

enum { MODES = 6 };

/* Translations, then rotations about z, x, y through `centre`, over `size`. */
typedef struct {
  int components, count;
  double centre[3], size;
} modes;

static modes modes_of(const sdr_points *points)
{
  static const int counts[] = {0, 1, 3, 6};
  modes m = {.components = points->components, .count = counts[points->components]};
  for (int a = 0; a < m.components; ++a) {
    double low = INFINITY, high = -INFINITY;
    for (int32_t i = 0; i < points->count; ++i) {
      low = fmin(low, points->x[a][i]);
      high = fmax(high, points->x[a][i]);
    }
    m.centre[a] = 0.5 * (low + high);
    m.size = fmax(m.size, high - low);
  }
  return m;
}

/* Displacement component a of point i under each mode. */
static void motion(const modes *m, const sdr_points *points, int32_t i, int a, double row[MODES])
{
  double r[3] = {0.0};
  for (int b = 0; b < m->components; ++b)
    r[b] = m->size > 0.0 ? (points->x[b][i] - m->centre[b]) / m->size : 0.0;
  memset(row, 0, MODES * sizeof *row);
  row[a] = 1.0;
  for (int k = m->components; k < m->count; ++k) {
    const int axis = (k - m->components + 2) % 3; /* z first: the only one in 2-D */
    if (a == (axis + 1) % 3) row[k] = -r[(axis + 2) % 3];
    if (a == (axis + 2) % 3) row[k] = r[(axis + 1) % 3];
  }
}

/* Sum over the prescribed components of the products of the modes. */
static void gram(const modes *m, const sdr_points *points, const uint8_t *prescribed,
                 double g[MODES][MODES])
{
  double row[MODES];
  for (int32_t i = 0; i < points->count; ++i)
    for (int a = 0; a < m->components; ++a) {
      if (!prescribed[i * m->components + a]) continue;
      motion(m, points, i, a, row);
      for (int k = 0; k < m->count; ++k)
        for (int l = 0; l < m->count; ++l) g[k][l] += row[k] * row[l];
    }
}

/* Rank of the positive semidefinite g by elimination, largest pivot first; g is used up. */
static int rank_of(int count, double g[MODES][MODES])
{
  double first = 0.0;
  int used[MODES] = {0};
  for (int rank = 0; rank < count; ++rank) {
    int best = -1;
    for (int k = 0; k < count; ++k)
      if (!used[k] && (best < 0 || g[k][k] > g[best][best])) best = k;
    if (rank == 0) first = g[best][best];
    if (!(g[best][best] > 1e-12 * first)) return rank;
    used[best] = 1;
    for (int k = 0; k < count; ++k)
      for (int l = 0; l < count && !used[k]; ++l)
        if (!used[l]) g[k][l] -= g[k][best] * g[best][l] / g[best][best];
  }
  return count;
}

sdr_status sdr_rigid_held(const sdr_points *points, const uint8_t *prescribed)
{
  const modes m = modes_of(points);
  double g[MODES][MODES] = {{0.0}};
  gram(&m, points, prescribed, g);
  for (int a = 0; a < m.components; ++a)
    if (!(g[a][a] > 0.0))
      return sdr_fail(SDR_BAD_INPUT,
                      "nothing keeps the body from moving along %c; prescribe that component of "
                      "some of its points (supports)",
                      "xyz"[a]);
  /* a body of one point does not turn */
  if (!(m.size > 0.0) || rank_of(m.count, g) == m.count) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "nothing keeps the body from turning; prescribe components of "
                                 "points some way apart (supports)");
}
