/* Scenes with fictitious layers: what is made of them, and the messages for wrong use. */
#include "output/fragments.h"
#include "support/program.h"
#include "support/scene_text.h"

static const char rest[] = "material: {young: 200 GPa, density: 7850 kg/m^3}\n"
                           "time: {end: 1 us}\n";
static const char square[] = "dimension: plane_stress\n"
                             "points: {shape: {box: {from: [0, 0], to: [10 mm, 10 mm]}}, spacing: "
                             "1 mm, align: cell}\n";

static int32_t images(const sdr_built *built, int layer)
{
  int32_t count = 0;
  for (int32_t i = 0; i < built->points->count; ++i)
    count += (built->points->layer[i] & SDR_LAYERS) == layer;
  return count;
}

static void a_layer_mirrors_the_rows_within_its_depth_and_the_corner(void **state)
{
  (void)state;
  sdr_built built;
  scene_build(&built,
              "%shorizon: 2 spacing\nsupports:\n"
              "- {on: left, layer: mirror, displacement: {x: 0}}\n"
              "- {on: bottom, layer: mirror, depth: 3 mm, displacement: {y: 0}}\n"
              "loads: [{traction: {on: right, layer: fictitious, depth: 1 horizon, value: [1, "
              "0]}}]\n%s",
              square, rest);
  assert_int_equal(images(&built, 0), 100);
  assert_int_equal(images(&built, 1), 20);     /* two rows */
  assert_int_equal(images(&built, 2), 30 + 6); /* three, and the corner on the left */
  assert_int_equal(images(&built, 3), 20 + 6); /* and the corner at the bottom */
  assert_int_equal(sdr_layers_count(built.layers), 82);
  for (int32_t i = 0; i < built.points->count; ++i) {
    const sdr_points *points = built.points;
    const int layer = points->layer[i] & SDR_LAYERS, corner = points->x[1][i] < 0.0;
    assert_true(points->spacing[i] == 1e-3 && points->horizon[i] == 2e-3);
    assert_int_equal(sdr_has_family(points, i), layer == 0 || (layer == 3 && !corner));
  }
  sdr_built_destroy(&built);
}

static void layers_follow_the_body_by_the_map_that_statics_takes(void **state)
{
  (void)state;
  sdr_built built;
  scene_build(&built,
              "%shorizon: 2 spacing\nsupports:\n"
              "- {on: left, layer: mirror, displacement: [0.1 mm, \"0.01*y\"]}\n"
              "- {on: bottom, layer: mirror, displacement: {y: 1 mm}}\n"
              "loads: [{traction: {on: right, layer: fictitious, value: [1 GPa, 2 GPa]}}]\n%s",
              square, rest);
  const sdr_points *points = built.points;
  double *u[3];
  sdr_slaves slaves = {0};
  vector_create(points, u);
  vector_noise(points, 1e-3, 5, u);
  assert_int_equal(sdr_layers_values(built.layers, 0.0), SDR_OK);
  sdr_layers_follow(built.layers, u);
  assert_int_equal(sdr_layers_slaves(built.layers, &slaves), SDR_OK);
  assert_int_equal(slaves.count, 2 * sdr_layers_count(built.layers));
  for (int32_t k = 0; k < slaves.count; ++k) {
    double sum = slaves.constant[k];
    for (int64_t p = slaves.first[k]; p < slaves.first[k + 1]; ++p) {
      assert_true(sdr_in_body(points, slaves.master[p] / 2));
      sum += slaves.coefficient[p] * u[slaves.master[p] % 2][slaves.master[p] / 2];
    }
    assert_int_equal(slaves.apart[k], (points->layer[slaves.unknown[k] / 2] & SDR_LAYERS) == 3);
    const double followed = u[slaves.unknown[k] % 2][slaves.unknown[k] / 2];
    assert_near(followed, sum, 1e-15);
  }
  sdr_slaves_destroy(&slaves);
  vector_destroy(u);
  sdr_built_destroy(&built);
}

/* f.(B u) = (B^T f).u for both maps. */
static void forces_are_mapped_by_the_transpose(void **state)
{
  (void)state;
  sdr_built built;
  scene_build(&built,
              "%ssupports: [{on: left, layer: mirror, displacement: [0, 0]}]\n"
              "loads: [{traction: {on: top, layer: fictitious, value: [1, 2]}}]\n%s",
              square, rest);
  const sdr_points *points = built.points;
  for (int map = SDR_LAYER_MOTION; map <= SDR_LAYER_FORCE; ++map) {
    double *u[3], *f[3];
    vector_create(points, u);
    vector_create(points, f);
    vector_noise(points, 1.0, 5, u);
    vector_noise(points, 1.0, 6, f);
    sdr_layers_extend(built.layers, (sdr_layer_map)map, u);
    const double before = vector_dot(points, f, u);
    sdr_layers_gather(built.layers, (sdr_layer_map)map, f);
    assert_near(vector_dot(points, f, u), before, 1e-12);
    vector_destroy(u);
    vector_destroy(f);
  }
  assert_false(sdr_layers_symmetric(built.layers));
  sdr_built_destroy(&built);
}

