/* output: summary.json. */
#include "output_body.h"

#include "output/summary.h"

#include <jansson.h>

static sdr_summary make(body *b)
{
  strcpy(b->scene->name, "cube");
  strcpy(b->scene->title, "A \"cube\"");
  strcpy(b->scene->time.integrator, "leapfrog");
  b->scene->dimension = SDR_PLANE_STRAIN;
  b->scene->damage.law = SDR_LAW_CRITICAL_STRETCH;
  return (sdr_summary){.scene = b->scene,
                       .commit = "abc123",
                       .instruction_set = "avx2",
                       .threads = 2,
                       .points = 10,
                       .bonds = 100,
                       .pairs = 50,
                       .runs = 4,
                       .loose = 3,
                       .steps = 1000,
                       .step_size = 1e-7,
                       .time_end = 1e-4,
                       .wall_setup = 0.5,
                       .wall_integrate = 2e-4,
                       .wall_output = 0.25,
                       .wall_total = 3.0,
                       .stable_step = 1.8e-7,
                       .books = {.kinetic = 1.0,
                                 .stored = 2.0,
                                 .dissipated = 3.0,
                                 .viscous = 0.25,
                                 .contact = 0.125,
                                 .refinement = -0.375,
                                 .external_work = 6.75,
                                 .imbalance = -0.5,
                                 .imbalance_relative = -0.05,
                                 .imbalance_largest = 0.06,
                                 .linear_residual = 1e-15,
                                 .angular_residual = 2e-15,
                                 .max_damage = 0.9,
                                 .broken = 7},
                       .onset_time = 43.6e-6,
                       .damage_max = 0.75,
                       .damage_mean = 0.125,
                       .fragments_known = 1,
                       .fragments = {.count = 3, .largest = 8, .single = 1}};
}

static json_t *load(const body *b)
{
  json_error_t error;
  json_t *root = json_load_file(body_path(b, "summary.json"), 0, &error);
  assert_non_null(root);
  return root;
}

/* The keys of an object in their order, one blank between. */
static const char *keys_of(json_t *object)
{
  static char text[1024];
  const char *key;
  json_t *value;
  text[0] = '\0';
  json_object_foreach(object, key, value)
  {
    if (*text) strcat(text, " ");
    strcat(text, key);
  }
  return text;
}

static void the_keys_are_those_of_the_contract_in_order(void **state)
{
  (void)state;
  body b;
  body_create(&b, 1, 1);
  const sdr_summary summary = make(&b);
  assert_int_equal(sdr_summary_write(b.directory, &summary), SDR_OK);
  json_t *root = load(&b);
  assert_string_equal(keys_of(root),
                      "program version commit scene title dimension model damage_law integrator "
                      "precision threads points bonds pairs runs loose steps step time_end "
                      "wall_seconds ns_per_bond_step peak_memory_bytes energy momentum damage "
                      "fragments solver skipped figures");
  assert_string_equal(keys_of(json_object_get(root, "wall_seconds")),
                      "setup integrate output total");
  assert_string_equal(
      keys_of(json_object_get(root, "energy")),
      "kinetic stored dissipated viscous contact refinement external_work imbalance "
      "imbalance_relative "
      "imbalance_largest");
  assert_string_equal(keys_of(json_object_get(root, "momentum")), "linear angular");
  assert_string_equal(keys_of(json_object_get(root, "damage")), "onset_time max mean");
  assert_string_equal(keys_of(json_object_get(root, "fragments")), "count largest");
  json_decref(root);
  body_destroy(&b);
}

static double real_at(json_t *root, const char *group, const char *key)
{
  return json_number_value(json_object_get(group ? json_object_get(root, group) : root, key));
}

static const char *text_at(json_t *root, const char *key)
{
  return json_string_value(json_object_get(root, key));
}

