/* Fields of non-ordinary bodies under a uniform gradient: what the laws give in closed form. */
#include "support/nonordinary.h"

/* Not symmetric, with strains of both signs, far from small. */
static const double gradient[9] = {0.06, 0.05, 0.01, -0.02, -0.08, 0.03, 0.02, 0.0, 0.04};

typedef struct {
  double lambda, mu;
} lame;

static lame lame_of(sdr_dimension dimension)
{
  const double nu = 0.3;
  if (dimension == SDR_1D) return (lame){0.0, 0.5 * body_young};
  return (lame){body_young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), body_young / (2.0 * (1.0 + nu))};
}

/* n x n */
static void product(int n, const double *a, const double *b, int turn, double *out)
{
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) {
      out[n * r + c] = 0.0;
      for (int k = 0; k < n; ++k)
        out[n * r + c] += a[n * r + k] * (turn ? b[n * c + k] : b[n * k + c]);
    }
}

static double determinant(int n, const double *f)
{
  if (n == 1) return f[0];
  if (n == 2) return f[0] * f[3] - f[1] * f[2];
  return f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6]) +
         f[2] * (f[3] * f[7] - f[4] * f[6]);
}

/* lambda tr e + 2 mu e; in plane stress with the strain across that leaves no stress there, which
   goes to *across. */
static void hooke(sdr_dimension dimension, int n, const double *e, double *stress, double *across)
{
  const lame l = lame_of(dimension);
  double trace = 0.0;
  for (int a = 0; a < n; ++a) trace += e[n * a + a];
  *across = dimension == SDR_PLANE_STRESS ? -l.lambda / (l.lambda + 2.0 * l.mu) * trace : 0.0;
  for (int k = 0; k < n * n; ++k)
    stress[k] = 2.0 * l.mu * e[k] + (k % (n + 1) == 0 ? l.lambda * (trace + *across) : 0.0);
}

/* F S F^T / det F of a plane body or one in space, with S of Green's strain. */
static void kirchhoff(sdr_dimension dimension, int n, const double *f, double *stress)
{
  double c[9], e[9] = {0.0}, second[9], half[9], transposed[9] = {0.0}, across;
  for (int k = 0; k < n * n; ++k) transposed[k] = f[n * (k % n) + k / n];
  product(n, transposed, f, 0, c);
  for (int k = 0; k < n * n; ++k) e[k] = 0.5 * (c[k] - (k % (n + 1) == 0));
  hooke(dimension, n, e, second, &across);
  product(n, f, second, 0, half);
  product(n, half, f, 1, stress);
  const double volume = determinant(n, f) * sqrt(1.0 + 2.0 * across);
  for (int k = 0; k < n * n; ++k) stress[k] /= volume;
}

/* (mu (F F^T - I) + lambda ln J) / J; in plane stress J takes part of the thickness that leaves no
   stress across, found by bisection. */
static void neo_hookean(sdr_dimension dimension, int n, const double *f, double *stress)
{
  const lame l = lame_of(dimension);
  const double plane = determinant(n, f);
  double b[9], low = 0.5, high = 2.0;
  for (int k = 0; k < 200 && dimension == SDR_PLANE_STRESS; ++k) {
    const double t = 0.5 * (low + high);
    *(l.mu * (t * t - 1.0) + l.lambda * log(plane * t) > 0.0 ? &high : &low) = t;
  }
  const double volume = dimension == SDR_PLANE_STRESS ? plane * low : plane;
  product(n, f, f, 1, b);
  for (int k = 0; k < n * n; ++k) {
    const int diagonal = k % (n + 1) == 0;
    stress[k] = (l.mu * (b[k] - diagonal) + diagonal * l.lambda * log(volume)) / volume;
  }
}

static void stress_of(sdr_dimension dimension, int n, sdr_elasticity law, const double *g,
                      double *stress)
{
  double f[9], e[9], unused;
  for (int k = 0; k < n * n; ++k) {
    f[k] = g[k] + (k % (n + 1) == 0);
    e[k] = 0.5 * (g[k] + g[n * (k % n) + k / n]);
  }
  if (law == SDR_LINEAR)
    hooke(dimension, n, e, stress, &unused);
  else if (law == SDR_SAINT_VENANT_KIRCHHOFF)
    kirchhoff(dimension, n, f, stress);
  else
    neo_hookean(dimension, n, f, stress);
}

/* Columns xx | xx yy xy | xx yy zz yz xz xy of the tensor at all points. */
static void expect_field(const nonordinary *b, double *const u[3], sdr_model_field which, int n,
                         const double *tensor, double size)
{
  static const int rows[3][6] = {{0}, {0, 3, 1}, {0, 4, 8, 5, 2, 1}};
  const int count = which == SDR_FIELD_DILATATION ? 1 : n * (n + 1) / 2;
  const size_t points = (size_t)b->shape.points->count;
  sdr_model *model = b->shape.model;
  double *out = sdr_alloc(points * 6, sizeof *out);
  assert_int_equal(model->ops->field(model, u, which, out), SDR_OK);
  for (int k = 0; k < count; ++k)
    for (size_t i = 0; i < points; ++i)
      if (!(fabs(out[(size_t)k * points + i] - tensor[rows[n - 1][k]]) <= 1e-9 * size))
        fail_msg("%d components, field %d, column %d, point %zu: %.12g, not %.12g", n, (int)which,
                 k, i, out[(size_t)k * points + i], tensor[rows[n - 1][k]]);
  sdr_free(out);
}

static void check_fields(const body_how *shape, sdr_elasticity law)
{
  const nonordinary_how how = {.shape = *shape, .elasticity = law};
  nonordinary b = nonordinary_create(&how);
  const int n = b.shape.points->components;
  double g[9] = {0.0}, own[9] = {0.0}, strain[9], stress[9], trace = 0.0, *u[3];
  for (int r = 0; r < n; ++r)
    for (int c = 0; c < n; ++c) g[3 * r + c] = own[n * r + c] = gradient[3 * r + c];
  for (int r = 0; r < n; ++r) trace += own[n * r + r];
  for (int k = 0; k < n * n; ++k) strain[k] = 0.5 * (own[k] + own[n * (k % n) + k / n]);
  vector_create(b.shape.points, u);
  vector_linear(b.shape.points, g, u);
  stress_of(shape->dimension, n, law, own, stress);
  expect_field(&b, u, SDR_FIELD_STRAIN, n, strain, 1.0);
  expect_field(&b, u, SDR_FIELD_DILATATION, n, &trace, 1.0);
  expect_field(&b, u, SDR_FIELD_STRESS, n, stress, body_young);
  vector_destroy(u);
  nonordinary_destroy(&b);
}

static const body_how shapes[] = {
    {.dimension = SDR_1D, .cells = {12}},
    {.dimension = SDR_PLANE_STRESS, .cells = {8, 7}},
    {.dimension = SDR_PLANE_STRAIN, .cells = {8, 7}, .angle = 0.3},
    {.dimension = SDR_3D, .cells = {5, 4, 4}, .ratio = 2.1, .jitter = 0.2},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static void stress_and_strain_of_small_gradients_are_hookes(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) check_fields(&shapes[k], SDR_LINEAR);
}

static void stress_of_finite_strain_is_cauchys(void **state)
{
  (void)state;
  for (int k = 1; k < SHAPES; ++k) {
    check_fields(&shapes[k], SDR_SAINT_VENANT_KIRCHHOFF);
    check_fields(&shapes[k], SDR_NEO_HOOKEAN);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(stress_and_strain_of_small_gradients_are_hookes),
      cmocka_unit_test(stress_of_finite_strain_is_cauchys),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
