/* output: the directory of a run. */
#include "output_body.h"

#include "output/rundir.h"

static void directories_are_made_with_their_parents(void **state)
{
  (void)state;
  body b;
  int lock = -1;
  body_create(&b, 1, 1);
  const char *deep = body_path(&b, "a/b//c/");
  assert_int_equal(sdr_rundir_open(deep, 0, &lock), SDR_OK);
  assert_true(lock >= 0);
  assert_true(body_has(&b, "a/b/c/.lock"));
  sdr_rundir_close(body_path(&b, "a/b/c"), lock);
  assert_false(body_has(&b, "a/b/c/.lock"));
  body_destroy(&b);
}

static void trying_a_directory_leaves_nothing_new(void **state)
{
  (void)state;
  body b;
  body_create(&b, 1, 1);
  assert_int_equal(sdr_rundir_try(body_path(&b, "new//deep/folder/")), SDR_OK);
  assert_false(body_has(&b, "new"));
  assert_int_equal(sdr_rundir_try(b.directory), SDR_OK);
  body_write(&b, "file", "mine");
  assert_int_equal(sdr_rundir_try(body_path(&b, "file/below")), SDR_IO_ERROR);
  assert_true(body_has(&b, "file"));
  body_destroy(&b);
}

static const char *const ours[] = {
    "summary.json",        "history.csv",       "snapshots.h5",      "snapshots.xdmf",
    "checkpoint.h5",       "used.yaml",         "damage.png",        "energy_density.png",
    "ledger.png",          "stress.xx.png",     "reactions.png",     "damage_at_43.6us.png",
    "stress.xx_at_1s.png", "compare.png",       "summary.json.part", "damage.mp4",
    "stress.xx.gif",       "checkpoint.h5.part"};
enum { OURS = sizeof ours / sizeof *ours };

static void a_new_run_removes_our_files_and_no_others(void **state)
{
  (void)state;
  body b;
  int lock = -1;
  body_create(&b, 1, 1);
  for (int k = 0; k < OURS; ++k) body_write(&b, ours[k], "old");
  body_write(&b, "notes.txt", "mine");
  body_write(&b, "photo.png", "mine");
  body_write(&b, "damage.jpg", "mine");
  body_write(&b, "ledger.mp4", "mine");
  assert_int_equal(sdr_rundir_open(b.directory, 0, &lock), SDR_OK);
  for (int k = 0; k < OURS; ++k) assert_false(body_has(&b, ours[k]));
  assert_true(body_has(&b, "notes.txt"));
  assert_true(body_has(&b, "photo.png"));
  assert_true(body_has(&b, "damage.jpg"));
  assert_true(body_has(&b, "ledger.mp4"));
  sdr_rundir_close(b.directory, lock);
  body_destroy(&b);
}

static void a_resumed_run_keeps_all_until_it_goes_on(void **state)
{
  (void)state;
  body b;
  int lock = -1;
  body_create(&b, 1, 1);
  for (int k = 0; k < OURS; ++k) body_write(&b, ours[k], "old");
  assert_int_equal(sdr_rundir_open(b.directory, 1, &lock), SDR_OK);
  for (int k = 0; k < OURS; ++k) assert_true(body_has(&b, ours[k]));
  assert_int_equal(sdr_rundir_reopen(b.directory), SDR_OK);
  assert_false(body_has(&b, "summary.json"));
  assert_false(body_has(&b, "damage.png"));
  assert_true(body_has(&b, "history.csv"));
  assert_true(body_has(&b, "checkpoint.h5"));
  sdr_rundir_close(b.directory, lock);
  body_destroy(&b);
}

static void a_directory_in_use_is_refused_with_the_process_and_left_alone(void **state)
{
  (void)state;
  body b;
  char wanted[256], byte;
  int ready[2], done[2], lock = -1;
  body_create(&b, 1, 1);
  assert_int_equal(pipe(ready), 0);
  assert_int_equal(pipe(done), 0);
  fflush(NULL);
  const pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) {
    close(done[1]); /* so that it ends with its parent at the latest */
    const int good = sdr_rundir_open(b.directory, 0, &lock) == SDR_OK;
    body_write(&b, "history.csv", "running");
    if (write(ready[1], "x", 1) != 1 || read(done[0], &byte, 1) != 1) _exit(1);
    _exit(!good); /* without closing: as a killed process does */
  }
  assert_int_equal(read(ready[0], &byte, 1), 1);
  assert_int_equal(sdr_rundir_open(b.directory, 0, &lock), SDR_BAD_INPUT);
  snprintf(wanted, sizeof wanted,
           "the directory %s is in use by process %ld; wait until it is done or give another "
           "directory with -o",
           b.directory, (long)child);
  assert_string_equal(sdr_error_message(), wanted);
  assert_int_equal(lock, -1);
  assert_true(body_has(&b, "history.csv"));

  assert_int_equal(write(done[1], "x", 1), 1); /* a dead process holds nothing */
  int status = 1;
  waitpid(child, &status, 0);
  assert_int_equal(status, 0);
  assert_true(body_has(&b, ".lock"));
  assert_int_equal(sdr_rundir_open(b.directory, 0, &lock), SDR_OK);
  char *text = body_read(&b, ".lock");
  assert_int_equal(atol(text), getpid());
  free(text);
  sdr_rundir_close(b.directory, lock);
  for (int k = 0; k < 2; ++k) {
    close(ready[k]);
    close(done[k]);
  }
  body_destroy(&b);
}

