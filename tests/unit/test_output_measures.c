/* output: measured quantities. */
#include "output_body.h"

#include "output/ledger.h"
#include "output/measures.h"

typedef struct {
  body b;
  sdr_measurement what[4];
  sdr_observer *ledger, *measures;
} run;

/* Points at x = 0, 1, 2 ... m in 1-D with volumes 1, 2, 3 ...; steps of 1 us, 100 of them. */
static void make_body(run *r, int32_t count)
{
  memset(r, 0, sizeof *r);
  body_create(&r->b, count, 1);
  r->b.scene->time.end = 100e-6;
  r->b.scene->output.history_every = 10;
  r->b.scene->output.measure = r->what;
  for (int32_t i = 0; i < count; ++i) r->b.points->volume[i] = i + 1;
}

static sdr_measurement *measure(run *r, sdr_measure_kind kind, const char *field)
{
  sdr_measurement *what = &r->what[r->b.scene->output.measure_count++];
  what->kind = kind;
  what->at = (sdr_length){INFINITY, 0};
  what->origin = (sdr_origin){"s.yaml", 8, 5};
  what->every = 1;
  strcpy(what->name, "m");
  strcpy(what->on.text, "body");
  strcpy(what->field, field);
  return what;
}

static sdr_status start(run *r)
{
  assert_int_equal(sdr_ledger_create(r->b.scene, r->b.points, &r->ledger), SDR_OK);
  return sdr_measures_create(r->b.scene, r->b.points, r->ledger, r->b.moment.steps, &r->measures);
}

/* u = 1 + x + t/us at each step. */
static void go(run *r, int from, int to)
{
  for (int step = from; step <= to; ++step) {
    int wants = 0;
    body_at(&r->b, step);
    for (int32_t i = 0; i < r->b.points->count; ++i) r->b.system->u[0][i] = 1.0 + i + step;
    r->b.balance.kinetic = 10.0 - step;
    const int ledger_due = r->ledger->ops->due(r->ledger, &r->b.moment, &wants);
    const int due = r->measures->ops->due(r->measures, &r->b.moment, &wants);
    r->b.moment.balance = wants ? &r->b.balance : NULL;
    if (ledger_due) assert_int_equal(r->ledger->ops->look(r->ledger, &r->b.moment), SDR_OK);
    if (due) assert_int_equal(r->measures->ops->look(r->measures, &r->b.moment), SDR_OK);
  }
}

static double value(const run *r, int k)
{
  return sdr_measures_value(r->measures, k);
}

static void finish(run *r)
{
  if (r->measures) r->measures->ops->destroy(r->measures);
  r->ledger->ops->destroy(r->ledger);
  for (int k = 0; k < 4; ++k) sdr_expression_destroy(&r->what[k].exact.formula);
  body_destroy(&r->b);
}

static void set_formula(sdr_measurement *what, const char *text)
{
  assert_int_equal(
      sdr_expression_create(text, (sdr_unit){1, 0, 0, 0}, NULL, NULL, &what->exact.formula),
      SDR_OK);
}

/* ---- kinds ----------------------------------------------------------------------------------- */

static void kinds_reduce_a_place_at_the_end(void **state)
{
  (void)state;
  run r;
  make_body(&r, 3);
  measure(&r, SDR_MEASURE_MIN, "displacement");
  measure(&r, SDR_MEASURE_MAX, "displacement");
  measure(&r, SDR_MEASURE_SUM, "displacement");
  measure(&r, SDR_MEASURE_MEAN, "displacement");
  assert_int_equal(start(&r), SDR_OK);
  go(&r, 0, 99);
  assert_true(isnan(value(&r, 0)));
  go(&r, 100, 100);
  assert_true(value(&r, 0) == 101.0);
  assert_true(value(&r, 1) == 103.0);
  assert_true(value(&r, 2) == 306.0);
  assert_true(fabs(value(&r, 3) - (101.0 + 2 * 102.0 + 3 * 103.0) / 6.0) < 1e-12); /* by volume */
  finish(&r);
}

