/* nom: quadratic functionals and collocation as sparse systems. */
#include "linalg/solver.h"
#include "nom/assembly.h"
#include "support/grid.h"

#include <string.h>

typedef struct {
  grid g;
  grid_operators o;
  double *u; /* two components */
} body;

static void body_create(int cells, int order, int nearest, body *b)
{
  uint64_t seed = 21;
  grid_create(2, cells, 0.3, 1.0, &b->g);
  grid_operators_create(&b->g, order, nearest, SDR_INFLUENCE_GAUSSIAN, &b->o);
  b->u = sdr_alloc(2 * (size_t)b->g.count, sizeof *b->u);
  for (int32_t i = 0; i < 2 * b->g.count; ++i) b->u[i] = noise(&seed);
}

static void body_destroy(body *b)
{
  sdr_free(b->u);
  grid_operators_destroy(&b->o);
  grid_destroy(&b->g);
}

/* The functional itself, point by point. */
static double value_of(const body *b, const sdr_functional *functional)
{
  double sum = 0.0;
  for (int32_t i = 0; i < b->g.count; ++i)
    for (int n = 0; n < functional->count; ++n) {
      const sdr_quadratic_term *t = functional->term + n;
      sum += 0.5 * b->g.volume[i] * t->coefficient * (t->by_point ? t->by_point[i] : 1.0) *
             sdr_operator_at(&b->o.op, t->a, i, b->u + t->p * b->g.count) *
             sdr_operator_at(&b->o.op, t->b, i, b->u + t->q * b->g.count);
    }
  return sum;
}

static void assemble(const body *b, const sdr_functional *functional, sdr_csr *m)
{
  sdr_csr_builder *builder;
  const int32_t n = functional->fields * b->g.count;
  assert_int_equal(sdr_csr_builder_create(n, n, &builder), SDR_OK);
  if (sdr_functional_add(&b->o.op, functional, builder) != SDR_OK)
    fail_msg("%s", sdr_error_message());
  assert_int_equal(sdr_csr_builder_finish(builder, m), SDR_OK);
  sdr_csr_builder_destroy(&builder);
}

static double form_of(const sdr_csr *m, const double *u)
{
  double sum = 0.0;
  for (int32_t r = 0; r < m->rows; ++r)
    for (int64_t k = m->row[r]; k < m->row[r + 1]; ++k)
      sum += 0.5 * u[r] * m->value[k] * u[m->column[k]];
  return sum;
}

static double entry(const sdr_csr *m, int32_t r, int32_t c)
{
  for (int64_t k = m->row[r]; k < m->row[r + 1]; ++k)
    if (m->column[k] == c) return m->value[k];
  return 0.0;
}

static void expect_symmetric(const sdr_csr *m)
{
  for (int32_t r = 0; r < m->rows; ++r)
    for (int64_t k = m->row[r]; k < m->row[r + 1]; ++k)
      assert_near(entry(m, m->column[k], r), m->value[k], 1e-10 * fabs(entry(m, r, r)) + 1e-12);
}

static void a_scalar_functional_is_half_of_its_form(void **state)
{
  (void)state;
  body b;
  sdr_csr m;
  body_create(8, 2, 14, &b);
  const int x = grid_find(&b.o, "x"), y = grid_find(&b.o, "y"), xx = grid_find(&b.o, "xx");
  double *by_point = sdr_alloc((size_t)b.g.count, sizeof *by_point);
  for (int32_t i = 0; i < b.g.count; ++i) by_point[i] = 1.0 + b.g.x[0][i];
  const sdr_quadratic_term terms[] = {{x, 0, x, 0, 2.0, by_point},
                                      {y, 0, y, 0, 1.5, NULL},
                                      {x, 0, xx, 0, 0.3, NULL},
                                      {SDR_VALUE, 0, y, 0, -0.7, by_point},
                                      {SDR_VALUE, 0, SDR_VALUE, 0, 5.0, NULL}};
  const sdr_functional functional = {1, 5, terms};
  assemble(&b, &functional, &m);
  expect_symmetric(&m);
  const double value = value_of(&b, &functional);
  assert_near(form_of(&m, b.u), value, 1e-12 * fabs(value));
  sdr_csr_destroy(&m);
  sdr_free(by_point);
  body_destroy(&b);
}

