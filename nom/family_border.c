/* Weights of bonds near the border of two spacings that leave uniform strain in equilibrium (theory
   sec. 5): a strain e pulls point i with sum c n (n.e n), so sum c n n n must be what it is on a
   lattice of one spacing, 0 inside. Of all changes c (1 + d) of the pairs between points of the
   border that do so, the least, sum c d^2, is d = (mu_i - mu_j) . n n n with a multiplier for each
   component of each point's sum. */
#include "base/memory.h"
#include "nom/cells.h"
#include "nom/family_sums.h"

#include <math.h>
#include <string.h>

enum { ITERATIONS = 200 };

/* `damping`: how much a point's multipliers cost beside the change of its pairs. Where the border
   meets a surface not all can be mended, and a large change far off would gain a little. */
static const double least_factor = 0.2, damping = 3e-3, tolerance = 1e-4;

/* A pair of two points of the border; c: its force a unit of stretch over Young's modulus, but for
   a constant that all share, m^2. */
typedef struct {
  int32_t i, j; /* numbers times cubics */
  double c, phi[SDR_CUBICS];
} border_pair;

typedef struct {
  sdr_families *families;
  const sdr_neighbourhood *near;
  int cubics;
  uint8_t *in;      /* a point */
  int32_t *number;  /* a point: its place among those of the border */
  int32_t unknowns; /* points of the border times cubics; so many numbers have those below */
  border_pair *pairs;
  int64_t count;
  double *rest; /* what is left of sum c n n n, less what a lattice of one spacing in the same body
                   has there */
  double *mu;
  double *size; /* sum c phi^2 over the pairs of a point, the mean of its cubics */
  double *step, *residual, *image, *step_image;
} border;

int sdr_cubic(int components, const double n[3], double phi[SDR_CUBICS])
{
  int count = 0;
  for (int a = 0; a < components; ++a)
    for (int b = a; b < components; ++b)
      for (int c = b; c < components; ++c) phi[count++] = n[a] * n[b] * n[c];
  return count;
}

double sdr_border_factor(const sdr_families *families, int32_t i, int32_t j, const double n[3])
{
  double phi[SDR_CUBICS], factor = 1.0;
  const int count = sdr_cubic(families->points->components, n, phi);
  const double *mi = families->cubic + (size_t)count * (size_t)i;
  const double *mj = families->cubic + (size_t)count * (size_t)j;
  for (int k = 0; k < count; ++k) factor += (mi[k] - mj[k]) * phi[k];
  return factor > least_factor ? factor : least_factor;
}

/* xi = x_j - x_i, and its direction n. */
static void direction_of(const sdr_points *points, int32_t i, int32_t j, double xi[3], double n[3])
{
  double square = 0.0;
  for (int a = 0; a < 3; ++a) {
    xi[a] = a < points->components ? points->x[a][j] - points->x[a][i] : 0.0;
    square += xi[a] * xi[a];
  }
  for (int a = 0; a < 3; ++a) n[a] = xi[a] / sqrt(square);
}

/* c of the directed bond i -> j. */
static double directed(const sdr_families *families, int32_t i, int32_t j, const double xi[3])
{
  const double *volume = families->points->volume;
  return sdr_families_weight(families, i, j, xi) * volume[i] * volume[j] /
         sdr_family_of(families, i)->first;
}

/* ---- who is there ---------------------------------------------------------------------------- */

static void find_points(border *b)
{
  const sdr_points *points = b->families->points;
  for (int32_t i = 0; i < points->count; ++i)
    for (int64_t k = b->near->row[i]; k < b->near->row[i + 1]; ++k) {
      const int32_t j = b->near->column[k];
      if (points->spacing[i] != points->spacing[j]) b->in[i] = b->in[j] = 1;
    }
  for (int32_t i = 0; i < points->count; ++i) {
    b->number[i] = b->unknowns;
    if (b->in[i]) b->unknowns += b->cubics;
  }
}

