/* scene: `output.cracks`. */
#include "scene/scene.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char path[] = "sunder_follow_XXXXXX";

static int make_file(void **state)
{
  (void)state;
  const int file = mkstemp(path);
  return file < 0 || close(file) != 0;
}

static int remove_file(void **state)
{
  (void)state;
  return unlink(path);
}

/* A plane body with a law, and this for `output`. */
static sdr_status load(const char *dimension, const char *law, const char *output, sdr_scene **out)
{
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fprintf(file,
          "dimension: %s\n"
          "points: {shape: {box: {from: [0, 0], to: [1, 1]}}, spacing: 0.1}\n"
          "material: {young: 1, density: 1, toughness: 1}\n"
          "damage: {law: %s}\n"
          "time: {end: 1}\n"
          "output: %s\n",
          dimension, law, output);
  fclose(file);
  return sdr_scene_load(path, NULL, 0, NULL, out);
}

static void a_tip_needs_its_start_only(void **state)
{
  (void)state;
  sdr_scene *scene;
  assert_int_equal(
      load("plane_stress", "variational", "{cracks: {tips: {a: {start: [50 cm, 0]}}}}", &scene),
      SDR_OK);
  const sdr_cracks_output *cracks = &scene->output.cracks;
  assert_int_equal(cracks->tip_count, 1);
  assert_true(isnan(cracks->threshold) && isnan(cracks->every) && isinf(cracks->count_at));
  assert_true(cracks->moved.relative && cracks->moved.value == 4.5);
  assert_true(cracks->window.relative && cracks->window.value == 6.0);
  assert_true(cracks->shortest.relative && cracks->shortest.value == 8.0);
  const sdr_crack_tip *tip = cracks->tip;
  assert_string_equal(tip->name, "a");
  assert_true(tip->start[0] == 0.5 && tip->start[1] == 0.0);
  assert_true(tip->direction[0] == 1.0 && tip->direction[1] == 0.0);
  assert_true(tip->fit[0].value == 0.0 && isinf(tip->fit[1].value));
  assert_string_equal(tip->figure[SDR_CRACK_FIRST_TIME], "a_first_time");
  assert_string_equal(tip->figure[SDR_CRACK_BRANCH_SPEED], "a_branch_speed");
  assert_string_equal(tip->figure[SDR_CRACK_TOUGHNESS_SHARE], "a_toughness_share");
  sdr_scene_destroy(&scene);
}

static void everything_can_be_said(void **state)
{
  (void)state;
  sdr_scene *scene;
  assert_int_equal(load("plane_stress", "critical_stretch",
                        "{cracks: {threshold: 0.4, every: 0.1, count_at: 0.5, moved: 10 cm, "
                        "window: 20 cm, shortest_arm: 3 spacing, tips: {a: {start: [0, 0], "
                        "direction: [0, -2], fit: {from: 1 cm, to: 60 cm}}, b: {start: [1, 0]}}}}",
                        &scene),
                   SDR_OK);
  const sdr_cracks_output *cracks = &scene->output.cracks;
  assert_int_equal(cracks->tip_count, 2);
  assert_true(cracks->threshold == 0.4 && cracks->every == 0.1 && cracks->count_at == 0.5);
  assert_true(!cracks->moved.relative && cracks->moved.value == 0.1);
  assert_true(!cracks->window.relative && cracks->window.value == 0.2);
  assert_true(cracks->shortest.relative && cracks->shortest.value == 3.0);
  assert_true(cracks->tip[0].direction[1] == -1.0);
  assert_true(cracks->tip[0].fit[0].value == 0.01 && cracks->tip[0].fit[1].value == 0.6);
  sdr_scene_destroy(&scene);
}

static void without_the_key_no_crack_is_followed(void **state)
{
  (void)state;
  sdr_scene *scene;
  assert_int_equal(load("plane_stress", "variational", "{}", &scene), SDR_OK);
  assert_int_equal(scene->output.cracks.tip_count, 0);
  assert_null(strstr(scene->used_yaml, "tips"));
  sdr_scene_destroy(&scene);
}

static void what_is_wrong_is_named(void **state)
{
  (void)state;
  static const struct {
    const char *dimension, *law, *output, *message;
  } cases[] = {
      {"plane_stress", "none", "{cracks: {tips: {a: {start: [0, 0]}}}}",
       "6:10: without a damage law no crack grows; give damage.law, or leave this out"},
      {"plane_stress", "variational", "{cracks: {tips: {a: {start: [0, 0], direction: [0, 0]}}}}",
       "the direction must have a length above 0"},
      {"plane_stress", "variational",
       "{cracks: {tips: {a: {start: [0, 0], fit: {from: 2 cm, to: 1 cm}}}}}",
       "'to' must be farther than 'from'"},
      {"plane_stress", "variational",
       "{cracks: {tips: {a12345678901234567890123456789012345678901: {start: [0, 0]}}}}",
       "the name of a tip has at most 40 letters"},
      {"plane_stress", "variational", "{cracks: {threshold: 0, tips: {a: {start: [0, 0]}}}}",
       "threshold"},
      {"plane_stress", "variational", "{cracks: {window: 1 s, tips: {a: {start: [0, 0]}}}}",
       "window"},
      {"plane_stress", "variational", "{cracks: {widow: 1, tips: {a: {start: [0, 0]}}}}", "widow"},
      {"plane_stress", "variational", "{cracks: {window: 1 cm}}", "tips"},
  };
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    sdr_scene *scene = NULL;
    assert_int_equal(load(cases[k].dimension, cases[k].law, cases[k].output, &scene),
                     SDR_BAD_INPUT);
    if (!strstr(sdr_error_message(), cases[k].message))
      fail_msg("%s\nlacks: %s", sdr_error_message(), cases[k].message);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_tip_needs_its_start_only),
      cmocka_unit_test(everything_can_be_said),
      cmocka_unit_test(without_the_key_no_crack_is_followed),
      cmocka_unit_test(what_is_wrong_is_named),
  };
  return cmocka_run_group_tests(tests, make_file, remove_file);
}
