/* output: when damage begins. */
#include "output_body.h"

#include "output/onset.h"

static sdr_observer *make(body *b, double threshold)
{
  sdr_observer *onset = NULL;
  body_create(b, 4, 1);
  b->balance.model.max_damage = 1.0;
  assert_int_equal(sdr_onset_create(b->points, threshold, &onset), SDR_OK);
  return onset;
}

static void onset_is_the_first_time_the_grown_damage_passes(void **state)
{
  (void)state;
  body b;
  sdr_observer *onset = make(&b, 0.4);
  b.model.damage[2] = 0.3; /* a pre-crack */
  assert_int_equal(body_show(&b, onset), SDR_OK);
  b.model.damage[2] = 0.69; /* grown by 0.39 */
  b.model.damage[1] = 0.4;  /* not past it */
  body_at(&b, 10);
  assert_int_equal(body_show(&b, onset), SDR_OK);
  assert_true(isnan(sdr_onset_time(onset)));
  b.model.damage[2] = 0.71;
  body_at(&b, 11);
  assert_int_equal(body_show(&b, onset), SDR_OK);
  assert_true(sdr_onset_time(onset) == b.moment.time);
  onset->ops->destroy(onset);
  body_destroy(&b);
}

static void it_looks_every_half_microsecond_until_found(void **state)
{
  (void)state;
  body b;
  sdr_observer *onset = make(&b, 0.4);
  b.moment.step_size = 0.1e-6;
  b.moment.steps = 1000;
  for (int step = 0; step <= 1000; ++step) {
    if (step == 733) b.model.damage[3] = 0.9;
    body_at(&b, step);
    assert_int_equal(body_show(&b, onset), SDR_OK);
  }
  assert_int_equal(b.model.field_calls, 1 + 147);
  assert_true(fabs(sdr_onset_time(onset) - 73.5e-6) < 1e-12);
  onset->ops->destroy(onset);
  body_destroy(&b);
}

static void it_looks_at_every_longer_step_and_at_the_last(void **state)
{
  (void)state;
  body b;
  int wants = 0;
  sdr_observer *onset = make(&b, 0.4);
  body_at(&b, 0);
  assert_int_equal(body_show(&b, onset), SDR_OK);
  body_at(&b, 1);
  assert_int_equal(onset->ops->due(onset, &b.moment, &wants), 1);
  b.moment.step_size = 1e-9;
  body_at(&b, 1);
  assert_int_equal(onset->ops->due(onset, &b.moment, &wants), 0);
  b.moment.last = 1;
  assert_int_equal(onset->ops->due(onset, &b.moment, &wants), 1);
  assert_int_equal(wants, 1);
  onset->ops->destroy(onset);
  body_destroy(&b);
}

static void no_field_is_made_where_no_bond_is_damaged_enough(void **state)
{
  (void)state;
  body b;
  sdr_observer *onset = make(&b, 0.4);
  assert_int_equal(body_show(&b, onset), SDR_OK);
  b.balance.model.max_damage = 0.39;
  body_at(&b, 1);
  assert_int_equal(body_show(&b, onset), SDR_OK);
  assert_int_equal(b.model.field_calls, 1);
  b.balance.model.max_damage = 0.41;
  body_at(&b, 2);
  assert_int_equal(body_show(&b, onset), SDR_OK);
  assert_int_equal(b.model.field_calls, 2);
  onset->ops->destroy(onset);
  body_destroy(&b);
}

static void a_checkpoint_keeps_the_first_damage_and_the_time_found(void **state)
{
  (void)state;
  body b;
  sdr_observer *other = NULL;
  sdr_state_block from[SDR_STATE_BLOCKS], to[SDR_STATE_BLOCKS];
  int count = 0;
  sdr_observer *onset = make(&b, 0.4);
  b.model.damage[0] = 0.5;
  assert_int_equal(body_show(&b, onset), SDR_OK);
  assert_int_equal(sdr_onset_create(b.points, 0.4, &other), SDR_OK);
  onset->ops->state(onset, from, &count);
  other->ops->state(other, to, &count);
  for (int k = 0; k < count; ++k) memcpy(to[k].data, from[k].data, from[k].bytes);
  b.model.damage[0] = 0.85; /* grown by 0.35 */
  body_at(&b, 1);
  assert_int_equal(body_show(&b, other), SDR_OK);
  assert_true(isnan(sdr_onset_time(other)));
  b.model.damage[0] = 0.95;
  body_at(&b, 2);
  assert_int_equal(body_show(&b, other), SDR_OK);
  assert_true(sdr_onset_time(other) == b.moment.time);
  onset->ops->destroy(onset);
  other->ops->destroy(other);
  body_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(onset_is_the_first_time_the_grown_damage_passes),
      cmocka_unit_test(it_looks_every_half_microsecond_until_found),
      cmocka_unit_test(it_looks_at_every_longer_step_and_at_the_last),
      cmocka_unit_test(no_field_is_made_where_no_bond_is_damaged_enough),
      cmocka_unit_test(a_checkpoint_keeps_the_first_damage_and_the_time_found),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
