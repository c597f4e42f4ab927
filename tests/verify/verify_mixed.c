/* `precision: mixed`: forces of runs in float arithmetic on double displacements. */
#include "support/scene_text.h"

/* To another u at random, with a rigid motion far larger than the stretch; v is the way over dt. */
static void move_to_noise(const sdr_points *points, double amplitude, uint64_t seed, double dt,
                          double *const u[3], double *const v[3])
{
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) v[a][i] = -u[a][i] / dt;
  vector_noise(points, amplitude, seed, u);
  for (int32_t i = 0; i < points->count; ++i) u[0][i] += 3.0 * body_spacing;
  for (int a = 0; a < points->components; ++a)
    for (int32_t i = 0; i < points->count; ++i) v[a][i] += u[a][i] / dt;
}

/* |float force - double force| over the largest, after three explicit steps. */
static double force_error(const body_how *how, double amplitude)
{
  double *u[3], *v[3], *f[2][3];
  int32_t count = 0;
  for (int mixed = 0; mixed < 2; ++mixed) {
    body_how one = *how;
    one.mixed = mixed;
    body b = body_create(&one);
    assert_int_equal(body_traits(b.model).mixed, mixed);
    vector_create(b.points, u);
    vector_create(b.points, v);
    vector_create(b.points, f[mixed]);
    for (uint64_t step = 1; step < 4; ++step) {
      move_to_noise(b.points, amplitude * body_spacing, step, 1e-8, u, v);
      b.model->ops->force_commit(b.model, u, v, step > 1 ? 1e-8 : 0.0, f[mixed]);
    }
    count = b.points->count;
    vector_destroy(u);
    vector_destroy(v);
    body_destroy(&b);
  }
  double worst = 0.0, most = 0.0;
  for (int a = 0; a < 3; ++a)
    for (int32_t i = 0; f[0][a] && i < count; ++i) {
      worst = fmax(worst, fabs(f[0][a][i] - f[1][a][i]));
      most = fmax(most, fabs(f[0][a][i]));
    }
  vector_destroy(f[0]);
  vector_destroy(f[1]);
  return worst / most;
}

static void forces_keep_seven_digits_at_any_stretch(void **state)
{
  (void)state;
  static const body_how shapes[] = {
      {.dimension = SDR_1D, .cells = {90}},
      {.dimension = SDR_PLANE_STRESS, .cells = {40, 37}},
      {.dimension = SDR_PLANE_STRAIN, .cells = {20, 50}, .angle = 0.3},
      {.dimension = SDR_3D, .cells = {9, 8, 34}, .ratio = 2.01}};
  static const double amplitudes[] = {0.1, 1e-3, 1e-6};
  double worst = 0.0;
  for (int k = 0; k < 4; ++k)
    for (int law = SDR_LAW_NONE; law <= SDR_LAW_VARIATIONAL; ++law)
      for (int scatter = 0; scatter < 2; ++scatter)
        for (int a = 0; a < 3; ++a) {
          body_how how = shapes[k];
          how.law = (sdr_law)law;
          how.scatter = 0.3 * scatter;
          how.stretch = amplitudes[a];
          worst = fmax(worst, force_error(&how, amplitudes[a]));
        }
  print_message("largest error of a force: %.2g of the largest\n", worst);
  assert_at_most(worst, 1e-6);
}

/* Leapfrog from rest in place, with waves as long as the body, by 200 steps; u gets where it went.
   Returns the largest damage of a bond. */
static double ride_waves(const body_how *how, double strain, double *u[3], int32_t *count)
{
  const double density = 2500.0, speed = strain * sqrt(body_young / density);
  const double dt = 0.3 * body_spacing / sqrt(body_young / density);
  double *v[3], *f[3];
  body b = body_create(how);
  vector_create(b.points, u);
  vector_create(b.points, v);
  vector_create(b.points, f);
  *count = b.points->count;
  for (int a = 0; a < b.points->components; ++a)
    for (int32_t i = 0; i < *count; ++i)
      v[a][i] = speed * cos(3.14159 * b.points->x[a][i] / (how->cells[a] * body_spacing) + 0.5 * a);
  for (int step = 0; step < 200; ++step) {
    for (int a = 0; a < b.points->components; ++a)
      for (int32_t i = 0; i < *count; ++i) {
        v[a][i] += dt * f[a][i] / (density * b.points->volume[i]);
        u[a][i] += dt * v[a][i];
      }
    b.model->ops->force_commit(b.model, u, v, dt, f);
  }
  sdr_energies energies;
  b.model->ops->energies(b.model, u, &energies);
  vector_destroy(v);
  vector_destroy(f);
  body_destroy(&b);
  return energies.max_damage;
}