static void points_of_layers_belong_to_no_piece_support_load_or_probe(void **state)
{
  (void)state;
  sdr_built built;
  sdr_fragments found;
  scene_build(&built,
              "%scracks: [{segment: {from: [5 mm, -1 mm], to: [5 mm, 11 mm]}}]\n"
              "damage: {law: variational}\n"
              "material: {young: 200 GPa, density: 7850 kg/m^3, toughness: 10 J/m^2}\n"
              "supports:\n- {on: left, layer: mirror, displacement: {x: 0}}\n"
              "- {on: body, displacement: {y: 0}}\n"
              "loads: [{traction: {on: top, value: [0, 1]}}, {body: {value: [1, 0]}}]\n"
              "time: {end: 1 us}\n",
              square);
  const sdr_points *points = built.points;
  int32_t *piece = sdr_alloc((size_t)points->count, sizeof *piece);
  assert_int_equal(sdr_fragments_find(built.system, 0.5, piece, &found), SDR_OK);
  assert_int_equal(found.count, 2);
  assert_int_equal(found.largest, 50);
  assert_int_equal(found.single, 0);
  for (int32_t i = 0; i < points->count; ++i)
    assert_int_equal(piece[i] >= 0, sdr_in_body(points, i));
  assert_int_equal(sdr_supports_count(built.supports), 100);
  assert_int_equal(sdr_loads_count(built.loads), 100);
  assert_true(sdr_in_body(points, sdr_points_nearest(points, (const double[3]){-3e-3, 5e-3, 0})));
  sdr_free(piece);
  sdr_built_destroy(&built);
}

/* Scenes and what the message holds. */
static const char *const cases[][2] = {
    {"dimension: plane_stress\npoints: {shape: {disc: {radius: 5 mm}}, spacing: 1 mm}\n"
     "supports: [{on: rim, layer: mirror, displacement: {x: 0}}]\n",
     ":3:12: support 'support0': a layer needs one flat face, and 'rim' is none; leave `layer` "
     "out to act on the points near the face"},
    {"dimension: plane_stress\npoints: {shape: {box: {from: [0, 0], to: [9 mm, 9 mm]}}, spacing: "
     "1 mm, align: cell, jitter: {share: 10 %}}\n"
     "supports: [{on: left, layer: mirror, displacement: {x: 0}}]\n",
     "support 'support0': a layer needs points in rows, and these are jittered; leave out "
     "`layer` "
     "or points.jitter"},
    {"dimension: plane_stress\npoints: {shape: {box: {from: [0, 0], to: [9 mm, 9 mm]}}, spacing: "
     "1 mm, angle: 20 deg}\n"
     "supports: [{name: grip, on: left, layer: mirror, displacement: {x: 0}}]\n",
     "support 'grip': a layer needs a face along the rows of the lattice, and 'left' lies across "
     "them; turn points.angle or the face"},
    {"dimension: plane_stress\npoints: {shape: {box: {from: [0, 0], to: [9 mm, 9 mm]}}, spacing: "
     "1 mm}\n"
     "loads: [{traction: {on: right, layer: fictitious, value: [1, 0]}}]\n",
     ":3:10: traction: a layer needs its face halfway between two rows of points, but the point "
     "at x = 3 mm, y = 0 m lies 6 spacings from 'right'; move the face, or the lattice by "
     "points.origin or points.align"},
    {"dimension: plane_stress\npoints: {shape: {box: {from: [0, 0], to: [9.2 mm, 9 mm]}}, "
     "spacing: 1 mm, align: cell}\n"
     "loads: [{traction: {on: right, layer: fictitious, value: [1, 0]}}]\n",
     "lies 5.7 spacings from 'right'"},
    {"dimension: plane_stress\npoints: {shape: {box: {from: [0, 0], to: [9 mm, 9 mm]}}, spacing: "
     "1 mm, align: cell}\n"
     "supports:\n- {on: left, layer: mirror, displacement: {x: 0}}\n"
     "- {name: more, on: left, layer: mirror, displacement: {y: 0}}\n",
     "its layer has a point at x = "},
    {"dimension: plane_stress\npoints: {shape: {box: {from: [0, 0], to: [9 mm, 9 mm]}}, spacing: "
     "1 mm, align: cell}\n"
     "supports: [{on: {box: {from: [20 mm, 0], to: [25 mm, 9 mm]}, face: left}, layer: mirror, "
     "displacement: {x: 0}}]\n",
     "no point lies under 'box' within the depth of the layer; choose a face of the body or "
     "a larger depth"},
    {"dimension: plane_stress\npoints: {shape: {box: {from: [0, 0], to: [9 mm, 9 mm]}}, spacing: "
     "1 mm, align: cell}\n"
     "supports: [{on: body, layer: mirror, displacement: {x: 0}}]\n",
     "a mirror layer lies outside a face; 'body' is a volume"},
    {"dimension: plane_stress\npoints: {shape: {box: {from: [0, 0], to: [9 mm, 9 mm]}}, spacing: "
     "1 mm, align: cell}\n"
     "supports: [{on: left, layer: mirror, velocity: {x: 0}}]\n",
     "a mirror layer holds a displacement; give it as a formula of t"},
    {"dimension: plane_stress\npoints: {shape: {box: {from: [0, 0], to: [9 mm, 9 mm]}}, spacing: "
     "1 mm, align: cell}\n"
     "supports: [{on: left, layer: mirror, displacement: {x: 0}, until: 3 us}]\n",
     "'until' does not go with a layer, which acts all the time; leave it out (a formula of t "
     "and "
     "'ramp' are possible)"},
    {"dimension: plane_stress\npoints: {shape: {box: {from: [0, 0], to: [9 mm, 9 mm]}}, spacing: "
     "1 mm, align: cell}\n"
     "loads: [{traction: {on: right, layer: mirror, value: [1, 0]}}]\n",
     "fictitious"},
};

