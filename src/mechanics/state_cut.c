#include "mechanics/state_cut.h"

#include "nom/stencil.h"

#include <math.h>

int sdr_cut_directions(const sdr_points *points, double normal[SDR_CUT_DIRECTIONS][3])
{
  const double pi = 3.14159265358979323846, golden = 2.39996322972865332;
  const int n = points->components, even = n == 1 ? 0 : n == 2 ? 180 : 200;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < 3; ++b) normal[a][b] = points->axes[a][b];
  for (int k = 0; k < even; ++k) {
    const double z = n == 3 ? (k + 0.5) / even : 0.0, across = sqrt(1.0 - z * z);
    const double angle = n == 3 ? golden * k : pi * k / even;
    normal[n + k][0] = across * cos(angle);
    normal[n + k][1] = across * sin(angle);
    normal[n + k][2] = z;
  }
  return n + even;
}

int32_t sdr_cut_sample(const sdr_points *points, int k)
{
  const double spread = k * 0.61803398874989485; /* steps of the golden ratio */
  return (int32_t)((spread - floor(spread)) * points->count);
}

typedef struct {
  const sdr_points *points;
  double volume, offset[3];
  int count;
} volume_call;

static void add_volume(void *context, const sdr_pair *pair)
{
  volume_call *call = context;
  const double volume = call->points->volume[pair->j];
  if (!(pair->weight_ij > 0.0)) return;
  ++call->count;
  call->volume += volume;
  for (int a = 0; a < call->points->components; ++a) call->offset[a] += volume * pair->xi[a];
}

/* On a lattice a family is complete if it is the full stencil. */
static int fills_stencil(const sdr_points *points, int32_t i, int count)
{
  sdr_stencil stencil;
  if (sdr_stencil_create(points->components, points->spacing[i], points->horizon[i], &stencil) !=
      SDR_OK)
    return 0;
  const int full = count == stencil.count;
  sdr_stencil_destroy(&stencil);
  return full;
}

int sdr_cut_complete(const sdr_points *points, const sdr_bonds *bonds, int32_t i)
{
  static const double ball[3] = {2.0, 3.14159265358979323846, 4.18879020478639098462};
  const int n = points->components;
  volume_call call = {.points = points};
  sdr_bonds_visit_loose_point(bonds, i, add_volume, &call);
  if (!points->irregular) return fills_stencil(points, i, call.count);
  const double thickness = points->volume[i] / pow(points->spacing[i], n);
  const double full = ball[n - 1] * thickness * pow(points->horizon[i], n);
  const double *offset = call.offset;
  return call.volume > 0.9 * full &&
         sqrt(offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2]) <
             0.1 * call.volume * points->horizon[i];
}

/* ---- how far a cut reaches ------------------------------------------------------------------- */

/* The largest xi.n of one family, for each direction. */
typedef struct {
  int components, count, bonds;
  double normal[SDR_CUT_DIRECTIONS][3], most[SDR_CUT_DIRECTIONS];
} reach_call;

/* What counts of them: see state_cut.h. The axes come first. */
static double reach_of(const reach_call *call)
{
  const int axes = call->components, even = call->count - axes;
  double along = 0.0, mean = 0.0;
  for (int k = 0; k < axes; ++k) along += call->most[k] / axes;
  for (int k = axes; k < call->count; ++k) mean += call->most[k] / even;
  return even > 0 ? fmax(mean, along / 1.04) : along;
}

/* Largest d.n of the lattice vectors d with |d|^2 <= square, whose components are at most `most`.
 */
static double lattice_most(double square, int most, const double n[3], int components)
{
  double far = 0.0;
  for (int z = 0; z <= (components > 2 ? most : 0); ++z)
    for (int y = 0; y <= (components > 1 ? most : 0); ++y) {
      const double left = square - y * y - z * z;
      if (left < 0.0) continue;
      far = fmax(far, fabs(n[0]) * floor(sqrt(left)) + fabs(n[1]) * y + fabs(n[2]) * z);
    }
  return far;
}

double sdr_cut_lattice_reach(const sdr_points *points, int32_t i)
{
  const double ratio = points->horizon[i] / points->spacing[i];
  const double square = ratio * ratio * (1.0 + 1e-9);
  reach_call call = {.components = points->components};
  call.count = sdr_cut_directions(points, call.normal);
  for (int k = 0; k < call.count; ++k) {
    double n[3] = {0.0}; /* in the lattice's frame */
    for (int a = 0; a < points->components; ++a)
      for (int b = 0; b < 3; ++b) n[a] += points->axes[a][b] * call.normal[k][b];
    call.most[k] = lattice_most(square, (int)sqrt(square), n, points->components) / ratio;
  }
  return reach_of(&call);
}

static void add_reach(void *context, const sdr_pair *pair)
{
  reach_call *call = context;
  if (!(pair->weight_ij > 0.0)) return;
  ++call->bonds;
  for (int k = 0; k < call->count; ++k) {
    double along = 0.0;
    for (int a = 0; a < call->components; ++a) along += pair->xi[a] * call->normal[k][a];
    call->most[k] = fmax(call->most[k], along);
  }
}

double sdr_cut_reach(const sdr_points *points, const sdr_bonds *bonds)
{
  reach_call one = {.components = points->components}, sum;
  int met = 0;
  one.count = sdr_cut_directions(points, one.normal);
  sum = one;
  for (int k = 0; k < SDR_CUT_TRIED && k < points->count && one.bonds < SDR_CUT_ENOUGH; ++k) {
    const int32_t i = sdr_cut_sample(points, k);
    if (!sdr_cut_complete(points, bonds, i)) continue;
    ++met;
    for (int d = 0; d < one.count; ++d) one.most[d] = 0.0;
    sdr_bonds_visit_loose_point(bonds, i, add_reach, &one);
    for (int d = 0; d < one.count; ++d) sum.most[d] += one.most[d] / points->horizon[i];
  }
  return met > 0 ? reach_of(&sum) / met : 1.0;
}
