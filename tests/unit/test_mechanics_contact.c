/* mechanics: contact. Two pieces far apart at first, or one body whose bonds are lost, moved into
   each other; forces against a search over all pairs written down again here. */
#include "mechanics/contact.h"
#include "support/still_body.h"

static const double penalty = 0.25;

typedef struct {
  still_body still;
  sdr_material material;
  sdr_contact *contact;
} touching;

static void touching_create(body b, touching *t)
{
  still_of(b, &t->still);
  t->material = (sdr_material){.young = body_young, .poisson = 0.2};
  sdr_scene *scene = &t->still.scene;
  scene->material = &t->material;
  scene->material_count = 1;
  scene->contact = (sdr_contact_scene){.on = 1, .range = 1.0, .penalty = penalty};
  assert_int_equal(sdr_contact_create(scene, b.model, &t->contact), SDR_OK);
  assert_non_null(t->contact);
}

static void touching_destroy(touching *t)
{
  sdr_contact_destroy(&t->contact);
  still_destroy(&t->still);
}

/* Two blocks with five empty columns between them. */
static int keep_blocks(const int32_t cell[3])
{
  return cell[0] < 5 || cell[0] > 9;
}

/* Move what lies right of the middle by `way` to the left and a little up, all with noise. */
static void push_together(const body *b, double way, uint64_t seed, double *const u[3])
{
  const sdr_points *points = b->points;
  vector_noise(points, 0.05 * body_spacing, seed, u);
  for (int32_t i = 0; i < points->count; ++i) {
    if (points->x[0][i] < 0.0) continue;
    u[0][i] -= way;
    if (points->components > 1) u[1][i] += 0.3 * body_spacing;
  }
}

/* What the definition says, over all pairs with `bonded` 0. */
static double reference_force(const body *b, int (*bonded)(const body *, int32_t, int32_t),
                              double *const u[3], double *const f[3])
{
  const sdr_points *points = b->points;
  const int n = points->components;
  const double nu = n == 2 ? 1.0 / 3.0 : 0.25;
  const double modulus = n == 1   ? body_young
                         : n == 2 ? body_young / (1.0 - nu * nu)
                                  : body_young * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
  const double k = penalty * modulus * pow(body_spacing, n - 2);
  double energy = 0.0;
  for (int a = 0; a < n; ++a) memset(f[a], 0, (size_t)points->count * sizeof(double));
  for (int32_t i = 0; i < points->count; ++i)
    for (int32_t j = i + 1; j < points->count; ++j) {
      double way[3], square = 0.0;
      if (bonded(b, i, j)) continue;
      for (int a = 0; a < n; ++a) {
        way[a] = points->x[a][j] + u[a][j] - points->x[a][i] - u[a][i];
        square += way[a] * way[a];
      }
      const double overlap = body_spacing - sqrt(square);
      if (!(overlap > 0.0)) continue;
      energy += 0.5 * k * overlap * overlap;
      for (int a = 0; a < n; ++a) {
        f[a][i] -= k * overlap * way[a] / sqrt(square);
        f[a][j] += k * overlap * way[a] / sqrt(square);
      }
    }
  return energy;
}

static int same_side(const body *b, int32_t i, int32_t j)
{
  return (b->points->x[0][i] < 0.0) == (b->points->x[0][j] < 0.0);
}

static void zero(const sdr_points *points, double *const f[3])
{
  for (int a = 0; a < points->components; ++a)
    memset(f[a], 0, (size_t)points->count * sizeof(double));
}

/* Through many positions, near and far, so that lists are kept and made anew. */
static void check_blocks(const body_how *how)
{
  touching t;
  touching_create(body_create_kept(how, keep_blocks), &t);
  const body *b = &t.still.body;
  double *u[3], *f[3], *expected[3];
  vector_create(b->points, u);
  vector_create(b->points, f);
  vector_create(b->points, expected);
  sdr_contact_state now;
  for (int n = 0; n < 24; ++n) {
    const double way = (4.7 + 0.04 * n) * body_spacing;
    push_together(b, way, 50 + (uint64_t)n / 4, u);
    zero(b->points, f);
    assert_int_equal(sdr_contact_force(t.contact, u, f), SDR_OK);
    const double energy = reference_force(b, same_side, u, expected);
    const double most = vector_largest(b->points, expected);
    assert_at_most(vector_difference(b->points, f, expected), 1e-9 * most);
    assert_near(sdr_contact_energy(t.contact), energy, 1e-9 * energy);
    if (n > 12) assert_true(energy > 0.0);
  }
  sdr_contact_look(t.contact, &now);
  assert_in_range(now.searches, 2, 23);
  assert_true(now.closest < 0.9);
  vector_destroy(u);
  vector_destroy(f);
  vector_destroy(expected);
  touching_destroy(&t);
}

static void forces_are_those_of_all_pairs_that_were_never_bonded(void **state)
{
  (void)state;
  const body_how bars = {.dimension = SDR_1D, .cells = {15}};
  const body_how plates = {.dimension = SDR_PLANE_STRESS, .cells = {15, 40}, .angle = 0.2};
  const body_how blocks = {.dimension = SDR_3D, .cells = {15, 8, 7}, .force_loose = 1};
  check_blocks(&bars);
  check_blocks(&plates);
  check_blocks(&blocks);
}

