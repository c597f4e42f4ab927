/* Stripes in which nothing has moved are skipped without a change of one bit (design sec. 2). */
#include "support/scene_text.h"

static const char *const knocked =
    "dimension: plane_stress\n"
    "points: {shape: {box: {from: [0, 0], to: [%s]}}, spacing: 1 mm%s}\n"
    "material: {young: 70 GPa, density: 2500 kg/m^3, toughness: 0.02 J/m^2, strength: 0.5 MPa}\n"
    "damage: {law: %s}\n"
    "loads: [{traction: {on: %s, value: [-2 MPa, 3 MPa]}}]\n"
    "supports: [{on: %s, depth: 3 spacing, displacement: {x: 0}, velocity: {y: 0}}]\n"
    "time: {step: 0.1 us, end: 20 us}\n";

static const char *const bodies[][4] = {
    {"60 mm, 200 mm", "", "bottom", "top"},
    {"600 mm, 7 mm", "", "right", "left"},
    {"60 mm, 60 mm", ", jitter: {share: 20 %}", "bottom", "top"}};

static void compare_runs(const sdr_built *a, const sdr_built *b)
{
  const size_t bytes = (size_t)a->points->count * sizeof(double);
  sdr_balance first, second;
  for (int c = 0; c < 2; ++c) {
    assert_memory_equal(a->system->u[c], b->system->u[c], bytes);
    assert_memory_equal(a->system->v[c], b->system->v[c], bytes);
    assert_memory_equal(a->system->f[c], b->system->f[c], bytes);
  }
  sdr_system_balance(a->system, &first);
  sdr_system_balance(b->system, &second);
  assert_memory_equal(&first, &second, sizeof first);
}

static void skipping_what_rests_changes_no_bit(void **state)
{
  (void)state;
  static const char *const laws[] = SDR_LAW_NAMES;
  for (int k = 0; k < 3; ++k)
    for (int law = 0; law < SDR_LAW_COUNT; ++law) {
      sdr_built skipping, all;
      scene_build(&skipping, knocked, bodies[k][0], bodies[k][1], laws[law], bodies[k][2],
                  bodies[k][3]);
      scene_build(&all, knocked, bodies[k][0], bodies[k][1], laws[law], bodies[k][2], bodies[k][3]);
      all.model->ops->skip_rest(all.model, 0);
      run_start(&skipping);
      run_start(&all);
      const double at_first = body_traits(skipping.model).moved;
      for (int n = 0; n < 200; ++n) {
        run_step(&skipping);
        run_step(&all);
        if (n % 20 == 0) compare_runs(&skipping, &all);
      }
      compare_runs(&skipping, &all);
      assert_true(at_first < 0.2);
      assert_true(body_traits(skipping.model).moved > at_first);
      if (law > 0) {
        sdr_energies e;
        all.model->ops->energies(all.model, all.system->u, &e);
        assert_true(e.max_damage > 0.3);
      }
      sdr_built_destroy(&skipping);
      sdr_built_destroy(&all);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(skipping_what_rests_changes_no_bit)};
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
