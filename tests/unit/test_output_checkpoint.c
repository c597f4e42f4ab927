/* output: checkpoints. */
#include "output_body.h"

#include "output/checkpoint.h"

enum { POINTS = 40 };

/* An observer with a block of state, which counts how often it is told of a resume. */
typedef struct {
  sdr_observer head;
  double sum;
  int resumes;
  sdr_status answer;
} witness;

static void witness_state(sdr_observer *observer, sdr_state_block *blocks, int *count)
{
  witness *w = (witness *)observer;
  blocks[0] = (sdr_state_block){"sum", &w->sum, sizeof w->sum};
  *count = 1;
}

static sdr_status witness_resumed(sdr_observer *observer, const sdr_moment *moment)
{
  witness *w = (witness *)observer;
  (void)moment;
  ++w->resumes;
  return w->answer == SDR_OK ? SDR_OK : sdr_fail(w->answer, "no");
}

static const sdr_observer_ops witness_ops = {
    .name = "witness", .state = witness_state, .resumed = witness_resumed};
static const sdr_observer_ops mute_ops = {.name = "mute"};

typedef struct {
  body b;
  witness seen;
  sdr_observer mute;
  sdr_observer *observers[2];
  sdr_load load;
} fixture;

static void fixture_destroy(fixture *f)
{
  body_destroy(&f->b);
  sdr_expression_destroy(&f->load.value[0]);
}

static void fill(double *values, double seed)
{
  for (int i = 0; i < POINTS; ++i) values[i] = seed + 1.0 / (3.0 + i);
}

/* A run whose every number is told by `seed`. */
static void fixture_create(fixture *f, double seed)
{
  const sdr_unit force = {1, 1, -2, 0};
  body_create(&f->b, POINTS, 2);
  f->load = (sdr_load){.kind = SDR_POINT_FORCE, .schedule = {-HUGE_VAL, HUGE_VAL, 0.0}};
  assert_int_equal(sdr_expression_create("5 N", force, NULL, NULL, &f->load.value[0]), SDR_OK);
  f->b.scene->load = &f->load;
  f->b.scene->load_count = 1;
  body_wire(&f->b);
  f->b.system->load_before[0][0] = seed + 14.0;
  for (int c = 0; c < 2; ++c) {
    fill(f->b.system->u[c], seed + c);
    fill(f->b.system->v[c], seed + 2.0 + c);
    fill(f->b.system->f[c], seed + 4.0 + c);
    f->b.system->impulse[c] = seed + 6.0 + c;
    f->b.system->angular_impulse[c] = seed + 8.0 + c;
  }
  fill(f->b.model.history, seed + 10.0);
  f->b.system->external_work = seed + 11.0;
  f->b.system->viscous = seed + 12.0;
  f->b.system->velocity_offset = seed + 12.0;
  f->b.scene->hash = UINT64_C(0x0123456789abcdef);
  f->b.moment.step_size = 1e-6 * (1.0 + seed);
  body_at(&f->b, 10 + (int)seed);
  f->seen = (witness){.head.ops = &witness_ops, .sum = seed + 13.0};
  f->mute = (sdr_observer){&mute_ops};
  f->observers[0] = &f->seen.head;
  f->observers[1] = &f->mute;
}

static sdr_status write_to(fixture *f, const char *directory)
{
  return sdr_checkpoint_write(directory, &f->b.moment, "avx2", f->observers, 2);
}

static sdr_status read_from(fixture *f, const char *directory)
{
  char path[128];
  snprintf(path, sizeof path, "%s/checkpoint.h5", directory);
  return sdr_checkpoint_read(path, &f->b.moment, "avx2", f->observers, 2);
}

