/* Fields over points: damage, energies, stress and strain against plain sums and closed forms. */
#include "damage/calibration.h"
#include "support/reference.h"

static const body_how shapes[] = {
    {.dimension = SDR_1D, .cells = {40}},
    {.dimension = SDR_PLANE_STRESS, .cells = {34, 9}},
    {.dimension = SDR_PLANE_STRAIN, .cells = {10, 11}, .force_loose = 1},
    {.dimension = SDR_PLANE_STRESS, .cells = {12, 11}, .jitter = 0.3, .horizon_spread = 0.3},
    {.dimension = SDR_3D, .cells = {9, 8, 7}, .ratio = 2.01},
    {.dimension = SDR_3D, .cells = {9, 5, 5}, .ratio = 2.2, .jitter = 0.2, .horizon_spread = 0.2},
};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static double *field_of(const body *b, double *const u[3], sdr_model_field which)
{
  double *out = sdr_alloc(6 * (size_t)b->points->count, sizeof *out);
  assert_int_equal(b->model->ops->field(b->model, u, which, out), SDR_OK);
  return out;
}

/* ---- damage ---------------------------------------------------------------------------------- */

/* d_ij of the reference's history at the state u. */
static double damage_of(const reference *r, int32_t i, int32_t j, double s)
{
  const size_t slot = (size_t)i * (size_t)r->body->points->count + (size_t)j;
  if (r->mark[slot] == SDR_CUT) return 1.0;
  if (r->mark[slot] == SDR_PROTECTED || r->body->how.law == SDR_LAW_NONE) return 0.0;
  if (r->body->how.law == SDR_LAW_CRITICAL_STRETCH) return r->lost[slot];
  const double k = fmax((double)(float)s, (double)r->stretch[slot]);
  return 1.0 - (double)sqrtl(reference_soften(r, i, (long double)k).left);
}

/* Mean over H_i by volume, and over all directed bonds the largest and the count beyond one half,
   cut ones aside. */
static double plain_damage(const reference *r, double *const u[3], int32_t i, double *most,
                           int64_t *broken)
{
  const sdr_points *points = r->body->points;
  double sum = 0.0, volume = 0.0;
  for (int32_t j = 0; j < points->count; ++j) {
    if (reference_far(r, i, j)) continue;
    const reference_pair p = reference_kinematics(points, u, i, j);
    if (!reference_in_family(points, i, p.xi)) continue;
    const double d = damage_of(r, i, j, (double)p.s);
    sum += d * points->volume[j];
    volume += points->volume[j];
    if (r->mark[(size_t)i * (size_t)points->count + (size_t)j] == SDR_CUT) continue;
    *most = fmax(*most, d);
    *broken += d > 0.5;
  }
  return sum / volume;
}

static void check_damage(const body_how *how, int with_history)
{
  body b = body_create(how);
  reference r = reference_create(&b);
  double *u[3], most = 0.0;
  int64_t broken = 0;
  vector_create(b.points, u);
  reference_mark(&r, body_cut_and_protect);
  if (with_history) {
    vector_noise(b.points, 0.02 * body_spacing, 7, u);
    b.model->ops->commit(b.model, u);
    reference_commit(&r, u);
    for (int a = 0; a < b.points->components; ++a)
      for (int32_t i = 0; i < b.points->count; ++i) u[a][i] *= 0.5;
  }
  double *damage = field_of(&b, u, SDR_FIELD_DAMAGE), least = 1.0;
  for (int32_t i = 0; i < b.points->count; ++i) {
    assert_near(damage[i], plain_damage(&r, u, i, &most, &broken), 1e-13);
    least = fmin(least, damage[i]);
  }
  sdr_energies e;
  b.model->ops->energies(b.model, u, &e);
  assert_near(e.max_damage, most, 1e-13);
  assert_int_equal(e.broken, broken);
  if (!with_history) assert_near(least, 0.0, 0.0); /* away from the cut */
  sdr_free(damage);
  vector_destroy(u);
  reference_destroy(&r);
  body_destroy(&b);
}

static void damage_is_the_share_of_the_family_that_is_cut_or_broken(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int law = SDR_LAW_NONE; law < SDR_LAW_COUNT; ++law)
      for (int scatter = 0; scatter < 2; ++scatter)
        for (int history = 0; history < 2; ++history) {
          body_how how = shapes[k];
          how.law = (sdr_law)law;
          how.scatter = 0.3 * scatter;
          check_damage(&how, history);
        }
}

static int cut_at_x_0(const void *context, const double a[3], const double b[3])
{
  (void)context;
  return (a[0] > 0.0) != (b[0] > 0.0) ? SDR_CUT : 0;
}

