/* The non-ordinary model against its equations written plainly: forces, energies, tangents, marks,
   storage, threads, and what it refuses. */
#include "mechanics/nonordinary_internal.h"
#include "support/elements.h"
#include "support/nonordinary.h"

typedef struct {
  const char *name;
  body_how shape;
  sdr_split split;
} form;

/* Bodies of every dimension and storage; horizons, moduli and materials vary. */
static const form forms[] = {
    {"1-D", {.dimension = SDR_1D, .cells = {30}, .scatter = 0.1}, SDR_SPLIT_SPECTRAL},
    {"plane stress",
     {.dimension = SDR_PLANE_STRESS, .cells = {10, 8}, .two_materials = 1, .scatter = 0.1},
     SDR_SPLIT_DILATATION},
    {"turned plane strain",
     {.dimension = SDR_PLANE_STRAIN,
      .cells = {9, 9},
      .angle = 0.3,
      .weight = {.correction = SDR_CORRECTION_ISO, .state_based = 1}},
     SDR_SPLIT_SPECTRAL},
    {"jittered plane stress",
     {.dimension = SDR_PLANE_STRESS, .cells = {9, 9}, .jitter = 0.3, .horizon_spread = 0.3},
     SDR_SPLIT_SPECTRAL},
    {"3-D", {.dimension = SDR_3D, .cells = {5, 4, 4}, .ratio = 1.8}, SDR_SPLIT_SPECTRAL},
    {"jittered 3-D",
     {.dimension = SDR_3D, .cells = {5, 4, 4}, .ratio = 2.1, .jitter = 0.2, .horizon_spread = 0.1},
     SDR_SPLIT_DILATATION},
};
enum { FORMS = sizeof forms / sizeof *forms };
static const sdr_elasticity laws[] = {SDR_LINEAR, SDR_SAINT_VENANT_KIRCHHOFF, SDR_NEO_HOOKEAN};

static nonordinary_how how_of(int form_index, int law, sdr_law damage)
{
  nonordinary_how how = {.shape = forms[form_index].shape,
                         .elasticity = laws[law],
                         .split = forms[form_index].split,
                         .strain = 0.05};
  how.shape.law = damage;
  return how;
}

/* Strains of mixed signs about `size`, noise of a tenth of it, a turn. */
static void deform(const nonordinary *b, double size, double turn, uint64_t seed,
                   double *const u[3])
{
  const double g[9] = {size,       0.3 * size - turn, 0.1 * size, turn,      -0.4 * size,
                       0.2 * size, -0.1 * size,       0.1 * size, 0.6 * size};
  double *extra[3];
  vector_create(b->shape.points, extra);
  vector_noise(b->shape.points, 0.1 * size * body_spacing, seed, extra);
  vector_linear(b->shape.points, g, u);
  vector_add(b->shape.points, u, 1.0, extra, u);
  vector_destroy(extra);
}

static int cut_low(const void *context, const double a[3], const double b[3])
{
  (void)context;
  const double plane = 0.6 * body_spacing;
  if (fmax(a[1], b[1]) > 0.3 * body_spacing) return 0;
  return (a[0] > plane) != (b[0] > plane) ? SDR_CUT : 0;
}

static void for_all(void (*check)(const nonordinary_how *))
{
  for (int k = 0; k < FORMS; ++k)
    for (int law = 0; law < 3; ++law)
      for (int damage = 0; damage < 2; ++damage) {
        const nonordinary_how how = how_of(k, law, damage ? SDR_LAW_VARIATIONAL : SDR_LAW_NONE);
        check(&how);
      }
}

/* ---- against the plain equations ------------------------------------------------------------- */

static void compare_with_plain(const nonordinary *b, plain_body *plain, double *const u[3],
                               int commit)
{
  sdr_energies own, expected;
  double *f[3], *g[3];
  vector_create(b->shape.points, f);
  vector_create(b->shape.points, g);
  b->shape.model->ops->energies(b->shape.model, u, &own);
  if (commit)
    b->shape.model->ops->force_commit(b->shape.model, u, NULL, 0.0, f);
  else
    b->shape.model->ops->force(b->shape.model, u, f);
  plain_force(plain, u, g, &expected, commit);
  const double largest = vector_largest(b->shape.points, g);
  assert_true(largest > 0.0);
  assert_at_most(vector_difference(b->shape.points, f, g) / largest, 1e-11);
  assert_near(own.stored, expected.stored, 1e-12 * expected.stored);
  assert_near(own.dissipated, expected.dissipated, 1e-11 * expected.stored);
  vector_destroy(f);
  vector_destroy(g);
}

