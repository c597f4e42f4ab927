/* Internal forces balance: no net force, no net moment about any point, for any horizons and any
   damage, because every directed bond acts on both its ends (theory sec. 1). */
#include "base/small.h"
#include "support/reference.h"

static const body_how shapes[] = {
    {.dimension = SDR_PLANE_STRESS, .cells = {16, 14}, .jitter = 0.3, .horizon_spread = 0.4},
    {.dimension = SDR_PLANE_STRAIN, .cells = {36, 7}, .angle = 0.4},
    {.dimension = SDR_3D, .cells = {7, 6, 6}, .ratio = 2.2, .jitter = 0.3, .horizon_spread = 0.3},
    {.dimension = SDR_3D, .cells = {8, 6, 5}, .ratio = 2.01, .force_loose = 1},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

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

static body damaged_body(int k, sdr_law law, int scatter)
{
  body_how how = shapes[k];
  how.law = law;
  how.scatter = 0.4 * scatter;
  how.two_materials = scatter;
  how.stretch = 0.02;
  return body_create(&how);
}

static void forces_and_moments_balance_for_any_horizons_and_damage(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int law = SDR_LAW_NONE; law < SDR_LAW_COUNT; ++law)
      for (int variant = 0; variant < 4; ++variant) {
        body b = damaged_body(k, (sdr_law)law, variant & 1);
        double *u[3], *f[3], linear, angular;
        int64_t cut;
        vector_create(b.points, u);
        vector_create(b.points, f);
        if (variant & 2)
          assert_int_equal(b.model->ops->mark(b.model, body_cut_and_protect, NULL, &cut), SDR_OK);
        vector_noise(b.points, 0.05 * body_spacing, 8, u);
        b.model->ops->commit(b.model, u);
        vector_noise(b.points, 0.05 * body_spacing, 9, u);
        b.model->ops->force(b.model, u, f);
        residuals(b.points, u, f, &linear, &angular);
        assert_at_most(linear, 1e-12);
        assert_at_most(angular, 1e-12);
        vector_destroy(u);
        vector_destroy(f);
        body_destroy(&b);
      }
}

/* The control: what the two residuals are if the dual half is missing. */
static void without_the_dual_half_nothing_balances(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; k += 2) { /* those whose horizons differ */
    body b = damaged_body(k, SDR_LAW_VARIATIONAL, 1);
    reference r = reference_create(&b);
    double *u[3], *f[3], linear, angular;
    vector_create(b.points, u);
    vector_create(b.points, f);
    vector_noise(b.points, 0.05 * body_spacing, 9, u);
    reference_force(&r, u, f, NULL);
    residuals(b.points, u, f, &linear, &angular);
    assert_at_most(linear, 1e-12);
    assert_at_most(angular, 1e-12);
    r.without_dual = 1;
    reference_force(&r, u, f, NULL);
    residuals(b.points, u, f, &linear, &angular);
    assert_true(linear > 1e-3);
    assert_true(angular > 1e-3);
    vector_destroy(u);
    vector_destroy(f);
    reference_destroy(&r);
    body_destroy(&b);
  }
}

static void a_rigid_motion_makes_no_force(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body b = damaged_body(k, SDR_LAW_VARIATIONAL, 1);
    double *u[3], *f[3], *scale[3];
    vector_create(b.points, u);
    vector_create(b.points, f);
    vector_create(b.points, scale);
    const double c = cos(0.7), s = sin(0.7);
    const double turn[9] = {c - 1.0, -s, 0.0, s, c - 1.0, 0.0, 0.0, 0.0, 0.0};
    vector_noise(b.points, 0.01 * body_spacing, 4, u);
    b.model->ops->force(b.model, u, scale);
    vector_linear(b.points, turn, u);
    b.model->ops->force(b.model, u, f);
    assert_at_most(vector_largest(b.points, f), 1e-11 * vector_largest(b.points, scale));
    vector_destroy(u);
    vector_destroy(f);
    vector_destroy(scale);
    body_destroy(&b);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(forces_and_moments_balance_for_any_horizons_and_damage),
      cmocka_unit_test(without_the_dual_half_nothing_balances),
      cmocka_unit_test(a_rigid_motion_makes_no_force),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
