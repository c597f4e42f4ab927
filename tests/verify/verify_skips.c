/* What a scene does not need is left out, and the answer keeps its bits (docs/performance.md,
   "What is skipped"). Stripes at rest have their own file, verify_rest. */
#include "mechanics/bond_internal.h"
#include "nom/neighbourhood.h"
#include "support/scene_text.h"

enum { STEPS = 12 };

/* Forces after a few steps of noise that the history sees one after the other. */
static void exercise(sdr_model *model, double *const f[3])
{
  double *u[3], *v[3];
  vector_create(model->points, u);
  vector_create(model->points, v);
  for (uint64_t step = 0; step < STEPS; ++step) {
    vector_noise(model->points, (0.2 + 0.1 * (double)(step % 5)) * 0.01 * body_spacing, step + 1,
                 u);
    model->ops->force_commit(model, u, v, 1e-8, f);
  }
  vector_destroy(u);
  vector_destroy(v);
}

static void expect_same_bits(const sdr_points *points, double *const a[3], double *const b[3])
{
  for (int c = 0; c < points->components; ++c)
    assert_memory_equal(a[c], b[c], (size_t)points->count * sizeof(double));
}

static const body_how shapes[] = {
    {.dimension = SDR_1D, .cells = {90}},
    {.dimension = SDR_PLANE_STRESS, .cells = {300, 9}},
    {.dimension = SDR_PLANE_STRAIN, .cells = {20, 30}, .jitter = 0.2, .horizon_spread = 0.2},
    {.dimension = SDR_3D, .cells = {9, 8, 34}, .ratio = 2.01}};
enum { SHAPES = sizeof shapes / sizeof *shapes };

/* Exercise the body that skips and the one that `prepare` has do the work; both have how's law. */
static void compare(const body_how *how, void (*prepare)(sdr_bond_model *))
{
  double *skipping[3], *working[3];
  body a = body_create(how), b = body_create(how);
  prepare((sdr_bond_model *)b.model);
  vector_create(a.points, skipping);
  vector_create(b.points, working);
  exercise(a.model, skipping);
  exercise(b.model, working);
  assert_true(vector_largest(a.points, skipping) > 0.0);
  expect_same_bits(a.points, skipping, working);
  vector_destroy(skipping);
  vector_destroy(working);
  body_destroy(&a);
  body_destroy(&b);
}

static void compare_all(void (*prepare)(sdr_bond_model *))
{
  for (int k = 0; k < SHAPES; ++k)
    for (int law = SDR_LAW_NONE; law < SDR_LAW_COUNT; ++law) {
      body_how how = shapes[k];
      how.law = (sdr_law)law;
      compare(&how, prepare);
    }
}

/* ---- moduli ---------------------------------------------------------------------------------- */

static void give_moduli_to_points(sdr_bond_model *model)
{
  sdr_bond_body *bonds = &model->body;
  const size_t padded = sdr_points_padded(bonds->points);
  if (bonds->stiffness_at) return;
  bonds->stiffness_at = sdr_alloc(padded, sizeof(double));
  bonds->threshold_at = sdr_alloc(padded, sizeof(double));
  bonds->decline_at = sdr_alloc(padded, sizeof(double));
  assert_true(bonds->stiffness_at && bonds->threshold_at && bonds->decline_at);
  for (size_t i = 0; i < padded; ++i) {
    bonds->stiffness_at[i] = bonds->stiffness;
    bonds->threshold_at[i] = bonds->threshold;
    bonds->decline_at[i] = bonds->decline;
  }
}

/* Two thresholds, though equal, need two fractions in the variational law: one rounding more. */
static void shared_moduli_need_no_coefficients_a_point(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int law = SDR_LAW_NONE; law < SDR_LAW_COUNT; ++law) {
      body_how how = shapes[k];
      how.law = (sdr_law)law;
      double *shared[3], *each[3];
      body a = body_create(&how), b = body_create(&how);
      if (how.horizon_spread <= 0.0) assert_null(((sdr_bond_model *)a.model)->body.stiffness_at);
      give_moduli_to_points((sdr_bond_model *)b.model);
      vector_create(a.points, shared);
      vector_create(b.points, each);
      exercise(a.model, shared);
      exercise(b.model, each);
      if (law == SDR_LAW_VARIATIONAL)
        assert_at_most(vector_difference(a.points, shared, each),
                       1e-14 * vector_largest(a.points, shared));
      else
        expect_same_bits(a.points, shared, each);
      vector_destroy(shared);
      vector_destroy(each);
      body_destroy(&a);
      body_destroy(&b);
    }
}

