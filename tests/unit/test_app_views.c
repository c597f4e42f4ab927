/* app: how a picture shows a body: moved points, slices of solid bodies, movies. */
#include "app/plot.h"
#include "app/plot_view.h"
#include "base/memory.h"
#include "support/cmocka_all.h"
#include "support/made_run.h"

static const made_run block = {.dimension = 3, .cells = 8, .law = "none", .frames = 3};

static sdr_rundata *open_block(char dir[512])
{
  sdr_rundata *run = NULL;
  made_run_write(made_run_name("views", dir), &block);
  assert_int_equal(sdr_rundata_open(dir, &run), SDR_OK);
  assert_int_equal(sdr_rundata_use(run, 2), SDR_OK);
  return run;
}

/* The made block has 8 x 8 x 4 points, z from 0 on. */
static void a_slice_is_one_layer_of_points(void **state)
{
  (void)state;
  char dir[512];
  sdr_plot_view view;
  sdr_rundata *run = open_block(dir);
  const double h = 0.1 / 8;
  const struct {
    sdr_view_how how;
    int axis, points;
    double at;
  } cases[] = {{{.slice_axis = SDR_SLICE_MIDDLE}, 2, 64, 2.0 * h},
               {{.slice_axis = 3, .slice_at = 0.4 * h}, 2, 64, 0.0},
               {{.slice_axis = 1, .slice_at = -h}, 0, 32, -h},
               {{.slice_axis = 2, .slice_at = 0.0}, 1, 32, 0.0}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    assert_int_equal(sdr_plot_view_make(run, 2, &cases[k].how, &view), SDR_OK);
    assert_true(view.has_slice);
    assert_int_equal(view.slice_axis, cases[k].axis);
    assert_int_equal(view.slice.count, cases[k].points);
    assert_int_equal(view.cloud.count, 256);
    for (int32_t n = 0; n < view.slice.count; ++n) {
      const int32_t i = view.slice_point[n];
      assert_true(fabs(run->position[cases[k].axis][i] - cases[k].at) < 1e-9);
      assert_true(view.slice.position[0][n] == run->position[cases[k].axis == 0 ? 1 : 0][i]);
    }
    sdr_plot_view_clear(&view);
  }
  const sdr_view_how none = {.slice_axis = SDR_SLICE_NONE};
  assert_int_equal(sdr_plot_view_make(run, 2, &none, &view), SDR_OK);
  assert_false(view.has_slice);
  sdr_plot_view_clear(&view);
  sdr_rundata_destroy(&run);
  made_run_remove(dir);
}

static void a_slice_beside_the_body_says_where_the_body_is(void **state)
{
  (void)state;
  char dir[512], expected[800];
  sdr_plot_view view;
  sdr_rundata *run = open_block(dir);
  const sdr_view_how how = {.slice_axis = 3, .slice_at = 0.2};
  assert_int_equal(sdr_plot_view_make(run, 2, &how, &view), SDR_BAD_INPUT);
  snprintf(expected, sizeof expected,
           "%s: the slice z = 200 mm meets no point; the points lie from 0 m to 37.5 mm", dir);
  assert_string_equal(sdr_error_message(), expected);
  sdr_rundata_destroy(&run);
  made_run_remove(dir);
}

static void points_move_by_their_displacement_times_the_factor(void **state)
{
  (void)state;
  char dir[512];
  sdr_plot_view view;
  sdr_rundata *run = open_block(dir);
  const sdr_view_how how = {.deformed = 50.0, .slice_axis = 3, .slice_at = 0.0};
  assert_int_equal(sdr_plot_view_make(run, 2, &how, &view), SDR_OK);
  for (int32_t i = 0; i < view.cloud.count; ++i) {
    const double x = run->position[0][i], y = run->position[1][i], r = fmax(hypot(x, y), 1e-9);
    assert_true(fabs(view.cloud.position[0][i] - x - 50.0 * 1e-4 * x / r) < 1e-9);
  }
  assert_true(view.slice.position[1][0] == view.cloud.position[1][view.slice_point[0]]);
  assert_false(view.extent.lattice);
  sdr_plot_view_clear(&view);
  sdr_rundata_destroy(&run);
  made_run_remove(dir);
}

/* ---- movies ---------------------------------------------------------------------------------- */

static void write_program(const char *dir, const char *name, const char *text)
{
  char path[700];
  snprintf(path, sizeof path, "%s/%s", dir, name);
  FILE *file = fopen(path, "w");
  fputs(text, file);
  fclose(file);
  chmod(path, 0755);
}

/* A gnuplot that is quick: a PNG that is whole enough. */
static const char *const quick_gnuplot =
    "#!/bin/sh\n/bin/cat > /dev/null\nprintf '\\211PNG\\r\\n\\032\\n'\n"
    "printf '%080d' 0\nprintf 'IEND\\256B`\\202'\n";
/* Takes its last word for the movie. */
static const char *const copying = "#!/bin/sh\nfor last; do :; done\necho \"$0 $*\" > \"$last\"\n";

