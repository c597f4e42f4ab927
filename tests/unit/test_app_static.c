/* app: the static solution as a user sees it. */
#include "support/program.h"

#include <jansson.h>
#include <math.h>

static const char scene[] = "title: Held plate\n"
                            "dimension: plane_stress\n"
                            "points: {shape: {box: {from: [0, 0], to: [40 mm, 20 mm]}}, "
                            "spacing: 1 mm, align: cell}\n"
                            "material: {young: 200 GPa, density: 7800 kg/m^3}\n"
                            "supports: [{name: wall, on: left, displacement: {x: 0, y: 0}}]\n"
                            "loads: [{traction: {on: right, value: [1 kPa, -2 kPa]}}]\n"
                            "time: {integrator: static}\n"
                            "output: {snapshots: 4, fields: [displacement, reaction]}\n";

static double number(const json_t *object, const char *key)
{
  const json_t *value = json_object_get(object, key);
  if (!json_is_number(value)) fail_msg("no number '%s'", key);
  return json_number_value(value);
}

static void a_run_has_one_step_and_says_what_it_solved(void **state)
{
  (void)state;
  said s;
  write_text("plate.yaml", scene);
  succeed(&s, "sunder run plate.yaml --quiet");
  assert_non_null(strstr(s.out, "solver              cholmod: 1560 unknowns, "));
  assert_non_null(strstr(s.out, "bent body's forces  differ by "));
  assert_non_null(strstr(s.out, "assembled in "));
  json_t *summary = json_load_file("out/plate/summary.json", 0, NULL);
  assert_non_null(summary);
  assert_string_equal(json_string_value(json_object_get(summary, "integrator")), "static");
  assert_true(number(summary, "steps") == 1.0);
  assert_true(number(summary, "time_end") == 1.0);
  const json_t *energy = json_object_get(summary, "energy");
  assert_true(number(energy, "stored") > 0.0 && number(energy, "kinetic") == 0.0);
  assert_true(number(energy, "imbalance_largest") < 1e-6);
  const json_t *solver = json_object_get(summary, "solver");
  assert_string_equal(json_string_value(json_object_get(solver, "name")), "cholmod");
  assert_true(json_is_null(json_object_get(solver, "stable_step")));
  assert_true(number(solver, "unknowns") == 1560.0);
  assert_true(number(solver, "nonzeros") > 20.0 * 1560.0);
  assert_true(number(solver, "memory_bytes") > 12.0 * number(solver, "nonzeros") / 2.0);
  assert_true(number(solver, "iterations") == 0.0);
  assert_true(number(solver, "residual") < 1e-12 && number(solver, "nonlinearity") < 1e-6);
  assert_true(number(solver, "assemble_seconds") > 0.0);
  assert_true(number(solver, "factor_seconds") > 0.0);
  assert_true(number(solver, "solve_seconds") > 0.0);
  json_decref(summary);
}

#define MEASURED(what) "sunder run plate.yaml --quiet --set output.measures='{pull: {" what "}}'"

static void a_support_s_reaction_can_be_measured(void **state)
{
  (void)state;
  said s;
  write_text("plate.yaml", scene);
  succeed(&s, MEASURED("kind: value, quantity: reaction, support: wall, component: x"));
  json_t *summary = json_load_file("out/plate/summary.json", 0, NULL);
  assert_non_null(summary);
  const json_t *figure = json_object_get(json_object_get(summary, "figures"), "pull");
  assert_true(fabs(number(figure, "value") + 1e3 * 0.02) < 1e-8 * 20.0);
  json_decref(summary);
  shell(&s, MEASURED("kind: value, quantity: reaction, support: floor, component: x"));
  assert_int_equal(s.code, 1);
  assert_non_null(strstr(s.err, "measure pull: no support has the name 'floor'"));
  shell(&s, MEASURED("kind: value, quantity: reaction, support: wall, component: norm"));
  assert_int_equal(s.code, 1);
  assert_non_null(strstr(s.err, "a reaction is measured by component: x, y or z"));
  shell(
      &s,
      MEASURED(
          "kind: value, quantity: reaction, support: wall, component: y") " --set "
                                                                          "supports.0.displacement="
                                                                          "'{x: 0}'");
  assert_int_equal(s.code, 1);
  assert_non_null(strstr(s.err, "measure pull: the support 'wall' leaves y free"));
}

