/* The program as a whole: scenes with an equation. */
#include "support/program.h"

#include <jansson.h>
#include <math.h>

/* A solution of degree n is exact with operators of order n, in each kind, form and dimension. */
static const char square[] = "title: Square\n"
                             "dimension: 2d\n"
                             "points: {shape: {box: {from: [0, 0], to: [1 m, 1 m]}},\n"
                             "  spacing: 0.1 m, jitter: {share: 20 %}}\n"
                             "equation:\n"
                             "  kind: poisson\n"
                             "  conductivity: 3\n"
                             "  source: -18\n"
                             "  exact: x^2+2*y^2-x*y\n"
                             "  boundary:\n"
                             "    - {on: [left, bottom, top], value: exact}\n"
                             "    - {on: right, flux: 3*(2*x-y)}\n"
                             "figures: {error_l2: {high: 1e-12}}\n";
static const char solid[] = "title: Block\n"
                            "dimension: 3d\n"
                            "points: {shape: {box: {from: [0, 0, 0], to: [1 m, 1 m, 1 m]}},\n"
                            "  spacing: 0.25 m}\n"
                            "equation:\n"
                            "  kind: elasticity\n"
                            "  young: 1 GPa\n"
                            "  poisson: 0.25\n"
                            "  support: {radius: 2.5 spacing}\n"
                            "  weight: constant\n"
                            "  singular: enlarge\n"
                            "  exact: [1e-3*x, 2e-3*y+1e-3*x, -1e-3*z]\n"
                            "  exact_stress: [1.6e6, 2.4e6, 0, 0, 0, 4e5]\n"
                            "  boundary:\n"
                            "    - {on: [left, bottom, top, back, front], displacement: exact}\n"
                            "    - {on: right, traction: [1.6e6, 4e5, 0]}\n";
static const char bar[] = "title: Bar\n"
                          "dimension: 1d\n"
                          "points: {shape: {box: {from: [0], to: [1 m]}}, spacing: 0.1 m,\n"
                          "  area: 2 m^2}\n"
                          "equation:\n"
                          "  kind: elasticity\n"
                          "  form: variational\n"
                          "  young: 2 Pa\n"
                          "  exact: [x]\n"
                          "  exact_stress: [2]\n"
                          "  boundary:\n"
                          "    - {on: left, displacement: [0]}\n"
                          "    - {on: right, traction: [2]}\n";

static double figure(const char *directory, const char *name)
{
  char path[200];
  json_error_t error;
  snprintf(path, sizeof path, "%s/summary.json", directory);
  json_t *root = json_load_file(path, 0, &error);
  if (!root) fail_msg("%s: %s", path, error.text);
  const json_t *one = json_object_get(json_object_get(root, "figures"), name);
  if (!one) fail_msg("%s: no figure %s", path, name);
  const double value = json_number_value(json_object_get(one, "value"));
  json_decref(root);
  return value;
}

static void polynomials_of_the_operators_order_are_exact_by_collocation(void **state)
{
  (void)state;
  said s;
  write_text("square.yaml", square);
  write_text("solid.yaml", solid);
  succeed(&s, "sunder run square.yaml --quiet && sunder run solid.yaml --quiet");
  assert_true(figure("out/square", "error_l2") < 1e-12);
  assert_true(figure("out/solid", "error_l2") < 1e-12);
  assert_true(figure("out/solid", "error_stress") < 1e-12);
}

/* A functional needs whole supports for that: the lattice goes on around what is held. */
static void and_by_the_functional_inside_a_frame(void **state)
{
  (void)state;
  said s;
  write_text("solid.yaml", solid);
  succeed(&s, "sunder run solid.yaml --quiet --set equation.form=variational "
              "--set equation.order=1 --set equation.support.radius='1.5 spacing' "
              "--set points.shape.box.from='[-0.75, -0.75, -0.75]' "
              "--set points.shape.box.to='[1.75, 1.75, 1.75]' "
              "--set equation.boundary='[{on: {difference: "
              "[{box: {from: [-9, -9, -9], to: [9, 9, 9]}}, "
              "{box: {from: [0.1, 0.1, 0.1], to: [0.9, 0.9, 0.9]}}]}, displacement: exact}]'");
  assert_true(figure("out/solid", "error_l2") < 1e-12);
  assert_true(figure("out/solid", "error_stress") < 1e-12);
}

