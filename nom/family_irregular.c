/* Moments of families of points on no lattice: means over complete families of their kind (points
   of a mesh are mostly alone in theirs); families at surfaces, that have none, take the integral,
   times the mean over all complete points of sum over integral. */
#include "base/memory.h"
#include "nom/family_sums.h"

#include <math.h>
#include <string.h>

/* Measure of the ball of radius `horizon`, times thickness or area. */
static double ball(const sdr_points *points, const sdr_family *family)
{
  const double d = family->horizon, pi = 3.14159265358979323846;
  const double across = family->volume / pow(family->spacing, points->components);
  const double measure[3] = {2.0 * d, pi * d * d, 4.0 / 3.0 * pi * d * d * d};
  return across * measure[points->components - 1];
}

/* A family counts as complete if it fills its ball and lies around its point. */
static int complete(const sdr_points *points, const sdr_family *family,
                    const sdr_family_sums *total)
{
  double offset = 0.0;
  for (int a = 0; a < 3; ++a) offset += total->offset[a] * total->offset[a];
  return total->volume > 0.9 * ball(points, family) &&
         sqrt(offset) < 0.1 * total->volume * family->horizon;
}

/* Mean over the ball of influence times (|xi|/horizon)^power: midpoints in q, fine enough for
   1e-7 of the smooth influence functions; a constant one is exact. */
static double mean_influence(const sdr_families *families, int power)
{
  const int n = families->points->components;
  if (families->how.influence == SDR_INFLUENCE_CONSTANT) return (double)n / (n + power);
  enum { PARTS = 2000 };
  double sum = 0.0;
  for (int k = 0; k < PARTS; ++k) {
    const double q = (k + 0.5) / PARTS;
    sum += sdr_influence_at(families->how.influence, q) * pow(q, power + n - 1);
  }
  return n * sum / PARTS;
}

double sdr_continuum_moment(const sdr_points *points, const sdr_family *family, int state_based)
{
  const int n = points->components, power = state_based ? 2 : 1;
  return ball(points, family) * pow(family->horizon, power) * n / (n + power);
}

/* What the sums over complete families are of the integrals that they stand for: means over all
   such points. */
typedef struct {
  double influence[2]; /* mean over the ball times |xi|/horizon, and its square */
  double first, second, moment;
  int64_t count;
} shares;

static void continuum_moments(const sdr_families *families, const shares *found, sdr_family *family)
{
  const sdr_points *points = families->points;
  const double volume = ball(points, family), d = family->horizon;
  family->first = volume * d * found->influence[0];
  family->second = volume * d * d * found->influence[1];
  family->moment = families->how.state_based ? family->second : family->first;
}

static void add_shares(const sdr_families *families, const sdr_family *family,
                       const sdr_family_sums *own, shares *found)
{
  sdr_family whole = *family;
  continuum_moments(families, found, &whole);
  found->first += own->first / whole.first;
  found->second += own->second / whole.second;
  found->moment += own->moment / whole.moment;
  ++found->count;
}

/* A family of which no point is complete: the integrals, times what they are worth elsewhere. */
static void estimate_moments(const sdr_families *families, const shares *found, sdr_family *family)
{
  continuum_moments(families, found, family);
  family->source = SDR_MOMENTS_CONTINUUM;
  if (found->count > 0) {
    family->source = SDR_MOMENTS_MEAN;
    family->first *= found->first / (double)found->count;
    family->second *= found->second / (double)found->count;
    family->moment *= found->moment / (double)found->count;
  }
  sdr_quartic_means(families->points->components, family->quartic);
  for (int k = 0; k < SDR_MONOMIALS; ++k) family->quartic[k] *= family->moment;
}

static void add_moments(sdr_family *family, const sdr_family_sums *own)
{
  family->first += own->first;
  family->second += own->second;
  family->moment += own->moment;
  for (int k = 0; k < SDR_MONOMIALS; ++k) family->quartic[k] += own->quartic[k];
}

static void scale_moments(sdr_family *family, double factor)
{
  family->first *= factor;
  family->second *= factor;
  family->moment *= factor;
  for (int k = 0; k < SDR_MONOMIALS; ++k) family->quartic[k] *= factor;
}

/* Sum the moments of complete points by family, how many there are to counted[]. */
static void sum_complete(sdr_families *families, const sdr_neighbourhood *near, int64_t *counted,
                         shares *found)
{
  const sdr_points *points = families->points;
  for (int32_t i = 0; i < points->count; ++i) {
    const int32_t f = families->of_point ? families->of_point[i] : 0;
    const sdr_family_sums own = sdr_sum_neighbours(families, near, i, SDR_WEIGHED_FULL);
    if (!complete(points, &families->family[f], &own)) continue;
    ++counted[f];
    add_moments(&families->family[f], &own);
    add_shares(families, &families->family[f], &own, found);
  }
}

sdr_status sdr_irregular_moments(sdr_families *families, const sdr_neighbourhood *near)
{
  shares found = {{mean_influence(families, 1), mean_influence(families, 2)}, 0.0, 0.0, 0.0, 0};
  int64_t *counted = sdr_alloc((size_t)families->count, sizeof *counted);
  if (!counted) return SDR_RUN_FAILED;
  for (int f = 0; f < families->count; ++f) scale_moments(&families->family[f], 0.0);
  sum_complete(families, near, counted, &found);
  for (int f = 0; f < families->count; ++f) {
    sdr_family *family = &families->family[f];
    if (counted[f] == 0) {
      estimate_moments(families, &found, family);
      continue;
    }
    family->source = SDR_MOMENTS_MEAN;
    scale_moments(family, 1.0 / (double)counted[f]);
  }
  sdr_free(counted);
  return SDR_OK;
}