static void momentum_and_torque_of_the_forces_vanish(void **state)
{
  (void)state;
  const body_how how = {.dimension = SDR_3D, .cells = {15, 8, 7}};
  touching t;
  touching_create(body_create_kept(&how, keep_blocks), &t);
  const sdr_points *points = t.still.body.points;
  double *u[3], *f[3], sum[3] = {0.0}, torque = 0.0, size = 0.0;
  vector_create(points, u);
  vector_create(points, f);
  push_together(&t.still.body, 5.3 * body_spacing, 7, u);
  assert_int_equal(sdr_contact_force(t.contact, u, f), SDR_OK);
  for (int32_t i = 0; i < points->count; ++i) {
    for (int a = 0; a < 3; ++a) sum[a] += f[a][i];
    torque += (points->x[0][i] + u[0][i]) * f[1][i] - (points->x[1][i] + u[1][i]) * f[0][i];
    size += fabs(f[0][i]);
  }
  assert_true(size > 0.0);
  for (int a = 0; a < 3; ++a) assert_at_most(fabs(sum[a]), 1e-14 * size);
  assert_at_most(fabs(torque), 1e-14 * size * 0.01);
  vector_destroy(u);
  vector_destroy(f);
  touching_destroy(&t);
}

/* ---- bonds ----------------------------------------------------------------------------------- */

static void bonded_points_do_not_repel(void **state)
{
  (void)state;
  const body_how how = {.dimension = SDR_PLANE_STRESS, .cells = {12, 9}};
  const double squeezed[9] = {-0.3, 0.0, 0.0, 0.0, -0.3};
  touching t;
  touching_create(body_create(&how), &t);
  const sdr_points *points = t.still.body.points;
  double *u[3], *f[3];
  vector_create(points, u);
  vector_create(points, f);
  vector_linear(points, squeezed, u);
  assert_int_equal(sdr_contact_force(t.contact, u, f), SDR_OK);
  assert_near(vector_largest(points, f), 0.0, 0.0);
  vector_destroy(u);
  vector_destroy(f);
  touching_destroy(&t);
}

static int crosses_middle(const void *context, const double a[3], const double b[3])
{
  (void)context;
  return (a[0] > 0.0) != (b[0] > 0.0) ? SDR_CUT : 0;
}

/* The faces of a cut touch where they were. Those of laws that keep a stretch and of others. */
static void faces_of_a_cut_carry_pressure(void **state)
{
  (void)state;
  static const sdr_law laws[] = {SDR_LAW_NONE, SDR_LAW_VARIATIONAL, SDR_LAW_CRITICAL_STRETCH};
  for (int k = 0; k < 6; ++k) {
    const body_how how = {
        .dimension = SDR_PLANE_STRESS, .cells = {12, 9}, .law = laws[k % 3], .force_loose = k / 3};
    touching t;
    int64_t cut = 0;
    body b = body_create(&how);
    assert_int_equal(b.model->ops->mark(b.model, crosses_middle, NULL, &cut), SDR_OK);
    touching_create(b, &t);
    double *u[3], *f[3], *expected[3];
    vector_create(b.points, u);
    vector_create(b.points, f);
    vector_create(b.points, expected);
    for (int32_t i = 0; i < b.points->count; ++i)
      u[0][i] = (b.points->x[0][i] > 0.0 ? -0.01 : 0.01) * body_spacing;
    assert_int_equal(sdr_contact_force(t.contact, u, f), SDR_OK);
    const double energy = reference_force(&b, same_side, u, expected);
    assert_near(sdr_contact_energy(t.contact), energy, 1e-11 * energy);
    assert_at_most(vector_difference(b.points, f, expected),
                   1e-11 * vector_largest(b.points, expected));
    sdr_contact_state now;
    sdr_contact_look(t.contact, &now);
    assert_int_equal(now.touching, 9);
    for (int32_t i = 0; i < b.points->count; ++i) u[0][i] = -u[0][i];
    zero(b.points, f);
    assert_int_equal(sdr_contact_force(t.contact, u, f), SDR_OK);
    assert_near(vector_largest(b.points, f), 0.0, 0.0);
    vector_destroy(u);
    vector_destroy(f);
    vector_destroy(expected);
    touching_destroy(&t);
  }
}

/* Tear the body along its middle, then close it: pairs are known from the step that loses them, and
   a search in between changes no bit. */
