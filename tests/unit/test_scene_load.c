/* scene: good scenes become the right numbers; variants, overrides, defaults, hash, failures. */
#include "base/memory.h"
#include "scene/scene.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define GOOD SUNDER_SOURCE_DIR "/tests/scenes/good/"

#define assert_near(found, expected)                                                               \
  assert_true(fabs((found) - (expected)) <= 4e-16 * fabs(expected))

static sdr_scene *load_with(const char *path, const char *variant, int count,
                            const char *const *sets)
{
  sdr_scene *scene = NULL;
  if (sdr_scene_load(path, variant, count, sets, &scene) != SDR_OK) {
    fail_msg("%s", sdr_error_message());
  }
  return scene;
}

static sdr_scene *load(const char *path)
{
  return load_with(path, NULL, 0, NULL);
}

/* Load a scene given as text. */
static sdr_status load_text(const char *text, const char *variant, int count,
                            const char *const *sets, sdr_scene **scene)
{
  char path[] = "/tmp/sunder_scene_XXXXXX";
  const int file = mkstemp(path);
  assert_true(file >= 0);
  assert_int_equal(write(file, text, strlen(text)), (ssize_t)strlen(text));
  close(file);
  const sdr_status status = sdr_scene_load(path, variant, count, sets, scene);
  unlink(path);
  return status;
}

static double value_at(sdr_expression *e, double x, double y, double t)
{
  double value = NAN;
  assert_non_null(e);
  assert_int_equal(sdr_expression_value(e, (double[3]){x, y, 0}, t, &value), SDR_OK);
  return value;
}

static void the_example_of_the_design_loads(void **state)
{
  (void)state;
  sdr_scene *s = load(GOOD "cylinder.yaml");
  assert_string_equal(s->title, "Thick cylinder under internal pressure");
  assert_string_equal(s->name, "cylinder");
  assert_string_equal(s->variant, "");
  assert_int_equal(s->dimension, SDR_PLANE_STRESS);
  assert_int_equal(s->points.shape->kind, SDR_ANNULUS);
  assert_near(s->points.shape->inner, 0.081);
  assert_near(s->points.shape->outer, 0.149);
  assert_near(s->points.spacing, 0.0005);
  assert_near(s->points.thickness, 1.0);
  assert_int_equal(s->points.cell_centred[0], 0);
  assert_int_equal(s->horizon_relative, 1);
  assert_near(value_at(s->horizon, 0, 0, 0), 3.015);
  assert_int_equal(s->model, SDR_BOND_BASED);
  assert_int_equal(s->weight.function, SDR_WEIGHT_CONSTANT);
  assert_int_equal(s->calibration, SDR_CALIBRATE_FAMILY);
  assert_int_equal(s->material_count, 1);
  assert_string_equal(s->material[0].name, "body");
  assert_null(s->material[0].where.shape);
  assert_near(s->material[0].young, 210e9);
  assert_near(s->material[0].poisson, 0.3);
  assert_near(s->material[0].density, 7850.0);
  assert_near(s->material[0].toughness, 2e4);
  assert_near(s->material[0].scatter_young, 0.05);
  assert_int_equal(s->material[0].scatter_seed, 1);
  assert_int_equal(s->damage.law, SDR_LAW_VARIATIONAL);
  assert_true(s->damage.ell.relative && s->damage.ell.value == 2);
  assert_near(s->damage.onset, 0.5);
  assert_int_equal(s->load_count, 1);
  assert_int_equal(s->load[0].kind, SDR_PRESSURE);
  assert_ptr_equal(s->load[0].on.shape, s->points.shape);
  assert_string_equal(s->load[0].on.face, "inner");
  assert_int_equal(sdr_expression_uses(s->load[0].value[0]), SDR_USES_TIME);
  assert_true(fabs(value_at(s->load[0].value[0], 0, 0, 1e-4) - 400e6 * exp(-1)) < 1);
  assert_true(s->load[0].schedule.from == -(double)INFINITY &&
              s->load[0].schedule.until == (double)INFINITY);
  assert_string_equal(s->time.integrator, "leapfrog");
  assert_near(s->time.step, 1e-7);
  assert_near(s->time.end, 1e-4);
  assert_near(s->time.safety, 0.9);
  assert_string_equal(s->output.directory, "out");
  assert_int_equal(s->output.snapshots, 20);
  assert_int_equal(s->output.field_count, 2);
  assert_string_equal(s->output.field[1], "damage");
  assert_int_equal(s->output.history_every, 5); /* 1000 steps in 200 rows */
  assert_true(s->output.checkpoint_every == (double)INFINITY);
  assert_int_equal(s->output.fragments, 1);
  assert_near(s->output.fragment_threshold, 0.5);
  assert_int_equal(s->output.ring, 1);
  assert_string_equal(sdr_origin_text(s->time.step_origin) + strlen(GOOD), "cylinder.yaml:22:36");
  sdr_scene_destroy(&s);
  assert_null(s);
}

