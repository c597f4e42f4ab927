/* The force is minus the gradient of stored + dissipated energy, and the tangent the gradient of
   the force: for every law, dimension and form of storage. Differences are taken away from the
   kinks s = 0 and s = k, where the energy has no second derivative (theory, Derivative tests). */
#include "damage/bond_law.h"
#include "support/slopes.h"

static const body_how shapes[] = {
    {.dimension = SDR_1D, .cells = {40}},
    {.dimension = SDR_PLANE_STRESS, .cells = {11, 9}},
    {.dimension = SDR_PLANE_STRAIN,
     .cells = {9, 10},
     .angle = 0.3,
     .weight = {.correction = SDR_CORRECTION_ISO}},
    {.dimension = SDR_PLANE_STRESS, .cells = {10, 9}, .jitter = 0.3, .horizon_spread = 0.3},
    {.dimension = SDR_3D, .cells = {9, 3, 4}, .ratio = 1.75},
    {.dimension = SDR_3D, .cells = {9, 3, 3}, .ratio = 1.8, .jitter = 0.2, .horizon_spread = 0.2},
};
enum { SHAPES = sizeof shapes / sizeof *shapes, EVERY = 7 };

/* On loading the history is the stretch rounded to float, by up to 6e-8; that moves (1-d)^2 by up
   to 4 d times as much, in the force but not in the energy, which is stationary in d. */
static double force_tolerance(const body *b, int loading)
{
  return loading && sdr_law_softens((int)b->how.law) ? 2e-7 : 1e-9;
}

static void check_force(const body *b, double *const u[3], int loading)
{
  double *f[3];
  vector_create(b->points, f);
  b->model->ops->force(b->model, u, f);
  const double largest = vector_largest(b->points, f);
  assert_true(largest > 0.0);
  for (int a = 0; a < b->points->components; ++a)
    for (int32_t i = 0; i < b->points->count; i += EVERY)
      assert_near(-slopes_of_energy(b, u, a, i, 2e-5 * body_spacing), f[a][i],
                  force_tolerance(b, loading) * largest);
  vector_destroy(f);
}

static void check_diagonal(const body *b, double *const diagonal, double *const column[3], int a,
                           int32_t i, double largest)
{
  const int n = b->points->components;
  for (int c = 0; c < n; ++c)
    assert_near(diagonal[(size_t)i * (size_t)(n * n) + (size_t)(c * n + a)], column[c][i],
                1e-13 * largest);
}

static void check_tangent(const body *b, double *const u[3], int loading)
{
  const int n = b->points->components;
  /* Softened so far, their tangents are below the float steps; verify_tangent has them in double.
   */
  if (loading && (b->how.law == SDR_LAW_AT1 || b->how.law == SDR_LAW_COHESIVE)) return;
  double *unit[3], *column[3], *expected[3];
  double *diagonal = sdr_alloc((size_t)b->points->count, (size_t)(n * n) * sizeof(double));
  vector_create(b->points, unit);
  vector_create(b->points, column);
  vector_create(b->points, expected);
  assert_int_equal(b->model->ops->tangent_diagonal(b->model, u, diagonal), SDR_OK);
  double largest = 0.0;
  for (size_t k = 0; k < (size_t)b->points->count * (size_t)(n * n); ++k)
    largest = fmax(largest, fabs(diagonal[k]));
  /* Large steps average over the float steps of the history; else rounding wants them small. */
  const double h = (loading ? 7e-4 : 3e-4) * body_spacing;
  for (int a = 0; a < n; ++a)
    for (int32_t i = 0; i < b->points->count; i += EVERY) {
      unit[a][i] = 1.0;
      assert_int_equal(b->model->ops->tangent_times(b->model, u, unit, column), SDR_OK);
      unit[a][i] = 0.0;
      slopes_of_force(b, u, a, i, h, expected);
      assert_at_most(vector_difference(b->points, column, expected),
                     (loading ? 1e-5 : 1e-8) * largest);
      check_diagonal(b, diagonal, column, a, i, largest);
    }
  sdr_free(diagonal);
  vector_destroy(unit);
  vector_destroy(column);
  vector_destroy(expected);
}

