/* The program with each model: what `check` says of it, what a run writes, warnings. */
#include "support/program.h"

#include <jansson.h>

static const char body[] =
    "dimension: plane_strain\n"
    "points: {shape: {box: {size: [40 mm, 20 mm]}}, spacing: 2 mm, align: cell}\n"
    "material: {young: 70 GPa, density: 2700 kg/m^3, toughness: 1e4 J/m^2}\n"
    "damage: {law: variational}\n"
    "initial: {velocity: [\"x > 0 ? 35 m/s : -35 m/s\", 0]}\n"
    "time: {end: 10 us, safety: 0.5}\n"
    "output: {snapshots: 1}\n";

#define ORDINARY "body.yaml --set material.model=ordinary --set material.poisson=0.3"
#define NONORDINARY "body.yaml --set material.model=nonordinary --set material.poisson=0.3"

static void says(const said *s, const char *line)
{
  if (!strstr(s->out, line)) fail_msg("'%s' is not in\n%s", line, s->out);
}

static void check_names_the_constants_of_an_ordinary_body(void **state)
{
  (void)state;
  said s;
  write_text("body.yaml", body);
  succeed(&s, "sunder check " ORDINARY " --set family.weight='[cubic, partial_volume, iso]'");
  says(&s, "model               ordinary, plane_strain, damage variational, integrator leapfrog\n");
  says(&s, "weights             cubic, partial_volume, iso\n");
  /* E/(2 (1 + nu)(1 - 2 nu)) and E/(2 (1 + nu)); a cut damages three rows on both sides */
  says(&s, "  poisson           0.3\n"
           "  K, G              67.308 GPa (of 2 dimensions), 26.923 GPa\n"
           "  form              standard\n"
           "  damage            ell 0.011538 m, Gc/ell 8.6667e+05 J/m^3, split dilatation\n");
}

static void check_names_the_control_of_a_non_ordinary_body(void **state)
{
  (void)state;
  said s;
  write_text("body.yaml", body);
  succeed(&s, "sunder check " NONORDINARY " --set damage.split=spectral "
              "--set material.control.normal='1 GPa' --set material.elasticity=neo_hookean");
  /* P_s = 2 (5 mu - D)/3 with D = 94.231 GPa */
  says(&s, "  elasticity        neo_hookean\n"
           "  control           P_s 26.923 GPa, P_n 1 GPa (given), of the first point\n"
           "  shape tensors     condition up to ");
  says(&s, "  damage            ell 0.011538 m, Gc/ell 8.6667e+05 J/m^3, split spectral\n");
}

static void check_leaves_a_bond_based_body_its_own_ratio(void **state)
{
  (void)state;
  said s;
  write_text("body.yaml", body);
  succeed(&s, "sunder check body.yaml");
  says(&s, "model               bond_based, plane_strain");
  says(&s, "weights             constant\n");
  says(&s, "  poisson_used      0.25, the law's own\n");
  assert_null(strstr(s.out, "K, G"));
}

static double number_at(const json_t *root, const char *part, const char *key)
{
  const json_t *value = json_object_get(json_object_get(root, part), key);
  if (!json_is_number(value)) fail_msg("%s.%s is no number", part, key);
  return json_number_value(value);
}

/* A body torn in two: damage starts, is dissipated and balanced. */
static void a_run_with_damage_at_the_points_has_all_its_figures(void **state)
{
  (void)state;
  static const char *const runs[] = {
      "sunder run " ORDINARY " -o out --quiet",
      "sunder run " NONORDINARY " -o out --quiet --set damage.split=spectral",
      "sunder run " ORDINARY " -o out --quiet --set damage.law=critical_stretch",
      "sunder run " NONORDINARY " -o out --quiet --set damage.law=critical_stretch"};
  write_text("body.yaml", body);
  for (int k = 0; k < 4; ++k) {
    said s;
    json_error_t error;
    succeed(&s, runs[k]);
    json_t *root = json_load_file("out/summary.json", 0, &error);
    assert_non_null(root);
    const int controlled = k % 2 == 1;
    assert_string_equal(json_string_value(json_object_get(root, "model")),
                        controlled ? "nonordinary" : "ordinary");
    const double bulk = number_at(root, "constants", "bulk");
    assert_true(bulk > 67.3e9 && bulk < 67.4e9);
    const json_t *constants = json_object_get(root, "constants");
    assert_int_equal(json_is_number(json_object_get(constants, "control_shear")), controlled);
    assert_int_equal(json_is_number(json_object_get(constants, "condition")), controlled);
    assert_int_equal(json_is_number(json_object_get(constants, "ell")), k < 2);
    assert_int_equal(json_is_number(json_object_get(constants, "critical_stretch")), k >= 2);
    assert_true(number_at(root, "damage", "onset_time") > 0.0);
    assert_true(number_at(root, "damage", "max") > 0.35);
    assert_true(number_at(root, "energy", "dissipated") > 0.0);
    assert_true(number_at(root, "momentum", "linear") < 1e-12);
    assert_true(number_at(root, "fragments", "count") >= 2.0);
    json_decref(root);
  }
}

static void without_the_dual_horizon_check_and_run_warn(void **state)
{
  (void)state;
  static const char warning[] =
      "family.dual is false: a point feels its own family only, so momentum is not kept\n";
  char line[200];
  said s;
  write_text("body.yaml", body);
  snprintf(line, sizeof line, "warning             %s", warning);
  succeed(&s, "sunder check " ORDINARY " --set family.dual=false");
  says(&s, line);
  snprintf(line, sizeof line, "sunder: warning: %s", warning);
  shell(&s, "sunder run " ORDINARY " --set family.dual=false -o out --set time.end='1 us'");
  assert_int_equal(s.code, 0);
  if (!strstr(s.err, line)) fail_msg("no warning in\n%s", s.err);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(check_names_the_constants_of_an_ordinary_body),
      cmocka_unit_test(check_names_the_control_of_a_non_ordinary_body),
      cmocka_unit_test(check_leaves_a_bond_based_body_its_own_ratio),
      cmocka_unit_test(a_run_with_damage_at_the_points_has_all_its_figures),
      cmocka_unit_test(without_the_dual_horizon_check_and_run_warn),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
