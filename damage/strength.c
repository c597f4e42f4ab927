#include "damage/strength.h"

#include "base/memory.h"
#include "damage/bond_law.h"
#include "nom/stencil.h"

#include <math.h>
#include <string.h>

enum { COMPONENTS = 6, IN_PLANE = 3 };

static const double pi = 3.14159265358979323846;

/* ---- directions of bonds --------------------------------------------------------------------- */

/* One of each two opposite bonds of a family: its unit vector and weight 2 b |xi| V. */
typedef struct {
  int count;
  double *direction; /* 3 a bond */
  double *weight;
  double *largest; /* the bond's largest stretch so far */
} fan;

static void fan_destroy(fan *f)
{
  sdr_free(f->direction);
  sdr_free(f->weight);
  sdr_free(f->largest);
}

static sdr_status fan_alloc(int count, fan *out)
{
  *out = (fan){count, sdr_alloc((size_t)count, 3 * sizeof(double)),
               sdr_alloc((size_t)count, sizeof(double)), sdr_alloc((size_t)count, sizeof(double))};
  if (out->direction && out->weight && out->largest) return SDR_OK;
  fan_destroy(out);
  return SDR_RUN_FAILED;
}

/* The stencil's neighbours k and count - 1 - k are opposite. */
static sdr_status fan_of_stencil(const sdr_families *families, const sdr_family *family, fan *out)
{
  sdr_stencil stencil;
  SDR_TRY(
      sdr_stencil_create(families->points->components, family->spacing, family->horizon, &stencil));
  const sdr_status status = fan_alloc(stencil.count / 2, out);
  for (int k = 0; k < stencil.count / 2 && status == SDR_OK; ++k) {
    double xi[3];
    sdr_stencil_vector(families->points, family->spacing, stencil.step + 3 * (size_t)k, xi);
    const double length = sqrt(xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]);
    for (int a = 0; a < 3; ++a) out->direction[3 * k + a] = xi[a] / length;
    out->weight[k] = 2.0 * sdr_family_bond_weight(families, family, xi) * length * family->volume;
  }
  sdr_stencil_destroy(&stencil);
  return status;
}

/* Equally many bonds everywhere: a half circle, or half a sphere by the golden angle. */
static sdr_status fan_of_continuum(const sdr_families *families, const sdr_family *family, fan *out)
{
  const int n = families->points->components, count = n == 1 ? 1 : n == 2 ? 90 : 300;
  SDR_TRY(fan_alloc(count, out));
  for (int k = 0; k < count; ++k) {
    double *d = out->direction + 3 * (size_t)k;
    const double share = (k + 0.5) / count, turn = n == 3 ? k * pi * (3.0 - sqrt(5.0)) : pi * share;
    d[2] = n == 3 ? share : 0.0;
    d[0] = n == 1 ? 1.0 : sqrt(1.0 - d[2] * d[2]) * cos(turn);
    d[1] = n == 1 ? 0.0 : sqrt(1.0 - d[2] * d[2]) * sin(turn);
    out->weight[k] = family->first / count;
  }
  return SDR_OK;
}

/* A bond's products n_a n_b along the axes of the pull: xx first, then yy, 2 xy, zz, 2 yz, 2 xz. */
static void products(double axes[3][3], const double d[3], double p[COMPONENTS])
{
  double m[3];
  for (int a = 0; a < 3; ++a) m[a] = axes[a][0] * d[0] + axes[a][1] * d[1] + axes[a][2] * d[2];
  p[0] = m[0] * m[0];
  p[1] = m[1] * m[1];
  p[2] = 2.0 * m[0] * m[1];
  p[3] = m[2] * m[2];
  p[4] = 2.0 * m[1] * m[2];
  p[5] = 2.0 * m[0] * m[2];
}

/* Right-handed axes with the first along n; in a plane the third stays normal to it. */
static void axes_along(const double n[3], int components, double axes[3][3])
{
  double z[3] = {0.0, 0.0, 1.0};
  if (components == 3 && fabs(n[2]) > 0.6) {
    z[2] = 0.0;
    z[0] = 1.0;
  }
  const double along = z[0] * n[0] + z[1] * n[1] + z[2] * n[2];
  double square = 0.0;
  for (int a = 0; a < 3; ++a) {
    axes[0][a] = n[a];
    axes[2][a] = z[a] - along * n[a];
    square += axes[2][a] * axes[2][a];
  }
  for (int a = 0; a < 3; ++a) axes[2][a] /= sqrt(square);
  for (int a = 0; a < 3; ++a)
    axes[1][a] = axes[2][(a + 1) % 3] * n[(a + 2) % 3] - axes[2][(a + 2) % 3] * n[(a + 1) % 3];
}

/* ---- uniaxial stress ------------------------------------------------------------------------- */

