/* mechanics: making a bond-based body, marking its pairs, and what it says of itself. */
#include "damage/laws.h"
#include "support/reference.h"

static const body_how shapes[] = {
    {.dimension = SDR_PLANE_STRESS, .cells = {20, 9}, .law = SDR_LAW_VARIATIONAL},
    {.dimension = SDR_PLANE_STRESS,
     .cells = {20, 9},
     .law = SDR_LAW_CRITICAL_STRETCH,
     .scatter = 0.1},
    {.dimension = SDR_PLANE_STRESS, .cells = {20, 9}, .law = SDR_LAW_NONE},
    {.dimension = SDR_PLANE_STRESS,
     .cells = {12, 9},
     .jitter = 0.2,
     .horizon_spread = 0.3,
     .law = SDR_LAW_VARIATIONAL},
    {.dimension = SDR_3D, .cells = {9, 5, 5}, .force_loose = 1, .law = SDR_LAW_CRITICAL_STRETCH},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static void cut_bonds_are_counted_by_direction(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body b = body_create(&shapes[k]);
    reference r = reference_create(&b);
    int64_t cut, expected = 0;
    reference_mark(&r, body_cut_and_protect);
    assert_int_equal(b.model->ops->mark(b.model, body_cut_and_protect, NULL, &cut), SDR_OK);
    double *u[3];
    vector_create(b.points, u);
    for (int32_t i = 0; i < b.points->count; ++i)
      for (int32_t j = 0; j < b.points->count; ++j) {
        if (reference_far(&r, i, j)) continue;
        const reference_pair p = reference_kinematics(b.points, u, i, j);
        expected += reference_in_family(b.points, i, p.xi) &&
                    r.mark[(size_t)i * (size_t)b.points->count + (size_t)j] == SDR_CUT;
      }
    assert_int_equal(cut, expected);
    vector_destroy(u);
    reference_destroy(&r);
    body_destroy(&b);
  }
}

static int nothing(const void *context, const double a[3], const double b[3])
{
  (void)context;
  (void)a;
  (void)b;
  return 0;
}

static void a_mark_that_meets_nothing_changes_nothing(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body plain = body_create(&shapes[k]), marked = body_create(&shapes[k]);
    double *u[3], *f[3], *g[3];
    int64_t cut = -1;
    vector_create(plain.points, u);
    vector_create(plain.points, f);
    vector_create(plain.points, g);
    assert_int_equal(marked.model->ops->mark(marked.model, nothing, NULL, &cut), SDR_OK);
    assert_int_equal(cut, 0);
    vector_noise(plain.points, 0.02 * body_spacing, 3, u);
    plain.model->ops->force(plain.model, u, f);
    marked.model->ops->force(marked.model, u, g);
    assert_near(vector_difference(plain.points, f, g), 0.0, 0.0);
    vector_destroy(u);
    vector_destroy(f);
    vector_destroy(g);
    body_destroy(&plain);
    body_destroy(&marked);
  }
}

static void a_force_without_commit_leaves_no_trace(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body b = body_create(&shapes[k]);
    double *u[3], *f[3];
    sdr_energies before, after;
    vector_create(b.points, u);
    vector_create(b.points, f);
    b.model->ops->energies(b.model, u, &before);
    vector_noise(b.points, 0.1 * body_spacing, 3, u);
    b.model->ops->force(b.model, u, f);
    b.model->ops->energies(b.model, u, &after);
    for (int a = 0; a < b.points->components; ++a)
      memset(u[a], 0, (size_t)b.points->count * sizeof(double));
    b.model->ops->energies(b.model, u, &after);
    assert_memory_equal(&before, &after, sizeof before);
    vector_destroy(u);
    vector_destroy(f);
    body_destroy(&b);
  }
}

static void a_body_says_what_it_keeps(void **state)
{
  (void)state;
  body_how how = shapes[0];
  body b = body_create(&how);
  const size_t slots = (size_t)b.bonds->run_slots;
  assert_int_equal(body_traits(b.model).history_bytes, slots * sizeof(float));
  assert_int_equal(body_traits(b.model).shared_moduli, 1);
  assert_ptr_equal(body_traits(b.model).bonds, b.bonds);
  assert_int_equal(b.model->bonds, b.bonds->directed);
  assert_string_equal(body_traits(b.model).name, "bond_based");
  body_destroy(&b);

  how.law = SDR_LAW_CRITICAL_STRETCH;
  how.scatter = 0.1;
  b = body_create(&how);
  assert_int_equal(body_traits(b.model).history_bytes, slots * sizeof(sdr_flags));
  assert_int_equal(body_traits(b.model).shared_moduli, 0);
  body_destroy(&b);

  how.law = SDR_LAW_NONE;
  b = body_create(&how);
  assert_int_equal(body_traits(b.model).history_bytes, 0);
  body_destroy(&b);
}

/* The body takes its bonds over, also where it fails. */
static sdr_status create_with(const body *parts, long successes, sdr_model **out)
{
  const sdr_bonds_how bonds_how = {.force_loose = parts->how.force_loose};
  const sdr_bond_based_how how = {.dimension = parts->how.dimension,
                                  .law = parts->how.law,
                                  .ell = {1.0, 1},
                                  .young = parts->young,
                                  .toughness = parts->toughness};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(parts->points, &bonds_how, &bonds), SDR_OK);
  sdr_memory_fail_after(successes);
  const sdr_status status = sdr_bond_based_create(parts->points, bonds, parts->families, &how, out);
  sdr_memory_fail_after(-1);
  return status;
}

static void every_failing_allocation_is_reported(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body parts = body_create(&shapes[k]);
    const size_t before = sdr_memory_now();
    long fails = 0;
    for (; fails < 50; ++fails) {
      sdr_model *model = NULL;
      const sdr_status status = create_with(&parts, fails, &model);
      if (status == SDR_OK) {
        model->ops->destroy(model);
        break;
      }
      assert_int_equal(status, SDR_RUN_FAILED);
      assert_null(model);
      assert_int_equal(sdr_memory_now(), before);
    }
    assert_true(fails >= 1 && fails < 50);
    assert_int_equal(sdr_memory_now(), before);
    body_destroy(&parts);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cut_bonds_are_counted_by_direction),
      cmocka_unit_test(a_mark_that_meets_nothing_changes_nothing),
      cmocka_unit_test(a_force_without_commit_leaves_no_trace),
      cmocka_unit_test(a_body_says_what_it_keeps),
      cmocka_unit_test(every_failing_allocation_is_reported),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
