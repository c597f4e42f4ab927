/* app: pictures of a run. */
#include "app/plot.h"
#include "app/plot_field.h"
#include "base/memory.h"
#include "support/cmocka_all.h"
#include "support/damaged_h5.h"
#include "support/made_run.h"

static const made_run small_ring = {
    .dimension = 2, .cells = 40, .cracks = 5, .law = "variational", .frames = 3};

static void assert_close(double value, double expected, double tolerance)
{
  if (!(fabs(value - expected) <= tolerance)) print_error("%.17g is not %.17g\n", value, expected);
  assert_true(fabs(value - expected) <= tolerance);
}

/* ---- the command ---- */

/* Run sdr_plot on a made directory; what it printed, without the directory's name. */
static sdr_status plot(const char *directory, const char *field, double time, const char *png,
                       char *printed, size_t room)
{
  const sdr_plot_options options = {
      .directory = directory, .field = field, .time = time, .png = png};
  char *text = NULL;
  size_t length = 0;
  FILE *out = open_memstream(&text, &length);
  const sdr_status status = sdr_plot(&options, out);
  fclose(out);
  const size_t skip = strlen(directory);
  size_t written = 0;
  for (const char *c = text; *c && written + 4 < room;) {
    const int found = strncmp(c, directory, skip) == 0;
    if (found)
      memcpy(printed + written, "DIR", 3);
    else
      printed[written] = *c;
    written += found ? 3 : 1;
    c += found ? skip : 1;
  }
  printed[written] = '\0';
  free(text);
  return status;
}

/* Width and height of a PNG; 0 if there is no such file. */
static int png_size(const char *directory, const char *name, int *height)
{
  char path[600];
  unsigned char head[24] = {0};
  snprintf(path, sizeof path, "%s/%s", directory, name);
  FILE *file = fopen(path, "rb");
  if (!file) return 0;
  assert_int_equal(fread(head, 1, 24, file), 24);
  fclose(file);
  assert_memory_equal(head, "\x89PNG\r\n\x1a\n", 8);
  *height = head[22] << 8 | head[23];
  return head[18] << 8 | head[19];
}

static void a_plot_writes_the_field_and_the_ledger(void **state)
{
  (void)state;
  char dir[512], printed[2000];
  int height = 0;
  made_run_write(made_run_name("plot", dir), &small_ring);
  assert_int_equal(plot(dir, NULL, NAN, NULL, printed, sizeof printed), SDR_OK);
  assert_string_equal(printed, "DIR/ledger.png: energies over time\n"
                               "DIR/damage.png: damage at 100 us, frame 3 of 3\n");
  assert_int_equal(png_size(dir, "ledger.png", &height), 1600);
  assert_true(png_size(dir, "damage.png", &height) > 1200 && height > 1000 && height < 2200);
  made_run_remove(dir);
}

static void a_named_file_gets_the_field_alone(void **state)
{
  (void)state;
  char dir[512], png[600], printed[2000];
  int height = 0;
  made_run_write(made_run_name("plot", dir), &small_ring);
  snprintf(png, sizeof png, "%s/x.png", dir);
  assert_int_equal(plot(dir, "stress.xy", 4e-5, png, printed, sizeof printed), SDR_OK);
  assert_string_equal(printed, "DIR/x.png: stress xy at 50 us, frame 2 of 3\n");
  assert_true(png_size(dir, "x.png", &height) > 1200);
  assert_int_equal(png_size(dir, "ledger.png", &height), 0);
  assert_int_equal(png_size(dir, "stress.xy.png", &height), 0);
  made_run_remove(dir);
}

static void bodies_in_one_and_three_dimensions_are_drawn(void **state)
{
  (void)state;
  char dir[512], printed[2000];
  int height = 0;
  for (int dimension = 1; dimension <= 3; dimension += 2) {
    const made_run run = {.dimension = dimension, .cells = 12, .law = "none", .frames = 2};
    made_run_write(made_run_name("plot", dir), &run);
    assert_int_equal(plot(dir, "displacement", NAN, NULL, printed, sizeof printed), SDR_OK);
    assert_true(png_size(dir, "displacement.png", &height) > 1000);
    made_run_remove(dir);
  }
}