/* Plane stress elasticity, nu = 1/4 and E = 15/16, so that the moduli are 1, 1/4 and 3/8. */
static void a_functional_of_a_vector_field_couples_its_components(void **state)
{
  (void)state;
  body b;
  sdr_csr m;
  body_create(8, 1, 8, &b);
  const int x = grid_find(&b.o, "x"), y = grid_find(&b.o, "y");
  const sdr_quadratic_term terms[] = {{x, 0, x, 0, 1.0, NULL},   {y, 1, y, 1, 1.0, NULL},
                                      {x, 0, y, 1, 0.5, NULL},   {y, 0, y, 0, 0.375, NULL},
                                      {x, 1, x, 1, 0.375, NULL}, {y, 0, x, 1, 0.75, NULL}};
  const sdr_functional functional = {2, 6, terms};
  assemble(&b, &functional, &m);
  expect_symmetric(&m);
  const double value = value_of(&b, &functional);
  assert_near(form_of(&m, b.u), value, 1e-12 * fabs(value));
  const int32_t n = b.g.count;
  for (int32_t i = 0; i < n; ++i) { /* a turn stores nothing */
    b.u[i] = -b.g.x[1][i];
    b.u[n + i] = b.g.x[0][i];
  }
  assert_near(form_of(&m, b.u), 0.0, 1e-12 * fabs(value));
  sdr_csr_destroy(&m);
  body_destroy(&b);
}

static void uncoupled_components_share_no_entries(void **state)
{
  (void)state;
  body b;
  sdr_csr m;
  body_create(6, 1, 8, &b);
  const sdr_quadratic_term terms[] = {{0, 0, 0, 0, 1.0, NULL}, {1, 1, 1, 1, 1.0, NULL}};
  const sdr_functional functional = {2, 2, terms};
  assemble(&b, &functional, &m);
  for (int32_t r = 0; r < m.rows; ++r)
    for (int64_t k = m.row[r]; k < m.row[r + 1]; ++k)
      assert_int_equal(m.column[k] / b.g.count, r / b.g.count);
  sdr_csr_destroy(&m);
  body_destroy(&b);
}

static void prescribed_unknowns_take_their_values_and_leave_the_matrix_symmetric(void **state)
{
  (void)state;
  body b;
  sdr_csr m;
  sdr_solver *solver;
  body_create(8, 2, 14, &b);
  const int32_t n = b.g.count;
  const sdr_quadratic_term terms[] = {
      {0, 0, 0, 0, 1.0, NULL}, {1, 0, 1, 0, 1.0, NULL}, {SDR_VALUE, 0, SDR_VALUE, 0, 1.0, NULL}};
  const sdr_functional functional = {1, 3, terms};
  double *f = sdr_alloc(4 * (size_t)n, sizeof *f), *x = f + n, *product = x + n;
  double *right = product + n;
  uint64_t seed = 2;
  for (int32_t i = 0; i < n; ++i) f[i] = right[i] = noise(&seed);
  assemble(&b, &functional, &m);
  assert_int_equal(sdr_fix_unknowns(&m, b.g.edge, b.u, f), SDR_OK);
  expect_symmetric(&m);
  assert_int_equal(sdr_solver_create("cholmod", SDR_MATRIX_POSITIVE, &solver), SDR_OK);
  assert_int_equal(sdr_solver_factor(solver, &m), SDR_OK);
  assert_int_equal(sdr_solver_solve(solver, f, x), SDR_OK);
  sdr_csr_destroy(&m);
  assemble(&b, &functional, &m);
  sdr_csr_times(&m, x, product);
  for (int32_t i = 0; i < n; ++i)
    if (b.g.edge[i])
      assert_near(x[i], b.u[i], 1e-12);
    else
      assert_near(product[i], right[i], 1e-9);
  sdr_solver_destroy(&solver);
  sdr_csr_destroy(&m);
  sdr_free(f);
  body_destroy(&b);
}

static void a_row_without_a_diagonal_cannot_be_prescribed(void **state)
{
  (void)state;
  sdr_csr_builder *builder;
  sdr_csr m;
  const uint8_t fixed[2] = {0, 1};
  const double value[2] = {0.0};
  double f[2] = {0.0};
  assert_int_equal(sdr_csr_builder_create(2, 2, &builder), SDR_OK);
  assert_int_equal(sdr_csr_builder_add(builder, 0, 1, 1.0), SDR_OK);
  assert_int_equal(sdr_csr_builder_add(builder, 1, 0, 1.0), SDR_OK);
  assert_int_equal(sdr_csr_builder_finish(builder, &m), SDR_OK);
  assert_int_equal(sdr_fix_unknowns(&m, fixed, value, f), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "unknown 1 cannot be prescribed: its row has no diagonal entry");
  sdr_csr_destroy(&m);
  sdr_csr_builder_destroy(&builder);
}

