/* The program with a body whose points split: resuming, frames, pictures, what is said. */
#include "output/hdf.h"
#include "support/program.h"

static const char scene[] =
    "title: A plate that splits\n"
    "dimension: plane_stress\n"
    "points: {shape: {box: {from: [0, -8 mm], to: [30 mm, 8 mm]}}, spacing: 1 mm, align: cell,\n"
    "  adapt: {energy: 8 kJ/m^3}}\n"
    "material: {model: bond_based, young: 72 GPa, density: 2440 kg/m^3, toughness: 135 J/m^2,\n"
    "  scatter: {young: 5 %, seed: 3}}\n"
    "damage: {law: critical_stretch}\n"
    "cracks: [{segment: {from: [0, 0], to: [15 mm, 0]}}]\n"
    "loads:\n"
    "  - traction: {on: top, value: [0, 12 MPa]}\n"
    "  - traction: {on: bottom, value: [0, -12 MPa]}\n"
    "time: {integrator: leapfrog, end: 14 us}\n"
    "output: {snapshots: 4, fields: [damage, level, displacement], history: {every: 2},\n"
    "  checkpoint: {every: 2 us}, probes: [{name: tip, at: [15 mm, 0], fields: [damage]}],\n"
    "  measures: {worst: {kind: max, field: damage}, split: {kind: value, quantity: refinement}}}\n"
    "figures: {worst: {low: 0}, split: {}}\n";

static void write_scene(void)
{
  FILE *file = fopen("plate.yaml", "w");
  assert_non_null(file);
  fputs(scene, file);
  assert_int_equal(fclose(file), 0);
}

static void a_resumed_run_ends_with_the_same_bits(void **state)
{
  (void)state;
  said s;
  write_scene();
  succeed(&s, "sunder run plate.yaml --quiet --threads 1 -o whole");
  assert_non_null(strstr(s.out, "points split"));
  succeed(&s, "sunder run plate.yaml --quiet --threads 2 -o part --set time.end='10 us'");
  succeed(&s, "sunder run plate.yaml --quiet --threads 1 -o part --resume part/checkpoint.h5");
  succeed(&s, "cmp whole/checkpoint.h5 part/checkpoint.h5");
  succeed(&s, "tail -n 3 whole/history.csv > a && tail -n 3 part/history.csv > b && cmp a b");
  /* in a directory of its own, where the first points are those of the checkpoint */
  succeed(&s, "sunder run plate.yaml --quiet -o part --set time.end='10 us' && "
              "sunder run plate.yaml --quiet -o new --resume part/checkpoint.h5");
  succeed(&s, "cmp whole/checkpoint.h5 new/checkpoint.h5");
  succeed(&s, "sunder plot new -o new.png");
}

/* A run does not split at its end, where nothing follows: the resumed one has to. */
static void a_split_due_at_the_end_is_made_on_resuming(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder run plate.yaml --quiet -o rare --set points.adapt.every='5 us'");
  succeed(&s, "sunder run plate.yaml --quiet -o ended --set points.adapt.every='5 us' "
              "--set time.end='10.4 us' && "
              "sunder run plate.yaml --quiet -o ended --set points.adapt.every='5 us' "
              "--resume ended/checkpoint.h5");
  succeed(&s, "cmp rare/checkpoint.h5 ended/checkpoint.h5");
}

static void frames_after_a_split_hold_their_own_points(void **state)
{
  (void)state;
  static char xdmf[60000];
  sdr_hdf *file = NULL;
  sdr_hdf_shape first, last, damage;
  assert_int_equal(sdr_hdf_open("whole/snapshots.h5", 0, &file), SDR_OK);
  assert_int_equal(sdr_hdf_shape_of(file, "points/position", &first), SDR_OK);
  assert_int_equal(first.rows, 30 * 16);
  assert_false(sdr_hdf_has(file, "frame_0000/points/position"));
  assert_int_equal(sdr_hdf_shape_of(file, "frame_0004/points/position", &last), SDR_OK);
  assert_int_equal(sdr_hdf_shape_of(file, "frame_0004/damage", &damage), SDR_OK);
  assert_true(last.rows > first.rows);
  assert_int_equal(damage.rows, last.rows);
  sdr_hdf_discard(&file);
  read_whole("whole/snapshots.xdmf", xdmf, sizeof xdmf);
  assert_non_null(strstr(xdmf, "snapshots.h5:/points/position"));
  assert_non_null(strstr(xdmf, "snapshots.h5:/frame_0004/points/position"));
}

static void pictures_show_the_points_of_their_frame(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder plot whole --field level -o level.png");
  succeed(&s, "sunder plot whole --field level --time '0 s' -o first.png");
  succeed(&s, "sunder compare whole part");
  assert_null(strstr(s.out, "different points"));
}

static void the_summary_books_what_splits_changed(void **state)
{
  (void)state;
  static char text[60000];
  read_whole("whole/summary.json", text, sizeof text);
  const char *found = strstr(text, "\"refinement\": ");
  assert_non_null(found);
  assert_true(strtod(found + strlen("\"refinement\": "), NULL) != 0.0);
}

static void check_says_what_may_split_and_how_short_steps_become(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder check plate.yaml");
  assert_non_null(strstr(s.out, "points may split    once, to 0.5 mm, above 8000 J/m^3 or a damage "
                                "of 0.02; with all within 3.015 mm, and 3.015 mm ahead of tips"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_resumed_run_ends_with_the_same_bits),
      cmocka_unit_test(a_split_due_at_the_end_is_made_on_resuming),
      cmocka_unit_test(frames_after_a_split_hold_their_own_points),
      cmocka_unit_test(pictures_show_the_points_of_their_frame),
      cmocka_unit_test(the_summary_books_what_splits_changed),
      cmocka_unit_test(check_says_what_may_split_and_how_short_steps_become),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
