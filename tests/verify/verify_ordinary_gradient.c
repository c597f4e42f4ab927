/* Ordinary bodies: the force is minus the gradient of stored + dissipated energy, and the tangent,
   its diagonal and its elements the gradient of the force: for every law, dimension, form and form
   of storage. Differences are taken away from the kinks theta = 0 and plus = history, where the
   energy has no second derivative. */
#include "support/elements.h"
#include "support/ordinary.h"
#include "support/slopes.h"

static const ordinary_how shapes[] = {
    {.body = {.dimension = SDR_1D, .cells = {40}}},
    {.body = {.dimension = SDR_PLANE_STRESS, .cells = {11, 9}}, .poisson = 0.2},
    {.body = {.dimension = SDR_PLANE_STRAIN,
              .cells = {9, 10},
              .angle = 0.3,
              .weight = {.correction = SDR_CORRECTION_ISO}},
     .poisson = 0.45},
    {.body =
         {.dimension = SDR_PLANE_STRESS, .cells = {10, 9}, .jitter = 0.3, .horizon_spread = 0.3}},
    {.body = {.dimension = SDR_PLANE_STRESS, .cells = {10, 8}}, .form = SDR_FORM_MADENCI_OTERKUS},
    {.body = {.dimension = SDR_PLANE_STRAIN, .cells = {9, 9}, .jitter = 0.2, .horizon_spread = 0.2},
     .form = SDR_FORM_MADENCI_OTERKUS},
    {.body = {.dimension = SDR_3D, .cells = {8, 3, 4}, .ratio = 1.75}},
    {.body = {.dimension = SDR_3D,
              .cells = {8, 3, 3},
              .ratio = 1.8,
              .jitter = 0.2,
              .horizon_spread = 0.2}},
};
enum { SHAPES = sizeof shapes / sizeof *shapes, EVERY = 11 };

static const sdr_law laws[] = {SDR_LAW_NONE, SDR_LAW_VARIATIONAL, SDR_LAW_CRITICAL_STRETCH};

static void check_force(const body *b, double *const u[3])
{
  double *f[3];
  vector_create(b->points, f);
  b->model->ops->force(b->model, u, f);
  const double largest = vector_largest(b->points, f);
  assert_true(largest > 0.0);
  for (int a = 0; a < b->points->components; ++a)
    for (int32_t i = 0; i < b->points->count; i += EVERY)
      assert_near(-slopes_of_energy(b, u, a, i, 1e-4 * body_spacing), f[a][i], 1e-8 * largest);
  vector_destroy(f);
}

static void check_elements(const body *b, double *const u[3])
{
  double *v[3], *right[3], *out[3];
  vector_create(b->points, v);
  vector_create(b->points, right);
  vector_create(b->points, out);
  vector_noise(b->points, 1.0, 12, v);
  assert_int_equal(b->model->ops->tangent_times(b->model, u, v, right), SDR_OK);
  elements all = {b->points->components, v, out, 0.0, 0.0};
  assert_int_equal(b->model->ops->visit_hessian(b->model, u, elements_add, &all), SDR_OK);
  assert_at_most(vector_difference(b->points, right, out),
                 1e-12 * vector_largest(b->points, right));
  assert_at_most(all.asymmetry, 1e-13 * all.largest);
  vector_destroy(v);
  vector_destroy(right);
  vector_destroy(out);
}

static void check_tangent(const body *b, double *const u[3])
{
  const int n = b->points->components;
  double *unit[3], *column[3], *expected[3];
  double *diagonal = sdr_alloc((size_t)b->points->count, (size_t)(n * n) * sizeof(double));
  vector_create(b->points, unit);
  vector_create(b->points, column);
  vector_create(b->points, expected);
  assert_int_equal(b->model->ops->tangent_diagonal(b->model, u, diagonal), SDR_OK);
  double largest = 0.0;
  for (size_t k = 0; k < (size_t)b->points->count * (size_t)(n * n); ++k)
    largest = fmax(largest, fabs(diagonal[k]));
  for (int a = 0; a < n; ++a)
    for (int32_t i = 0; i < b->points->count; i += EVERY) {
      unit[a][i] = 1.0;
      assert_int_equal(b->model->ops->tangent_times(b->model, u, unit, column), SDR_OK);
      unit[a][i] = 0.0;
      slopes_of_force(b, u, a, i, 1e-4 * body_spacing, expected);
      assert_at_most(vector_difference(b->points, column, expected), 1e-7 * largest);
      for (int c = 0; c < n; ++c)
        assert_near(diagonal[(size_t)i * (size_t)(n * n) + (size_t)(c * n + a)], column[c][i],
                    1e-12 * largest);
    }
  check_elements(b, u);
  sdr_free(diagonal);
  vector_destroy(unit);
  vector_destroy(column);
  vector_destroy(expected);
}

/* Every body, after a history of stretching, at `factor` times that stretch. */
static void every_body(double factor, void (*check)(const body *, double *const[3]))
{
  for (int k = 0; k < SHAPES; ++k)
    for (int law = 0; law < 3; ++law)
      for (int variant = 0; variant < 8; ++variant) {
        ordinary_how how = shapes[k];
        how.body.law = laws[law];
        how.body.force_loose = variant & 1;
        how.body.scatter = variant & 2 ? 0.3 : 0.0;
        how.body.two_materials = how.body.scatter > 0.0;
        how.body.stretch = k == 0 ? 0.02 : 0.016;
        if (how.body.force_loose && how.body.jitter > 0.0) continue;
        body b = ordinary_create(&how);
        int64_t cut;
        if (variant & 4)
          assert_int_equal(b.model->ops->mark(b.model, body_cut_and_protect, NULL, &cut), SDR_OK);
        double *u[3];
        vector_create(b.points, u);
        slopes_stretch(&b, 1.0, 3, u);
        b.model->ops->commit(b.model, u);
        sdr_energies e;
        b.model->ops->energies(b.model, u, &e);
        assert_int_equal(e.max_damage > 0.1, laws[law] != SDR_LAW_NONE);
        slopes_stretch(&b, factor, 4, u);
        check(&b, u);
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
    for (int variant = 0; variant < 8; ++variant) {
      ordinary_how how = shapes[k];
      how.body.law = variant & 4 ? SDR_LAW_VARIATIONAL : SDR_LAW_CRITICAL_STRETCH;
      how.body.force_loose = variant & 1;
      how.body.scatter = variant & 2 ? 0.3 : 0.0;
      body b = ordinary_create(&how);
      double *u[3], *v[3], *exact[3], *reference[3];
      vector_create(b.points, u);
      vector_create(b.points, v);
      vector_create(b.points, exact);
      vector_create(b.points, reference);
      vector_noise(b.points, 1.0, 11, v);
      assert_int_equal(b.model->ops->tangent_times(b.model, u, v, exact), SDR_OK);
      b.model->ops->reference_times(b.model, v, reference);
      assert_at_most(vector_difference(b.points, exact, reference),
                     1e-12 * vector_largest(b.points, exact));
      vector_destroy(u);
      vector_destroy(v);
      vector_destroy(exact);
      vector_destroy(reference);
      body_destroy(&b);
    }
}

static void the_secant_is_positive_and_the_tangent_at_rest(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    ordinary_how how = shapes[k];
    how.body.law = SDR_LAW_VARIATIONAL;
    body b = ordinary_create(&how);
    double *u[3];
    vector_create(b.points, u);
    slopes_stretch(&b, 2.0, 3, u);
    elements_check_secant(b.points, b.model, u);
    vector_destroy(u);
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
      cmocka_unit_test(the_secant_is_positive_and_the_tangent_at_rest),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
