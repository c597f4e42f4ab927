/* What collocation and functionals of nonlocal operators solve, and how well: Poisson's equation
   and the simply supported plate with the solution u = sin(pi x) sin(pi y) on the unit square.
   Supports hold 8/14/32 nearest points for orders 1/2/4, weights are Gaussian, volumes are those of
   the lattice's cells inside the square, jitter is 0.2 spacings and leaves the boundary's points
   where they are; errors are relative, in the L2 norm over the points. */
#include "linalg/solver.h"
#include "nom/assembly.h"
#include "nom/operator_energy.h"
#include "support/grid.h"

static const int nearest_of[5] = {0, 8, 14, 22, 32};

static double sine(const grid *g, int32_t i)
{
  return sin(GRID_PI * g->x[0][i]) * sin(GRID_PI * g->x[1][i]);
}

static double relative_error(const grid *g, const double *u)
{
  double wrong = 0.0, all = 0.0;
  for (int32_t i = 0; i < g->count; ++i) {
    wrong += pow(u[i] - sine(g, i), 2.0);
    all += pow(sine(g, i), 2.0);
  }
  return sqrt(wrong / all);
}

static void solve(sdr_csr_builder *builder, sdr_matrix_kind kind, const double *f, double *u)
{
  sdr_csr matrix;
  sdr_solver *solver;
  assert_int_equal(sdr_csr_builder_finish(builder, &matrix), SDR_OK);
  sdr_csr_builder_destroy(&builder);
  assert_int_equal(sdr_solver_create("auto", kind, &solver), SDR_OK);
  if (sdr_solver_factor(solver, &matrix) != SDR_OK) fail_msg("%s", sdr_error_message());
  assert_int_equal(sdr_solver_solve(solver, f, u), SDR_OK);
  sdr_solver_destroy(&solver);
  sdr_csr_destroy(&matrix);
}

/* -u_xx - u_yy = 2 pi^2 sin sin, u = 0 on the boundary. */
static double poisson_by_collocation(int cells, int order, double jitter)
{
  grid g;
  grid_operators o;
  sdr_csr_builder *builder;
  grid_create(2, cells, jitter, 1.0, &g);
  grid_operators_create(&g, order, nearest_of[order], SDR_INFLUENCE_GAUSSIAN, &o);
  const sdr_term minus_laplace[] = {{grid_find(&o, "xx"), 0, -1.0}, {grid_find(&o, "yy"), 0, -1.0}};
  const sdr_term value = {SDR_VALUE, 0, 1.0};
  double *f = sdr_alloc(2 * (size_t)g.count, sizeof *f), *u = f + g.count;
  assert_int_equal(sdr_csr_builder_create(g.count, g.count, &builder), SDR_OK);
  for (int32_t i = 0; i < g.count; ++i) {
    f[i] = g.edge[i] ? 0.0 : 2.0 * GRID_PI * GRID_PI * sine(&g, i);
    assert_int_equal(
        sdr_collocate(&o.op, i, g.edge[i] ? 1 : 2, g.edge[i] ? &value : minus_laplace, i, builder),
        SDR_OK);
  }
  solve(builder, SDR_MATRIX_GENERAL, f, u);
  const double error = relative_error(&g, u);
  sdr_free(f);
  grid_operators_destroy(&o);
  grid_destroy(&g);
  return error;
}

static void expect_poisson(int order, double jitter, double most, double least_order)
{
  const double coarse = poisson_by_collocation(40, order, jitter);
  const double fine = poisson_by_collocation(80, order, jitter);
  print_message("Poisson, collocation, n = %d, jitter %.1f: %.3e at 1/80, order %.2f\n", order,
                jitter, fine, log2(coarse / fine));
  assert_true(fine <= most);
  assert_true(log2(coarse / fine) >= least_order);
}

static void poisson_by_collocation_converges_with_order_two(void **state)
{
  (void)state;
  expect_poisson(2, 0.0, 5e-4, 1.8);
  expect_poisson(2, 0.2, 5e-4, 1.8);
}

static void poisson_by_fourth_order_collocation_is_exact_to_half_a_millionth(void **state)
{
  (void)state;
  expect_poisson(4, 0.0, 5e-7, 3.2);
  expect_poisson(4, 0.2, 5e-7, 3.2);
}

/* The functional 1/2 |grad u|^2 - f u with first-order operators and operator energy P, on a
   lattice that continues by `frame` spacings around the square; there u is prescribed (its odd
   continuation, which is the exact solution), so that every support inside is complete. */