static void expect_same(const fixture *a, const fixture *c)
{
  const size_t bytes = POINTS * sizeof(double);
  for (int k = 0; k < 2; ++k) {
    assert_memory_equal(a->b.system->u[k], c->b.system->u[k], bytes);
    assert_memory_equal(a->b.system->v[k], c->b.system->v[k], bytes);
    assert_memory_equal(a->b.system->f[k], c->b.system->f[k], bytes);
  }
  assert_memory_equal(a->b.model.history, c->b.model.history, bytes);
  assert_memory_equal(a->b.system->impulse, c->b.system->impulse, 3 * sizeof(double));
  assert_memory_equal(a->b.system->angular_impulse, c->b.system->angular_impulse,
                      3 * sizeof(double));
  assert_true(a->b.system->load_before[0][0] == c->b.system->load_before[0][0]);
  assert_true(a->b.system->external_work == c->b.system->external_work);
  assert_true(a->b.system->viscous == c->b.system->viscous);
  assert_true(a->b.system->velocity_offset == c->b.system->velocity_offset);
  assert_true(a->b.system->time == c->b.system->time && a->b.moment.time == c->b.moment.time);
  assert_true(a->b.moment.step_size == c->b.moment.step_size);
  assert_int_equal(a->b.moment.step, c->b.moment.step);
  assert_int_equal(a->b.system->step, c->b.system->step);
  assert_true(a->seen.sum == c->seen.sum);
}

/* A run and a checkpoint of another one with the same scene. */
typedef struct {
  fixture from, to, untouched;
} pair;

static void pair_create(pair *p)
{
  fixture_create(&p->from, 1.0);
  fixture_create(&p->to, 2.0);
  fixture_create(&p->untouched, 2.0);
  assert_int_equal(write_to(&p->from, p->from.b.directory), SDR_OK);
}

static void pair_destroy(pair *p)
{
  fixture_destroy(&p->from);
  fixture_destroy(&p->to);
  fixture_destroy(&p->untouched);
}

static void expect_refused(pair *p, const char *message)
{
  char wanted[512];
  const size_t before = sdr_memory_now();
  assert_int_equal(read_from(&p->to, p->from.b.directory), SDR_BAD_INPUT);
  snprintf(wanted, sizeof wanted, "%s/checkpoint.h5 %s", p->from.b.directory, message);
  assert_string_equal(sdr_error_message(), wanted);
  expect_same(&p->to, &p->untouched);
  assert_int_equal(p->to.seen.resumes, 0);
  assert_int_equal(sdr_memory_now(), before);
}

/* ---- claims ---------------------------------------------------------------------------------- */

static void a_checkpoint_brings_back_every_bit(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  body_write(&p.to.b, "summary.json", "{}");
  body_write(&p.to.b, "notes.txt", "mine");
  assert_false(body_has(&p.from.b, "checkpoint.h5.part"));
  assert_int_equal(read_from(&p.to, p.from.b.directory), SDR_OK);
  expect_same(&p.to, &p.from);
  assert_int_equal(p.to.seen.resumes, 1);
  assert_false(body_has(&p.to.b, "summary.json")); /* it is not complete any more */
  assert_true(body_has(&p.to.b, "notes.txt"));
  pair_destroy(&p);
}

static void what_an_observer_says_on_resume_is_passed_on(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  p.to.seen.answer = SDR_IO_ERROR;
  assert_int_equal(read_from(&p.to, p.from.b.directory), SDR_IO_ERROR);
  assert_string_equal(sdr_error_message(), "no");
  pair_destroy(&p);
}

static void another_scene_is_refused(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  p.to.b.scene->hash = 1;
  expect_refused(&p, "does not fit this run: its scene hash is 0123456789abcdef, this run's is "
                     "0000000000000001; only title, output, figures, threads, time.end, "
                     "time.allow_unstable and damage.onset may differ");
  pair_destroy(&p);
}

static void another_precision_is_refused(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  p.to.b.scene->mixed = 1;
  expect_refused(&p, "does not fit this run: its precision is double, this run's is mixed; only "
                     "title, output, figures, "
                     "threads, time.end, time.allow_unstable and damage.onset may differ");
  pair_destroy(&p);
}

static void another_number_of_points_is_refused(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  p.to.b.system->count = POINTS - 1;
  expect_refused(&p, "does not fit this run: its number of points is 40, this run's is 39; only "
                     "title, output, figures, "
                     "threads, time.end, time.allow_unstable and damage.onset may differ");
  pair_destroy(&p);
}

