/* nom: derivatives of every multi-index, by row weights and matrix-free. */
#include "base/parallel.h"
#include "support/grid.h"

#include <string.h>

/* A polynomial with all monomials up to an order, 1 among them. */
typedef struct {
  sdr_multi_indices set;
  double constant, factor[SDR_MOST_TERMS];
} polynomial;

static double falling(double x, int power, int times)
{
  double value = 1.0;
  for (int k = 0; k < times; ++k) value *= power - k;
  if (times > power) return 0.0;
  for (int k = 0; k < power - times; ++k) value *= x;
  return value;
}

/* D_a of the polynomial at point i; a = SDR_VALUE: its value. */
static double exact(const polynomial *f, const grid *g, int32_t i, int a)
{
  double sum = a == SDR_VALUE ? f->constant : 0.0;
  for (int k = 0; k < f->set.count; ++k) {
    double term = f->factor[k];
    for (int c = 0; c < g->components; ++c)
      term *= falling(g->x[c][i], f->set.power[k][c], a == SDR_VALUE ? 0 : f->set.power[a][c]);
    sum += term;
  }
  return sum;
}

static double *sample(int components, int order, const grid *g, polynomial *f)
{
  uint64_t seed = 5;
  assert_int_equal(sdr_multi_indices_of(components, order, &f->set), SDR_OK);
  f->constant = noise(&seed);
  for (int k = 0; k < f->set.count; ++k) f->factor[k] = noise(&seed);
  double *u = sdr_alloc((size_t)g->count, sizeof *u);
  for (int32_t i = 0; i < g->count; ++i) u[i] = exact(f, g, i, SDR_VALUE);
  return u;
}

/* Largest error of all derivatives, each relative to what values of size 1 make of it: a!/h^|a|. */
static double largest_error(const grid *g, const grid_operators *o, const polynomial *f,
                            const double *u)
{
  double largest = 0.0;
  for (int a = 0; a < o->op.terms; ++a)
    for (int32_t i = 0; i < g->count; ++i) {
      const double scale = f->set.factorial[a] / pow(o->support.radius[i], f->set.degree[a]);
      const double error = sdr_operator_at(&o->op, a, i, u) - exact(f, g, i, a);
      largest = fmax(largest, fabs(error) / scale);
    }
  return largest;
}

static const int cells_of[3] = {40, 12, 6};
static const int nearest_of[3][6] = {
    {4, 6, 8, 10, 12, 14}, {8, 14, 22, 32, 44, 60}, {12, 30, 50, 90, 120, 160}};

static void polynomials_up_to_the_order_are_exact_on_any_points(void **state)
{
  (void)state;
  for (int d = 1; d <= 3; ++d)
    for (int order = 1; order <= (d == 3 ? 4 : 6); ++order) {
      grid g;
      grid_operators o;
      polynomial f;
      grid_create(d, cells_of[d - 1], 0.4, 1.0, &g);
      grid_operators_create(&g, order, nearest_of[d - 1][order - 1], SDR_INFLUENCE_GAUSSIAN, &o);
      double *u = sample(d, order, &g, &f);
      assert_true(largest_error(&g, &o, &f, u) < 1e-10);
      sdr_free(u);
      grid_operators_destroy(&o);
      grid_destroy(&g);
    }
}

static void gradients_are_exact_to_eleven_digits(void **state)
{
  (void)state;
  for (int d = 1; d <= 3; ++d)
    for (int order = 1; order <= 2; ++order) {
      grid g;
      grid_operators o;
      polynomial f;
      grid_create(d, cells_of[d - 1], 0.4, 1.0, &g);
      grid_operators_create(&g, order, nearest_of[d - 1][order - 1], SDR_INFLUENCE_CONSTANT, &o);
      double *u = sample(d, 1, &g, &f);
      for (int a = 0; a < d; ++a)
        for (int32_t i = 0; i < g.count; ++i)
          assert_near(sdr_operator_at(&o.op, a, i, u), f.factor[a], 1e-11);
      sdr_free(u);
      grid_operators_destroy(&o);
      grid_destroy(&g);
    }
}

static void every_weight_is_exact(void **state)
{
  (void)state;
  for (int w = 0; w < SDR_INFLUENCES; ++w) {
    grid g;
    grid_operators o;
    polynomial f;
    grid_create(2, 12, 0.3, 1.0, &g);
    grid_operators_create(&g, 2, 20, (sdr_influence)w, &o);
    double *u = sample(2, 2, &g, &f);
    assert_true(largest_error(&g, &o, &f, u) < 1e-12);
    sdr_free(u);
    grid_operators_destroy(&o);
    grid_destroy(&g);
  }
}

