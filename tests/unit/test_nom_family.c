/* nom: moments and weights of bulk families. */
#include "base/memory.h"
#include "nom/family.h"
#include "nom/stencil.h"
#include "support/cmocka_all.h"
#include "support/noise.h"

#include <math.h>
#include <string.h>

static const sdr_families_how plain = {0}, iso = {.correction = SDR_CORRECTION_ISO};

static void assert_close(double value, double expected, double tolerance)
{
  if (!(fabs(value - expected) <= tolerance))
    fail_msg("%.15g, expected %.15g +- %g", value, expected, tolerance);
}

/* A square of side x side points with spacing 1, jittered, turned by angle. */
static sdr_points *square(int side, double jitter, double angle, double ratio)
{
  sdr_points *points;
  uint64_t seed = 31;
  assert_int_equal(sdr_points_create(side * side, 2, jitter <= 0.0, &points), SDR_OK);
  points->axes[0][0] = points->axes[1][1] = cos(angle);
  points->axes[0][1] = sin(angle);
  points->axes[1][0] = -sin(angle);
  points->lattice_spacing = 1.0;
  points->irregular = jitter > 0.0;
  for (int32_t i = 0; i < side * side; ++i) {
    const int32_t cell[3] = {i % side, i / side, 0};
    for (int a = 0; a < 2; ++a)
      points->x[a][i] = points->axes[0][a] * cell[0] + points->axes[1][a] * cell[1] +
                        (jitter > 0.0 ? jitter * noise(&seed) : 0.0);
    if (points->cell) memcpy(points->cell + 3 * (size_t)i, cell, sizeof cell);
    points->spacing[i] = points->volume[i] = 1.0;
    points->horizon[i] = ratio;
  }
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  return points;
}

static void a_stencil_counts_points_of_the_lattice_in_a_ball(void **state)
{
  (void)state;
  static const struct {
    int components, count;
    double ratio;
  } cases[] = {{1, 6, 3.015},  {2, 28, 3.015}, {2, 4, 1.0},    {2, 8, 1.5},
               {2, 48, 4.015}, {2, 28, 3.0},   {2, 24, 2.999}, {3, 6, 1.0},
               {3, 18, 1.42},  {3, 26, 1.74},  {3, 32, 2.0},   {3, 122, 3.015}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    sdr_stencil s;
    assert_int_equal(sdr_stencil_create(cases[k].components, 0.1, 0.1 * cases[k].ratio, &s),
                     SDR_OK);
    assert_int_equal(s.count, cases[k].count);
    for (int n = 0; n < s.count; ++n)
      for (int a = 0; a < 3; ++a)
        assert_int_equal(s.step[3 * n + a], -s.step[3 * (s.count - 1 - n) + a]);
    sdr_stencil_destroy(&s);
  }
}

