/* The program as a whole: the files of a run are as the contract says (design sec. 5). */
#include "output/hdf.h"
#include "output/version.h"
#include "support/program.h"

#include <jansson.h>
#include <math.h>

#define SCENES SUNDER_SOURCE_DIR "/tests/scenes/good/"
#define RING                                                                                       \
  "thick_cylinder --variant coarse_4mm --quiet --threads 2 -o ring --set output.snapshots=4"       \
  " --set output.history.every=2 --set output.fields='[displacement, damage, stress, fragment]'"   \
  " --set supports='[{name: grip, on: outer, displacement: {x: 0}, from: 20 us, until: 40 us}]'"   \
  " --set output.probes='[{name: tip, at: [81 mm, 0], fields: [velocity, damage]}, "               \
  "{at: [0, 149 mm]}]'"

static int run_ring(void **state)
{
  said s;
  if (enter_folder(state) != 0) return -1;
  succeed(&s, "sunder run " RING);
  return 0;
}

static json_t *summary_of(const char *directory)
{
  char path[600];
  snprintf(path, sizeof path, "%s/summary.json", directory);
  json_t *summary = json_load_file(path, JSON_REJECT_DUPLICATES, NULL);
  if (!summary) fail_msg("%s is no JSON", path);
  return summary;
}

static double real_at(json_t *summary, const char *group, const char *key)
{
  json_t *value = json_object_get(json_object_get(summary, group), key);
  assert_true(json_is_number(value));
  return json_number_value(value);
}

static void the_summary_has_every_key_of_the_contract_and_no_other(void **state)
{
  (void)state;
  /* s: text, i: whole number, f: number, n: number or null, o: object, a: list */
  static const char *const keys[] = {"s program",
                                     "s version",
                                     "s commit",
                                     "s scene",
                                     "s title",
                                     "s dimension",
                                     "s model",
                                     "s damage_law",
                                     "s integrator",
                                     "s precision",
                                     "i threads",
                                     "i points",
                                     "i bonds",
                                     "i pairs",
                                     "i runs",
                                     "i loose",
                                     "i steps",
                                     "f step",
                                     "f time_end",
                                     "o wall_seconds",
                                     "f wall_seconds.setup",
                                     "f wall_seconds.integrate",
                                     "f wall_seconds.output",
                                     "f wall_seconds.total",
                                     "f ns_per_bond_step",
                                     "i peak_memory_bytes",
                                     "o energy",
                                     "f energy.kinetic",
                                     "f energy.stored",
                                     "f energy.dissipated",
                                     "f energy.external_work",
                                     "f energy.imbalance",
                                     "f energy.imbalance_relative",
                                     "f energy.imbalance_largest",
                                     "o momentum",
                                     "f momentum.linear",
                                     "f momentum.angular",
                                     "o damage",
                                     "n damage.onset_time",
                                     "f damage.max",
                                     "f damage.mean",
                                     "o fragments",
                                     "i fragments.count",
                                     "i fragments.largest",
                                     "o solver",
                                     "a skipped",
                                     "o figures",
                                     "o figures.imbalance",
                                     "f figures.imbalance.value",
                                     "f figures.imbalance.low",
                                     "f figures.imbalance.high",
                                     "n figures.imbalance.paper"};
  json_t *summary = summary_of("ring");
  size_t top = 0;
  for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k) {
    char path[100];
    json_t *value = summary;
    snprintf(path, sizeof path, "%s", keys[k] + 2);
    top += strchr(path, '.') == NULL;
    for (char *part = strtok(path, "."); part; part = strtok(NULL, "."))
      value = json_object_get(value, part);
    const char kind = keys[k][0];
    const int fits = kind == 's'   ? json_is_string(value)
                     : kind == 'i' ? json_is_integer(value)
                     : kind == 'f' ? json_is_real(value)
                     : kind == 'n' ? json_is_real(value) || json_is_null(value)
                     : kind == 'o' ? json_is_object(value)
                                   : json_is_array(value);
    if (!fits) fail_msg("%s is missing or of another kind", keys[k]);
  }
  assert_int_equal(json_object_size(summary), top);
  json_decref(summary);
}

