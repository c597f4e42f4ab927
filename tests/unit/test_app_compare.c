/* app: two runs side by side. */
#include "app/compare.h"
#include "app/compare_parts.h"
#include "base/memory.h"
#include "support/cmocka_all.h"
#include "support/made_run.h"

static const made_run first = {
    .dimension = 2, .cells = 40, .cracks = 5, .law = "variational", .frames = 3};

/* Compare two made runs; what is printed, with A/ and B/ for the directories. */
static sdr_status compare(const made_run *a, const made_run *b, char *printed, size_t room)
{
  char dir_a[512], dir_b[512], *text = NULL;
  size_t length = 0, written = 0;
  made_run_write(made_run_name("compare-a", dir_a), a);
  made_run_write(made_run_name("compare-b", dir_b), b);
  FILE *out = open_memstream(&text, &length);
  const sdr_status status = sdr_compare(dir_a, dir_b, NULL, out);
  fclose(out);
  for (const char *c = text; *c && written + 8 < room;) {
    const int is_a = strncmp(c, dir_a, strlen(dir_a)) == 0;
    const int is_b = strncmp(c, dir_b, strlen(dir_b)) == 0;
    if (is_a || is_b)
      memcpy(printed + written, is_a ? "DIR_A" : "DIR_B", 5);
    else
      printed[written] = *c;
    written += is_a || is_b ? 5 : 1;
    c += is_a ? strlen(dir_a) : is_b ? strlen(dir_b) : 1;
  }
  printed[written] = '\0';
  free(text);
  char png[600];
  snprintf(png, sizeof png, "%s/compare.png", dir_a);
  if (status == SDR_OK && strstr(printed, "compare.png: ")) assert_int_equal(access(png, R_OK), 0);
  made_run_remove(dir_a);
  made_run_remove(dir_b);
  return status;
}

/* The line that begins with `name`, which must be there, equals `expected`. */
static void check_line(const char *printed, const char *name, const char *expected)
{
  const char *line = printed;
  while (line && strncmp(line, name, strlen(name)) != 0) {
    line = strchr(line, '\n');
    if (line) ++line;
  }
  if (!line) print_error("no line \"%s\" in:\n%s\n", name, printed);
  assert_non_null(line);
  char found[256];
  snprintf(found, sizeof found, "%.*s", (int)strcspn(line, "\n"), line);
  assert_string_equal(found, expected);
}

static void the_table_has_aligned_columns_with_difference_and_ratio(void **state)
{
  (void)state;
  char printed[8000];
  made_run other = first;
  other.cracks = 8;
  other.law = "critical_stretch";
  assert_int_equal(compare(&first, &other, printed, sizeof printed), SDR_OK);
  check_line(printed, "A: ", "A: Thick cylinder under internal pressure");
  check_line(printed, "      ",
             "                          A                     B                     "
             "B - A           B / A");
  check_line(printed, "damage law",
             "damage law                variational           critical_stretch      differs");
  check_line(printed, "onset of damage",
             "onset of damage           43.6 us               43.6 us               "
             "0 s             1");
  check_line(printed, "fragments",
             "fragments                 15                    24                    "
             "9               1.6");
  check_line(printed, "  through_cracks",
             "  through_cracks          5                     8                     "
             "3               1.6");
  check_line(printed, "dissipated energy",
             "dissipated energy         12.005 kJ             12.008 kJ             "
             "3 J             1");
  check_line(printed, "imbalance, largest",
             "imbalance, largest        0.00025               0.00025               "
             "0               1");
  check_line(printed, "time per bond and step",
             "time per bond and step    2.21 ns               2.21 ns               "
             "0 ns            1");
  check_line(printed, "DIR_A/compare.png", "DIR_A/compare.png: fields and energies of both runs");
}

