/* app: pictures of what history.csv has of probes and supports. */
#include "app/plot.h"
#include "app/plot_columns.h"
#include "base/memory.h"
#include "support/cmocka_all.h"
#include "support/made_run.h"

static const made_run bare = {.dimension = 2, .cells = 20, .law = "none", .without_history = 1};

static void write_file(const char *dir, const char *name, const char *text)
{
  char path[700];
  snprintf(path, sizeof path, "%s/%s", dir, name);
  FILE *file = fopen(path, "w");
  assert_non_null(file);
  fputs(text, file);
  fclose(file);
}

/* A probe, a support that is pulled (from 1 s on, full speed after another second), one that goes
   to a place, one that is held. */
static const char *const used =
    "dimension: plane_stress\n"
    "points: {shape: {box: {from: [0, 0], to: [1 m, 1 m]}}, spacing: 0.1 m}\n"
    "material: {young: 1 GPa, density: 1000 kg/m^3}\n"
    "supports:\n"
    "- {name: pull, on: right, velocity: {x: 2 m/s}, from: 1 s, ramp: 1 s}\n"
    "- {name: push, on: left, displacement: {x: 3 mm * t/(1 s), y: 1 mm * x/(1 m)}}\n"
    "- {name: held, on: top, displacement: {y: 0}}\n"
    "time: {end: 4 s}\n";
static const char *const history =
    "time,kinetic,max_damage,tip.displacement.x,tip.displacement.y,tip.damage,pull.reaction.x,"
    "push.reaction.x,push.reaction.y,held.reaction.y\n"
    "0,0,0,0,0,0.5,0,0,0,0\n1,0,0,0,0,0.5,1,2,3,4\n2,0,0,0,0,0.5,5,6,7,8\n4,0,0,0,0,0.5,9,1,1,1\n";

static void expect_panel(const sdr_column_panel *panel, const char *name, const char *field,
                         int curves, int moved)
{
  assert_string_equal(panel->name, name);
  assert_string_equal(panel->field, field);
  assert_int_equal(panel->count, curves);
  assert_int_equal(panel->moved != NULL, moved);
}

static void columns_become_panels_with_the_way_that_supports_go(void **state)
{
  (void)state;
  char dir[512];
  sdr_rundata *run = NULL;
  sdr_column_panels panels;
  made_run_write(made_run_name("reactions", dir), &bare);
  write_file(dir, "history.csv", history);
  write_file(dir, "used.yaml", used);
  assert_int_equal(sdr_rundata_open(dir, &run), SDR_OK);
  assert_int_equal(sdr_column_panels_find(run, &panels), SDR_OK);
  assert_int_equal(panels.count, 7);
  expect_panel(&panels.panel[0], "tip", "displacement", 2, 0);
  assert_string_equal(panels.panel[0].part[1], "y");
  expect_panel(&panels.panel[1], "tip", "damage", 1, 0);
  assert_string_equal(panels.panel[1].unit, "");
  expect_panel(&panels.panel[2], "pull", "reaction", 1, 0);
  expect_panel(&panels.panel[3], "pull", "reaction", 1, 1);
  expect_panel(&panels.panel[4], "push", "reaction", 2, 0);
  expect_panel(&panels.panel[5], "push", "reaction", 1, 1); /* y differs from place to place */
  expect_panel(&panels.panel[6], "held", "reaction", 1, 0); /* it does not move */
  const double *pull = panels.panel[3].moved, *push = panels.panel[5].moved;
  assert_true(isnan(pull[0]) && fabs(pull[1]) < 1e-15);
  assert_true(fabs(pull[2] - 1.0) < 1e-12 && fabs(pull[3] - 5.0) < 1e-12);
  assert_true(fabs(push[3] - 0.012) < 1e-15);
  assert_true(fabs(panels.panel[5].value[0][2] - 6.0) < 1e-15);
  sdr_column_panels_clear(&panels);
  sdr_rundata_destroy(&run);
  made_run_remove(dir);
}

static sdr_status plot(const char *dir, char **printed)
{
  const sdr_plot_options options = {.directory = dir, .time = (double)NAN};
  size_t length = 0;
  FILE *out = open_memstream(printed, &length);
  const sdr_status status = sdr_plot(&options, out);
  fclose(out);
  return status;
}

static void a_plot_draws_probes_and_reactions(void **state)
{
  (void)state;
  char dir[512], path[600];
  char *printed = NULL;
  made_run_write(made_run_name("reactions", dir), &bare);
  write_file(dir, "history.csv", history);
  write_file(dir, "used.yaml", used);
  assert_int_equal(plot(dir, &printed), SDR_BAD_INPUT); /* no snapshots */
  assert_non_null(strstr(printed, "/reactions.png: reactions and probes over time, and over the "
                                  "prescribed displacement\n"));
  free(printed);
  snprintf(path, sizeof path, "%s/reactions.png", dir);
  assert_int_equal(access(path, R_OK), 0);
  unlink(path);
  write_file(dir, "used.yaml", "points: [\n"); /* not to be read: no ways, no failure */
  assert_int_equal(plot(dir, &printed), SDR_BAD_INPUT);
  assert_non_null(strstr(printed, "/reactions.png: reactions and probes over time\n"));
  free(printed);
  write_file(dir, "history.csv", "time,kinetic\n0,0\n1,0\n");
  unlink(path);
  assert_int_equal(plot(dir, &printed), SDR_BAD_INPUT);
  assert_null(strstr(printed, "reactions.png"));
  assert_int_not_equal(access(path, R_OK), 0);
  free(printed);
  made_run_remove(dir);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(columns_become_panels_with_the_way_that_supports_go),
      cmocka_unit_test(a_plot_draws_probes_and_reactions)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
