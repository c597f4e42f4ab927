#include "nom/family_sums.h"

#include <math.h>

/* Add a neighbour at xi with volume v and weight b. */
static void add_bond(sdr_family_sums *s, const double xi[3], double v, double b)
{
  double square = 0.0, phi[SDR_MONOMIALS];
  for (int a = 0; a < s->components; ++a) square += xi[a] * xi[a];
  const double length = sqrt(square);
  const double n[3] = {xi[0] / length, xi[1] / length, xi[2] / length};
  const double r = b * (s->state_based ? square : length) * v;
  const int count = sdr_quartic(s->components, n, phi);
  s->first += b * length * v;
  s->second += b * square * v;
  s->moment += r;
  s->volume += v;
  for (int a = 0; a < 3; ++a) s->offset[a] += xi[a] * v;
  for (int k = 0; k < count; ++k) {
    s->quartic[k] += r * phi[k];
    for (int c = 0; c < count; ++c) s->gram[k * count + c] += r * phi[k] * phi[c];
  }
}

static double length_of(const double xi[3])
{
  return sqrt(xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]);
}

sdr_family_sums sdr_sum_stencil(const sdr_families *families, const sdr_family *family,
                                const sdr_stencil *stencil, sdr_weighing weighing)
{
  sdr_family_sums total = {.components = families->points->components,
                           .state_based = families->how.state_based};
  for (int k = 0; k < stencil->count; ++k) {
    double xi[3];
    sdr_stencil_vector(families->points, family->spacing, stencil->step + 3 * k, xi);
    add_bond(&total, xi, family->volume,
             weighing == SDR_WEIGHED_FULL
                 ? sdr_family_bond_weight(families, family, xi)
                 : sdr_family_plain_weight(families, family, family->spacing, length_of(xi)));
  }
  return total;
}

sdr_family_sums sdr_sum_neighbours(const sdr_families *families, const sdr_neighbourhood *near,
                                   int32_t i, sdr_weighing weighing)
{
  const sdr_points *points = families->points;
  const sdr_family *family = sdr_family_of(families, i);
  sdr_family_sums total = {.components = points->components,
                           .state_based = families->how.state_based};
  for (int64_t k = near->row[i]; k < near->row[i + 1]; ++k) {
    const int32_t j = near->column[k];
    double xi[3] = {0.0};
    for (int a = 0; a < points->components; ++a) xi[a] = points->x[a][j] - points->x[a][i];
    add_bond(&total, xi, points->volume[j],
             weighing == SDR_WEIGHED_FULL
                 ? sdr_families_weight(families, i, j, xi)
                 : sdr_family_plain_weight(families, family, points->spacing[j], length_of(xi)));
  }
  return total;
}