static void a_file_in_the_place_of_the_directory_is_an_io_error(void **state)
{
  (void)state;
  body b;
  char wanted[256];
  int lock = -1;
  body_create(&b, 1, 1);
  body_write(&b, "file", "");
  assert_int_equal(sdr_rundir_open(body_path(&b, "file"), 0, &lock), SDR_IO_ERROR);
  snprintf(wanted, sizeof wanted, "cannot use %s/file as the run's directory: it is a file",
           b.directory);
  assert_string_equal(sdr_error_message(), wanted);
  assert_int_equal(sdr_rundir_open(body_path(&b, "file/run"), 0, &lock), SDR_IO_ERROR);
  snprintf(wanted, sizeof wanted, "cannot make the directory %s/file/run: Not a directory",
           b.directory);
  assert_string_equal(sdr_error_message(), wanted);
  assert_int_equal(sdr_rundir_open("", 0, &lock), SDR_IO_ERROR);
  assert_int_equal(lock, -1);
  body_destroy(&b);
}

static void a_directory_that_may_not_be_written_is_an_io_error(void **state)
{
  (void)state;
  int lock = -1;
  if (geteuid() == 0) { /* root may write anywhere but into the kernel's own files */
    assert_int_equal(sdr_rundir_open("/proc", 0, &lock), SDR_IO_ERROR);
    assert_non_null(strstr(sdr_error_message(), "cannot write /proc/.lock: "));
    return;
  }
  body b;
  char wanted[256];
  body_create(&b, 1, 1);
  assert_int_equal(chmod(b.directory, 0500), 0);
  assert_int_equal(sdr_rundir_open(b.directory, 0, &lock), SDR_IO_ERROR);
  snprintf(wanted, sizeof wanted, "cannot write %s/.lock: Permission denied", b.directory);
  assert_string_equal(sdr_error_message(), wanted);
  assert_int_equal(chmod(b.directory, 0700), 0);
  body_destroy(&b);
}

static void closing_nothing_is_harmless(void **state)
{
  (void)state;
  body b;
  body_create(&b, 1, 1);
  body_write(&b, ".lock", "1\n");
  sdr_rundir_close(b.directory, -1);
  assert_true(body_has(&b, ".lock"));
  body_destroy(&b);
}

static void a_file_is_written_whole(void **state)
{
  (void)state;
  body b;
  body_create(&b, 1, 1);
  assert_int_equal(sdr_rundir_write(b.directory, "used.yaml", "title: a\n"), SDR_OK);
  char *text = body_read(&b, "used.yaml");
  assert_string_equal(text, "title: a\n");
  assert_false(body_has(&b, "used.yaml.part"));
  free(text);
  body_destroy(&b);
}

static int write_much(void *context)
{
  body *b = context;
  char wanted[256], text[5000];
  memset(text, 'x', sizeof text - 1);
  text[sizeof text - 1] = '\0';
  snprintf(wanted, sizeof wanted, "cannot write %s/used.yaml: File too large", b->directory);
  return sdr_rundir_write(b->directory, "used.yaml", text) == SDR_IO_ERROR &&
                 strcmp(sdr_error_message(), wanted) == 0
             ? 0
             : 1;
}

static void a_full_disk_leaves_the_file_before(void **state)
{
  (void)state;
  body b;
  body_create(&b, 1, 1);
  assert_int_equal(body_with_full_disk(4000, write_much, &b), 0);
  assert_false(body_has(&b, "used.yaml"));
  body_write(&b, "used.yaml", "before");
  assert_int_equal(body_with_full_disk(4000, write_much, &b), 0);
  char *text = body_read(&b, "used.yaml");
  assert_string_equal(text, "before");
  assert_false(body_has(&b, "used.yaml.part"));
  free(text);
  body_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(directories_are_made_with_their_parents),
      cmocka_unit_test(trying_a_directory_leaves_nothing_new),
      cmocka_unit_test(a_new_run_removes_our_files_and_no_others),
      cmocka_unit_test(a_resumed_run_keeps_all_until_it_goes_on),
      cmocka_unit_test(a_directory_in_use_is_refused_with_the_process_and_left_alone),
      cmocka_unit_test(a_file_in_the_place_of_the_directory_is_an_io_error),
      cmocka_unit_test(a_directory_that_may_not_be_written_is_an_io_error),
      cmocka_unit_test(closing_nothing_is_harmless),
      cmocka_unit_test(a_file_is_written_whole),
      cmocka_unit_test(a_full_disk_leaves_the_file_before),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
