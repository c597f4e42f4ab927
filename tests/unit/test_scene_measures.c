/* scene: measures and their tables. */
#include "base/memory.h"
#include "scene/scene.h"
#include "scene/table.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[64];

static int make_folder(void **state)
{
  (void)state;
  strcpy(folder, "sunder_measures_XXXXXX");
  return mkdtemp(folder) == NULL;
}

static int remove_folder(void **state)
{
  char command[100];
  (void)state;
  snprintf(command, sizeof command, "rm -rf %s", folder);
  return system(command);
}

static const char *put_file(const char *name, const char *text)
{
  static char paths[4][128];
  static int turn;
  char *path = paths[turn++ & 3];
  snprintf(path, sizeof paths[0], "%s/%s", folder, name);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fputs(text, file);
  fclose(file);
  return path;
}

/* ---- tables ---------------------------------------------------------------------------------- */

static sdr_status read_table(const char *text, int *rows, double key[10], double value[10])
{
  double *keys = NULL, *values = NULL;
  sdr_store *store = sdr_store_create();
  assert_non_null(store);
  const sdr_status status =
      sdr_table_read(store, put_file("t.csv", text), "x", "u", rows, &keys, &values);
  if (status == SDR_OK) {
    memcpy(key, keys, (size_t)*rows * sizeof *key);
    memcpy(value, values, (size_t)*rows * sizeof *value);
  }
  sdr_store_destroy(&store);
  return status;
}

static void a_table_is_two_columns_of_a_file(void **state)
{
  (void)state;
  int rows = 0;
  double key[10], value[10];
  assert_int_equal(
      read_table("# made by hand\r\n\r\n t , u,x\r\n1, 2.5 ,-1\r\n# half\r\n,-3e2,0\r\n5,7,1e-3",
                 &rows, key, value),
      SDR_OK);
  assert_int_equal(rows, 3);
  assert_true(key[0] == -1.0 && key[1] == 0.0 && key[2] == 1e-3);
  assert_true(value[0] == 2.5 && value[1] == -300.0 && value[2] == 7.0);
}

static void a_wrong_table_is_named_with_its_line(void **state)
{
  (void)state;
  static const struct {
    const char *text, *message;
  } cases[] = {{"", "t.csv: the file is empty"},
               {"# nothing\n", "t.csv: the file is empty"},
               {"x,u\n1,2\n", "t.csv: a table needs at least 2 rows"},
               {"x,v\n1,2\n", "t.csv:1: there is no column 'u' in 'x,v'"},
               {"x,u\n1,2\n1,3\n", "t.csv:3: 1 does not lie above 1, the row before"},
               {"x,u\n1,2\n2\n", "t.csv:3: '' is no number"},
               {"x,u\n1,2\n2,3 m\n", "t.csv:3: '3 m' is no number"},
               {"x,u\n1,2\n2,inf\n", "t.csv:3: 'inf' is no number"}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    int rows = 0;
    double key[10], value[10];
    assert_int_equal(read_table(cases[k].text, &rows, key, value), SDR_BAD_INPUT);
    const char *message = sdr_error_message();
    assert_string_equal(strrchr(message, '/') + 1, cases[k].message);
  }
}

/* ---- scenes ---------------------------------------------------------------------------------- */

#define BODY                                                                                       \
  "dimension: plane_stress\n"                                                                      \
  "points: {shape: {box: {from: [0, 0], to: [10 mm, 4 mm]}}, spacing: 1 mm}\n"                     \
  "material: {young: 72 GPa, density: 2440 kg/m^3}\n"                                              \
  "time: {step: 0.1 us, end: 1 us}\n"

static sdr_scene *load(const char *path, const char *variant)
{
  sdr_scene *scene = NULL;
  if (sdr_scene_load(path, variant, 0, NULL, &scene) != SDR_OK) fail_msg("%s", sdr_error_message());
  return scene;
}