static void every_key_of_a_state_based_body_arrives(void **state)
{
  (void)state;
  sdr_scene *s = load(GOOD "state_based.yaml");
  assert_int_equal(s->model, SDR_NONORDINARY);
  assert_int_equal(s->elasticity, SDR_NEO_HOOKEAN);
  assert_near(s->control_shear, 20e9);
  assert_true(isnan(s->control_normal));
  assert_int_equal(s->weight.function, SDR_WEIGHT_CUBIC);
  assert_int_equal(s->weight.partial_volume, 1);
  assert_int_equal(s->weight.correction, SDR_CORRECT_SURFACE_ISO);
  assert_int_equal(s->one_sided, 1);
  assert_int_equal(s->split, SDR_SPLIT_SPECTRAL);
  assert_true(s->damage.ell.relative && s->damage.ell.value == 0);
  assert_near(s->material[1].poisson, 0.25);
  assert_non_null(strstr(s->used_yaml, "ell: auto"));
  sdr_scene_destroy(&s);

  const char *const sets[] = {"material.model=ordinary", "material.poisson=0.4",
                              "material.form=madenci_oterkus"};
  assert_int_equal(sdr_scene_load(GOOD "cylinder.yaml", NULL, 3, sets, &s), SDR_OK);
  assert_int_equal(s->model, SDR_ORDINARY);
  assert_int_equal(s->form, SDR_FORM_MADENCI_OTERKUS);
  assert_int_equal(s->split, SDR_SPLIT_DILATATION);
  assert_int_equal(s->one_sided, 0);
  assert_near(s->material[0].poisson, 0.4);
  sdr_scene_destroy(&s);
}

static void every_key_of_a_plate_arrives(void **state)
{
  (void)state;
  sdr_scene *s = load(GOOD "notch.yaml");
  assert_int_equal(s->points.shape->kind, SDR_DIFFERENCE);
  assert_int_equal(s->points.shape->part_count, 2);
  assert_int_equal(s->points.shape->parts[1].kind, SDR_DISC);
  assert_near(s->points.shape->parts[1].centre[0], 0.05);
  assert_int_equal(s->points.cell_centred[0], 1);
  assert_int_equal(s->points.cell_centred[1], 0);
  assert_near(s->points.lattice_origin[0], 0.0005);
  assert_near(s->points.angle, acos(-1) / 6);
  assert_near(s->points.jitter, 0.1);
  assert_int_equal(s->points.jitter_seed, 7);
  assert_near(s->points.thickness, 0.002);
  assert_int_equal(s->points.refine_count, 1);
  assert_near(s->points.refine[0].spacing, 0.00025);
  assert_int_equal(s->points.refine[0].where.shape->kind, SDR_INTERSECTION);
  assert_string_equal(s->points.refine[0].where.text, "tip");
  const sdr_shape *box = &s->points.refine[0].where.shape->parts[0];
  assert_near(box->low[0], 0.005);
  assert_near(box->high[1], 0.025);
  assert_near(box->angle, acos(-1) / 4);
  assert_int_equal(s->points.refine[0].where.shape->parts[1].vertex_count, 4);
  assert_int_equal(s->horizon_relative, 0);
  assert_near(value_at(s->horizon, 0.5, 0, 0), 0.0045);
  assert_int_equal(s->weight.partial_volume, 1);
  assert_int_equal(s->calibration, SDR_CALIBRATE_PRINTED);
  assert_int_equal(s->region_count, 4);
  assert_near(s->region[3].shape->normal[0], -1.0);
  assert_int_equal(s->material_count, 2);
  assert_string_equal(s->material[1].name, "stiff");
  assert_ptr_equal(s->material[1].where.shape, s->region[3].shape);
  assert_true(isnan(s->material[1].poisson));
  assert_near(s->material[1].scatter_young, 0.02);
  assert_int_equal(s->damage.law, SDR_LAW_CRITICAL_STRETCH);
  assert_true(!s->damage.ell.relative && fabs(s->damage.ell.value - 0.002) < 1e-18);
  assert_true(isnan(s->damage.onset));
  assert_int_equal(s->damage.protect_count, 2);
  assert_int_equal(s->crack_count, 2);
  assert_int_equal(s->crack[1].point_count, 3);
  assert_near(s->crack[0].vertices[3], 0.01);
  assert_near(s->crack[0].vertices[4], 0.02);
  assert_int_equal(s->initial_count, 3);
  assert_int_equal(s->initial[0].velocity, 0); /* displacements come first */
  assert_null(s->initial[0].value[1]);
  assert_null(s->initial[2].value[0]);
  assert_near(value_at(s->initial[1].value[0], 0.25, 0, 0), 0.25);
  sdr_scene_destroy(&s);
}

