/* Ordinary bodies keep what physics asks of them: momenta, rigid motions, the exact energy of
   uniform strains, the patch test, and nothing but rigid motions without energy (theory sec. 5). */
#include "base/small.h"
#include "support/ordinary.h"

#include <gsl/gsl_eigen.h>

static const ordinary_how varied[] = {
    {.body =
         {.dimension = SDR_PLANE_STRESS, .cells = {16, 14}, .jitter = 0.3, .horizon_spread = 0.4}},
    {.body = {.dimension = SDR_PLANE_STRAIN, .cells = {36, 7}, .angle = 0.4}, .poisson = 0.45},
    {.body =
         {.dimension = SDR_PLANE_STRESS, .cells = {12, 11}, .jitter = 0.3, .horizon_spread = 0.3},
     .form = SDR_FORM_MADENCI_OTERKUS},
    {.body = {.dimension = SDR_3D,
              .cells = {7, 6, 6},
              .ratio = 2.2,
              .jitter = 0.3,
              .horizon_spread = 0.3}},
    {.body = {.dimension = SDR_3D, .cells = {8, 6, 5}, .ratio = 2.01, .force_loose = 1}},
};
enum { VARIED = sizeof varied / sizeof *varied };

static body damaged_body(int k, sdr_law law, int scatter)
{
  ordinary_how how = varied[k];
  how.body.law = law;
  how.body.scatter = 0.4 * scatter;
  how.body.two_materials = scatter;
  how.body.stretch = 0.02;
  return ordinary_create(&how);
}

/* |sum f| over sum |f|, and |sum x f| over sum |x| |f| at present positions. */
static void residuals(const sdr_points *points, double *const u[3], double *const f[3],
                      double *linear, double *angular)
{
  double force[3] = {0.0}, moment[3] = {0.0}, force_scale = 0.0, moment_scale = 0.0;
  for (int32_t i = 0; i < points->count; ++i) {
    double x[3] = {0.0}, at[3] = {0.0}, turn[3];
    for (int a = 0; a < points->components; ++a) {
      x[a] = points->x[a][i] + u[a][i];
      at[a] = f[a][i];
    }
    sdr_cross3(x, at, turn);
    for (int a = 0; a < 3; ++a) {
      force[a] += at[a];
      moment[a] += turn[a];
    }
    force_scale += sdr_norm3(at);
    moment_scale += sdr_norm3(x) * sdr_norm3(at);
  }
  *linear = sdr_norm3(force) / force_scale;
  *angular = sdr_norm3(moment) / moment_scale;
}

/* A quarter turn and more, on top of noise. */
static void turned(const body *b, double amplitude, uint64_t seed, double *const u[3])
{
  double *extra[3];
  const double c = cos(1.9), s = sin(1.9);
  const double turn[9] = {c - 1.0, -s, 0.0, s, c - 1.0, 0.0, 0.0, 0.0, 0.0};
  vector_create(b->points, extra);
  vector_noise(b->points, amplitude * body_spacing, seed, extra);
  vector_linear(b->points, turn, u);
  vector_add(b->points, u, 1.0, extra, u);
  vector_destroy(extra);
}

static void forces_and_moments_balance_for_any_horizons_turned_and_damaged(void **state)
{
  (void)state;
  for (int k = 0; k < VARIED; ++k)
    for (int law = SDR_LAW_NONE; law <= SDR_LAW_CRITICAL_STRETCH; ++law)
      for (int variant = 0; variant < 4; ++variant) {
        body b = damaged_body(k, (sdr_law)law, variant & 1);
        double *u[3], *f[3], linear, angular;
        int64_t cut;
        vector_create(b.points, u);
        vector_create(b.points, f);
        if (variant & 2)
          assert_int_equal(b.model->ops->mark(b.model, body_cut_and_protect, NULL, &cut), SDR_OK);
        turned(&b, 0.05, 8, u);
        b.model->ops->commit(b.model, u);
        turned(&b, 0.05, 9, u);
        b.model->ops->force(b.model, u, f);
        residuals(b.points, u, f, &linear, &angular);
        assert_at_most(linear, 1e-12);
        assert_at_most(angular, 1e-12);
        vector_destroy(u);
        vector_destroy(f);
        body_destroy(&b);
      }
}