static int listed_by(const border *b, int32_t i, int32_t j)
{
  const sdr_points *points = b->families->points;
  return b->in[i] && b->in[j] &&
         (i < j || !sdr_in_horizon(points, j, sdr_distance_squared(points, i, j)));
}

static void add_pair(border *b, int32_t i, int32_t j, double c_ij)
{
  const sdr_points *points = b->families->points;
  double xi[3], n[3];
  border_pair *pair = &b->pairs[b->count++];
  *pair = (border_pair){.i = b->number[i], .j = b->number[j], .c = c_ij};
  direction_of(points, i, j, xi, n);
  sdr_cubic(points->components, n, pair->phi);
  if (!sdr_in_horizon(points, j, sdr_distance_squared(points, i, j))) return;
  for (int a = 0; a < 3; ++a) xi[a] = -xi[a];
  pair->c += directed(b->families, j, i, xi);
}

/* All bonds' parts of sum c n n n, and the border's pairs. */
static sdr_status add_bonds(border *b)
{
  const sdr_points *points = b->families->points;
  int64_t most = 0;
  for (int32_t i = 0; i < points->count; ++i)
    for (int64_t k = b->near->row[i]; k < b->near->row[i + 1]; ++k)
      most += listed_by(b, i, b->near->column[k]);
  b->pairs = sdr_alloc((size_t)most + 1, sizeof *b->pairs);
  if (!b->pairs) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < points->count; ++i)
    for (int64_t k = b->near->row[i]; k < b->near->row[i + 1]; ++k) {
      const int32_t j = b->near->column[k];
      if (!b->in[i] && !b->in[j]) continue;
      double xi[3], n[3], phi[SDR_CUBICS];
      direction_of(points, i, j, xi, n);
      sdr_cubic(points->components, n, phi);
      const double c = directed(b->families, i, j, xi);
      for (int m = 0; m < b->cubics; ++m) {
        if (b->in[i]) b->rest[b->number[i] + m] += c * phi[m];
        if (b->in[j]) b->rest[b->number[j] + m] -= c * phi[m];
      }
      if (listed_by(b, i, j)) add_pair(b, i, j, c);
    }
  return SDR_OK;
}

/* ---- a lattice of one spacing in the same body ----------------------------------------------- */

typedef struct {
  const sdr_points *points;
  sdr_cells cells;
  double largest; /* spacing */
} filling;

/* Share of a cell of `size` around x that the cell of point j fills. */
static double shared_by(const sdr_points *points, int32_t j, const double x[3], double size)
{
  double share = 1.0;
  for (int a = 0; a < points->components && share > 0.0; ++a) {
    double d = 0.0;
    for (int c = 0; c < points->components; ++c) d += points->axes[a][c] * (points->x[c][j] - x[c]);
    const double end = fmin(size, d + points->spacing[j]),
                 start = fmax(-size, d - points->spacing[j]);
    share *= fmax(0.0, end - start) / (2.0 * size);
  }
  return share;
}

/* Share of a cell of `size` around x that the body fills. */
static double filled(const filling *body, const double x[3], double size)
{
  const sdr_cells *cells = &body->cells;
  int32_t low[3] = {0}, high[3] = {0};
  const double reach = 0.5 * (size + body->largest) * sqrt(body->points->components);
  double share = 0.0;
  for (int a = 0; a < body->points->components; ++a) {
    low[a] = sdr_cells_coordinate(cells, a, x[a] - reach);
    high[a] = sdr_cells_coordinate(cells, a, x[a] + reach);
  }
  for (int64_t z = low[2]; z <= high[2]; ++z)
    for (int64_t y = low[1]; y <= high[1]; ++y) {
      const int64_t row = (z * cells->n[1] + y) * cells->n[0];
      for (int64_t k = cells->first[row + low[0]]; k < cells->first[row + high[0] + 1]; ++k)
        share += shared_by(body->points, cells->point[k], x, size);
    }
  return fmin(share, 1.0);
}