/* A plane between two rows takes 11 of 28 neighbours from the points next to it (measured.md). */
static void a_plane_cut_removes_11_of_28_bonds(void **state)
{
  (void)state;
  const body_how how = {.dimension = SDR_PLANE_STRESS, .cells = {20, 21}};
  body b = body_create(&how);
  int64_t cut;
  assert_int_equal(b.model->ops->mark(b.model, cut_at_x_0, NULL, &cut), SDR_OK);
  double *u[3];
  vector_create(b.points, u);
  double *damage = field_of(&b, u, SDR_FIELD_DAMAGE);
  const double beside[3] = {0.25 * body_spacing, 0.0, 0.0};
  assert_near(damage[sdr_points_nearest(b.points, beside)], 11.0 / 28.0, 1e-14);
  assert_near(b.families->family[0].cut_share, 11.0 / 28.0, 1e-14);
  sdr_free(damage);
  vector_destroy(u);
  body_destroy(&b);
}

typedef struct {
  const reference *r;
  double *const *u;
  char *seen;
  int64_t count;
} visits;

static void visit(void *context, int32_t i, int32_t j, double damage)
{
  visits *v = context;
  const sdr_points *points = v->r->body->points;
  const size_t slot = (size_t)(i < j ? i : j) * (size_t)points->count + (size_t)(i < j ? j : i);
  assert_false(v->seen[slot]);
  v->seen[slot] = 1;
  ++v->count;
  const reference_pair p = reference_kinematics(points, v->u, i, j);
  const int in_i = reference_in_family(points, i, p.xi),
            in_j = reference_in_family(points, j, p.xi);
  const double sum = (in_i ? damage_of(v->r, i, j, (double)p.s) : 0.0) +
                     (in_j ? damage_of(v->r, j, i, (double)p.s) : 0.0);
  assert_near(damage, sum / (in_i + in_j), 1e-13);
}

static void every_pair_is_visited_once_with_the_mean_of_its_halves(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int law = SDR_LAW_NONE; law < SDR_LAW_COUNT; ++law) {
      body_how how = shapes[k];
      how.law = (sdr_law)law;
      how.scatter = 0.3;
      body b = body_create(&how);
      reference r = reference_create(&b);
      double *u[3];
      vector_create(b.points, u);
      reference_mark(&r, body_cut_and_protect);
      vector_noise(b.points, 0.02 * body_spacing, 7, u);
      b.model->ops->commit(b.model, u);
      reference_commit(&r, u);
      const size_t n = (size_t)b.points->count;
      visits v = {&r, u, sdr_alloc(n * n, 1), 0};
      b.model->ops->visit_damage(b.model, u, visit, &v);
      assert_int_equal(v.count, b.bonds->pairs);
      sdr_free(v.seen);
      vector_destroy(u);
      reference_destroy(&r);
      body_destroy(&b);
    }
}

/* ---- energies -------------------------------------------------------------------------------- */

static double integral(const body *b, const double *density)
{
  double sum = 0.0;
  for (int32_t i = 0; i < b->points->count; ++i) sum += density[i] * b->points->volume[i];
  return sum;
}

static void energy_fields_sum_to_the_energies(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int law = SDR_LAW_NONE; law < SDR_LAW_COUNT; ++law)
      for (int scatter = 0; scatter < 2; ++scatter) {
        body_how how = shapes[k];
        how.law = (sdr_law)law;
        how.scatter = 0.3 * scatter;
        body b = body_create(&how);
        int64_t cut;
        assert_int_equal(b.model->ops->mark(b.model, body_cut_and_protect, NULL, &cut), SDR_OK);
        double *u[3];
        vector_create(b.points, u);
        vector_noise(b.points, 0.02 * body_spacing, 7, u);
        b.model->ops->commit(b.model, u);
        vector_noise(b.points, 0.004 * body_spacing, 8, u);
        sdr_energies e;
        b.model->ops->energies(b.model, u, &e);
        double *stored = field_of(&b, u, SDR_FIELD_ENERGY_DENSITY);
        double *dissipated = field_of(&b, u, SDR_FIELD_DISSIPATED);
        assert_true(e.stored > 0.0);
        assert_near(integral(&b, stored), e.stored, 1e-12 * e.stored);
        /* critical stretch books what each bond really held, the field shows its threshold */
        if (law != SDR_LAW_CRITICAL_STRETCH)
          assert_near(integral(&b, dissipated), e.dissipated, 1e-12 * e.dissipated);
        else
          assert_true(integral(&b, dissipated) > 0.0 && integral(&b, dissipated) < e.dissipated);
        sdr_free(stored);
        sdr_free(dissipated);
        vector_destroy(u);
        body_destroy(&b);
      }
}

/* ---- strain and stress ----------------------------------------------------------------------- */