static void a_run_compared_with_itself_differs_nowhere(void **state)
{
  (void)state;
  char printed[8000];
  assert_int_equal(compare(&first, &first, printed, sizeof printed), SDR_OK);
  check_line(printed, "differences at", "differences at 100 us");
  check_line(printed, "damage  ", "damage                    largest 0             RMS 0");
  check_line(printed, "displacement", "displacement              largest 0 m           RMS 0 m");
  assert_non_null(strstr(printed, "points off by over 0.1    0.00 % (0 of "));
}

static void fields_are_compared_at_the_last_common_time(void **state)
{
  (void)state;
  char printed[8000];
  made_run bar = {.dimension = 1, .cells = 40, .law = "none", .frames = 5};
  made_run other = bar;
  other.frames = 3;
  assert_int_equal(compare(&bar, &other, printed, sizeof printed), SDR_OK);
  check_line(printed, "differences at", "differences at 100 us");
  double times_a[3] = {0.0, 4e-5, 8e-5}, times_b[3] = {0.0, 4.005e-5, 9e-5};
  sdr_rundata a = {.frame_count = 3, .frame_time = times_a};
  sdr_rundata b = {.frame_count = 3, .frame_time = times_b};
  sdr_frames frames = sdr_compare_frames(&a, &b);
  assert_int_equal(frames.frame[0], 0); /* without a step in a summary times must agree */
  assert_true(frames.common);
  times_b[1] = 4e-5;
  frames = sdr_compare_frames(&a, &b);
  assert_true(frames.common && frames.frame[0] == 1 && frames.frame[1] == 1);
  times_b[0] = 1e-5;
  times_b[1] = 5e-5;
  frames = sdr_compare_frames(&a, &b);
  assert_true(!frames.common && frames.frame[0] == 2 && frames.frame[1] == 2);
}

static void the_differences_of_fields_are_exact(void **state)
{
  (void)state;
  char dir_a[512], dir_b[512], path[600], *text = NULL;
  size_t length = 0;
  const made_run bar = {.dimension = 1, .cells = 40, .law = "none", .frames = 1};
  made_run_write(made_run_name("compare-a", dir_a), &bar);
  made_run_write(made_run_name("compare-b", dir_b), &bar);
  snprintf(path, sizeof path, "%s/snapshots.h5", dir_b);
  const hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t set = H5Dopen2(file, "/frame_0000/damage", H5P_DEFAULT);
  float damage[40];
  H5Dread(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, damage);
  damage[3] += 0.25F; /* RMS of this and the next: sqrt((0.0625 + 0.0025) / 40) */
  damage[4] -= 0.05F;
  H5Dwrite(set, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, damage);
  H5Dclose(set);
  H5Fclose(file);
  FILE *out = open_memstream(&text, &length);
  assert_int_equal(sdr_compare(dir_a, dir_b, NULL, out), SDR_OK);
  fclose(out);
  check_line(text, "damage  ", "damage                    largest 0.25          RMS 0.04031");
  check_line(text, "points off", "points off by over 0.1    2.50 % (1 of 40)");
  free(text);
  made_run_remove(dir_a);
  made_run_remove(dir_b);
}

static void runs_with_different_points_share_a_picture_only(void **state)
{
  (void)state;
  char printed[8000];
  made_run other = first;
  other.turn = 0.3;
  other.cells = 30;
  assert_int_equal(compare(&first, &other, printed, sizeof printed), SDR_OK);
  check_line(printed, "no diff", "no differences of fields: the runs have different points");
  check_line(printed, "DIR_A/compare.png", "DIR_A/compare.png: fields and energies of both runs");
}