static void check_plain(const nonordinary_how *how)
{
  nonordinary b = nonordinary_create(how);
  plain_body plain = plain_create(&b);
  double *u[3];
  vector_create(b.shape.points, u);
  if (b.shape.points->components == 2) plain_mark(&plain, cut_low);
  deform(&b, 0.04, how->elasticity == SDR_LINEAR ? 0.0 : 0.5, 3, u);
  compare_with_plain(&b, &plain, u, 0);
  compare_with_plain(&b, &plain, u, 1);
  deform(&b, 0.02, 0.0, 4, u); /* unloading, with damage */
  compare_with_plain(&b, &plain, u, 1);
  deform(&b, -0.07, 0.0, 5, u);
  compare_with_plain(&b, &plain, u, 0);
  vector_destroy(u);
  plain_destroy(&plain);
  nonordinary_destroy(&b);
}

static void kernels_do_what_the_equations_say(void **state)
{
  (void)state;
  for_all(check_plain);
}

/* ---- derivatives ----------------------------------------------------------------------------- */

static double energy_of(const nonordinary *b, double *const u[3])
{
  sdr_energies e;
  b->shape.model->ops->energies(b->shape.model, u, &e);
  return e.stored + e.dissipated;
}

/* Force against differences of sixth order, at every seventh point. */
static void compare_with_slope(const nonordinary *b, double *const u[3])
{
  static const double at[6] = {-3, -2, -1, 1, 2, 3}, of[6] = {-1, 9, -45, 45, -9, 1};
  const double h = 2e-4 * body_spacing;
  double *f[3];
  vector_create(b->shape.points, f);
  b->shape.model->ops->force(b->shape.model, u, f);
  const double largest = vector_largest(b->shape.points, f);
  for (int a = 0; a < b->shape.points->components; ++a)
    for (int32_t i = 0; i < b->shape.points->count; i += 7) {
      const double there = u[a][i];
      double slope = 0.0;
      for (int k = 0; k < 6; ++k) {
        u[a][i] = there + at[k] * h;
        slope += of[k] / (60.0 * h) * energy_of(b, u);
      }
      u[a][i] = there;
      assert_near(-slope, f[a][i], 1e-8 * largest);
    }
  vector_destroy(f);
}

/* Tangent against differences of the force; symmetric; its diagonal blocks. */
static void compare_tangent(const nonordinary *b, double *const u[3])
{
  static const double at[6] = {-3, -2, -1, 1, 2, 3}, of[6] = {-1, 9, -45, 45, -9, 1};
  const double h = 1e-4 * body_spacing;
  const sdr_points *points = b->shape.points;
  double *v[3], *w[3], *f[3], *slope[3], *other[3];
  double **const all[5] = {v, w, f, slope, other};
  for (int k = 0; k < 5; ++k) vector_create(points, all[k]);
  vector_noise(points, 1.0, 71, v);
  vector_noise(points, 1.0, 72, w);
  for (int k = 0; k < 6; ++k) {
    vector_add(points, u, at[k] * h, v, other);
    b->shape.model->ops->force(b->shape.model, other, f);
    vector_add(points, slope, -of[k] / (60.0 * h), f, slope);
  }
  assert_int_equal(b->shape.model->ops->tangent_times(b->shape.model, u, v, f), SDR_OK);
  const double largest = vector_largest(points, f);
  assert_at_most(vector_difference(points, f, slope) / largest, 1e-7);
  const double there = vector_dot(points, f, w);
  assert_int_equal(b->shape.model->ops->tangent_times(b->shape.model, u, w, other), SDR_OK);
  assert_near(vector_dot(points, other, v), there, 1e-12 * largest * points->count);
  for (int k = 0; k < 5; ++k) vector_destroy(all[k]);
}

static void check_derivatives(const nonordinary_how *how)
{
  nonordinary b = nonordinary_create(how);
  double *u[3];
  int64_t cut;
  vector_create(b.shape.points, u);
  if (b.shape.points->components == 2)
    assert_int_equal(b.shape.model->ops->mark(b.shape.model, cut_low, NULL, &cut), SDR_OK);
  deform(&b, 0.04, how->elasticity == SDR_LINEAR ? 0.0 : 0.5, 3, u);
  compare_with_slope(&b, u); /* damage grows */
  compare_tangent(&b, u);
  b.shape.model->ops->commit(b.shape.model, u);
  deform(&b, 0.02, 0.0, 4, u); /* less than before */
  compare_with_slope(&b, u);
  compare_tangent(&b, u);
  vector_destroy(u);
  nonordinary_destroy(&b);
}

