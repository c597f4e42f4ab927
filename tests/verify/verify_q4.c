/* The finite-element reference of our own against closed forms, before anything is compared with
   it. */
#include "tests/support/q4.h"
#include "support/body.h"

static const q4_plate beam = {.size = {8.0, 2.0},
                              .low = {0.0, -1.0},
                              .young = 3e7,
                              .poisson = 0.3,
                              .density = 1000.0,
                              .thickness = 1.0};

static void solve(const q4_plate *plate, const char *fixed, double *load, double *u)
{
  if (q4_solve(plate, fixed, load, u) != SDR_OK) fail_msg("%s", sdr_error_message());
}

static void linear_displacements_of_the_rim_are_met_inside(void **state)
{
  (void)state;
  for (int plane_strain = 0; plane_strain < 2; ++plane_strain) {
    q4_plate plate = beam;
    plate.nx = 5;
    plate.ny = 7;
    plate.plane_strain = plane_strain;
    const size_t n = (size_t)q4_unknowns(&plate);
    double *u = sdr_alloc(n, sizeof *u), *load = sdr_alloc(n, sizeof *load), x[2];
    char *fixed = sdr_alloc(n, 1);
    for (int j = 0; j <= plate.ny; ++j)
      for (int i = 0; i <= plate.nx; ++i) {
        const int32_t k = q4_node(&plate, i, j);
        if (i % plate.nx != 0 && j % plate.ny != 0) continue;
        q4_place(&plate, i, j, x);
        fixed[2 * k] = fixed[2 * k + 1] = 1;
        u[2 * k] = 1e-3 * x[0] + 2e-3 * x[1];
        u[2 * k + 1] = 5e-4 * x[0] - 1e-3 * x[1];
      }
    solve(&plate, fixed, load, u);
    for (int j = 0; j <= plate.ny; ++j)
      for (int i = 0; i <= plate.nx; ++i) {
        const int32_t k = q4_node(&plate, i, j);
        q4_place(&plate, i, j, x);
        assert_near(u[2 * k], 1e-3 * x[0] + 2e-3 * x[1], 1e-14);
        assert_near(u[2 * k + 1], 5e-4 * x[0] - 1e-3 * x[1], 1e-14);
      }
    sdr_free(u);
    sdr_free(load);
    sdr_free(fixed);
  }
}

/* A cantilever under a parabolic shear load P at its end, elasticity's solution (Timoshenko and
   Goodier, sec. 21): x from the clamp, depth 2, length 8. */
static void exact_cantilever(const q4_plate *plate, double p, const double x[2], double u[2])
{
  const double l = plate->size[0], d = plate->size[1], nu = plate->poisson;
  const double inertia = d * d * d / 12.0, scale = p / (6.0 * plate->young * inertia);
  u[0] =
      -scale * x[1] * ((6.0 * l - 3.0 * x[0]) * x[0] + (2.0 + nu) * (x[1] * x[1] - 0.25 * d * d));
  u[1] = scale * (3.0 * nu * x[1] * x[1] * (l - x[0]) + (4.0 + 5.0 * nu) * 0.25 * d * d * x[0] +
                  (3.0 * l - x[0]) * x[0] * x[0]);
}

/* Relative error of the tip's deflection. */
static double cantilever_error(int refined)
{
  q4_plate plate = beam;
  plate.nx = 16 * refined;
  plate.ny = 4 * refined;
  const double p = -1000.0, d = plate.size[1], inertia = d * d * d / 12.0;
  const size_t n = (size_t)q4_unknowns(&plate);
  double *u = sdr_alloc(n, sizeof *u), *load = sdr_alloc(n, sizeof *load), x[2], exact[2];
  char *fixed = sdr_alloc(n, 1);
  for (int j = 0; j <= plate.ny; ++j) {
    const int32_t k = q4_node(&plate, 0, j);
    q4_place(&plate, 0, j, x);
    exact_cantilever(&plate, p, x, &u[2 * k]);
    fixed[2 * k] = fixed[2 * k + 1] = 1;
  }
  const double h = d / plate.ny, g = 0.5 / sqrt(3.0);
  for (int j = 0; j < plate.ny; ++j)
    for (int s = -1; s <= 1; s += 2) {
      const double y = plate.low[1] + h * (j + 0.5 + s * g), b = 0.5 + s * g;
      const double force = 0.5 * h * p / (2.0 * inertia) * (0.25 * d * d - y * y);
      load[2 * q4_node(&plate, plate.nx, j) + 1] += (1.0 - b) * force;
      load[2 * q4_node(&plate, plate.nx, j + 1) + 1] += b * force;
    }
  solve(&plate, fixed, load, u);
  q4_place(&plate, plate.nx, plate.ny / 2, x);
  exact_cantilever(&plate, p, x, exact);
  const double error = fabs(q4_value(&plate, u, x, 1) / exact[1] - 1.0);
  sdr_free(u);
  sdr_free(load);
  sdr_free(fixed);
  return error;
}

static void a_cantilever_bends_as_elasticity_has_it_with_order_2(void **state)
{
  (void)state;
  const double coarse = cantilever_error(1), middle = cantilever_error(2),
               fine = cantilever_error(4);
  assert_at_most(fine, 2e-3);
  assert_near(log2(coarse / middle), 2.0, 0.15);
  assert_near(log2(middle / fine), 2.0, 0.1);
}

/* A bar that is let go from uniform strain (003 sec. 4.1), nu = 0: the sum of two waves of
   triangles. */
static void a_bar_let_go_vibrates_as_its_wave_does(void **state)
{
  (void)state;
  q4_plate plate = {
      .nx = 200, .ny = 1, .size = {1.0, 0.01}, .young = 200e9, .density = 7850.0, .thickness = 1.0};
  const size_t n = (size_t)q4_unknowns(&plate);
  const double pi = 3.14159265358979323846, c = sqrt(plate.young / plate.density);
  double *u = sdr_alloc(n, sizeof *u), x[2] = {0.4975, 0.005}, worst = 0.0;
  char *fixed = sdr_alloc(n, 1);
  for (int i = 0; i <= plate.nx; ++i)
    for (int j = 0; j <= 1; ++j) u[2 * q4_node(&plate, i, j)] = 1e-3 * i / plate.nx;
  for (int j = 0; j <= 1; ++j) fixed[2 * q4_node(&plate, 0, j)] = 1;
  q4_motion motion;
  assert_int_equal(q4_motion_start(&plate, fixed, u, 0.8e-6, &motion), SDR_OK);
  for (int step = 1; step <= 2500; ++step) {
    q4_motion_step(&motion);
    const double t = step * motion.dt;
    const double exact =
        1e-3 / pi * (asin(sin(0.5 * pi * (x[0] - c * t))) + asin(sin(0.5 * pi * (x[0] + c * t))));
    worst = fmax(worst, fabs(q4_value(&plate, u, x, 0) - exact));
  }
  assert_at_most(worst, 1e-5);
  q4_motion_end(&motion);
  sdr_free(u);
  sdr_free(fixed);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(linear_displacements_of_the_rim_are_met_inside),
      cmocka_unit_test(a_cantilever_bends_as_elasticity_has_it_with_order_2),
      cmocka_unit_test(a_bar_let_go_vibrates_as_its_wave_does),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
