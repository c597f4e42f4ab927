/* app: a run that gains energy from nowhere is stopped; sound runs under sudden loads are not. */
#include "support/program.h"

/* An elastic bar pushed at one end; the limit is 0.18 us or so. */
static const char scene[] = "dimension: plane_stress\n"
                            "points: {shape: {box: {from: [0, 0], to: [40 mm, 10 mm]}}, "
                            "spacing: 1 mm, align: cell}\n"
                            "horizon: 3.015 spacing\n"
                            "material: {young: 200 GPa, density: 7800 kg/m^3, toughness: 1 J/m^2}\n"
                            "damage: {law: variational}\n"
                            "loads: [{traction: {on: left, value: [1 MPa, 0]}}]\n"
                            "time: {step: auto, end: 60 us, allow_unstable: true}\n"
                            "output: {snapshots: 0}\n";

static void a_sound_step_under_a_sudden_load_is_not_stopped(void **state)
{
  (void)state;
  said s;
  write_text("bar.yaml", scene);
  succeed(&s, "sunder run bar.yaml --quiet --set output.history.every=1");
}

static void a_step_above_the_limit_is_stopped_by_its_energy_with_time_and_point(void **state)
{
  (void)state;
  said s;
  double t, percent, x, y, z;
  long long step;
  write_text("bar.yaml", scene);
  shell(&s, "sunder run bar.yaml --quiet --set output.history.every=1 --set damage.law=none "
            "--set time.step=\"0.45 us\"");
  assert_int_equal(s.code, 2);
  assert_int_equal(sscanf(s.err,
                          "sunder: the run blew up by t = %lf s (step %lld): %lf %% of its energy "
                          "came from nowhere; the fastest point is at (%lf, %lf, %lf) m",
                          &t, &step, &percent, &x, &y, &z),
                   6);
  assert_true(t > 0.0 && t < 60e-6 && step > 5 && percent > 50.0);
  assert_true(x > 0.0 && x < 0.04 && y > 0.0 && y < 0.01 && z == 0.0);
  assert_false(exists("out/bar/summary.json"));
}

/* Bonds of an unstable body break with more than they took: the books balance by a dissipation
   below zero. */
static void energy_from_bonds_that_break_is_told_too(void **state)
{
  (void)state;
  said s;
  write_text("noise.yaml",
             "dimension: plane_stress\n"
             "points: {shape: {box: {size: [20 mm, 20 mm]}}, spacing: 1 mm, align: cell}\n"
             "material: {young: 210 GPa, density: 7850 kg/m^3, toughness: 2e4 J/m^2}\n"
             "damage: {law: critical_stretch}\n"
             "initial: {velocity: [\"5 m/s * sin(x*y/(20 mm^2))\", "
             "\"3 m/s * cos(7*x/(1 mm))\"]}\n"
             "time: {step: 0.44 us, allow_unstable: true, end: 100 us}\n"
             "output: {snapshots: 0}\n");
  shell(&s, "sunder run noise.yaml --quiet");
  assert_int_equal(s.code, 2);
  assert_non_null(strstr(s.err, "of its energy came from nowhere"));
}

static void energies_that_are_no_numbers_stop_the_run(void **state)
{
  (void)state;
  said s;
  write_text("bar.yaml", scene);
  shell(&s, "sunder run bar.yaml --quiet --set material.toughness=2e300");
  assert_int_equal(s.code, 2);
  assert_non_null(strstr(s.err, "sunder: the run's energy is no number at t = "));
  assert_false(exists("out/bar/summary.json"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_sound_step_under_a_sudden_load_is_not_stopped),
      cmocka_unit_test(a_step_above_the_limit_is_stopped_by_its_energy_with_time_and_point),
      cmocka_unit_test(energy_from_bonds_that_break_is_told_too),
      cmocka_unit_test(energies_that_are_no_numbers_stop_the_run),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