static void the_summary_tells_what_ran(void **state)
{
  (void)state;
  static const char *const texts[][2] = {
      {"program", "sunder"},         {"version", SUNDER_VERSION},
      {"scene", "thick_cylinder"},   {"title", "Thick cylinder, 4 mm"},
      {"dimension", "plane_stress"}, {"model", "bond_based"},
      {"damage_law", "variational"}, {"integrator", "leapfrog"},
      {"precision", "double"}};
#ifdef _OPENMP
  enum { THREADS = 2 };
#else
  enum { THREADS = 1 }; /* a build without threads says what it used */
#endif
  static const struct {
    const char *key;
    int value;
  } numbers[] = {
      {"threads", THREADS}, {"points", 3068}, {"bonds", 79112}, {"pairs", 39556}, {"steps", 125}};
  json_t *s = summary_of("ring");
  for (size_t k = 0; k < sizeof texts / sizeof *texts; ++k)
    assert_string_equal(json_string_value(json_object_get(s, texts[k][0])), texts[k][1]);
  for (size_t k = 0; k < sizeof numbers / sizeof *numbers; ++k)
    assert_int_equal(json_integer_value(json_object_get(s, numbers[k].key)), numbers[k].value);
  assert_true(fabs(json_real_value(json_object_get(s, "step")) - 0.8e-6) < 1e-21);
  assert_true(fabs(json_real_value(json_object_get(s, "time_end")) - 1e-4) < 1e-15);
  const double parts = real_at(s, "wall_seconds", "setup") + real_at(s, "wall_seconds", "output") +
                       real_at(s, "wall_seconds", "integrate");
  assert_true(fabs(parts - real_at(s, "wall_seconds", "total")) < 1e-9);
  const double ns = real_at(s, "wall_seconds", "integrate") * 1e9 / (79112.0 * 125.0);
  assert_true(fabs(json_real_value(json_object_get(s, "ns_per_bond_step")) / ns - 1) < 1e-12);
  json_decref(s);
}

static const char header[] =
    "time,kinetic,stored,dissipated,viscous,contact,refinement,external_work,imbalance,max_damage,"
    "broken_bonds,tip.velocity.x,tip.velocity.y,tip.damage,probe1.displacement.x,"
    "probe1.displacement.y,grip.reaction.x";
enum { COLUMNS = 17, STORED = 2, DISSIPATED = 3, WORK = 7, IMBALANCE = 8, REACTION = 16 };

static void the_history_has_the_columns_of_the_contract_and_ends_as_the_summary_says(void **state)
{
  (void)state;
  static char text[200000];
  double row[COLUMNS] = {0}, before = -1, start = 0;
  int rows = 0, held = 0;
  read_whole("ring/history.csv", text, sizeof text);
  char *line = strtok(text, "\n");
  assert_string_equal(line, header);
  while ((line = strtok(NULL, "\n"))) {
    char *at = line;
    for (int c = 0; c < COLUMNS; ++c) {
      char *end;
      row[c] = strtod(at, &end);
      assert_true(end > at && *end == (c + 1 < COLUMNS ? ',' : '\0') && isfinite(row[c]));
      at = end + 1;
    }
    if (rows++ == 0) start = row[1] + row[STORED] + row[DISSIPATED];
    assert_true(row[0] > before);
    before = row[0];
    /* the row's own sum: E - E(0) - W */
    const double energy = row[1] + row[STORED] + row[DISSIPATED];
    assert_true(fabs(energy - start - row[WORK] - row[IMBALANCE]) <= 1e-9 * (energy + 1));
    /* held from 20 to 40 us; the force that holds a point acts from the step before */
    if (row[0] < 19.1e-6 || row[0] > 40.1e-6)
      assert_true(row[REACTION] == 0);
    else
      held += row[REACTION] != 0;
  }
  assert_int_equal(rows, 64); /* steps 0, 2, ... 124, and the last, 125 */
  assert_true(held > 5);
  json_t *s = summary_of("ring");
  assert_true(row[0] == json_real_value(json_object_get(s, "time_end")));
  assert_true(row[1] == real_at(s, "energy", "kinetic"));
  assert_true(row[STORED] == real_at(s, "energy", "stored"));
  assert_true(row[DISSIPATED] == real_at(s, "energy", "dissipated"));
  assert_true(row[WORK] == real_at(s, "energy", "external_work"));
  assert_true(row[IMBALANCE] == real_at(s, "energy", "imbalance"));
  json_decref(s);
}