/* Take from point i what it would have on a lattice of its own spacing. */
static void less_one_spacing(border *b, const filling *body, const sdr_stencil *stencil, int32_t i)
{
  const sdr_points *points = body->points;
  const sdr_family *family = sdr_family_of(b->families, i);
  const double volumes = family->volume * family->volume;
  for (int k = 0; k < stencil->count; ++k) {
    double xi[3], x[3] = {0.0}, n[3], phi[SDR_CUBICS], square = 0.0;
    sdr_stencil_vector(points, family->spacing, stencil->step + 3 * k, xi);
    for (int a = 0; a < points->components; ++a) {
      x[a] = points->x[a][i] + xi[a];
      square += xi[a] * xi[a];
    }
    for (int a = 0; a < 3; ++a) n[a] = xi[a] / sqrt(square);
    sdr_cubic(points->components, n, phi);
    const double c = 2.0 * sdr_family_bond_weight(b->families, family, xi) * volumes /
                     family->first * filled(body, x, family->spacing);
    for (int m = 0; m < b->cubics; ++m) b->rest[b->number[i] + m] -= c * phi[m];
  }
}

static sdr_status each_less_one_spacing(border *b, const filling *body)
{
  const sdr_points *points = body->points;
  const sdr_family *last = NULL;
  sdr_stencil stencil = {0};
  sdr_status status = SDR_OK;
  for (int32_t i = 0; i < points->count && status == SDR_OK; ++i) {
    const sdr_family *family = sdr_family_of(b->families, i);
    if (!b->in[i]) continue;
    if (family != last) {
      sdr_stencil_destroy(&stencil);
      status = sdr_stencil_create(points->components, family->spacing, family->horizon, &stencil);
    }
    last = family;
    if (status == SDR_OK) less_one_spacing(b, body, &stencil, i);
  }
  sdr_stencil_destroy(&stencil);
  return status;
}

static sdr_status less_lattice(border *b)
{
  const sdr_points *points = b->families->points;
  filling body = {.points = points, .largest = points->spacing[0]};
  double least = points->spacing[0];
  for (int32_t i = 1; i < points->count; ++i) {
    least = fmin(least, points->spacing[i]);
    body.largest = fmax(body.largest, points->spacing[i]);
  }
  SDR_TRY(sdr_cells_create(points, 2.0 * least, &body.cells));
  const sdr_status status = each_less_one_spacing(b, &body);
  sdr_cells_destroy(&body.cells);
  return status;
}

/* ---- the least change ------------------------------------------------------------------------ */

static double change_of(const border *b, const border_pair *p, const double *mu)
{
  double change = 0.0;
  for (int m = 0; m < b->cubics; ++m) change += (mu[p->i + m] - mu[p->j + m]) * p->phi[m];
  return change;
}

static void image_of(const border *b, const double *mu, double *out)
{
  for (int32_t k = 0; k < b->unknowns; ++k) out[k] = damping * b->size[k] * mu[k];
  for (int64_t k = 0; k < b->count; ++k) {
    const border_pair *p = &b->pairs[k];
    const double change = p->c * change_of(b, p, mu);
    for (int m = 0; m < b->cubics; ++m) {
      out[p->i + m] += change * p->phi[m];
      out[p->j + m] -= change * p->phi[m];
    }
  }
}

static double product(const border *b, const double *x, const double *y)
{
  double sum = 0.0;
  for (int32_t k = 0; k < b->unknowns; ++k) sum += x[k] * y[k];
  return sum;
}

/* Conjugate residuals: what is left falls with every iteration and stays least where it cannot
   vanish, as where the border meets a surface. */
