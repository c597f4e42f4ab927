/* The program as a whole: wrong scenes, files and checkpoints, each with its exact text and exit
   status, and nothing left that looks like a whole result. */
#include "output/hdf.h"
#include "support/program.h"

#include <glob.h>
#include <math.h>

#define COARSE "thick_cylinder --variant coarse_4mm --quiet"
#define SHORT COARSE " --set time.end='8 us'"
#define ENDS_WRONG "sunder run " SHORT " -o wrong "

/* Scenes whose exit status is not 1. */
static int status_of(const char *name)
{
  return strcmp(name, "directory_not_writable") == 0 ? 3 : 1;
}

static void every_wrong_scene_gives_its_text_and_no_summary(void **state)
{
  (void)state;
  static char expected[25000], text[25100];
  glob_t found;
  said s;
  int wrong = 0;
  succeed(&s, "cp '" SUNDER_SOURCE_DIR "'/tests/scenes/bad/*.yaml '" SUNDER_SOURCE_DIR
              "'/tests/scenes/bad/*.expected '" SUNDER_SOURCE_DIR "'/tests/scenes/bad/*.csv .");
  assert_int_equal(glob("*.yaml", 0, NULL, &found), 0);
  assert_true(found.gl_pathc >= 40);
  for (size_t k = 0; k < found.gl_pathc; ++k) {
    char name[100], command[300], path[300];
    snprintf(name, sizeof name, "%.*s", (int)(strlen(found.gl_pathv[k]) - strlen(".yaml")),
             found.gl_pathv[k]);
    snprintf(path, sizeof path, "%s.expected", name);
    read_whole(path, expected, sizeof expected);
    snprintf(text, sizeof text, "sunder: %s", expected);
    snprintf(command, sizeof command, "sunder run %s.yaml --quiet", name);
    shell(&s, command);
    snprintf(path, sizeof path, "out/%s/summary.json", name);
    if (s.code == status_of(name) && strcmp(s.err, text) == 0 && !s.out[0] && !exists(path))
      continue;
    print_error("%s\n  wanted %d: %s  got %d:    %s", name, status_of(name), text, s.code, s.err);
    ++wrong;
  }
  globfree(&found);
  assert_int_equal(wrong, 0);
}

/* What only --set can spoil quickly: wrong at the points, the step, the start or on the way. */
static void overrides_that_are_wrong_only_after_reading_give_their_text(void **state)
{
  (void)state;
  static const struct {
    const char *sets;
    int code;
    const char *text;
  } cases[] = {
      {"--set horizon='1000 spacing'", 1,
       "--set horizon: a horizon of 1000 spacings would give each point millions of bonds; give "
       "less than 100 spacings"},
      {"--set time.step='1e-30 s'", 1,
       "--set time.step: 8e-06 s in steps of 1e-30 s are 8.0e+24 steps; at most 1e15 are possible, "
       "so take a longer step or an earlier end"},
      {"--set cracks='[{segment: {from: [0, 0], to: [1 mm, 0]}}]'", 1,
       "--set cracks: the cracks cut no bond; do they lie in the body?"},
      {"--set initial.velocity='[{value: [\"1 m/s*sqrt(-x/(1 m))\", 0]}]'", 1,
       "--set initial.velocity: initial velocity, x component: the formula '1 m/s*sqrt(-x/(1 m))' "
       "gives nan at (x, y, z) = (0.004, -0.148, 0) m; it must be finite"},
      {"--set supports='[{name: rim, on: outer, displacement: {x: \"1 mm*sqrt(1-t/(3 us))\"}}]'", 1,
       "--set supports: support 'rim', x component: the formula '1 mm*sqrt(1-t/(3 us))' gives nan "
       "at t = 3.2e-06 s; it must be finite"},
      {"--set output.probes='[{name: tip, at: [10 cm, 0], fields: [fragment]}]'", 1,
       "--set output.probes: probe tip cannot show 'fragment'; name another field"},
      {"--set output.probes='[{name: tip, at: [100, 0]}]'", 1,
       "--set output.probes: probe tip lies outside the body: the nearest point is 9.985e+04 mm "
       "away, beyond its horizon of 12.04 mm; give a place in the body"},
      {"--set output.fields='[colour]'", 1, NULL},
      {"--set time.step='50 us' --set time.end='1 ms' --set time.allow_unstable=true", 2, NULL}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    char command[600], text[600];
    said s;
    snprintf(command, sizeof command, ENDS_WRONG "%s", cases[k].sets);
    snprintf(text, sizeof text, "sunder: %s\n", cases[k].text ? cases[k].text : "");
    if (cases[k].text) {
      refuse(&s, command, cases[k].code, text);
    } else {
      shell(&s, command);
      assert_int_equal(s.code, cases[k].code);
      assert_string_equal(s.out, "");
    }
    assert_false(exists("wrong/summary.json"));
  }
}