static void conditions_and_output_of_a_plate_arrive(void **state)
{
  (void)state;
  sdr_scene *s = load(GOOD "notch.yaml");
  assert_int_equal(s->load_count, 4);
  assert_int_equal(s->load[0].kind, SDR_TRACTION);
  assert_string_equal(s->load[0].on.face, "right");
  assert_int_equal(s->load[0].spread_layer, 1);
  assert_near(s->load[0].schedule.until, 5e-6);
  assert_true(s->load[1].schedule.from == 0); /* a ramp begins at 0 if nothing else is said */
  assert_string_equal(s->load[1].on.text, "hole.rim");
  assert_near(value_at(s->load[2].value[1], 0, 0, 0), -9.81 * 2440);
  assert_null(s->load[2].value[0]);
  assert_near(s->load[3].at[1], 0.04);
  assert_int_equal(s->support_count, 2);
  assert_string_equal(s->support[0].name, "grip");
  assert_string_equal(s->support[1].name, "support1");
  assert_int_equal(s->support[0].kind[0], SDR_PRESCRIBED_DISPLACEMENT);
  assert_int_equal(s->support[0].kind[1], SDR_PRESCRIBED_VELOCITY);
  assert_int_equal(s->support[1].kind[0], SDR_FREE);
  assert_true(s->support[0].depth.relative && s->support[0].depth.value == 3);
  assert_string_equal(s->support[1].on.face, "bottom");
  assert_true(isnan(s->time.step));
  assert_near(s->time.safety, 0.8);
  assert_int_equal(s->time.allow_unstable, 1);
  assert_string_equal(s->output.directory, "out/notch");
  assert_int_equal(s->output.history_every, 10);
  assert_near(s->output.checkpoint_every, 1e-5);
  assert_int_equal(s->output.probe_count, 2);
  assert_string_equal(s->output.probe[1].name, "probe1");
  assert_string_equal(s->output.probe[0].field[1], "damage");
  assert_near(s->output.fragment_threshold, 0.35);
  assert_near(s->output.ring_centre[0], 0.05);
  assert_int_equal(s->figure_count, 2);
  assert_near(s->figure[0].paper, 43.6e-6);
  assert_true(isnan(s->figure[1].high) && isnan(s->figure[1].paper));
  assert_int_equal(s->threads, 2);
  sdr_scene_destroy(&s);
}