static void values_arrive_with_every_digit(void **state)
{
  (void)state;
  body b;
  body_create(&b, 1, 1);
  const sdr_summary summary = make(&b);
  assert_int_equal(sdr_summary_write(b.directory, &summary), SDR_OK);
  json_t *root = load(&b);
  assert_string_equal(text_at(root, "program"), "sunder");
  assert_string_equal(text_at(root, "title"), "A \"cube\"");
  assert_string_equal(text_at(root, "dimension"), "plane_strain");
  assert_string_equal(text_at(root, "model"), "bond_based");
  assert_string_equal(text_at(root, "damage_law"), "critical_stretch");
  assert_string_equal(text_at(root, "precision"), "double");
  assert_true(real_at(root, "damage", "onset_time") == 43.6e-6);
  assert_true(real_at(root, "energy", "viscous") == 0.25);
  assert_true(real_at(root, "energy", "contact") == 0.125);
  assert_true(real_at(root, "energy", "refinement") == -0.375);
  assert_true(real_at(root, "energy", "imbalance_largest") == 0.06);
  assert_true(real_at(root, "momentum", "angular") == 2e-15);
  assert_true(real_at(root, "fragments", "largest") == 8.0);
  assert_true(fabs(real_at(root, NULL, "ns_per_bond_step") - 2.0) < 1e-12);
  assert_true(real_at(root, NULL, "peak_memory_bytes") > 1e6);
  json_decref(root);
  body_destroy(&b);
}

static void what_is_not_known_is_null(void **state)
{
  (void)state;
  body b;
  body_create(&b, 1, 1);
  sdr_summary summary = make(&b);
  summary.onset_time = NAN;
  summary.commit = NULL;
  summary.steps = 0;
  summary.wall_integrate = 0.0;
  summary.fragments_known = 0;
  summary.books.imbalance = INFINITY;
  assert_int_equal(sdr_summary_write(b.directory, &summary), SDR_OK);
  json_t *root = load(&b);
  assert_true(json_is_null(json_object_get(json_object_get(root, "damage"), "onset_time")));
  assert_true(json_is_null(json_object_get(json_object_get(root, "energy"), "imbalance")));
  assert_true(json_is_null(json_object_get(json_object_get(root, "fragments"), "count")));
  assert_true(json_is_null(json_object_get(root, "commit")));
  assert_true(json_is_null(json_object_get(root, "ns_per_bond_step")));
  json_decref(root);
  body_destroy(&b);
}

static void the_cost_of_a_resumed_run_counts_its_own_steps(void **state)
{
  (void)state;
  body b;
  body_create(&b, 1, 1);
  sdr_summary summary = make(&b);
  summary.steps_run = 100;
  assert_int_equal(sdr_summary_write(b.directory, &summary), SDR_OK);
  json_t *root = load(&b);
  assert_true(real_at(root, NULL, "steps") == 1000.0);
  assert_true(fabs(real_at(root, NULL, "ns_per_bond_step") - 20.0) < 1e-12);
  json_decref(root);
  body_destroy(&b);
}

static const sdr_measured measured[] = {{"onset_time", 44e-6, 0}, {"through_cracks", NAN, 0}};

static void name_figures(body *b, sdr_figure *figures, int count)
{
  b->scene->figure = figures;
  b->scene->figure_count = count;
}

static void figures_hold_value_range_and_the_papers_value(void **state)
{
  (void)state;
  body b;
  sdr_figure figures[2] = {{"through_cracks", 5.0, NAN, NAN, {"s.yaml", 1, 1}},
                           {"onset_time", 41.6e-6, 45.6e-6, 43.6e-6, {"s.yaml", 2, 1}}};
  body_create(&b, 1, 1);
  sdr_summary summary = make(&b);
  name_figures(&b, figures, 2);
  summary.measured = measured;
  summary.measured_count = 2;
  assert_int_equal(sdr_summary_write(b.directory, &summary), SDR_OK);
  json_t *root = load(&b);
  json_t *all = json_object_get(root, "figures");
  assert_string_equal(keys_of(all), "through_cracks onset_time");
  json_t *onset = json_object_get(all, "onset_time");
  assert_string_equal(keys_of(onset), "value low high paper");
  assert_true(real_at(all, "onset_time", "value") == 44e-6);
  assert_true(real_at(all, "onset_time", "high") == 45.6e-6);
  assert_true(real_at(all, "onset_time", "paper") == 43.6e-6);
  json_t *cracks = json_object_get(all, "through_cracks");
  assert_true(json_is_null(json_object_get(cracks, "value")));
  assert_true(json_is_null(json_object_get(cracks, "high")));
  assert_true(real_at(all, "through_cracks", "low") == 5.0);
  json_decref(root);
  body_destroy(&b);
}