static void a_run_that_blows_up_names_time_and_point_and_leaves_no_summary(void **state)
{
  (void)state;
  double time, x, y, z;
  long long step;
  said s;
  shell(&s, "sunder run " COARSE " -o blown --set time.step='5 us' --set time.end='1 ms' "
            "--set time.allow_unstable=true --set damage.law=none");
  assert_int_equal(s.code, 2);
  assert_string_equal(s.out, "");
  assert_int_equal(sscanf(s.err,
                          "sunder: the run blew up at t = %lf s (step %lld): the point at (%lf, "
                          "%lf, %lf) m would move by a horizon or more in one step; take a smaller",
                          &time, &step, &x, &y, &z),
                   5);
  assert_true(step >= 1 && step < 20);
  assert_true(fabs(time - 5e-6 * (double)step) < 1e-10);
  assert_true(hypot(x, y) >= 0.081 && hypot(x, y) <= 0.149 && z == 0);
  assert_false(exists("blown/summary.json"));
}

static void scenes_that_cannot_be_read_are_io_errors(void **state)
{
  (void)state;
  static const char *const cases[][2] = {
      {"nowhere.yaml", "there is no scene 'nowhere.yaml': neither a file nor a problem; problems: "
                       "thick_cylinder"},
      {"''", "there is no scene '': neither a file nor a problem; problems: thick_cylinder"},
      {"folder", "folder: is a directory; give the scene file in it"},
      {"dangling.yaml",
       "there is no scene 'dangling.yaml': neither a file nor a problem; problems: "
       "thick_cylinder"},
      {"/dev/null", "/dev/null: is not a file"},
      {"/proc/self/mem", "/proc/self/mem: cannot be read: Input/output error"}};
  said s;
  succeed(&s, "mkdir -p folder mine/thick_cylinder && ln -sf nothing dangling.yaml && "
              "echo 'dimension: 1d' > mine/thick_cylinder/scene.yaml");
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    char command[100], text[300];
    snprintf(command, sizeof command, "SUNDER_PROBLEMS=mine sunder run %s", cases[k][0]);
    snprintf(text, sizeof text, "sunder: %s\n", cases[k][1]);
    refuse(&s, command, 3, text);
  }
}

static void a_mistyped_name_is_bad_input_and_names_the_nearest(void **state)
{
  (void)state;
  said s;
  succeed(&s, "mkdir -p named/thick_cylinder named/bar named/wave && touch hole.yaml && "
              "for p in bar wave thick_cylinder; do touch named/$p/scene.yaml; done");
  refuse(&s, "SUNDER_PROBLEMS=named sunder run thick_cylindr", 1,
         "sunder: there is no scene 'thick_cylindr': neither a file nor a problem (did you mean "
         "'thick_cylinder'?); problems: bar, thick_cylinder, wave\n");
  refuse(&s, "SUNDER_PROBLEMS=named sunder check hole", 1,
         "sunder: there is no scene 'hole': neither a file nor a problem (did you mean the file "
         "'hole.yaml'?); problems: bar, thick_cylinder, wave\n");
}