static void an_unfinished_run_is_drawn_as_far_as_it_is(void **state)
{
  (void)state;
  char dir[512], path[600], printed[2000];
  made_run run = small_ring;
  run.without_summary = 1;
  made_run_write(made_run_name("plot", dir), &run);
  snprintf(path, sizeof path, "%s/history.csv", dir);
  FILE *history = fopen(path, "a");
  fputs("1e-4,12.5,1", history); /* a row that is being written */
  fclose(history);
  assert_int_equal(plot(dir, NULL, NAN, NULL, printed, sizeof printed), SDR_OK);
  assert_string_equal(printed,
                      "DIR: no summary.json, so this run has not finished; drawing what is there\n"
                      "DIR/ledger.png: energies over time\n"
                      "DIR/damage.png: damage at 100 us, frame 3 of 3\n");
  made_run_remove(dir);
}

static void a_frame_without_its_time_does_not_count(void **state)
{
  (void)state;
  char dir[512], path[600];
  made_run_write(made_run_name("plot", dir), &small_ring);
  snprintf(path, sizeof path, "%s/snapshots.h5", dir);
  const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  H5Ldelete(file, "/frame_0002/time", H5P_DEFAULT);
  H5Fclose(file);
  sdr_rundata *run = NULL;
  assert_int_equal(sdr_rundata_open(dir, &run), SDR_OK);
  assert_int_equal(run->frame_count, 2);
  assert_int_equal(run->dimension, 2);
  sdr_rundata_destroy(&run);
  assert_null(run);
  made_run_remove(dir);
}

static void check_component(const sdr_rundata *run, const char *name, double expected,
                            const char *label)
{
  sdr_plot_field field;
  assert_int_equal(sdr_plot_field_read(run, 2, name, &field), SDR_OK);
  assert_close((double)field.value[0], expected, 1e-5 * fabs(expected));
  assert_string_equal(field.label, label);
  sdr_plot_field_clear(&field);
}

static void a_field_alone_is_its_magnitude_and_components_have_names(void **state)
{
  (void)state;
  char dir[512];
  made_run_write(made_run_name("plot", dir), &small_ring);
  sdr_rundata *run = NULL;
  assert_int_equal(sdr_rundata_open(dir, &run), SDR_OK);
  const double x = run->position[0][0], y = run->position[1][0], r = hypot(x, y);
  const double xx = 2e8 * x / r, yy = 1e8 * (0.2 + r), xy = -1e8;
  check_component(run, "displacement", 1e-4, "displacement magnitude");
  check_component(run, "displacement.y", 1e-4 * y / r, "displacement y");
  check_component(run, "stress.xx", xx, "stress xx");
  check_component(run, "stress.xy", xy, "stress xy");
  check_component(run, "stress", sqrt(xx * xx + yy * yy + 2.0 * xy * xy), "stress magnitude");
  sdr_rundata_destroy(&run);
  made_run_remove(dir);
}

static void colour_scales_follow_the_signs_of_the_values(void **state)
{
  (void)state;
  char dir[512];
  sdr_rundata *run = NULL;
  sdr_plot_field field;
  made_run_write(made_run_name("plot", dir), &small_ring);
  assert_int_equal(sdr_rundata_open(dir, &run), SDR_OK);
  assert_int_equal(sdr_plot_field_read(run, 2, "damage", &field), SDR_OK);
  assert_true(field.low == 0.0 && field.high == 1.0);
  sdr_plot_field_clear(&field);
  assert_int_equal(sdr_plot_field_read(run, 2, "stress.xx", &field), SDR_OK);
  assert_ptr_equal(field.palette, &sdr_palette_diverging);
  assert_true(field.low == -field.high);
  sdr_plot_field_clear(&field);
  assert_int_equal(sdr_plot_field_read(run, 2, "stress.xy", &field), SDR_OK);
  assert_ptr_equal(field.palette, &sdr_palette_reversed);
  assert_true(field.low < field.high);
  sdr_plot_field_clear(&field);
  /* The first frame is at rest, which takes no colour from the others. */
  sdr_plot_field rest;
  assert_int_equal(sdr_plot_field_read(run, 2, "stress.yy", &field), SDR_OK);
  assert_int_equal(sdr_plot_field_read(run, 0, "stress.yy", &rest), SDR_OK);
  const double high = field.high;
  assert_true(rest.flat && rest.low == -0.5 && rest.high == 0.5);
  sdr_plot_field_share(&rest, &field);
  assert_true(field.low == 0.0 && field.high == high && rest.low == 0.0 && rest.high == high);
  assert_ptr_equal(rest.palette, &sdr_palette_sequential);
  sdr_plot_field_clear(&rest);
  sdr_plot_field_clear(&field);
  sdr_rundata_destroy(&run);
  made_run_remove(dir);
}