static void a_rigid_motion_makes_no_force(void **state)
{
  (void)state;
  for (int k = 0; k < VARIED; ++k) {
    body b = damaged_body(k, SDR_LAW_VARIATIONAL, 1);
    double *u[3], *f[3], *scale[3];
    vector_create(b.points, u);
    vector_create(b.points, f);
    vector_create(b.points, scale);
    vector_noise(b.points, 0.01 * body_spacing, 4, u);
    b.model->ops->force(b.model, u, scale);
    turned(&b, 0.0, 1, u);
    b.model->ops->force(b.model, u, f);
    assert_at_most(vector_largest(b.points, f), 1e-11 * vector_largest(b.points, scale));
    vector_destroy(u);
    vector_destroy(f);
    vector_destroy(scale);
    body_destroy(&b);
  }
}

/* ---- uniform strains ------------------------------------------------------------------------- */

static const ordinary_how uniform[] = {
    {.body = {.dimension = SDR_1D, .cells = {15}}},
    {.body = {.dimension = SDR_PLANE_STRESS, .cells = {15, 13}}, .poisson = 0.2},
    {.body = {.dimension = SDR_PLANE_STRAIN, .cells = {13, 13}, .angle = 0.4}, .poisson = 0.45},
    {.body = {.dimension = SDR_3D, .cells = {9, 9, 11}, .ratio = 2.3, .angle = 0.3}},
};
enum { UNIFORM = sizeof uniform / sizeof *uniform };

/* A field's value at the middle point under a displacement gradient. */
static double middle_value(const body *b, const double gradient[9], sdr_model_field which,
                           int component)
{
  const double origin[3] = {0.0, 0.0, 0.0};
  const int32_t middle = sdr_points_nearest(b->points, origin);
  const size_t count = (size_t)b->points->count;
  double *u[3], *out = sdr_alloc(6 * count, sizeof *out);
  vector_create(b->points, u);
  vector_linear(b->points, gradient, u);
  assert_int_equal(b->model->ops->field(b->model, u, which, out), SDR_OK);
  const double value = out[(size_t)component * count + (size_t)middle];
  vector_destroy(u);
  sdr_free(out);
  return value;
}

/* Second derivative of the energy density along a gradient: the odd part, geometry's, cancels. */
static double curvature(const body *b, const double direction[9], double size)
{
  double plus[9], minus[9];
  for (int c = 0; c < 9; ++c) {
    plus[c] = size * direction[c];
    minus[c] = -plus[c];
  }
  return (middle_value(b, plus, SDR_FIELD_ENERGY_DENSITY, 0) +
          middle_value(b, minus, SDR_FIELD_ENERGY_DENSITY, 0)) /
         (size * size);
}

static double bulk_of(const ordinary_how *how)
{
  return sdr_state_bulk(how->body.dimension, body_young, ordinary_poisson(how));
}
static double shear_of(const ordinary_how *how)
{
  return sdr_state_shear(how->body.dimension, body_young, ordinary_poisson(how));
}

static void uniform_dilation_stores_the_exact_energy(void **state)
{
  (void)state;
  for (int k = 0; k < UNIFORM; ++k)
    for (int variant = 0; variant < 6; ++variant) {
      ordinary_how how = uniform[k];
      how.body.weight.correction = variant / 2 == 1 ? SDR_CORRECTION_ISO : SDR_CORRECTION_NONE;
      how.body.weight.partial_volume = variant / 2 == 2;
      how.body.force_loose = variant & 1;
      body b = ordinary_create(&how);
      const int n = b.points->components;
      const double dilation[9] = {0.01, 0, 0, 0, 0.01, 0, 0, 0, 0.01};
      const double exact = 0.5 * bulk_of(&how) * (0.01 * n) * (0.01 * n);
      assert_near(middle_value(&b, dilation, SDR_FIELD_ENERGY_DENSITY, 0), exact, 1e-10 * exact);
      assert_near(middle_value(&b, dilation, SDR_FIELD_DILATATION, 0), 0.01 * n, 1e-12);
      body_destroy(&b);
    }
}

static void isotropic_weights_store_the_exact_energy_of_any_strain(void **state)
{
  (void)state;
  static const double uniaxial[9] = {1}, shear[9] = {0, 1}, two_axes[9] = {1, 0, 0, 0, -1};
  for (int k = 1; k < UNIFORM; ++k) {
    ordinary_how how = uniform[k];
    how.body.weight.correction = SDR_CORRECTION_ISO;
    body b = ordinary_create(&how);
    const double n = b.points->components, g = shear_of(&how);
    const double c11 = bulk_of(&how) + 2.0 * g * (n - 1.0) / n;
    assert_near(curvature(&b, uniaxial, 1e-6), c11, 1e-10 * c11);
    assert_near(curvature(&b, shear, 1e-6), g, 1e-10 * c11);
    assert_near(curvature(&b, two_axes, 1e-6), 4.0 * g, 1e-10 * c11);
    body_destroy(&b);
  }
}

