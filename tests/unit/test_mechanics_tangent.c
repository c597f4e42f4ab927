/* mechanics: the tangent stiffness as a matrix is that of tangent_times. */
#include "mechanics/tangent.h"
#include "support/ordinary.h"

/* A displacement that loads some bonds, unloads others and compresses many, beyond s_c. */
static void deform(const body *b, double *const u[3], double amplitude)
{
  const double gradient[9] = {0.6 * amplitude,  0.3 * amplitude, 0.0, -0.5 * amplitude,
                              -0.4 * amplitude, 0.2 * amplitude, 0.0, 0.1 * amplitude,
                              0.5 * amplitude};
  double *noisy[3];
  vector_create(b->points, noisy);
  vector_noise(b->points, 0.3 * amplitude * body_spacing, 5, noisy);
  vector_linear(b->points, gradient, u);
  vector_add(b->points, u, 1.0, noisy, u);
  vector_destroy(noisy);
}

/* Largest |A v - tangent_times(v)| over the largest |tangent_times(v)|, for two v. */
static double difference_from_product(const body *b, const sdr_csr *a, double *const u[3])
{
  const int m = b->points->components;
  const size_t unknowns = (size_t)(b->points->count * m);
  double *v[3], *wanted[3], worst = 0.0;
  double *x = sdr_alloc(unknowns, sizeof *x), *y = sdr_alloc(unknowns, sizeof *y);
  vector_create(b->points, v);
  vector_create(b->points, wanted);
  for (uint64_t seed = 7; seed < 9; ++seed) {
    vector_noise(b->points, 1.0, seed, v);
    assert_int_equal(b->model->ops->tangent_times(b->model, u, v, wanted), SDR_OK);
    for (int32_t i = 0; i < b->points->count; ++i)
      for (int c = 0; c < m; ++c) x[i * m + c] = v[c][i];
    sdr_csr_times(a, x, y);
    for (int32_t i = 0; i < b->points->count; ++i)
      for (int c = 0; c < m; ++c)
        worst = fmax(worst, fabs(y[i * m + c] - wanted[c][i]) / vector_largest(b->points, wanted));
  }
  vector_destroy(v);
  vector_destroy(wanted);
  sdr_free(x);
  sdr_free(y);
  return worst;
}

static double at(const sdr_csr *a, int32_t row, int32_t column)
{
  for (int64_t k = a->row[row]; k < a->row[row + 1]; ++k)
    if (a->column[k] == column) return a->value[k];
  return NAN; /* not in the pattern */
}

static void check_symmetric(const sdr_csr *a)
{
  double largest = 0.0; /* a diagonal entry may have nearly vanished */
  for (int32_t r = 0; r < a->rows; ++r) largest = fmax(largest, fabs(at(a, r, r)));
  for (int32_t r = 0; r < a->rows; ++r)
    for (int64_t k = a->row[r]; k < a->row[r + 1]; ++k) {
      if (k > a->row[r]) assert_true(a->column[k] > a->column[k - 1]);
      const double other = at(a, a->column[k], r);
      if (!(other == a->value[k])) /* the same bits but for the order of sums on the diagonal */
        assert_near(other, a->value[k], 1e-13 * largest);
    }
}

static void check(const body_how *how, double amplitude)
{
  body b = body_create(how);
  double *u[3];
  sdr_csr a = {0};
  int64_t cut;
  vector_create(b.points, u);
  if (how->dimension != SDR_1D && how->law != SDR_LAW_NONE)
    assert_int_equal(b.model->ops->mark(b.model, body_cut_and_protect, NULL, &cut), SDR_OK);
  deform(&b, u, amplitude);
  b.model->ops->commit(b.model, u);
  deform(&b, u, 0.8 * amplitude); /* off the kinks: unloading here, loading nowhere */
  for (int round = 0; round < 2; ++round) {
    assert_int_equal(sdr_tangent_assemble(b.model, u, &a), SDR_OK);
    assert_int_equal(a.rows, b.points->count * b.points->components);
    assert_at_most(difference_from_product(&b, &a, u), 1e-12);
    check_symmetric(&a);
    sdr_csr_destroy(&a);
    deform(&b, u, 1.7 * amplitude); /* and loading */
  }
  vector_destroy(u);
  body_destroy(&b);
}