static void directories_that_cannot_be_written_are_io_errors(void **state)
{
  (void)state;
  static const char *const cases[][2] = {
      {"in_the_way", "cannot use in_the_way as the run's directory: it is a file"},
      {"in_the_way/a", "cannot make the directory in_the_way/a: Not a directory"},
      {"/dev/null/a", "cannot make the directory /dev/null/a: Not a directory"},
      {"/proc/a", "cannot make the directory /proc/a: No such file or directory"},
      {"leads_nowhere", "cannot use the directory leads_nowhere: No such file or directory"}};
  said s;
  succeed(&s, "touch in_the_way && ln -sf nothing leads_nowhere");
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    char command[200], text[300];
    snprintf(command, sizeof command, "sunder run " SHORT " -o %s", cases[k][0]);
    snprintf(text, sizeof text, "sunder: %s\n", cases[k][1]);
    refuse(&s, command, 3, text);
  }
  char longer[3000] = "sunder run " SHORT " -o ";
  for (int k = 0; k < 120; ++k) strcat(longer, "abcdefghi/");
  refuse(&s, longer, 1, "sunder: the name of the run's directory is longer than 599 characters\n");
}

/* Number of frames; every one must be whole. 0 if there is no file. */
static int whole_frames(const char *path)
{
  sdr_hdf *file = NULL;
  if (!exists(path)) return 0;
  if (sdr_hdf_open(path, 0, &file) != SDR_OK) fail_msg("%s", sdr_error_message());
  int frames = 0;
  for (; frames < 100; ++frames) {
    char name[60];
    sdr_hdf_shape shape;
    snprintf(name, sizeof name, "frame_%04d/time", frames);
    if (!sdr_hdf_has(file, name)) break;
    snprintf(name, sizeof name, "frame_%04d/damage", frames);
    assert_int_equal(sdr_hdf_shape_of(file, name, &shape), SDR_OK);
    float *damage = calloc(shape.rows, sizeof *damage);
    shape.type = SDR_HDF_FLOAT;
    assert_int_equal(sdr_hdf_read(file, name, shape, damage), SDR_OK);
    free(damage);
  }
  sdr_hdf_discard(&file);
  return frames;
}

/* The limit of a file's size stands for a disk that is full: both fail a write in the middle. */
static void a_full_disk_is_an_io_error_and_leaves_whole_frames_and_rows_only(void **state)
{
  (void)state;
  static const struct {
    int blocks; /* of 512 bytes */
    const char *file;
  } cases[] = {{2, "used.yaml"},      {40, "snapshots.h5"},   {400, "snapshots.h5"},
               {900, "snapshots.h5"}, {1400, "snapshots.h5"}, {1900, "snapshots.h5"}};
  static char history[60000];
  int most = 0;
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    char command[400], text[100];
    said s;
    snprintf(command, sizeof command,
             "rm -rf full && (trap '' XFSZ; ulimit -f %d; exec sunder run " COARSE
             " -o full --set output.checkpoint.every='20 us' 2>&1) | cat >&2; test -d full",
             cases[k].blocks);
    shell(&s, command);
    snprintf(text, sizeof text, "sunder: cannot write full/%s: File too large\n", cases[k].file);
    assert_string_equal(s.err, text);
    assert_string_equal(s.out, "");
    assert_int_equal(s.code, 0);
    assert_false(exists("full/summary.json"));
    assert_false(exists("full/checkpoint.h5.part"));
    const int frames = whole_frames("full/snapshots.h5");
    most = frames > most ? frames : most;
    if (!exists("full/history.csv")) continue;
    const size_t length = read_whole("full/history.csv", history, sizeof history);
    assert_true(length > 0 && history[length - 1] == '\n');
  }
  assert_true(most >= 10);
}

static void a_full_disk_gives_exit_status_3(void **state)
{
  (void)state;
  said s;
  shell(&s, "trap '' XFSZ; ulimit -f 40; exec sunder run " COARSE " -o small");
  assert_int_equal(s.code, 3);
}

