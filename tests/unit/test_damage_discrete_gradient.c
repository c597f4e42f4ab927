/* damage: the discrete gradient of a bond's energy, against the quotient in quadruple precision. */
#include "damage/discrete_gradient.h"
#include "support/cmocka_all.h"

typedef __float128 quad;

static quad power(quad x, int n)
{
  quad y = 1;
  for (int k = 0; k < n; ++k) y *= x;
  return y;
}

/* Primitive of 2 F(k, k): twice the energy of loading from 0 to s, over C |xi|; written from the
   force, not from the header's energies. */
static quad envelope(int law, quad s, quad q, quad r)
{
  if (law == SDR_LAW_VARIATIONAL) return q * s * s / (s * s + q);
  if (law == SDR_LAW_AT1) return s * s * 2 < q ? s * s : q - q * q / (4 * s * s);
  const quad mu = SDR_COHESIVE_MU, gamma = SDR_COHESIVE_GAMMA, last = mu + gamma / r;
  const quad x = s / q, steep = (1 - gamma) / (mu - 1);
  const quad y = x < 1 ? x : 1, z = x < mu ? x : mu, t = x < last ? x : last;
  quad e = power(y, 2);
  if (x > 1) e += 2 * (z - 1) - steep * power(z - 1, 2);
  if (x > mu) e += 2 * gamma * (t - mu) - r * power(t - mu, 2);
  return e * q * q;
}

/* g of the history k. */
static quad left_of(int law, quad k, quad q, quad r)
{
  if (law == SDR_LAW_VARIATIONAL) return power(q / (k * k + q), 2);
  if (law == SDR_LAW_AT1) return 2 * k * k > q ? power(q / (2 * k * k), 2) : 1;
  const quad mu = SDR_COHESIVE_MU, gamma = SDR_COHESIVE_GAMMA, x = k / q;
  const quad steep = (1 - gamma) / (mu - 1);
  if (x <= 1) return 1;
  const quad f = x < mu ? 1 - steep * (x - 1) : gamma - r * (x - mu);
  return f > 0 ? f / x : 0;
}

/* E(s) after the history k, up to a constant of k. */
static quad total(int law, quad s, quad k, quad q, quad r)
{
  if (law == SDR_LAW_NONE || s < 0) return s * s;
  const quad left = left_of(law, k, q, r);
  if (s <= k) return left * s * s;
  return left * k * k + envelope(law, s, q, r) - envelope(law, k, q, r);
}

/* The force over C at s, twice: the limit of small steps. */
static quad force2(int law, quad s, quad k, quad q, quad r)
{
  if (law == SDR_LAW_NONE || s < 0) return 2 * s;
  return 2 * s * left_of(law, s > k ? s : k, q, r);
}

typedef struct {
  int law;
  const char *name;
  double q, r;
} law_case;

static const law_case laws[] = {{SDR_LAW_NONE, "none", 1.0, 0.0},
                                {SDR_LAW_VARIATIONAL, "variational", 1.1e-4, 0.0},
                                {SDR_LAW_AT1, "at1", 1.3e-4, 0.0},
                                {SDR_LAW_COHESIVE, "cohesive", 0.008, 0.11}};
enum { LAWS = sizeof laws / sizeof *laws, STEPS = 10 };
static const double steps[STEPS] = {1.0, 0.3, 0.02, 3e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};

static void check(const law_case *law, double s0, double s1, double before)
{
  const double k = s0 > before ? s0 : before, h = s1 - s0;
  const quad way = (quad)s1 - (quad)s0;
  const quad grown =
      total(law->law, s1, k, law->q, law->r) - total(law->law, s0, k, law->q, law->r);
  const quad mean = grown / way;
  /* d/ds1 of the quotient */
  const quad slope = (force2(law->law, s1, k, law->q, law->r) - mean) / way;
  const sdr_mean_answer a = sdr_mean_of(law->law, s0, s1, before, law->q, law->r);
  const double size = fabs(s0) + fabs(s1);
  if (!(fabs(a.mean - (double)mean) <= 2e-15 * size))
    fail_msg("%s: %.17g to %.17g, k %g: mean %.17g, exact %.17g", law->name, s0, s1, before, a.mean,
             (double)mean);
  /* the slope jumps by up to 4 at a kink, whose own place has been rounded */
  if (!(fabs(a.slope - (double)slope) <= 1e-13 + 5e-16 * size / fabs(h)))
    fail_msg("%s: %.17g to %.17g, k %g, step %g: slope %.17g, exact %.17g", law->name, s0, s1,
             before, h, a.slope, (double)slope);
}

