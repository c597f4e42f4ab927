#include "output/crack_area.h"

#include "base/memory.h"

#include <math.h>

double sdr_mean_projection(int components, double spacing, double horizon)
{
  static const double of_length[] = {1.0, 2.0 / M_PI, 0.5}; /* mean of |cos| over directions */
  const double square = horizon * horizon / (spacing * spacing) * (1.0 + 1e-9);
  const int reach = (int)sqrt(square), ry = components > 1 ? reach : 0;
  const int rz = components > 2 ? reach : 0;
  double sum = 0.0, count = 0.0;
  for (int a = -reach; a <= reach; ++a)
    for (int b = -ry; b <= ry; ++b)
      for (int c = -rz; c <= rz; ++c) {
        const double length = (double)(a * a + b * b + c * c);
        if (!(length > 0.0) || length > square) continue;
        sum += sqrt(length);
        count += 1.0;
      }
  return of_length[components - 1] * spacing * sum / count;
}

typedef struct {
  const int32_t *owner;
  double distance;
  int32_t crack; /* of the nearest site so far; -1: none */
} nearest;

static void keep_nearest(void *context, int32_t site, double distance)
{
  nearest *best = context;
  const int32_t crack = best->owner[site];
  if (crack < 0 || distance > best->distance) return;
  if (!(distance < best->distance) && best->crack >= 0 && best->crack <= crack) return;
  best->distance = distance;
  best->crack = crack;
}

static int32_t crack_of(const sdr_crack_sites *sites, const int32_t *owner,
                        const sdr_points *points, int32_t i)
{
  double x[3] = {0.0};
  nearest best = {owner, (double)HUGE_VAL, -1};
  for (int c = 0; c < points->components; ++c) x[c] = points->x[c][i];
  sdr_point_grid_within(sites->grid, x, points->horizon[i], keep_nearest, &best);
  return best.crack;
}

/* Projections of the spacings and horizons there are: mostly one, so the latest is kept. */
typedef struct {
  double spacing, horizon, value;
} projection;

static double projection_at(projection *kept, const sdr_points *points, int32_t i)
{
  const double spacing = points->spacing[i], horizon = points->horizon[i];
  if (kept->spacing < spacing || kept->spacing > spacing || kept->horizon < horizon ||
      kept->horizon > horizon)
    *kept =
        (projection){spacing, horizon, sdr_mean_projection(points->components, spacing, horizon)};
  return kept->value;
}

sdr_status sdr_crack_surfaces(sdr_system *system, const sdr_crack_sites *sites,
                              const int32_t *owner, const float *first, int cracks,
                              sdr_crack_surface *out)
{
  const sdr_points *points = system->model->points;
  projection kept = {0.0, 0.0, 1.0};
  double *damage = sdr_alloc((size_t)points->count, sizeof *damage);
  double *spent = sdr_alloc((size_t)points->count, sizeof *spent);
  sdr_status status = damage && spent ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) status = sdr_system_field(system, "damage", damage);
  if (status == SDR_OK) status = sdr_system_field(system, "dissipated", spent);
  for (int k = 0; status == SDR_OK && k < cracks; ++k) out[k] = (sdr_crack_surface){0.0, 0.0};
  for (int32_t i = 0; status == SDR_OK && i < points->count; ++i) {
    const double grown = damage[i] - (double)first[i];
    if (!sdr_in_body(points, i) || !(grown > 1e-6)) continue; /* `first` is rounded */
    const int32_t crack = crack_of(sites, owner, points, i);
    if (crack < 0) continue;
    out[crack].area += grown * points->volume[i] / projection_at(&kept, points, i);
    out[crack].energy += spent[i] * points->volume[i];
  }
  sdr_free(damage);
  sdr_free(spent);
  return status;
}