/* at1 and cohesive have kinks besides: all bonds are past that of at1 and past both of cohesive's
   first line, and none is where the second one ends. */
static double stretch_of(int shape, int law)
{
  if (law == SDR_LAW_AT1) return 0.0085;
  if (law == SDR_LAW_COHESIVE) return 0.04;
  return shape == 0 ? 0.02 : 0.016;
}

/* Every body, after a history of stretching, at `factor` times that stretch. */
static void every_body(double factor, void (*check)(const body *, double *const[3], int))
{
  for (int k = 0; k < SHAPES; ++k)
    for (int law = 0; law < SDR_LAW_COUNT; ++law)
      for (int variant = 0; variant < 8; ++variant) {
        body_how how = shapes[k];
        how.law = (sdr_law)law;
        how.force_loose = variant & 1;
        how.scatter = variant & 2 ? 0.3 : 0.0;
        how.two_materials = how.scatter > 0.0;
        how.stretch = stretch_of(k, law);
        how.brittle = 16.0;
        how.ell = 1.3;
        if (how.force_loose && how.jitter > 0.0) continue;
        if (factor > 1.0 && law == SDR_LAW_CRITICAL_STRETCH) continue; /* breaks in commit */
        body b = body_create(&how);
        int64_t cut;
        if (variant & 4)
          assert_int_equal(b.model->ops->mark(b.model, body_cut_and_protect, NULL, &cut), SDR_OK);
        double *u[3];
        vector_create(b.points, u);
        slopes_stretch(&b, 1.0, 3, u);
        b.model->ops->commit(b.model, u);
        slopes_stretch(&b, factor, 4, u);
        check(&b, u, factor > 1.0);
        vector_destroy(u);
        body_destroy(&b);
      }
}

static void force_is_minus_the_gradient_of_energy_on_loading(void **state)
{
  (void)state;
  every_body(2.5, check_force);
}

static void force_is_minus_the_gradient_of_energy_on_unloading(void **state)
{
  (void)state;
  every_body(0.5, check_force);
}

static void force_is_minus_the_gradient_of_energy_in_compression(void **state)
{
  (void)state;
  every_body(-0.7, check_force);
}

static void tangent_is_the_gradient_of_the_force_on_loading(void **state)
{
  (void)state;
  every_body(2.5, check_tangent);
}

static void tangent_is_the_gradient_of_the_force_on_unloading(void **state)
{
  (void)state;
  every_body(0.5, check_tangent);
}

static void tangent_is_the_gradient_of_the_force_in_compression(void **state)
{
  (void)state;
  every_body(-0.7, check_tangent);
}

static void the_reference_tangent_is_the_tangent_of_the_undeformed_body(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int variant = 0; variant < 4; ++variant) {
      body_how how = shapes[k];
      how.law = SDR_LAW_VARIATIONAL;
      how.force_loose = variant & 1;
      how.scatter = variant & 2 ? 0.3 : 0.0;
      body b = body_create(&how);
      double *u[3], *v[3], *exact[3], *reference[3];
      vector_create(b.points, u);
      vector_create(b.points, v);
      vector_create(b.points, exact);
      vector_create(b.points, reference);
      vector_noise(b.points, 1.0, 11, v);
      assert_int_equal(b.model->ops->tangent_times(b.model, u, v, exact), SDR_OK);
      b.model->ops->reference_times(b.model, v, reference);
      assert_at_most(vector_difference(b.points, exact, reference),
                     1e-13 * vector_largest(b.points, exact));
      vector_destroy(u);
      vector_destroy(v);
      vector_destroy(exact);
      vector_destroy(reference);
      body_destroy(&b);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(force_is_minus_the_gradient_of_energy_on_loading),
      cmocka_unit_test(force_is_minus_the_gradient_of_energy_on_unloading),
      cmocka_unit_test(force_is_minus_the_gradient_of_energy_in_compression),
      cmocka_unit_test(tangent_is_the_gradient_of_the_force_on_loading),
      cmocka_unit_test(tangent_is_the_gradient_of_the_force_on_unloading),
      cmocka_unit_test(tangent_is_the_gradient_of_the_force_in_compression),
      cmocka_unit_test(the_reference_tangent_is_the_tangent_of_the_undeformed_body),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