static void a_collocated_row_is_its_sum_of_derivatives(void **state)
{
  (void)state;
  body b;
  sdr_csr_builder *builder;
  sdr_csr m;
  body_create(8, 2, 14, &b);
  const int32_t n = b.g.count;
  const int xx = grid_find(&b.o, "xx"), yy = grid_find(&b.o, "yy"), x = grid_find(&b.o, "x");
  const sdr_term terms[] = {
      {xx, 0, 1.0}, {x, 1, -2.0}, {yy, 0, 3.0}, {SDR_VALUE, 0, 7.0}, {SDR_VALUE, 1, 0.5}};
  assert_int_equal(sdr_csr_builder_create(n, 2 * n, &builder), SDR_OK);
  for (int32_t i = 0; i < n; ++i)
    assert_int_equal(sdr_collocate(&b.o.op, i, 5, terms, n - 1 - i, builder), SDR_OK);
  assert_int_equal(sdr_csr_builder_finish(builder, &m), SDR_OK);
  double *product = sdr_alloc((size_t)n, sizeof *product);
  sdr_csr_times(&m, b.u, product);
  for (int32_t i = 0; i < n; ++i) {
    double expected = 0.0;
    for (int t = 0; t < 5; ++t)
      expected +=
          terms[t].coefficient * sdr_operator_at(&b.o.op, terms[t].a, i, b.u + terms[t].p * n);
    assert_near(product[n - 1 - i], expected, 1e-10);
  }
  sdr_free(product);
  sdr_csr_destroy(&m);
  sdr_csr_builder_destroy(&builder);
  body_destroy(&b);
}

static void wrong_terms_are_named(void **state)
{
  (void)state;
  body b;
  sdr_csr_builder *builder;
  body_create(6, 1, 8, &b);
  assert_int_equal(sdr_csr_builder_create(1, 1, &builder), SDR_OK);
  const sdr_quadratic_term terms[] = {{0, 0, 0, 0, 1.0, NULL}, {1, 0, 2, 0, 1.0, NULL}};
  sdr_functional functional = {1, 2, terms};
  assert_int_equal(sdr_functional_add(&b.o.op, &functional, builder), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "term 1 of a functional: derivatives are -1..1 and components 0..0, not 1 of "
                      "0 with 2 of 0");
  functional.fields = 0;
  assert_int_equal(sdr_functional_add(&b.o.op, &functional, builder), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "a functional of 0 components over 49 points: too few");
  functional.fields = INT32_MAX / 40;
  assert_int_equal(sdr_functional_add(&b.o.op, &functional, builder), SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), "too many unknowns"));
  const sdr_term wrong = {2, 0, 1.0};
  assert_int_equal(sdr_collocate(&b.o.op, 0, 1, &wrong, 0, builder), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "term 0 of an equation: derivatives are -1..1 and "
                                           "components from 0, not 2 of 0");
  sdr_csr_builder_destroy(&builder);
  body_destroy(&b);
}

static void no_memory_leaves_nothing_behind(void **state)
{
  (void)state;
  body b;
  sdr_csr_builder *builder;
  body_create(6, 1, 8, &b);
  const sdr_quadratic_term term = {0, 0, 0, 0, 1.0, NULL};
  const sdr_functional functional = {1, 1, &term};
  const size_t before = sdr_memory_now();
  assert_int_equal(sdr_csr_builder_create(b.g.count, b.g.count, &builder), SDR_OK);
  for (long passed = 0; passed < 3; ++passed) {
    sdr_memory_fail_after(passed);
    assert_int_equal(sdr_functional_add(&b.o.op, &functional, builder), SDR_RUN_FAILED);
  }
  sdr_memory_fail_after(-1);
  sdr_csr_builder_destroy(&builder);
  assert_int_equal(sdr_memory_now(), before);
  body_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_scalar_functional_is_half_of_its_form),
      cmocka_unit_test(a_functional_of_a_vector_field_couples_its_components),
      cmocka_unit_test(uncoupled_components_share_no_entries),
      cmocka_unit_test(prescribed_unknowns_take_their_values_and_leave_the_matrix_symmetric),
      cmocka_unit_test(a_row_without_a_diagonal_cannot_be_prescribed),
      cmocka_unit_test(a_collocated_row_is_its_sum_of_derivatives),
      cmocka_unit_test(wrong_terms_are_named),
      cmocka_unit_test(no_memory_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
