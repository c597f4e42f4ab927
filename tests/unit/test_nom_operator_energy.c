/* nom: operator energy, its gradient and its matrix. */
#include "nom/assembly.h"
#include "nom/operator_energy.h"
#include "support/grid.h"

typedef struct {
  grid g;
  grid_operators o;
  double *u, *coefficient;
} body;

static void body_create(int components, int order, int nearest, double jitter, body *b)
{
  const int cells[3] = {20, 8, 4};
  uint64_t seed = 9;
  grid_create(components, cells[components - 1], jitter, 1.0, &b->g);
  grid_operators_create(&b->g, order, nearest, SDR_INFLUENCE_GAUSSIAN, &b->o);
  b->u = sdr_alloc((size_t)b->g.count, sizeof *b->u);
  b->coefficient = sdr_alloc((size_t)b->g.count, sizeof *b->coefficient);
  for (int32_t i = 0; i < b->g.count; ++i) {
    b->u[i] = noise(&seed);
    b->coefficient[i] = 2.0 + noise(&seed);
  }
}

static void body_destroy(body *b)
{
  sdr_free(b->u);
  sdr_free(b->coefficient);
  grid_operators_destroy(&b->o);
  grid_destroy(&b->g);
}

static double energy_of(const body *b)
{
  return sdr_operator_energy(&b->o.shape, b->coefficient, b->u);
}

static void polynomials_up_to_the_order_have_no_energy(void **state)
{
  (void)state;
  for (int order = 1; order <= 3; ++order) {
    body b;
    body_create(2, order, 22, 0.3, &b);
    const double noisy = energy_of(&b);
    for (int beyond = 0; beyond < 2; ++beyond) {
      for (int32_t i = 0; i < b.g.count; ++i)
        b.u[i] = 1.0 + pow(b.g.x[0][i] + 0.5 * b.g.x[1][i], order + beyond);
      if (beyond)
        assert_true(energy_of(&b) > 1e-8 * noisy);
      else
        assert_true(energy_of(&b) < 1e-24 * noisy);
    }
    body_destroy(&b);
  }
}

/* In 1-D with neighbours at -1 and 1 and order 1: u_x = 0 for (1, 0, 1), the residuals are 1, m =
   2, so the point has V P/(2 2) (1 + 1). */
static void a_mode_that_the_gradient_cannot_see_has_the_energy_of_the_formula(void **state)
{
  (void)state;
  const double x[3] = {-1.0, 0.0, 1.0}, radius[3] = {1.0, 1.0, 1.0};
  const double p[3] = {0.0, 6.0, 0.0}, u[3] = {1.0, 0.0, 1.0};
  const sdr_cloud cloud = {1, 3, {x, NULL, NULL}, NULL};
  const sdr_shape_how how = {.order = 1, .influence = SDR_INFLUENCE_CONSTANT};
  sdr_support s;
  sdr_shape_tensors shape;
  assert_int_equal(sdr_support_by_radius(&cloud, radius, &s), SDR_OK);
  assert_int_equal(sdr_shape_tensors_create(&s, &how, &shape), SDR_OK);
  assert_near(sdr_operator_energy(&shape, p, u), 3.0, 1e-14);
  double gradient[3] = {0.0};
  sdr_operator_energy_gradient(&shape, p, u, gradient);
  assert_near(gradient[0], 3.0, 1e-14);
  assert_near(gradient[1], -6.0, 1e-14);
  assert_near(gradient[2], 3.0, 1e-14);
  sdr_shape_tensors_destroy(&shape);
  sdr_support_destroy(&s);
}

/* The energy is quadratic, so that a central difference is exact but for rounding. */
static void the_gradient_is_the_derivative_of_the_energy(void **state)
{
  (void)state;
  const int nearest[3] = {6, 14, 30};
  for (int d = 1; d <= 3; ++d) {
    body b;
    body_create(d, 2, nearest[d - 1], 0.3, &b);
    double *gradient = sdr_alloc((size_t)b.g.count, sizeof *gradient);
    const double scale = energy_of(&b);
    sdr_operator_energy_gradient(&b.o.shape, b.coefficient, b.u, gradient);
    for (int32_t i = 0; i < b.g.count; i += 5) {
      const double there = b.u[i];
      b.u[i] = there + 0.5;
      const double above = energy_of(&b);
      b.u[i] = there - 0.5;
      assert_near(gradient[i], above - energy_of(&b), 1e-12 * scale);
      b.u[i] = there;
    }
    sdr_free(gradient);
    body_destroy(&b);
  }
}

