/* Non-ordinary bodies: momenta, rigid motion, exact gradients, patches, zero modes, dispersion,
   and traditional peridynamics as the special case. */
#include "base/small.h"
#include "mechanics/nonordinary_internal.h"
#include "support/nonordinary.h"

#include <gsl/gsl_eigen.h>

static const sdr_elasticity laws[] = {SDR_LINEAR, SDR_SAINT_VENANT_KIRCHHOFF, SDR_NEO_HOOKEAN};
static const sdr_families_how iso = {.correction = SDR_CORRECTION_ISO, .state_based = 1};

/* u = R (x + g x) - x, about the origin; g of three components. */
static void turned(const sdr_points *points, double angle, const double g[9], double *const u[3])
{
  const double c = cos(angle), s = sin(angle);
  vector_linear(points, g, u);
  for (int32_t i = 0; points->components > 1 && i < points->count; ++i) {
    const double x = points->x[0][i] + u[0][i], y = points->x[1][i] + u[1][i];
    u[0][i] = c * x - s * y - points->x[0][i];
    u[1][i] = s * x + c * y - points->x[1][i];
  }
}

/* ---- momenta --------------------------------------------------------------------------------- */

static int cut_side(const void *context, const double a[3], const double b[3])
{
  (void)context;
  return fmax(a[1], b[1]) < 0.0 && (a[0] > 1e-5) != (b[0] > 1e-5) ? SDR_CUT : 0;
}

/* |sum f| and |sum y x f| over the sums of sizes; y = x + share u. */
static void momenta(const sdr_points *points, double *const u[3], double *const f[3], double share,
                    double *linear, double *angular)
{
  double sum[3] = {0.0}, size = 0.0, turn[3] = {0.0}, turn_size = 0.0;
  for (int32_t i = 0; i < points->count; ++i) {
    double y[3] = {0.0}, force[3] = {0.0}, moment[3];
    for (int a = 0; a < points->components; ++a) {
      y[a] = points->x[a][i] + share * u[a][i];
      force[a] = f[a][i];
      sum[a] += force[a];
    }
    sdr_cross3(y, force, moment);
    for (int a = 0; a < 3; ++a) turn[a] += moment[a];
    size += sdr_norm3(force);
    turn_size += sdr_norm3(y) * sdr_norm3(force);
  }
  *linear = sdr_norm3(sum) / size;
  *angular = sdr_norm3(turn) / turn_size;
}

/* A turned, strained, damaged, partly cut body with horizons that vary. */
static void momenta_of(const nonordinary_how *how, double strain, double angle, double share,
                       double *linear, double *angular)
{
  const double g[9] = {strain,       0.3 * strain, 0.2 * strain,  -0.1 * strain, -0.5 * strain,
                       0.1 * strain, 0.4 * strain, -0.3 * strain, 0.6 * strain};
  nonordinary b = nonordinary_create(how);
  const sdr_points *points = b.shape.points;
  double *u[3], *f[3], *extra[3];
  int64_t cut;
  vector_create(points, u);
  vector_create(points, f);
  vector_create(points, extra);
  assert_int_equal(b.shape.model->ops->mark(b.shape.model, cut_side, NULL, &cut), SDR_OK);
  assert_true(cut > 0);
  turned(points, angle, g, u);
  vector_noise(points, 0.1 * strain * body_spacing, 3, extra);
  vector_add(points, u, 1.0, extra, u);
  b.shape.model->ops->force_commit(b.shape.model, u, NULL, 0.0, f);
  sdr_energies e;
  b.shape.model->ops->energies(b.shape.model, u, &e);
  assert_true(how->shape.law == SDR_LAW_NONE || e.max_damage > 0.2);
  momenta(points, u, f, share, linear, angular);
  vector_destroy(u);
  vector_destroy(f);
  vector_destroy(extra);
  nonordinary_destroy(&b);
}

static const nonordinary_how varied[] = {{.shape = {.dimension = SDR_PLANE_STRESS,
                                                    .cells = {14, 13},
                                                    .jitter = 0.3,
                                                    .horizon_spread = 0.3,
                                                    .law = SDR_LAW_VARIATIONAL,
                                                    .scatter = 0.1},
                                          .split = SDR_SPLIT_SPECTRAL,
                                          .strain = 0.03},
                                         {.shape = {.dimension = SDR_3D,
                                                    .cells = {7, 6, 6},
                                                    .ratio = 2.2,
                                                    .jitter = 0.2,
                                                    .horizon_spread = 0.2,
                                                    .law = SDR_LAW_VARIATIONAL},
                                          .split = SDR_SPLIT_DILATATION,
                                          .strain = 0.03}};

