/* output: snapshots.h5 and snapshots.xdmf. */
#include "output_body.h"

#include "output/frames.h"
#include "output/hdf_trial.h"
#include "output/snapshots.h"
#include "support/damaged_h5.h"

#include <hdf5.h>

static sdr_observer *make(body *b, int snapshots)
{
  sdr_observer *observer = NULL;
  b->scene->output.snapshots = snapshots;
  assert_int_equal(sdr_snapshots_create(b->scene, b->directory, b->points, &observer), SDR_OK);
  return observer;
}

static void name_fields(body *b, int count, const char *const *names)
{
  b->scene->output.field_count = count;
  for (int f = 0; f < count; ++f) strcpy(b->scene->output.field[f], names[f]);
}

static const char *const usual[] = {"displacement", "damage"};

/* The state at a step is told by u and damage. */
static void run(body *b, sdr_observer *observer, int from, int to)
{
  for (int step = from; step <= to; ++step) {
    body_at(b, step);
    b->system->u[0][1] = step;
    b->model.damage[1] = 0.001 * step;
    assert_int_equal(body_show(b, observer), SDR_OK);
  }
}

static sdr_hdf *open_file(const body *b)
{
  sdr_hdf *file = NULL;
  assert_int_equal(sdr_hdf_open(body_path(b, "snapshots.h5"), 0, &file), SDR_OK);
  return file;
}

/* The file as it is now, closed or still being written. */
static void expect_frames(const body *b, int count, const int *steps)
{
  double times[64], damage[64];
  sdr_hdf *file = open_file(b);
  assert_int_equal(sdr_frames_times(file, times, 64), count);
  for (int k = 0; k < count; ++k) {
    char path[SDR_FRAME_PATH];
    const sdr_hdf_shape shape = {SDR_HDF_DOUBLE, 1, (size_t)b->points->count, 1};
    sdr_frame_path(path, k, "damage");
    assert_true(fabs(times[k] - steps[k] * b->moment.step_size) < 1e-15);
    assert_int_equal(sdr_hdf_read(file, path, shape, damage), SDR_OK);
    assert_true(fabs(damage[1] - 0.001 * steps[k]) < 1e-7);
  }
  sdr_hdf_discard(&file);
}