static void another_instruction_set_is_refused(void **state)
{
  (void)state;
  pair p;
  char path[128], wanted[512];
  pair_create(&p);
  snprintf(path, sizeof path, "%s/checkpoint.h5", p.from.b.directory);
  assert_int_equal(sdr_checkpoint_read(path, &p.to.b.moment, "avx512", p.to.observers, 2),
                   SDR_BAD_INPUT);
  snprintf(wanted, sizeof wanted,
           "%s does not fit this run: its instruction set is avx2, this run's is avx512; only "
           "title, output, figures, "
           "threads, time.end, time.allow_unstable and damage.onset may differ",
           path);
  assert_string_equal(sdr_error_message(), wanted);
  expect_same(&p.to, &p.untouched);
  pair_destroy(&p);
}

static void an_observer_without_state_there_is_refused(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  assert_int_equal(
      sdr_checkpoint_write(p.from.b.directory, &p.from.b.moment, "avx2", p.from.observers, 0),
      SDR_OK);
  expect_refused(&p, "does not fit this run: it has no observers/witness/sum");
  pair_destroy(&p);
}

static void a_missing_file_is_an_io_error(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  assert_int_equal(read_from(&p.to, "no/such"), SDR_IO_ERROR);
  assert_string_equal(sdr_error_message(),
                      "cannot read no/such/checkpoint.h5: No such file or directory");
  expect_same(&p.to, &p.untouched);
  pair_destroy(&p);
}

static const char not_whole[] = "is not a whole checkpoint: it is truncated or damaged";

static void a_file_of_another_kind_is_refused(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  body_write(&p.from.b, "checkpoint.h5", "title: a scene\n");
  expect_refused(&p, not_whole);
  body_write(&p.from.b, "checkpoint.h5", "");
  expect_refused(&p, not_whole);
  pair_destroy(&p);
}

static void a_truncated_file_is_refused_wherever_it_ends(void **state)
{
  (void)state;
  pair p;
  struct stat status;
  char path[128];
  pair_create(&p);
  snprintf(path, sizeof path, "%s/checkpoint.h5", p.from.b.directory);
  assert_int_equal(stat(path, &status), 0);
  for (off_t size = status.st_size - 1; size > 0; size -= 997) {
    assert_int_equal(truncate(path, size), 0);
    expect_refused(&p, not_whole);
  }
  pair_destroy(&p);
}

static long find_bytes(FILE *file, const void *bytes, size_t size)
{
  char block[65536];
  rewind(file);
  const size_t length = fread(block, 1, sizeof block, file);
  const char *found = memmem(block, length, bytes, size);
  assert_non_null(found);
  return found - block;
}

static void a_flipped_bit_in_the_state_is_refused(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  FILE *file = fopen(body_path(&p.from.b, "checkpoint.h5"), "r+");
  assert_non_null(file);
  const long at = find_bytes(file, p.from.b.model.history + 7, sizeof(double));
  fseek(file, at, SEEK_SET);
  const int byte = fgetc(file);
  fseek(file, at, SEEK_SET);
  fputc(byte ^ 4, file);
  fclose(file);
  expect_refused(&p, not_whole);
  pair_destroy(&p);
}

/* HDF5 must not see it: over some of these it hangs or takes all memory. */
static void a_flipped_bit_anywhere_is_refused(void **state)
{
  (void)state;
  pair p;
  struct stat status;
  pair_create(&p);
  const int file = open(body_path(&p.from.b, "checkpoint.h5"), O_RDWR);
  assert_true(file >= 0 && fstat(file, &status) == 0);
  for (off_t at = 0; at < status.st_size; at += 173) {
    unsigned char byte, flipped;
    assert_int_equal(pread(file, &byte, 1, at), 1);
    flipped = byte ^ (unsigned char)(1 << at % 8);
    assert_int_equal(pwrite(file, &flipped, 1, at), 1);
    expect_refused(&p, not_whole);
    assert_int_equal(pwrite(file, &byte, 1, at), 1);
  }
  assert_int_equal(pwrite(file, "", 1, status.st_size), 1); /* one byte more */
  expect_refused(&p, not_whole);
  assert_int_equal(ftruncate(file, status.st_size), 0);
  close(file);
  assert_int_equal(read_from(&p.to, p.from.b.directory), SDR_OK);
  pair_destroy(&p);
}

