/* The energy audit: a thousand energy-momentum steps of a bursting ring at 0.1, 1 and 5 times the
   explicit limit, and as many parts of steps at 50 times, leave next to nothing of energy, momentum
   and spin; so does a spinning disc that breaks. */
#include "support/scene_text.h"

typedef struct {
  double energy, linear, angular; /* largest, relative as in the summary */
  int64_t accepted, cuts;
  double damage, dissipated;
} audit;

static audit audited(const char *variant, int64_t parts)
{
  sdr_built run;
  sdr_balance first, now;
  audit a = {0};
  double most = 0.0, scale = 0.0, turning = 0.0;
  problem_build(&run, "energy_audit", variant, NULL);
  run_start(&run);
  sdr_system_balance(run.system, &first);
  const sdr_solve_record *solve = &run.system->solve;
  while (run.system->step < run.steps && solve->accepted < parts) {
    run_step(&run);
    sdr_system_balance(run.system, &now);
    most = fmax(most, balance_energy(&now));
    scale = fmax(scale, now.momentum_scale);
    turning = fmax(turning, now.angular_scale);
    const double off = balance_energy(&now) - balance_energy(&first) - run.system->external_work;
    a.energy = fmax(a.energy, fabs(off) / most);
    for (int c = 0; c < 3; ++c) {
      const double p = now.momentum[c] - first.momentum[c] - run.system->impulse[c];
      const double l = now.angular[c] - first.angular[c] - run.system->angular_impulse[c];
      a.linear = fmax(a.linear, fabs(p) / scale);
      a.angular = fmax(a.angular, fabs(l) / turning);
    }
  }
  a.accepted = solve->accepted;
  a.cuts = solve->cuts;
  a.damage = now.model.max_damage;
  a.dissipated = now.model.dissipated / most;
  sdr_built_destroy(&run);
  return a;
}

static void assert_balanced(const char *variant, int64_t parts, double damage)
{
  const audit a = audited(variant, parts);
  print_message("%s: energy %.2g, momentum %.2g, spin %.2g; %lld accepted, %lld cuts; damage %.3f, "
                "dissipated %.3f\n",
                variant ? variant : "five", a.energy, a.linear, a.angular, (long long)a.accepted,
                (long long)a.cuts, a.damage, a.dissipated);
  assert_at_most(a.energy, 1e-9);
  assert_at_most(a.linear, 1e-9);
  assert_at_most(a.angular, 1e-9);
  assert_true(a.damage > damage);
  assert_true(a.accepted >= parts);
}

static void a_thousand_steps_of_a_tenth_of_the_limit_balance(void **state)
{
  (void)state;
  assert_balanced("tenth", 1000, 0.9);
}

static void a_thousand_steps_of_the_limit_balance(void **state)
{
  (void)state;
  assert_balanced("one", 1000, 0.99);
}

static void a_thousand_steps_of_5_times_the_limit_balance(void **state)
{
  (void)state;
  assert_balanced(NULL, 1000, 0.99);
}

static void steps_of_50_times_the_limit_balance(void **state)
{
  (void)state;
  assert_balanced("fifty", 1000, 0.99);
}

static void a_thousand_steps_balance_while_bonds_break(void **state)
{
  (void)state;
  assert_balanced("critical_stretch", 1000, 0.99);
}

static void a_disc_that_breaks_keeps_its_spin(void **state)
{
  (void)state;
  assert_balanced("disc", 100, 0.9);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_thousand_steps_of_a_tenth_of_the_limit_balance),
      cmocka_unit_test(a_thousand_steps_of_the_limit_balance),
      cmocka_unit_test(a_thousand_steps_of_5_times_the_limit_balance),
      cmocka_unit_test(steps_of_50_times_the_limit_balance),
      cmocka_unit_test(a_thousand_steps_balance_while_bonds_break),
      cmocka_unit_test(a_disc_that_breaks_keeps_its_spin)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