/* |mixed - double| of the displacements over the largest. */
static double stray(const body_how *how, double strain, double *damage)
{
  double *u[2][3], worst = 0.0, most = 0.0;
  int32_t count = 0;
  for (int mixed = 0; mixed < 2; ++mixed) {
    body_how one = *how;
    one.mixed = mixed;
    *damage = ride_waves(&one, strain, u[mixed], &count);
  }
  for (int a = 0; a < 3; ++a)
    for (int32_t i = 0; u[0][a] && i < count; ++i) {
      worst = fmax(worst, fabs(u[0][a][i] - u[1][a][i]));
      most = fmax(most, fabs(u[0][a][i]));
    }
  vector_destroy(u[0]);
  vector_destroy(u[1]);
  return worst / most;
}

static void waves_stay_within_1e_7_of_double_for_200_steps(void **state)
{
  (void)state;
  static const sdr_law laws[] = {SDR_LAW_NONE, SDR_LAW_VARIATIONAL, SDR_LAW_CRITICAL_STRETCH};
  for (int k = 0; k < 3; ++k)
    for (int scatter = 0; scatter < 2; ++scatter) {
      double damage;
      const body_how how = {.dimension = SDR_PLANE_STRESS,
                            .cells = {90, 80},
                            .law = laws[k],
                            .stretch = 0.01,
                            .scatter = 0.1 * scatter};
      const double error = stray(&how, 2e-3, &damage);
      print_message("law %d, scatter %d: %.2g, damage %.3f\n", (int)laws[k], scatter, error,
                    damage);
      assert_at_most(error, 1e-7);
      if (laws[k] == SDR_LAW_VARIATIONAL) assert_true(damage > 0.01 && damage < 0.25);
      if (laws[k] == SDR_LAW_CRITICAL_STRETCH) assert_true(damage == 0.0);
    }
}

/* The 4 mm cylinder to 40 us: books as in double, both momenta balanced, nearly the same body. */
static void a_run_keeps_its_books(void **state)
{
  (void)state;
  static const char *const sets[2][3] = {{"time.step=0.4 us", "precision=double", NULL},
                                         {"time.step=0.4 us", "precision=mixed", NULL}};
  double imbalance[2], error = 0.0, most = 0.0;
  sdr_built run[2];
  for (int mixed = 0; mixed < 2; ++mixed) {
    problem_build(&run[mixed], "thick_cylinder", "coarse_4mm", sets[mixed]);
    imbalance[mixed] = run_imbalance(&run[mixed], 40e-6, 0.8e-6);
  }
  for (int32_t i = 0; i < run[0].points->count; ++i)
    for (int a = 0; a < 2; ++a) {
      error = fmax(error, fabs(run[1].system->u[a][i] - run[0].system->u[a][i]));
      most = fmax(most, fabs(run[0].system->u[a][i]));
    }
  print_message("imbalance %.4g and %.4g, displacements differ by %.2g of the largest\n",
                imbalance[0], imbalance[1], error / most);
  assert_near(imbalance[1], imbalance[0], 0.01 * imbalance[0]);
  assert_at_most(error / most, 1e-5);
  sdr_balance balance;
  sdr_system_balance(run[1].system, &balance);
  for (int a = 0; a < 3; ++a) {
    assert_near(balance.momentum[a], run[1].system->impulse[a], 1e-12 * balance.momentum_scale);
    assert_near(balance.angular[a], run[1].system->angular_impulse[a],
                1e-7 * balance.angular_scale);
  }
  sdr_built_destroy(&run[0]);
  sdr_built_destroy(&run[1]);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(forces_keep_seven_digits_at_any_stretch),
      cmocka_unit_test(waves_stay_within_1e_7_of_double_for_200_steps),
      cmocka_unit_test(a_run_keeps_its_books),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