/* A difference turns the normals of what it takes away, so the pressure pushes into the body. */
static void the_rim_of_a_hole_looks_out_of_the_body(void **state)
{
  (void)state;
  sdr_scene *s = load(GOOD "notch.yaml");
  const sdr_shape *rim = s->load[1].on.shape;
  assert_int_equal(rim->kind, SDR_DIFFERENCE);
  assert_int_equal(rim->parts[1].kind, SDR_DISC);
  assert_near(rim->parts[1].outer, 0.005);
  const sdr_shape *space = &rim->parts[0];
  assert_int_equal(space->kind, SDR_UNION);
  assert_true(space->parts[0].normal[0] == -space->parts[1].normal[0]);
  sdr_scene_destroy(&s);
}

/* The first block of docs/scene.md is a whole scene. */
static void the_smallest_scene_of_the_manual_loads(void **state)
{
  (void)state;
  static char text[8000];
  FILE *stream = fopen(SUNDER_SOURCE_DIR "/docs/scene.md", "r");
  assert_non_null(stream);
  text[fread(text, 1, sizeof text - 1, stream)] = '\0';
  fclose(stream);
  char *begin = strstr(text, "```yaml\n");
  assert_non_null(begin);
  begin += strlen("```yaml\n");
  char *end = strstr(begin, "```");
  assert_non_null(end);
  *end = '\0';
  sdr_scene *s = NULL;
  if (load_text(begin, NULL, 0, NULL, &s) != SDR_OK) fail_msg("%s", sdr_error_message());
  assert_int_equal(s->load_count, 2);
  sdr_scene_destroy(&s);
}

static void one_and_three_dimensions_load(void **state)
{
  (void)state;
  sdr_scene *bar = load(GOOD "bar.yaml");
  assert_int_equal(bar->dimension, SDR_1D);
  assert_near(bar->points.thickness, 1e-4);
  assert_near(bar->points.shape->high[0], 1.0);
  assert_int_equal(bar->damage.law, SDR_LAW_NONE);
  assert_true(bar->material[0].toughness == (double)INFINITY);
  assert_int_equal(bar->crack[0].point_count, 1);
  assert_int_equal(bar->output.fragments, 0);
  assert_int_equal(bar->output.history_every, 0); /* the step is automatic */
  sdr_scene_destroy(&bar);
  sdr_scene *block = load(GOOD "block.yaml");
  assert_int_equal(block->points.shape->primitive_count, 3);
  assert_near(block->crack[0].normal[2], 1.0);
  assert_near(block->crack[1].vertices[3], 0.005);
  assert_near(block->crack[1].vertices[8], 0.002);
  assert_string_equal(block->load[1].on.face, "ends");
  assert_string_equal(block->load[2].on.face, "front");
  assert_int_equal(block->output.ring, 0);
  sdr_scene_destroy(&block);
}

static void a_variant_overrides_the_scene_and_set_overrides_both(void **state)
{
  (void)state;
  sdr_scene *s = load_with(GOOD "cylinder.yaml", "coarse", 0, NULL);
  assert_near(s->points.spacing, 0.004);
  assert_near(s->points.shape->inner, 0.081); /* merged deep */
  assert_near(s->time.step, 1e-6);
  assert_string_equal(s->variant, "coarse");
  sdr_scene_destroy(&s);
  const char *const sets[] = {
      "points.spacing=2 mm",          "loads.0.pressure.value=1 MPa * t/(1 s)",
      "output.probes=[{at: [0, 0]}]", "points.shape={disc: {radius: 1 cm}}",
      "loads.0.pressure.on=rim",      "output.ring=false"};
  s = load_with(GOOD "cylinder.yaml", "coarse", 6, sets);
  assert_near(s->points.spacing, 0.002);
  assert_near(s->time.step, 1e-6);
  assert_near(value_at(s->load[0].value[0], 0, 0, 0.5), 5e5);
  assert_int_equal(s->output.probe_count, 1);
  assert_int_equal(s->points.shape->kind, SDR_DISC);
  sdr_scene_destroy(&s);
}

static void the_default_directory_names_scene_and_variant(void **state)
{
  (void)state;
  const char *text = "{dimension: 1d, points: {shape: {interval: {from: 0, to: 1}}, spacing: 0.1}, "
                     "material: {young: 1, density: 1}, time: {end: 1}, variants: {b: {}}}";
  sdr_scene *s = NULL;
  assert_int_equal(load_text(text, "b", 0, NULL, &s), SDR_OK);
  char wanted[200];
  snprintf(wanted, sizeof wanted, "out/%s-b", s->name);
  assert_string_equal(s->output.directory, wanted);
  assert_string_equal(s->title, s->name);
  sdr_scene_destroy(&s);
}

