/* The program as a whole where its surroundings fail: signals, disks, files of others, memory. */
#include "output/hdf.h"
#include "support/program.h"
#include "support/scarce.h"

#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <sys/file.h>
#include <time.h>

#define RING                                                                                       \
  "thick_cylinder --quiet --variant coarse_4mm --set points.spacing='8 mm' --set figures='{}'"     \
  " --set output.history.every=3 --threads 1"
#define CHECKPOINTS " --set output.checkpoint.every='4 us'"

static void pause_for(long microseconds)
{
  const struct timespec pause = {0, microseconds * 1000};
  nanosleep(&pause, NULL);
}

/* Wait until the file has so many bytes. */
static void wait_for(const char *path, off_t bytes)
{
  struct stat info;
  for (int wait = 0; wait < 20000; ++wait, pause_for(1000))
    if (stat(path, &info) == 0 && info.st_size >= bytes) return;
  fail_msg("%s never came", path);
}

/* ---- signals --------------------------------------------------------------------------------- */

/* The run of `command` into `directory` gets the signal in its midst; when it stood then (s). */
static double stop_by(int signal, const char *name, const char *command, const char *directory)
{
  static char text[20000];
  char history[100], wanted[200];
  const char *at;
  double time = 0.0;
  int ended;
  snprintf(history, sizeof history, "%s/history.csv", directory);
  const pid_t pid = start(command);
  wait_for(history, 2000);
  assert_int_equal(kill(pid, signal), 0);
  assert_int_equal(waitpid(pid, &ended, 0), pid);
  read_whole("started.out", text, sizeof text);
  if (!WIFEXITED(ended) || WEXITSTATUS(ended) != 4) fail_msg("%d: %s", ended, text);
  snprintf(wanted, sizeof wanted, "sunder: stopped by %s at t = ", name);
  assert_int_equal(strncmp(text, wanted, strlen(wanted)), 0);
  assert_int_equal(sscanf(text + strlen(wanted), "%lf", &time), 1);
  snprintf(wanted, sizeof wanted,
           " steps; to go on, give the same command with --resume %s/checkpoint.h5\n", directory);
  at = strstr(text, " steps;");
  assert_non_null(at);
  assert_string_equal(at, wanted);
  return time;
}

static void a_run_that_is_stopped_goes_on_with_the_bits_of_one_that_was_not(void **state)
{
  (void)state;
  static const struct {
    int number;
    const char *name;
  } signals[] = {{SIGTERM, "SIGTERM"}, {SIGINT, "SIGINT"}};
  for (size_t k = 0; k < sizeof signals / sizeof *signals; ++k) {
    char command[900];
    said s;
    succeed(&s, "rm -rf stopped whole");
    const double at = stop_by(signals[k].number, signals[k].name,
                              "sunder run " RING " -o stopped --set output.snapshots=0"
                              " --set time.end='1 s'",
                              "stopped");
    assert_false(exists("stopped/summary.json"));
    assert_false(exists("stopped/.lock"));
    const double end = 0.8e-6 * ceil(at / 0.8e-6 + 10.0);
    snprintf(command, sizeof command,
             "o=\"--set output.snapshots=0 --set output.checkpoint.every=1 --set time.end=%.17g\"; "
             "sunder run " RING " $o --resume stopped/checkpoint.h5 && "
             "sunder run " RING " $o -o whole && cmp whole/checkpoint.h5 stopped/checkpoint.h5 && "
             "cmp whole/history.csv stopped/history.csv",
             end);
    succeed(&s, command);
  }
}

static void a_signal_that_is_ignored_stays_ignored(void **state)
{
  (void)state;
  int ended;
  succeed(&(said){0}, "rm -rf deaf");
  const pid_t pid = start("sh -c \"trap '' INT; exec sunder run " RING " -o deaf --set "
                          "output.snapshots=0 --set time.end=1\"");
  wait_for("deaf/history.csv", 1000);
  assert_int_equal(kill(pid, SIGINT), 0);
  pause_for(50000);
  assert_int_equal(waitpid(pid, &ended, WNOHANG), 0);
  assert_int_equal(kill(pid, SIGTERM), 0);
  assert_int_equal(waitpid(pid, &ended, 0), pid);
  assert_int_equal(WEXITSTATUS(ended), 4);
}

/* ---- disks ----------------------------------------------------------------------------------- */

static void a_directory_that_goes_away_ends_the_run(void **state)
{
  (void)state;
  static char text[20000];
  int ended;
  const pid_t pid = start("sunder run " RING " -o gone --set output.checkpoint.every='100 us'"
                          " --set output.snapshots=0 --set time.end=1");
  wait_for("gone/history.csv", 1000);
  succeed(&(said){0}, "mv gone went && rm -rf went"); /* at once: rm alone meets new files */
  assert_int_equal(waitpid(pid, &ended, 0), pid);
  read_whole("started.out", text, sizeof text);
  assert_string_equal(text,
                      "sunder: cannot write gone/checkpoint.h5.part: No such file or directory\n");
  assert_int_equal(WEXITSTATUS(ended), 3);
}

