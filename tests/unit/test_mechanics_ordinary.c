/* mechanics: making an ordinary state-based body, marking its pairs, what it says of itself and
   what a checkpoint holds. */
#include "damage/laws.h"
#include "support/ordinary.h"

static const ordinary_how shapes[] = {
    {.body = {.dimension = SDR_PLANE_STRESS, .cells = {20, 9}, .law = SDR_LAW_VARIATIONAL}},
    {.body = {.dimension = SDR_PLANE_STRESS, .cells = {20, 9}, .law = SDR_LAW_CRITICAL_STRETCH},
     .form = SDR_FORM_MADENCI_OTERKUS},
    {.body = {.dimension = SDR_1D, .cells = {20}, .law = SDR_LAW_NONE}},
    {.body = {.dimension = SDR_PLANE_STRAIN,
              .cells = {12, 9},
              .jitter = 0.2,
              .horizon_spread = 0.3,
              .law = SDR_LAW_CRITICAL_STRETCH}},
    {.body = {.dimension = SDR_PLANE_STRAIN,
              .cells = {12, 12},
              .jitter = 0.2,
              .law = SDR_LAW_VARIATIONAL}},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static sdr_status make(const ordinary_how *how, double poisson, sdr_model **out)
{
  body parts = ordinary_create(how);
  const sdr_bonds_how bonds_how = {.force_loose = how->body.force_loose};
  const sdr_state_based_how model_how = {.dimension = how->body.dimension,
                                         .law = how->body.law,
                                         .form = how->form,
                                         .young = parts.young,
                                         .poisson = &poisson,
                                         .toughness = parts.toughness};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(parts.points, &bonds_how, &bonds), SDR_OK);
  const sdr_status status = sdr_ordinary_create(parts.points, bonds, &model_how, out);
  if (status == SDR_OK) (*out)->ops->destroy(*out);
  body_destroy(&parts);
  return status;
}

static void a_ratio_without_a_body_is_refused(void **state)
{
  (void)state;
  static const double bad[] = {0.5, 0.7, -1.0};
  sdr_model *model;
  for (int k = 0; k < 3; ++k) {
    char expected[128];
    assert_int_equal(make(&shapes[0], bad[k], &model), SDR_BAD_INPUT);
    snprintf(expected, sizeof expected,
             "a state-based body needs a Poisson's ratio above -1 and below 0.5, not %g", bad[k]);
    assert_string_equal(sdr_error_message(), expected);
  }
  assert_int_equal(make(&shapes[0], (double)NAN, &model), SDR_BAD_INPUT);
  assert_int_equal(make(&shapes[2], (double)NAN, &model), SDR_OK); /* a bar has none */
}

static void the_printed_form_is_refused_outside_the_plane(void **state)
{
  (void)state;
  sdr_model *model;
  ordinary_how how = {.body = {.dimension = SDR_3D, .cells = {4, 4, 4}}};
  assert_int_equal(make(&how, 0.2, &model), SDR_OK);
  body parts = ordinary_create(&how);
  const double poisson = 0.2;
  const sdr_bonds_how bonds_how = {.force_loose = 0};
  const sdr_state_based_how model_how = {.dimension = SDR_3D,
                                         .form = SDR_FORM_MADENCI_OTERKUS,
                                         .young = parts.young,
                                         .poisson = &poisson,
                                         .toughness = parts.toughness};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(parts.points, &bonds_how, &bonds), SDR_OK);
  assert_int_equal(sdr_ordinary_create(parts.points, bonds, &model_how, &model), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "material.form madenci_oterkus exists in plane_stress and plane_strain "
                      "only; leave it out to take the standard form");
  body_destroy(&parts);
}

static void constants_are_those_of_the_plane_state(void **state)
{
  (void)state;
  const double e = 10.0, nu = 0.25, lambda = e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const double g = e / (2.0 * (1.0 + nu));
  assert_near(sdr_state_shear(SDR_3D, e, nu), g, 1e-14);
  assert_near(sdr_state_bulk(SDR_3D, e, nu), lambda + 2.0 / 3.0 * g, 1e-14);
  assert_near(sdr_state_bulk(SDR_PLANE_STRAIN, e, nu), lambda + g, 1e-14);
  /* sigma_zz = 0 takes lambda^2/(lambda + 2 G) away */
  assert_near(sdr_state_bulk(SDR_PLANE_STRESS, e, nu),
              lambda + g - lambda * lambda / (lambda + 2.0 * g), 1e-14);
  assert_near(sdr_state_bulk(SDR_1D, e, nu), e, 0.0);
}