static void solve(border *b)
{
  const int32_t count = b->unknowns;
  const size_t bytes = (size_t)count * sizeof *b->residual;
  for (int32_t k = 0; k < count; ++k) b->residual[k] = -b->rest[k];
  memcpy(b->step, b->residual, bytes);
  image_of(b, b->residual, b->image);
  memcpy(b->step_image, b->image, bytes);
  double along = product(b, b->residual, b->image);
  const double enough = tolerance * tolerance * product(b, b->step_image, b->step_image);
  for (int iteration = 0; iteration < ITERATIONS; ++iteration) {
    const double square = product(b, b->step_image, b->step_image);
    if (!(square > enough) || !(along > 0.0)) break;
    const double size = along / square;
    for (int32_t k = 0; k < count; ++k) {
      b->mu[k] += size * b->step[k];
      b->residual[k] -= size * b->step_image[k];
    }
    image_of(b, b->residual, b->image);
    const double next = product(b, b->residual, b->image), share = next / along;
    along = next;
    for (int32_t k = 0; k < count; ++k) {
      b->step[k] = b->residual[k] + share * b->step[k];
      b->step_image[k] = b->image[k] + share * b->step_image[k];
    }
  }
}

static sdr_status alloc_border(border *b)
{
  const size_t count = (size_t)b->unknowns;
  b->rest = sdr_alloc(count, sizeof(double));
  b->mu = sdr_alloc(count, sizeof(double));
  b->size = sdr_alloc(count, sizeof(double));
  b->step = sdr_alloc(count, sizeof(double));
  b->residual = sdr_alloc(count, sizeof(double));
  b->image = sdr_alloc(count, sizeof(double));
  b->step_image = sdr_alloc(count, sizeof(double));
  return b->rest && b->mu && b->size && b->step && b->residual && b->image && b->step_image
             ? SDR_OK
             : SDR_RUN_FAILED;
}

static void measure_points(const border *b)
{
  for (int64_t k = 0; k < b->count; ++k) {
    const border_pair *p = &b->pairs[k];
    double square = 0.0;
    for (int m = 0; m < b->cubics; ++m) square += p->phi[m] * p->phi[m];
    for (int m = 0; m < b->cubics; ++m) {
      b->size[p->i + m] += p->c * square / b->cubics;
      b->size[p->j + m] += p->c * square / b->cubics;
    }
  }
}

static sdr_status balance(border *b)
{
  SDR_TRY(alloc_border(b));
  SDR_TRY(add_bonds(b));
  SDR_TRY(less_lattice(b));
  measure_points(b);
  solve(b);
  return SDR_OK;
}

/* The multipliers of all points, 0 away from the border. */
static sdr_status hand_over(border *b)
{
  sdr_families *families = b->families;
  const size_t cubics = (size_t)b->cubics;
  families->cubic = sdr_alloc((size_t)families->points->count, cubics * sizeof(double));
  if (!families->cubic) return SDR_RUN_FAILED;
  for (int32_t i = 0; i < families->points->count; ++i)
    if (b->in[i])
      memcpy(families->cubic + cubics * (size_t)i, b->mu + b->number[i], cubics * sizeof(double));
  families->border = b->in;
  b->in = NULL;
  return SDR_OK;
}

sdr_status sdr_border_weights(sdr_families *families, const sdr_neighbourhood *near)
{
  border b = {.families = families, .near = near};
  const double any[3] = {1.0, 0.0, 0.0};
  double phi[SDR_CUBICS];
  b.cubics = sdr_cubic(families->points->components, any, phi);
  b.in = sdr_alloc(sdr_points_padded(families->points), 1);
  b.number = sdr_alloc((size_t)families->points->count, sizeof *b.number);
  sdr_status status = b.in && b.number ? SDR_OK : SDR_RUN_FAILED;
  if (status == SDR_OK) find_points(&b);
  if (status == SDR_OK && b.unknowns > 0) {
    status = balance(&b);
    if (status == SDR_OK) status = hand_over(&b);
  }
  sdr_free(b.in);
  sdr_free(b.number);
  sdr_free(b.pairs);
  sdr_free(b.rest);
  sdr_free(b.mu);
  sdr_free(b.size);
  sdr_free(b.step);
  sdr_free(b.residual);
  sdr_free(b.image);
  sdr_free(b.step_image);
  return status;
}