static void the_matrix_is_that_of_the_product_in_every_dimension_and_law(void **state)
{
  (void)state;
  static const sdr_dimension dimensions[] = {SDR_1D, SDR_PLANE_STRESS, SDR_PLANE_STRAIN, SDR_3D};
  for (int d = 0; d < 4; ++d)
    for (int l = 0; l < SDR_LAW_COUNT; ++l)
      for (int jittered = 0; jittered < 2; ++jittered) {
        const body_how how = {.dimension = dimensions[d],
                              .cells = {11, 8, 7},
                              .ratio = dimensions[d] == SDR_3D ? 2.015 : 3.015,
                              .law = (sdr_law)l,
                              .jitter = jittered ? 0.3 : 0.0,
                              .horizon_spread = jittered ? 0.2 : 0.0,
                              .scatter = 0.2,
                              .two_materials = 1};
        check(&how, 0.01);
      }
}

/* Unbent bonds stiffen across themselves when they are stretched: at u = 0 only along. */
static void the_reference_matrix_is_that_of_the_reference_product(void **state)
{
  (void)state;
  const body_how how = {
      .dimension = SDR_PLANE_STRESS, .cells = {12, 9}, .weight.correction = SDR_CORRECTION_ISO};
  body b = body_create(&how);
  double *u[3], *v[3], *wanted[3];
  sdr_csr a = {0};
  vector_create(b.points, u);
  vector_create(b.points, v);
  vector_create(b.points, wanted);
  assert_int_equal(sdr_tangent_assemble(b.model, u, &a), SDR_OK);
  for (int32_t i = 0; i < 20; ++i)
    for (int c = 0; c < 2; ++c) { /* a column of the matrix at a time */
      vector_noise(b.points, 0.0, 1, v);
      v[c][i] = 1.0;
      b.model->ops->reference_times(b.model, v, wanted);
      const double largest = vector_largest(b.points, wanted);
      for (int32_t j = 0; j < b.points->count; ++j)
        for (int d = 0; d < 2; ++d) {
          const double here = at(&a, 2 * j + d, 2 * i + c);
          assert_near(isnan(here) ? 0.0 : here, wanted[d][j], 1e-12 * largest);
        }
    }
  sdr_csr_destroy(&a);
  vector_destroy(u);
  vector_destroy(v);
  vector_destroy(wanted);
  body_destroy(&b);
}

/* Loose pairs have two slots and count once. */
static void runs_and_loose_pairs_give_the_same_matrix(void **state)
{
  (void)state;
  body_how how = {.dimension = SDR_PLANE_STRESS, .cells = {9, 7}, .law = SDR_LAW_VARIATIONAL};
  sdr_csr a[2] = {{0}};
  for (int loose = 0; loose < 2; ++loose) {
    how.force_loose = loose;
    body b = body_create(&how);
    double *u[3];
    vector_create(b.points, u);
    deform(&b, u, 0.005);
    assert_int_equal(sdr_tangent_assemble(b.model, u, &a[loose]), SDR_OK);
    vector_destroy(u);
    body_destroy(&b);
  }
  assert_int_equal(a[0].row[a[0].rows], a[1].row[a[1].rows]);
  for (int32_t r = 0; r < a[0].rows; ++r)
    for (int64_t k = a[0].row[r]; k < a[0].row[r + 1]; ++k) {
      assert_int_equal(a[0].column[k], a[1].column[k]);
      assert_near(a[0].value[k], a[1].value[k], 1e-12 * fabs(at(&a[0], r, r)));
    }
  sdr_csr_destroy(&a[0]);
  sdr_csr_destroy(&a[1]);
}

static void a_failed_allocation_leaves_nothing_behind(void **state)
{
  (void)state;
  const body_how how = {.dimension = SDR_PLANE_STRESS, .cells = {7, 6}};
  body b = body_create(&how);
  double *u[3];
  vector_create(b.points, u);
  const size_t before = sdr_memory_now();
  int finished = 0;
  for (long successes = 0; successes < 60 && !finished; ++successes) {
    sdr_csr a = {0};
    sdr_memory_fail_after(successes);
    const sdr_status status = sdr_tangent_assemble(b.model, u, &a);
    sdr_memory_fail_after(-1);
    finished = status == SDR_OK;
    if (!finished) assert_int_equal(status, SDR_RUN_FAILED);
    if (!finished) assert_null(a.row);
    sdr_csr_destroy(&a);
    assert_int_equal(sdr_memory_now(), before);
  }
  assert_true(finished);
  vector_destroy(u);
  body_destroy(&b);
}

/* ---- many states ----------------------------------------------------------------------------- */

