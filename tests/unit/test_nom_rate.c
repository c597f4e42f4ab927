/* nom: velocity gradients and increments of the deformation gradient without a shape tensor. */
#include "base/parallel.h"
#include "nom/rate.h"
#include "support/grid.h"

#include <stdio.h>

typedef struct {
  grid g;
  sdr_support s;
  double *y[3], *v[3], *rate;
} motion;

static void motion_create(int d, motion *m)
{
  const int cells[3] = {20, 8, 5};
  const int nearest[3] = {4, 8, 18};
  *m = (motion){0};
  grid_create(d, cells[d - 1], 0.3, 1.0, &m->g);
  assert_int_equal(sdr_support_by_count(&m->g.cloud, nearest[d - 1], &m->s), SDR_OK);
  for (int a = 0; a < d; ++a) {
    m->y[a] = sdr_alloc((size_t)m->g.count, sizeof(double));
    m->v[a] = sdr_alloc((size_t)m->g.count, sizeof(double));
  }
  m->rate = sdr_alloc(9 * (size_t)m->g.count, sizeof(double));
}

static void motion_destroy(motion *m)
{
  for (int a = 0; a < 3; ++a) {
    sdr_free(m->y[a]);
    sdr_free(m->v[a]);
  }
  sdr_free(m->rate);
  sdr_support_destroy(&m->s);
  grid_destroy(&m->g);
}

static sdr_status rate_of(const motion *m, sdr_influence influence)
{
  const double *y[3], *v[3];
  for (int a = 0; a < 3; ++a) {
    y[a] = m->y[a];
    v[a] = m->v[a];
  }
  return sdr_rate_gradient(&m->s, influence, y, v, m->rate);
}

static const double F[3][3] = {{1.2, -0.6, 0.1}, {0.5, 0.9, 0.2}, {-0.1, 0.3, 1.4}};
static const double L[3][3] = {{0.3, -2.0, 0.7}, {1.9, -0.4, 0.5}, {0.6, 0.8, 0.2}};

/* y = F X + c, v = L y + d, with the first components of F and L. */
static void move_affinely(motion *m)
{
  const int d = m->g.components;
  for (int32_t i = 0; i < m->g.count; ++i) {
    for (int a = 0; a < d; ++a) {
      m->y[a][i] = 3.0 + a;
      for (int b = 0; b < d; ++b) m->y[a][i] += F[a][b] * m->g.x[b][i];
    }
    for (int a = 0; a < d; ++a) {
      m->v[a][i] = -5.0;
      for (int b = 0; b < d; ++b) m->v[a][i] += L[a][b] * m->y[b][i];
    }
  }
}

static void affine_motion_has_its_velocity_gradient_on_any_points(void **state)
{
  (void)state;
  for (int d = 1; d <= 3; ++d) {
    motion m;
    motion_create(d, &m);
    move_affinely(&m);
    for (int w = 0; w < SDR_INFLUENCES; ++w) {
      assert_int_equal(rate_of(&m, (sdr_influence)w), SDR_OK);
      for (int32_t i = 0; i < m.g.count; ++i)
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b)
            assert_near(m.rate[9 * i + 3 * a + b], a < d && b < d ? L[a][b] : 0.0, 1e-11);
    }
    motion_destroy(&m);
  }
}

/* A motion that is not affine: y = X + 0.2 sin, and some velocity. */
static void move_freely(motion *m)
{
  const int d = m->g.components;
  for (int32_t i = 0; i < m->g.count; ++i)
    for (int a = 0; a < d; ++a) {
      const double x = m->g.x[a][i], other = m->g.x[(a + 1) % d][i];
      m->y[a][i] = x + 0.2 * sin(2.0 * other + 0.5 * a);
      m->v[a][i] = cos(3.0 * x - other) + x * other;
    }
}