static void a_few_stray_values_do_not_take_the_colours_from_the_rest(void **state)
{
  (void)state;
  enum { N = 2000 };
  char dir[512], path[600];
  float values[N];
  const made_run bar = {.dimension = 1, .cells = N, .law = "none", .frames = 1};
  made_run_write(made_run_name("plot", dir), &bar);
  for (int i = 0; i < N; ++i) values[i] = (float)(i + 1) / N;
  values[17] = 1000.0F;
  snprintf(path, sizeof path, "%s/snapshots.h5", dir);
  const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t group = H5Gopen2(file, "/frame_0000", H5P_DEFAULT);
  made_set(group, "velocity", H5T_NATIVE_FLOAT, N, 1, values);
  H5Gclose(group);
  H5Fclose(file);
  sdr_rundata *run = NULL;
  sdr_plot_field field;
  assert_int_equal(sdr_rundata_open(dir, &run), SDR_OK);
  assert_int_equal(sdr_plot_field_read(run, 0, "velocity", &field), SDR_OK);
  assert_close(field.high, 1.0, 0.01);
  assert_close(field.most, 1000.0, 0.0);
  assert_close(field.least, 1.0 / N, 1e-9);
  sdr_plot_field_clear(&field);
  sdr_rundata_destroy(&run);
  made_run_remove(dir);
}

/* ---- what can go wrong ---- */

/* The message, without the directory's name. */
static void check_failure(const char *dir, const char *field, double time, const char *png,
                          sdr_status expected, const char *message)
{
  char printed[2000], cleaned[2000] = "";
  assert_int_equal(plot(dir, field, time, png, printed, sizeof printed), expected);
  const char *said = sdr_error_message(), *found = strstr(said, dir);
  if (found)
    snprintf(cleaned, sizeof cleaned, "%.*sDIR%s", (int)(found - said), said, found + strlen(dir));
  else
    snprintf(cleaned, sizeof cleaned, "%s", said);
  assert_string_equal(cleaned, message);
}

static void a_wrong_request_says_what_there_is(void **state)
{
  (void)state;
  char dir[512], png[600];
  made_run_write(made_run_name("plot", dir), &small_ring);
  snprintf(png, sizeof png, "%s/x.png", dir);
  check_failure(dir, "damag", NAN, png, SDR_BAD_INPUT,
                "DIR/snapshots.h5: no field \"damag\"; present: damage, displacement, stress; the "
                "scene's output.fields says which are written");
  check_failure(dir, "time", NAN, png, SDR_BAD_INPUT,
                "DIR/snapshots.h5: no field \"time\"; present: damage, displacement, stress; the "
                "scene's output.fields says which are written");
  check_failure(dir, "stress.zz", NAN, png, SDR_BAD_INPUT,
                "field \"stress\" has no component \"zz\"; it has: xx yy xy");
  check_failure(dir, "damage.x1", NAN, png, SDR_BAD_INPUT,
                "field \"damage\" has no named components; give \"damage\" alone");
  check_failure(dir, "damage.x", NAN, png, SDR_BAD_INPUT,
                "field \"damage\" has no named components; give \"damage\" alone");
  check_failure(dir, "../stress", NAN, NULL, SDR_BAD_INPUT,
                "\"../stress\" is not the name of a field");
  check_failure(dir, NULL, 2e-4, png, SDR_BAD_INPUT,
                "DIR: time 200 us is outside of the snapshots, which reach from 0 s to 100 us");
  check_failure(dir, NULL, -1e-3, png, SDR_BAD_INPUT,
                "DIR: time -1 ms is outside of the snapshots, which reach from 0 s to 100 us");
  made_run_remove(dir);
}

static void a_directory_that_is_no_run_is_refused(void **state)
{
  (void)state;
  char dir[512], path[600];
  made_run_name("plot", dir);
  check_failure(dir, NULL, NAN, NULL, SDR_IO_ERROR,
                "DIR: No such file or directory; give the directory of a run");
  mkdir(dir, 0777);
  check_failure(dir, NULL, NAN, NULL, SDR_BAD_INPUT,
                "DIR: not a run's directory; it holds no summary.json, history.csv or "
                "snapshots.h5");
  snprintf(path, sizeof path, "%s/history.csv", dir);
  fclose(fopen(path, "w"));
  check_failure(path, NULL, NAN, NULL, SDR_BAD_INPUT,
                "DIR: not a directory; give the directory of a run");
  made_run_remove(dir);
}