typedef struct {
  const fan *bonds;
  const double *product; /* COMPONENTS a bond */
  const sdr_strength_law *law;
  int components; /* of strain: 1, 3 or 6 */
} pull;

/* Stress of a strain (Pa) and its slope. */
static void stress_of(const pull *p, const double strain[COMPONENTS], double stress[COMPONENTS],
                      double slope[COMPONENTS][COMPONENTS])
{
  memset(stress, 0, COMPONENTS * sizeof *stress);
  memset(slope, 0, COMPONENTS * sizeof *slope);
  for (int k = 0; k < p->bonds->count; ++k) {
    const double *m = p->product + COMPONENTS * (size_t)k;
    double s = 0.0;
    for (int c = 0; c < p->components; ++c) s += strain[c] * m[c];
    const sdr_bond_answer bond =
        sdr_bond_law(p->law->law, s, p->bonds->largest[k], p->law->q, p->law->r);
    const double weight = p->law->c * p->bonds->weight[k];
    for (int c = 0; c < p->components; ++c) {
      stress[c] += weight * bond.force * m[c];
      for (int d = 0; d < p->components; ++d) slope[c][d] += weight * bond.slope * m[c] * m[d];
    }
  }
}

/* Solve the small dense system in place by elimination with pivots; 0 if it is singular. */
static int solve(int n, double a[COMPONENTS][COMPONENTS], double x[COMPONENTS])
{
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int r = k + 1; r < n; ++r)
      if (fabs(a[r][k]) > fabs(a[best][k])) best = r;
    if (a[best][k] == 0.0) return 0;
    for (int c = 0; c < n; ++c) {
      const double keep = a[k][c];
      a[k][c] = a[best][c];
      a[best][c] = keep;
    }
    const double keep = x[k];
    x[k] = x[best];
    x[best] = keep;
    for (int r = 0; r < n; ++r) {
      if (r == k) continue;
      const double factor = a[r][k] / a[k][k];
      for (int c = k; c < n; ++c) a[r][c] -= factor * a[k][c];
      x[r] -= factor * x[k];
    }
  }
  for (int k = 0; k < n; ++k) x[k] /= a[k][k];
  return 1;
}

/* Find the other strains, so that nothing but the first stress is left; 0 if none is near. */
static int relax(const pull *p, double strain[COMPONENTS], double *stress)
{
  const int n = p->components - 1;
  for (int iteration = 0; iteration < 40; ++iteration) {
    double t[COMPONENTS], slope[COMPONENTS][COMPONENTS], a[COMPONENTS][COMPONENTS];
    double x[COMPONENTS] = {0.0}, left = 0.0;
    stress_of(p, strain, t, slope);
    *stress = t[0];
    for (int c = 0; c < n; ++c) {
      left = fmax(left, fabs(t[c + 1]));
      x[c] = -t[c + 1];
      for (int d = 0; d < n; ++d) a[c][d] = slope[c + 1][d + 1];
    }
    if (left <= 1e-10 * fabs(t[0])) return 1;
    if (!solve(n, a, x)) return 0;
    for (int c = 0; c < n; ++c) strain[c + 1] += x[c];
  }
  return 0;
}

typedef struct {
  double strain[COMPONENTS], stress;
} pulled;

static void remember(const pull *p, const pulled *at)
{
  for (int k = 0; k < p->bonds->count; ++k) {
    double s = 0.0;
    for (int c = 0; c < p->components; ++c)
      s += at->strain[c] * p->product[COMPONENTS * (size_t)k + (size_t)c];
    p->bonds->largest[k] = fmax(p->bonds->largest[k], s);
  }
}

/* Pull in steps from *from to `end`; *before: where the step to the largest stress began. The
   history is that of a path which never turns back, so it is what the last state says. */
static void march(const pull *p, double step, double end, pulled *before, pulled *most)
{
  pulled at = *before;
  memset(p->bonds->largest, 0, (size_t)p->bonds->count * sizeof(double));
  if (!relax(p, at.strain, &at.stress)) return;
  remember(p, &at);
  *most = at;
  while (at.strain[0] < end) {
    pulled next = at;
    next.strain[0] += step;
    if (!relax(p, next.strain, &next.stress)) return;
    if (next.stress > most->stress) {
      *before = at;
      *most = next;
    }
    remember(p, &next);
    at = next;
  }
}