static void a_huge_horizon_is_refused(void **state)
{
  (void)state;
  sdr_stencil s;
  assert_int_equal(sdr_stencil_create(2, 1.0, 120.0, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "a horizon of 120 spacings would give each point millions "
                      "of bonds; give less than 100 spacings");
}

static void moments_of_a_lattice_are_its_stencils_at_surfaces_too(void **state)
{
  (void)state;
  sdr_points *points = square(4, 0.0, 0.2, 3.015); /* no point has a complete family */
  sdr_families *families;
  assert_int_equal(sdr_families_create(points, &plain, &families), SDR_OK);
  double first = 0.0, second = 0.0;
  for (int y = -3; y <= 3; ++y)
    for (int x = -3; x <= 3; ++x)
      if (x * x + y * y <= 9) {
        first += sqrt(x * x + y * y);
        second += x * x + y * y;
      }
  assert_int_equal(families->count, 1);
  assert_int_equal(families->family[0].source, SDR_MOMENTS_STENCIL);
  assert_int_equal(families->family[0].neighbours, 28);
  assert_close(families->family[0].first, first, 1e-12);
  assert_close(families->family[0].second, second, 1e-12);
  /* n_x^4 + 2 n_x^2 n_y^2 + n_y^4 = 1 */
  const double *q = families->family[0].quartic;
  assert_close(q[0] + 2.0 * q[2] + q[4], first, 1e-12);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

static void isotropic_weights_make_fourth_moments_isotropic(void **state)
{
  (void)state;
  for (int k = 0; k < 4; ++k) {
    sdr_points *points = square(4, 0.0, 0.3 * k, 2.0 + 0.7 * k);
    sdr_families *families;
    assert_int_equal(sdr_families_create(points, &iso, &families), SDR_OK);
    const sdr_family *f = families->family;
    static const double mean[5] = {3.0 / 8.0, 0.0, 1.0 / 8.0, 0.0, 3.0 / 8.0};
    for (int c = 0; c < 5; ++c) assert_close(f->quartic[c] / f->first, mean[c], 1e-13);
    sdr_families_destroy(&families);
    sdr_points_destroy(&points);
  }
}

static void isotropic_weights_heed_the_moment_that_the_model_uses(void **state)
{
  (void)state;
  static const double mean[5] = {3.0 / 8.0, 0.0, 1.0 / 8.0, 0.0, 3.0 / 8.0};
  for (int influence = 0; influence < SDR_INFLUENCES; ++influence)
    for (int state_based = 0; state_based < 2; ++state_based) {
      const sdr_families_how how = {.influence = (sdr_influence)influence,
                                    .partial_volume = 1,
                                    .correction = SDR_CORRECTION_ISO,
                                    .state_based = state_based};
      sdr_points *points = square(4, 0.0, 0.2, 3.015);
      sdr_families *families;
      assert_int_equal(sdr_families_create(points, &how, &families), SDR_OK);
      const sdr_family *f = families->family;
      for (int c = 0; c < 5; ++c) assert_close(f->quartic[c] / f->moment, mean[c], 1e-13);
      assert_close(f->moment, state_based ? f->second : f->first, 0.0);
      sdr_families_destroy(&families);
      sdr_points_destroy(&points);
    }
}

/* sum over i's own family of b |xi| V n_x^p n_y^q. */
static double own_moment(const sdr_families *families, int32_t i, int p, int q)
{
  const sdr_points *points = families->points;
  double sum = 0.0;
  for (int32_t j = 0; j < points->count; ++j) {
    const double xi[3] = {points->x[0][j] - points->x[0][i], points->x[1][j] - points->x[1][i]};
    const double length = hypot(xi[0], xi[1]);
    if (j == i || length > points->horizon[i] * (1.0 + 1e-10)) continue;
    sum += sdr_families_weight(families, i, j, xi) * length * points->volume[j] *
           pow(xi[0] / length, p) * pow(xi[1] / length, q);
  }
  return sum;
}

static void surface_iso_makes_the_family_of_an_edge_isotropic_and_full(void **state)
{
  (void)state;
  const sdr_families_how how = {.correction = SDR_CORRECTION_SURFACE_ISO};
  sdr_points *points = square(16, 0.0, 0.0, 3.015);
  sdr_families *families;
  assert_int_equal(sdr_families_create(points, &how, &families), SDR_OK);
  const double full = families->family[0].moment;
  int bulk = 0;
  for (int32_t i = 0; i < points->count; ++i) {
    const double whole = own_moment(families, i, 4, 0) + 2.0 * own_moment(families, i, 2, 2) +
                         own_moment(families, i, 0, 4);
    assert_close(whole, full, 1e-11 * full);
    bulk += families->bulk[i];
    const double x = points->x[0][i], y = points->x[1][i];
    if (x < 3.0 || x > 12.0 || y != 0.0) continue; /* the middle of an edge */
    assert_close(own_moment(families, i, 4, 0), 3.0 / 8.0 * full, 1e-10 * full);
    assert_close(own_moment(families, i, 2, 2), 1.0 / 8.0 * full, 1e-10 * full);
    assert_close(own_moment(families, i, 1, 3), 0.0, 1e-10 * full);
  }
  assert_int_equal(bulk, 10 * 10);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

/* By 003 sec. 3.2 with both half bonds: at the end of a bar half the bonds are missing. */
static void madenci_oterkus_factors_double_where_half_of_a_family_is_missing(void **state)
{
  (void)state;
  const sdr_families_how how = {.correction = SDR_CORRECTION_MADENCI_OTERKUS};
  sdr_points *points;
  assert_int_equal(sdr_points_create(20, 1, 1, &points), SDR_OK);
  points->lattice_spacing = 1.0;
  for (int32_t i = 0; i < 20; ++i) {
    points->cell[3 * i] = i;
    points->x[0][i] = i;
    points->spacing[i] = points->volume[i] = 1.0;
    points->horizon[i] = 3.0;
  }
  assert_int_equal(sdr_points_arrange(points), SDR_OK);
  sdr_families *families;
  assert_int_equal(sdr_families_create(points, &how, &families), SDR_OK);
  for (int32_t i = 0; i < 20; ++i) {
    const double x = fmin(points->x[0][i], 19.0 - points->x[0][i]);
    double missing = 0.0;
    for (double far = x + 1.0; far <= 3.0; far += 1.0) missing += far;
    assert_close(families->axial[i], 12.0 / (12.0 - missing), 1e-13);
  }
  /* the pair takes the mean of both ends */
  const double one[3] = {1.0, 0.0, 0.0};
  assert_close(sdr_families_weight(families, 0, 1, one), 0.5 * (2.0 + 12.0 / 7.0), 1e-13);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

static void a_neighbour_on_the_horizon_keeps_a_trace_of_weight(void **state)
{
  (void)state;
  const sdr_families_how how = {.influence = SDR_INFLUENCE_LINEAR};
  sdr_points *points = square(5, 0.0, 0.0, 3.0);
  sdr_families *families;
  assert_int_equal(sdr_families_create(points, &how, &families), SDR_OK);
  const double on[3] = {3.0, 0.0, 0.0};
  const double b = sdr_families_weight(families, 0, 3, on);
  assert_true(b > 0.0 && b < 1e-11);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

static void weights_never_fall_under_a_fifth(void **state)
{
  (void)state;
  const double lambda[SDR_MONOMIALS] = {-50.0, 0.0, 0.0, 0.0, 3.0}, east[3] = {1.0, 0.0, 0.0};
  const double north[3] = {0.0, 1.0, 0.0};
  assert_close(sdr_iso_weight(2, lambda, east), 0.2, 1e-15);
  assert_close(sdr_iso_weight(2, lambda, north), 4.0, 1e-15);
}

static void partial_volumes_fall_from_1_to_a_half_at_the_horizon(void **state)
{
  (void)state;
  assert_close(sdr_partial_volume(2.0, 3.0, 1.0), 1.0, 0.0);
  assert_close(sdr_partial_volume(2.5, 3.0, 1.0), 1.0, 0.0);
  assert_close(sdr_partial_volume(2.75, 3.0, 1.0), 0.75, 1e-15);
  assert_close(sdr_partial_volume(3.0, 3.0, 1.0), 0.5, 1e-15);
  assert_close(sdr_partial_volume(4.0, 3.0, 1.0), 0.0, 0.0);
}

static void jittered_points_take_the_mean_of_complete_families(void **state)
{
  (void)state;
  sdr_points *points = square(20, 0.2, 0.0, 3.015);
  sdr_families *families;
  assert_int_equal(sdr_families_create(points, &plain, &families), SDR_OK);
  const sdr_family *f = families->family;
  assert_int_equal(f->source, SDR_MOMENTS_MEAN);
  /* 2 pi d^3/3 in the continuum; the ring of points that noise moves in and out is a tenth of it */
  assert_close(f->first / (2.0 * 3.14159265358979 * pow(3.015, 3.0) / 3.0), 1.0, 0.1);
  const double stencil = 24.0 + 12.0 * sqrt(2.0) + 8.0 * sqrt(5.0);
  assert_true(fabs(f->first - stencil) > 1e-3);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

static void without_a_complete_family_the_continuum_is_taken(void **state)
{
  (void)state;
  sdr_points *points = square(3, 0.2, 0.0, 3.0);
  sdr_families *families;
  assert_int_equal(sdr_families_create(points, &plain, &families), SDR_OK);
  const sdr_family *f = families->family;
  assert_int_equal(f->source, SDR_MOMENTS_CONTINUUM);
  assert_close(f->first, 2.0 * 3.14159265358979323846 * 27.0 / 3.0, 1e-12);
  assert_close(f->second, 2.0 * 3.14159265358979323846 * 81.0 / 4.0, 1e-12);
  assert_close(f->quartic[0] / f->first, 3.0 / 8.0, 1e-15);
  assert_close(f->quartic[2] / f->first, 1.0 / 8.0, 1e-15);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

static void points_alike_share_a_family(void **state)
{
  (void)state;
  sdr_points *points = square(9, 0.0, 0.0, 2.0);
  for (int32_t i = 0; i < points->count; ++i) points->horizon[i] = i % 3 == 0 ? 2.0 : 3.0;
  sdr_families *families;
  assert_int_equal(sdr_families_create(points, &plain, &families), SDR_OK);
  assert_int_equal(families->count, 2);
  for (int32_t i = 0; i < points->count; ++i)
    assert_close(sdr_family_of(families, i)->horizon, points->horizon[i], 0.0);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
}

static void every_failing_allocation_is_reported(void **state)
{
  (void)state;
  for (int k = 0; k < 2 * SDR_CORRECTIONS; ++k) {
    sdr_points *points = square(9, k % 2 ? 0.1 : 0.0, 0.0, 2.5);
    if (k % 2) points->horizon[3] = 3.0;
    const sdr_families_how how = {.correction = (sdr_correction)(k / 2)};
    const size_t before = sdr_memory_now();
    long fails = 0;
    for (; fails < 100; ++fails) {
      sdr_families *families = NULL;
      sdr_memory_fail_after(fails);
      const sdr_status status = sdr_families_create(points, &how, &families);
      sdr_memory_fail_after(-1);
      if (status == SDR_OK) {
        sdr_families_destroy(&families);
        break;
      }
      assert_int_equal(status, SDR_RUN_FAILED);
      assert_null(families);
      assert_int_equal(sdr_memory_now(), before);
    }
    assert_true(fails > 2 && fails < 100);
    sdr_points_destroy(&points);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_stencil_counts_points_of_the_lattice_in_a_ball),
      cmocka_unit_test(a_huge_horizon_is_refused),
      cmocka_unit_test(moments_of_a_lattice_are_its_stencils_at_surfaces_too),
      cmocka_unit_test(isotropic_weights_make_fourth_moments_isotropic),
      cmocka_unit_test(isotropic_weights_heed_the_moment_that_the_model_uses),
      cmocka_unit_test(surface_iso_makes_the_family_of_an_edge_isotropic_and_full),
      cmocka_unit_test(madenci_oterkus_factors_double_where_half_of_a_family_is_missing),
      cmocka_unit_test(a_neighbour_on_the_horizon_keeps_a_trace_of_weight),
      cmocka_unit_test(weights_never_fall_under_a_fifth),
      cmocka_unit_test(partial_volumes_fall_from_1_to_a_half_at_the_horizon),
      cmocka_unit_test(jittered_points_take_the_mean_of_complete_families),
      cmocka_unit_test(without_a_complete_family_the_continuum_is_taken),
      cmocka_unit_test(points_alike_share_a_family),
      cmocka_unit_test(every_failing_allocation_is_reported),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