/* Families that have lost bonds, some with fading moduli. */
static void torn_families_have_exact_slopes(void **state)
{
  (void)state;
  for (int k = 1; k < FORMS; ++k) /* in 1-D the same strain would break all */
    for (int law = 0; law < 3; ++law) {
      const nonordinary_how how = how_of(k, law, SDR_LAW_CRITICAL_STRETCH);
      nonordinary b = nonordinary_create(&how);
      const sdr_nonordinary_model *model = (const sdr_nonordinary_model *)b.shape.model;
      double *u[3], faded = 1.0;
      vector_create(b.shape.points, u);
      for (uint64_t seed = 3; seed < 40 && faded >= 1.0; ++seed) {
        deform(&b, 0.02 * (double)seed, 0.0, seed, u);
        b.shape.model->ops->commit(b.shape.model, u);
        for (int32_t i = 0; i < b.shape.points->count; ++i)
          faded = fmin(faded, model->mu[i] / model->whole_mu[i]);
      }
      assert_true(faded < 1.0);
      deform(&b, 0.03, 0.0, 4, u);
      compare_with_slope(&b, u);
      compare_tangent(&b, u);
      vector_destroy(u);
      nonordinary_destroy(&b);
    }
}

static void force_and_tangent_are_slopes_of_the_energy(void **state)
{
  (void)state;
  for_all(check_derivatives);
}

/* Sum of the parts of the Hessian, dense. */
typedef struct {
  int n, size;
  double *matrix;
} dense;

static void add_block(void *context, int count, const int32_t *point, const double *block)
{
  const dense *to = context;
  const int n = to->n, wide = n * count;
  for (int r = 0; r < wide; ++r)
    for (int c = 0; c < wide; ++c)
      to->matrix[(n * point[r / n] + r % n) * to->size + n * point[c / n] + c % n] +=
          block[r * wide + c];
}

static void check_hessian(const nonordinary_how *how)
{
  nonordinary b = nonordinary_create(how);
  const sdr_points *points = b.shape.points;
  const int n = points->components, size = n * points->count;
  dense full = {n, size, sdr_alloc((size_t)(size * size), sizeof(double))};
  double *diagonal = sdr_alloc((size_t)(size * n), sizeof(double)), *u[3], *v[3], *out[3];
  vector_create(points, u);
  vector_create(points, v);
  vector_create(points, out);
  deform(&b, 0.04, 0.0, 3, u);
  vector_noise(points, 1.0, 5, v);
  const sdr_model_ops *o = b.shape.model->ops;
  assert_int_equal(o->visit_hessian(b.shape.model, u, add_block, &full), SDR_OK);
  assert_int_equal(o->tangent_diagonal(b.shape.model, u, diagonal), SDR_OK);
  assert_int_equal(o->tangent_times(b.shape.model, u, v, out), SDR_OK);
  const double largest = vector_largest(points, out);
  for (int r = 0; r < size; ++r) {
    double sum = 0.0;
    for (int c = 0; c < size; ++c) sum += full.matrix[r * size + c] * v[c % n][c / n];
    assert_near(sum, out[r % n][r / n], 1e-12 * largest);
    for (int c = 0; c < n; ++c)
      assert_near(diagonal[r * n + c], full.matrix[r * size + r / n * n + c], 1e-13 * largest);
  }
  sdr_free(full.matrix);
  sdr_free(diagonal);
  vector_destroy(u);
  vector_destroy(v);
  vector_destroy(out);
  nonordinary_destroy(&b);
}

static void parts_of_the_hessian_make_the_tangent(void **state)
{
  (void)state;
  for (int k = 0; k < 4; ++k) {
    const nonordinary_how how = how_of(k, 1 + k % 2, SDR_LAW_VARIATIONAL);
    check_hessian(&how);
  }
}

static void the_secant_is_positive_and_the_tangent_at_rest(void **state)
{
  (void)state;
  for (int k = 0; k < FORMS; ++k)
    for (int law = 0; law < 3; ++law) {
      nonordinary_how how = how_of(k, law, SDR_LAW_VARIATIONAL);
      how.split = SDR_SPLIT_DILATATION;
      nonordinary b = nonordinary_create(&how);
      double *u[3];
      vector_create(b.shape.points, u);
      deform(&b, 0.06, 0.0, 3, u);
      elements_check_secant(b.shape.points, b.shape.model, u);
      vector_destroy(u);
      nonordinary_destroy(&b);
    }
}