static void the_matrix_is_the_derivative_of_the_gradient_for_each_component(void **state)
{
  (void)state;
  const int nearest[3] = {6, 14, 30};
  for (int d = 1; d <= 3; ++d) {
    body b;
    sdr_csr_builder *builder;
    sdr_csr m;
    body_create(d, 2, nearest[d - 1], 0.3, &b);
    const int32_t n = b.g.count;
    assert_int_equal(sdr_csr_builder_create(2 * n, 2 * n, &builder), SDR_OK);
    assert_int_equal(sdr_operator_energy_add(&b.o.shape, b.coefficient, 2, builder), SDR_OK);
    assert_int_equal(sdr_csr_builder_finish(builder, &m), SDR_OK);
    double *both = sdr_alloc(4 * (size_t)n, sizeof *both), *product = both + 2 * n;
    double *gradient = sdr_alloc((size_t)n, sizeof *gradient);
    for (int32_t i = 0; i < n; ++i) {
      both[i] = b.u[i];
      both[n + i] = -3.0 * b.u[i];
    }
    sdr_csr_times(&m, both, product);
    sdr_operator_energy_gradient(&b.o.shape, b.coefficient, b.u, gradient);
    for (int32_t i = 0; i < n; ++i) {
      assert_near(product[i], gradient[i], 1e-11 * energy_of(&b));
      assert_near(product[n + i], -3.0 * gradient[i], 3e-11 * energy_of(&b));
    }
    sdr_free(both);
    sdr_free(gradient);
    sdr_csr_destroy(&m);
    sdr_csr_builder_destroy(&builder);
    body_destroy(&b);
  }
}

/* The checkerboard on a lattice has no gradient inside, and so no energy without control. */
static void it_takes_hold_of_the_checkerboard(void **state)
{
  (void)state;
  body b;
  body_create(2, 1, 8, 0.0, &b);
  for (int32_t i = 0; i < b.g.count; ++i) b.u[i] = (i % 9 + i / 9) % 2 ? 1.0 : -1.0;
  const int32_t middle = 4 * 9 + 4;
  assert_near(sdr_operator_at(&b.o.op, 0, middle, b.u), 0.0, 1e-12);
  assert_near(sdr_operator_at(&b.o.op, 1, middle, b.u), 0.0, 1e-12);
  assert_true(energy_of(&b) > 1.0);
  body_destroy(&b);
}

static void no_memory_leaves_nothing_behind(void **state)
{
  (void)state;
  body b;
  sdr_csr_builder *builder;
  body_create(2, 1, 8, 0.0, &b);
  const size_t before = sdr_memory_now();
  for (long passed = 0; passed < 4; ++passed) {
    sdr_memory_fail_after(passed);
    if (sdr_csr_builder_create(b.g.count, b.g.count, &builder) == SDR_OK) {
      assert_int_equal(sdr_operator_energy_add(&b.o.shape, b.coefficient, 1, builder),
                       SDR_RUN_FAILED);
      sdr_csr_builder_destroy(&builder);
    }
    sdr_memory_fail_after(-1);
    assert_int_equal(sdr_memory_now(), before);
  }
  body_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(polynomials_up_to_the_order_have_no_energy),
      cmocka_unit_test(a_mode_that_the_gradient_cannot_see_has_the_energy_of_the_formula),
      cmocka_unit_test(the_gradient_is_the_derivative_of_the_energy),
      cmocka_unit_test(the_matrix_is_the_derivative_of_the_gradient_for_each_component),
      cmocka_unit_test(it_takes_hold_of_the_checkerboard),
      cmocka_unit_test(no_memory_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
