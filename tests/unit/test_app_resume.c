/* The program as a whole: a run that is killed again and again, and resumed each time from its
   latest checkpoint, ends with the same bits as one that nobody disturbed. */
#include "output/hdf.h"
#include "support/program.h"

#include <jansson.h>
#include <signal.h>
#include <stdint.h>
#include <time.h>

static void pause_for(long microseconds)
{
  const struct timespec pause = {microseconds / 1000000, microseconds % 1000000 * 1000};
  nanosleep(&pause, NULL);
}

static double now(void)
{
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void assert_same_bytes(const char *directory, const char *other, const char *name)
{
  char command[300];
  said s;
  snprintf(command, sizeof command, "cmp %s/%s %s/%s", directory, name, other, name);
  shell(&s, command);
  if (s.code != 0) fail_msg("%s", s.out);
}

/* All that does not depend on the clock and the machine. */
static json_t *lasting_summary(const char *directory)
{
  static const char *const passing[] = {"wall_seconds", "ns_per_bond_step", "peak_memory_bytes",
                                        "threads"};
  char path[200];
  snprintf(path, sizeof path, "%s/summary.json", directory);
  json_t *summary = json_load_file(path, 0, NULL);
  if (!summary) fail_msg("%s cannot be read", path);
  for (size_t k = 0; k < sizeof passing / sizeof *passing; ++k)
    assert_int_equal(json_object_del(summary, passing[k]), 0);
  json_object_del(summary, "solver"); /* counts from the resume on */
  return summary;
}

static void assert_same_dataset(sdr_hdf *a, sdr_hdf *b, const char *name)
{
  sdr_hdf_shape shape, other;
  assert_int_equal(sdr_hdf_shape_of(a, name, &shape), SDR_OK);
  if (sdr_hdf_shape_of(b, name, &other) != SDR_OK) fail_msg("%s", sdr_error_message());
  assert_int_equal(shape.rows, other.rows);
  assert_int_equal(shape.columns, other.columns);
  const size_t count = shape.rows * shape.columns;
  double *x = calloc(count, sizeof *x), *y = calloc(count, sizeof *y);
  shape.type = SDR_HDF_DOUBLE;
  assert_int_equal(sdr_hdf_read(a, name, shape, x), SDR_OK);
  assert_int_equal(sdr_hdf_read(b, name, shape, y), SDR_OK);
  assert_memory_equal(x, y, count * sizeof *x);
  free(x);
  free(y);
}

/* Frames are made of fields that the scenes below ask for. */
static void assert_same_snapshots(const char *directory, const char *other)
{
  char path[200], name[100];
  sdr_hdf *a = NULL, *b = NULL;
  snprintf(path, sizeof path, "%s/snapshots.h5", directory);
  assert_int_equal(sdr_hdf_open(path, 0, &a), SDR_OK);
  snprintf(path, sizeof path, "%s/snapshots.h5", other);
  assert_int_equal(sdr_hdf_open(path, 0, &b), SDR_OK);
  assert_int_equal(sdr_hdf_count(a, "/"), 6); /* 5 frames and the points */
  assert_int_equal(sdr_hdf_count(b, "/"), 6);
  for (int frame = 0; frame < 5; ++frame) {
    static const char *const fields[] = {"time", "displacement", "velocity", "damage", "reaction"};
    for (size_t k = 0; k < sizeof fields / sizeof *fields; ++k) {
      snprintf(name, sizeof name, "frame_%04d/%s", frame, fields[k]);
      assert_same_dataset(a, b, name);
    }
  }
  sdr_hdf_discard(&a);
  sdr_hdf_discard(&b);
}

/* The checkpoint at the end holds u, v, f, damage histories, sums and observers, whole. */
static void assert_same_runs(const char *directory, const char *other)
{
  json_t *a = lasting_summary(directory), *b = lasting_summary(other);
  assert_same_bytes(directory, other, "history.csv");
  assert_same_bytes(directory, other, "checkpoint.h5");
  assert_same_bytes(directory, other, "snapshots.xdmf");
  assert_same_bytes(directory, other, "used.yaml");
  assert_same_snapshots(directory, other);
  if (!json_equal(a, b)) fail_msg("the summaries of %s and %s differ", directory, other);
  json_decref(a);
  json_decref(b);
}

/* Start the command, let it live for some time after its directory has a checkpoint (a new one:
   the present one's inode changes), kill it. 1 if it was killed, 0 if it was done before. */
static int run_and_kill(const char *command, const char *checkpoint, long microseconds)
{
  struct stat before = {0}, after;
  const int had = stat(checkpoint, &before) == 0;
  const pid_t pid = start(command);
  int ended = 0;
  for (int wait = 0; wait < 60000; ++wait) {
    if (waitpid(pid, &ended, WNOHANG) == pid) break;
    if (stat(checkpoint, &after) == 0 && (!had || after.st_ino != before.st_ino ||
                                          after.st_mtim.tv_nsec != before.st_mtim.tv_nsec)) {
      pause_for(microseconds);
      kill(pid, SIGKILL);
      assert_int_equal(waitpid(pid, &ended, 0), pid);
      break;
    }
    pause_for(1000);
  }
  if (WIFSIGNALED(ended)) return WTERMSIG(ended) == SIGKILL;
  if (WEXITSTATUS(ended) != 0) {
    static char text[20000];
    read_whole("started.out", text, sizeof text);
    fail_msg("%s: exit status %d\n%s", command, WEXITSTATUS(ended), text);
  }
  return 0;
}

enum { MOST_KILLS = 3 };

/* Kill the run of `scene` into `broken`, which lasts so many seconds, at some moments, on 2 and 1
   threads in turn, and let it end. How often it was killed. */
static int kill_often(const char *scene, double lasts)
{
  static unsigned seed = 2026;
  char command[1500];
  said s;
  int kills = 0;
  succeed(&s, "rm -rf broken");
  snprintf(command, sizeof command, "sunder run %s --threads 2 -o broken", scene);
  for (; kills < MOST_KILLS; ++kills) {
    seed = seed * 1664525U + 1013904223U;
    const double share = (double)(seed >> 8) / (1 << 24);
    if (!run_and_kill(command, "broken/checkpoint.h5", (long)(0.3e6 * share * lasts))) break;
    if (exists("broken/summary.json")) break; /* it had all but ended */
    snprintf(command, sizeof command, "sunder run %s --threads %d --resume broken/checkpoint.h5",
             scene, 1 + kills % 2);
  }
  if (kills == MOST_KILLS) succeed(&s, command);
  return kills;
}

static void kill_and_compare(const char *scene)
{
  char command[1500];
  said s;
  int kills = 0;
  snprintf(command, sizeof command, "rm -rf whole; sunder run %s --threads 1 -o whole", scene);
  const double from = now();
  succeed(&s, command);
  const double lasts = now() - from;
  /* on a busy machine a run may end before this program wakes up to kill it */
  for (int attempt = 0; attempt < 10 && kills == 0; ++attempt) kills = kill_often(scene, lasts);
  assert_true(kills > 0);
  assert_same_runs("whole", "broken");

  /* a run that is over goes on from its last checkpoint to the same end */
  snprintf(command, sizeof command, "sunder run %s --resume broken/checkpoint.h5", scene);
  succeed(&s, command);
  assert_same_runs("whole", "broken");
}

#define OUTPUT                                                                                     \
  " --quiet --set output.checkpoint.every='8 us' --set output.history.every=3"                     \
  " --set output.snapshots=4 --set output.fields='[displacement, velocity, damage, reaction]'"
#define RING                                                                                       \
  "thick_cylinder --variant coarse_4mm" OUTPUT                                                     \
  " --set output.probes='[{name: tip, at: [81 mm, 0], fields: [velocity, damage]}]'"               \
  " --set output.measures='{fastest: {kind: max, field: velocity, component: norm, from: 9 us}, "  \
  "early: {kind: mean, field: damage, on: inner, at: 20 us}, late: {kind: sum, field: force, "     \
  "component: x}, off: {kind: min, quantity: imbalance, from: start, every: 2}, shape: {kind: "    \
  "l2_error, field: displacement, component: y, on: outer, until: 30 us, exact: 1 um*y/r}}'"

static void variational_damage_goes_on_with_the_same_bits(void **state)
{
  (void)state;
  kill_and_compare(RING);
}

static void mixed_precision_goes_on_with_the_same_bits(void **state)
{
  (void)state;
  kill_and_compare(RING " --set precision=mixed");
}

static void critical_stretch_goes_on_with_the_same_bits(void **state)
{
  (void)state;
  kill_and_compare(RING " --set damage.law=critical_stretch --set material.toughness=5000");
}

static void an_elastic_body_goes_on_with_the_same_bits(void **state)
{
  (void)state;
  kill_and_compare(RING " --set damage.law=none --set output.fragments=false"
                        " --set output.ring=false");
}

/* Supports that come and go, ramps, reactions. */
static void supports_go_on_with_the_same_bits(void **state)
{
  (void)state;
  kill_and_compare(
      RING
      " --set supports='[{name: grip, on: outer, displacement: {x: 0}, velocity: {y: 1 m/s}, "
      "ramp: 30 us, until: 70 us}, {name: late, on: outer, displacement: {x: 0}, from: 80 us}]'");
}

/* Steps that are cut, supports that come and go: what a step leaves to the next one's first guess
   is dropped at a checkpoint in both runs. */
static void energy_momentum_goes_on_with_the_same_bits(void **state)
{
  (void)state;
  kill_and_compare(RING " --set time.integrator=energy_momentum --set time.step='4 us'"
                        " --set time.end='76 us' --set supports='[{name: grip, on: outer, "
                        "displacement: {x: 0}, velocity: {y: 1 m/s}, ramp: 30 us, until: 50 us}]'");
}

/* Loose pairs (jitter, refinement), two materials, pre-cracks, initial fields, protected zones. */
static void a_notched_plate_goes_on_with_the_same_bits(void **state)
{
  (void)state;
  kill_and_compare("'" SUNDER_SOURCE_DIR "/tests/scenes/good/notch.yaml'" OUTPUT
                   " --set time.end='20 us' --set output.checkpoint.every='2 us'");
}

/* Only the time of the end differs: the checkpoint of a shorter run serves. */
static void a_longer_run_goes_on_from_a_shorter_one(void **state)
{
  (void)state;
  said s;
  succeed(&s, "rm -rf whole short; sunder run " RING " -o whole");
  succeed(&s, "sunder run " RING " -o short --set time.end='50.4 us'");
  succeed(&s, "sunder run " RING " --resume short/checkpoint.h5");
  json_t *a = lasting_summary("whole"), *b = lasting_summary("short");
  assert_true(json_equal(a, b));
  json_decref(a);
  json_decref(b);
  assert_same_bytes("whole", "short", "checkpoint.h5");
}

/* A copy of a checkpoint in a new directory: history and snapshots begin there. */
static void a_new_directory_begins_at_the_checkpoint(void **state)
{
  (void)state;
  static char whole[60000], tail[60000];
  said s;
  succeed(&s, "rm -rf whole new; sunder run " RING " -o whole --set time.end='50.4 us' && "
              "cp whole/checkpoint.h5 copy.h5 && sunder run " RING " -o whole && "
              "sunder run " RING " -o new --resume copy.h5");
  read_whole("whole/history.csv", whole, sizeof whole);
  read_whole("new/history.csv", tail, sizeof tail);
  const char *end_of_header = strchr(tail, '\n');
  assert_non_null(end_of_header);
  assert_int_equal(strncmp(whole, tail, (size_t)(end_of_header - tail) + 1), 0);
  assert_true(strtod(end_of_header + 1, NULL) >= 50.4e-6 - 1e-12);
  assert_non_null(strstr(whole, end_of_header)); /* its rows are the last of the whole's */
  assert_same_bytes("whole", "new", "checkpoint.h5");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(variational_damage_goes_on_with_the_same_bits),
      cmocka_unit_test(mixed_precision_goes_on_with_the_same_bits),
      cmocka_unit_test(critical_stretch_goes_on_with_the_same_bits),
      cmocka_unit_test(an_elastic_body_goes_on_with_the_same_bits),
      cmocka_unit_test(supports_go_on_with_the_same_bits),
      cmocka_unit_test(energy_momentum_goes_on_with_the_same_bits),
      cmocka_unit_test(a_notched_plate_goes_on_with_the_same_bits),
      cmocka_unit_test(a_longer_run_goes_on_from_a_shorter_one),
      cmocka_unit_test(a_new_directory_begins_at_the_checkpoint),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