/* The tangent for the stable step is the exact one of the body at rest. */
static void check_reference(const nonordinary_how *how)
{
  nonordinary b = nonordinary_create(how);
  const sdr_points *points = b.shape.points;
  double *u[3], *v[3], *exact[3], *out[3];
  double **const all[4] = {u, v, exact, out};
  for (int k = 0; k < 4; ++k) vector_create(points, all[k]);
  vector_noise(points, 1.0, 8, v);
  assert_int_equal(b.shape.model->ops->tangent_times(b.shape.model, u, v, exact), SDR_OK);
  b.shape.model->ops->reference_times(b.shape.model, v, out);
  assert_at_most(vector_difference(points, out, exact) / vector_largest(points, exact), 1e-12);
  for (int k = 0; k < 4; ++k) vector_destroy(all[k]);
  nonordinary_destroy(&b);
}

static void reference_tangent_is_that_of_the_body_at_rest(void **state)
{
  (void)state;
  for (int k = 0; k < FORMS; ++k)
    for (int law = 0; law < 3; ++law) {
      const nonordinary_how how = how_of(k, law, SDR_LAW_NONE);
      check_reference(&how);
    }
}

/* ---- storage, threads, rest ------------------------------------------------------------------ */

static void force_at(const nonordinary *b, double *const u[3], double *const f[3])
{
  b->shape.model->ops->force_commit(b->shape.model, u, NULL, 0.0, f);
}

static void loose_pairs_and_runs_give_the_same_forces_to_1e_13(void **state)
{
  (void)state;
  for (int k = 0; k < FORMS; ++k)
    for (int law = 0; law < 3; ++law) {
      if (forms[k].shape.jitter > 0.0) continue;
      nonordinary_how how = how_of(k, law, SDR_LAW_VARIATIONAL);
      nonordinary runs = nonordinary_create(&how);
      how.shape.force_loose = 1;
      nonordinary loose = nonordinary_create(&how);
      assert_true(runs.shape.bonds->run_count > 0 && loose.shape.bonds->run_count == 0);
      double *u[3], *f[3], *g[3];
      vector_create(runs.shape.points, u);
      vector_create(runs.shape.points, f);
      vector_create(runs.shape.points, g);
      deform(&runs, 0.04, 0.0, 3, u);
      force_at(&runs, u, f);
      force_at(&loose, u, g);
      assert_at_most(
          vector_difference(runs.shape.points, f, g) / vector_largest(runs.shape.points, f), 1e-13);
      vector_destroy(u);
      vector_destroy(f);
      vector_destroy(g);
      nonordinary_destroy(&runs);
      nonordinary_destroy(&loose);
    }
}

/* Same bits: with 1 and 3 threads, resting stripes skipped or not, a pulse in one corner. */
static void check_bits(const nonordinary_how *how)
{
  double *u[3] = {NULL}, *f[3] = {NULL}, *g[3] = {NULL};
  const int threads = sdr_threads();
  for (int trial = 0; trial < 3; ++trial) {
    nonordinary b = nonordinary_create(how);
    const sdr_points *points = b.shape.points;
    if (trial == 0) {
      vector_create(points, u);
      vector_create(points, f);
      vector_create(points, g);
      for (int a = 0; a < points->components; ++a)
        for (int32_t i = 0; i < points->count / 8; ++i) u[a][i] = 1e-3 * body_spacing * (i % 5 - 1);
    }
    sdr_set_threads(trial == 1 ? 3 : 1);
    b.shape.model->ops->skip_rest(b.shape.model, trial < 2);
    force_at(&b, u, trial == 0 ? f : g);
    sdr_model_traits traits;
    b.shape.model->ops->traits(b.shape.model, &traits);
    assert_true(how->shape.jitter > 0.0 || traits.moved < 1.0);
    for (int a = 0; trial > 0 && a < points->components; ++a)
      assert_memory_equal(f[a], g[a], (size_t)points->count * sizeof(double));
    nonordinary_destroy(&b);
  }
  sdr_set_threads(threads);
  vector_destroy(u);
  vector_destroy(f);
  vector_destroy(g);
}

static void threads_and_skipped_rest_change_no_bit(void **state)
{
  (void)state;
  for (int law = 0; law < 3; ++law) {
    nonordinary_how how = how_of(1, law, SDR_LAW_VARIATIONAL);
    how.shape.cells[1] = 100;
    check_bits(&how);
    how.shape.jitter = 0.2;
    check_bits(&how);
  }
}

/* ---- what it refuses ------------------------------------------------------------------------- */