/* One degree beyond the order there is an error, so the tests above can fail. */
static void polynomials_beyond_the_order_are_not_exact(void **state)
{
  (void)state;
  grid g;
  grid_operators o;
  polynomial f;
  grid_create(2, 12, 0.3, 1.0, &g);
  grid_operators_create(&g, 2, 14, SDR_INFLUENCE_GAUSSIAN, &o);
  double *u = sample(2, 3, &g, &f);
  assert_true(largest_error(&g, &o, &f, u) > 1e-5);
  sdr_free(u);
  grid_operators_destroy(&o);
  grid_destroy(&g);
}

static double *wavy(const grid *g)
{
  double *u = sdr_alloc((size_t)g->count, sizeof *u);
  for (int32_t i = 0; i < g->count; ++i) {
    u[i] = 1.0;
    for (int a = 0; a < g->components; ++a) u[i] += sin(3.0 * g->x[a][i] + a) * (1.0 + 0.3 * u[i]);
  }
  return u;
}

/* One derivative of u in the three ways; out: three fields of scratch. */
static void compare_ways(const grid *g, const grid_operators *o, int a, const double *u,
                         double *const out[3])
{
  sdr_csr matrix;
  const int degree = a == SDR_VALUE ? 0 : o->shape.set.degree[a];
  const double most = 1e-10 * pow(g->cells, degree);
  sdr_operator_apply(&o->op, a, u, out[0]);
  sdr_derivative(&o->shape, a, u, out[1]);
  assert_int_equal(sdr_operator_matrix(&o->op, a, &matrix), SDR_OK);
  sdr_csr_times(&matrix, u, out[2]);
  sdr_csr_destroy(&matrix);
  for (int32_t i = 0; i < g->count; ++i) {
    assert_near(out[1][i], out[0][i], most);
    assert_near(out[2][i], out[0][i], most);
  }
}

static void matrix_free_rows_and_matrices_give_the_same(void **state)
{
  (void)state;
  for (int d = 1; d <= 3; ++d) {
    grid g;
    grid_operators o;
    double *out[3];
    grid_create(d, cells_of[d - 1], 0.3, 1.0, &g);
    grid_operators_create(&g, 3, nearest_of[d - 1][2], SDR_INFLUENCE_GAUSSIAN, &o);
    double *u = wavy(&g);
    for (int k = 0; k < 3; ++k) out[k] = sdr_alloc((size_t)g.count, sizeof(double));
    for (int a = SDR_VALUE; a < o.op.terms; ++a) compare_ways(&g, &o, a, u, out);
    for (int k = 0; k < 3; ++k) sdr_free(out[k]);
    sdr_free(u);
    grid_operators_destroy(&o);
    grid_destroy(&g);
  }
}

static void all_derivatives_at_a_point_are_those_of_each_field(void **state)
{
  (void)state;
  grid g;
  grid_operators o;
  double all[SDR_MOST_TERMS];
  grid_create(2, 12, 0.3, 1.0, &g);
  grid_operators_create(&g, 3, 22, SDR_INFLUENCE_GAUSSIAN, &o);
  double *u = wavy(&g), *one = sdr_alloc((size_t)g.count, sizeof *one);
  for (int a = 0; a < o.op.terms; ++a) {
    sdr_derivative(&o.shape, a, u, one);
    for (int32_t i = 0; i < g.count; ++i) {
      sdr_derivatives_at(&o.shape, i, u, all);
      assert_true(all[a] == one[i]);
    }
  }
  sdr_free(u);
  sdr_free(one);
  grid_operators_destroy(&o);
  grid_destroy(&g);
}

static void matrices_hold_ascending_columns_and_rows_that_sum_to_zero(void **state)
{
  (void)state;
  grid g;
  grid_operators o;
  sdr_csr m;
  grid_create(2, 8, 0.2, 1.0, &g);
  grid_operators_create(&g, 2, 14, SDR_INFLUENCE_GAUSSIAN, &o);
  assert_int_equal(sdr_operator_matrix(&o.op, grid_find(&o, "xy"), &m), SDR_OK);
  assert_int_equal(m.row[m.rows], o.support.row[g.count] + g.count);
  for (int32_t i = 0; i < m.rows; ++i) {
    double sum = 0.0;
    int own = 0;
    for (int64_t k = m.row[i]; k < m.row[i + 1]; ++k) {
      assert_true(k == m.row[i] || m.column[k] > m.column[k - 1]);
      own += m.column[k] == i;
      sum += m.value[k];
    }
    assert_int_equal(own, 1);
    assert_near(sum, 0.0, 1e-10);
  }
  sdr_csr_destroy(&m);
  grid_operators_destroy(&o);
  grid_destroy(&g);
}

