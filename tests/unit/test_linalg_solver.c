/* linalg: one contract for all linear solvers. */
#include "base/memory.h"
#include "linalg/solver.h"
#include "support/cmocka_all.h"
#include "support/noise.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const names[] = {"cholmod", "klu", "umfpack", "pcg", "auto"};
enum { NAMES = 5 };

static int takes(const char *name, sdr_matrix_kind kind)
{
  if (strcmp(name, "cholmod") == 0) return kind != SDR_MATRIX_GENERAL;
  return strcmp(name, "pcg") != 0 || kind == SDR_MATRIX_POSITIVE;
}

static void add(sdr_csr_builder *builder, int32_t row, int32_t column, double value)
{
  assert_int_equal(sdr_csr_builder_add(builder, row, column, value), SDR_OK);
}

/* Five-point Laplacian on n x n cells with `components` unknowns a cell, coupled by 1/4; `shift` is
   added to the diagonal, `wind` makes it unsymmetric. */
typedef struct {
  int32_t n, components;
  double edge, shift, wind; /* edge: 1: zero values beyond the edge; 0: no flow through it */
} grid;

static void add_link(sdr_csr_builder *builder, const grid *g, int32_t i, int32_t j, double wind)
{
  for (int32_t a = 0; a < g->components; ++a)
    for (int32_t b = 0; b < g->components; ++b) {
      const double share = a == b ? 1.0 : 0.25;
      add(builder, i * g->components + a, i * g->components + b, share);
      if (j >= 0) add(builder, i * g->components + a, j * g->components + b, -share + wind * share);
    }
}