static void what_a_run_lacks_is_said(void **state)
{
  (void)state;
  char printed[8000];
  made_run other = first;
  other.frames = 0;
  assert_int_equal(compare(&first, &other, printed, sizeof printed), SDR_OK);
  check_line(printed, "no diff",
             "no differences of fields: DIR_B has no snapshots (output.snapshots: 0)");
  check_line(printed, "DIR_A/compare.png", "DIR_A/compare.png: energies of both runs");

  other = first;
  other.without_damage = 1;
  other.without_summary = 1;
  other.without_history = 1;
  assert_int_equal(compare(&first, &other, printed, sizeof printed), SDR_OK);
  check_line(printed, "DIR_B: no summary",
             "DIR_B: no summary.json, so this run has not finished; comparing what is there");
  check_line(printed, "damage  ", "damage                    not in the snapshots of both");
  check_line(printed, "DIR_B: no rows",
             "DIR_B: no rows in history.csv, so no picture of its energies");
  check_line(printed, "kinetic energy",
             "kinetic energy            18 kJ                 -"
             "                     -               -");
  check_line(printed, "DIR_A/compare.png", "DIR_A/compare.png: fields and energies of both runs");
}

static void an_unfinished_run_shows_its_last_row(void **state)
{
  (void)state;
  char printed[8000];
  made_run other = first;
  other.without_summary = 1;
  assert_int_equal(compare(&other, &other, printed, sizeof printed), SDR_OK);
  /* -9 - 3 sin(60), made_history at its end */
  check_line(printed, "imbalance  ",
             "imbalance                 -8.0856 J             -8.0856 J"
             "             0 J             1");
  check_line(printed, "end time",
             "end time                  100 us                100 us"
             "                0 s             1");
}

static void a_figure_outside_of_its_range_is_marked(void **state)
{
  (void)state;
  char printed[8000];
  made_run other = first;
  other.cracks = 4;
  assert_int_equal(compare(&first, &other, printed, sizeof printed), SDR_OK);
  assert_non_null(strstr(printed, "    B is outside of its range, 5 to 20\n"));
  assert_null(strstr(printed, "    A is outside"));
}

static void a_missing_run_is_an_io_error(void **state)
{
  (void)state;
  char dir[512], message[700];
  made_run_name("compare-a", dir);
  assert_int_equal(sdr_compare(dir, dir, NULL, stdout), SDR_IO_ERROR);
  snprintf(message, sizeof message, "%s: No such file or directory; give the directory of a run",
           dir);
  assert_string_equal(sdr_error_message(), message);
}

static void every_failing_allocation_comes_back_as_an_error(void **state)
{
  (void)state;
  char dir[512];
  const made_run run = {.dimension = 2, .cells = 12, .cracks = 3, .law = "none", .frames = 1};
  made_run_write(made_run_name("compare-a", dir), &run);
  const size_t before = sdr_memory_now();
  sdr_status status = SDR_RUN_FAILED;
  int successes = 0;
  for (; status != SDR_OK && successes < 1000; ++successes) {
    char *text = NULL;
    size_t length = 0;
    FILE *out = open_memstream(&text, &length);
    sdr_memory_fail_after(successes);
    status = sdr_compare(dir, dir, NULL, out);
    sdr_memory_fail_after(-1);
    fclose(out);
    free(text);
    if (status != SDR_OK) assert_int_equal(status, SDR_RUN_FAILED);
    assert_int_equal(sdr_memory_now(), before);
  }
  assert_int_equal(status, SDR_OK);
  assert_true(successes > 40);
  made_run_remove(dir);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_table_has_aligned_columns_with_difference_and_ratio),
      cmocka_unit_test(a_run_compared_with_itself_differs_nowhere),
      cmocka_unit_test(fields_are_compared_at_the_last_common_time),
      cmocka_unit_test(the_differences_of_fields_are_exact),
      cmocka_unit_test(runs_with_different_points_share_a_picture_only),
      cmocka_unit_test(what_a_run_lacks_is_said),
      cmocka_unit_test(an_unfinished_run_shows_its_last_row),
      cmocka_unit_test(a_figure_outside_of_its_range_is_marked),
      cmocka_unit_test(a_missing_run_is_an_io_error),
      cmocka_unit_test(every_failing_allocation_comes_back_as_an_error),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