static double poisson_by_functional(int cells, int frame, double p)
{
  grid g;
  grid_operators o;
  sdr_csr_builder *builder;
  sdr_csr matrix;
  sdr_solver *solver;
  const double size = 1.0 + 2.0 * frame / cells;
  grid_create(2, cells + 2 * frame, 0.0, size, &g);
  for (int c = 0; c < 2; ++c)
    for (int32_t i = 0; i < g.count; ++i) g.x[c][i] -= (double)frame / cells;
  grid_operators_create(&g, 1, nearest_of[1], SDR_INFLUENCE_GAUSSIAN, &o);
  const sdr_quadratic_term terms[] = {{0, 0, 0, 0, 1.0, NULL}, {1, 0, 1, 0, 1.0, NULL}};
  const sdr_functional functional = {1, 2, terms};
  double *f = sdr_alloc(4 * (size_t)g.count, sizeof *f), *u = f + g.count;
  double *coefficient = u + g.count, *value = coefficient + g.count;
  uint8_t *fixed = sdr_alloc((size_t)g.count, 1);
  for (int32_t i = 0; i < g.count; ++i) {
    const double from_centre = fmax(fabs(g.x[0][i] - 0.5), fabs(g.x[1][i] - 0.5));
    fixed[i] = from_centre > 0.5 - 1e-9;
    value[i] = sine(&g, i);
    f[i] = 2.0 * GRID_PI * GRID_PI * value[i] * g.volume[i];
    coefficient[i] = p;
  }
  assert_int_equal(sdr_csr_builder_create(g.count, g.count, &builder), SDR_OK);
  assert_int_equal(sdr_functional_add(&o.op, &functional, builder), SDR_OK);
  assert_int_equal(sdr_operator_energy_add(&o.shape, coefficient, 1, builder), SDR_OK);
  assert_int_equal(sdr_csr_builder_finish(builder, &matrix), SDR_OK);
  assert_int_equal(sdr_fix_unknowns(&matrix, fixed, value, f), SDR_OK);
  assert_int_equal(sdr_solver_create("cholmod", SDR_MATRIX_POSITIVE, &solver), SDR_OK);
  assert_int_equal(sdr_solver_factor(solver, &matrix), SDR_OK);
  assert_int_equal(sdr_solver_solve(solver, f, u), SDR_OK);
  const double error = relative_error(&g, u);
  sdr_solver_destroy(&solver);
  sdr_csr_destroy(&matrix);
  sdr_csr_builder_destroy(&builder);
  sdr_free(f);
  sdr_free(fixed);
  grid_operators_destroy(&o);
  grid_destroy(&g);
  return error;
}

/* P = 4 d/3 = 8/3 takes the second-order error of the energy away (theory, "Nonlocal operators").
 */
static void the_first_order_functional_with_operator_energy_is_of_order_four(void **state)
{
  (void)state;
  const double coarse = poisson_by_functional(20, 4, 8.0 / 3.0);
  const double middle = poisson_by_functional(40, 4, 8.0 / 3.0);
  const double other = poisson_by_functional(40, 4, 2.0);
  print_message("Poisson, functional, P = 8/3: %.3e at 1/20, %.3e at 1/40, order %.2f; P = 2: "
                "%.3e at 1/40\n",
                coarse, middle, log2(coarse / middle), other);
  assert_true(coarse <= 2e-5 && middle <= 2e-5);
  assert_true(log2(coarse / middle) >= 3.7);
  assert_true(other > 100.0 * middle);
}

/* ---- the simply supported plate -------------------------------------------------------------- */

/* D = 1: w and the moment sum m with -lap m = q, -lap w = m, both 0 on the boundary;
   q = 4 pi^4 sin sin. */
static double plate_by_moments(int cells, int order, double jitter)
{
  grid g;
  grid_operators o;
  sdr_csr_builder *builder;
  grid_create(2, cells, jitter, 1.0, &g);
  grid_operators_create(&g, order, nearest_of[order], SDR_INFLUENCE_GAUSSIAN, &o);
  const int xx = grid_find(&o, "xx"), yy = grid_find(&o, "yy");
  const sdr_term curvature[] = {{xx, 0, 1.0}, {yy, 0, 1.0}, {SDR_VALUE, 1, 1.0}};
  const sdr_term balance[] = {{xx, 1, -1.0}, {yy, 1, -1.0}};
  const sdr_term w = {SDR_VALUE, 0, 1.0}, m = {SDR_VALUE, 1, 1.0};
  const int32_t n = g.count;
  double *f = sdr_alloc(4 * (size_t)n, sizeof *f), *u = f + 2 * n;
  assert_int_equal(sdr_csr_builder_create(2 * n, 2 * n, &builder), SDR_OK);
  for (int32_t i = 0; i < n; ++i) {
    const int edge = g.edge[i];
    f[n + i] = edge ? 0.0 : 4.0 * pow(GRID_PI, 4.0) * sine(&g, i);
    assert_int_equal(sdr_collocate(&o.op, i, edge ? 1 : 3, edge ? &w : curvature, i, builder),
                     SDR_OK);
    assert_int_equal(sdr_collocate(&o.op, i, edge ? 1 : 2, edge ? &m : balance, n + i, builder),
                     SDR_OK);
  }
  solve(builder, SDR_MATRIX_GENERAL, f, u);
  const double error = relative_error(&g, u);
  sdr_free(f);
  grid_operators_destroy(&o);
  grid_destroy(&g);
  return error;
}