static void stress_and_strain_are_those_of_the_strain_that_is_applied(void **state)
{
  (void)state;
  const double gradient[9] = {2e-6, 1e-6, 0, 0, -1e-6, 0, 0, 0, 3e-6};
  for (int k = 1; k < UNIFORM; ++k) {
    ordinary_how how = uniform[k];
    how.body.weight.correction = SDR_CORRECTION_ISO;
    body b = ordinary_create(&how);
    const int n = b.points->components, xy = n == 2 ? 2 : 5;
    const double g = shear_of(&how), bulk = bulk_of(&how), trace = n == 2 ? 1e-6 : 4e-6;
    const double scale = 1e-6 * bulk, pressure = bulk * trace;
    assert_near(middle_value(&b, gradient, SDR_FIELD_STRAIN, 0), 2e-6, 1e-15);
    assert_near(middle_value(&b, gradient, SDR_FIELD_STRAIN, 1), -1e-6, 1e-15);
    assert_near(middle_value(&b, gradient, SDR_FIELD_STRAIN, xy), 0.5e-6, 1e-15);
    /* to first order in the strain */
    assert_near(middle_value(&b, gradient, SDR_FIELD_STRESS, 0),
                pressure + 2.0 * g * (2e-6 - trace / n), 2e-5 * scale);
    assert_near(middle_value(&b, gradient, SDR_FIELD_STRESS, 1),
                pressure + 2.0 * g * (-1e-6 - trace / n), 2e-5 * scale);
    assert_near(middle_value(&b, gradient, SDR_FIELD_STRESS, xy), g * 1e-6, 2e-5 * scale);
    body_destroy(&b);
  }
}

/* 004's constants are those of the continuum: this is what its lattice makes of them. */
static void the_printed_form_stores_the_energy_of_its_sums(void **state)
{
  (void)state;
  const ordinary_how how = {.body = {.dimension = SDR_PLANE_STRESS, .cells = {13, 13}},
                            .poisson = 0.2,
                            .form = SDR_FORM_MADENCI_OTERKUS};
  body b = ordinary_create(&how);
  double count = 0.0, lengths = 0.0; /* sum over the family of 1 and of |xi|/spacing */
  for (int y = -3; y <= 3; ++y)
    for (int x = -3; x <= 3; ++x) {
      const double length = sqrt((double)(x * x + y * y));
      if (length <= 0.0 || length > 3.015) continue;
      count += 1.0;
      lengths += length;
    }
  const double pi = 3.14159265358979323846, m = 3.015, strain = 0.01;
  const double theta = 2.0 / (pi * m * m) * count * strain;
  const double b_sum = 6.0 * shear_of(&how) / (pi * m * m * m) * lengths * strain * strain;
  const double exact = 0.5 * (bulk_of(&how) - 2.0 * shear_of(&how)) * theta * theta + b_sum;
  const double dilation[9] = {strain, 0, 0, 0, strain, 0, 0, 0, strain};
  assert_near(middle_value(&b, dilation, SDR_FIELD_DILATATION, 0), theta, 1e-12);
  assert_near(middle_value(&b, dilation, SDR_FIELD_ENERGY_DENSITY, 0), exact, 1e-10 * exact);
  body_destroy(&b);
}

/* ---- patch test ------------------------------------------------------------------------------ */

/* 1 if the point lies more than 2 horizons inside the box. */
static int deep(const body *b, int32_t i)
{
  const double c = cos(b->how.angle), s = sin(b->how.angle);
  const double x[3] = {b->points->x[0][i], b->points->components > 1 ? b->points->x[1][i] : 0.0,
                       b->points->components > 2 ? b->points->x[2][i] : 0.0};
  const double along[3] = {c * x[0] + s * x[1], c * x[1] - s * x[0], x[2]};
  for (int a = 0; a < b->points->components; ++a) {
    const double half = 0.5 * (b->how.cells[a] - 1) * body_spacing;
    if (half - fabs(along[a]) <= 2.0 * b->points->horizon[i]) return 0;
  }
  return 1;
}