static void a_row_of_points_in_the_plane_is_refused_by_name(void **state)
{
  (void)state;
  const body_how shape = {.dimension = SDR_PLANE_STRESS, .cells = {10, 1}};
  sdr_points *points = body_points(&shape, NULL);
  sdr_bonds *bonds;
  sdr_model *model = NULL;
  const sdr_bonds_how bonds_how = {0};
  assert_int_equal(sdr_bonds_create(points, &bonds_how, &bonds), SDR_OK);
  double young[64];
  const double poisson[2] = {0.3, 0.3}, toughness[2] = {1.0, 1.0};
  for (int k = 0; k < 64; ++k) young[k] = body_young;
  const sdr_state_based_how how = {.dimension = SDR_PLANE_STRESS,
                                   .control_shear = (double)NAN,
                                   .control_normal = (double)NAN,
                                   .young = young,
                                   .poisson = poisson,
                                   .toughness = toughness};
  assert_int_equal(sdr_nonordinary_create(points, bonds, &how, &model), SDR_BAD_INPUT);
  assert_null(model);
  assert_string_equal(sdr_error_message(),
                      "the non-ordinary model cannot tell strains at point 0, (-0.00225, 0, 0) m: "
                      "its neighbours lie (almost) in a line; take a larger horizon or more points "
                      "across");
  sdr_points_destroy(&points);
}

static void a_control_without_stiffness_is_refused(void **state)
{
  (void)state;
  const body_how shape = {.dimension = SDR_PLANE_STRESS, .cells = {8, 8}};
  sdr_points *points = body_points(&shape, NULL);
  sdr_bonds *bonds;
  sdr_model *model = NULL;
  const sdr_bonds_how bonds_how = {0};
  assert_int_equal(sdr_bonds_create(points, &bonds_how, &bonds), SDR_OK);
  double young[128];
  const double poisson[2] = {0.3, 0.3}, toughness[2] = {1.0, 1.0};
  for (int k = 0; k < 128; ++k) young[k] = body_young;
  const sdr_state_based_how how = {.dimension = SDR_PLANE_STRESS,
                                   .control_shear = 1e9,
                                   .control_normal = -2e9,
                                   .young = young,
                                   .poisson = poisson,
                                   .toughness = toughness};
  assert_int_equal(sdr_nonordinary_create(points, bonds, &how, &model), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "the zero-energy control needs shear >= 0 and shear + normal >= 0, not 1e+09 "
                      "Pa and -2e+09 Pa");
  sdr_points_destroy(&points);
}

/* Every allocation of the creation fails once: an error, and nothing is left behind. */
static void a_failing_allocator_leaves_nothing_behind(void **state)
{
  (void)state;
  const body_how shape = {.dimension = SDR_PLANE_STRESS, .cells = {8, 8}};
  sdr_points *points = body_points(&shape, NULL);
  double young[128];
  const double poisson[2] = {0.3, 0.3}, toughness[2] = {1.0, 1.0};
  for (int k = 0; k < 128; ++k) young[k] = body_young;
  const sdr_state_based_how how = {.dimension = SDR_PLANE_STRESS,
                                   .law = SDR_LAW_CRITICAL_STRETCH,
                                   .control_shear = (double)NAN,
                                   .control_normal = (double)NAN,
                                   .young = young,
                                   .poisson = poisson,
                                   .toughness = toughness};
  const size_t before = sdr_memory_now();
  sdr_status status = SDR_RUN_FAILED;
  for (long k = 0; status != SDR_OK; ++k) {
    const sdr_bonds_how bonds_how = {0};
    sdr_bonds *bonds;
    sdr_model *model = NULL;
    assert_int_equal(sdr_bonds_create(points, &bonds_how, &bonds), SDR_OK);
    sdr_memory_fail_after(k);
    status = sdr_nonordinary_create(points, bonds, &how, &model);
    sdr_memory_fail_after(-1);
    if (status == SDR_OK) model->ops->destroy(model);
    assert_true(status == SDR_OK || status == SDR_RUN_FAILED);
    assert_int_equal(sdr_memory_now(), before);
    assert_true(k < 100);
  }
  sdr_points_destroy(&points);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(kernels_do_what_the_equations_say),
      cmocka_unit_test(torn_families_have_exact_slopes),
      cmocka_unit_test(force_and_tangent_are_slopes_of_the_energy),
      cmocka_unit_test(parts_of_the_hessian_make_the_tangent),
      cmocka_unit_test(the_secant_is_positive_and_the_tangent_at_rest),
      cmocka_unit_test(reference_tangent_is_that_of_the_body_at_rest),
      cmocka_unit_test(loose_pairs_and_runs_give_the_same_forces_to_1e_13),
      cmocka_unit_test(threads_and_skipped_rest_change_no_bit),
      cmocka_unit_test(a_row_of_points_in_the_plane_is_refused_by_name),
      cmocka_unit_test(a_control_without_stiffness_is_refused),
      cmocka_unit_test(a_failing_allocator_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