static void points_of_layers_do_not_count(void **state)
{
  (void)state;
  run r;
  make_body(&r, 3);
  uint8_t layer[3] = {0, 0, 1};
  measure(&r, SDR_MEASURE_MAX, "displacement");
  measure(&r, SDR_MEASURE_VALUE, "displacement")->at_point = 1;
  r.what[1].point[0] = 2.0;
  r.b.points->layer = layer;
  assert_int_equal(start(&r), SDR_OK);
  go(&r, 100, 100);
  assert_true(value(&r, 0) == 102.0);
  assert_true(value(&r, 1) == 102.0);
  r.b.points->layer = NULL;
  finish(&r);
}

static void errors_are_against_a_formula_of_place_and_time(void **state)
{
  (void)state;
  run r;
  make_body(&r, 2);
  sdr_measurement *l2 = measure(&r, SDR_MEASURE_L2_ERROR, "displacement");
  l2->at = (sdr_length){3.0, 1};
  set_formula(l2, "x + t*1e6"); /* u is 1 above it */
  sdr_measurement *most = measure(&r, SDR_MEASURE_MAX_ERROR, "displacement");
  most->at = (sdr_length){3.0, 1};
  set_formula(most, "2*(x + t*1e6)");
  sdr_measurement *zero = measure(&r, SDR_MEASURE_L2_ERROR, "displacement");
  set_formula(zero, "0");
  assert_int_equal(start(&r), SDR_OK);
  go(&r, 0, 100);
  /* volumes 1, 2; exact 3, 4 */
  assert_true(fabs(value(&r, 0) - sqrt(3.0 / (9.0 + 2 * 16.0))) < 1e-12);
  assert_true(fabs(value(&r, 1) - 3.0) < 1e-12); /* |5 - 8| at x = 1 */
  assert_true(isnan(value(&r, 2)));
  finish(&r);
}

static void a_series_is_summed_over_n(void **state)
{
  (void)state;
  run r;
  make_body(&r, 2);
  sdr_measurement *what = measure(&r, SDR_MEASURE_MAX_ERROR, "displacement");
  what->at = (sdr_length){0.0, 1};
  what->exact.is_series = 1;
  what->exact.first = -1;
  what->exact.last = 3;
  set_formula(what, "n + x/5"); /* 5 + x */
  assert_int_equal(start(&r), SDR_OK);
  go(&r, 0, 0);
  assert_true(fabs(value(&r, 0) - 4.0) < 1e-12);
  finish(&r);
}

static void a_table_is_linear_between_its_rows(void **state)
{
  (void)state;
  run r;
  double key[] = {0.0, 0.5, 2.0}, values[] = {1.0, 0.0, 6.0};
  make_body(&r, 3);
  sdr_measurement *what = measure(&r, SDR_MEASURE_SUM, "displacement");
  what->kind = SDR_MEASURE_MAX_ERROR;
  what->at = (sdr_length){0.0, 0};
  what->exact = (sdr_exact){.by = 'x', .rows = 3, .key = key, .value = values};
  assert_int_equal(start(&r), SDR_OK);
  go(&r, 0, 1);
  assert_true(fabs(value(&r, 0) - 3.0) < 1e-12); /* 1, 2, 3 against 1, 2, 6 */
  finish(&r);
}

static void components_and_the_length_of_a_vector_are_told_apart(void **state)
{
  (void)state;
  run r;
  memset(&r, 0, sizeof r);
  body_create(&r.b, 2, 2);
  r.b.scene->output.measure = r.what;
  measure(&r, SDR_MEASURE_MAX, "velocity")->component = 1;
  measure(&r, SDR_MEASURE_MAX, "velocity")->component = -1;
  measure(&r, SDR_MEASURE_MIN, "stress")->component = 2; /* the fake's is 100 k + i */
  assert_int_equal(start(&r), SDR_OK);
  r.b.system->v[0][1] = 3.0;
  r.b.system->v[1][1] = -4.0;
  go(&r, 100, 100);
  assert_true(value(&r, 0) == 0.0);
  assert_true(value(&r, 1) == 5.0);
  assert_true(value(&r, 2) == 200.0);
  finish(&r);
}

/* ---- when ------------------------------------------------------------------------------------ */