/* A disk of the test's own, where the system lets it have one. */
#define ON_A_DISK(options, command)                                                                \
  "mkdir -p disk && unshare -rm sh -c \"mount -t tmpfs -o " options " none disk && " command "\""

static int may_mount(void)
{
  said s;
  shell(&s, ON_A_DISK("size=100k", "true"));
  if (s.code != 0) print_message("no file systems may be mounted here\n");
  return s.code == 0;
}

/* At each of many sizes the disk is full at another place of the run. */
static void a_full_disk_ends_the_run_with_what_was_whole(void **state)
{
  (void)state;
  if (!may_mount()) skip();
  for (int kilobytes = 4; kilobytes <= 484; kilobytes += 120) {
    char command[1500];
    said s;
    snprintf(command, sizeof command,
             ON_A_DISK("size=%dk",
                       "sunder run " RING CHECKPOINTS " -o disk/full --set time.end='8 us' --set "
                       "output.snapshots=20; echo \\$? >code; mkdir -p kept; cp -r disk/full/. "
                       "kept 2>/dev/null; ls -A kept"),
             kilobytes);
    succeed(&s, "rm -rf kept");
    shell(&s, command);
    static char code[8];
    read_whole("code", code, sizeof code);
    if (strcmp(code, "3\n") != 0) fail_msg("%d kB: %s%s", kilobytes, code, s.err);
    assert_non_null(strstr(s.err, ": No space left on device\n"));
    assert_null(strstr(s.out, "summary.json"));
    assert_null(strstr(s.out, ".part"));
    assert_null(strstr(s.out, ".lock"));
    if (!exists("kept/checkpoint.h5")) continue;
    succeed(&s, "sunder run " RING CHECKPOINTS " --set time.end='8 us' --set output.snapshots=20 "
                "--resume kept/checkpoint.h5");
  }
}

static void a_disk_that_cannot_be_written_is_an_io_error(void **state)
{
  (void)state;
  said s;
  if (!may_mount()) skip();
  shell(&s, ON_A_DISK("ro", "sunder run " RING " -o disk/new"));
  assert_string_equal(s.err, "sunder: cannot make the directory disk/new: Read-only file system\n");
  assert_int_equal(s.code, 3);
  shell(&s, ON_A_DISK("ro", "sunder run " RING " -o disk"));
  assert_string_equal(s.err, "sunder: cannot write disk/.lock: Read-only file system\n");
  assert_int_equal(s.code, 3);
}

/* ---- files of others ------------------------------------------------------------------------- */

/* A reader that locks what it looks at, as HDF5's own tools do, stops no run. */
static void files_that_someone_has_locked_do_not_stop_a_run(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder run " RING CHECKPOINTS " -o locked --set time.end='8 us'");
  const int checkpoint = open("locked/checkpoint.h5", O_RDONLY);
  const int snapshots = open("locked/snapshots.h5", O_RDONLY);
  assert_int_equal(flock(checkpoint, LOCK_EX), 0);
  assert_int_equal(flock(snapshots, LOCK_EX), 0);
  succeed(&s, "sunder run " RING CHECKPOINTS " --resume locked/checkpoint.h5 --set "
              "time.end='16 us'");
  close(checkpoint);
  close(snapshots);
}

/* ---- memory ---------------------------------------------------------------------------------- */

/* Some of the allocations; the long tests let each fail. */
static void a_run_that_is_out_of_memory_says_so_and_leaves_nothing_whole(void **state)
{
  (void)state;
  static const char *const sets[] = {"points.spacing=16 mm", "time.end=4 us", "time.step=2 us",
                                     "output.snapshots=1", "output.checkpoint.every=2 us"};
  const scarce_run run = {SUNDER_SOURCE_DIR "/problems/thick_cylinder/scene.yaml", "starved",
                          sizeof sets / sizeof *sets, sets};
  int survived = 0;
  assert_true(scarce_all(&run, 3, 61, 0, 0, &survived) > 5);
  assert_true(scarce_all(&run, 17, 61, 1, 500, &survived) > 5);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_run_that_is_stopped_goes_on_with_the_bits_of_one_that_was_not),
      cmocka_unit_test(a_signal_that_is_ignored_stays_ignored),
      cmocka_unit_test(a_directory_that_goes_away_ends_the_run),
      cmocka_unit_test(a_full_disk_ends_the_run_with_what_was_whole),
      cmocka_unit_test(a_disk_that_cannot_be_written_is_an_io_error),
      cmocka_unit_test(files_that_someone_has_locked_do_not_stop_a_run),
      cmocka_unit_test(a_run_that_is_out_of_memory_says_so_and_leaves_nothing_whole),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
