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

typedef struct {
  int count;
  double normal[SDR_CUT_DIRECTIONS][3], most[SDR_CUT_DIRECTIONS];
} reach_call;

static void add_reach(void *context, const sdr_pair *pair)
{
  reach_call *call = context;
  if (!(pair->weight_ij > 0.0)) return;
  for (int k = 0; k < call->count; ++k) {
    double along = 0.0;
    for (int a = 0; a < 3; ++a) along += pair->xi[a] * call->normal[k][a];
    call->most[k] = fmax(call->most[k], along);
  }
}

double sdr_cut_reach(const sdr_points *points, const sdr_bonds *bonds)
{
  double sum = 0.0;
  int met = 0;
  reach_call call = {.count = 0};
  call.count = sdr_cut_directions(points, call.normal);
  for (int k = 0; k < SDR_CUT_TRIED && k < points->count && met < SDR_CUT_ENOUGH; ++k) {
    const int32_t i = sdr_cut_sample(points, k);
    if (!sdr_cut_complete(points, bonds, i)) continue;
    ++met;
    for (int d = 0; d < call.count; ++d) call.most[d] = 0.0;
    sdr_bonds_visit_loose_point(bonds, i, add_reach, &call);
    for (int d = 0; d < call.count; ++d) sum += call.most[d] / (points->horizon[i] * call.count);
  }
  return met > 0 ? sum / met : 1.0;
}
