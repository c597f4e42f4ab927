/* Ordinary bodies that crack: what a split body has dissipated, and the books under leapfrog
   (theory sec. 4-5). */
#include "support/ordinary.h"
#include "support/split.h"
#include "support/torn.h"

/* ---- separation ------------------------------------------------------------------------------ */

/* What points away from the ends dissipate when their body is split, over Gc and area. */
static double separation(const ordinary_how *how, double tilt)
{
  ordinary_how longer = *how;
  split plan = split_plan(&longer.body, tilt);
  body b = ordinary_create(&longer);
  const double taken = split_dissipated(&plan, b.points, b.model) / b.toughness[0];
  body_destroy(&b);
  return taken;
}

static const double eighth = 3.14159265358979323846 / 8.0;

static ordinary_how strip(sdr_law law, double poisson)
{
  return (ordinary_how){.body = {.dimension = SDR_PLANE_STRESS, .law = law}, .poisson = poisson};
}

/* The band of damaged points: 3 spacings on both sides of a cut along an axis, 3 cos 22.5 = 2.772
   at 22.5 degrees, 2 sqrt 2 at 45; ell is 3/1.04 of them. */
static void a_split_body_dissipates_the_toughness_at_0_and_22_5_and_45_degrees(void **state)
{
  (void)state;
  static const double expected[3] = {1.04, 0.9608, 0.9805};
  for (int k = 0; k < 4; ++k)
    for (int angle = 0; angle < 3; ++angle) {
      ordinary_how how = strip(SDR_LAW_VARIATIONAL, 0.1 + 0.1 * k);
      how.body.dimension = k == 3 ? SDR_3D : k == 1 ? SDR_PLANE_STRAIN : SDR_PLANE_STRESS;
      how.body.force_loose = k == 2;
      const double taken = separation(&how, angle * eighth);
      print_message("%d, %g degrees: %.4f\n", k, 22.5 * angle, taken);
      assert_near(taken, 1.0, 0.05);
      assert_near(taken, expected[angle], 2e-3);
    }
}

static double split_at(ordinary_how how, double angle)
{
  const double taken = separation(&how, angle);
  print_message("ratio %g, %.4g degrees: %.4f\n", how.body.ratio, angle * 22.5 / eighth, taken);
  return taken;
}

/* A family of 5.015 spacings is rounder: ell is its mean band, 2 x 4.927 spacings. One of 4.015 is
   too square for any ell: 4 spacings on both sides along the axis, 5/sqrt 2 at 45 degrees. */
static void cuts_take_what_their_bands_hold_of_other_families(void **state)
{
  (void)state;
  ordinary_how how = strip(SDR_LAW_VARIATIONAL, 0.25);
  how.body.ratio = 5.015;
  assert_near(split_at(how, 0.0), 5.0 / 4.927, 2e-3);
  assert_near(split_at(how, 2.0 * eighth), 7.0 / sqrt(2.0) / 4.927, 2e-3);
  how.body.ratio = 4.015;
  assert_near(split_at(how, 0.0), 1.04, 2e-3);
  assert_near(split_at(how, 2.0 * eighth), 1.04 * 5.0 / (4.0 * sqrt(2.0)), 2e-3);
}

/* Along the slope 1/2 a family of 3.015 reaches least: 6/sqrt 5 spacings. */
static void no_cut_dissipates_less_than_0_93_of_the_toughness(void **state)
{
  (void)state;
  const ordinary_how how = strip(SDR_LAW_VARIATIONAL, 0.25);
  assert_near(split_at(how, atan(0.5)), 1.04 * 2.0 / sqrt(5.0), 2e-3);
}

static void critical_stretch_takes_the_toughness_in_any_direction(void **state)
{
  (void)state;
  for (int k = 0; k < 6; ++k)
    for (int angle = 0; angle < 3; ++angle) {
      ordinary_how how = strip(SDR_LAW_CRITICAL_STRETCH, k < 3 ? 0.1 + 0.15 * k : 0.25);
      how.body.dimension = k == 5 ? SDR_3D : k == 2 ? SDR_PLANE_STRAIN : SDR_PLANE_STRESS;
      how.body.force_loose = k == 1;
      how.form = k == 3 ? SDR_FORM_MADENCI_OTERKUS : SDR_FORM_STANDARD;
      how.body.weight.influence = k == 4 ? SDR_INFLUENCE_CUBIC : SDR_INFLUENCE_CONSTANT;
      const double taken = separation(&how, angle * eighth);
      print_message("%d, %g degrees: %.4f\n", k, 22.5 * angle, taken);
      assert_near(taken, 1.0, 0.05);
    }
}

static void jittered_points_take_the_toughness_too(void **state)
{
  (void)state;
  for (int law = SDR_LAW_VARIATIONAL; law <= SDR_LAW_CRITICAL_STRETCH; ++law)
    for (int angle = 0; angle < 3; ++angle) {
      ordinary_how how = strip((sdr_law)law, 0.25);
      how.body.jitter = 0.3;
      how.body.dimension = angle == 2 ? SDR_3D : SDR_PLANE_STRESS;
      const double tilt = angle == 2 ? 0.0 : angle * eighth;
      const double taken = separation(&how, tilt);
      print_message("law %d, %d-D, %.4g degrees: %.4f\n", law, angle == 2 ? 3 : 2,
                    tilt * 22.5 / eighth, taken);
      assert_near(taken, 1.0, 0.05);
    }
}

/* ---- torn to pieces ---------------------------------------------------------------------------
 */