static const int pair_of[3][6][2] = {
    {{0, 0}}, {{0, 0}, {1, 1}, {0, 1}}, {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};

static const double gradient[9] = {3e-4, -2e-4, 5e-5, 4e-4, -1e-4, 6e-5, -7e-5, 1e-5, 2e-4};

static double strain_part(int n, int k)
{
  const int a = pair_of[n - 1][k][0], c = pair_of[n - 1][k][1];
  return 0.5 * (gradient[3 * a + c] + gradient[3 * c + a]);
}

static void strain_of_a_linear_displacement_is_exact_at_every_point(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k) {
    body b = body_create(&shapes[k]);
    const int n = b.points->components;
    const size_t count = (size_t)b.points->count;
    double *u[3];
    vector_create(b.points, u);
    vector_linear(b.points, gradient, u);
    double *strain = field_of(&b, u, SDR_FIELD_STRAIN);
    double *dilatation = field_of(&b, u, SDR_FIELD_DILATATION);
    double trace = 0.0;
    for (int a = 0; a < n; ++a) trace += gradient[4 * a];
    for (size_t i = 0; i < count; ++i) {
      for (int c = 0; c < n * (n + 1) / 2; ++c)
        assert_near(strain[(size_t)c * count + i], strain_part(n, c), 1e-15);
      assert_near(dilatation[i], trace, 1e-15);
    }
    sdr_free(strain);
    sdr_free(dilatation);
    vector_destroy(u);
    body_destroy(&b);
  }
}

/* Stress at the middle point, linear part: what is odd in the strain. */
static void middle_stress(const body *b, double size, double stress[6])
{
  const double origin[3] = {0.0, 0.0, 0.0};
  const size_t at = (size_t)sdr_points_nearest(b->points, origin);
  const int n = b->points->components;
  memset(stress, 0, 6 * sizeof *stress);
  for (int sign = -1; sign <= 1; sign += 2) {
    double scaled[9], *u[3];
    for (int c = 0; c < 9; ++c) scaled[c] = sign * size * gradient[c];
    vector_create(b->points, u);
    vector_linear(b->points, scaled, u);
    double *out = field_of(b, u, SDR_FIELD_STRESS);
    for (int c = 0; c < n * (n + 1) / 2; ++c)
      stress[c] += 0.5 * sign / size * out[(size_t)c * (size_t)b->points->count + at];
    sdr_free(out);
    vector_destroy(u);
  }
}

/* sigma = C : eps of a cubic lattice along the axes. */
static void expected_stress(int n, double c11, double c12, double c66, double stress[6])
{
  double trace = 0.0;
  for (int a = 0; a < n; ++a) trace += strain_part(n, a);
  for (int c = 0; c < n * (n + 1) / 2; ++c)
    stress[c] =
        c < n ? (c11 - c12) * strain_part(n, c) + c12 * trace : 2.0 * c66 * strain_part(n, c);
}

static void stress_of_uniform_strain_is_the_stiffness_times_it(void **state)
{
  (void)state;
  static const body_how cubes[] = {
      {.dimension = SDR_1D, .cells = {15}},
      {.dimension = SDR_PLANE_STRESS, .cells = {11, 9}},
      {.dimension = SDR_PLANE_STRAIN, .cells = {11, 9}},
      {.dimension = SDR_PLANE_STRAIN, .cells = {9, 11}, .force_loose = 1},
      {.dimension = SDR_3D, .cells = {9, 9, 9}}};
  for (int k = 0; k < 5; ++k)
    for (int iso = 0; iso < 2; ++iso) {
      body_how how = cubes[k];
      how.weight.correction = iso ? SDR_CORRECTION_ISO : SDR_CORRECTION_NONE;
      body b = body_create(&how);
      const int n = b.points->components;
      const sdr_effective_stiffness s =
          sdr_stiffness_of(how.dimension, b.families->family, body_micromodulus(&b, 0), body_young);
      double stress[6], expected[6];
      middle_stress(&b, 1e-2, stress);
      if (iso)
        expected_stress(n, s.exact_c11, s.exact_c12, s.exact_c66, expected);
      else
        expected_stress(n, s.c11, s.c12, s.c66, expected);
      for (int c = 0; c < n * (n + 1) / 2; ++c)
        assert_near(stress[c], expected[c], 1e-9 * s.c11 * 4e-4);
      body_destroy(&b);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(damage_is_the_share_of_the_family_that_is_cut_or_broken),
      cmocka_unit_test(a_plane_cut_removes_11_of_28_bonds),
      cmocka_unit_test(every_pair_is_visited_once_with_the_mean_of_its_halves),
      cmocka_unit_test(energy_fields_sum_to_the_energies),
      cmocka_unit_test(strain_of_a_linear_displacement_is_exact_at_every_point),
      cmocka_unit_test(stress_of_uniform_strain_is_the_stiffness_times_it),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