static void the_scene_is_named_after_file_or_folder(void **state)
{
  (void)state;
  char folder[] = "/tmp/sunder_folder_XXXXXX", path[200];
  assert_non_null(mkdtemp(folder));
  snprintf(path, sizeof path, "%s/scene.yaml", folder);
  FILE *stream = fopen(path, "w");
  fputs("{dimension: 1d, points: {shape: {interval: {from: 0, to: 1}}, spacing: 0.1}, material: "
        "{young: 1, density: 1}, time: {end: 1}}",
        stream);
  fclose(stream);
  sdr_scene *s = load(path);
  assert_string_equal(s->name, strrchr(folder, '/') + 1);
  sdr_scene_destroy(&s);
  unlink(path);
  rmdir(folder);
}

static void the_used_scene_loads_to_the_same_scene(void **state)
{
  (void)state;
  static const char *const paths[] = {GOOD "cylinder.yaml", GOOD "notch.yaml", GOOD "bar.yaml",
                                      GOOD "block.yaml"};
  for (size_t k = 0; k < sizeof paths / sizeof *paths; ++k) {
    sdr_scene *s = load(paths[k]), *again = NULL;
    if (load_text(s->used_yaml, NULL, 0, NULL, &again) != SDR_OK) {
      fail_msg("%s\n%s", sdr_error_message(), s->used_yaml);
    }
    assert_string_equal(again->used_yaml, s->used_yaml);
    assert_true(again->hash == s->hash);
    assert_int_equal(again->default_count, 0);
    sdr_scene_destroy(&s);
    sdr_scene_destroy(&again);
  }
}

static int lists_default(const sdr_scene *s, const char *line)
{
  for (int k = 0; k < s->default_count; ++k) {
    if (strcmp(s->defaults[k], line) == 0) return 1;
  }
  return 0;
}

static void what_is_not_given_is_listed(void **state)
{
  (void)state;
  sdr_scene *s = load(GOOD "bar.yaml");
  assert_true(lists_default(s, "horizon = 3.015 spacing"));
  assert_true(lists_default(s, "damage.law = none"));
  assert_true(lists_default(s, "time.step = auto"));
  assert_true(lists_default(s, "supports.0.depth = 1 spacing"));
  assert_true(lists_default(s, "output.snapshots = 20"));
  assert_true(lists_default(s, "output.fields = [displacement, damage]"));
  assert_true(lists_default(s, "title = bar"));
  assert_false(lists_default(s, "time.end = 1 ms"));
  sdr_scene_destroy(&s);
}

static uint64_t hash_with(const char *set)
{
  sdr_scene *s = load_with(GOOD "cylinder.yaml", NULL, set ? 1 : 0, &set);
  const uint64_t hash = s->hash;
  sdr_scene_destroy(&s);
  return hash;
}

static void the_hash_is_of_what_affects_the_state(void **state)
{
  (void)state;
  static const char *const same[] = {"time.end=1 us",
                                     "threads=3",
                                     "title=other",
                                     "output.snapshots=1",
                                     "damage.onset=0.1",
                                     "time.step=100 ns",
                                     "points.spacing=500 um",
                                     "output.directory=x",
                                     "figures={a: {low: 1}}",
                                     "time.safety=0.9",
                                     "time.allow_unstable=true"};
  static const char *const other[] = {
      "time.step=0.2 us",     "points.spacing=0.25 mm",
      "horizon=2 mm",         "material.scatter.seed=2",
      "damage.ell=1 horizon", "loads.0.pressure.value=1 MPa",
      "points.align=cell",    "cracks=[{segment: {from: [0, 0], to: [1, 0]}}]"};
  const uint64_t plain = hash_with(NULL);
  for (size_t k = 0; k < sizeof same / sizeof *same; ++k) {
    if (hash_with(same[k]) != plain) fail_msg("%s changes the hash", same[k]);
  }
  for (size_t k = 0; k < sizeof other / sizeof *other; ++k) {
    if (hash_with(other[k]) == plain) fail_msg("%s does not change the hash", other[k]);
  }
}