static void a_run_without_snapshots_still_gets_its_ledger(void **state)
{
  (void)state;
  char dir[512];
  int height = 0;
  made_run run = small_ring;
  run.frames = 0;
  made_run_write(made_run_name("plot", dir), &run);
  check_failure(
      dir, NULL, NAN, NULL, SDR_BAD_INPUT,
      "DIR: no snapshots, so there is no field to draw; the scene's output.snapshots must "
      "be above 0 (now perhaps \"output.snapshots: 0\")");
  assert_int_equal(png_size(dir, "ledger.png", &height), 1600);
  made_run_remove(dir);
}

static void write_text(const char *dir, const char *name, const char *text)
{
  char path[600];
  snprintf(path, sizeof path, "%s/%s", dir, name);
  FILE *file = fopen(path, "w");
  fputs(text, file);
  fclose(file);
}

static void broken_files_are_named(void **state)
{
  (void)state;
  char dir[512];
  made_run_write(made_run_name("plot", dir), &small_ring);
  write_text(dir, "history.csv", "time,kinetic\n0,1\n1,two\n");
  check_failure(dir, NULL, NAN, NULL, SDR_BAD_INPUT,
                "DIR/history.csv:3: column 2 of 2 is not a number");
  write_text(dir, "history.csv", "time,kinetic\n0,1\n1\n");
  check_failure(dir, NULL, NAN, NULL, SDR_BAD_INPUT,
                "DIR/history.csv:3: column 1 of 2 is not a number");
  write_text(dir, "history.csv", "kinetic,stored\n0,1\n");
  check_failure(
      dir, NULL, NAN, NULL, SDR_BAD_INPUT,
      "DIR/history.csv: missing, or without a column \"time\", so there are no energies to "
      "draw");
  write_text(dir, "summary.json", "[1, 2]");
  check_failure(dir, NULL, NAN, NULL, SDR_BAD_INPUT, "DIR/summary.json: not a JSON object");
  write_text(dir, "summary.json", "{}");
  write_text(dir, "snapshots.h5", "not HDF5");
  check_failure(
      dir, NULL, NAN, NULL, SDR_IO_ERROR,
      "DIR/snapshots.h5: not a readable HDF5 file; it may be truncated, or its first frame "
      "is not written yet");
  made_run_remove(dir);
}

static void a_truncated_snapshot_file_never_crashes(void **state)
{
  (void)state;
  char dir[512], path[600], printed[2000];
  const made_run bar = {.dimension = 1, .cells = 50, .law = "none", .frames = 2};
  made_run_write(made_run_name("plot", dir), &bar);
  snprintf(path, sizeof path, "%s/snapshots.h5", dir);
  struct stat info;
  assert_int_equal(stat(path, &info), 0);
  for (off_t size = info.st_size - 1; size > 0; size -= 997) {
    assert_int_equal(truncate(path, size), 0);
    assert_int_equal(plot(dir, NULL, NAN, path, printed, sizeof printed), SDR_IO_ERROR);
  }
  made_run_remove(dir);
}

static void a_damaged_snapshot_file_never_crashes(void **state)
{
  (void)state;
  char dir[512], path[600];
  made_run_write(made_run_name("plot", dir), &small_ring);
  snprintf(path, sizeof path, "%s/snapshots.h5", dir);
  loop_the_members(path);
  check_failure(dir, NULL, NAN, NULL, SDR_IO_ERROR,
                "DIR/snapshots.h5: damaged, HDF5 does not get through it; move it away to go on "
                "without it");
  made_run_remove(dir);
}

static void a_picture_that_cannot_be_written_is_an_io_error(void **state)
{
  (void)state;
  char dir[512];
  made_run_write(made_run_name("plot", dir), &small_ring);
  check_failure(dir, NULL, NAN, "/nowhere/at/all.png", SDR_IO_ERROR,
                "/nowhere/at/all.png: cannot be written: No such file or directory");
  check_failure(dir, NULL, NAN, dir, SDR_BAD_INPUT,
                "DIR: a picture is a PNG; let its name end with .png");
  made_run_remove(dir);
}