static void finite_strain_balances_both_momenta_to_1e_12(void **state)
{
  (void)state;
  for (int k = 0; k < 2; ++k)
    for (int law = 1; law < 3; ++law) {
      nonordinary_how how = varied[k];
      double linear, angular;
      how.elasticity = laws[law];
      momenta_of(&how, 0.05, 0.8, 1.0, &linear, &angular);
      assert_at_most(linear, 1e-12);
      assert_at_most(angular, 1e-12);
    }
}

/* Small strains know the shape before only: the torque about present places is that of the stress
   over the strain, and goes with the strain; about places before it vanishes. */
static void linear_strain_balances_torque_to_the_strain_only(void **state)
{
  (void)state;
  double linear, angular[3], before;
  nonordinary_how how = varied[0];
  how.strain = 0.008;
  for (int k = 0; k < 3; ++k) {
    momenta_of(&how, 0.04 / (1 << k), 0.0, 1.0, &linear, &angular[k]);
    assert_at_most(linear, 1e-12);
    momenta_of(&how, 0.04 / (1 << k), 0.0, 0.0, &linear, &before);
    assert_at_most(before, 1e-12);
  }
  print_message("linear: torque %.2e %.2e %.2e at strains 0.04 0.02 0.01\n", angular[0], angular[1],
                angular[2]);
  assert_true(angular[0] > 1e-6 && angular[2] < 0.5 * angular[0]);
}

static void large_rotations_give_no_force_with_finite_strain(void **state)
{
  (void)state;
  const double none[9] = {0.0};
  for (int k = 0; k < 2; ++k)
    for (int law = 1; law < 3; ++law) {
      nonordinary_how how = varied[k];
      how.elasticity = laws[law];
      nonordinary b = nonordinary_create(&how);
      double *u[3], *f[3];
      vector_create(b.shape.points, u);
      vector_create(b.shape.points, f);
      turned(b.shape.points, 2.3, none, u);
      b.shape.model->ops->force(b.shape.model, u, f);
      /* over the force of a strain of 1 */
      const double unit = body_young * b.shape.points->volume[0] / body_spacing;
      assert_at_most(vector_largest(b.shape.points, f) / unit, 1e-13);
      vector_destroy(u);
      vector_destroy(f);
      nonordinary_destroy(&b);
    }
}

/* ---- exactness ------------------------------------------------------------------------------- */

static void gradients_of_affine_motions_are_exact_to_1e_11_on_any_points(void **state)
{
  (void)state;
  const double g[9] = {0.3, -0.2, 0.1, 0.4, -0.1, 0.2, -0.3, 0.1, 0.2};
  for (int k = 0; k < 2; ++k) {
    nonordinary_how how = varied[k];
    how.shape.law = SDR_LAW_NONE;
    how.elasticity = SDR_SAINT_VENANT_KIRCHHOFF;
    nonordinary b = nonordinary_create(&how);
    const sdr_points *points = b.shape.points;
    const int n = points->components;
    double *u[3];
    sdr_energies energies; /* leave the gradients behind */
    vector_create(points, u);
    vector_linear(points, g, u);
    b.shape.model->ops->energies(b.shape.model, u, &energies);
    const sdr_nonordinary_model *model = (const sdr_nonordinary_model *)b.shape.model;
    for (int32_t i = 0; i < points->count; ++i)
      for (int a = 0; a < n; ++a)
        for (int c = 0; c < n; ++c)
          assert_near(model->body.gradient[n * a + c][i], g[3 * a + c], 1e-11);
    vector_destroy(u);
    nonordinary_destroy(&b);
  }
}

/* Largest force of a uniform strain more than 2 horizons from surfaces, over E strain V/spacing. */
static double patch_residual(const nonordinary_how *how)
{
  const double g[9] = {1e-3, 4e-4, 2e-4, -3e-4, 6e-4, 1e-4, 3e-4, -2e-4, -5e-4};
  nonordinary b = nonordinary_create(how);
  const sdr_points *points = b.shape.points;
  double *u[3], *f[3], most = 0.0, edge[3] = {0.0};
  int inside = 0;
  vector_create(points, u);
  vector_create(points, f);
  vector_linear(points, g, u);
  b.shape.model->ops->force(b.shape.model, u, f);
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) edge[a] = fmax(edge[a], points->x[a][i]);
  for (int32_t i = 0; i < points->count; ++i) {
    int deep = 1;
    for (int a = 0; a < points->components; ++a)
      deep &= fabs(points->x[a][i]) < edge[a] - 2.0 * points->horizon[i];
    inside += deep;
    for (int a = 0; deep && a < points->components; ++a) most = fmax(most, fabs(f[a][i]));
  }
  assert_true(inside > 0);
  const double unit = body_young * 1e-3 * points->volume[0] / body_spacing;
  vector_destroy(u);
  vector_destroy(f);
  nonordinary_destroy(&b);
  return most / unit;
}