static void bad_overrides_say_what_is_wrong(void **state)
{
  (void)state;
  static const char *const cases[][2] = {
      {"points.spacing",
       "--set points.spacing: write it as PATH=VALUE, like --set time.end=\"1 us\""},
      {"=1", "--set : write it as PATH=VALUE, like --set time.end=\"1 us\""},
      {"points.spacing=", "--set points.spacing: no value after '='; give one"},
      {"points.spacing=-1 mm",
       "--set points.spacing: points.spacing = -1 mm is out of range; allowed: above 0 m"},
      {"points.spacing=1 mm + foo",
       "--set points.spacing:8: points.spacing: unknown name 'foo'; known: x y z t r theta pi and "
       "the functions sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh log2 log10 "
       "ln exp sqrt sign rint abs min max"},
      {"loads.3.pressure.value=1",
       "--set loads.3.pressure.value: loads has 1 entry; the index 3 is past its end (0 to 1)"},
      {"time.end.x=1", "--set time.end.x: time.end is a single value and has no 'x' in it"},
      {"time.stop=1",
       "--set time.stop: unknown key 'stop'; did you mean 'step'? known here: integrator, step, "
       "safety, end, allow_unstable, method, order, solver, tolerance, tolerance_displacement, "
       "tolerance_velocity, viscosity"},
      {"time=[1",
       "--set time: not YAML: did not find expected ',' or ']' (while parsing a flow sequence)"}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    sdr_scene *s = NULL;
    assert_int_equal(sdr_scene_load(GOOD "cylinder.yaml", NULL, 1, &cases[k][0], &s),
                     SDR_BAD_INPUT);
    assert_null(s);
    assert_string_equal(sdr_error_message(), cases[k][1]);
  }
}