static void linear_displacements_make_no_force_deep_inside(void **state)
{
  (void)state;
  static const ordinary_how bodies[] = {
      {.body = {.dimension = SDR_1D, .cells = {31}}},
      {.body = {.dimension = SDR_PLANE_STRESS, .cells = {17, 18}}, .poisson = 0.2},
      {.body = {.dimension = SDR_PLANE_STRAIN, .cells = {17, 17}, .angle = 0.4}, .poisson = 0.45},
      {.body = {.dimension = SDR_PLANE_STRESS, .cells = {17, 17}},
       .form = SDR_FORM_MADENCI_OTERKUS},
      {.body = {.dimension = SDR_3D, .cells = {11, 11, 11}, .ratio = 2.01}},
  };
  const double gradient[9] = {0.01, 0.004, -0.003, 0.002, -0.006, 0.001, 0.003, 0.0, 0.008};
  static const sdr_families_how weights[] = {
      {.influence = SDR_INFLUENCE_CONSTANT},
      {.partial_volume = 1},
      {.correction = SDR_CORRECTION_ISO},
      {.influence = SDR_INFLUENCE_CUBIC, .correction = SDR_CORRECTION_ISO}};
  for (int k = 0; k < 5; ++k)
    for (int w = 0; w < 4; ++w) {
      ordinary_how how = bodies[k];
      how.body.weight = weights[w];
      body b = ordinary_create(&how);
      double *u[3], *f[3], inside = 0.0;
      int met = 0;
      vector_create(b.points, u);
      vector_create(b.points, f);
      vector_linear(b.points, gradient, u);
      b.model->ops->force(b.model, u, f);
      for (int32_t i = 0; i < b.points->count; ++i) {
        if (!deep(&b, i)) continue;
        ++met;
        for (int a = 0; a < b.points->components; ++a) inside = fmax(inside, fabs(f[a][i]));
      }
      assert_true(met > 0);
      assert_at_most(inside, 1e-10 * vector_largest(b.points, f));
      vector_destroy(u);
      vector_destroy(f);
      body_destroy(&b);
    }
}

/* ---- modes without energy -------------------------------------------------------------------- */

static int zero_modes(const body *b)
{
  const size_t n = (size_t)b->points->components, size = n * (size_t)b->points->count;
  gsl_matrix *matrix = gsl_matrix_alloc(size, size);
  gsl_vector *values = gsl_vector_alloc(size);
  gsl_eigen_symm_workspace *work = gsl_eigen_symm_alloc(size);
  double *v[3], *out[3];
  vector_create(b->points, v);
  vector_create(b->points, out);
  for (size_t c = 0; c < size; ++c) {
    v[c % n][c / n] = 1.0;
    b->model->ops->reference_times(b->model, v, out);
    v[c % n][c / n] = 0.0;
    for (size_t r = 0; r < size; ++r) gsl_matrix_set(matrix, r, c, out[r % n][r / n]);
  }
  double asymmetry = 0.0, largest = 0.0;
  for (size_t r = 0; r < size; ++r)
    for (size_t c = 0; c < r; ++c) {
      asymmetry =
          fmax(asymmetry, fabs(gsl_matrix_get(matrix, r, c) - gsl_matrix_get(matrix, c, r)));
      largest = fmax(largest, fabs(gsl_matrix_get(matrix, r, c)));
    }
  assert_at_most(asymmetry, 1e-13 * largest);
  gsl_eigen_symm(matrix, values, work);
  const double top = gsl_vector_max(values);
  int zero = 0;
  for (size_t r = 0; r < size; ++r) {
    const double value = gsl_vector_get(values, r);
    assert_true(value > -1e-11 * top);
    assert_true(value < 1e-11 * top || value > 1e-6 * top); /* nothing in between */
    zero += value < 1e-11 * top;
  }
  gsl_matrix_free(matrix);
  gsl_vector_free(values);
  gsl_eigen_symm_free(work);
  vector_destroy(v);
  vector_destroy(out);
  return zero;
}

static void only_rigid_motions_store_nothing(void **state)
{
  (void)state;
  static const ordinary_how bodies[] = {
      {.body = {.dimension = SDR_1D, .cells = {20}}},
      {.body = {.dimension = SDR_PLANE_STRESS, .cells = {7, 8}}, .poisson = 0.2},
      {.body = {.dimension = SDR_PLANE_STRAIN, .cells = {7, 8}, .angle = 0.4}, .poisson = 0.45},
      {.body =
           {.dimension = SDR_PLANE_STRESS, .cells = {8, 7}, .jitter = 0.3, .horizon_spread = 0.3}},
      {.body = {.dimension = SDR_PLANE_STRESS, .cells = {8, 7}}, .form = SDR_FORM_MADENCI_OTERKUS},
      {.body = {.dimension = SDR_3D, .cells = {4, 4, 5}, .ratio = 2.01}},
  };
  static const int expected[] = {1, 3, 3, 3, 3, 6};
  for (int k = 0; k < 6; ++k) {
    body b = ordinary_create(&bodies[k]);
    assert_int_equal(zero_modes(&b), expected[k]);
    body_destroy(&b);
  }
}