static int write_again(void *context)
{
  fixture *f = context;
  char wanted[256];
  snprintf(wanted, sizeof wanted, "cannot write %s/checkpoint.h5.part: File too large",
           f->b.directory);
  return write_to(f, f->b.directory) == SDR_IO_ERROR && strcmp(sdr_error_message(), wanted) == 0
             ? 0
             : 1;
}

static void a_full_disk_leaves_the_checkpoint_before(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  for (rlim_t bytes = 100; bytes < 20000; bytes *= 3) {
    p.from.b.system->u[0][0] = 77.0; /* never gets there */
    assert_int_equal(body_with_full_disk(bytes, write_again, &p.from), 0);
  }
  fill(p.from.b.system->u[0], 1.0);
  assert_false(body_has(&p.from.b, "checkpoint.h5.part"));
  assert_int_equal(read_from(&p.to, p.from.b.directory), SDR_OK);
  expect_same(&p.to, &p.from);
  pair_destroy(&p);
}

static void a_checkpoint_is_due_nearest_to_each_multiple_and_at_the_end(void **state)
{
  (void)state;
  body b;
  int due[8], count = 0;
  body_create(&b, 2, 1);
  b.scene->output.checkpoint_every = 30.4e-6;
  for (int step = 0; step <= 100; ++step) {
    body_at(&b, step);
    if (sdr_checkpoint_due(&b.moment)) due[count++] = step;
  }
  assert_int_equal(count, 4);
  assert_memory_equal(due, ((const int[]){30, 61, 91, 100}), 4 * sizeof *due);
  b.scene->output.checkpoint_every = INFINITY;
  assert_int_equal(sdr_checkpoint_due(&b.moment), 0);
  body_destroy(&b);
}

static void running_out_of_memory_changes_nothing(void **state)
{
  (void)state;
  pair p;
  pair_create(&p);
  const size_t before = sdr_memory_now();
  int failures = 0;
  for (int k = 0; k < 100; ++k) {
    sdr_memory_fail_after(k);
    const sdr_status status = read_from(&p.to, p.from.b.directory);
    sdr_memory_fail_after(-1);
    assert_int_equal(sdr_memory_now(), before);
    if (status == SDR_OK) break;
    assert_int_equal(status, SDR_RUN_FAILED);
    expect_same(&p.to, &p.untouched);
    ++failures;
  }
  assert_true(failures > 5);
  expect_same(&p.to, &p.from);
  pair_destroy(&p);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_checkpoint_brings_back_every_bit),
      cmocka_unit_test(what_an_observer_says_on_resume_is_passed_on),
      cmocka_unit_test(another_scene_is_refused),
      cmocka_unit_test(another_precision_is_refused),
      cmocka_unit_test(another_number_of_points_is_refused),
      cmocka_unit_test(another_instruction_set_is_refused),
      cmocka_unit_test(an_observer_without_state_there_is_refused),
      cmocka_unit_test(a_missing_file_is_an_io_error),
      cmocka_unit_test(a_file_of_another_kind_is_refused),
      cmocka_unit_test(a_truncated_file_is_refused_wherever_it_ends),
      cmocka_unit_test(a_flipped_bit_in_the_state_is_refused),
      cmocka_unit_test(a_flipped_bit_anywhere_is_refused),
      cmocka_unit_test(a_full_disk_leaves_the_checkpoint_before),
      cmocka_unit_test(a_checkpoint_is_due_nearest_to_each_multiple_and_at_the_end),
      cmocka_unit_test(running_out_of_memory_changes_nothing),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