static void an_unknown_variant_lists_the_known_ones(void **state)
{
  (void)state;
  sdr_scene *s = NULL;
  assert_int_equal(chdir(GOOD), 0);
  assert_int_equal(sdr_scene_load("cylinder.yaml", "fine", 0, NULL, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "cylinder.yaml: unknown variant 'fine'; variants of "
                                           "this scene: coarse, critical_stretch");
  assert_int_equal(sdr_scene_load("bar.yaml", "fine", 0, NULL, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "bar.yaml: unknown variant 'fine'; this scene has no variants");
}

static void line_ends_and_byte_order_marks_do_not_matter(void **state)
{
  (void)state;
  sdr_scene *s = NULL;
  assert_int_equal(load_text("\xEF\xBB\xBF"
                             "dimension: 1d\r\npoints:\r\n  shape: {interval: {from: "
                             "0, to: 1}}\r\n  spacing: 0.1\r\nmaterial: {young: 1, density: 1}\r\n"
                             "time: {end: 1}\r\n",
                             NULL, 0, NULL, &s),
                   SDR_OK);
  assert_near(s->points.spacing, 0.1);
  sdr_scene_destroy(&s);
}

static void shapes_that_double_at_each_level_are_refused(void **state)
{
  (void)state;
  char text[4000] = "{dimension: plane_stress, points: {shape: s20, spacing: 1}, material: {young: "
                    "1, density: 1}, time: {end: 1}, regions: {s0: {disc: {radius: 1}}";
  for (int k = 1; k <= 20; ++k) {
    char line[80];
    snprintf(line, sizeof line, ", s%d: {union: [s%d, s%d]}", k, k - 1, k - 1);
    strcat(text, line);
  }
  strcat(text, "}}");
  sdr_scene *s = NULL;
  assert_int_equal(load_text(text, NULL, 0, NULL, &s), SDR_BAD_INPUT);
  assert_non_null(
      strstr(sdr_error_message(), "regions.s14.union: a shape of more than 10000 parts"));
}

/* Every allocation of ours fails once; nothing may leak or crash. */
static void running_out_of_memory_anywhere_is_survived(void **state)
{
  (void)state;
  static const char *const sets[] = {"threads=1", "points.jitter.seed=3"};
  sdr_scene *s = load(GOOD "notch.yaml"); /* what is kept for good is there now */
  sdr_scene_destroy(&s);
  const size_t before = sdr_memory_now();
  long failures = 0;
  for (;; ++failures) {
    sdr_memory_fail_after(failures);
    const sdr_status status = sdr_scene_load(GOOD "notch.yaml", NULL, 2, sets, &s);
    sdr_memory_fail_after(-1);
    if (status == SDR_OK) break;
    assert_null(s);
    assert_int_equal(status, SDR_RUN_FAILED);
    assert_non_null(strstr(sdr_error_message(), "out of memory"));
    assert_int_equal(sdr_memory_now(), before);
  }
  assert_true(failures > 100);
  sdr_scene_destroy(&s);
  assert_int_equal(sdr_memory_now(), before);
}

/* Change single bytes of a good scene: it loads or is refused with a place, and leaks nothing. */
static void damaged_scenes_are_refused_with_a_place(void **state)
{
  (void)state;
  char text[8000], copy[8000];
  FILE *stream = fopen(GOOD "notch.yaml", "r");
  assert_non_null(stream);
  const size_t length = fread(text, 1, sizeof text - 1, stream);
  fclose(stream);
  const size_t before = sdr_memory_now();
  for (size_t k = 0; k < length; k += 3) {
    memcpy(copy, text, length);
    copy[length] = '\0';
    copy[k] = "}{:[],-'\"#x9*&\n\t"[(k / 3) % 15];
    sdr_scene *s = NULL;
    const sdr_status status = load_text(copy, NULL, 0, NULL, &s);
    assert_true(status == SDR_OK || status == SDR_BAD_INPUT);
    if (status == SDR_BAD_INPUT) assert_non_null(strstr(sdr_error_message(), "sunder_scene_"));
    sdr_scene_destroy(&s);
    assert_int_equal(sdr_memory_now(), before);
  }
}

static void text_in_memory_becomes_a_scene_with_its_name_in_messages(void **state)
{
  sdr_scene *scene = NULL;
  (void)state;
  assert_int_equal(
      sdr_scene_parse("dimension: 1d\n"
                      "points: {shape: {box: {from: [0 m], to: [1 m]}}, spacing: 1 cm}\n"
                      "material: {young: 1 GPa, density: 1000 kg/m^3}\n"
                      "time: {end: 1 ms}\n",
                      "rod", &scene),
      SDR_OK);
  assert_string_equal(scene->name, "rod");
  assert_near(scene->points.spacing, 0.01);
  sdr_scene_destroy(&scene);
  assert_int_equal(sdr_scene_parse("dimension: 7d\n", "rod", &scene), SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), "rod:1:12: "));
  assert_int_equal(sdr_scene_parse("", "rod", &scene), SDR_BAD_INPUT);
  assert_null(scene);
}

#define SOFT                                                                                       \
  "dimension: plane_stress\n"                                                                      \
  "points: {shape: {box: {from: [0, 0], to: [1, 1]}}, spacing: 0.1}\n"                             \
  "material: {young: 1 GPa, density: 1000, toughness: 1, strength: 1 MPa}\n"

static void what_nothing_looks_at_is_listed(void **state)
{
  (void)state;
  static const char *const expected[] = {
      "material.strength: only the damage law cohesive uses it",
      "damage.ell: the law critical_stretch does not use it",
      "time.safety: the integrator static does not use it",
      "loads.0: begins at 3 s, after the end of the run at 2 s",
      "supports.1: begins at 2.5 s, after the end of the run at 2 s"};
  const char *text = SOFT "damage: {law: critical_stretch, ell: 2 horizon}\n"
                          "loads: [{traction: {on: top, value: [0, 1], from: 3 s}}]\n"
                          "supports: [{on: left, displacement: {x: 0}, from: 2 s},\n"
                          "  {on: bottom, displacement: {y: 0}, from: 2.5 s}]\n"
                          "time: {integrator: static, safety: 0.5, end: 2 s}\n";
  sdr_scene *s = NULL;
  if (load_text(text, NULL, 0, NULL, &s) != SDR_OK) fail_msg("%s", sdr_error_message());
  assert_int_equal(s->idle_count, (int)(sizeof expected / sizeof *expected));
  for (int k = 0; k < s->idle_count; ++k) assert_string_equal(s->idle[k], expected[k]);
  sdr_scene_destroy(&s);
  if (load_text(SOFT "time: {end: 1 s}\n", NULL, 0, NULL, &s) != SDR_OK)
    fail_msg("%s", sdr_error_message());
  assert_int_equal(s->idle_count, 2);
  assert_string_equal(s->idle[0], "material.toughness: there is no damage law");
  sdr_scene_destroy(&s);
}

