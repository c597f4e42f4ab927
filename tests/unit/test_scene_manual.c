/* scene: every example of the manual and of the README loads. Examples that are parts of a scene
   are completed by sections of one that fits. */
#include "scene/scene.h"
#include "support/cmocka_all.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { ROOM = 120000, SCENE_ROOM = 4000 };

/* What completes an example, each left out where the example has it. */
static const struct {
  const char *key, *text;
} filling[] = {
    {"dimension", "dimension: plane_stress\n"},
    {"points", "points: {shape: {difference: [{box: {from: [0, 0], to: [100 mm, 40 mm]}}, hole]}, "
               "spacing: 1 mm}\n"},
    {"material", "material: {young: 72 GPa, density: 2440 kg/m^3, toughness: 3.8 J/m^2}\n"},
    {"damage", "damage: {law: critical_stretch}\n"},
    {"regions", "regions: {hole: {disc: {radius: 5 mm, centre: [50 mm, 20 mm]}}}\n"},
    {"time", "time: {end: 10 ms, step: 10 ns}\n"},
};

/* Whether a line of `text` begins with `key` and a colon. */
static int has_section(const char *text, const char *key)
{
  const size_t length = strlen(key);
  for (const char *line = text; line; line = strchr(line, '\n') ? strchr(line, '\n') + 1 : NULL)
    if (strncmp(line, key, length) == 0 && line[length] == ':') return 1;
  return 0;
}

/* Append to `scene` what `example` lacks of a scene. An equation needs none of it. */
static void complete(const char *example, char *scene, size_t room)
{
  const int is_fixed = has_section(example, "supports") || has_section(example, "loads");
  if (has_section(example, "equation")) return;
  for (size_t k = 0; k < sizeof filling / sizeof *filling; ++k)
    if (!has_section(example, filling[k].key))
      strncat(scene, filling[k].text, room - strlen(scene) - 1);
  if (!is_fixed)
    strncat(scene, "loads: [{traction: {on: top, value: [0, 12 MPa]}}]\n",
            room - strlen(scene) - 1);
}

static void load_text(const char *text)
{
  sdr_scene *scene = NULL;
  if (sdr_scene_parse(text, "example", &scene) != SDR_OK)
    fail_msg("%s\n%s", sdr_error_message(), text);
  sdr_scene_destroy(&scene);
}

/* Lines "value: FORMULA": of a load or, by its unit, of a velocity. */
static void load_values(const char *example)
{
  char formula[200], scene[SCENE_ROOM];
  for (const char *at = example; *at; at += strcspn(at, "\n") + 1) {
    const char *value = at + strlen("value: ");
    snprintf(formula, sizeof formula, "%.*s", (int)strcspn(value, "\n"), value);
    if (strstr(formula, "m/s"))
      snprintf(scene, sizeof scene, "initial: {velocity: [{value: [%s, 0]}]}\n", formula);
    else
      snprintf(scene, sizeof scene, "loads:\n  - pressure: {on: top, value: %s}\n", formula);
    complete(scene, scene, sizeof scene);
    load_text(scene);
  }
}

static void load_example(const char *example)
{
  char scene[SCENE_ROOM];
  if (strncmp(example, "value:", 6) == 0) {
    load_values(example);
    return;
  }
  if (strncmp(example, "shape:", 6) == 0)
    snprintf(scene, sizeof scene, "points: {%.*s, spacing: 1 mm}\n", (int)strcspn(example, "\n"),
             example);
  else
    snprintf(scene, sizeof scene, "%s", example);
  complete(scene, scene, sizeof scene);
  load_text(scene);
}

/* The number of examples in a file. */
static int load_examples(const char *path)
{
  static char text[ROOM];
  int count = 0;
  FILE *stream = fopen(path, "r");
  assert_non_null(stream);
  const size_t length = fread(text, 1, sizeof text - 1, stream);
  assert_true(length < sizeof text - 1);
  text[length] = '\0';
  fclose(stream);
  for (char *begin = strstr(text, "```yaml\n"); begin; begin = strstr(begin, "```yaml\n")) {
    begin += strlen("```yaml\n");
    char *end = strstr(begin, "```");
    assert_non_null(end);
    *end = '\0';
    load_example(begin);
    ++count;
    begin = end + 1;
  }
  return count;
}

/* In a folder with the table that one of them names. */
static void every_example_of_the_manual_loads(void **state)
{
  (void)state;
  char folder[] = "/tmp/sunder_manual_XXXXXX";
  assert_non_null(mkdtemp(folder));
  assert_int_equal(chdir(folder), 0);
  FILE *table = fopen("tip.csv", "w");
  assert_non_null(table);
  fputs("t,ux\n0,0\n0.004,1e-3\n", table);
  assert_int_equal(fclose(table), 0);
  assert_true(load_examples(SUNDER_SOURCE_DIR "/docs/scene.md") >= 15);
  assert_int_equal(unlink("tip.csv"), 0);
  assert_int_equal(rmdir(folder), 0);
}

static void every_example_of_the_readme_loads(void **state)
{
  (void)state;
  assert_true(load_examples(SUNDER_SOURCE_DIR "/README.md") >= 1);
}

int main(void)
{
  const struct CMUnitTest tests[] = {cmocka_unit_test(every_example_of_the_manual_loads),
                                     cmocka_unit_test(every_example_of_the_readme_loads)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
