/* The critical stretch of non-ordinary bodies, from what their families lose: full families are
   split by planes in many directions, with everything that breaking bonds bring about
   (nonordinary_break.c, nonordinary_families.c) for small strains. All is in proportion to the
   opening, so events are found without steps. s0 is such that the cheapest and the dearest
   direction lie equally far from Gc. */
#include "mechanics/nonordinary_internal.h"
#include "mechanics/state_split.h"

#include <math.h>

/* A material over its shear modulus. */
typedef struct {
  double lambda, mu, control_shear, control_normal;
} split_call;

/* A bond at an opening of 1: distance beyond the plane, stretch, what breaks it (the square of s,
   and of s and z across), whether it is left, or would be once those that break now are gone. */
typedef struct {
  double along, length, stretch, drive, left, staying;
} split_bond;

/* One family whose owner lies at the distance h from the plane. */
typedef struct {
  const split_call *of;
  const sdr_full_family *family;
  const double *normal;
  split_bond *bond;
  double h, trace, least; /* of the whole K; least: where moduli fade */
  int torn;
} split_family;

static void add_shape(const split_family *at, int k, double k_sum[6], double m_sum[9])
{
  const int n = at->family->components;
  const double *xi = at->family->xi + 3 * (size_t)k, w = at->family->weight[k];
  const double opens = at->bond[k].along > at->h ? 1.0 : 0.0;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      m_sum[n * a + b] += w * opens * at->normal[a] * xi[b];
      if (b >= a) k_sum[sdr_upper(n, a, b)] += w * xi[a] * xi[b];
    }
}

/* G of the bonds with `left` (or `staying`); returns the share of the moduli, 0: K is singular. */
static double gradient_of(const split_family *at, int staying, double g[9])
{
  const int n = at->family->components;
  double k_sum[6] = {0.0}, m[9] = {0.0}, inverse[6];
  for (int k = 0; k < at->family->count; ++k)
    if (staying ? at->bond[k].staying > 0.0 : at->bond[k].left > 0.0) add_shape(at, k, k_sum, m);
  const double share = sdr_nonordinary_share(n, k_sum, at->least, inverse);
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      g[n * a + b] = 0.0;
      for (int c = 0; c < n; ++c) g[n * a + b] += m[n * a + c] * inverse[sdr_upper(n, c, b)];
    }
  return share;
}

/* |z|^2 and (z.xi/|xi|)^2 of a bond. */
static void residual(const split_family *at, int k, const double g[9], double *square,
                     double *along)
{
  const int n = at->family->components;
  const double *xi = at->family->xi + 3 * (size_t)k;
  const double opens = at->bond[k].along > at->h ? 1.0 : 0.0;
  double dot = 0.0;
  *square = 0.0;
  for (int a = 0; a < n; ++a) {
    double z = opens * at->normal[a];
    for (int b = 0; b < n; ++b) z -= g[n * a + b] * xi[b];
    *square += z * z;
    dot += z * xi[a] / at->bond[k].length;
  }
  *along = dot * dot;
}

/* Energy density over the opening squared; `drive` of the bonds left is set unless `staying`. */
static double density_of(const split_family *at, int staying)
{
  const int n = at->family->components;
  const sdr_moduli moduli = {at->of->lambda, at->of->mu, 0};
  double g[9], control = 0.0;
  const double share = gradient_of(at, staying, g);
  sdr_point_stress stress;
  if (!(share > 0.0)) return 0.0;
  sdr_stress_of(n, SDR_LINEAR, SDR_SPLIT_WHOLE, &moduli, g, &stress);
  for (int k = 0; k < at->family->count; ++k) {
    split_bond *bond = &at->bond[k];
    double square, along;
    if (!(staying ? bond->staying > 0.0 : bond->left > 0.0)) continue;
    residual(at, k, g, &square, &along);
    control +=
        at->family->weight[k] * (at->of->control_shear * square + at->of->control_normal * along);
    if (staying) continue;
    bond->drive = bond->stretch * bond->stretch;
    if (at->torn) bond->drive += (square - along) / (bond->length * bond->length);
  }
  return share * share * stress.plus + 0.5 * control / at->trace;
}

/* The largest drive of bonds that open, below `below`; 0: there is none. */
static double largest_drive(const split_family *at, double below)
{
  double most = 0.0;
  for (int k = 0; k < at->family->count; ++k) {
    const split_bond *bond = &at->bond[k];
    if (bond->left > 0.0 && bond->stretch > 0.0 && bond->drive < below)
      most = fmax(most, bond->drive);
  }
  return most;
}