static void uniform_strain_is_in_balance_to_1e_10_away_from_surfaces(void **state)
{
  (void)state;
  static const sdr_families_how weights[] = {
      {.partial_volume = 0},
      {.partial_volume = 1},
      {.correction = SDR_CORRECTION_ISO, .state_based = 1},
      {.influence = SDR_INFLUENCE_CUBIC, .correction = SDR_CORRECTION_ISO, .state_based = 1}};
  for (int law = 0; law < 3; ++law)
    for (int w = 0; w < 4; ++w) {
      nonordinary_how how = {.shape = {.dimension = SDR_PLANE_STRAIN, .cells = {19, 18}},
                             .elasticity = laws[law]};
      how.shape.weight = weights[w];
      how.poisson = 0.45;
      assert_at_most(patch_residual(&how), 1e-10);
    }
  const nonordinary_how solid = {.shape = {.dimension = SDR_3D, .cells = {9, 9, 9}, .ratio = 1.8}};
  assert_at_most(patch_residual(&solid), 1e-10);
}

/* ---- zero modes ------------------------------------------------------------------------------ */

typedef struct {
  int n, size;
  double *matrix;
} dense;

static void add_block(void *context, int count, const int32_t *point, const double *block)
{
  const dense *to = context;
  const int n = to->n, wide = n * count;
  for (int r = 0; r < wide; ++r)
    for (int c = 0; c < wide; ++c)
      to->matrix[(n * point[r / n] + r % n) * to->size + n * point[c / n] + c % n] +=
          block[r * wide + c];
}

/* Eigenvalues of the tangent at rest below 1e-9 of the largest; none may be below -1e-9 of it. */
static int zero_modes(const nonordinary_how *how)
{
  nonordinary b = nonordinary_create(how);
  const int n = b.shape.points->components, size = n * b.shape.points->count;
  dense full = {n, size, sdr_alloc((size_t)(size * size), sizeof(double))};
  double *u[3];
  vector_create(b.shape.points, u);
  assert_int_equal(b.shape.model->ops->visit_hessian(b.shape.model, u, add_block, &full), SDR_OK);
  gsl_matrix_view matrix = gsl_matrix_view_array(full.matrix, (size_t)size, (size_t)size);
  gsl_vector *value = gsl_vector_alloc((size_t)size);
  gsl_eigen_symm_workspace *work = gsl_eigen_symm_alloc((size_t)size);
  gsl_eigen_symm(&matrix.matrix, value, work);
  double largest = 0.0;
  int zeros = 0;
  for (int k = 0; k < size; ++k) largest = fmax(largest, gsl_vector_get(value, (size_t)k));
  for (int k = 0; k < size; ++k) {
    assert_true(gsl_vector_get(value, (size_t)k) > -1e-9 * largest);
    zeros += gsl_vector_get(value, (size_t)k) < 1e-9 * largest;
  }
  gsl_eigen_symm_free(work);
  gsl_vector_free(value);
  sdr_free(full.matrix);
  vector_destroy(u);
  nonordinary_destroy(&b);
  return zeros;
}

static void only_rigid_motions_cost_nothing_with_control(void **state)
{
  (void)state;
  for (int dimension = 0; dimension < 2; ++dimension)
    for (int law = 0; law < 2; ++law) {
      nonordinary_how how = {.elasticity = laws[law]};
      how.shape = dimension == 0
                      ? (body_how){.dimension = SDR_PLANE_STRESS, .cells = {8, 8}}
                      : (body_how){.dimension = SDR_3D, .cells = {4, 4, 4}, .ratio = 1.8};
      assert_int_equal(zero_modes(&how), dimension == 0 ? 3 : 6);
    }
}

/* Largest force that the displacement +-1, alternating from point to point, brings to points more
   than 2 horizons from surfaces, over the largest anywhere with control. */
