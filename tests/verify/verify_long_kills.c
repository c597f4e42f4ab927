/* A run that is killed at twenty random moments, wherever it then stands (setting up, in a step,
   writing a checkpoint or a frame), and resumed each time from what lies there, ends with the bits
   of one that nobody disturbed. */
#include "support/program.h"

#include <signal.h>
#include <time.h>

enum { KILLS = 20 };

#define RING                                                                                       \
  "thick_cylinder --quiet --variant coarse_4mm --set time.end='200 us' --set figures='{}'"         \
  " --set output.history.every=3 --set output.snapshots=40 --set output.checkpoint.every='1.6 us'"

static double now(void)
{
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static double chance(void)
{
  static unsigned seed = 7;
  seed = seed * 1664525U + 1013904223U;
  return (double)(seed >> 8) / (1 << 24);
}

/* Start, kill after so many seconds; 1 if it was still running then. */
static int run_and_kill(const char *command, double seconds)
{
  int ended;
  const pid_t pid = start(command);
  const struct timespec pause = {(time_t)seconds, (long)(1e9 * (seconds - (double)(long)seconds))};
  nanosleep(&pause, NULL);
  kill(pid, SIGKILL);
  assert_int_equal(waitpid(pid, &ended, 0), pid);
  if (WIFSIGNALED(ended)) return 1;
  if (WEXITSTATUS(ended) == 0) return 0;
  static char text[20000];
  read_whole("started.out", text, sizeof text);
  fail_msg("%s: exit status %d\n%s", command, WEXITSTATUS(ended), text);
  return 0;
}

static const char *command_on(const char *options)
{
  static char command[1500];
  const char *resume = exists("broken/checkpoint.h5") ? "--resume broken/checkpoint.h5" : "";
  snprintf(command, sizeof command, "sunder run " RING " %s -o broken --threads %d %s", options,
           1 + (chance() < 0.5), resume);
  return command;
}

static void kill_and_compare(const char *options)
{
  char command[1500];
  said s;
  int kills = 0, ends = 0;
  snprintf(command, sizeof command,
           "rm -rf whole broken; sunder run " RING " %s -o whole --threads 1", options);
  const double from = now();
  succeed(&s, command);
  const double lasts = now() - from;
  while (kills < KILLS) {
    if (run_and_kill(command_on(options), 0.2 * lasts * chance())) {
      ++kills;
    } else { /* begin again: all moments shall be hit */
      assert_true(++ends < 50);
      succeed(&s, "rm -rf broken");
    }
  }
  succeed(&s, command_on(options));
  succeed(&s, "for f in history.csv checkpoint.h5 snapshots.xdmf used.yaml; do "
              "cmp whole/$f broken/$f || exit; done");
  succeed(&s, "test ! -e broken/.lock && ! ls broken/*.part 2>/dev/null");
}

static void variational_damage(void **state)
{
  (void)state;
  kill_and_compare("");
}

static void critical_stretch_in_mixed_precision(void **state)
{
  (void)state;
  kill_and_compare("--set damage.law=critical_stretch --set material.toughness=5000 "
                   "--set precision=mixed");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(variational_damage),
      cmocka_unit_test(critical_stretch_in_mixed_precision),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