static void frames_lie_at_the_steps_nearest_to_even_times(void **state)
{
  (void)state;
  body b;
  body_create(&b, 3, 2);
  name_fields(&b, 2, usual);
  sdr_observer *observer = make(&b, 3);
  run(&b, observer, 0, 100);
  assert_int_equal(observer->ops->finish(observer, &b.moment), SDR_OK);
  expect_frames(&b, 4, (const int[]){0, 33, 67, 100});
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static void steps_longer_than_the_spacing_of_frames_give_a_frame_each(void **state)
{
  (void)state;
  body b;
  body_create(&b, 3, 2);
  name_fields(&b, 2, usual);
  b.moment.steps = 3;
  b.moment.end = 3e-6;
  sdr_observer *observer = make(&b, 20);
  run(&b, observer, 0, 3);
  assert_int_equal(observer->ops->finish(observer, &b.moment), SDR_OK);
  expect_frames(&b, 4, (const int[]){0, 1, 2, 3});
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static void the_last_step_has_a_frame_even_short_of_the_end(void **state)
{
  (void)state;
  body b;
  body_create(&b, 3, 2);
  name_fields(&b, 2, usual);
  sdr_observer *observer = make(&b, 2);
  run(&b, observer, 0, 80);
  assert_int_equal(observer->ops->finish(observer, &b.moment), SDR_OK);
  expect_frames(&b, 3, (const int[]){0, 50, 80});
  observer->ops->destroy(observer);
  body_destroy(&b);
}

/* 100 steps of 1 us to 99.4 us: the step before the last is nearer to the end than the last. */
static void the_last_frame_is_that_of_the_last_step(void **state)
{
  (void)state;
  body b;
  body_create(&b, 3, 2);
  name_fields(&b, 2, usual);
  b.moment.end = 99.4e-6;
  sdr_observer *observer = make(&b, 2);
  run(&b, observer, 0, 100);
  assert_int_equal(observer->ops->finish(observer, &b.moment), SDR_OK);
  expect_frames(&b, 3, (const int[]){0, 50, 100});
  /* Resumed where nothing is left to do, it has its last frame. */
  assert_int_equal(observer->ops->resumed(observer, &b.moment), SDR_OK);
  assert_int_equal(observer->ops->finish(observer, &b.moment), SDR_OK);
  expect_frames(&b, 3, (const int[]){0, 50, 100});
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static void no_snapshots_make_no_file(void **state)
{
  (void)state;
  body b;
  body_create(&b, 3, 2);
  name_fields(&b, 2, usual);
  sdr_observer *observer = make(&b, 0);
  run(&b, observer, 0, 100);
  assert_int_equal(observer->ops->finish(observer, &b.moment), SDR_OK);
  assert_int_equal(observer->ops->resumed(observer, &b.moment), SDR_OK);
  assert_false(body_has(&b, "snapshots.h5"));
  assert_false(body_has(&b, "snapshots.xdmf"));
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static void expect_shape(sdr_hdf *file, const char *name, sdr_hdf_type type, int rank, size_t rows,
                         size_t columns)
{
  sdr_hdf_shape shape;
  assert_int_equal(sdr_hdf_shape_of(file, name, &shape), SDR_OK);
  assert_int_equal(shape.type, type);
  assert_int_equal(shape.rank, rank);
  assert_int_equal(shape.rows, rows);
  assert_int_equal(shape.columns, columns);
}

static void the_file_has_the_layout_of_the_contract(void **state)
{
  (void)state;
  body b;
  const char *const fields[] = {"displacement", "damage", "stress", "fragment"};
  body_create(&b, 3, 2);
  name_fields(&b, 4, fields);
  sdr_observer *observer = make(&b, 1);
  run(&b, observer, 0, 0);
  sdr_hdf *file = open_file(&b);
  expect_shape(file, "points/index", SDR_HDF_INT32, 1, 3, 1);
  expect_shape(file, "points/position", SDR_HDF_DOUBLE, 2, 3, 3);
  expect_shape(file, "points/volume", SDR_HDF_DOUBLE, 1, 3, 1);
  expect_shape(file, "points/horizon", SDR_HDF_DOUBLE, 1, 3, 1);
  expect_shape(file, "points/spacing", SDR_HDF_DOUBLE, 1, 3, 1);
  expect_shape(file, "frame_0000/time", SDR_HDF_DOUBLE, 0, 1, 1);
  expect_shape(file, "frame_0000/displacement", SDR_HDF_FLOAT, 2, 3, 2);
  expect_shape(file, "frame_0000/damage", SDR_HDF_FLOAT, 1, 3, 1);
  expect_shape(file, "frame_0000/stress", SDR_HDF_FLOAT, 2, 3, 3);
  expect_shape(file, "frame_0000/fragment", SDR_HDF_FLOAT, 1, 3, 1);
  assert_int_equal(sdr_hdf_count(file, "frame_0000"), 5);
  assert_int_equal(sdr_hdf_count(file, "points"), 5);
  assert_int_equal(sdr_hdf_count(file, "/"), 2);
  sdr_hdf_discard(&file);
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static void expect_values(sdr_hdf *file, const char *name, size_t count, const double *wanted)
{
  double values[16];
  const sdr_hdf_shape shape = {SDR_HDF_DOUBLE, 1, count, 1};
  assert_int_equal(sdr_hdf_read(file, name, shape, values), SDR_OK);
  assert_memory_equal(values, wanted, count * sizeof *wanted);
}

static void points_stand_in_the_order_of_generation(void **state)
{
  (void)state;
  body b;
  const int32_t order[3] = {2, 0, 1};
  const char *const fields[] = {"displacement", "fragment", "stress"};
  body_create(&b, 3, 2);
  name_fields(&b, 3, fields);
  b.points->generated = sdr_alloc(3, sizeof *b.points->generated);
  memcpy(b.points->generated, order, sizeof order);
  for (int i = 0; i < 3; ++i) {
    b.points->volume[i] = 10.0 + i;
    b.system->u[0][i] = 1.0 + i;
    b.system->u[1][i] = -1.0 - i;
  }
  sdr_observer *observer = make(&b, 1);
  assert_int_equal(body_show(&b, observer), SDR_OK);
  sdr_hdf *file = open_file(&b);
  expect_values(file, "points/index", 3, (const double[]){0, 1, 2});
  expect_values(file, "points/position", 9, (const double[]){1, 0, 0, 2, 0, 0, 0, 0, 0});
  expect_values(file, "points/volume", 3, (const double[]){11, 12, 10});
  expect_values(file, "frame_0000/displacement", 6, (const double[]){2, -2, 3, -3, 1, -1});
  expect_values(file, "frame_0000/fragment", 3, (const double[]){1, 2, 0});
  expect_values(file, "frame_0000/stress", 9,
                (const double[]){1, 101, 201, 2, 102, 202, 0, 100, 200});
  sdr_hdf_discard(&file);
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static void a_missing_dataset_or_another_size_is_bad_input(void **state)
{
  (void)state;
  body b;
  char wanted[256];
  double values[9];
  sdr_hdf_shape shape = {SDR_HDF_DOUBLE, 1, 4, 1};
  body_create(&b, 3, 2);
  name_fields(&b, 2, usual);
  sdr_observer *observer = make(&b, 2);
  run(&b, observer, 0, 0);
  sdr_hdf *file = open_file(&b);
  assert_int_equal(sdr_hdf_read(file, "frame_0000/damage", shape, values), SDR_BAD_INPUT);
  snprintf(wanted, sizeof wanted, "%s/snapshots.h5: frame_0000/damage holds 3 values, not 4",
           b.directory);
  assert_string_equal(sdr_error_message(), wanted);
  assert_false(sdr_hdf_has(file, "frame_0000/stress"));
  assert_false(sdr_hdf_has(file, "frame_0001/damage"));
  assert_int_equal(sdr_hdf_shape_of(file, "frame_0001/damage", &shape), SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), "snapshots.h5: frame_0001/damage cannot be read: "));
  sdr_hdf_discard(&file);
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static void a_file_that_is_missing_or_no_hdf5_is_told_apart(void **state)
{
  (void)state;
  body b;
  sdr_hdf *file = NULL;
  char wanted[256];
  body_create(&b, 3, 2);
  assert_int_equal(sdr_hdf_open(body_path(&b, "snapshots.h5"), 0, &file), SDR_IO_ERROR);
  snprintf(wanted, sizeof wanted, "cannot read %s/snapshots.h5: No such file or directory",
           b.directory);
  assert_string_equal(sdr_error_message(), wanted);
  body_write(&b, "snapshots.h5", "time,kinetic\n");
  assert_int_equal(sdr_hdf_open(body_path(&b, "snapshots.h5"), 0, &file), SDR_BAD_INPUT);
  snprintf(wanted, sizeof wanted,
           "%s/snapshots.h5 is not a whole HDF5 file: file signature not found", b.directory);
  assert_string_equal(sdr_error_message(), wanted);
  assert_null(file);
  body_destroy(&b);
}

static int occurrences(const char *text, const char *part)
{
  int count = 0;
  for (const char *at = strstr(text, part); at; at = strstr(at + 1, part)) ++count;
  return count;
}

static void the_xdmf_names_every_frame_and_its_vertices(void **state)
{
  (void)state;
  body b;
  body_create(&b, 3, 3);
  name_fields(&b, 2, usual);
  sdr_observer *observer = make(&b, 4);
  run(&b, observer, 0, 100);
  char *text = body_read(&b, "snapshots.xdmf");
  assert_int_equal(occurrences(text, "<Time Value=\""), 5);
  assert_int_equal(occurrences(text, "TopologyType=\"Polyvertex\" NumberOfElements=\"3\""), 5);
  assert_int_equal(occurrences(text, "snapshots.h5:/points/index"), 5);
  assert_int_equal(occurrences(text, "AttributeType=\"Vector\""), 5);
  assert_int_equal(occurrences(text, "Dimensions=\"3 3\" Format=\"HDF\">snapshots.h5:/frame_0004/"
                                     "displacement"),
                   1);
  free(text);
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static void an_unknown_field_is_refused(void **state)
{
  (void)state;
  body b;
  sdr_observer *observer = NULL;
  body_create(&b, 3, 2);
  name_fields(&b, 1, (const char *const[]){"stres"});
  assert_int_equal(sdr_snapshots_create(b.scene, b.directory, b.points, &observer), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "output.fields: there is no field 'stres'");
  body_destroy(&b);
}

/* ---- resume and accidents -------------------------------------------------------------------- */

static void a_resumed_file_holds_the_frames_of_a_run_never_stopped(void **state)
{
  (void)state;
  body b;
  sdr_observer *next = NULL;
  body_create(&b, 3, 2);
  name_fields(&b, 2, usual);
  sdr_observer *observer = make(&b, 4);
  run(&b, observer, 0, 100);
  observer->ops->destroy(observer);
  char *whole = body_read(&b, "snapshots.xdmf");
  next = make(&b, 4);
  run(&b, next, 61, 60); /* nothing: only the state below */
  body_at(&b, 60);
  assert_int_equal(next->ops->resumed(next, &b.moment), SDR_OK);
  expect_frames(&b, 3, (const int[]){0, 25, 50});
  char *cut = body_read(&b, "snapshots.xdmf");
  assert_int_equal(occurrences(cut, "<Time"), 3);
  run(&b, next, 61, 100);
  assert_int_equal(next->ops->finish(next, &b.moment), SDR_OK);
  expect_frames(&b, 5, (const int[]){0, 25, 50, 75, 100});
  char *again = body_read(&b, "snapshots.xdmf");
  assert_string_equal(again, whole);
  free(whole);
  free(cut);
  free(again);
  next->ops->destroy(next);
  body_destroy(&b);
}

/* As a kill can leave it: the superblock counts bytes that were never written. HDF5 refuses it. */
static void a_file_cut_short_behind_its_frames_goes_on(void **state)
{
  (void)state;
  body b;
  struct stat info;
  char path[4200];
  sdr_hdf *file = NULL;
  body_create(&b, 3, 2);
  name_fields(&b, 2, usual);
  sdr_observer *observer = make(&b, 4);
  run(&b, observer, 0, 60);
  snprintf(path, sizeof path, "%s/snapshots.h5", b.directory);
  assert_int_equal(stat(path, &info), 0);
  const off_t whole = info.st_size; /* with the frames at 0, 25 and 50 */
  run(&b, observer, 61, 80);
  observer->ops->destroy(observer);
  assert_int_equal(stat(path, &info), 0);
  assert_true(info.st_size > whole);
  assert_int_equal(truncate(path, info.st_size - 1), 0);
  assert_int_equal(sdr_hdf_open(path, 0, &file), SDR_BAD_INPUT);
  sdr_observer *next = make(&b, 4);
  body_at(&b, 60);
  assert_int_equal(next->ops->resumed(next, &b.moment), SDR_OK);
  expect_frames(&b, 3, (const int[]){0, 25, 50});
  run(&b, next, 61, 100);
  assert_int_equal(next->ops->finish(next, &b.moment), SDR_OK);
  expect_frames(&b, 5, (const int[]){0, 25, 50, 75, 100});
  assert_false(body_has(&b, "snapshots.h5.part"));
  next->ops->destroy(next);
  body_destroy(&b);
}

/* A run that stopped at step 60 of 100, with frames at 0, 25 and 50; the file's path. */
static void leave_frames(body *b, char path[4200])
{
  body_create(b, 3, 2);
  name_fields(b, 2, usual);
  sdr_observer *observer = make(b, 4);
  run(b, observer, 0, 60);
  observer->ops->destroy(observer);
  snprintf(path, 4200, "%s/snapshots.h5", b->directory);
}

static void a_file_over_which_hdf5_would_hang_is_refused(void **state)
{
  (void)state;
  body b;
  char path[4200], wanted[4400];
  leave_frames(&b, path);
  assert_int_equal(sdr_hdf_trial(path), SDR_OK);
  loop_the_names(path);
  assert_int_equal(sdr_hdf_trial(path), SDR_IO_ERROR);
  snprintf(wanted, sizeof wanted,
           "%s: damaged, HDF5 does not get through it; move it away to go on without it", path);
  assert_string_equal(sdr_error_message(), wanted);
  body_destroy(&b);
}

static void a_damaged_file_is_not_written_over(void **state)
{
  (void)state;
  body b;
  char path[4200];
  struct stat before, after;
  leave_frames(&b, path);
  loop_the_members(path);
  assert_int_equal(stat(path, &before), 0);
  sdr_observer *next = make(&b, 4);
  assert_int_equal(next->ops->resumed(next, &b.moment), SDR_IO_ERROR);
  assert_non_null(strstr(sdr_error_message(), "damaged, HDF5 does not get through it"));
  assert_int_equal(stat(path, &after), 0);
  assert_true(before.st_ino == after.st_ino && before.st_size == after.st_size);
  assert_int_equal(before.st_mtim.tv_nsec, after.st_mtim.tv_nsec);
  assert_int_equal(rename(path, body_path(&b, "damaged.h5")), 0);
  assert_int_equal(next->ops->resumed(next, &b.moment), SDR_OK); /* as the message says */
  next->ops->destroy(next);
  body_destroy(&b);
}

/* Chunks, and values that the file has no bytes for, are none of ours. */
static void values_that_no_file_of_ours_holds_are_refused(void **state)
{
  (void)state;
  body b;
  char path[4200];
  leave_frames(&b, path);
  const hsize_t sizes[] = {10, 1 << 20};
  for (int chunked = 0; chunked < 2; ++chunked) {
    const hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    const hid_t space = H5Screate_simple(1, &sizes[!chunked], NULL),
                how = H5Pcreate(H5P_DATASET_CREATE);
    if (chunked) H5Pset_chunk(how, 1, &sizes[0]);
    H5Dclose(H5Dcreate2(file, "x", H5T_NATIVE_FLOAT, space, H5P_DEFAULT, how, H5P_DEFAULT));
    H5Pclose(how);
    H5Sclose(space);
    H5Fclose(file);
    assert_int_equal(sdr_hdf_trial(path), SDR_IO_ERROR);
  }
  unlink(path);
  assert_int_equal(sdr_hdf_trial(path), SDR_IO_ERROR);
  assert_non_null(strstr(sdr_error_message(), "snapshots.h5: No such file or directory"));
  body_destroy(&b);
}

static void a_frame_at_the_checkpoint_is_kept_or_made_up(void **state)
{
  (void)state;
  for (int there = 0; there < 2; ++there) {
    body b;
    body_create(&b, 3, 2);
    name_fields(&b, 2, usual);
    sdr_observer *observer = make(&b, 4);
    run(&b, observer, 0, there ? 50 : 49);
    observer->ops->destroy(observer);
    observer = make(&b, 4);
    body_at(&b, 50);
    b.system->u[0][1] = 50.0;
    b.model.damage[1] = 0.05;
    assert_int_equal(observer->ops->resumed(observer, &b.moment), SDR_OK);
    expect_frames(&b, 3, (const int[]){0, 25, 50});
    observer->ops->destroy(observer);
    body_destroy(&b);
  }
}

static void a_run_resumed_elsewhere_begins_with_a_frame_of_its_own(void **state)
{
  (void)state;
  body b;
  body_create(&b, 3, 2);
  name_fields(&b, 2, usual);
  sdr_observer *observer = make(&b, 4);
  body_at(&b, 60);
  b.model.damage[1] = 0.06;
  assert_int_equal(observer->ops->resumed(observer, &b.moment), SDR_OK);
  run(&b, observer, 61, 100);
  expect_frames(&b, 3, (const int[]){60, 75, 100});
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static void a_file_of_another_body_is_not_continued(void **state)
{
  (void)state;
  body b, other;
  char wanted[256];
  body_create(&b, 3, 2);
  body_create(&other, 4, 2);
  name_fields(&b, 2, usual);
  sdr_observer *observer = make(&b, 4);
  run(&b, observer, 0, 10);
  observer->ops->destroy(observer);
  assert_int_equal(sdr_snapshots_create(b.scene, b.directory, other.points, &observer), SDR_OK);
  assert_int_equal(observer->ops->resumed(observer, &b.moment), SDR_BAD_INPUT);
  snprintf(wanted, sizeof wanted,
           "%s/snapshots.h5 holds 3 points, this run has 4, so it cannot be continued; give "
           "another directory with -o",
           b.directory);
  assert_string_equal(sdr_error_message(), wanted);
  observer->ops->destroy(observer);
  body_destroy(&other);
  body_destroy(&b);
}

static void a_killed_run_leaves_its_frames_readable(void **state)
{
  (void)state;
  body b;
  body_create(&b, 50, 2);
  name_fields(&b, 2, usual);
  fflush(NULL);
  const pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) {
    sdr_observer *observer = make(&b, 10);
    run(&b, observer, 0, 55);
    raise(SIGKILL);
  }
  waitpid(child, NULL, 0);
  expect_frames(&b, 6, (const int[]){0, 10, 20, 30, 40, 50});
  sdr_observer *observer = make(&b, 10);
  body_at(&b, 30);
  assert_int_equal(observer->ops->resumed(observer, &b.moment), SDR_OK);
  run(&b, observer, 31, 100);
  expect_frames(&b, 11, (const int[]){0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100});
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static int fill_snapshots(void *context)
{
  body *b = context;
  sdr_observer *observer = make(b, 100);
  char wanted[256];
  snprintf(wanted, sizeof wanted, "cannot write %s/snapshots.h5: File too large", b->directory);
  for (int step = 0; step <= 100; ++step) {
    body_at(b, step);
    b->model.damage[1] = 0.001 * step;
    const sdr_status status = body_show(b, observer);
    if (status == SDR_OK) continue;
    observer->ops->destroy(observer);
    return status == SDR_IO_ERROR && strcmp(sdr_error_message(), wanted) == 0 ? 0 : 2;
  }
  return 1;
}

static void a_full_disk_keeps_the_frames_before(void **state)
{
  (void)state;
  static const int steps[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  body b;
  body_create(&b, 50, 2);
  name_fields(&b, 2, usual);
  assert_int_equal(body_with_full_disk(90000, fill_snapshots, &b), 0);
  sdr_hdf *file = open_file(&b);
  const int count = sdr_frames_times(file, NULL, 0);
  sdr_hdf_discard(&file);
  assert_true(count > 1 && count < 16);
  expect_frames(&b, count, steps);
  char *text = body_read(&b, "snapshots.xdmf");
  assert_int_equal(occurrences(text, "<Time"), count);
  free(text);
  body_destroy(&b);
}

static void a_missing_directory_is_an_io_error(void **state)
{
  (void)state;
  body b;
  sdr_observer *observer = NULL;
  body_create(&b, 3, 2);
  name_fields(&b, 2, usual);
  b.scene->output.snapshots = 1;
  assert_int_equal(sdr_snapshots_create(b.scene, "no/such", b.points, &observer), SDR_OK);
  assert_int_equal(body_show(&b, observer), SDR_IO_ERROR);
  assert_string_equal(sdr_error_message(),
                      "cannot write no/such/snapshots.h5: No such file or directory");
  observer->ops->destroy(observer);
  body_destroy(&b);
}

static void a_disk_too_full_for_a_frame_leaves_no_file(void **state)
{
  (void)state;
  body b;
  body_create(&b, 50, 2);
  name_fields(&b, 2, usual);
  assert_int_equal(body_with_full_disk(3000, fill_snapshots, &b), 0);
  assert_false(body_has(&b, "snapshots.h5"));
  assert_false(body_has(&b, "snapshots.xdmf"));
  body_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(frames_lie_at_the_steps_nearest_to_even_times),
      cmocka_unit_test(steps_longer_than_the_spacing_of_frames_give_a_frame_each),
      cmocka_unit_test(the_last_step_has_a_frame_even_short_of_the_end),
      cmocka_unit_test(the_last_frame_is_that_of_the_last_step),
      cmocka_unit_test(no_snapshots_make_no_file),
      cmocka_unit_test(the_file_has_the_layout_of_the_contract),
      cmocka_unit_test(points_stand_in_the_order_of_generation),
      cmocka_unit_test(a_missing_dataset_or_another_size_is_bad_input),
      cmocka_unit_test(a_file_that_is_missing_or_no_hdf5_is_told_apart),
      cmocka_unit_test(the_xdmf_names_every_frame_and_its_vertices),
      cmocka_unit_test(an_unknown_field_is_refused),
      cmocka_unit_test(a_resumed_file_holds_the_frames_of_a_run_never_stopped),
      cmocka_unit_test(a_file_cut_short_behind_its_frames_goes_on),
      cmocka_unit_test(a_file_over_which_hdf5_would_hang_is_refused),
      cmocka_unit_test(a_damaged_file_is_not_written_over),
      cmocka_unit_test(values_that_no_file_of_ours_holds_are_refused),
      cmocka_unit_test(a_frame_at_the_checkpoint_is_kept_or_made_up),
      cmocka_unit_test(a_run_resumed_elsewhere_begins_with_a_frame_of_its_own),
      cmocka_unit_test(a_file_of_another_body_is_not_continued),
      cmocka_unit_test(a_killed_run_leaves_its_frames_readable),
      cmocka_unit_test(a_full_disk_keeps_the_frames_before),
      cmocka_unit_test(a_missing_directory_is_an_io_error),
      cmocka_unit_test(a_disk_too_full_for_a_frame_leaves_no_file),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