static void snapshots_have_the_points_and_a_group_for_each_frame(void **state)
{
  (void)state;
  static const struct {
    const char *name;
    size_t columns;
  } members[] = {{"points/index", 1},      {"points/position", 3},         {"points/volume", 1},
                 {"points/horizon", 1},    {"frame_0000/displacement", 2}, {"frame_0004/damage", 1},
                 {"frame_0004/stress", 3}, {"frame_0004/fragment", 1}};
  sdr_hdf *file = NULL;
  sdr_hdf_shape shape;
  double time;
  assert_int_equal(sdr_hdf_open("ring/snapshots.h5", 0, &file), SDR_OK);
  assert_int_equal(sdr_hdf_count(file, "/"), 6);
  assert_int_equal(sdr_hdf_count(file, "frame_0003"), 5);
  for (size_t k = 0; k < sizeof members / sizeof *members; ++k) {
    assert_int_equal(sdr_hdf_shape_of(file, members[k].name, &shape), SDR_OK);
    assert_int_equal(shape.rows, 3068);
    assert_int_equal(shape.columns, members[k].columns);
  }
  const sdr_hdf_shape single = {SDR_HDF_DOUBLE, 0, 1, 1};
  assert_int_equal(sdr_hdf_read(file, "frame_0000/time", single, &time), SDR_OK);
  assert_true(time == 0);
  assert_int_equal(sdr_hdf_read(file, "frame_0004/time", single, &time), SDR_OK);
  assert_true(fabs(time - 1e-4) < 1e-15);

  /* the body's area: volumes are spacing^2 times 1 m */
  double volume[3068], sum = 0;
  const sdr_hdf_shape list = {SDR_HDF_DOUBLE, 1, 3068, 1};
  assert_int_equal(sdr_hdf_read(file, "points/volume", list, volume), SDR_OK);
  for (int i = 0; i < 3068; ++i) sum += volume[i];
  assert_true(fabs(sum - 3068 * 16e-6) < 1e-12);
  sdr_hdf_discard(&file);
}

/* Is the text well-formed as far as its elements go? The names of those that are open are kept. */
static void assert_well_formed(const char *text)
{
  char open[20][40];
  int depth = 0, elements = 0;
  for (const char *at = strchr(text, '<'); at; at = strchr(at + 1, '<')) {
    const char *end = strchr(at, '>');
    assert_non_null(end);
    if (at[1] == '?' || at[1] == '!') continue;
    const char *name = at[1] == '/' ? at + 2 : at + 1;
    const int length = (int)strcspn(name, " />\n");
    if (at[1] == '/') {
      assert_true(depth > 0);
      --depth;
      assert_int_equal(strlen(open[depth]), length);
      assert_int_equal(strncmp(open[depth], name, (size_t)length), 0);
    } else if (end[-1] != '/') {
      assert_true(depth < 20);
      snprintf(open[depth++], sizeof open[0], "%.*s", length, name);
    }
    int quotes = 0;
    for (const char *c = at; c < end; ++c) quotes += *c == '"';
    assert_int_equal(quotes % 2, 0);
    ++elements;
  }
  assert_int_equal(depth, 0);
  assert_true(elements > 10);
}

/* Every array that the XDMF names is in the HDF5 file, with the size that it says. */
static void the_xdmf_is_well_formed_and_names_what_the_snapshots_hold(void **state)
{
  (void)state;
  static char text[100000];
  sdr_hdf *file = NULL;
  int arrays = 0, frames = 0;
  read_whole("ring/snapshots.xdmf", text, sizeof text);
  assert_well_formed(text);
  assert_non_null(strstr(text, "CollectionType=\"Temporal\""));
  for (const char *at = text; (at = strstr(at, "<Time Value=\"")); ++at) ++frames;
  assert_int_equal(frames, 5);
  assert_int_equal(sdr_hdf_open("ring/snapshots.h5", 0, &file), SDR_OK);
  for (char *at = text; (at = strstr(at, "Dimensions=\"")); ++arrays) {
    unsigned long rows = 0, columns = 1;
    char name[100];
    sdr_hdf_shape shape;
    assert_true(sscanf(at, "Dimensions=\"%lu %lu", &rows, &columns) >= 1);
    at = strstr(at, "snapshots.h5:/");
    assert_non_null(at);
    assert_int_equal(sscanf(at, "snapshots.h5:/%99[^<]", name), 1);
    if (sdr_hdf_shape_of(file, name, &shape) != SDR_OK) fail_msg("%s", sdr_error_message());
    assert_int_equal(shape.rows, rows);
    assert_int_equal(shape.columns, columns);
  }
  assert_int_equal(arrays, 5 * (2 + 4)); /* index, positions, four fields */
  sdr_hdf_discard(&file);
}

/* The hash is in the checkpoint, so that the same file means the same scene and the same state. */
static void used_yaml_runs_again_to_the_same_bits(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder run " RING " -o first --set output.checkpoint.every='30 us' && "
              "cp first/used.yaml copy.yaml && "
              "sunder run copy.yaml --quiet --threads 1 -o second && "
              "cmp first/history.csv second/history.csv && "
              "cmp first/checkpoint.h5 second/checkpoint.h5 && "
              "cmp first/snapshots.h5 second/snapshots.h5 && "
              "cmp first/used.yaml second/used.yaml");
}

