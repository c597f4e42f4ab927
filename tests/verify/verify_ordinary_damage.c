/* Ordinary bodies that crack: what a split body has dissipated, and the books under leapfrog
   (theory sec. 4-5). */
#include "support/ordinary.h"
#include "support/still_body.h"
#include "time/integrator.h"

/* ---- separation ------------------------------------------------------------------------------ */

/* Normal of the plane: turned by this from the first lattice axis. */
static double tilt;

/* Open the plane rigidly by `from` to `to` metres, each time `growth` as far as before. */
static void open_crack(const body *b, double from, double to, double growth)
{
  const double c = cos(tilt), t = sin(tilt);
  double *u[3], *v[3], *f[3], before = 0.0;
  vector_create(b->points, u);
  vector_create(b->points, v);
  vector_create(b->points, f);
  for (double gap = from; gap < growth * to; gap *= growth) {
    for (int32_t i = 0; i < b->points->count; ++i) {
      const int moves = c * b->points->x[0][i] + t * b->points->x[1][i] > 1e-6 * body_spacing;
      u[0][i] = moves ? gap * c : 0.0;
      u[1][i] = moves ? gap * t : 0.0;
      v[0][i] = moves ? (gap - before) * c : 0.0; /* a step of 1 s led here */
      v[1][i] = moves ? (gap - before) * t : 0.0;
    }
    b->model->ops->force_commit(b->model, u, v, 1.0, f);
    before = gap;
  }
  sdr_energies e;
  b->model->ops->energies(b->model, u, &e);
  assert_at_most(e.stored, 1e-2 * e.dissipated);
  vector_destroy(u);
  vector_destroy(v);
  vector_destroy(f);
}

/* Dissipated energy of a body of so many rows, J; *toughness: of its material. */
static double dissipated(const ordinary_how *how, int32_t rows, double *toughness)
{
  ordinary_how longer = *how;
  longer.body.cells[1] = rows;
  longer.body.cells[0] = 2 * ((16 + (int32_t)(rows * tan(tilt))) / 2);
  body b = ordinary_create(&longer);
  sdr_energies e;
  if (how->body.law == SDR_LAW_VARIATIONAL)
    open_crack(&b, 1e-3, 10.0, 10.0);
  else
    open_crack(&b, 1e-3 * body_spacing, 0.3 * body_spacing, how->body.jitter > 0.0 ? 1.03 : 1.01);
  double *u[3];
  vector_create(b.points, u);
  b.model->ops->energies(b.model, u, &e);
  vector_destroy(u);
  *toughness = b.toughness[0];
  body_destroy(&b);
  return e.dissipated;
}

/* Over Gc and area: the difference of two lengths is free of end effects. */
static double separation(const ordinary_how *how)
{
  double toughness;
  const int rows = how->body.jitter > 0.0 ? 120 : 20; /* chance wants many */
  const double longer = dissipated(how, rows + 20, &toughness);
  const double shorter = dissipated(how, 20, &toughness);
  const double depth = how->body.dimension == SDR_3D ? how->body.cells[2] * body_spacing : 1.0;
  return (longer - shorter) * cos(tilt) / (rows * body_spacing * depth * toughness);
}

static const double eighth = 3.14159265358979323846 / 8.0;

static ordinary_how strip(sdr_law law, double poisson)
{
  return (ordinary_how){.body = {.dimension = SDR_PLANE_STRESS, .cells = {16, 0}, .law = law},
                        .poisson = poisson};
}

static void a_body_split_along_the_lattice_dissipates_the_toughness(void **state)
{
  (void)state;
  tilt = 0.0;
  for (int k = 0; k < 4; ++k) {
    ordinary_how how = strip(SDR_LAW_VARIATIONAL, 0.1 + 0.1 * k);
    how.body.dimension = k % 2 ? SDR_PLANE_STRAIN : SDR_PLANE_STRESS;
    how.body.force_loose = k > 1;
    how.body.ratio = k == 3 ? 4.1 : 3.015;
    assert_near(separation(&how), 1.0, 1e-3);
  }
}

/* ell counts the rows beside a cut along the lattice; a cut at an angle damages a thinner band, as
   far as the family reaches across it. */
static void at_an_angle_the_band_is_as_thin_as_the_family_reaches(void **state)
{
  (void)state;
  const ordinary_how how = strip(SDR_LAW_VARIATIONAL, 0.2);
  for (int k = 1; k <= 2; ++k) {
    tilt = k * eighth;
    const double reach = fmax(3.0 * cos(tilt), 2.0 * cos(tilt) + 2.0 * sin(tilt));
    assert_near(separation(&how), reach / 3.0, 5e-3);
  }
}

static void critical_stretch_takes_the_toughness_in_any_direction(void **state)
{
  (void)state;
  for (int k = 0; k < 5; ++k)
    for (int angle = 0; angle < 3; ++angle) {
      ordinary_how how = strip(SDR_LAW_CRITICAL_STRETCH, k < 3 ? 0.1 + 0.15 * k : 0.25);
      how.body.dimension = k == 2 ? SDR_PLANE_STRAIN : SDR_PLANE_STRESS;
      how.body.force_loose = k == 1;
      how.form = k == 3 ? SDR_FORM_MADENCI_OTERKUS : SDR_FORM_STANDARD;
      how.body.weight.influence = k == 4 ? SDR_INFLUENCE_CUBIC : SDR_INFLUENCE_CONSTANT;
      tilt = angle * eighth;
      const double taken = separation(&how);
      print_message("%d, %g degrees: %.4f\n", k, 22.5 * angle, taken);
      assert_near(taken, 1.0, 0.05);
    }
}

static void jittered_points_take_the_toughness_too(void **state)
{
  (void)state;
  for (int law = SDR_LAW_VARIATIONAL; law <= SDR_LAW_CRITICAL_STRETCH; ++law)
    for (int angle = 0; angle < 2; ++angle) {
      ordinary_how how = strip((sdr_law)law, 0.25);
      how.body.jitter = 0.3;
      tilt = angle * eighth;
      const double taken = separation(&how);
      print_message("law %d, %g degrees: %.4f\n", law, 22.5 * angle, taken);
      assert_near(taken, 1.0, 0.05);
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
      cmocka_unit_test(a_body_split_along_the_lattice_dissipates_the_toughness),
      cmocka_unit_test(at_an_angle_the_band_is_as_thin_as_the_family_reaches),
      cmocka_unit_test(critical_stretch_takes_the_toughness_in_any_direction),
      cmocka_unit_test(jittered_points_take_the_toughness_too),
      cmocka_unit_test(imbalance_falls_by_four_per_halving_with_variational_damage),
      cmocka_unit_test(critical_stretch_keeps_the_books_near_second_order),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