static void a_simply_supported_plate_bends_as_two_poisson_problems(void **state)
{
  (void)state;
  for (int jittered = 0; jittered < 2; ++jittered) {
    const double second = plate_by_moments(40, 2, 0.2 * jittered);
    const double fourth = plate_by_moments(40, 4, 0.2 * jittered);
    print_message("plate, moments, N = 40, jitter %.1f: %.3e with n = 2, %.3e with n = 4\n",
                  0.2 * jittered, second, fourth);
    assert_true(second <= 4e-3);
    assert_true(fourth <= 1e-5);
  }
}

/* The ring of a lattice that point i lies on: 0 on the boundary. */
static int ring_of(const grid *g, int32_t i)
{
  const int side = g->cells + 1, at[2] = {i % side, i / side};
  int ring = g->cells;
  for (int c = 0; c < 2; ++c)
    for (int end = 0; end < 2; ++end) {
      const int away = end ? g->cells - at[c] : at[c];
      if (away < ring) ring = away;
    }
  return ring;
}

/* Rows of the ring beside the boundary hold the moment condition of the boundary points next to
   them: lap w = 0 there, as w = 0 along an edge. */
static void moment_rows(const grid *g, const sdr_operator *op, const sdr_term laplace[2], int32_t i,
                        sdr_csr_builder *builder)
{
  const int side = g->cells + 1, step[2] = {1, side}, at[2] = {i % side, i / side};
  for (int c = 0; c < 2; ++c) {
    if (at[c] != 1 && at[c] != g->cells - 1) continue;
    const int32_t beside = at[c] == 1 ? i - step[c] : i + step[c];
    assert_int_equal(sdr_collocate(op, beside, 2, laplace, i, builder), SDR_OK);
  }
}

/* The fourth derivatives themselves, w_xxxx + 2 w_xxyy + w_yyyy = q. */
static double plate_directly(int cells, int order, int nearest)
{
  grid g;
  grid_operators o;
  sdr_csr_builder *builder;
  grid_create(2, cells, 0.0, 1.0, &g);
  grid_operators_create(&g, order, nearest, SDR_INFLUENCE_GAUSSIAN, &o);
  const sdr_term biharmonic[] = {{grid_find(&o, "xxxx"), 0, 1.0},
                                 {grid_find(&o, "xxyy"), 0, 2.0},
                                 {grid_find(&o, "yyyy"), 0, 1.0}};
  const sdr_term laplace[] = {{grid_find(&o, "xx"), 0, 1.0}, {grid_find(&o, "yy"), 0, 1.0}};
  const sdr_term value = {SDR_VALUE, 0, 1.0};
  double *f = sdr_alloc(2 * (size_t)g.count, sizeof *f), *u = f + g.count;
  assert_int_equal(sdr_csr_builder_create(g.count, g.count, &builder), SDR_OK);
  for (int32_t i = 0; i < g.count; ++i) {
    const int ring = ring_of(&g, i);
    f[i] = ring > 1 ? 4.0 * pow(GRID_PI, 4.0) * sine(&g, i) : 0.0;
    if (ring == 1)
      moment_rows(&g, &o.op, laplace, i, builder);
    else
      assert_int_equal(
          sdr_collocate(&o.op, i, ring ? 3 : 1, ring ? biharmonic : &value, i, builder), SDR_OK);
  }
  solve(builder, SDR_MATRIX_GENERAL, f, u);
  const double error = relative_error(&g, u);
  sdr_free(f);
  grid_operators_destroy(&o);
  grid_destroy(&g);
  return error;
}

/* A fourth derivative of order n converges with n + 1 - 4, on a lattice 2 for n = 4 and 4 for 6. */
static void the_plate_solved_directly_needs_operators_of_order_six(void **state)
{
  (void)state;
  const double coarse = plate_directly(24, 4, 32), fourth = plate_directly(48, 4, 32);
  const double sixth = plate_directly(40, 6, 60);
  print_message(
      "plate, fourth derivatives: %.3e with n = 4 at N = 48 (order %.2f), %.3e with n = 6 "
      "at N = 40\n",
      fourth, log2(coarse / fourth), sixth);
  assert_true(fourth <= 4e-3 && log2(coarse / fourth) >= 1.7);
  assert_true(sixth <= 1e-5);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(poisson_by_collocation_converges_with_order_two),
      cmocka_unit_test(poisson_by_fourth_order_collocation_is_exact_to_half_a_millionth),
      cmocka_unit_test(the_first_order_functional_with_operator_energy_is_of_order_four),
      cmocka_unit_test(a_simply_supported_plate_bends_as_two_poisson_problems),
      cmocka_unit_test(the_plate_solved_directly_needs_operators_of_order_six),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