static void movie(const char *ffmpeg, const char *convert, const char *png, const char *expected)
{
  char dir[512], programs[512], path[1100], text[4000] = "";
  char *before = strdup(getenv("PATH"));
  made_run_write(made_run_name("views", dir), &block);
  made_run_name("programs", programs);
  mkdir(programs, 0777);
  write_program(programs, "gnuplot", quick_gnuplot);
  if (ffmpeg) write_program(programs, "ffmpeg", ffmpeg);
  if (convert) write_program(programs, "convert", convert);
  setenv("PATH", programs, 1);
  if (png) snprintf(path, sizeof path, "%s/%s", dir, png);
  const sdr_plot_options options = {.directory = dir,
                                    .field = "displacement",
                                    .time = NAN,
                                    .slice_axis = SDR_SLICE_NONE,
                                    .movie = 1,
                                    .png = png ? path : NULL};
  FILE *out = fmemopen(text, sizeof text, "w");
  const sdr_status status = sdr_plot(&options, out);
  fclose(out);
  setenv("PATH", before, 1);
  if (status != SDR_OK) fail_msg("%s", sdr_error_message());
  assert_non_null(strstr(text, expected));
  for (int k = 0; k < 3; ++k) {
    snprintf(path, sizeof path, "%s/displacement_frames/%04d.png", dir, k);
    assert_int_equal(unlink(path), 0);
  }
  snprintf(path, sizeof path, "rm -r '%s' '%s'", dir, programs);
  assert_int_equal(system(path), 0);
  free(before);
}

static void a_movie_is_made_by_what_is_installed(void **state)
{
  (void)state;
  movie(copying, copying, NULL, "/displacement.mp4: 3 frames, which are in ");
  movie(NULL, copying, NULL, "/displacement.gif: 3 frames, which are in ");
  movie(copying, NULL, "x.gif", "/x.gif: 3 frames, which are in ");
}

static void without_a_program_for_movies_the_frames_are_kept(void **state)
{
  (void)state;
  const char *said = "_frames: 3 frames; no movie of them, since neither ffmpeg nor ImageMagick's "
                     "convert could make one";
  movie(NULL, NULL, NULL, said);
  movie("#!/bin/sh\nexit 1\n", "#!/bin/sh\nexit 0\n", NULL,
        said); /* one fails, one writes nothing */
  movie(NULL, copying, "x.mp4", said);
}

static void a_movie_has_a_name_of_one_and_no_time(void **state)
{
  (void)state;
  char dir[512];
  made_run_write(made_run_name("views", dir), &block);
  sdr_plot_options options = {
      .directory = dir, .field = "displacement", .time = NAN, .movie = 1, .png = "x.png"};
  FILE *out = fopen("/dev/null", "w");
  assert_int_equal(sdr_plot(&options, out), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "x.png: a movie's name ends with .mp4 or .gif");
  options.time = 0.0;
  options.png = NULL;
  assert_int_equal(sdr_plot(&options, out), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "a movie shows all times; leave out --time or --movie");
  fclose(out);
  made_run_remove(dir);
}

/* ---- what a plot of a directory is called, and what it refuses ---- */

static const made_run ring = {.dimension = 2, .cells = 24, .law = "none", .frames = 3};

/* What sdr_plot printed; the caller frees. */
static char *printed_by(const sdr_plot_options *options, sdr_status expected)
{
  char *text = NULL;
  size_t length = 0;
  FILE *out = open_memstream(&text, &length);
  assert_int_equal(sdr_plot(options, out), expected);
  fclose(out);
  return text;
}

static int is_there(const char *dir, const char *name)
{
  char path[700];
  snprintf(path, sizeof path, "%s/%s", dir, name);
  return access(path, F_OK) == 0;
}

static void a_time_that_was_asked_for_is_in_the_name(void **state)
{
  (void)state;
  char dir[512];
  const sdr_plot_options options = {.directory = made_run_name("views", dir), .time = 4e-5};
  made_run_write(dir, &ring);
  char *printed = printed_by(&options, SDR_OK);
  assert_non_null(strstr(printed, "/damage_at_50us.png: damage at 50 us, frame 2 of 3\n"));
  assert_true(is_there(dir, "damage_at_50us.png") && !is_there(dir, "damage.png"));
  free(printed);
  made_run_remove(dir);
}

static void without_damage_another_field_is_drawn(void **state)
{
  (void)state;
  char dir[512];
  made_run run = ring;
  run.without_damage = 1;
  const sdr_plot_options options = {.directory = made_run_name("views", dir), .time = (double)NAN};
  made_run_write(dir, &run);
  char *printed = printed_by(&options, SDR_OK);
  assert_non_null(strstr(printed, ": no field damage; drawing displacement\n"));
  assert_non_null(strstr(printed, "/displacement.png: displacement magnitude at 100 us, "));
  free(printed);
  made_run_remove(dir);
}

static void only_a_solid_body_has_slices(void **state)
{
  (void)state;
  char dir[512], expected[600];
  const sdr_plot_options options = {
      .directory = made_run_name("views", dir), .time = (double)NAN, .slice_axis = 3};
  made_run_write(dir, &ring);
  free(printed_by(&options, SDR_BAD_INPUT));
  snprintf(expected, sizeof expected,
           "%s: only a solid body has slices, and this one has 2 dimensions; leave out --slice",
           dir);
  assert_string_equal(sdr_error_message(), expected);
  made_run_remove(dir);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_slice_is_one_layer_of_points),
      cmocka_unit_test(a_slice_beside_the_body_says_where_the_body_is),
      cmocka_unit_test(points_move_by_their_displacement_times_the_factor),
      cmocka_unit_test(a_movie_is_made_by_what_is_installed),
      cmocka_unit_test(without_a_program_for_movies_the_frames_are_kept),
      cmocka_unit_test(a_time_that_was_asked_for_is_in_the_name),
      cmocka_unit_test(without_damage_another_field_is_drawn),
      cmocka_unit_test(only_a_solid_body_has_slices),
      cmocka_unit_test(a_movie_has_a_name_of_one_and_no_time),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
