/* scene: every wrong scene gives exactly its message. */
#include "base/memory.h"
#include "scene/scene.h"
#include "support/cmocka_all.h"

#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static void read_text(const char *path, char *text, size_t size)
{
  FILE *stream = fopen(path, "r");
  assert_non_null(stream);
  text[fread(text, 1, size - 1, stream)] = '\0';
  fclose(stream);
}

/* Scenes that can be read and are wrong only once there are points, a step or a directory: the
   whole program's test looks at those. */
static int is_wrong_later(const char *scene)
{
  static const char *const names[] = {"horizon_below_spacing",
                                      "cohesive_horizon",
                                      "horizon_negative_somewhere",
                                      "empty_shape",
                                      "zero_points",
                                      "load_on_nothing",
                                      "support_on_nothing",
                                      "overlapping_supports",
                                      "initial_on_nothing",
                                      "protect_nothing",
                                      "refine_nothing",
                                      "material_without_points",
                                      "step_above_bound",
                                      "formula_not_finite",
                                      "formula_divides_by_zero_later",
                                      "too_many_points",
                                      "unmeasured_figure",
                                      "measure_on_nothing",
                                      "measure_outside",
                                      "measure_beyond_steps",
                                      "measure_beyond_table",
                                      "measure_name_taken",
                                      "directory_not_writable",
                                      "equation_lacks_condition",
                                      "equation_meets_nothing",
                                      "equation_singular",
                                      "equation_round_flux",
                                      "equation_unmeasured",
                                      "equation_value_not_finite"};
  for (size_t k = 0; k < sizeof names / sizeof *names; ++k) {
    const size_t length = strlen(names[k]);
    if (strncmp(scene, names[k], length) == 0 && scene[length] == '.') return 1;
  }
  return 0;
}

/* tests/scenes/bad/NAME.expected holds the message and a newline. */
static void each_bad_scene_gives_its_message(void **state)
{
  (void)state;
  glob_t found;
  assert_int_equal(chdir(SUNDER_SOURCE_DIR "/tests/scenes/bad"), 0);
  assert_int_equal(glob("*.expected", 0, NULL, &found), 0);
  assert_true(found.gl_pathc >= 40);
  int wrong = 0;
  for (size_t k = 0; k < found.gl_pathc; ++k) {
    char scene_path[300], expected[20000], message[20000];
    const char *name = found.gl_pathv[k];
    snprintf(scene_path, sizeof scene_path, "%.*s.yaml", (int)(strlen(name) - strlen(".expected")),
             name);
    read_text(name, expected, sizeof expected);
    sdr_scene *scene = NULL;
    const size_t before = sdr_memory_now();
    const sdr_status status = sdr_scene_load(scene_path, NULL, 0, NULL, &scene);
    sdr_scene_destroy(&scene);
    assert_int_equal(sdr_memory_now(), before);
    if (status == SDR_OK && is_wrong_later(scene_path)) continue;
    assert_int_equal(status, SDR_BAD_INPUT);
    snprintf(message, sizeof message, "%s\n", sdr_error_message());
    if (strcmp(message, expected) == 0) continue;
    print_error("%s\n  wanted: %s  got:    %s", scene_path, expected, message);
    ++wrong;
  }
  globfree(&found);
  assert_int_equal(wrong, 0);
}

static void a_file_that_cannot_be_read_is_an_io_error(void **state)
{
  (void)state;
  sdr_scene *scene = NULL;
  assert_int_equal(sdr_scene_load("nowhere.yaml", NULL, 0, NULL, &scene), SDR_IO_ERROR);
  assert_string_equal(sdr_error_message(),
                      "nowhere.yaml: cannot be read: No such file or directory");
  assert_int_equal(sdr_scene_load("/", NULL, 0, NULL, &scene), SDR_IO_ERROR);
  assert_string_equal(sdr_error_message(), "/: is a directory; give the scene file in it");
  assert_int_equal(sdr_scene_load("/dev/null", NULL, 0, NULL, &scene), SDR_IO_ERROR);
  assert_string_equal(sdr_error_message(), "/dev/null: is not a file");
  assert_null(scene);
}

static void a_huge_file_is_refused_unread(void **state)
{
  (void)state;
  char path[] = "/tmp/sunder_huge_XXXXXX";
  const int file = mkstemp(path);
  assert_true(file >= 0);
  assert_int_equal(ftruncate(file, 100 * 1024 * 1024), 0);
  sdr_scene *scene = NULL;
  char expected[100];
  snprintf(expected, sizeof expected, "%s: larger than 4 MB, so it is no scene file", path);
  assert_int_equal(sdr_scene_load(path, NULL, 0, NULL, &scene), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), expected);
  close(file);
  unlink(path);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_bad_scene_gives_its_message),
      cmocka_unit_test(a_file_that_cannot_be_read_is_an_io_error),
      cmocka_unit_test(a_huge_file_is_refused_unread),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