static void measures_stand_among_the_figures_without_a_range(void **state)
{
  (void)state;
  body b;
  sdr_figure figure = {"tip", 1.0, 3.0, 2.5, {"s.yaml", 1, 1}};
  const sdr_measured with_measures[] = {
      {"onset_time", 44e-6, 0}, {"error", 0.5, 1}, {"tip", 2.0, 1}};
  body_create(&b, 1, 1);
  sdr_summary summary = make(&b);
  name_figures(&b, &figure, 1);
  summary.measured = with_measures;
  summary.measured_count = 3;
  assert_int_equal(sdr_summary_write(b.directory, &summary), SDR_OK);
  json_t *root = load(&b);
  json_t *all = json_object_get(root, "figures");
  assert_string_equal(keys_of(all), "tip error");
  assert_true(real_at(all, "tip", "value") == 2.0);
  assert_true(real_at(all, "tip", "high") == 3.0);
  assert_true(real_at(all, "error", "value") == 0.5);
  assert_true(json_is_null(json_object_get(json_object_get(all, "error"), "low")));
  json_decref(root);
  body_destroy(&b);
}

static void a_figure_that_nothing_measures_is_refused(void **state)
{
  (void)state;
  body b;
  sdr_figure figure = {"crack_speed", 0.0, 1.0, NAN, {"s.yaml", 40, 5}};
  body_create(&b, 1, 1);
  sdr_summary summary = make(&b);
  name_figures(&b, &figure, 1);
  summary.measured = measured;
  summary.measured_count = 2;
  static const char wanted[] = "s.yaml:40:5: nothing measures the figure 'crack_speed'; this run "
                               "measures onset_time, through_cracks";
  assert_int_equal(sdr_figures_check(b.scene, measured, 2), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), wanted);
  assert_int_equal(sdr_summary_write(b.directory, &summary), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), wanted);
  assert_false(body_has(&b, "summary.json"));
  body_destroy(&b);
}

static void skipped_features_are_listed(void **state)
{
  (void)state;
  body b;
  const char *const skipped[] = {"fragments: no damage law", "\xff not text"};
  body_create(&b, 1, 1);
  sdr_summary summary = make(&b);
  summary.skipped = skipped;
  summary.skipped_count = 2;
  assert_int_equal(sdr_summary_write(b.directory, &summary), SDR_OK);
  json_t *root = load(&b);
  json_t *list = json_object_get(root, "skipped");
  assert_int_equal(json_array_size(list), 2);
  assert_string_equal(json_string_value(json_array_get(list, 0)), skipped[0]);
  assert_true(json_is_null(json_array_get(list, 1)));
  json_decref(root);
  body_destroy(&b);
}

static int write_summary(void *context)
{
  body *b = context;
  char wanted[256];
  const sdr_summary summary = make(b);
  snprintf(wanted, sizeof wanted, "cannot write %s/summary.json: File too large", b->directory);
  return sdr_summary_write(b->directory, &summary) == SDR_IO_ERROR &&
                 strcmp(sdr_error_message(), wanted) == 0
             ? 0
             : 1;
}

static void a_full_disk_leaves_no_summary(void **state)
{
  (void)state;
  body b;
  body_create(&b, 1, 1);
  assert_int_equal(body_with_full_disk(300, write_summary, &b), 0);
  assert_false(body_has(&b, "summary.json"));
  assert_false(body_has(&b, "summary.json.part"));
  body_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_keys_are_those_of_the_contract_in_order),
      cmocka_unit_test(values_arrive_with_every_digit),
      cmocka_unit_test(what_is_not_known_is_null),
      cmocka_unit_test(the_cost_of_a_resumed_run_counts_its_own_steps),
      cmocka_unit_test(figures_hold_value_range_and_the_papers_value),
      cmocka_unit_test(measures_stand_among_the_figures_without_a_range),
      cmocka_unit_test(a_figure_that_nothing_measures_is_refused),
      cmocka_unit_test(skipped_features_are_listed),
      cmocka_unit_test(a_full_disk_leaves_no_summary),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