static double alternating_force(int no_control, double *with)
{
  nonordinary_how how = {.shape = {.dimension = SDR_PLANE_STRESS, .cells = {19, 19}},
                         .no_control = no_control};
  nonordinary b = nonordinary_create(&how);
  const sdr_points *points = b.shape.points;
  double *v[3], *out[3], most = 0.0;
  vector_create(points, v);
  vector_create(points, out);
  for (int32_t i = 0; i < points->count; ++i) {
    const long x = lround(points->x[0][i] / body_spacing),
               y = lround(points->x[1][i] / body_spacing);
    v[0][i] = (x + y) % 2 == 0 ? 1.0 : -1.0;
  }
  b.shape.model->ops->reference_times(b.shape.model, v, out);
  if (!no_control) *with = vector_largest(points, out);
  for (int32_t i = 0; i < points->count; ++i)
    if (fmax(fabs(points->x[0][i]), fabs(points->x[1][i])) < 2.9 * body_spacing)
      most = fmax(most, fmax(fabs(out[0][i]), fabs(out[1][i])));
  vector_destroy(v);
  vector_destroy(out);
  nonordinary_destroy(&b);
  return most / *with;
}

/* The modes that F cannot see: of a body with surfaces none is left exactly, since families there
   are lopsided, but inside they cost nothing. */
static void an_alternating_motion_costs_nothing_without_control(void **state)
{
  (void)state;
  double with = 0.0;
  assert_true(alternating_force(0, &with) > 0.1);
  assert_at_most(alternating_force(1, &with), 1e-13);
}

/* ---- dispersion ------------------------------------------------------------------------------ */

/* Speed of a plane wave along the first axis over the continuum's, at wave number `kh`/spacing:
   the reference tangent on a cosine that is even about the point in the middle. */
static double relative_speed(const nonordinary_how *how, int polarisation, double kh)
{
  nonordinary b = nonordinary_create(how);
  const sdr_points *points = b.shape.points;
  const double origin[3] = {0.0};
  const int32_t middle = sdr_points_nearest(points, origin);
  const double k = kh / body_spacing, nu = b.poisson[0];
  double *v[3], *out[3];
  vector_create(points, v);
  vector_create(points, out);
  for (int32_t i = 0; i < points->count; ++i)
    v[polarisation][i] = cos(k * (points->x[0][i] - points->x[0][middle]));
  b.shape.model->ops->reference_times(b.shape.model, v, out);
  const double modulus =
      polarisation == 0 ? body_young / (1.0 - nu * nu) : body_young / (2.0 * (1.0 + nu));
  const double found = out[polarisation][middle] / (points->volume[middle] * k * k);
  vector_destroy(v);
  vector_destroy(out);
  nonordinary_destroy(&b);
  return sqrt(found / modulus);
}

/* Constant weights with isotropic fourth moments, horizon 3.015 spacings: ten points a wave. */
static void waves_of_ten_spacings_keep_their_speed(void **state)
{
  (void)state;
  nonordinary_how how = {
      .shape = {.dimension = SDR_PLANE_STRESS, .cells = {17, 17}, .weight = iso}};
  const double shear = relative_speed(&how, 1, 0.63), along = relative_speed(&how, 0, 0.63);
  nonordinary_how cubic = how, none = how;
  cubic.shape.weight.influence = SDR_INFLUENCE_CUBIC;
  none.no_control = 1;
  const double cubic_shear = relative_speed(&cubic, 1, 0.63);
  const double cubic_along = relative_speed(&cubic, 0, 0.63), free = relative_speed(&none, 1, 0.63);
  print_message("speed at kh = 0.63: shear %.4f, longitudinal %.4f; cubic weight %.4f, %.4f; "
                "without control %.4f\n",
                shear, along, cubic_shear, cubic_along, free);
  assert_near(shear, 0.996, 0.001);
  assert_near(along, 0.978, 0.001);
  assert_near(cubic_shear, 1.003, 0.001);
  assert_near(cubic_along, 0.992, 0.001);
  assert_near(free, 0.719, 0.001);
}

/* Long waves, whose error is of second order in kh: what the lattice leaves of it, as its moments
   of sixth order are not isotropic, is below a twentieth of that without control. */
static void control_cancels_dispersion_of_second_order(void **state)
{
  (void)state;
  const nonordinary_how how = {
      .shape = {.dimension = SDR_PLANE_STRESS, .cells = {17, 17}, .weight = iso}};
  nonordinary_how none = how;
  none.no_control = 1;
  for (int polarisation = 0; polarisation < 2; ++polarisation) {
    const double with = relative_speed(&how, polarisation, 0.2) - 1.0;
    const double without = relative_speed(&none, polarisation, 0.2) - 1.0;
    print_message("error of speed at kh = 0.2: %.2e with control, %.2e without\n", with, without);
    assert_true(fabs(with) < 0.05 * fabs(without));
  }
}