/* What the family loses, over s0^2: bonds break in the order of their drive; where what stays
   would store more, with the next ones. */
static double loss_of(split_family *at)
{
  double opening = 0.0, loss = 0.0, energy = density_of(at, 0);
  double drive = largest_drive(at, (double)INFINITY);
  while (drive > 0.0) {
    const double limit = drive * (1.0 - 1e-9);
    opening = fmax(opening, 1.0 / drive); /* squared, over s0^2 */
    const double breaks = fmin(limit, (1.0 - 1e-9) / opening);
    for (int k = 0; k < at->family->count; ++k) {
      split_bond *bond = &at->bond[k];
      bond->staying = bond->stretch > 0.0 && bond->drive > breaks ? 0.0 : bond->left;
    }
    const double after = density_of(at, 1);
    if (after > energy) {
      drive = largest_drive(at, breaks);
      continue;
    }
    loss += opening * (energy - after);
    at->torn = 1;
    for (int k = 0; k < at->family->count; ++k) at->bond[k].left = at->bond[k].staying;
    energy = density_of(at, 0);
    drive = largest_drive(at, (double)INFINITY);
  }
  return loss;
}

/* Where the plane lies: as many places on the way of the horizon; fewer in each of many families.
 */
enum { PLACES = 24, PLACES_SOLID = 10, PLACES_OF_MANY = 5, DIRECTIONS = 60, DIRECTIONS_SOLID = 28 };

static void set_bonds(split_family *at)
{
  const sdr_full_family *f = at->family;
  for (int k = 0; k < f->count; ++k) {
    const double *xi = f->xi + 3 * (size_t)k;
    split_bond *bond = &at->bond[k];
    bond->length = sqrt(xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]);
    bond->along = xi[0] * at->normal[0] + xi[1] * at->normal[1] + xi[2] * at->normal[2];
  }
}

/* Start anew at another distance. */
static void place_plane(split_family *at, double h)
{
  at->h = h;
  at->torn = 0;
  for (int k = 0; k < at->family->count; ++k) {
    split_bond *bond = &at->bond[k];
    bond->left = bond->staying = 1.0;
    bond->stretch = bond->along > h ? bond->along / (bond->length * bond->length) : 0.0;
  }
}

/* Energy per area over s0^2 G and horizon. */
static double cost_of(const void *context, const sdr_full_family *f, const double normal[3])
{
  const int n = f->components;
  const int places = f->one_of_many ? PLACES_OF_MANY : n == 3 ? PLACES_SOLID : PLACES;
  split_family at = {.of = context, .family = f, .normal = normal, .bond = (split_bond *)f->space};
  double k_sum[6] = {0.0}, m[9] = {0.0}, sum = 0.0;
  set_bonds(&at);
  for (int k = 0; k < f->count; ++k) add_shape(&at, k, k_sum, m);
  for (int a = 0; a < n; ++a) at.trace += k_sum[sdr_upper(n, a, a)];
  at.least = sdr_nonordinary_least(n, k_sum);
  for (int k = 0; k < places; ++k) {
    place_plane(&at, (k + 0.5) / places * f->horizon);
    sum += loss_of(&at) * 2.0 / places; /* times the horizon, over it */
  }
  return sum;
}

sdr_status sdr_nonordinary_set_threshold(sdr_nonordinary_model *model, const double *toughness)
{
  const sdr_points *points = model->state.head.points;
  const int n = points->components, directions = n == 3 ? DIRECTIONS_SOLID : DIRECTIONS;
  double cost[UINT8_MAX + 1] = {0.0}; /* of each material; its points share ratios of moduli */
  for (int32_t i = 0; i < points->count; ++i) {
    const double shear = model->state.shear[i];
    double *of = &cost[points->material[i]];
    const split_call call = {.lambda = (model->state.bulk[i] - 2.0 * shear / n) / shear,
                             .mu = 1.0,
                             .control_shear = model->control_shear[i] / shear,
                             .control_normal = model->control_normal[i] / shear};
    if (!(*of > 0.0))
      SDR_TRY(sdr_split_middle(points, model->state.bonds, directions, cost_of, &call, of));
    model->state.threshold[i] = toughness[points->material[i]] / (*of * shear * points->horizon[i]);
  }
  return SDR_OK;
}
