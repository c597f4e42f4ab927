/* output: the ledger and history.csv. */
#include "output_body.h"

#include "output/ledger.h"

static const char header[] = "time,kinetic,stored,dissipated,viscous,contact,refinement,"
                             "external_work,imbalance,max_damage,broken_bonds";

static sdr_observer *make(body *b, int every)
{
  sdr_observer *ledger = NULL;
  b->scene->output.history_every = every;
  assert_int_equal(sdr_ledger_create(b->scene, b->points, &ledger), SDR_OK);
  return ledger;
}

static void run(body *b, sdr_observer *ledger, int from, int to)
{
  for (int step = from; step <= to; ++step) {
    body_at(b, step);
    b->balance.kinetic = step;
    b->system->external_work = step;
    assert_int_equal(body_show(b, ledger), SDR_OK);
  }
}

static int line_count(const char *text)
{
  int lines = 0;
  for (; *text; ++text) lines += *text == '\n';
  return lines;
}

/* ---- columns --------------------------------------------------------------------------------- */

static void the_header_and_a_row_are_those_of_the_contract(void **state)
{
  (void)state;
  body b;
  body_create(&b, 3, 2);
  sdr_observer *ledger = make(&b, 1);
  b.balance.kinetic = 0.1;
  b.balance.model = (sdr_energies){2.0, 3.0, 0.25, 7};
  assert_int_equal(body_show(&b, ledger), SDR_OK);
  char *text = body_read(&b, "history.csv");
  char wanted[512];
  snprintf(wanted, sizeof wanted, "%s\n0,0.10000000000000001,2,3,0,0,0,0,0,0.25,7\n", header);
  assert_string_equal(text, wanted);
  free(text);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

static void probe(body *b, sdr_probe *p, const char *name, double x)
{
  *p = (sdr_probe){.at = {x, 0.0, 0.0}, .origin = {"s.yaml", 7, 3}};
  snprintf(p->name, sizeof p->name, "%s", name);
  b->scene->output.probe = p;
  b->scene->output.probe_count = 1;
}

static void probes_add_a_column_for_each_component_at_the_nearest_point(void **state)
{
  (void)state;
  body b;
  sdr_probe tip;
  body_create(&b, 3, 2);
  probe(&b, &tip, "tip", 1.8);
  tip.field_count = 3;
  strcpy(tip.field[0], "displacement");
  strcpy(tip.field[1], "damage");
  strcpy(tip.field[2], "stress");
  b.system->u[0][2] = 0.5;
  b.system->u[1][2] = -0.25;
  b.model.damage[2] = 0.75;
  sdr_observer *ledger = make(&b, 1);
  assert_int_equal(body_show(&b, ledger), SDR_OK);
  char *text = body_read(&b, "history.csv");
  char wanted[512];
  snprintf(wanted, sizeof wanted,
           "%s,tip.displacement.x,tip.displacement.y,tip.damage,tip.stress.xx,tip.stress.yy,"
           "tip.stress.xy\n0,0,0,0,0,0,0,0,0,0,0,0.5,-0.25,0.75,2,102,202\n",
           header);
  assert_string_equal(text, wanted);
  assert_int_equal(b.model.field_calls, 2); /* stress once for its three columns */
  free(text);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

static void a_bar_names_its_one_component(void **state)
{
  (void)state;
  body b;
  sdr_probe end;
  body_create(&b, 2, 1);
  probe(&b, &end, "end", 3.0);
  end.field_count = 2;
  strcpy(end.field[0], "velocity");
  strcpy(end.field[1], "strain");
  sdr_observer *ledger = make(&b, 1);
  assert_int_equal(body_show(&b, ledger), SDR_OK);
  char *text = body_read(&b, "history.csv");
  assert_non_null(strstr(text, "broken_bonds,end.velocity.x,end.strain.xx\n"));
  free(text);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

static void a_field_that_no_probe_can_show_is_refused_with_its_place(void **state)
{
  (void)state;
  body b;
  sdr_probe end;
  sdr_observer *ledger = NULL;
  body_create(&b, 2, 1);
  probe(&b, &end, "end", 3.0);
  end.field_count = 1;
  strcpy(end.field[0], "fragment");
  const size_t before = sdr_memory_now();
  assert_int_equal(sdr_ledger_create(b.scene, b.points, &ledger), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "s.yaml:7:3: probe end cannot show 'fragment'; name another field");
  assert_null(ledger);
  assert_int_equal(sdr_memory_now(), before);
  body_destroy(&b);
}

static void supports_add_the_sum_of_their_own_reactions(void **state)
{
  (void)state;
  body b;
  sdr_support_scene supports[2];
  sdr_expression *zero = NULL;
  const sdr_unit metre = {1, 0, 0, 0};
  assert_int_equal(sdr_expression_create("0", metre, NULL, NULL, &zero), SDR_OK);
  body_create(&b, 3, 2);
  for (int k = 0; k < 2; ++k) { /* the whole body, one after the other */
    supports[k] = (sdr_support_scene){.schedule = {-HUGE_VAL, HUGE_VAL, 0.0}, .depth = {1.0, 1}};
    supports[k].kind[0] = SDR_PRESCRIBED_DISPLACEMENT;
    supports[k].value[0] = zero;
  }
  strcpy(supports[0].name, "grip");
  strcpy(supports[1].name, "later");
  supports[0].schedule.until = 1e-6;
  supports[1].schedule.from = 2e-6;
  supports[0].kind[1] = SDR_PRESCRIBED_VELOCITY;
  supports[0].value[1] = zero;
  b.scene->support = supports;
  b.scene->support_count = 2;
  body_wire(&b);
  const sdr_prescribed *list = sdr_supports_list(b.supports);
  assert_int_equal(sdr_supports_count(b.supports), 9);
  for (int k = 0; k < 9; ++k)
    b.system->reaction[k] = list[k].support == 1 ? 0.25 : list[k].component == 0 ? 1.0 : -2.0;
  sdr_observer *ledger = make(&b, 1);
  assert_int_equal(body_show(&b, ledger), SDR_OK);
  char *text = body_read(&b, "history.csv");
  char wanted[512];
  snprintf(wanted, sizeof wanted,
           "%s,grip.reaction.x,grip.reaction.y,later.reaction.x\n0,0,0,0,0,0,0,0,0,0,0,3,-6,0.75\n",
           header);
  assert_string_equal(text, wanted);
  free(text);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
  sdr_expression_destroy(&zero);
}

/* ---- books ----------------------------------------------------------------------------------- */

static void the_imbalance_is_what_work_does_not_explain(void **state)
{
  (void)state;
  body b;
  body_create(&b, 2, 2);
  sdr_observer *ledger = make(&b, 1);
  b.balance.model.stored = 5.0;
  assert_int_equal(body_show(&b, ledger), SDR_OK);
  const double energies[3] = {105.0, 55.0, 45.0}; /* stored */
  const double work[3] = {98.0, 50.0, 40.5};
  const double wanted[3] = {2.0, 0.0, -0.5};
  for (int k = 0; k < 3; ++k) {
    body_at(&b, k + 1);
    b.balance.model.stored = energies[k];
    b.system->viscous = k; /* damping took some of the work */
    b.system->external_work = work[k] + k;
    assert_int_equal(body_show(&b, ledger), SDR_OK);
    const sdr_books books = sdr_ledger_books(ledger);
    assert_true(books.viscous == k);
    assert_true(fabs(books.imbalance - wanted[k]) < 1e-12);
    assert_true(fabs(books.imbalance_relative - wanted[k] / 105.0) < 1e-15);
    assert_true(fabs(books.imbalance_largest - 2.0 / 105.0) < 1e-15);
  }
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

static void momentum_residuals_are_over_the_largest_scale(void **state)
{
  (void)state;
  body b;
  body_create(&b, 2, 2);
  sdr_observer *ledger = make(&b, 1);
  b.balance.momentum[0] = 10.0;
  b.balance.momentum_scale = 40.0;
  assert_int_equal(body_show(&b, ledger), SDR_OK);
  assert_true(sdr_ledger_books(ledger).linear_residual == 0.0);
  assert_true(sdr_ledger_books(ledger).angular_residual == 0.0);
  body_at(&b, 1);
  b.balance.momentum[0] = 16.0;
  b.balance.momentum[1] = 4.0;
  b.balance.momentum_scale = 20.0;
  b.balance.angular[2] = -3.0;
  b.balance.angular_scale = 6.0;
  b.system->impulse[0] = 3.0; /* 3 and 4 are left */
  b.system->angular_impulse[2] = -1.5;
  assert_int_equal(body_show(&b, ledger), SDR_OK);
  assert_true(fabs(sdr_ledger_books(ledger).linear_residual - 5.0 / 40.0) < 1e-15);
  assert_true(fabs(sdr_ledger_books(ledger).angular_residual - 1.5 / 6.0) < 1e-15);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

/* ---- rows ------------------------------------------------------------------------------------ */

static void rows_come_every_so_many_steps_and_at_the_end(void **state)
{
  (void)state;
  body b;
  body_create(&b, 2, 1);
  b.moment.steps = 25;
  sdr_observer *ledger = make(&b, 10);
  run(&b, ledger, 0, 25);
  assert_int_equal(ledger->ops->finish(ledger, &b.moment), SDR_OK);
  char *text = body_read(&b, "history.csv");
  assert_int_equal(line_count(text), 1 + 4);
  assert_non_null(strstr(text, ",25,0,0,0,0,0,25,0,0,0\n"));
  free(text);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

static void without_a_number_a_run_has_two_hundred_rows(void **state)
{
  (void)state;
  body b;
  body_create(&b, 2, 1);
  b.moment.steps = 2000;
  sdr_observer *ledger = make(&b, 0);
  run(&b, ledger, 0, 2000);
  char *text = body_read(&b, "history.csv");
  assert_int_equal(line_count(text), 1 + 201);
  free(text);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

static void finishing_writes_the_row_that_nobody_asked_for(void **state)
{
  (void)state;
  body b;
  body_create(&b, 2, 1);
  sdr_observer *ledger = make(&b, 50);
  run(&b, ledger, 0, 60);
  b.moment.balance = NULL; /* then the ledger makes its own */
  b.model.energies.stored = 3.0;
  assert_int_equal(ledger->ops->finish(ledger, &b.moment), SDR_OK);
  assert_true(sdr_ledger_books(ledger).stored == 3.0);
  char *text = body_read(&b, "history.csv");
  assert_int_equal(line_count(text), 1 + 3);
  free(text);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

static void rows_are_readable_while_the_run_goes_on(void **state)
{
  (void)state;
  body b;
  body_create(&b, 2, 1);
  sdr_observer *ledger = make(&b, 1);
  run(&b, ledger, 0, 4);
  char *text = body_read(&b, "history.csv");
  assert_int_equal(line_count(text), 1 + 5);
  free(text);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

/* ---- resume ---------------------------------------------------------------------------------- */

static void copy_state(sdr_observer *from, sdr_observer *to)
{
  sdr_state_block a[SDR_STATE_BLOCKS], c[SDR_STATE_BLOCKS];
  int count = 0;
  from->ops->state(from, a, &count);
  to->ops->state(to, c, &count);
  for (int k = 0; k < count; ++k) memcpy(c[k].data, a[k].data, a[k].bytes);
}

static void a_resumed_history_is_that_of_a_run_never_stopped(void **state)
{
  (void)state;
  body b;
  body_create(&b, 2, 1);
  sdr_observer *ledger = make(&b, 5), *next = NULL;
  run(&b, ledger, 0, 30);
  assert_int_equal(sdr_ledger_create(b.scene, b.points, &next), SDR_OK);
  copy_state(ledger, next);
  run(&b, ledger, 31, 100);
  ledger->ops->destroy(ledger);
  char *whole = body_read(&b, "history.csv");

  body_at(&b, 30); /* the checkpoint's step, whose row is there */
  b.balance.kinetic = 30.0;
  assert_int_equal(next->ops->resumed(next, &b.moment), SDR_OK);
  char *cut = body_read(&b, "history.csv");
  assert_int_equal(line_count(cut), 1 + 7);
  assert_memory_equal(cut, whole, strlen(cut));
  assert_false(body_has(&b, "history.csv.part"));
  run(&b, next, 31, 100);
  char *again = body_read(&b, "history.csv");
  assert_string_equal(again, whole);
  free(cut);
  free(again);
  free(whole);
  next->ops->destroy(next);
  body_destroy(&b);
}

static void a_missing_row_is_made_up_and_a_torn_one_cut(void **state)
{
  (void)state;
  body b;
  char text[512];
  body_create(&b, 2, 1);
  sdr_observer *ledger = make(&b, 5);
  snprintf(text, sizeof text, "%s\n0,0,0,0,0,0,0,0,0,0,0\n1.0e-05,1", header);
  body_write(&b, "history.csv", text);
  body_at(&b, 10);
  b.moment.balance = &b.balance;
  assert_int_equal(ledger->ops->resumed(ledger, &b.moment), SDR_OK);
  char *now = body_read(&b, "history.csv");
  assert_int_equal(line_count(now), 3);
  assert_non_null(strstr(now, "0,0\n9.9999999999999991e-06,"));
  free(now);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

static void a_resumed_run_elsewhere_begins_a_new_history(void **state)
{
  (void)state;
  body b;
  body_create(&b, 2, 1);
  sdr_observer *ledger = make(&b, 5);
  body_at(&b, 12);
  assert_int_equal(ledger->ops->resumed(ledger, &b.moment), SDR_OK);
  run(&b, ledger, 13, 20);
  char *now = body_read(&b, "history.csv");
  assert_int_equal(line_count(now), 1 + 2);
  free(now);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

static void a_history_with_other_columns_is_not_continued(void **state)
{
  (void)state;
  body b;
  char wanted[256], text[512];
  body_create(&b, 2, 1);
  sdr_observer *ledger = make(&b, 5);
  snprintf(text, sizeof text, "%s,tip.damage\n0,0,0,0,0,0,0,0,0,0,0,0\n", header);
  body_write(&b, "history.csv", text);
  assert_int_equal(ledger->ops->resumed(ledger, &b.moment), SDR_BAD_INPUT);
  snprintf(wanted, sizeof wanted,
           "%s/history.csv has other columns than this run writes, so it cannot be continued; "
           "give the same probes and supports, or another directory with -o",
           b.directory);
  assert_string_equal(sdr_error_message(), wanted);
  char *now = body_read(&b, "history.csv");
  assert_string_equal(now, text);
  assert_false(body_has(&b, "history.csv.part"));
  free(now);
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

/* ---- full disk ------------------------------------------------------------------------------- */

static int fill_history(void *context)
{
  body *b = context;
  char wanted[256];
  sdr_observer *ledger = make(b, 1);
  snprintf(wanted, sizeof wanted, "cannot write %s/history.csv: File too large", b->directory);
  for (int step = 0; step <= 100; ++step) {
    body_at(b, step);
    const sdr_status status = body_show(b, ledger);
    if (status == SDR_OK) continue;
    ledger->ops->destroy(ledger);
    return status == SDR_IO_ERROR && strcmp(sdr_error_message(), wanted) == 0 ? 0 : 2;
  }
  return 1;
}

static void a_full_disk_stops_the_run_and_leaves_whole_rows_only(void **state)
{
  (void)state;
  body b;
  body_create(&b, 2, 1);
  assert_int_equal(body_with_full_disk(500, fill_history, &b), 0);
  char *text = body_read(&b, "history.csv");
  assert_true(line_count(text) > 3);
  assert_true(text[strlen(text) - 1] == '\n');
  free(text);
  assert_int_equal(body_with_full_disk(20, fill_history, &b), 0);
  assert_false(body_has(&b, "history.csv")); /* not even a header fits */
  body_destroy(&b);
}

static void a_missing_directory_is_an_io_error(void **state)
{
  (void)state;
  body b;
  body_create(&b, 2, 1);
  sdr_observer *ledger = make(&b, 1);
  b.moment.directory = "no/such";
  assert_int_equal(body_show(&b, ledger), SDR_IO_ERROR);
  assert_string_equal(sdr_error_message(),
                      "cannot write no/such/history.csv: No such file or directory");
  ledger->ops->destroy(ledger);
  body_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_header_and_a_row_are_those_of_the_contract),
      cmocka_unit_test(probes_add_a_column_for_each_component_at_the_nearest_point),
      cmocka_unit_test(a_bar_names_its_one_component),
      cmocka_unit_test(a_field_that_no_probe_can_show_is_refused_with_its_place),
      cmocka_unit_test(supports_add_the_sum_of_their_own_reactions),
      cmocka_unit_test(the_imbalance_is_what_work_does_not_explain),
      cmocka_unit_test(momentum_residuals_are_over_the_largest_scale),
      cmocka_unit_test(rows_come_every_so_many_steps_and_at_the_end),
      cmocka_unit_test(without_a_number_a_run_has_two_hundred_rows),
      cmocka_unit_test(finishing_writes_the_row_that_nobody_asked_for),
      cmocka_unit_test(rows_are_readable_while_the_run_goes_on),
      cmocka_unit_test(a_resumed_history_is_that_of_a_run_never_stopped),
      cmocka_unit_test(a_missing_row_is_made_up_and_a_torn_one_cut),
      cmocka_unit_test(a_resumed_run_elsewhere_begins_a_new_history),
      cmocka_unit_test(a_history_with_other_columns_is_not_continued),
      cmocka_unit_test(a_full_disk_stops_the_run_and_leaves_whole_rows_only),
      cmocka_unit_test(a_missing_directory_is_an_io_error),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