static void an_instant_is_the_step_nearest_to_its_time(void **state)
{
  (void)state;
  run r;
  make_body(&r, 1);
  const double at[] = {0.0, 6.4e-6, 6.6e-6, 100e-6};
  for (int k = 0; k < 4; ++k) {
    sdr_measurement *what = measure(&r, SDR_MEASURE_VALUE, "displacement");
    what->at_point = 1;
    what->at = (sdr_length){at[k], 0};
  }
  assert_int_equal(start(&r), SDR_OK);
  go(&r, 0, 100);
  assert_true(value(&r, 0) == 1.0);
  assert_true(value(&r, 1) == 7.0);
  assert_true(value(&r, 2) == 8.0);
  assert_true(value(&r, 3) == 101.0);
  finish(&r);
}

static void a_window_holds_its_ends_and_every_so_many_steps(void **state)
{
  (void)state;
  run r;
  make_body(&r, 1);
  for (int k = 0; k < 3; ++k) {
    static const sdr_measure_kind kinds[] = {SDR_MEASURE_MIN, SDR_MEASURE_MAX, SDR_MEASURE_MEAN};
    sdr_measurement *what = measure(&r, kinds[k], "displacement");
    what->over_time = 1;
    what->from = 3e-6;
    what->until = 9e-6;
    what->every = k < 2 ? 1 : 4; /* steps 4 and 8 */
  }
  assert_int_equal(start(&r), SDR_OK);
  go(&r, 0, 100);
  assert_true(value(&r, 0) == 4.0);
  assert_true(value(&r, 1) == 10.0);
  assert_true(value(&r, 2) == 7.0);
  finish(&r);
}

static void nothing_is_looked_at_but_what_is_due(void **state)
{
  (void)state;
  run r;
  make_body(&r, 2);
  measure(&r, SDR_MEASURE_MAX, "damage")->at = (sdr_length){5.0, 1};
  measure(&r, SDR_MEASURE_MIN, "damage")->at = (sdr_length){5.0, 1};
  measure(&r, SDR_MEASURE_MIN, "displacement")->over_time = 1;
  r.what[2].from = -INFINITY;
  r.what[2].until = INFINITY;
  assert_int_equal(start(&r), SDR_OK);
  go(&r, 0, 100);
  assert_int_equal(r.b.model.field_calls, 1);
  finish(&r);
}

static void quantities_of_the_body_are_the_ledgers_between_its_rows_too(void **state)
{
  (void)state;
  run r;
  make_body(&r, 1);
  sdr_measurement *what = measure(&r, SDR_MEASURE_VALUE, "");
  strcpy(what->quantity, "kinetic");
  what->at = (sdr_length){3.0, 1}; /* rows at 0, 10, ... */
  what = measure(&r, SDR_MEASURE_MIN, "");
  strcpy(what->quantity, "imbalance_relative");
  what->over_time = 1;
  what->from = 0.0;
  what->until = 4e-6;
  assert_int_equal(start(&r), SDR_OK);
  go(&r, 0, 12);
  assert_true(value(&r, 0) == 7.0);
  assert_true(value(&r, 1) == -0.4);
  char *text = body_read(&r.b, "history.csv");
  assert_null(strstr(text, "\n3e-06,"));
  free(text);
  finish(&r);
}

/* ---- wrong input ----------------------------------------------------------------------------- */

static void assert_refused(run *r, const char *message)
{
  assert_int_equal(start(r), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), message);
  finish(r);
}

static void what_cannot_be_measured_is_refused_with_its_place(void **state)
{
  (void)state;
  run r;
  double key[] = {1e-6, 50e-6}, values[] = {0.0, 1.0};
  make_body(&r, 2);
  measure(&r, SDR_MEASURE_MAX, "damage")->at = (sdr_length){101.0, 1};
  assert_refused(&r, "s.yaml:8:5: measure m: the run has 100 steps, so none has number 101");
  make_body(&r, 2);
  measure(&r, SDR_MEASURE_VALUE, "damage")->at_point = 1;
  r.what[0].point[0] = -3.5; /* the horizon is 3 m */
  assert_refused(&r, "s.yaml:8:5: measure m: the point lies outside the body: the nearest one is "
                     "3500 mm away, beyond its horizon of 3000 mm");
  make_body(&r, 2);
  measure(&r, SDR_MEASURE_MAX_ERROR, "damage")->exact =
      (sdr_exact){.by = 't', .rows = 2, .key = key, .value = values};
  assert_refused(&r, "s.yaml:8:5: measure m: its table goes from t = 1e-06 to 5e-05 and lacks t = "
                     "0.0001");
}