static void check_tearing(int force_loose)
{
  const body_how how = {.dimension = SDR_PLANE_STRESS,
                        .cells = {12, 9},
                        .law = SDR_LAW_CRITICAL_STRETCH,
                        .force_loose = force_loose};
  touching t, other;
  touching_create(body_create(&how), &t);
  touching_create(body_create(&how), &other);
  const sdr_points *points = t.still.body.points;
  double *u[3], *v[3], *f[3], *g[3];
  vector_create(points, u);
  vector_create(points, v);
  vector_create(points, f);
  vector_create(points, g);
  static const double open[] = {0.0, 0.005, 0.04, 0.02, -0.01, -0.03};
  for (int n = 0; n < 6; ++n) {
    for (int32_t i = 0; i < points->count; ++i)
      u[0][i] = (points->x[0][i] > 0.0 ? 0.5 : -0.5) * open[n] * body_spacing;
    sdr_model *models[] = {t.still.body.model, other.still.body.model};
    models[0]->ops->force_commit(models[0], u, v, 1.0, f);
    models[1]->ops->force_commit(models[1], u, v, 1.0, g);
    assert_int_equal(sdr_contact_force(t.contact, u, f), SDR_OK);
    if (n > 2) assert_int_equal(sdr_contact_restart(other.contact, u), SDR_OK);
    assert_int_equal(sdr_contact_force(other.contact, u, g), SDR_OK);
    for (int a = 0; a < 2; ++a)
      assert_memory_equal(f[a], g[a], (size_t)points->count * sizeof(double));
    assert_true((sdr_contact_energy(t.contact) > 0.0) == (n > 3));
  }
  sdr_contact_state now;
  sdr_contact_look(t.contact, &now);
  assert_int_equal(now.searches, 1);
  assert_int_equal(now.touching, 9);
  vector_destroy(u);
  vector_destroy(v);
  vector_destroy(f);
  vector_destroy(g);
  touching_destroy(&t);
  touching_destroy(&other);
}

static void bonds_that_break_turn_into_contact(void **state)
{
  (void)state;
  check_tearing(0);
  check_tearing(1);
}

/* ---- the rest -------------------------------------------------------------------------------- */

static void threads_change_no_bit(void **state)
{
  (void)state;
  const body_how how = {.dimension = SDR_PLANE_STRESS, .cells = {15, 400}};
  touching t;
  touching_create(body_create_kept(&how, keep_blocks), &t);
  const sdr_points *points = t.still.body.points;
  double *u[3], *f[2][3], energy[2];
  vector_create(points, u);
  push_together(&t.still.body, 5.3 * body_spacing, 5, u);
  for (int k = 0; k < 2; ++k) {
    vector_create(points, f[k]);
    sdr_set_threads(k == 0 ? 1 : 3);
    assert_int_equal(sdr_contact_restart(t.contact, u), SDR_OK);
    assert_int_equal(sdr_contact_force(t.contact, u, f[k]), SDR_OK);
    energy[k] = sdr_contact_energy(t.contact);
  }
  sdr_set_threads(1);
  assert_true(energy[0] > 0.0);
  assert_memory_equal(&energy[0], &energy[1], sizeof energy[0]);
  for (int a = 0; a < 2; ++a)
    assert_memory_equal(f[0][a], f[1][a], (size_t)points->count * sizeof(double));
  vector_destroy(u);
  vector_destroy(f[0]);
  vector_destroy(f[1]);
  touching_destroy(&t);
}

static void a_failing_allocator_is_reported(void **state)
{
  (void)state;
  const body_how how = {.dimension = SDR_PLANE_STRESS, .cells = {15, 9}};
  for (long successes = 0;; ++successes) {
    still_body still;
    still_of(body_create_kept(&how, keep_blocks), &still);
    sdr_material material = {.young = body_young};
    still.scene.material = &material;
    still.scene.contact = (sdr_contact_scene){.on = 1, .range = 1.0, .penalty = penalty};
    double *u[3], *f[3];
    sdr_contact *contact = NULL;
    vector_create(still.body.points, u);
    vector_create(still.body.points, f);
    sdr_memory_fail_after(successes);
    sdr_status status = sdr_contact_create(&still.scene, still.body.model, &contact);
    if (status == SDR_OK) status = sdr_contact_force(contact, u, f);
    sdr_memory_fail_after(-1);
    sdr_contact_destroy(&contact);
    assert_null(still.body.model->lost);
    vector_destroy(u);
    vector_destroy(f);
    still_destroy(&still);
    if (status == SDR_OK) {
      assert_in_range(successes, 8, 40);
      return;
    }
    assert_int_equal(status, SDR_RUN_FAILED);
    assert_non_null(strstr(sdr_error_message(), "out of memory"));
  }
}

static void without_the_key_there_is_no_contact(void **state)
{
  (void)state;
  const body_how how = {.dimension = SDR_1D, .cells = {9}};
  still_body still;
  still_create(&how, &still);
  sdr_contact *contact = (sdr_contact *)&still;
  assert_int_equal(sdr_contact_create(&still.scene, still.body.model, &contact), SDR_OK);
  assert_null(contact);
  still_destroy(&still);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(forces_are_those_of_all_pairs_that_were_never_bonded),
      cmocka_unit_test(momentum_and_torque_of_the_forces_vanish),
      cmocka_unit_test(bonded_points_do_not_repel),
      cmocka_unit_test(faces_of_a_cut_carry_pressure),
      cmocka_unit_test(bonds_that_break_turn_into_contact),
      cmocka_unit_test(threads_change_no_bit),
      cmocka_unit_test(a_failing_allocator_is_reported),
      cmocka_unit_test(without_the_key_there_is_no_contact),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