/* The values of an update are those of assembling: entries for entries that both have. */
static void check_update(const body *b, sdr_tangent *tangent, double *const u[3])
{
  sdr_csr wanted = {0};
  assert_int_equal(sdr_tangent_update(tangent, NULL, u), SDR_OK);
  assert_int_equal(sdr_tangent_assemble(b->model, u, &wanted), SDR_OK);
  const sdr_csr *made = sdr_tangent_matrix(tangent);
  assert_int_equal(made->rows, wanted.rows);
  for (int32_t r = 0; r < made->rows; ++r) {
    int64_t p = wanted.row[r];
    for (int64_t k = made->row[r]; k < made->row[r + 1]; ++k) {
      const int both = p < wanted.row[r + 1] && wanted.column[p] == made->column[k];
      assert_near(made->value[k], both ? wanted.value[p] : 0.0, 0.0);
      p += both;
    }
    assert_int_equal(p, wanted.row[r + 1]);
  }
  sdr_csr_destroy(&wanted);
}

/* Forth and back, with damage growing. */
static void check_updates(const body *b, double amplitude)
{
  sdr_tangent *tangent = NULL;
  double *u[3];
  vector_create(b->points, u);
  assert_int_equal(sdr_tangent_create(b->model, SDR_TANGENT_EXACT, &tangent), SDR_OK);
  for (int round = 0; round < 4; ++round) {
    deform(b, u, (round % 2 ? 0.3 : 1.0 + round) * amplitude);
    check_update(b, tangent, u);
    b->model->ops->commit(b->model, u);
  }
  sdr_tangent_destroy(&tangent);
  assert_null(tangent);
  vector_destroy(u);
}

static void an_update_gives_the_bits_of_assembling(void **state)
{
  (void)state;
  static const sdr_dimension dimensions[] = {SDR_1D, SDR_PLANE_STRESS, SDR_3D};
  for (int d = 0; d < 3; ++d)
    for (int jittered = 0; jittered < 2; ++jittered) {
      const body_how how = {.dimension = dimensions[d],
                            .cells = {9, 6, 5},
                            .ratio = dimensions[d] == SDR_3D ? 2.015 : 3.015,
                            .law = SDR_LAW_VARIATIONAL,
                            .jitter = jittered ? 0.3 : 0.0};
      body b = body_create(&how);
      check_updates(&b, 0.01);
      body_destroy(&b);
    }
}

/* Ordinary bodies leave out the bonds, and in the end the points, that have come apart. */
static void an_update_follows_families_that_shrink(void **state)
{
  (void)state;
  const ordinary_how how = {
      .body = {.dimension = SDR_PLANE_STRESS, .cells = {9, 7}, .law = SDR_LAW_CRITICAL_STRETCH}};
  body b = ordinary_create(&how);
  check_updates(&b, 0.01);
  sdr_energies energies;
  double *u[3];
  vector_create(b.points, u);
  b.model->ops->energies(b.model, u, &energies);
  assert_true(energies.broken > b.model->bonds / 4);
  vector_destroy(u);
  body_destroy(&b);
}

static void a_body_without_such_a_tangent_is_refused(void **state)
{
  (void)state;
  const ordinary_how how = {.body = {.dimension = SDR_PLANE_STRESS, .cells = {5, 4}}};
  body b = ordinary_create(&how);
  sdr_model_ops ops = *b.model->ops;
  const sdr_model_ops *own = b.model->ops;
  sdr_tangent *tangent = NULL;
  ops.visit_secant = NULL;
  ops.visit_mean_tangent = NULL;
  b.model->ops = &ops;
  assert_int_equal(sdr_tangent_create(b.model, SDR_TANGENT_SECANT, &tangent), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "the model ordinary has no secant stiffness");
  assert_int_equal(sdr_tangent_create(b.model, SDR_TANGENT_MEAN, &tangent), SDR_BAD_INPUT);
  assert_null(tangent);
  b.model->ops = own;
  body_destroy(&b);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_matrix_is_that_of_the_product_in_every_dimension_and_law),
      cmocka_unit_test(the_reference_matrix_is_that_of_the_reference_product),
      cmocka_unit_test(runs_and_loose_pairs_give_the_same_matrix),
      cmocka_unit_test(a_failed_allocation_leaves_nothing_behind),
      cmocka_unit_test(an_update_gives_the_bits_of_assembling),
      cmocka_unit_test(an_update_follows_families_that_shrink),
      cmocka_unit_test(a_body_without_such_a_tangent_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
