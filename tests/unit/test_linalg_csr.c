/* linalg: sparse matrices summed up from entries. */
#include "base/memory.h"
#include "base/parallel.h"
#include "linalg/csr.h"
#include "support/cmocka_all.h"
#include "support/noise.h"

#include <math.h>
#include <string.h>

static sdr_csr_builder *builder_of(int32_t rows, int32_t columns)
{
  sdr_csr_builder *builder = NULL;
  assert_int_equal(sdr_csr_builder_create(rows, columns, &builder), SDR_OK);
  return builder;
}

static void entries_at_one_place_are_summed_and_columns_ascend(void **state)
{
  (void)state;
  enum { ROWS = 41, COLUMNS = 23, ENTRIES = 3000 };
  static double dense[ROWS][COLUMNS];
  memset(dense, 0, sizeof dense);
  sdr_csr_builder *builder = builder_of(ROWS, COLUMNS);
  sdr_csr a = {0};
  uint64_t seed = 5;
  for (int k = 0; k < ENTRIES; ++k) {
    const int32_t r = (int32_t)(20.0 * (1.0 + noise(&seed))); /* row 40 stays empty */
    const int32_t c = (int32_t)(11.5 * (1.0 + noise(&seed)));
    const double value = noise(&seed);
    assert_int_equal(sdr_csr_builder_add(builder, r, c, value), SDR_OK);
    dense[r][c] += value;
  }
  assert_int_equal(sdr_csr_builder_finish(builder, &a), SDR_OK);
  sdr_csr_builder_destroy(&builder);
  int64_t seen = 0;
  for (int32_t r = 0; r < ROWS; ++r)
    for (int64_t k = a.row[r]; k < a.row[r + 1]; ++k, ++seen) {
      if (k > a.row[r]) assert_true(a.column[k] > a.column[k - 1]);
      /* same order of summation, so the same bits */
      assert_true(a.value[k] == dense[r][a.column[k]]);
      dense[r][a.column[k]] = 0.0;
    }
  for (int r = 0; r < ROWS; ++r)
    for (int c = 0; c < COLUMNS; ++c) assert_true(dense[r][c] == 0.0);
  assert_int_equal(seen, a.row[ROWS]);
  sdr_csr_destroy(&a);
  assert_null(a.value);
}

/* More entries than one block of the builder holds. */
static void many_entries_make_the_same_matrix(void **state)
{
  (void)state;
  enum { ROWS = 1000, TIMES = 700 };
  const size_t before = sdr_memory_now();
  sdr_csr_builder *builder = builder_of(ROWS, ROWS);
  sdr_csr a = {0};
  for (int t = 0; t < TIMES; ++t)
    for (int32_t r = 0; r < ROWS; ++r)
      assert_int_equal(sdr_csr_builder_add(builder, r, (r + t % 3) % ROWS, 1.0), SDR_OK);
  assert_int_equal(sdr_csr_builder_finish(builder, &a), SDR_OK);
  assert_int_equal(a.row[ROWS], 3 * ROWS);
  double sum = 0.0;
  for (int64_t k = 0; k < a.row[ROWS]; ++k) sum += a.value[k];
  assert_true(sum == (double)ROWS * TIMES);
  sdr_csr_builder_destroy(&builder);
  sdr_csr_destroy(&a);
  assert_int_equal(sdr_memory_now(), before);
}

static void a_matrix_without_entries_is_zero(void **state)
{
  (void)state;
  sdr_csr_builder *builder = builder_of(3, 2);
  sdr_csr a = {0};
  assert_int_equal(sdr_csr_builder_finish(builder, &a), SDR_OK);
  sdr_csr_builder_destroy(&builder);
  const double x[2] = {1.0, 2.0};
  double y[3] = {9.0, 9.0, 9.0};
  sdr_csr_times(&a, x, y);
  for (int r = 0; r < 3; ++r) assert_true(y[r] == 0.0);
  sdr_csr_destroy(&a);
}

static void an_entry_outside_is_refused(void **state)
{
  (void)state;
  sdr_csr_builder *builder = builder_of(3, 2);
  assert_int_equal(sdr_csr_builder_add(builder, 2, 2, 1.0), SDR_RUN_FAILED);
  assert_string_equal(sdr_error_message(), "the entry (2, 2) lies outside a matrix of 3 x 2");
  assert_int_equal(sdr_csr_builder_add(builder, -1, 0, 1.0), SDR_RUN_FAILED);
  assert_int_equal(sdr_csr_builder_add(builder, 3, 0, 1.0), SDR_RUN_FAILED);
  sdr_csr_builder_destroy(&builder);
  sdr_csr_builder_destroy(&builder); /* NULL-safe */
}

static void a_product_has_the_same_bits_on_any_number_of_threads(void **state)
{
  (void)state;
  enum { ROWS = 9000 };
  sdr_csr_builder *builder = builder_of(ROWS, ROWS);
  sdr_csr a = {0};
  uint64_t seed = 3;
  for (int32_t r = 0; r < ROWS; ++r)
    for (int k = 0; k < 7; ++k)
      assert_int_equal(
          sdr_csr_builder_add(builder, r, (int32_t)(0.5 * ROWS * (1.0 + noise(&seed))), 1.0 / 3),
          SDR_OK);
  assert_int_equal(sdr_csr_builder_finish(builder, &a), SDR_OK);
  sdr_csr_builder_destroy(&builder);
  static double x[ROWS], y[3][ROWS];
  for (int k = 0; k < ROWS; ++k) x[k] = noise(&seed);
  for (int threads = 1; threads <= 3; ++threads) {
    sdr_set_threads(threads);
    sdr_csr_times(&a, x, y[threads - 1]);
  }
  assert_memory_equal(y[0], y[1], sizeof y[0]);
  assert_memory_equal(y[0], y[2], sizeof y[0]);
  double sum = 0.0;
  for (int64_t k = a.row[8999]; k < a.row[9000]; ++k) sum += a.value[k] * x[a.column[k]];
  assert_true(sum == y[0][8999]);
  sdr_csr_destroy(&a);
}

/* Whichever allocation fails, nothing leaks and nothing is written. */
static void a_failed_allocation_leaves_nothing_behind(void **state)
{
  (void)state;
  int finished = 0;
  for (long successes = 0; successes < 20 && !finished; ++successes) {
    const size_t before = sdr_memory_now();
    sdr_csr_builder *builder = NULL;
    sdr_csr a = {0};
    sdr_memory_fail_after(successes);
    sdr_status status = sdr_csr_builder_create(4, 4, &builder);
    if (status == SDR_OK) status = sdr_csr_builder_add(builder, 1, 1, 1.0);
    if (status == SDR_OK) status = sdr_csr_builder_finish(builder, &a);
    sdr_memory_fail_after(-1);
    finished = status == SDR_OK;
    if (!finished) assert_int_equal(status, SDR_RUN_FAILED);
    if (!finished) assert_null(a.row);
    sdr_csr_builder_destroy(&builder);
    sdr_csr_destroy(&a);
    assert_int_equal(sdr_memory_now(), before);
  }
  assert_true(finished);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(entries_at_one_place_are_summed_and_columns_ascend),
      cmocka_unit_test(many_entries_make_the_same_matrix),
      cmocka_unit_test(a_matrix_without_entries_is_zero),
      cmocka_unit_test(an_entry_outside_is_refused),
      cmocka_unit_test(a_product_has_the_same_bits_on_any_number_of_threads),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
