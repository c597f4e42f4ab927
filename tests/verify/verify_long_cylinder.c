/* The cylinder at full size (196,556 points): onset, books, same bits on any number of threads. */
#include "support/scene_text.h"

static void build_full(sdr_built *run)
{
  problem_build(run, "thick_cylinder", NULL, NULL);
  assert_int_equal(run->points->count, 196556);
}

static double most_damaged(const sdr_built *run, double *damage)
{
  double most = 0.0;
  assert_int_equal(sdr_system_field(run->system, "damage", damage), SDR_OK);
  for (int32_t i = 0; i < run->points->count; ++i) most = fmax(most, damage[i]);
  return most;
}

static void onset_is_the_papers_and_the_books_close(void **state)
{
  (void)state;
  sdr_built run;
  sdr_balance balance;
  build_full(&run);
  double *damage = sdr_alloc((size_t)run.points->count, sizeof *damage);
  run_start(&run);
  sdr_system_balance(run.system, &balance);
  const double start = balance_energy(&balance);
  double onset = (double)NAN, most = start;
  for (int n = 1; n <= 1000; ++n) {
    run_step(&run);
    if (isnan(onset) && n % 5 == 0 && most_damaged(&run, damage) > run.onset)
      onset = run.system->time;
    if (n % 50 != 0) continue;
    sdr_system_balance(run.system, &balance);
    most = fmax(most, balance_energy(&balance));
  }
  const double imbalance = (balance_energy(&balance) - start - run.system->external_work) / most;
  print_message("onset %.1f us, imbalance %.2g at %.1f us\n", onset * 1e6, imbalance,
                run.system->time * 1e6);
  assert_near(run.system->time, 100e-6, 1e-12);
  assert_near(onset, 43.6e-6, 2e-6); /* the paper's onset, issue 2 */
  assert_at_most(fabs(imbalance), 5e-4);
  sdr_free(damage);
  sdr_built_destroy(&run);
}

/* FNV-1a over the bits of u and f after 100 steps, and the energies. */
static uint64_t bits_after_100_steps(int threads, double *u)
{
  sdr_built run;
  uint64_t hash = 14695981039346656037u;
  build_full(&run);
  sdr_set_threads(threads);
  run_start(&run);
  for (int n = 0; n < 100; ++n) run_step(&run);
  sdr_balance balance;
  sdr_system_balance(run.system, &balance);
  const size_t count = (size_t)run.points->count;
  for (int a = 0; a < 2; ++a) {
    memcpy(u + (size_t)a * count, run.system->u[a], count * sizeof *u);
    const unsigned char *bytes = (const unsigned char *)run.system->f[a];
    for (size_t k = 0; k < count * sizeof *u; ++k) hash = (hash ^ bytes[k]) * 1099511628211u;
  }
  const unsigned char *bytes = (const unsigned char *)&balance;
  for (size_t k = 0; k < sizeof balance; ++k) hash = (hash ^ bytes[k]) * 1099511628211u;
  sdr_built_destroy(&run);
  return hash;
}

static void one_two_and_three_threads_give_the_same_bits(void **state)
{
  (void)state;
  const size_t size = (size_t)2 * 196556;
  double *one = sdr_alloc(size, sizeof *one), *more = sdr_alloc(size, sizeof *more);
  const uint64_t hash = bits_after_100_steps(1, one);
  for (int threads = 2; threads <= 3; ++threads) {
    assert_true(bits_after_100_steps(threads, more) == hash);
    assert_memory_equal(one, more, size * sizeof *one);
  }
  sdr_free(one);
  sdr_free(more);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(onset_is_the_papers_and_the_books_close),
      cmocka_unit_test(one_two_and_three_threads_give_the_same_bits),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