static void wrong_use_is_refused_with_the_reason(void **state)
{
  (void)state;
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    sdr_built built;
    assert_int_equal(scene_try(&built, "%s%s", cases[k][0], rest), SDR_BAD_INPUT);
    if (!strstr(sdr_error_message(), cases[k][1]))
      fail_msg("case %zu: \"%s\" lacks \"%s\"", k, sdr_error_message(), cases[k][1]);
  }
}

static void a_run_with_layers_resumes_with_the_same_bits(void **state)
{
  (void)state;
  static const char motion[] =
      "material: {young: 200 GPa, density: 7850 kg/m^3}\n"
      "initial: {velocity: [\"10*sin(150*x)\", \"-8*cos(200*y)\"]}\n"
      "supports:\n"
      "- {on: left, layer: mirror, displacement: [\"1e-5*sin(2e5*t)\", \"1e-3*x\"]}\n"
      "loads: [{traction: {on: right, layer: fictitious, value: [1 MPa, 2 MPa], ramp: 10 us}}]\n"
      "output: {checkpoint: {every: 4 us}, snapshots: 0, history: {every: 5}}\n"
      "time: {end: 10 us, step: 0.2 us}\n";
  char text[2000];
  said s;
  snprintf(text, sizeof text, "%s%s", square, motion);
  write_text("moving.yaml", text);
  shell(&s, "sunder run moving.yaml -o whole --quiet && "
            "sunder run moving.yaml -o parts --quiet --set 'time.end=5 us' && "
            "sunder run moving.yaml --resume parts/checkpoint.h5 --quiet && "
            "cmp whole/history.csv parts/history.csv");
  if (s.code != 0) fail_msg("%s%s", s.out, s.err);
}

static void every_failing_allocation_is_reported(void **state)
{
  (void)state;
  sdr_built built;
  static const char text[] = "supports: [{on: left, layer: mirror, displacement: [0, 0]}]\n"
                             "loads: [{traction: {on: top, layer: fictitious, value: [1, 2]}}]\n";
  scene_build(&built, "%s%s%s", square, text, rest);
  const size_t held = sdr_memory_now();
  for (long k = 0;; ++k) {
    sdr_layers *layers = NULL;
    sdr_slaves slaves = {0};
    sdr_memory_fail_after(k);
    sdr_status status = sdr_layers_create(built.scene, built.points, &layers);
    if (status == SDR_OK) status = sdr_layers_slaves(layers, &slaves);
    sdr_memory_fail_after(-1);
    sdr_slaves_destroy(&slaves);
    if (layers) sdr_layers_destroy(&layers);
    assert_int_equal(sdr_memory_now(), held);
    if (status == SDR_OK) break;
    assert_int_equal(status, SDR_RUN_FAILED);
    assert_true(k < 1000);
  }
  sdr_built_destroy(&built);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_layer_mirrors_the_rows_within_its_depth_and_the_corner),
      cmocka_unit_test(layers_follow_the_body_by_the_map_that_statics_takes),
      cmocka_unit_test(forces_are_mapped_by_the_transpose),
      cmocka_unit_test(points_of_layers_belong_to_no_piece_support_load_or_probe),
      cmocka_unit_test(wrong_use_is_refused_with_the_reason),
      cmocka_unit_test(a_run_with_layers_resumes_with_the_same_bits),
      cmocka_unit_test(every_failing_allocation_is_reported),
  };
  return cmocka_run_group_tests(tests, enter_folder, leave_folder);
}