/* ---- traditional peridynamics ---------------------------------------------------------------- */

/* Constant horizon, no control, small strains: f_i = sum (T_i<xi> - T_j<-xi>) V_j V_i with
   T_i<xi> = sigma_i K_i^-1 xi, written by itself. */
static void traditional_force(const nonordinary *b, double *const u[3], double *const f[3])
{
  const sdr_points *points = b->shape.points;
  const double nu = b->poisson[0], c = body_young / (1.0 - nu * nu);
  double(*t)[4] = calloc((size_t)points->count, sizeof *t);
  for (int32_t i = 0; i < points->count; ++i) {
    double k[3] = {0.0}, m[4] = {0.0};
    for (int32_t j = 0; j < points->count; ++j) {
      const double x = points->x[0][j] - points->x[0][i], y = points->x[1][j] - points->x[1][i];
      if (i == j || hypot(x, y) > points->horizon[0] * (1.0 + 1e-9)) continue;
      const double w = points->volume[j], p = u[0][j] - u[0][i], q = u[1][j] - u[1][i];
      k[0] += w * x * x;
      k[1] += w * x * y;
      k[2] += w * y * y;
      m[0] += w * p * x;
      m[1] += w * p * y;
      m[2] += w * q * x;
      m[3] += w * q * y;
    }
    const double det = k[0] * k[2] - k[1] * k[1];
    const double xx = (m[0] * k[2] - m[1] * k[1]) / det, xy = (m[1] * k[0] - m[0] * k[1]) / det;
    const double yx = (m[2] * k[2] - m[3] * k[1]) / det, yy = (m[3] * k[0] - m[2] * k[1]) / det;
    const double sx = c * (xx + nu * yy), sy = c * (yy + nu * xx);
    const double s = c * 0.5 * (1.0 - nu) * (xy + yx);
    t[i][0] = (sx * k[2] - s * k[1]) / det;
    t[i][1] = (s * k[0] - sx * k[1]) / det;
    t[i][2] = (s * k[2] - sy * k[1]) / det;
    t[i][3] = (sy * k[0] - s * k[1]) / det;
  }
  for (int32_t i = 0; i < points->count; ++i) {
    f[0][i] = f[1][i] = 0.0;
    for (int32_t j = 0; j < points->count; ++j) {
      const double x = points->x[0][j] - points->x[0][i], y = points->x[1][j] - points->x[1][i];
      if (i == j || hypot(x, y) > points->horizon[0] * (1.0 + 1e-9)) continue;
      const double w = points->volume[i] * points->volume[j];
      f[0][i] += w * ((t[i][0] + t[j][0]) * x + (t[i][1] + t[j][1]) * y);
      f[1][i] += w * ((t[i][2] + t[j][2]) * x + (t[i][3] + t[j][3]) * y);
    }
  }
  free(t);
}

static void constant_horizons_give_traditional_peridynamics_to_round_off(void **state)
{
  (void)state;
  const nonordinary_how how = {.shape = {.dimension = SDR_PLANE_STRESS, .cells = {15, 14}},
                               .no_control = 1};
  nonordinary b = nonordinary_create(&how);
  double *u[3], *f[3], *g[3];
  vector_create(b.shape.points, u);
  vector_create(b.shape.points, f);
  vector_create(b.shape.points, g);
  vector_noise(b.shape.points, 0.01 * body_spacing, 17, u);
  b.shape.model->ops->force(b.shape.model, u, f);
  traditional_force(&b, u, g);
  assert_at_most(vector_difference(b.shape.points, f, g) / vector_largest(b.shape.points, g),
                 1e-13);
  vector_destroy(u);
  vector_destroy(f);
  vector_destroy(g);
  nonordinary_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(finite_strain_balances_both_momenta_to_1e_12),
      cmocka_unit_test(linear_strain_balances_torque_to_the_strain_only),
      cmocka_unit_test(large_rotations_give_no_force_with_finite_strain),
      cmocka_unit_test(gradients_of_affine_motions_are_exact_to_1e_11_on_any_points),
      cmocka_unit_test(uniform_strain_is_in_balance_to_1e_10_away_from_surfaces),
      cmocka_unit_test(only_rigid_motions_cost_nothing_with_control),
      cmocka_unit_test(an_alternating_motion_costs_nothing_without_control),
      cmocka_unit_test(control_cancels_dispersion_of_second_order),
      cmocka_unit_test(waves_of_ten_spacings_keep_their_speed),
      cmocka_unit_test(constant_horizons_give_traditional_peridynamics_to_round_off),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