static void a_run_may_be_repeated_from_its_own_directory(void **state)
{
  (void)state;
  said s;
  succeed(&s,
          "sunder run " RING " -o own --set time.end='8 us' && cp own/history.csv before.csv && "
          "sunder run own/used.yaml --quiet -o own && cmp own/history.csv before.csv");
}

static void a_finished_directory_is_replaced_and_what_is_not_ours_stays(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder run " RING " -o old --set output.checkpoint.every='30 us' && "
              "echo mine > old/notes.txt && touch old/damage.png && "
              "sunder run '" SCENES "bar.yaml' --quiet -o old --set points.spacing='1 cm' "
              "--set output.snapshots=0");
  assert_true(exists("old/summary.json"));
  assert_true(exists("old/notes.txt"));
  assert_false(exists("old/snapshots.h5"));
  assert_false(exists("old/snapshots.xdmf"));
  assert_false(exists("old/checkpoint.h5"));
  assert_false(exists("old/damage.png"));
  json_t *summary = summary_of("old");
  assert_string_equal(json_string_value(json_object_get(summary, "scene")), "bar");
  assert_true(json_is_null(json_object_get(json_object_get(summary, "damage"), "onset_time")));
  assert_true(json_is_null(json_object_get(json_object_get(summary, "fragments"), "count")));
  json_decref(summary);
}

/* One, two and three dimensions, each from scene to summary. */
static void good_scenes_pass_check_and_run(void **state)
{
  (void)state;
  static const char *const scenes[][2] = {
      {"bar", "--set points.spacing='1 cm'"},
      {"block", "--set points.spacing='2 mm' --set time.end='0.2 us' --set time.step='0.05 us' "
                "--set cracks='[]'"},
      {"notch", "--set time.end='2 us' --set figures='{}'"},
      {"cylinder", "--variant coarse"}};
  for (size_t k = 0; k < sizeof scenes / sizeof *scenes; ++k) {
    char command[500];
    said s;
    snprintf(command, sizeof command, "sunder check '" SCENES "%s.yaml' %s", scenes[k][0],
             scenes[k][1]);
    succeed(&s, command);
    snprintf(command, sizeof command, "sunder run '" SCENES "%s.yaml' --quiet -o good/%s %s",
             scenes[k][0], scenes[k][0], scenes[k][1]);
    succeed(&s, command);
    snprintf(command, sizeof command, "good/%s", scenes[k][0]);
    json_t *summary = summary_of(command);
    assert_true(fabs(real_at(summary, "energy", "imbalance_relative")) < 0.05);
    assert_true(real_at(summary, "momentum", "linear") < 1e-12);
    assert_true(real_at(summary, "momentum", "angular") < 1e-12);
    json_decref(summary);
  }
}

static void figures_are_shown_with_their_ranges(void **state)
{
  (void)state;
  said s;
  succeed(&s, "sunder run thick_cylinder --variant coarse_4mm --quiet -o shown "
              "--set time.end='8 us' --set figures='{imbalance: {low: -1, high: 1}, "
              "fragments: {low: 2}, damage_max: {high: 1}, onset_time: {paper: 43.6 us}, "
              "damage_mean: {high: -1}}'");
  assert_non_null(strstr(s.out, "figures (SI)\n"));
  assert_non_null(strstr(s.out, ", accepted -1 to 1\n"));
  assert_non_null(strstr(s.out, "  fragments         1, accepted from 2: OUTSIDE\n"));
  assert_non_null(strstr(s.out, ", accepted up to 1\n"));
  assert_non_null(strstr(s.out, "  onset_time        none, the paper's 4.36e-05\n"));
  assert_non_null(strstr(s.out, ", accepted up to -1: OUTSIDE\n"));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_summary_has_every_key_of_the_contract_and_no_other),
      cmocka_unit_test(the_summary_tells_what_ran),
      cmocka_unit_test(the_history_has_the_columns_of_the_contract_and_ends_as_the_summary_says),
      cmocka_unit_test(snapshots_have_the_points_and_a_group_for_each_frame),
      cmocka_unit_test(the_xdmf_is_well_formed_and_names_what_the_snapshots_hold),
      cmocka_unit_test(used_yaml_runs_again_to_the_same_bits),
      cmocka_unit_test(a_run_may_be_repeated_from_its_own_directory),
      cmocka_unit_test(a_finished_directory_is_replaced_and_what_is_not_ours_stays),
      cmocka_unit_test(good_scenes_pass_check_and_run),
      cmocka_unit_test(figures_are_shown_with_their_ranges),
  };
  return cmocka_run_group_tests(tests, run_ring, leave_folder);
}
