/* output: progress, on a terminal and elsewhere. */
#include "output_body.h"

#include "output/ledger.h"
#include "output/progress.h"

#include <sys/ioctl.h>
#include <time.h>

/* ---- numbers --------------------------------------------------------------------------------- */

static void expect_text(double value, const char *unit, const char *wanted)
{
  char text[SDR_PREFIXED_SIZE];
  assert_string_equal(sdr_prefixed(text, value, unit), wanted);
}

static void numbers_have_three_digits_and_a_prefix(void **state)
{
  (void)state;
  expect_text(0.0, "J", "0 J");
  expect_text(42e-6, "s", "42.0 us");
  expect_text(1234.5, "J", "1.23 kJ");
  expect_text(-0.0125, "J", "-12.5 mJ");
  expect_text(999.4, "J", "999 J");
  expect_text(999.7, "J", "1.00 kJ");
  expect_text(99.96, "J", "100 J");
  expect_text(9.996, "J", "10.0 J");
  expect_text(1.0, "s", "1.00 s");
  expect_text(1e-6, "s", "1.00 us");
  expect_text(1e-5, "s", "10.0 us");
  expect_text(1e-30, "J", "1e-30 J");
  expect_text(5e15, "J", "5.00 PJ");
  expect_text(NAN, "J", "nan J");
  expect_text(INFINITY, "J", "inf J");
}

/* ---- what is drawn --------------------------------------------------------------------------- */

typedef struct {
  body b;
  sdr_observer *ledger, *progress;
  double seconds; /* that the run took */
} fixture;