sdr_status sdr_strength_along(const sdr_families *families, const sdr_family *family,
                              const sdr_strength_law *law, const double n[3], double *stress,
                              double *strain)
{
  const int components = families->points->components;
  fan bonds;
  SDR_TRY(family->source == SDR_MOMENTS_STENCIL ? fan_of_stencil(families, family, &bonds)
                                                : fan_of_continuum(families, family, &bonds));
  double *product = sdr_alloc((size_t)bonds.count, COMPONENTS * sizeof *product);
  if (product) {
    const int strains = components == 1 ? 1 : components == 2 ? IN_PLANE : COMPONENTS;
    const pull p = {&bonds, product, law, strains};
    double axes[3][3];
    axes_along(n, components, axes);
    for (int k = 0; k < bonds.count; ++k)
      products(axes, bonds.direction + 3 * (size_t)k, product + COMPONENTS * (size_t)k);
    const double scale = law->law == SDR_LAW_COHESIVE ? law->q : sqrt(law->q);
    /* Below half of that strain no bond of any law has softened so far that a peak were near. */
    pulled before = {{0.5 * scale}, 0.0}, most = before;
    double end = 2.0 * scale;
    for (double step = 0.04 * scale; step > 1e-5 * scale; step *= 0.125) {
      march(&p, step, end, &before, &most);
      end = most.strain[0] + step;
    }
    *stress = most.stress;
    if (strain) *strain = most.strain[0];
  }
  sdr_free(product);
  fan_destroy(&bonds);
  return product ? SDR_OK : SDR_RUN_FAILED;
}

/* ---- over directions ------------------------------------------------------------------------- */

/* Strength along a direction given on the lattice's axes, with a weight in the mean. */
static sdr_status add_direction(const sdr_families *families, const sdr_family *family,
                                const sdr_strength_law *law, const double on_axes[3], double weight,
                                sdr_strength_range *sum)
{
  double n[3] = {0.0}, stress;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) n[a] += families->points->axes[b][a] * on_axes[b];
  SDR_TRY(sdr_strength_along(families, family, law, n, &stress, NULL));
  sum->mean += weight * stress;
  sum->least = fmin(sum->least, stress);
  sum->most = fmax(sum->most, stress);
  return SDR_OK;
}

sdr_status sdr_strength_over_directions(const sdr_families *families, const sdr_family *family,
                                        const sdr_strength_law *law, sdr_strength_range *out)
{
  const int components = families->points->components;
  sdr_strength_range sum = {0.0, INFINITY, 0.0};
  double weights = 0.0;
  const int alike = components == 1 || family->source != SDR_MOMENTS_STENCIL;
  const int most = alike ? 0 : components == 2 ? 9 : 6;
  for (int k = 0; k <= most; ++k)
    for (int l = 0; l <= (components == 3 ? k : 0); ++l) {
      /* 3-D: (1, y, z) with 1 >= y >= z on the cube, weighed by what it covers of the sphere */
      const double y = k / 6.0, z = l / 6.0, square = 1.0 + y * y + z * z, length = sqrt(square);
      const double angle = k * pi / 36.0;
      const double flat[3] = {cos(angle), sin(angle), 0.0};
      const double space[3] = {1.0 / length, y / length, z / length};
      double weight = (k == 0 || k == most) && !alike ? 0.5 : 1.0;
      if (components == 3) weight *= (l == 0 || l == k ? 0.5 : 1.0) / (square * length);
      SDR_TRY(add_direction(families, family, law, components == 3 ? space : flat, weight, &sum));
      weights += weight;
    }
  sum.mean /= weights;
  *out = sum;
  return SDR_OK;
}

/* ---- cohesive -------------------------------------------------------------------------------- */

sdr_status sdr_cohesive_beta(const sdr_families *families, const sdr_family *family, double c,
                             double young, double *beta)
{
  /* B2 matters beyond mu s_e: in 2-D the peak comes before, in 3-D it moves by 0.2 %. */
  const double s_e = 1e-4;
  const sdr_strength_law law = {SDR_LAW_COHESIVE, c, s_e, 0.1};
  sdr_strength_range range = {0.0, INFINITY, 0.0};
  if (families->points->components == 2 && family->source == SDR_MOMENTS_STENCIL)
    for (int k = 0; k < 3; ++k) {
      const double n[3] = {cos(k * pi / 8.0), sin(k * pi / 8.0), 0.0};
      SDR_TRY(add_direction(families, family, &law, n, 1.0 / 3.0, &range));
    }
  else
    SDR_TRY(sdr_strength_over_directions(families, family, &law, &range));
  *beta = range.mean / (young * s_e);
  return SDR_OK;
}

sdr_status sdr_cohesive_constants(double horizon, double young, double critical_squared,
                                  double strength, double beta, double *s_e, double *decline)
{
  const double yield = strength / (beta * young), a = critical_squared / (yield * yield);
  if (!(a > SDR_COHESIVE_LEAST))
    return sdr_fail(SDR_BAD_INPUT,
                    "the horizon %g mm is too large for the law cohesive with this strength and "
                    "toughness; at most %.4g mm meets both",
                    horizon * 1e3, horizon * a / SDR_COHESIVE_LEAST * 1e3);
  const double last = 1.0 + (a - SDR_COHESIVE_MU) / SDR_COHESIVE_GAMMA;
  *s_e = yield;
  *decline = SDR_COHESIVE_GAMMA / (last - SDR_COHESIVE_MU);
  return SDR_OK;
}