/* From every side of every kink, with steps of all sizes up and down. */
static void mean_and_slope_have_full_precision_for_steps_of_any_size(void **state)
{
  (void)state;
  for (int l = 0; l < LAWS; ++l) {
    const double onset = sqrt(0.5 * laws[l].q),
                 last = laws[l].r > 0.0 ? laws[l].q * (1.25 + 0.5 / laws[l].r) : 0.1;
    const double kinks[] = {0.0, onset, laws[l].q, 1.25 * laws[l].q, last, 3e-3, 0.012, 0.2};
    for (int b = 0; b < 8; ++b)
      for (int c = 0; c < 8; ++c)
        for (int n = 0; n < STEPS; ++n)
          for (int part = 0; part <= 6; ++part) {
            const double h = steps[n], s0 = kinks[c] - h * part / 5.0;
            if (s0 <= -0.99) continue;
            check(&laws[l], s0, s0 + h, kinks[b]);
            if (s0 - h > -0.99) check(&laws[l], s0, s0 - h, kinks[b]);
          }
  }
}

static void the_mean_is_twice_the_force_where_nothing_moves(void **state)
{
  (void)state;
  for (int l = 0; l < LAWS; ++l)
    for (int n = -20; n <= 60; ++n)
      for (int b = 0; b <= 4; ++b) {
        const double s = 1e-3 * n, before = 0.01 * b, k = s > before ? s : before;
        const sdr_mean_answer a = sdr_mean_of(laws[l].law, s, s, before, laws[l].q, laws[l].r);
        const sdr_bond_answer f = sdr_bond_law(laws[l].law, s, k, laws[l].q, laws[l].r);
        if (!(fabs(a.mean - 2.0 * f.force) <= 1e-16 + 4e-16 * fabs(s)))
          fail_msg("%s at %g after %g: %.17g, force %.17g", laws[l].name, s, before, a.mean,
                   f.force);
        /* half of the slope of twice the force belongs to the step's end */
        if (!(fabs(a.slope - f.slope) <= 1e-13))
          fail_msg("%s at %g after %g: slope %.17g, law %.17g", laws[l].name, s, before, a.slope,
                   f.slope);
      }
}

/* The form without branches, which loops over runs take, is that of pieces. */
static void both_forms_of_the_variational_law_agree(void **state)
{
  (void)state;
  const double q = 1.1e-4;
  for (int i = -30; i <= 90; ++i)
    for (int j = -30; j <= 90; ++j)
      for (int b = 0; b <= 4; ++b) {
        const double s0 = 7e-4 * i, s1 = 7e-4 * j, before = 0.007 * b;
        const sdr_mean_answer x = sdr_mean_variational(s0, s1, before, q);
        const sdr_mean_answer y = sdr_mean_any(SDR_LAW_VARIATIONAL, s0, s1, before, q, 0.0);
        if (!(fabs(x.mean - y.mean) <= 1e-15 * (fabs(s0) + fabs(s1))))
          fail_msg("mean of %g to %g after %g: %.17g and %.17g", s0, s1, before, x.mean, y.mean);
        if (!(fabs(x.slope - y.slope) <= 1e-13))
          fail_msg("slope of %g to %g after %g: %.17g and %.17g", s0, s1, before, x.slope, y.slope);
      }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(mean_and_slope_have_full_precision_for_steps_of_any_size),
      cmocka_unit_test(the_mean_is_twice_the_force_where_nothing_moves),
      cmocka_unit_test(both_forms_of_the_variational_law_agree)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