static double seconds_now(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Steps 0 to `last`, a millisecond each, with `to` for stderr; then finish. */
static void show_run(fixture *f, int to, int last)
{
  const int kept = dup(STDERR_FILENO);
  const double begun = seconds_now();
  dup2(to, STDERR_FILENO);
  const sdr_status made = sdr_progress_create(f->ledger, &f->progress);
  for (int step = 0; made == SDR_OK && step <= last; ++step) {
    body_at(&f->b, step);
    f->b.balance.kinetic = 12.3 * step;
    if (body_show(&f->b, f->ledger) != SDR_OK || body_show(&f->b, f->progress) != SDR_OK) break;
    usleep(1000);
  }
  if (made == SDR_OK && f->b.moment.last) f->progress->ops->finish(f->progress, &f->b.moment);
  if (made == SDR_OK) f->progress->ops->destroy(f->progress);
  f->seconds = seconds_now() - begun;
  dup2(kept, STDERR_FILENO);
  close(kept);
  assert_int_equal(made, SDR_OK);
  assert_int_equal(f->b.moment.step, last);
}

static void fixture_create(fixture *f)
{
  body_create(&f->b, 2, 1);
  f->b.scene->output.history_every = 1;
  assert_int_equal(sdr_ledger_create(f->b.scene, f->b.points, &f->ledger), SDR_OK);
}

static void fixture_destroy(fixture *f)
{
  f->ledger->ops->destroy(f->ledger);
  body_destroy(&f->b);
}

static void a_file_gets_a_line_every_tenth(void **state)
{
  (void)state;
  fixture f;
  fixture_create(&f);
  const int file = open(body_path(&f.b, "log"), O_CREAT | O_WRONLY, 0600);
  show_run(&f, file, 100);
  close(file);
  char *text = body_read(&f.b, "log"), *rest = text;
  for (int tenth = 1; tenth <= 10; ++tenth) {
    char start[128];
    snprintf(start, sizeof start, "%3d %%, %s us of 100 us, ", 10 * tenth,
             (const char *[]){"10.0", "20.0", "30.0", "40.0", "50.0", "60.0", "70.0", "80.0",
                              "90.0", "100"}[tenth - 1]);
    char *line = strsep(&rest, "\n");
    assert_non_null(line);
    assert_memory_equal(line, start, strlen(start));
    snprintf(start, sizeof start, "step %d/100", 10 * tenth);
    assert_non_null(strstr(line, start));
    assert_non_null(strstr(line, "steps/s, kinetic "));
    assert_non_null(strstr(line, "stored 0 J, dissipated 0 J, imbalance 1.0e+00"));
    assert_true((strstr(line, " s left") != NULL) == (tenth < 10));
  }
  assert_string_equal(rest, "");
  free(text);
  fixture_destroy(&f);
}

static int open_terminal(int columns, int *other)
{
  const struct winsize size = {.ws_row = 24, .ws_col = (unsigned short)columns};
  const int master = posix_openpt(O_RDWR | O_NOCTTY);
  if (master < 0 || grantpt(master) != 0 || unlockpt(master) != 0) return -1;
  *other = open(ptsname(master), O_RDWR | O_NOCTTY);
  if (*other >= 0) ioctl(*other, TIOCSWINSZ, &size);
  return master;
}

/* All that a run up to step `last` writes to a terminal of so many columns; for free(). */
static char *terminal_text(fixture *f, int columns, int last)
{
  int other = -1;
  const int master = open_terminal(columns, &other);
  assert_true(master >= 0 && other >= 0);
  show_run(f, other, last);
  char *text = calloc(1, 65536);
  fcntl(master, F_SETFL, O_NONBLOCK);
  size_t length = 0;
  ssize_t got;
  while (length < 65535 && (got = read(master, text + length, 65535 - length)) > 0)
    length += (size_t)got;
  close(other);
  close(master);
  return text;
}

static void a_terminal_gets_one_line_redrawn_now_and_then(void **state)
{
  (void)state;
  fixture f;
  setenv("TERM", "xterm", 1);
  for (int columns = 20; columns <= 200; columns += 60) {
    fixture_create(&f);
    char *text = terminal_text(&f, columns, 100);
    int draws = 0;
    char *copy = strdup(text), *rest = copy, *line;
    while ((line = strsep(&rest, "\r")) != NULL && *line != '\n') {
      if (!*line) continue;
      ++draws;
      char *end = strstr(line, "\033[K");
      assert_non_null(end);
      assert_true(end - line < columns);
      assert_memory_equal(line + 3, " %", 2);
    }
    assert_true(draws >= 2 && draws <= 2 + (int)(10.0 * f.seconds));
    assert_non_null(strstr(text, columns < 80 ? "\r100 %" : "\r100 % [####################]"));
    assert_true((strstr(text, ", 100 us of 100 us") != NULL) == (columns >= 80));
    assert_true((strstr(text, "kinetic") != NULL) == (columns >= 140));
    assert_string_equal(text + strlen(text) - 5, "\033[K\r\n");
    free(copy);
    free(text);
    fixture_destroy(&f);
  }
}

static void a_run_that_fails_leaves_the_cursor_on_a_new_line(void **state)
{
  (void)state;
  fixture f;
  setenv("TERM", "xterm", 1);
  fixture_create(&f);
  char *text = terminal_text(&f, 120, 37);
  assert_string_equal(text + strlen(text) - 5, "\033[K\r\n");
  free(text);
  fixture_destroy(&f);
}

static void a_dumb_terminal_gets_lines(void **state)
{
  (void)state;
  fixture f;
  setenv("TERM", "dumb", 1);
  fixture_create(&f);
  char *text = terminal_text(&f, 120, 37);
  assert_null(strchr(text, '\033'));
  assert_memory_equal(text, " 10 %, 10.0 us of 100 us, ", 26);
  free(text);
  fixture_destroy(&f);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(numbers_have_three_digits_and_a_prefix),
      cmocka_unit_test(a_file_gets_a_line_every_tenth),
      cmocka_unit_test(a_terminal_gets_one_line_redrawn_now_and_then),
      cmocka_unit_test(a_run_that_fails_leaves_the_cursor_on_a_new_line),
      cmocka_unit_test(a_dumb_terminal_gets_lines),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
