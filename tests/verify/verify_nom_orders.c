/* Derivatives by nonlocal operators converge as theory, "Nonlocal operators", says, on lattices and
   on jittered points. Supports hold 8/14/22/32 nearest points for orders 1/2/3/4 in 2-D, weights
   are Gaussian; errors are relative, in the L2 norm over the points. */
#include "support/grid.h"

static const int nearest_of[5] = {0, 8, 14, 22, 32};

/* sin(2 x + 3 y + z / 2 + 0.3): D_a is 2^a_x 3^a_y (1/2)^a_z times sin shifted by |a| pi/2. */
static double wave(const grid *g, int32_t i, const int power[3])
{
  const double k[3] = {2.0, 3.0, 0.5};
  double phase = 0.3, factor = 1.0;
  for (int c = 0; c < g->components; ++c) {
    phase += k[c] * g->x[c][i] + 0.5 * GRID_PI * power[c];
    factor *= pow(k[c], power[c]);
  }
  return factor * sin(phase);
}

/* Points at least six spacings from the boundary, whose supports on a lattice are complete. */
static int deep(const grid *g, int32_t i)
{
  for (int c = 0; c < g->components; ++c)
    if (fabs(g->x[c][i] - 0.5) > 0.5 - 6.0 / g->cells) return 0;
  return 1;
}

/* Relative error of every derivative of order n; `inside`: over deep points only. */
static void derivative_errors(int components, int cells, int order, double jitter, int inside,
                              double error[SDR_MOST_TERMS])
{
  const int more = components == 3 ? 2 * nearest_of[order] : nearest_of[order];
  const int none[3] = {0, 0, 0};
  grid g;
  grid_operators o;
  grid_create(components, cells, jitter, 1.0, &g);
  grid_operators_create(&g, order, components == 1 ? 2 * order + 2 : more, SDR_INFLUENCE_GAUSSIAN,
                        &o);
  double *u = sdr_alloc((size_t)g.count, sizeof *u);
  for (int32_t i = 0; i < g.count; ++i) u[i] = wave(&g, i, none);
  for (int a = 0; a < o.op.terms; ++a) {
    double wrong = 0.0, all = 0.0;
    for (int32_t i = 0; i < g.count; ++i) {
      if (inside && !deep(&g, i)) continue;
      const double right = wave(&g, i, o.shape.set.power[a]);
      wrong += pow(sdr_operator_at(&o.op, a, i, u) - right, 2.0);
      all += right * right;
    }
    error[a] = sqrt(wrong / all);
  }
  sdr_free(u);
  grid_operators_destroy(&o);
  grid_destroy(&g);
}

static void expect_orders(int components, int coarse, double jitter)
{
  for (int order = 1; order <= 4; ++order) {
    double error[2][SDR_MOST_TERMS];
    sdr_multi_indices set;
    assert_int_equal(sdr_multi_indices_of(components, order, &set), SDR_OK);
    for (int fine = 0; fine < 2; ++fine)
      derivative_errors(components, coarse << fine, order, jitter, jitter == 0.0, error[fine]);
    for (int a = 0; a < set.count; ++a) {
      const int k = set.degree[a];
      const int promised = jitter == 0.0 ? (order + 2 - k) / 2 * 2 : order + 1 - k;
      const double found = log2(error[0][a] / error[1][a]);
      if (!(found >= promised - 0.3))
        fail_msg("%d-D, order %d: %s converges with order %.2f, not %d (%.2e, %.2e)", components,
                 order, set.name[a], found, promised, error[0][a], error[1][a]);
    }
  }
}

static void derivatives_of_order_k_converge_with_n_plus_1_minus_k_on_jittered_points(void **state)
{
  (void)state;
  expect_orders(1, 80, 0.2);
  expect_orders(2, 30, 0.2);
  expect_orders(2, 30, 0.4);
}

static void inside_a_lattice_the_order_is_rounded_up_to_an_even_one(void **state)
{
  (void)state;
  expect_orders(1, 80, 0.0);
  expect_orders(2, 30, 0.0);
}

static void derivatives_converge_in_space_too(void **state)
{
  (void)state;
  double error[2][SDR_MOST_TERMS];
  sdr_multi_indices set;
  assert_int_equal(sdr_multi_indices_of(3, 2, &set), SDR_OK);
  for (int fine = 0; fine < 2; ++fine) derivative_errors(3, 10 << fine, 2, 0.2, 0, error[fine]);
  for (int a = 0; a < set.count; ++a)
    assert_true(log2(error[0][a] / error[1][a]) >= 3 - set.degree[a] - 0.3);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(derivatives_of_order_k_converge_with_n_plus_1_minus_k_on_jittered_points),
      cmocka_unit_test(inside_a_lattice_the_order_is_rounded_up_to_an_even_one),
      cmocka_unit_test(derivatives_converge_in_space_too),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