static void a_mistyped_law_is_not_called_none(void **state)
{
  (void)state;
  sdr_scene *s = NULL;
  assert_int_equal(sdr_scene_parse(SOFT "damage: {law: critical_strech}\n"
                                        "output: {cracks: {tips: {a: {start: [0, 0.5]}}}}\n"
                                        "time: {end: 1 s}\n",
                                   "typo.yaml", &s),
                   SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "typo.yaml:4:15: unknown law 'critical_strech'; did you mean "
                      "'critical_stretch'? available: none, variational, critical_stretch, at1, "
                      "cohesive");
}

static void what_could_never_act_is_refused(void **state)
{
  (void)state;
  static const char *const sets[][2] = {
      {"loads=[{traction: {on: top, value: [0, 1], until: -1 us}}]",
       "--set loads: 'until' lies before the run, which begins at t = 0, so this would never act"},
      {"supports=[{on: bottom, velcity: {y: 0}}]",
       "--set supports: unknown key 'velcity'; did you mean 'velocity'? known here: name, on, "
       "layer, "
       "depth, displacement, velocity, mean, from, until, ramp"},
      {"time={integrator: static, safety: 2}",
       "--set time: time.safety = 2 is out of range; allowed: above 0 and at most 1"},
      {"variants.a.points.spacng=3",
       "--set variants.a.points.spacng: overrides change the scene that runs, not its variants; "
       "give --variant NAME and override the key itself, like --set points.spacing=\"1 mm\""}};
  for (size_t k = 0; k < sizeof sets / sizeof *sets; ++k) {
    sdr_scene *s = NULL;
    assert_int_equal(load_text(SOFT "time: {end: 1 s}\n", NULL, 1, sets[k], &s), SDR_BAD_INPUT);
    assert_string_equal(sdr_error_message(), sets[k][1]);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_nothing_looks_at_is_listed),
      cmocka_unit_test(what_could_never_act_is_refused),
      cmocka_unit_test(a_mistyped_law_is_not_called_none),
      cmocka_unit_test(the_example_of_the_design_loads),
      cmocka_unit_test(every_key_of_a_plate_arrives),
      cmocka_unit_test(every_key_of_a_state_based_body_arrives),
      cmocka_unit_test(conditions_and_output_of_a_plate_arrive),
      cmocka_unit_test(the_rim_of_a_hole_looks_out_of_the_body),
      cmocka_unit_test(the_smallest_scene_of_the_manual_loads),
      cmocka_unit_test(one_and_three_dimensions_load),
      cmocka_unit_test(a_variant_overrides_the_scene_and_set_overrides_both),
      cmocka_unit_test(the_default_directory_names_scene_and_variant),
      cmocka_unit_test(the_scene_is_named_after_file_or_folder),
      cmocka_unit_test(the_used_scene_loads_to_the_same_scene),
      cmocka_unit_test(what_is_not_given_is_listed),
      cmocka_unit_test(the_hash_is_of_what_affects_the_state),
      cmocka_unit_test(text_in_memory_becomes_a_scene_with_its_name_in_messages),
      cmocka_unit_test(bad_overrides_say_what_is_wrong),
      cmocka_unit_test(an_unknown_variant_lists_the_known_ones),
      cmocka_unit_test(line_ends_and_byte_order_marks_do_not_matter),
      cmocka_unit_test(shapes_that_double_at_each_level_are_refused),
      cmocka_unit_test(running_out_of_memory_anywhere_is_survived),
      cmocka_unit_test(damaged_scenes_are_refused_with_a_place),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