static void a_formula_that_is_not_finite_is_named(void **state)
{
  (void)state;
  run r;
  make_body(&r, 1);
  sdr_measurement *what = measure(&r, SDR_MEASURE_MAX_ERROR, "displacement");
  what->at = (sdr_length){0.0, 1};
  what->exact.is_series = 1;
  what->exact.last = 2;
  set_formula(what, "1/(n - 1)");
  assert_int_equal(start(&r), SDR_OK);
  body_at(&r.b, 0);
  assert_int_equal(body_show(&r.b, r.measures), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "s.yaml:8:5: measure m: the formula '1/(n - 1)' gives inf "
                      "at n = 1; it must be finite");
  finish(&r);
}

static void no_memory_is_reported_and_nothing_leaks(void **state)
{
  (void)state;
  run r;
  make_body(&r, 3);
  measure(&r, SDR_MEASURE_MAX, "damage");
  measure(&r, SDR_MEASURE_MAX, "velocity");
  assert_int_equal(start(&r), SDR_OK);
  const size_t before = sdr_memory_now();
  int failures = 0;
  for (long successes = 0; failures == successes; ++successes) {
    sdr_observer *other = NULL;
    sdr_memory_fail_after(successes);
    const sdr_status status =
        sdr_measures_create(r.b.scene, r.b.points, r.ledger, r.b.moment.steps, &other);
    sdr_memory_fail_after(-1);
    if (status == SDR_OK) {
      other->ops->destroy(other);
    } else {
      assert_int_equal(status, SDR_RUN_FAILED);
      ++failures;
    }
    assert_int_equal(sdr_memory_now(), before);
  }
  assert_true(failures >= 5);
  finish(&r);
}

/* ---- checkpoints ----------------------------------------------------------------------------- */

static void a_checkpoint_keeps_what_was_measured(void **state)
{
  (void)state;
  run r, other;
  sdr_state_block from[SDR_STATE_BLOCKS], to[SDR_STATE_BLOCKS];
  int count = 0;
  run *both[2] = {&r, &other};
  for (int k = 0; k < 2; ++k) {
    make_body(both[k], 1);
    sdr_measurement *what = measure(both[k], SDR_MEASURE_MEAN, "displacement");
    what->over_time = 1;
    what->from = -INFINITY;
    what->until = 8e-6;
    measure(both[k], SDR_MEASURE_MAX, "displacement")->at = (sdr_length){2.0, 1};
    assert_int_equal(start(both[k]), SDR_OK);
  }
  go(&r, 0, 5);
  r.measures->ops->state(r.measures, from, &count);
  other.measures->ops->state(other.measures, to, &count);
  for (int k = 0; k < count; ++k) memcpy(to[k].data, from[k].data, from[k].bytes);
  go(&r, 6, 20);
  go(&other, 6, 20);
  assert_true(value(&r, 0) == 5.0);
  for (int k = 0; k < 2; ++k) assert_true(value(&r, k) == value(&other, k));
  finish(&r);
  finish(&other);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(kinds_reduce_a_place_at_the_end),
      cmocka_unit_test(points_of_layers_do_not_count),
      cmocka_unit_test(errors_are_against_a_formula_of_place_and_time),
      cmocka_unit_test(a_series_is_summed_over_n),
      cmocka_unit_test(a_table_is_linear_between_its_rows),
      cmocka_unit_test(components_and_the_length_of_a_vector_are_told_apart),
      cmocka_unit_test(an_instant_is_the_step_nearest_to_its_time),
      cmocka_unit_test(a_window_holds_its_ends_and_every_so_many_steps),
      cmocka_unit_test(nothing_is_looked_at_but_what_is_due),
      cmocka_unit_test(quantities_of_the_body_are_the_ledgers_between_its_rows_too),
      cmocka_unit_test(what_cannot_be_measured_is_refused_with_its_place),
      cmocka_unit_test(a_formula_that_is_not_finite_is_named),
      cmocka_unit_test(no_memory_is_reported_and_nothing_leaks),
      cmocka_unit_test(a_checkpoint_keeps_what_was_measured),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