/* 000 eq. 47: L = Fdot F^-1, both by first-order operators, whose shape tensor is the paper's K. */
static void it_is_the_rate_of_deformation_by_the_shape_tensor(void **state)
{
  (void)state;
  motion m;
  sdr_shape_tensors shape;
  const sdr_shape_how how = {.order = 1, .influence = SDR_INFLUENCE_GAUSSIAN};
  motion_create(2, &m);
  move_freely(&m);
  assert_int_equal(rate_of(&m, how.influence), SDR_OK);
  assert_int_equal(sdr_shape_tensors_create(&m.s, &how, &shape), SDR_OK);
  for (int32_t i = 0; i < m.g.count; ++i) {
    double f[2][2], rate[2][2];
    for (int a = 0; a < 2; ++a) {
      sdr_derivatives_at(&shape, i, m.y[a], f[a]);
      sdr_derivatives_at(&shape, i, m.v[a], rate[a]);
    }
    for (int a = 0; a < 2; ++a) /* L F = Fdot */
      for (int b = 0; b < 2; ++b)
        assert_near(m.rate[9 * i + 3 * a] * f[0][b] + m.rate[9 * i + 3 * a + 1] * f[1][b],
                    rate[a][b], 1e-11);
  }
  sdr_shape_tensors_destroy(&shape);
  motion_destroy(&m);
}

/* 000 eq. 49 does not say at which end of the increment y is. At its start C takes the old gradient
   to the new one, F_new = (I + C) F_old; at its end it leads back, F_old = (I - C) F_new. Both hold
   for any motion. */
static void an_increment_leads_from_one_deformation_gradient_to_the_next(void **state)
{
  (void)state;
  motion m;
  sdr_shape_tensors shape;
  const sdr_shape_how how = {.order = 1, .influence = SDR_INFLUENCE_CUBIC};
  motion_create(2, &m);
  move_freely(&m);
  assert_int_equal(sdr_shape_tensors_create(&m.s, &how, &shape), SDR_OK);
  for (int end = 0; end < 2; ++end) {
    for (int32_t i = 0; i < m.g.count && end; ++i)
      for (int a = 0; a < 2; ++a) m.y[a][i] += m.v[a][i];
    assert_int_equal(rate_of(&m, how.influence), SDR_OK);
    for (int32_t i = 0; i < m.g.count; ++i) {
      double f[2][2], added[2][2];
      const double *c = m.rate + 9 * i;
      for (int a = 0; a < 2; ++a) {
        sdr_derivatives_at(&shape, i, m.y[a], f[a]);
        sdr_derivatives_at(&shape, i, m.v[a], added[a]);
      }
      for (int a = 0; a < 2; ++a)
        for (int b = 0; b < 2; ++b)
          assert_near(c[3 * a] * f[0][b] + c[3 * a + 1] * f[1][b], added[a][b], 1e-9);
    }
  }
  sdr_shape_tensors_destroy(&shape);
  motion_destroy(&m);
}

static void a_collapsed_neighbourhood_is_named(void **state)
{
  (void)state;
  motion m;
  motion_create(2, &m);
  move_affinely(&m);
  for (int32_t i = 0; i < m.g.count; ++i) m.y[1][i] = 2.0 * m.y[0][i];
  assert_int_equal(rate_of(&m, SDR_INFLUENCE_CONSTANT), SDR_RUN_FAILED);
  char expected[160];
  snprintf(expected, sizeof expected,
           "point 0 at (0, 0): its %d neighbours have collapsed in their present places, so no "
           "velocity gradient exists there",
           (int)m.s.row[1]);
  assert_string_equal(sdr_error_message(), expected);
  move_affinely(&m);
  sdr_memory_fail_after(0);
  assert_int_equal(rate_of(&m, SDR_INFLUENCE_CONSTANT), SDR_RUN_FAILED);
  sdr_memory_fail_after(-1);
  motion_destroy(&m);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(affine_motion_has_its_velocity_gradient_on_any_points),
      cmocka_unit_test(it_is_the_rate_of_deformation_by_the_shape_tensor),
      cmocka_unit_test(an_increment_leads_from_one_deformation_gradient_to_the_next),
      cmocka_unit_test(a_collapsed_neighbourhood_is_named),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