/* The traction's work is that of the whole section; at its ends a functional is of order 1. */
static void a_pulled_bar_stretches_by_stress_over_modulus(void **state)
{
  (void)state;
  said s;
  write_text("bar.yaml", bar);
  succeed(&s, "sunder run bar.yaml --quiet --set equation.coarser='[0.2 m]'");
  assert_true(figure("out/bar", "error_l2") < 0.02);
  assert_true(figure("out/bar", "order") > 0.7);
}

static void a_run_leaves_what_other_runs_leave(void **state)
{
  (void)state;
  said s;
  write_text("square.yaml", square);
  succeed(&s, "sunder run square.yaml --quiet");
  assert_non_null(strstr(s.out, "Square: 121 points\n"));
  assert_non_null(strstr(s.out, "equation            poisson: -k lap u = source\n"));
  assert_non_null(strstr(s.out, ", accepted up to 1e-12\n"));
  assert_true(exists("out/square/used.yaml") && exists("out/square/snapshots.h5") &&
              exists("out/square/snapshots.xdmf"));
  succeed(&s, "sunder plot out/square && sunder plot out/square --field value -o u.png");
  assert_true(exists("out/square/error.png") && exists("u.png"));
  succeed(&s, "sunder run square.yaml --quiet -o few --set output.snapshots=0");
  assert_false(exists("few/snapshots.h5"));
  succeed(&s, "sunder check square.yaml");
  assert_non_null(strstr(s.out, "points              121, spacing 100 mm, 121 unknowns"));
  assert_non_null(strstr(s.out, "  points.jitter.inside = true\n"));
}

static void what_was_used_gives_the_same_bits_again_on_any_threads(void **state)
{
  (void)state;
  said s;
  write_text("square.yaml", square);
  succeed(&s, "sunder run square.yaml --quiet --threads 1 -o one && "
              "sunder run one/used.yaml --quiet --threads 3 -o three");
  assert_true(figure("one", "error_l2") == figure("three", "error_l2"));
}

static void a_study_gives_the_order(void **state)
{
  (void)state;
  said s;
  write_text("square.yaml", square);
  succeed(&s, "sunder run square.yaml --quiet --set equation.exact='sin(x)*sin(y)' "
              "--set equation.source='6*sin(x)*sin(y)' "
              "--set equation.boundary.1.flux='3*cos(x)*sin(y)' --set equation.coarser='[0.2 m]' "
              "--set figures.error_l2.high=1");
  assert_true(figure("out/square", "order") > 1.7);
  assert_non_null(strstr(s.out, "spacing 0.2         36 points, error "));
}

static void there_is_nothing_to_resume(void **state)
{
  (void)state;
  said s;
  write_text("square.yaml", square);
  refuse(&s, "sunder run square.yaml --resume out/square/checkpoint.h5", 1,
         "sunder: --resume: an equation is solved at once, so there is nothing to go on with; run "
         "the scene without it\n");
}

/* Nothing holds the bar: the matrix has no inverse. */
static void a_body_that_nothing_holds_fails(void **state)
{
  (void)state;
  said s;
  write_text("bar.yaml", bar);
  shell(&s, "sunder run bar.yaml --quiet -o loose "
            "--set equation.boundary='[{on: right, traction: [2]}]'");
  assert_int_equal(s.code, 2);
  assert_false(exists("loose/summary.json"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(polynomials_of_the_operators_order_are_exact_by_collocation),
      cmocka_unit_test(and_by_the_functional_inside_a_frame),
      cmocka_unit_test(a_pulled_bar_stretches_by_stress_over_modulus),
      cmocka_unit_test(a_run_leaves_what_other_runs_leave),
      cmocka_unit_test(what_was_used_gives_the_same_bits_again_on_any_threads),
      cmocka_unit_test(a_study_gives_the_order),
      cmocka_unit_test(there_is_nothing_to_resume),
      cmocka_unit_test(a_body_that_nothing_holds_fails),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