static ordinary_how torn_of(int k)
{
  static const double poisson[4] = {0.1, 0.45, 0.2, 0.45};
  ordinary_how how = {.body = {.dimension = k == 2 ? SDR_3D : SDR_PLANE_STRAIN,
                               .cells = {k == 2 ? 7 : 24, k == 2 ? 8 : 18, 7},
                               .ratio = k == 2 ? 2.2 : 3.015,
                               .law = SDR_LAW_CRITICAL_STRETCH,
                               .stretch = 0.004,
                               .force_loose = k == 1},
                      .poisson = poisson[k],
                      .form = k == 3 ? SDR_FORM_MADENCI_OTERKUS : SDR_FORM_STANDARD};
  return how;
}

/* Lost stretches are free (theory sec. 9), which only lowers energies. */
static void a_lost_bond_never_raises_the_energy_of_a_point(void **state)
{
  (void)state;
  for (int k = 0; k < 4; ++k) {
    const ordinary_how how = torn_of(k);
    lose_at_random(ordinary_create(&how), 0.003 * body_spacing);
  }
}

/* Nor does it stiffen anything, so the step of the start holds to the end. */
static void a_body_torn_to_pieces_at_the_default_step_keeps_its_books(void **state)
{
  (void)state;
  for (int k = 0; k < 4; ++k) {
    const ordinary_how how = torn_of(k);
    const torn end = tear(ordinary_create(&how), k == 2 ? 20000.0 : 5000.0, 0.1, 150);
    assert_true(end.broken > 0.1 && end.taken > 0.2);
    assert_at_most(end.fall, 0.0);
    assert_at_most(end.imbalance, 1e-3);
    assert_true(end.limit > 0.99); /* known to 0.5 % */
  }
}

/* ---- books ----------------------------------------------------------------------------------- */

/* Run a free body that starts from a smooth strain and a pull along x; largest imbalance over the
   largest energy. */
static double imbalance(const ordinary_how *how, double dt, double end, double rate,
                        sdr_energies *last)
{
  still_body s;
  sdr_balance balance;
  still_of(ordinary_create(how), &s);
  sdr_system *system = s.system;
  const sdr_points *points = s.body.points;
  for (int32_t i = 0; i < points->count; ++i) {
    const double x = points->x[0][i], y = points->x[1][i];
    system->u[0][i] = 1e-3 * x + 1e-4 * body_spacing * sin(1500.0 * y);
    system->v[0][i] = rate * x;
    system->v[1][i] = 0.3 * rate * y;
  }
  assert_int_equal(sdr_leapfrog.start(system, dt), SDR_OK);
  sdr_system_balance(system, &balance);
  const double start = balance.kinetic + balance.model.stored + balance.model.dissipated;
  double worst = 0.0, most = start;
  for (long n = 1; n <= lround(end / dt); ++n) {
    assert_int_equal(sdr_leapfrog.step(system, dt), SDR_OK);
    sdr_system_balance(system, &balance);
    const double energy = balance.kinetic + balance.model.stored + balance.model.dissipated;
    worst = fmax(worst, fabs(energy - start));
    most = fmax(most, energy);
  }
  *last = balance.model;
  still_destroy(&s);
  return worst / most;
}

static ordinary_how pulled(sdr_law law, int loose)
{
  return (ordinary_how){.body = {.dimension = SDR_PLANE_STRESS,
                                 .cells = {40, 30},
                                 .law = law,
                                 .stretch = 0.004,
                                 .force_loose = loose}};
}

/* Imbalances with the step halved, and halved again. */
static void halve(const ordinary_how *how, double worst[3], sdr_energies *e)
{
  for (int k = 0; k < 3; ++k) worst[k] = imbalance(how, 4e-8 / (1 << k), 8e-6, 3000.0, e);
  print_message("law %d: imbalance %.4g %.4g %.4g, damage %.3f, broken %d\n", (int)how->body.law,
                worst[0], worst[1], worst[2], e->max_damage, (int)e->broken);
}

static void imbalance_falls_by_four_per_halving_with_variational_damage(void **state)
{
  (void)state;
  for (int law = SDR_LAW_NONE; law <= SDR_LAW_VARIATIONAL; ++law) {
    const ordinary_how how = pulled((sdr_law)law, law);
    double worst[3];
    sdr_energies e;
    halve(&how, worst, &e);
    assert_near(worst[0] / worst[1], 4.0, 0.2);
    assert_near(worst[1] / worst[2], 4.0, 0.2);
    if (law == SDR_LAW_VARIATIONAL) assert_true(e.max_damage > 0.9);
  }
}

/* Which bonds break when changes with the step, so the order shows over two halvings. */
static void critical_stretch_keeps_the_books_near_second_order(void **state)
{
  (void)state;
  for (int loose = 0; loose < 2; ++loose) {
    const ordinary_how how = pulled(SDR_LAW_CRITICAL_STRETCH, loose);
    double worst[3];
    sdr_energies e;
    halve(&how, worst, &e);
    assert_true(e.broken > 1000);
    assert_at_most(worst[0], 3e-3);
    assert_true(worst[0] / worst[2] > 8.0);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_split_body_dissipates_the_toughness_at_0_and_22_5_and_45_degrees),
      cmocka_unit_test(cuts_take_what_their_bands_hold_of_other_families),
      cmocka_unit_test(no_cut_dissipates_less_than_0_93_of_the_toughness),
      cmocka_unit_test(critical_stretch_takes_the_toughness_in_any_direction),
      cmocka_unit_test(jittered_points_take_the_toughness_too),
      cmocka_unit_test(a_lost_bond_never_raises_the_energy_of_a_point),
      cmocka_unit_test(a_body_torn_to_pieces_at_the_default_step_keeps_its_books),
      cmocka_unit_test(imbalance_falls_by_four_per_halving_with_variational_damage),
      cmocka_unit_test(critical_stretch_keeps_the_books_near_second_order),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