/* ---- traditional peridynamics ---------------------------------------------------------------- */

/* The traditional form (000 table 1, left): with one horizon a point sums
   (t_i<xi> - t_j<-xi>) V_j over its own family, t the scalar of 000 eq. 42, influence function 1.
 */
typedef struct {
  const body *b;
  double *const *u;
  double bulk, shear;
} traditional;

/* |xi|; y: xi + eta and its length. */
static double distance(const traditional *t, int32_t i, int32_t j, double y[4])
{
  double xi = 0.0, l = 0.0;
  for (int a = 0; a < t->b->points->components; ++a) {
    const double x = t->b->points->x[a][j] - t->b->points->x[a][i];
    y[a] = x + t->u[a][j] - t->u[a][i];
    xi += x * x;
    l += y[a] * y[a];
  }
  y[3] = sqrt(l);
  return sqrt(xi);
}

static int near(const traditional *t, int32_t i, int32_t j, double y[4], double *xi)
{
  *xi = distance(t, i, j, y);
  return i != j && *xi < 1.0001 * t->b->points->horizon[0];
}

static void family_sums(const traditional *t, int32_t i, double *m, double *theta)
{
  double y[4], xi, sum = 0.0;
  *m = 0.0;
  for (int32_t j = 0; j < t->b->points->count; ++j) {
    if (!near(t, i, j, y, &xi)) continue;
    *m += xi * xi * t->b->points->volume[j];
    sum += xi * (y[3] - xi) * t->b->points->volume[j];
  }
  *theta = t->b->points->components / *m * sum;
}

static double force_state(const traditional *t, double m, double theta, double xi, double l)
{
  const double n = t->b->points->components;
  return n * t->bulk * theta / m * xi + n * (n + 2.0) * t->shear / m * (l - xi - theta * xi / n);
}

static void one_horizon_gives_traditional_peridynamics(void **state)
{
  (void)state;
  static const ordinary_how bodies[] = {
      {.body = {.dimension = SDR_PLANE_STRESS, .cells = {15, 16}}, .poisson = 0.2},
      {.body = {.dimension = SDR_PLANE_STRAIN, .cells = {14, 15}, .jitter = 0.3}, .poisson = 0.4},
      {.body = {.dimension = SDR_3D, .cells = {6, 6, 7}, .ratio = 2.01}},
  };
  for (int k = 0; k < 3; ++k) {
    body b = ordinary_create(&bodies[k]);
    const size_t count = (size_t)b.points->count;
    double *u[3], *f[3], *expected[3], *m = sdr_alloc(count, sizeof *m);
    double *theta = sdr_alloc(count, sizeof *theta);
    vector_create(b.points, u);
    vector_create(b.points, f);
    vector_create(b.points, expected);
    vector_noise(b.points, 0.1 * body_spacing, 5, u);
    const traditional t = {&b, u, bulk_of(&bodies[k]), shear_of(&bodies[k])};
    for (int32_t i = 0; i < b.points->count; ++i) family_sums(&t, i, &m[i], &theta[i]);
    for (int32_t i = 0; i < b.points->count; ++i)
      for (int32_t j = 0; j < b.points->count; ++j) {
        double y[4], xi;
        if (!near(&t, i, j, y, &xi)) continue;
        const double both =
            force_state(&t, m[i], theta[i], xi, y[3]) + force_state(&t, m[j], theta[j], xi, y[3]);
        for (int a = 0; a < b.points->components; ++a)
          expected[a][i] += both * y[a] / y[3] * b.points->volume[i] * b.points->volume[j];
      }
    b.model->ops->force(b.model, u, f);
    assert_at_most(vector_difference(b.points, f, expected),
                   1e-13 * vector_largest(b.points, expected));
    sdr_free(m);
    sdr_free(theta);
    vector_destroy(u);
    vector_destroy(f);
    vector_destroy(expected);
    body_destroy(&b);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(forces_and_moments_balance_for_any_horizons_turned_and_damaged),
      cmocka_unit_test(a_rigid_motion_makes_no_force),
      cmocka_unit_test(uniform_dilation_stores_the_exact_energy),
      cmocka_unit_test(isotropic_weights_store_the_exact_energy_of_any_strain),
      cmocka_unit_test(stress_and_strain_are_those_of_the_strain_that_is_applied),
      cmocka_unit_test(the_printed_form_stores_the_energy_of_its_sums),
      cmocka_unit_test(linear_displacements_make_no_force_deep_inside),
      cmocka_unit_test(only_rigid_motions_store_nothing),
      cmocka_unit_test(one_horizon_gives_traditional_peridynamics),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