/* The row before the loads and the one with them; the wall takes what the traction gives. */
static void its_history_has_two_rows_with_the_reactions(void **state)
{
  (void)state;
  said s;
  write_text("plate.yaml", scene);
  succeed(&s,
          "sunder run plate.yaml --quiet >/dev/null; sed -n 1p out/plate/history.csv | tr , "
          "'\\n' | grep -n wall; wc -l <out/plate/history.csv; tail -n 1 out/plate/history.csv");
  int x, y, lines;
  char last[4000];
  assert_int_equal(sscanf(s.out, "%d:%*s\n%d:%*s\n%d\n%3999s", &x, &y, &lines, last), 4);
  assert_int_equal(lines, 3);
  double value[2] = {0.0};
  int column = 1;
  for (char *at = strtok(last, ","); at; at = strtok(NULL, ","), ++column)
    if (column == x || column == y) value[column == y] = atof(at);
  assert_true(fabs(value[0] + 1e3 * 0.02) < 1e-8 * 20.0);
  assert_true(fabs(value[1] - 2e3 * 0.02) < 1e-8 * 40.0);
}

static void check_says_what_would_be_solved(void **state)
{
  (void)state;
  said s;
  write_text("plate.yaml", scene);
  succeed(&s, "sunder check plate.yaml");
  assert_non_null(strstr(s.out, "static solution     at t = 1 s: 1600 components, 40 of them "
                                "prescribed; solver auto\n"));
  assert_non_null(strstr(s.out, "integrator static\n"));
  assert_non_null(strstr(s.out, "\n  steps in time: static solution\n"));
  assert_non_null(strstr(s.out, "\n  time.end = 1 s\n"));
  assert_null(strstr(s.out, "stable step"));
}

static void check_counts_a_prescribed_mean_once(void **state)
{
  (void)state;
  said s;
  write_text("plate.yaml", scene);
  succeed(&s, "sunder check plate.yaml --set supports.0.mean=true");
  assert_non_null(strstr(s.out, ": 1600 components, 2 of them prescribed; "));
}

static void used_yaml_runs_again(void **state)
{
  (void)state;
  said s;
  write_text("plate.yaml", scene);
  succeed(&s, "sunder run plate.yaml --quiet --set time.solver=pcg >/dev/null");
  succeed(&s, "sunder run out/plate/used.yaml --quiet -o again");
  assert_non_null(strstr(s.out, "solver              pcg: 1560 unknowns, "));
  assert_non_null(strstr(s.out, " iterations\n"));
}

static void a_body_that_nothing_holds_ends_with_its_message(void **state)
{
  (void)state;
  said s;
  write_text("plate.yaml", scene);
  refuse(&s, "sunder run plate.yaml --quiet --set supports='[]' -o loose", 1,
         "sunder: nothing keeps the body from moving along x; prescribe that component of some of "
         "its points (supports)\n");
  assert_false(exists("loose/summary.json"));
}

static void a_step_of_another_integrator_is_said_to_be_idle(void **state)
{
  (void)state;
  said s;
  write_text("plate.yaml", scene);
  shell(&s, "sunder run plate.yaml --set time.step='1 us' --set time.safety=0.5 >/dev/null");
  assert_int_equal(s.code, 0);
  assert_non_null(strstr(s.err, "warning: time.step does not matter to a static solution"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_run_has_one_step_and_says_what_it_solved),
      cmocka_unit_test(a_support_s_reaction_can_be_measured),
      cmocka_unit_test(its_history_has_two_rows_with_the_reactions),
      cmocka_unit_test(check_says_what_would_be_solved),
      cmocka_unit_test(check_counts_a_prescribed_mean_once),
      cmocka_unit_test(used_yaml_runs_again),
      cmocka_unit_test(a_body_that_nothing_holds_ends_with_its_message),
      cmocka_unit_test(a_step_of_another_integrator_is_said_to_be_idle),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