static void what_is_left_out_has_defaults(void **state)
{
  (void)state;
  sdr_scene *scene =
      load(put_file("s.yaml", BODY "output:\n"
                                   "  measures:\n"
                                   "    a: {kind: max, field: damage}\n"
                                   "    b: {kind: mean, field: velocity, component: norm, "
                                   "every: 5}\n"
                                   "    c: {kind: value, field: stress, component: xy, "
                                   "point: [1 mm, 2 mm], at: 0.5 us}\n"
                                   "    d: {kind: min, quantity: kinetic, at: 3 steps}\n"),
           NULL);
  assert_int_equal(scene->output.measure_count, 4);
  const sdr_measurement *m = scene->output.measure;
  assert_string_equal(m[0].name, "a");
  assert_true(isinf(m[0].at.value) && !m[0].over_time && !m[0].at_point);
  assert_string_equal(m[0].on.text, "body");
  assert_true(m[1].over_time && m[1].component == -1 && m[1].every == 5);
  assert_true(isinf(m[1].from) && isinf(m[1].until));
  assert_true(m[2].at_point && m[2].component == 2 && m[2].point[1] == 2e-3);
  assert_true(m[2].at.value == 0.5e-6 && !m[2].at.relative);
  assert_true(m[3].at.relative && m[3].at.value == 3.0);
  assert_string_equal(m[3].quantity, "kinetic");
  sdr_scene_destroy(&scene);
}

static void a_variant_changes_and_drops_measures_and_figures(void **state)
{
  (void)state;
  const char *path = put_file(
      "v.yaml", BODY "output: {measures: {a: {kind: max, field: damage}, b: {kind: min, field: "
                     "damage}}}\n"
                     "figures: {a: {high: 1}, b: {low: 0}}\n"
                     "variants: {short: {output: {measures: {a: null, b: {at: 0 us}}}, figures: "
                     "{a: null}}}\n");
  sdr_scene *scene = load(path, "short");
  assert_int_equal(scene->output.measure_count, 1);
  assert_string_equal(scene->output.measure[0].name, "b");
  assert_true(scene->output.measure[0].at.value == 0.0);
  assert_int_equal(scene->figure_count, 1);
  assert_string_equal(scene->figure[0].name, "b");
  sdr_scene_destroy(&scene);
}

/* A run keeps the scene in its own directory, from where the table must be found too. */
static void a_table_lies_beside_the_scene_and_its_copy_finds_it(void **state)
{
  (void)state;
  put_file("ref.csv", "t,u\n0,1\n1,3\n");
  sdr_scene *scene =
      load(put_file("f.yaml", BODY "output: {measures: {a: {kind: max_error, field: damage, "
                                   "exact: {table: ref.csv, by: t, column: u}}}}\n"),
           NULL);
  const sdr_exact *exact = &scene->output.measure[0].exact;
  assert_int_equal(exact->rows, 2);
  assert_int_equal(exact->by, 't');
  assert_true(exact->value[1] == 3.0);
  FILE *copy = fopen("sunder_measures_copy.yaml", "w");
  assert_non_null(copy);
  fputs(scene->used_yaml, copy);
  fclose(copy);
  sdr_scene *again = load("sunder_measures_copy.yaml", NULL);
  unlink("sunder_measures_copy.yaml");
  assert_int_equal(again->output.measure[0].exact.rows, 2);
  assert_true(again->hash == scene->hash);
  sdr_scene_destroy(&again);
  sdr_scene_destroy(&scene);
}

static void a_series_is_a_formula_of_n(void **state)
{
  (void)state;
  sdr_scene *scene = load(
      put_file("n.yaml", BODY "output: {measures: {a: {kind: l2_error, field: displacement, "
                              "component: x, exact: {series: 1 mm*n*t/(1 s), from: 1, to: 4}}}}\n"),
      NULL);
  const sdr_exact *exact = &scene->output.measure[0].exact;
  double value = 0.0;
  assert_true(exact->is_series && exact->first == 1 && exact->last == 4);
  assert_int_equal(sdr_expression_sum(exact->formula, (double[3]){0.0}, 2.0, 1, 4, &value), SDR_OK);
  assert_true(fabs(value - 0.02) < 1e-15);
  sdr_scene_destroy(&scene);
}

static void measures_do_not_change_the_state(void **state)
{
  (void)state;
  sdr_scene *plain = load(put_file("p.yaml", BODY), NULL);
  sdr_scene *with =
      load(put_file("q.yaml", BODY "output: {measures: {a: {kind: max, field: damage}}}\n"), NULL);
  assert_true(plain->hash == with->hash);
  sdr_scene_destroy(&plain);
  sdr_scene_destroy(&with);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_table_is_two_columns_of_a_file),
      cmocka_unit_test(a_wrong_table_is_named_with_its_line),
      cmocka_unit_test(what_is_left_out_has_defaults),
      cmocka_unit_test(a_variant_changes_and_drops_measures_and_figures),
      cmocka_unit_test(a_table_lies_beside_the_scene_and_its_copy_finds_it),
      cmocka_unit_test(a_series_is_a_formula_of_n),
      cmocka_unit_test(measures_do_not_change_the_state),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
