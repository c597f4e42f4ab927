/* base: errors, memory, parallel loops. */
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "support/cmocka_all.h"

#include <string.h>

static void the_message_may_quote_the_message_before_it(void **state)
{
  (void)state;
  assert_int_equal(sdr_fail(SDR_BAD_INPUT, "spacing %d", 3), SDR_BAD_INPUT);
  sdr_fail(SDR_IO_ERROR, "scene: %s", sdr_error_message());
  assert_string_equal(sdr_error_message(), "scene: spacing 3");
}

static void a_block_is_zero_aligned_and_counted(void **state)
{
  (void)state;
  const size_t before = sdr_memory_now();
  unsigned char *block = sdr_alloc(100, 3);
  assert_non_null(block);
  assert_int_equal((uintptr_t)block % 64, 0);
  for (int k = 0; k < 300; ++k) assert_int_equal(block[k], 0);
  assert_int_equal(sdr_memory_now() - before, 300);
  sdr_free(block);
  assert_int_equal(sdr_memory_now(), before);
  assert_true(sdr_memory_peak() >= before + 300);
}

static void a_size_that_overflows_is_refused(void **state)
{
  (void)state;
  assert_null(sdr_alloc(SIZE_MAX / 4, 8));
  assert_non_null(strstr(sdr_error_message(), "overflow"));
}

static void growing_keeps_the_content(void **state)
{
  (void)state;
  int *block = sdr_alloc(4, sizeof *block);
  for (int k = 0; k < 4; ++k) block[k] = k + 1;
  block = sdr_realloc(block, 1000, sizeof *block);
  for (int k = 0; k < 4; ++k) assert_int_equal(block[k], k + 1);
  assert_int_equal(block[999], 0);
  sdr_free(block);
}

static void an_injected_failure_reaches_the_caller(void **state)
{
  (void)state;
  sdr_memory_fail_after(1);
  void *first = sdr_alloc(1, 1);
  void *second = sdr_alloc(1, 1);
  sdr_memory_fail_after(-1);
  assert_non_null(first);
  assert_null(second);
  assert_non_null(strstr(sdr_error_message(), "out of memory"));
  sdr_free(first);
}

static void mark(void *context, int index)
{
  ++((int *)context)[index];
}

static void every_task_runs_once_on_any_number_of_threads(void **state)
{
  (void)state;
  for (int threads = 1; threads <= 3; ++threads) {
    int done[101] = {0};
    sdr_set_threads(threads);
    sdr_parallel_for(1, 101, 2, mark, done);
    for (int k = 0; k < 101; ++k) assert_int_equal(done[k], k % 2);
  }
}

static void store_product(void *context, int index)
{
  volatile double *values = context;
  values[index] = values[index] * 0.5;
}

static void denormals_are_flushed_inside_and_kept_outside(void **state)
{
  (void)state;
#if defined(__SSE2__)
  double values[2] = {2.3e-308, 2.3e-308};
  sdr_set_threads(2);
  sdr_parallel_for(0, 2, 1, store_product, values);
  assert_true(values[0] == 0.0 && values[1] == 0.0);
  volatile double outside = 2.3e-308;
  outside = outside * 0.5;
  assert_true(outside > 0.0);
#endif
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_message_may_quote_the_message_before_it),
      cmocka_unit_test(a_block_is_zero_aligned_and_counted),
      cmocka_unit_test(a_size_that_overflows_is_refused),
      cmocka_unit_test(growing_keeps_the_content),
      cmocka_unit_test(an_injected_failure_reaches_the_caller),
      cmocka_unit_test(every_task_runs_once_on_any_number_of_threads),
      cmocka_unit_test(denormals_are_flushed_inside_and_kept_outside),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
