/* time: leapfrog step by step, and how it stops. Its order is shown by tests/verify. */
#include "support/still_body.h"
#include "time/integrator.h"

static const body_how plate = {.dimension = SDR_PLANE_STRESS, .cells = {12, 9}};
static const double dt = 2e-9;

static void integrators_are_found_by_name(void **state)
{
  (void)state;
  assert_ptr_equal(sdr_integrator_find("leapfrog"), &sdr_leapfrog);
  assert_null(sdr_integrator_find("leapfro"));
  assert_null(sdr_integrator_find(""));
}

static void time_is_steps_times_the_step(void **state)
{
  (void)state;
  still_body s;
  still_create(&plate, &s);
  assert_int_equal(sdr_leapfrog.start(s.system, dt), SDR_OK);
  assert_near(s.system->velocity_offset, -0.5 * dt, 0.0);
  for (int n = 1; n <= 1000; ++n) {
    assert_int_equal(sdr_leapfrog.step(s.system, dt), SDR_OK);
    assert_int_equal(s.system->step, n);
    assert_near(s.system->time, n * dt, 0.0); /* no sum of rounding */
  }
  assert_near(vector_largest(s.body.points, s.system->u), 0.0, 0.0); /* at rest it rests */
  still_destroy(&s);
}

/* One step against the formulas: v += dt/2 a, u += dt v, a(u), v += dt/2 a. */
static void one_step_is_velocity_verlet(void **state)
{
  (void)state;
  still_body s;
  still_create(&plate, &s);
  sdr_system *system = s.system;
  const sdr_points *points = s.body.points;
  double *u[3], *v[3], *f[3];
  vector_create(points, u);
  vector_create(points, v);
  vector_create(points, f);
  vector_noise(points, 0.01 * body_spacing, 3, u);
  vector_noise(points, 10.0, 4, v);
  vector_add(points, u, 0.0, v, system->u);
  vector_add(points, v, 0.0, u, system->v);
  assert_int_equal(sdr_leapfrog.start(system, dt), SDR_OK);
  assert_int_equal(sdr_leapfrog.step(system, dt), SDR_OK);
  s.body.model->ops->force(s.body.model, u, f);
  for (int a = 0; a < 2; ++a)
    for (int32_t i = 0; i < points->count; ++i) {
      v[a][i] += 0.5 * dt * f[a][i] / system->mass[i];
      u[a][i] += dt * v[a][i];
    }
  assert_at_most(vector_difference(points, u, system->u), 1e-14 * vector_largest(points, u));
  assert_at_most(vector_difference(points, v, system->v), 1e-13 * vector_largest(points, v));
  vector_destroy(u);
  vector_destroy(v);
  vector_destroy(f);
  still_destroy(&s);
}

static void check_blow_up(double velocity)
{
  still_body s;
  still_create(&plate, &s);
  assert_int_equal(sdr_leapfrog.start(s.system, dt), SDR_OK);
  assert_int_equal(sdr_leapfrog.step(s.system, dt), SDR_OK);
  s.system->v[1][50] = velocity;
  assert_int_equal(sdr_leapfrog.step(s.system, dt), SDR_RUN_FAILED);
  char expected[256];
  snprintf(expected, sizeof expected,
           "the run blew up at t = %.6g s (step 2): the point at (%g, %g, 0) m would move by a "
           "horizon or more in one step; take a smaller time.step, or look at the loads there",
           2.0 * dt, s.body.points->x[0][50], s.body.points->x[1][50]);
  assert_string_equal(sdr_error_message(), expected);
  still_destroy(&s);
}

static void a_point_that_flies_off_stops_the_run(void **state)
{
  (void)state;
  check_blow_up(1.01 * 3.015 * body_spacing / dt);
  check_blow_up((double)INFINITY);
  check_blow_up((double)NAN);
}

/* A single fast point is no blow-up while it moves by less than a horizon. */
static void a_fast_point_is_let_be(void **state)
{
  (void)state;
  still_body s;
  still_create(&plate, &s);
  assert_int_equal(sdr_leapfrog.start(s.system, dt), SDR_OK);
  s.system->v[0][50] = 0.9 * 3.015 * body_spacing / dt;
  assert_int_equal(sdr_leapfrog.step(s.system, dt), SDR_OK);
  still_destroy(&s);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(integrators_are_found_by_name),
      cmocka_unit_test(time_is_steps_times_the_step),
      cmocka_unit_test(one_step_is_velocity_verlet),
      cmocka_unit_test(a_point_that_flies_off_stops_the_run),
      cmocka_unit_test(a_fast_point_is_let_be),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