static void ell_is_given_or_the_band_that_a_cut_damages(void **state)
{
  (void)state;
  ordinary_how how = shapes[0];
  double ell, threshold;
  body b = ordinary_create(&how);
  sdr_state_constants(b.model, 0, &ell, &threshold);
  /* a cut along an axis damages 3 rows on both sides */
  assert_near(ell, 6.0 / 1.04 * body_spacing, 1e-12 * body_spacing);
  assert_true(isnan(threshold));
  body_destroy(&b);
  how.body.ell = 1.5;
  b = ordinary_create(&how);
  sdr_state_constants(b.model, 0, &ell, &threshold);
  assert_near(ell, 1.5 * 3.015 * body_spacing, 1e-12 * body_spacing);
  body_destroy(&b);
  b = ordinary_create(&shapes[4]); /* families of irregular points end before the horizon */
  sdr_state_constants(b.model, 0, &ell, &threshold);
  assert_true(ell < 1.98 * 3.015 * body_spacing && ell > 1.7 * 3.015 * body_spacing);
  body_destroy(&b);
  b = ordinary_create(&shapes[1]);
  sdr_state_constants(b.model, 0, &ell, &threshold);
  assert_true(isnan(ell));
  assert_near(threshold, 1e-4, 1e-15);
  body_destroy(&b);
}

static void a_point_says_what_it_has_lost(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body b = ordinary_create(&shapes[k]);
    const size_t count = (size_t)b.points->count;
    double *u[3], *damage = sdr_alloc(count, sizeof *damage);
    int64_t cut;
    vector_create(b.points, u);
    assert_int_equal(b.model->ops->mark(b.model, body_cut_and_protect, NULL, &cut), SDR_OK);
    assert_true(cut > 0);
    assert_int_equal(b.model->ops->field(b.model, u, SDR_FIELD_DAMAGE, damage), SDR_OK);
    double most = 0.0;
    for (size_t i = 0; i < count; ++i) most = fmax(most, damage[i]);
    /* variational: damage of the point; else the share of its bonds */
    assert_true(shapes[k].body.law == SDR_LAW_VARIATIONAL ? most <= 0.0 : most > 0.2);
    sdr_energies e;
    b.model->ops->energies(b.model, u, &e);
    assert_int_equal(e.broken, 0); /* cut bonds do not count */
    assert_near(e.max_damage, 0.0, 0.0);
    sdr_free(damage);
    vector_destroy(u);
    body_destroy(&b);
  }
}

static void note_damage(void *context, int32_t i, int32_t j, double damage)
{
  double *most = context;
  (void)i;
  (void)j;
  assert_true(damage >= 0.0 && damage <= 1.0);
  ++most[0];
  most[1] = fmax(most[1], damage);
  most[2] += damage;
}

static void every_pair_is_visited_once_with_its_damage(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body b = ordinary_create(&shapes[k]);
    double *u[3], seen[3] = {0.0};
    vector_create(b.points, u);
    vector_noise(b.points, 0.05 * body_spacing, 3, u);
    b.model->ops->commit(b.model, u);
    b.model->ops->visit_damage(b.model, u, note_damage, seen);
    assert_int_equal((int64_t)seen[0], b.bonds->pairs);
    sdr_energies e;
    b.model->ops->energies(b.model, u, &e);
    if (shapes[k].body.law == SDR_LAW_NONE) assert_near(seen[1], 0.0, 0.0);
    if (shapes[k].body.law == SDR_LAW_CRITICAL_STRETCH) {
      assert_near(seen[1], 1.0, 0.0);
      assert_true(e.broken > 0 && e.broken <= b.bonds->directed);
    }
    if (shapes[k].body.law == SDR_LAW_VARIATIONAL)
      assert_true(seen[1] > 0.5 && seen[1] <= e.max_damage);
    vector_destroy(u);
    body_destroy(&b);
  }
}

static void a_force_without_commit_leaves_no_trace(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body b = ordinary_create(&shapes[k]);
    double *u[3], *zero[3], *f[3];
    sdr_energies before, after;
    vector_create(b.points, u);
    vector_create(b.points, zero);
    vector_create(b.points, f);
    b.model->ops->energies(b.model, zero, &before);
    vector_noise(b.points, 0.1 * body_spacing, 3, u);
    b.model->ops->force(b.model, u, f);
    b.model->ops->energies(b.model, u, &after);
    b.model->ops->energies(b.model, zero, &after);
    assert_memory_equal(&before, &after, sizeof before);
    vector_destroy(u);
    vector_destroy(zero);
    vector_destroy(f);
    body_destroy(&b);
  }
}