/* ---- tests for cut pairs --------------------------------------------------------------------- */

static int mark_nothing(const void *context, const double a[3], const double b[3])
{
  (void)context;
  (void)a;
  (void)b;
  return 0;
}

/* As if every run and chunk had a cut pair somewhere. */
static void look_at_every_flag(sdr_bond_model *model)
{
  int64_t cut;
  assert_int_equal(model->head.ops->mark(&model->head, mark_nothing, NULL, &cut), SDR_OK);
  assert_int_equal(cut, 0);
  sdr_bond_body *bonds = &model->body;
  if (!sdr_law_softens((int)bonds->law)) assert_int_equal(sdr_bond_alloc_flags(model), SDR_OK);
  const size_t runs = (size_t)bonds->bonds->run_count;
  if (runs > 0 && !bonds->run_marked) bonds->run_marked = sdr_alloc(runs, 1);
  if (runs > 0) memset(bonds->run_marked, 1, runs);
  if (runs > 0 && bonds->run_flagged) memset(bonds->run_flagged, 1, runs);
  bonds->loose_marked = 1;
}

static void bodies_without_cuts_need_no_look_at_flags(void **state)
{
  (void)state;
  compare_all(look_at_every_flag);
}

/* ---- no damage law --------------------------------------------------------------------------- */

static size_t history_bytes(const sdr_model *model)
{
  sdr_model_traits traits;
  model->ops->traits(model, &traits);
  return traits.history_bytes;
}

static void no_damage_law_keeps_no_history(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int law = SDR_LAW_VARIATIONAL; law < SDR_LAW_COUNT; ++law) {
      body_how none = shapes[k], unbreakable = shapes[k];
      unbreakable.law = (sdr_law)law;
      unbreakable.stretch = 1e12;
      double *without[3], *with[3];
      body a = body_create(&none), b = body_create(&unbreakable);
      assert_int_equal(history_bytes(a.model), 0);
      assert_true(history_bytes(b.model) > 0);
      vector_create(a.points, without);
      vector_create(b.points, with);
      exercise(a.model, without);
      exercise(b.model, with);
      /* laws that soften multiply by (1-d)^2 = 1 to round-off */
      if (sdr_law_softens(law))
        assert_at_most(vector_difference(a.points, without, with),
                       1e-14 * vector_largest(a.points, without));
      else
        expect_same_bits(a.points, without, with);
      vector_destroy(without);
      vector_destroy(with);
      body_destroy(&a);
      body_destroy(&b);
    }
}

/* ---- the third dimension --------------------------------------------------------------------- */

/* A body of one layer, in two or three components, with the same volumes and constants. */
static body one_layer(sdr_dimension dimension, sdr_law law)
{
  const body_how how = {.dimension = dimension, .cells = {70, 31, 1}, .law = law};
  body b = {.how = how, .points = body_points(&how, NULL)};
  for (int32_t i = 0; i < b.points->count; ++i) b.points->volume[i] = pow(body_spacing, 3.0);
  assert_int_equal(sdr_families_create(b.points, &how.weight, &b.families), SDR_OK);
  body_materials(&b);
  const sdr_bonds_how plain = {.force_loose = 0};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(b.points, &plain, &bonds), SDR_OK);
  const sdr_bond_based_how model_how = {.dimension = dimension,
                                        .law = law,
                                        .ell = {1.0, 1},
                                        .young = b.young,
                                        .toughness = b.toughness,
                                        .strength = b.strength};
  assert_int_equal(sdr_bond_based_create(b.points, bonds, b.families, &model_how, &b.model),
                   SDR_OK);
  b.bonds = bonds;
  ((sdr_bond_model *)b.model)->body.stiffness = 1e20;
  ((sdr_bond_model *)b.model)->body.threshold = law == SDR_LAW_COHESIVE ? 1e-3 : 1e-4;
  ((sdr_bond_model *)b.model)->body.decline = 0.05;
  return b;
}