/* The results that lie beside a checkpoint which does not fit must stay as they are. */
static void checkpoints_that_do_not_fit_are_refused_and_change_nothing(void **state)
{
  (void)state;
  static const char *const fits = "; only title, output, figures, threads, time.end, "
                                  "time.allow_unstable and damage.onset may differ\n";
  said s, before, after;
  shell(&s, "sunder run " SHORT " -o done --set output.checkpoint.every='2 us' && "
            "cp done/checkpoint.h5 copy.h5 && head -c 100000 copy.h5 > cut.h5 && "
            "head -c 20 copy.h5 > stub.h5 && : > empty.h5 && mkdir -p folder.h5");
  assert_int_equal(s.code, 0);
  succeed(&before, "cat done/* | cksum");

  refuse(&s, "sunder run " SHORT " -o new --resume nowhere.h5", 3,
         "sunder: cannot read nowhere.h5: No such file or directory\n");
  refuse(&s, "sunder run " SHORT " -o done --resume cut.h5", 1,
         "sunder: cut.h5 is not a whole checkpoint: it is truncated or damaged\n");
  refuse(&s, "sunder run " SHORT " -o done --resume stub.h5", 1,
         "sunder: stub.h5 is not a whole checkpoint: it is truncated or damaged\n");
  refuse(&s, "sunder run " SHORT " -o done --resume empty.h5", 1,
         "sunder: empty.h5 is not a whole checkpoint: it is truncated or damaged\n");
  refuse(&s, "sunder run " SHORT " -o done --resume done/snapshots.h5", 1,
         "sunder: done/snapshots.h5 holds snapshots, not a checkpoint; give done/checkpoint.h5\n");
  refuse(&s, "sunder run " SHORT " -o done --resume done/", 1,
         "sunder: done/ is a directory, not a checkpoint; give done/checkpoint.h5\n");
  refuse(&s, "sunder run " SHORT " -o done --resume done", 1,
         "sunder: done is a directory, not a checkpoint; give done/checkpoint.h5\n");
  refuse(&s, "sunder run " SHORT " -o done --resume done/used.yaml", 1,
         "sunder: done/used.yaml is a scene, not a checkpoint; give the checkpoint.h5 of a run's "
         "directory\n");
  refuse(&s, "sunder run " SHORT " --set time.end='4 us' --resume done/checkpoint.h5", 1,
         "sunder: done/checkpoint.h5 is at t = 8e-06 s, past this run's end at t = 4e-06 s; give a "
         "later time.end\n");
  refuse(&s, "sunder run " SHORT " --set damage.ell='1 horizon' --resume done/checkpoint.h5", 1,
         "sunder: the results in done are of another scene, so they cannot be continued; give the "
         "scene, --variant and --set that they were made with (see used.yaml there), or another "
         "directory with -o\n");

  shell(&s, "sunder run " SHORT " --set damage.ell='1 horizon' --resume done/checkpoint.h5 -o new");
  assert_int_equal(s.code, 1);
  assert_non_null(strstr(s.err, "done/checkpoint.h5 does not fit this run: its scene hash is "));
  assert_non_null(strstr(s.err, fits));
  assert_false(exists("new/used.yaml"));

  shell(&s, "sunder run " SHORT " --resume done/checkpoint.h5 --isa baseline");
  if (s.code != 0) { /* a processor that has no more than that fits */
    assert_int_equal(s.code, 1);
    assert_non_null(strstr(s.err, "its instruction set is "));
    assert_non_null(strstr(s.err, ", this run's is baseline; only"));
    succeed(&after, "cat done/* | cksum");
    assert_string_equal(after.out, before.out);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_wrong_scene_gives_its_text_and_no_summary),
      cmocka_unit_test(overrides_that_are_wrong_only_after_reading_give_their_text),
      cmocka_unit_test(a_run_that_blows_up_names_time_and_point_and_leaves_no_summary),
      cmocka_unit_test(scenes_that_cannot_be_read_are_io_errors),
      cmocka_unit_test(a_mistyped_name_is_bad_input_and_names_the_nearest),
      cmocka_unit_test(directories_that_cannot_be_written_are_io_errors),
      cmocka_unit_test(a_full_disk_is_an_io_error_and_leaves_whole_frames_and_rows_only),
      cmocka_unit_test(a_full_disk_gives_exit_status_3),
      cmocka_unit_test(checkpoints_that_do_not_fit_are_refused_and_change_nothing),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