/* Blocks copied into a fresh body give the same forces and energies, bit for bit. */
static void a_checkpoint_holds_the_whole_state(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body from = ordinary_create(&shapes[k]), to = ordinary_create(&shapes[k]);
    sdr_state_block a[SDR_STATE_BLOCKS], c[SDR_STATE_BLOCKS];
    double *u[3], *v[3], *f[3], *g[3];
    int first, second;
    vector_create(from.points, u);
    vector_create(from.points, v);
    vector_create(from.points, f);
    vector_create(from.points, g);
    vector_noise(from.points, 0.05 * body_spacing, 3, u);
    from.model->ops->force_commit(from.model, u, v, 1e-8, f);
    from.model->ops->state(from.model, a, &first);
    to.model->ops->state(to.model, c, &second);
    assert_int_equal(first, second);
    for (int n = 0; n < first; ++n) {
      assert_string_equal(a[n].name, c[n].name);
      assert_int_equal(a[n].bytes, c[n].bytes);
      memcpy(c[n].data, a[n].data, a[n].bytes);
    }
    vector_noise(from.points, 0.05 * body_spacing, 4, u);
    from.model->ops->force_commit(from.model, u, v, 1e-8, f);
    to.model->ops->force_commit(to.model, u, v, 1e-8, g);
    assert_near(vector_difference(from.points, f, g), 0.0, 0.0);
    sdr_energies e, h;
    from.model->ops->energies(from.model, u, &e);
    to.model->ops->energies(to.model, u, &h);
    assert_memory_equal(&e, &h, sizeof e);
    vector_destroy(u);
    vector_destroy(v);
    vector_destroy(f);
    vector_destroy(g);
    body_destroy(&from);
    body_destroy(&to);
  }
}

static void a_body_says_what_it_keeps(void **state)
{
  (void)state;
  body b = ordinary_create(&shapes[0]);
  sdr_model_traits traits = body_traits(b.model);
  assert_string_equal(traits.name, "ordinary");
  assert_ptr_equal(traits.bonds, b.bonds);
  assert_int_equal(traits.shared_moduli, 1);
  assert_int_equal(traits.mixed, 0);
  assert_int_equal(traits.history_bytes, (size_t)b.points->count * sizeof(double));
  assert_near(traits.moved, 0.0, 0.0);
  assert_int_equal(b.model->bonds, b.bonds->directed);
  body_destroy(&b);
}

static void every_failing_allocation_is_reported(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body parts = ordinary_create(&shapes[k]);
    const double poisson[2] = {0.3, 0.3};
    const sdr_state_based_how how = {.dimension = shapes[k].body.dimension,
                                     .law = shapes[k].body.law,
                                     .form = shapes[k].form,
                                     .young = parts.young,
                                     .poisson = poisson,
                                     .toughness = parts.toughness};
    const sdr_bonds_how bonds_how = {.force_loose = 0};
    const size_t before = sdr_memory_now();
    long fails = 0;
    for (; fails < 5000; ++fails) {
      sdr_bonds *bonds;
      sdr_model *model = NULL;
      assert_int_equal(sdr_bonds_create(parts.points, &bonds_how, &bonds), SDR_OK);
      sdr_memory_fail_after(fails);
      const sdr_status status = sdr_ordinary_create(parts.points, bonds, &how, &model);
      sdr_memory_fail_after(-1);
      if (status == SDR_OK) model->ops->destroy(model);
      assert_int_equal(sdr_memory_now(), before);
      if (status == SDR_OK) break;
      assert_int_equal(status, SDR_RUN_FAILED);
      assert_null(model);
    }
    assert_true(fails >= 10 && fails < 5000);
    body_destroy(&parts);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_ratio_without_a_body_is_refused),
      cmocka_unit_test(the_printed_form_is_refused_outside_the_plane),
      cmocka_unit_test(constants_are_those_of_the_plane_state),
      cmocka_unit_test(ell_is_given_or_the_band_that_a_cut_damages),
      cmocka_unit_test(a_point_says_what_it_has_lost),
      cmocka_unit_test(every_pair_is_visited_once_with_its_damage),
      cmocka_unit_test(a_force_without_commit_leaves_no_trace),
      cmocka_unit_test(a_checkpoint_holds_the_whole_state),
      cmocka_unit_test(a_body_says_what_it_keeps),
      cmocka_unit_test(every_failing_allocation_is_reported),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