static void plane_bodies_have_no_third_component(void **state)
{
  (void)state;
  for (int law = SDR_LAW_NONE; law < SDR_LAW_COUNT; ++law) {
    double *two[3], *three[3], *u[2][3], *v[2][3];
    body a = one_layer(SDR_PLANE_STRESS, (sdr_law)law), b = one_layer(SDR_3D, (sdr_law)law);
    assert_null(a.points->x[2]);
    assert_int_equal(a.model->bonds, b.model->bonds);
    vector_create(a.points, two);
    vector_create(b.points, three);
    for (int k = 0; k < 2; ++k) {
      vector_create(k ? b.points : a.points, u[k]);
      vector_create(k ? b.points : a.points, v[k]);
    }
    for (uint64_t step = 1; step <= STEPS; ++step) {
      vector_noise(a.points, 0.004 * body_spacing, step, u[0]);
      for (int c = 0; c < 2; ++c)
        memcpy(u[1][c], u[0][c], (size_t)a.points->count * sizeof(double));
      a.model->ops->force_commit(a.model, u[0], v[0], 1e-8, two);
      b.model->ops->force_commit(b.model, u[1], v[1], 1e-8, three);
    }
    assert_true(vector_largest(a.points, two) > 0.0);
    expect_same_bits(a.points, two, three);
    for (int32_t i = 0; i < b.points->count; ++i) assert_true(three[2][i] == 0.0);
    for (int k = 0; k < 2; ++k) {
      vector_destroy(u[k]);
      vector_destroy(v[k]);
    }
    vector_destroy(two);
    vector_destroy(three);
    body_destroy(&a);
    body_destroy(&b);
  }
}

/* ---- books and fields ------------------------------------------------------------------------ */

static const char *const ring =
    "dimension: plane_stress\n"
    "points: {shape: {annulus: {inner: 80 mm, outer: 120 mm}}, spacing: 4 mm}\n"
    "material: {young: 210 GPa, density: 7850 kg/m^3, toughness: 2e4 J/m^2, "
    "strength: 400 MPa, scatter: {young: 5 %%}}\n"
    "damage: {law: %s}\n"
    "loads: [{pressure: {on: inner, value: 400 MPa}}]\n"
    "time: {step: 0.8 us, end: 80 us}\n";

static void energies_and_fields_change_no_bit_of_the_run(void **state)
{
  (void)state;
  static const char *const laws[] = SDR_LAW_NAMES;
  static const char *const fields[] = {"damage", "stress", "energy_density", "dissipated"};
  for (int law = 0; law < SDR_LAW_COUNT; ++law) {
    sdr_built silent, watched;
    scene_build(&silent, ring, laws[law]);
    scene_build(&watched, ring, laws[law]);
    double *values = sdr_alloc((size_t)silent.points->count, 3 * sizeof *values);
    run_start(&silent);
    run_start(&watched);
    for (int n = 0; n < 100; ++n) {
      sdr_balance balance;
      run_step(&silent);
      run_step(&watched);
      sdr_system_balance(watched.system, &balance);
      for (int k = 0; k < 4; ++k)
        assert_int_equal(sdr_system_field(watched.system, fields[k], values), SDR_OK);
    }
    expect_same_bits(silent.points, silent.system->u, watched.system->u);
    expect_same_bits(silent.points, silent.system->f, watched.system->f);
    sdr_free(values);
    sdr_built_destroy(&silent);
    sdr_built_destroy(&watched);
  }
}

/* ---- neighbourhoods and index lists ---------------------------------------------------------- */

/* Explicit runs on a lattice hold neither neighbourhood nor index lists nor a Jacobian: all that
   their build ever holds is less than the neighbourhood alone would be. */
static void lattices_are_built_without_neighbourhood(void **state)
{
  (void)state;
  sdr_built built;
  const size_t before = sdr_memory_now();
  scene_build(
      &built,
      "dimension: 3d\n"
      "points: {shape: {box: {from: [0, 0, 0], to: [24 mm, 24 mm, 24 mm]}}, spacing: 1 mm}\n"
      "material: {young: 70 GPa, density: 2500 kg/m^3}\n"
      "time: {end: 1 us}\n");
  const size_t held = sdr_memory_now() - before;
  sdr_neighbourhood near;
  const size_t start = sdr_memory_now();
  assert_int_equal(sdr_neighbourhood_create(built.points, &near), SDR_OK);
  const size_t neighbourhood = sdr_memory_now() - start;
  assert_int_equal(near.row[built.points->count], built.model->bonds);
  assert_true(built.bonds->loose.slot_count == 0);
  print_message("held %.1f MB; a neighbourhood alone takes %.1f MB\n", (double)held * 1e-6,
                (double)neighbourhood * 1e-6);
  assert_true(held < neighbourhood);
  sdr_neighbourhood_destroy(&near);
  sdr_built_destroy(&built);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(shared_moduli_need_no_coefficients_a_point),
      cmocka_unit_test(bodies_without_cuts_need_no_look_at_flags),
      cmocka_unit_test(no_damage_law_keeps_no_history),
      cmocka_unit_test(plane_bodies_have_no_third_component),
      cmocka_unit_test(energies_and_fields_change_no_bit_of_the_run),
      cmocka_unit_test(lattices_are_built_without_neighbourhood),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