/* With a PATH of one directory, in which `program` (NULL: nothing) stands as gnuplot. */
static void check_with_gnuplot(const char *program, const char *message)
{
  char dir[512], fake[600];
  char *path = strdup(getenv("PATH"));
  made_run_write(made_run_name("plot", dir), &small_ring);
  snprintf(fake, sizeof fake, "%s/gnuplot", dir);
  if (program) {
    write_text(dir, "gnuplot", program);
    chmod(fake, 0755);
  }
  setenv("PATH", dir, 1);
  check_failure(dir, NULL, NAN, NULL, SDR_IO_ERROR, message);
  setenv("PATH", path, 1);
  unlink(fake);
  assert_int_equal(access(dir, F_OK), 0);
  made_run_remove(dir);
  assert_int_not_equal(access(dir, F_OK), 0); /* no temporary file was left */
  free(path);
}

static void a_missing_or_failing_gnuplot_is_explained(void **state)
{
  (void)state;
  check_with_gnuplot(NULL, "gnuplot is not installed, and pictures need it; install the Debian "
                           "package gnuplot-nox");
  check_with_gnuplot("#!/bin/sh\necho unknown terminal >&2\nexit 1\n",
                     "gnuplot failed with status 1: unknown terminal");
  check_with_gnuplot("#!/bin/sh\nkill -9 $$\n", "gnuplot was stopped by signal 9: ");
  check_with_gnuplot("#!/bin/sh\nwhile read -r line; do :; done\nexit 0\n",
                     "DIR/ledger.png: gnuplot wrote no whole picture; is the disk full?");
}

static void a_title_cannot_give_gnuplot_orders(void **state)
{
  (void)state;
  char dir[512], text[2000], bad[600], printed[2000];
  const made_run bar = {.dimension = 1, .cells = 20, .law = "none", .frames = 1};
  made_run_write(made_run_name("plot", dir), &bar);
  snprintf(bad, sizeof bad, "%s/x.png", dir);
  snprintf(text, sizeof text,
           "{\"title\": \"it's '; system('touch %s') # \\\\ \\n system('touch %s') %%d ` \"}", bad,
           bad);
  write_text(dir, "summary.json", text);
  assert_int_equal(plot(dir, NULL, NAN, NULL, printed, sizeof printed), SDR_OK);
  assert_int_not_equal(access(bad, F_OK), 0);
  made_run_remove(dir);
}

static void every_failing_allocation_comes_back_as_an_error(void **state)
{
  (void)state;
  char dir[512], png[600], printed[2000];
  const made_run run = {.dimension = 2, .cells = 12, .cracks = 3, .law = "none", .frames = 1};
  made_run_write(made_run_name("plot", dir), &run);
  snprintf(png, sizeof png, "%s/x.png", dir);
  const size_t before = sdr_memory_now();
  sdr_status status = SDR_RUN_FAILED;
  int successes = 0;
  for (; status != SDR_OK && successes < 1000; ++successes) {
    sdr_memory_fail_after(successes);
    status = plot(dir, NULL, NAN, png, printed, sizeof printed);
    sdr_memory_fail_after(-1);
    if (status != SDR_OK) assert_int_equal(status, SDR_RUN_FAILED);
    assert_int_equal(sdr_memory_now(), before);
  }
  assert_int_equal(status, SDR_OK);
  assert_true(successes > 20);
  made_run_remove(dir);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_plot_writes_the_field_and_the_ledger),
      cmocka_unit_test(a_named_file_gets_the_field_alone),
      cmocka_unit_test(bodies_in_one_and_three_dimensions_are_drawn),
      cmocka_unit_test(an_unfinished_run_is_drawn_as_far_as_it_is),
      cmocka_unit_test(a_frame_without_its_time_does_not_count),
      cmocka_unit_test(a_field_alone_is_its_magnitude_and_components_have_names),
      cmocka_unit_test(colour_scales_follow_the_signs_of_the_values),
      cmocka_unit_test(a_few_stray_values_do_not_take_the_colours_from_the_rest),
      cmocka_unit_test(a_wrong_request_says_what_there_is),
      cmocka_unit_test(a_directory_that_is_no_run_is_refused),
      cmocka_unit_test(a_run_without_snapshots_still_gets_its_ledger),
      cmocka_unit_test(broken_files_are_named),
      cmocka_unit_test(a_truncated_snapshot_file_never_crashes),
      cmocka_unit_test(a_damaged_snapshot_file_never_crashes),
      cmocka_unit_test(a_picture_that_cannot_be_written_is_an_io_error),
      cmocka_unit_test(a_missing_or_failing_gnuplot_is_explained),
      cmocka_unit_test(a_title_cannot_give_gnuplot_orders),
      cmocka_unit_test(every_failing_allocation_comes_back_as_an_error),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