static void constants_have_no_derivative_at_all(void **state)
{
  (void)state;
  grid g;
  grid_operators o;
  grid_create(2, 8, 0.3, 1.0, &g);
  grid_operators_create(&g, 2, 14, SDR_INFLUENCE_GAUSSIAN, &o);
  double *u = sdr_alloc((size_t)g.count, sizeof *u);
  for (int32_t i = 0; i < g.count; ++i) u[i] = 1234.5678;
  for (int a = 0; a < o.op.terms; ++a)
    for (int32_t i = 0; i < g.count; ++i) {
      double all[SDR_MOST_TERMS];
      sdr_derivatives_at(&o.shape, i, u, all);
      assert_true(sdr_operator_at(&o.op, a, i, u) == 0.0 && all[a] == 0.0);
    }
  sdr_free(u);
  grid_operators_destroy(&o);
  grid_destroy(&g);
}

/* Lengths and volumes in other units: weights scale as 1/length^|a|, whatever the volumes'. */
static void units_do_not_matter(void **state)
{
  (void)state;
  grid g, small;
  grid_operators o, p;
  grid_create(2, 8, 0.3, 1.0, &g);
  grid_create(2, 8, 0.3, 1e-6, &small);
  for (int32_t i = 0; i < g.count; ++i) small.volume[i] *= 1e-9;
  grid_operators_create(&g, 3, 22, SDR_INFLUENCE_GAUSSIAN, &o);
  grid_operators_create(&small, 3, 22, SDR_INFLUENCE_GAUSSIAN, &p);
  for (int64_t k = 0; k < o.support.row[g.count]; ++k)
    for (int a = 0; a < o.op.terms; ++a) {
      const double scaled = p.op.weight[k * 9 + a] * pow(1e-6, o.shape.set.degree[a]);
      assert_near(scaled, o.op.weight[k * 9 + a], 1e-9 * pow(8.0, o.shape.set.degree[a]));
    }
  grid_operators_destroy(&o);
  grid_operators_destroy(&p);
  grid_destroy(&g);
  grid_destroy(&small);
}

static void any_number_of_threads_gives_the_same_bits(void **state)
{
  (void)state;
  const int threads = sdr_threads();
  grid g;
  grid_operators one, three;
  grid_create(2, 25, 0.3, 1.0, &g);
  sdr_set_threads(1);
  grid_operators_create(&g, 3, 22, SDR_INFLUENCE_GAUSSIAN, &one);
  sdr_set_threads(3);
  grid_operators_create(&g, 3, 22, SDR_INFLUENCE_GAUSSIAN, &three);
  sdr_set_threads(threads);
  const size_t entries = (size_t)one.support.row[g.count] * 9;
  assert_memory_equal(one.op.weight, three.op.weight, entries * sizeof(double));
  assert_memory_equal(one.shape.condition, three.shape.condition, (size_t)g.count * sizeof(double));
  grid_operators_destroy(&one);
  grid_operators_destroy(&three);
  grid_destroy(&g);
}

static void no_memory_leaves_nothing_behind(void **state)
{
  (void)state;
  grid g;
  grid_operators o;
  sdr_operator op;
  sdr_csr m;
  grid_create(2, 6, 0.2, 1.0, &g);
  grid_operators_create(&g, 2, 14, SDR_INFLUENCE_GAUSSIAN, &o);
  const size_t before = sdr_memory_now();
  for (long passed = 0; passed < 2; ++passed) {
    sdr_memory_fail_after(passed);
    assert_int_equal(sdr_operator_create(&o.shape, &op), SDR_RUN_FAILED);
    assert_int_equal(sdr_operator_matrix(&o.op, 0, &m), SDR_RUN_FAILED);
    sdr_memory_fail_after(passed + 1);
    assert_int_equal(sdr_operator_matrix(&o.op, 0, &m), SDR_RUN_FAILED);
    sdr_memory_fail_after(-1);
    assert_int_equal(sdr_memory_now(), before);
  }
  grid_operators_destroy(&o);
  grid_destroy(&g);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(polynomials_up_to_the_order_are_exact_on_any_points),
      cmocka_unit_test(gradients_are_exact_to_eleven_digits),
      cmocka_unit_test(every_weight_is_exact),
      cmocka_unit_test(polynomials_beyond_the_order_are_not_exact),
      cmocka_unit_test(matrix_free_rows_and_matrices_give_the_same),
      cmocka_unit_test(all_derivatives_at_a_point_are_those_of_each_field),
      cmocka_unit_test(matrices_hold_ascending_columns_and_rows_that_sum_to_zero),
      cmocka_unit_test(constants_have_no_derivative_at_all),
      cmocka_unit_test(units_do_not_matter),
      cmocka_unit_test(any_number_of_threads_gives_the_same_bits),
      cmocka_unit_test(no_memory_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