static sdr_csr grid_matrix(const grid *g)
{
  const int32_t cells = g->n * g->n, rows = cells * g->components;
  sdr_csr_builder *builder = NULL;
  sdr_csr a = {0};
  assert_int_equal(sdr_csr_builder_create(rows, rows, &builder), SDR_OK);
  for (int32_t i = 0; i < cells; ++i) {
    static const int32_t steps[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    for (int k = 0; k < 4; ++k) {
      const int32_t x = i % g->n + steps[k][0], y = i / g->n + steps[k][1];
      const int inside = x >= 0 && x < g->n && y >= 0 && y < g->n;
      if (inside)
        add_link(builder, g, i, y * g->n + x, steps[k][0] > 0 ? g->wind : 0.0);
      else if (g->edge > 0.0)
        add_link(builder, g, i, -1, 0.0);
    }
  }
  for (int32_t r = 0; r < rows; ++r) add(builder, r, r, g->shift);
  assert_int_equal(sdr_csr_builder_finish(builder, &a), SDR_OK);
  sdr_csr_builder_destroy(&builder);
  return a;
}

static double *vector_of(int32_t count)
{
  double *v = sdr_alloc((size_t)count, sizeof *v);
  assert_non_null(v);
  return v;
}

/* Largest |x - wanted| over the largest |wanted|. */
static double error_of(const double *x, const double *wanted, int32_t count)
{
  double most = 0.0, whole = 0.0;
  for (int32_t k = 0; k < count; ++k) {
    if (!isfinite(x[k])) return INFINITY;
    most = fmax(most, fabs(x[k] - wanted[k]));
    whole = fmax(whole, fabs(wanted[k]));
  }
  return most / whole;
}

/* Solve for two right-hand sides with known answers, then factor once more and solve again. */
static void check_solver(const char *name, sdr_matrix_kind kind, const sdr_csr *a)
{
  sdr_solver *solver = NULL;
  double *wanted = vector_of(a->rows), *b = vector_of(a->rows), *x = vector_of(a->rows);
  uint64_t seed = 11;
  assert_int_equal(sdr_solver_create(name, kind, &solver), SDR_OK);
  for (int round = 0; round < 3; ++round) {
    if (round != 1) assert_int_equal(sdr_solver_factor(solver, a), SDR_OK);
    for (int32_t k = 0; k < a->rows; ++k) wanted[k] = noise(&seed);
    sdr_csr_times(a, wanted, b);
    memset(x, 0xff, (size_t)a->rows * sizeof *x); /* NAN: what was there must not matter */
    assert_int_equal(sdr_solver_solve(solver, b, x), SDR_OK);
    if (!(error_of(x, wanted, a->rows) < 1e-9))
      fail_msg("%s: error %g", name, error_of(x, wanted, a->rows));
    const sdr_solver_report report = sdr_solver_report_of(solver);
    assert_true(report.residual < 2e-12);
    assert_true(report.bytes >= 8.0 * a->rows);
    assert_int_equal(report.singular_row, -1);
    assert_int_equal(report.iterations > 0, strcmp(report.name, "pcg") == 0);
    if (strcmp(name, "auto") != 0) assert_string_equal(report.name, name);
  }
  sdr_solver_destroy(&solver);
  sdr_free(wanted);
  sdr_free(b);
  sdr_free(x);
}

static void check_all(const grid *g, sdr_matrix_kind kind)
{
  sdr_csr a = grid_matrix(g);
  for (int k = 0; k < NAMES; ++k)
    if (takes(names[k], kind)) check_solver(names[k], kind, &a);
  sdr_csr_destroy(&a);
}

static void each_solver_solves_a_positive_definite_system(void **state)
{
  (void)state;
  check_all(&(grid){.n = 12, .components = 1, .edge = 1.0}, SDR_MATRIX_POSITIVE);
  check_all(&(grid){.n = 40, .components = 3, .edge = 1.0}, SDR_MATRIX_POSITIVE);
  check_all(&(grid){.n = 40, .components = 7, .edge = 1.0}, SDR_MATRIX_POSITIVE);
}

/* Some eigenvalues below zero, none near it. */
static void each_solver_that_may_solves_an_indefinite_system(void **state)
{
  (void)state;
  check_all(&(grid){.n = 9, .components = 2, .edge = 1.0, .shift = -1.234}, SDR_MATRIX_SYMMETRIC);
  check_all(&(grid){.n = 30, .components = 2, .edge = 1.0, .shift = -1.234}, SDR_MATRIX_SYMMETRIC);
}

static void each_solver_that_may_solves_an_unsymmetric_system(void **state)
{
  (void)state;
  check_all(&(grid){.n = 9, .components = 1, .edge = 1.0, .wind = 0.7}, SDR_MATRIX_GENERAL);
  check_all(&(grid){.n = 40, .components = 2, .edge = 1.0, .wind = 0.7}, SDR_MATRIX_GENERAL);
}

/* [0 1; 1 0] and a saddle point: zeros on the diagonal. */
static void umfpack_and_klu_pivot(void **state)
{
  (void)state;
  static const double entry[4][4] = {{0, 1, 0, 2}, {1, 0, 3, 0}, {0, 3, 0, 1}, {2, 0, 1, 0}};
  sdr_csr_builder *builder = NULL;
  sdr_csr a = {0};
  assert_int_equal(sdr_csr_builder_create(4, 4, &builder), SDR_OK);
  for (int32_t r = 0; r < 4; ++r)
    for (int32_t c = 0; c < 4; ++c)
      if (entry[r][c] != 0.0) add(builder, r, c, entry[r][c]);
  assert_int_equal(sdr_csr_builder_finish(builder, &a), SDR_OK);
  sdr_csr_builder_destroy(&builder);
  check_solver("umfpack", SDR_MATRIX_SYMMETRIC, &a);
  check_solver("klu", SDR_MATRIX_GENERAL, &a);
  check_solver("auto", SDR_MATRIX_SYMMETRIC, &a);
  sdr_csr_destroy(&a);
}

static void a_system_of_one_unknown_is_solved(void **state)
{
  (void)state;
  check_all(&(grid){.n = 1, .components = 1, .edge = 1.0}, SDR_MATRIX_POSITIVE);
}

static void a_system_without_unknowns_has_nothing_to_solve(void **state)
{
  (void)state;
  int64_t start = 0;
  const sdr_csr a = {.row = &start};
  double nothing[2] = {0.0, 0.0};
  for (int k = 0; k < NAMES; ++k) {
    sdr_solver *solver = NULL;
    assert_int_equal(sdr_solver_create(names[k], SDR_MATRIX_POSITIVE, &solver), SDR_OK);
    assert_int_equal(sdr_solver_factor(solver, &a), SDR_OK);
    assert_int_equal(sdr_solver_solve(solver, nothing, nothing + 1), SDR_OK);
    sdr_solver_destroy(&solver);
  }
}

static void a_zero_right_hand_side_has_the_answer_zero(void **state)
{
  (void)state;
  sdr_csr a = grid_matrix(&(grid){.n = 6, .components = 2, .edge = 1.0});
  static const double b[72];
  double x[72];
  for (int k = 0; k < NAMES; ++k) {
    sdr_solver *solver = NULL;
    assert_int_equal(sdr_solver_create(names[k], SDR_MATRIX_POSITIVE, &solver), SDR_OK);
    assert_int_equal(sdr_solver_factor(solver, &a), SDR_OK);
    memset(x, 0xff, sizeof x);
    assert_int_equal(sdr_solver_solve(solver, b, x), SDR_OK);
    for (int r = 0; r < 72; ++r) assert_true(x[r] == 0.0);
    assert_true(sdr_solver_report_of(solver).residual == 0.0);
    sdr_solver_destroy(&solver);
  }
  sdr_csr_destroy(&a);
}

/* The same system with equations and unknowns in units that differ by 1e9. */
static void units_of_equations_and_unknowns_do_not_matter(void **state)
{
  (void)state;
  const grid g = {.n = 20, .components = 2, .edge = 1.0, .wind = 0.7};
  for (int symmetric = 0; symmetric < 2; ++symmetric) {
    sdr_csr a = grid_matrix(&g);
    for (int32_t r = 0; r < a.rows; ++r)
      for (int64_t k = a.row[r]; k < a.row[r + 1]; ++k)
        a.value[k] *= (r % 2 ? 1e-9 : 1.0) * (a.column[k] % 2 == symmetric ? 1e9 : 1.0);
    sdr_solver *solver = NULL;
    double *wanted = vector_of(a.rows), *b = vector_of(a.rows), *x = vector_of(a.rows);
    uint64_t seed = 17;
    for (int32_t k = 0; k < a.rows; ++k)
      wanted[k] = noise(&seed) * (k % 2 == symmetric ? 1e-9 : 1.0);
    sdr_csr_times(&a, wanted, b);
    for (int k = 1; k < 3; ++k) {
      assert_int_equal(sdr_solver_create(names[k], SDR_MATRIX_GENERAL, &solver), SDR_OK);
      assert_int_equal(sdr_solver_factor(solver, &a), SDR_OK);
      assert_int_equal(sdr_solver_solve(solver, b, x), SDR_OK);
      for (int32_t r = 0; r < a.rows; ++r)
        assert_true(fabs(x[r] - wanted[r]) <= 1e-6 * (r % 2 == symmetric ? 1e-9 : 1.0));
      sdr_solver_destroy(&solver);
    }
    sdr_free(wanted);
    sdr_free(b);
    sdr_free(x);
    sdr_csr_destroy(&a);
  }
}

/* ---- what goes wrong ------------------------------------------------------------------------- */

/* A body that nothing holds: constants are in the kernel. Rounding leaves the last pivot some
   1e-16, of either sign, and it must be seen all the same. */
static void a_singular_matrix_is_named_with_its_row(void **state)
{
  (void)state;
  for (int32_t n = 3; n <= 43; n += 20) {
    sdr_csr a = grid_matrix(&(grid){.n = n, .components = 2});
    for (int k = 0; k < NAMES; ++k) {
      sdr_solver *solver = NULL;
      if (strcmp(names[k], "pcg") == 0) continue;
      assert_int_equal(sdr_solver_create(names[k], SDR_MATRIX_POSITIVE, &solver), SDR_OK);
      assert_int_equal(sdr_solver_factor(solver, &a), SDR_RUN_FAILED);
      const sdr_solver_report report = sdr_solver_report_of(solver);
      char begins[96], wanted[96];
      snprintf(begins, sizeof begins, "the matrix of %d rows is singular", (int)a.rows);
      snprintf(wanted, sizeof wanted, " at row %d", (int)report.singular_row);
      assert_memory_equal(sdr_error_message(), begins, strlen(begins));
      assert_in_range(report.singular_row, 0, a.rows - 1);
      assert_non_null(strstr(sdr_error_message(), wanted));
      double x = 0.0;
      assert_int_equal(sdr_solver_solve(solver, &x, &x), SDR_RUN_FAILED);
      assert_string_equal(sdr_error_message(), "no matrix has been factored");
      sdr_solver_destroy(&solver);
    }
    sdr_csr_destroy(&a);
  }
}

/* One unknown that nothing holds, in the middle of a sound system: exactly that row. */
static void a_loose_unknown_is_found(void **state)
{
  (void)state;
  sdr_csr a = grid_matrix(&(grid){.n = 30, .components = 1, .edge = 1.0});
  const int32_t loose = 437;
  for (int32_t r = 0; r < a.rows; ++r)
    for (int64_t k = a.row[r]; k < a.row[r + 1]; ++k)
      if ((r == loose) != (a.column[k] == loose)) a.value[k] = 0.0;
  for (int64_t k = a.row[loose]; k < a.row[loose + 1]; ++k) a.value[k] = 0.0;
  for (int k = 0; k < NAMES; ++k) {
    sdr_solver *solver = NULL;
    assert_int_equal(sdr_solver_create(names[k], SDR_MATRIX_POSITIVE, &solver), SDR_OK);
    assert_int_equal(sdr_solver_factor(solver, &a), SDR_RUN_FAILED);
    assert_int_equal(sdr_solver_report_of(solver).singular_row, loose);
    assert_non_null(strstr(sdr_error_message(), "the matrix of 900 rows is singular"));
    assert_non_null(strstr(sdr_error_message(), "at row 437"));
    sdr_solver_destroy(&solver);
  }
  sdr_csr_destroy(&a);
}

static void pcg_says_that_a_matrix_is_not_positive(void **state)
{
  (void)state;
  sdr_csr a = grid_matrix(&(grid){.n = 20, .components = 1, .edge = 1.0, .shift = -2.0});
  double *b = vector_of(a.rows), *x = vector_of(a.rows);
  uint64_t seed = 2;
  for (int32_t k = 0; k < a.rows; ++k) b[k] = noise(&seed);
  sdr_solver *solver = NULL;
  assert_int_equal(sdr_solver_create("pcg", SDR_MATRIX_POSITIVE, &solver), SDR_OK);
  assert_int_equal(sdr_solver_factor(solver, &a), SDR_OK);
  assert_int_equal(sdr_solver_solve(solver, b, x), SDR_RUN_FAILED);
  assert_string_equal(sdr_error_message(),
                      "the matrix of 400 rows is singular or not positive definite");
  sdr_solver_destroy(&solver);
  assert_int_equal(sdr_solver_create("cholmod", SDR_MATRIX_POSITIVE, &solver), SDR_OK);
  assert_int_equal(sdr_solver_factor(solver, &a), SDR_RUN_FAILED);
  assert_non_null(strstr(sdr_error_message(), "singular or not positive definite at row "));
  sdr_solver_destroy(&solver);
  sdr_free(b);
  sdr_free(x);
  sdr_csr_destroy(&a);
}

static void a_name_that_does_not_fit_is_refused(void **state)
{
  (void)state;
  sdr_solver *solver = NULL;
  assert_int_equal(sdr_solver_create("mumps", SDR_MATRIX_POSITIVE, &solver), SDR_BAD_INPUT);
  assert_string_equal(
      sdr_error_message(),
      "there is no linear solver 'mumps'; choose auto, cholmod, klu, umfpack or pcg");
  assert_int_equal(sdr_solver_create("pcg", SDR_MATRIX_SYMMETRIC, &solver), SDR_BAD_INPUT);
  assert_string_equal(
      sdr_error_message(),
      "the linear solver 'pcg' does not take a symmetric matrix; choose auto or umfpack");
  assert_int_equal(sdr_solver_create("cholmod", SDR_MATRIX_GENERAL, &solver), SDR_BAD_INPUT);
  assert_null(solver);
  sdr_solver_destroy(&solver); /* NULL-safe */
}

static void a_matrix_that_is_not_square_is_refused(void **state)
{
  (void)state;
  sdr_solver *solver = NULL;
  const sdr_csr a = {.rows = 2, .columns = 3};
  assert_int_equal(sdr_solver_create("auto", SDR_MATRIX_GENERAL, &solver), SDR_OK);
  assert_int_equal(sdr_solver_factor(solver, &a), SDR_RUN_FAILED);
  assert_string_equal(sdr_error_message(),
                      "a matrix of 2 x 3 cannot be solved with: it is not square");
  sdr_solver_destroy(&solver);
}

/* Whichever allocation of ours fails, nothing leaks. */
static void a_failed_allocation_leaves_nothing_behind(void **state)
{
  (void)state;
  sdr_csr a = grid_matrix(&(grid){.n = 24, .components = 1, .edge = 1.0});
  const size_t before = sdr_memory_now();
  for (int k = 0; k < NAMES; ++k) {
    int finished = 0;
    for (long successes = 0; successes < 60 && !finished; ++successes) {
      sdr_solver *solver = NULL;
      sdr_memory_fail_after(successes);
      sdr_status status = sdr_solver_create(names[k], SDR_MATRIX_POSITIVE, &solver);
      if (status == SDR_OK) status = sdr_solver_factor(solver, &a);
      sdr_memory_fail_after(-1);
      finished = status == SDR_OK;
      if (!finished) assert_int_equal(status, SDR_RUN_FAILED);
      if (!finished) assert_non_null(strstr(sdr_error_message(), "out of memory"));
      sdr_solver_destroy(&solver);
      assert_int_equal(sdr_memory_now(), before);
    }
    assert_true(finished);
  }
  sdr_csr_destroy(&a);
}

/* ---- again and again ------------------------------------------------------------------------- */

static void check_refactored(const char *name)
{
  const grid first = {.n = 25, .components = 2, .edge = 1.0};
  const grid second = {.n = 25, .components = 2, .edge = 1.0, .shift = 0.7};
  sdr_csr a = grid_matrix(&first), b = grid_matrix(&second);
  sdr_solver *again = NULL, *anew = NULL;
  double *right = vector_of(a.rows), *x = vector_of(a.rows), *wanted = vector_of(a.rows);
  uint64_t seed = 3;
  for (int32_t k = 0; k < a.rows; ++k) right[k] = noise(&seed);
  assert_int_equal(sdr_solver_create(name, SDR_MATRIX_POSITIVE, &again), SDR_OK);
  assert_int_equal(sdr_solver_create(name, SDR_MATRIX_POSITIVE, &anew), SDR_OK);
  assert_int_equal(sdr_solver_factor(anew, &b), SDR_OK);
  assert_int_equal(sdr_solver_solve(anew, right, wanted), SDR_OK);
  assert_int_equal(sdr_solver_factor(again, &a), SDR_OK);
  for (int round = 0; round < 3; ++round) {
    assert_int_equal(sdr_solver_refactor(again, &a), SDR_OK);
    assert_int_equal(sdr_solver_refactor(again, &b), SDR_OK);
    assert_int_equal(sdr_solver_solve(again, right, x), SDR_OK);
    assert_memory_equal(x, wanted, (size_t)a.rows * sizeof *x);
  }
  sdr_solver_destroy(&again);
  sdr_solver_destroy(&anew);
  sdr_csr_destroy(&a);
  sdr_csr_destroy(&b);
  sdr_free(right);
  sdr_free(x);
  sdr_free(wanted);
}

static void a_factor_of_the_same_pattern_gives_the_same_bits(void **state)
{
  (void)state;
  for (int k = 0; k < NAMES; ++k) check_refactored(names[k]);
}

static void a_factor_that_failed_is_tried_again_with_other_values(void **state)
{
  (void)state;
  const grid good = {.n = 25, .components = 1, .edge = 1.0};
  const grid bad = {.n = 25, .components = 1, .edge = 1.0, .shift = -1.234};
  sdr_csr a = grid_matrix(&good), b = grid_matrix(&bad), smaller = grid_matrix(&(grid){.n = 2});
  sdr_solver *solver = NULL;
  double *right = vector_of(a.rows), *x = vector_of(a.rows);
  right[7] = 1.0;
  assert_int_equal(sdr_solver_create("cholmod", SDR_MATRIX_POSITIVE, &solver), SDR_OK);
  assert_int_equal(sdr_solver_refactor(solver, &a), SDR_RUN_FAILED);
  assert_int_equal(sdr_solver_factor(solver, &b), SDR_RUN_FAILED);
  assert_int_equal(sdr_solver_solve(solver, right, x), SDR_RUN_FAILED);
  assert_int_equal(sdr_solver_refactor(solver, &a), SDR_OK);
  assert_int_equal(sdr_solver_solve(solver, right, x), SDR_OK);
  assert_int_equal(sdr_solver_refactor(solver, &smaller), SDR_RUN_FAILED);
  assert_string_equal(sdr_error_message(),
                      "a matrix of 0 rows cannot be factored again: the last had 625");
  sdr_solver_destroy(&solver);
  sdr_csr_destroy(&a);
  sdr_csr_destroy(&b);
  sdr_csr_destroy(&smaller);
  sdr_free(right);
  sdr_free(x);
}

/* Direct solvers: the inverse itself, also where the matrix has changed since. pcg: symmetric,
   positive, and of diagonal blocks the inverse. */
static void a_solver_preconditions(void **state)
{
  (void)state;
  const grid g = {.n = 15, .components = 2, .edge = 1.0};
  for (int k = 0; k < NAMES; ++k) {
    sdr_csr a = grid_matrix(&g);
    sdr_solver *solver = NULL;
    double *right = vector_of(a.rows), *x = vector_of(a.rows), *y = vector_of(a.rows);
    uint64_t seed = 5;
    for (int32_t r = 0; r < a.rows; ++r) right[r] = noise(&seed);
    assert_int_equal(sdr_solver_create(names[k], SDR_MATRIX_POSITIVE, &solver), SDR_OK);
    assert_int_equal(sdr_solver_precondition(solver, right, x), SDR_RUN_FAILED);
    assert_int_equal(sdr_solver_factor(solver, &a), SDR_OK);
    assert_int_equal(sdr_solver_precondition(solver, right, x), SDR_OK);
    for (int64_t p = 0; p < a.row[a.rows]; ++p) a.value[p] *= 2.0;
    if (strcmp(names[k], "pcg") != 0) {
      sdr_csr_times(&a, x, y);
      for (int32_t r = 0; r < a.rows; ++r) assert_true(fabs(y[r] - 2.0 * right[r]) < 1e-12);
      assert_int_equal(sdr_solver_precondition(solver, right, y), SDR_OK);
      assert_true(error_of(y, x, a.rows) < 1e-12);
    } else { /* blocks of 4 and 1 */
      for (int32_t r = 0; r < a.rows; ++r)
        assert_true(fabs(4.0 * x[r] + x[r ^ 1] - right[r]) < 1e-14);
    }
    sdr_solver_destroy(&solver);
    sdr_csr_destroy(&a);
    sdr_free(right);
    sdr_free(x);
    sdr_free(y);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_solver_solves_a_positive_definite_system),
      cmocka_unit_test(each_solver_that_may_solves_an_indefinite_system),
      cmocka_unit_test(each_solver_that_may_solves_an_unsymmetric_system),
      cmocka_unit_test(umfpack_and_klu_pivot),
      cmocka_unit_test(a_system_of_one_unknown_is_solved),
      cmocka_unit_test(a_system_without_unknowns_has_nothing_to_solve),
      cmocka_unit_test(a_zero_right_hand_side_has_the_answer_zero),
      cmocka_unit_test(units_of_equations_and_unknowns_do_not_matter),
      cmocka_unit_test(a_singular_matrix_is_named_with_its_row),
      cmocka_unit_test(a_loose_unknown_is_found),
      cmocka_unit_test(pcg_says_that_a_matrix_is_not_positive),
      cmocka_unit_test(a_name_that_does_not_fit_is_refused),
      cmocka_unit_test(a_matrix_that_is_not_square_is_refused),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
      cmocka_unit_test(a_factor_of_the_same_pattern_gives_the_same_bits),
      cmocka_unit_test(a_factor_that_failed_is_tried_again_with_other_values),
      cmocka_unit_test(a_solver_preconditions),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
