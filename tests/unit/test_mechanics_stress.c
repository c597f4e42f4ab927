/* Elastic laws of a point: stress is the slope of energy, the tangent that of stress; objectivity;
   splits; plane stress. */
#include "mechanics/stress.h"

#include "support/body.h"

static const double young = 3.0, poissons[] = {0.0, 0.3, 0.45};
static const sdr_dimension dimensions[] = {SDR_1D, SDR_PLANE_STRESS, SDR_PLANE_STRAIN, SDR_3D};
static const sdr_elasticity laws[] = {SDR_LINEAR, SDR_SAINT_VENANT_KIRCHHOFF, SDR_NEO_HOOKEAN};
static const int splits[] = {SDR_SPLIT_DILATATION, SDR_SPLIT_SPECTRAL, SDR_SPLIT_WHOLE};

typedef struct {
  sdr_dimension dimension;
  int n, split;
  sdr_elasticity law;
  sdr_moduli moduli;
} material;

static double largest(const double *a, int count)
{
  double most = 0.0;
  for (int k = 0; k < count; ++k) most = fmax(most, fabs(a[k]));
  return most;
}

/* Call check for every dimension, law, split and Poisson's ratio. */
static void for_all(void (*check)(const material *))
{
  for (int d = 0; d < 4; ++d)
    for (int l = 0; l < 3; ++l)
      for (int s = 0; s < 3; ++s)
        for (int p = 0; p < 3; ++p) {
          const sdr_moduli moduli = sdr_moduli_of(dimensions[d], laws[l], young, poissons[p]);
          const material m = {dimensions[d], sdr_components(dimensions[d]), splits[s], laws[l],
                              moduli};
          check(&m);
        }
}

/* 1 if a principal strain, their sum or the growth of volume is close to zero: the kinks of the
   splits, where no difference is exact. */
static int near_kink(const material *m, const double *g, double size)
{
  double strain[9], full[9] = {0.0}, e[3], v[9], sum = 0.0, volume = 0.0;
  sdr_strain_of(m->n, m->law != SDR_LINEAR, g, strain);
  for (int a = 0; a < m->n; ++a)
    for (int b = 0; b < m->n; ++b) full[3 * a + b] = strain[m->n * a + b];
  for (int a = m->n; a < 3; ++a) full[4 * a] = size;
  sdr_eigen3(full, e, v);
  for (int a = 0; a < 3; ++a) {
    if (fabs(e[a]) < 0.02 * size) return 1;
    sum += e[a];
    volume += log(fmax(1.0 + 2.0 * e[a], 1e-3));
  }
  const double rest = (3 - m->n) * size;
  return fabs(sum - rest) < 0.02 * size ||
         fabs(volume - (3 - m->n) * log(1.0 + 2.0 * size)) < 0.02 * size;
}

/* A gradient away from the kinks: noise about a strain of mixed signs. */
static void gradient_of(const material *m, uint64_t *seed, double size, double *g)
{
  do {
    const double turn = noise(seed) > 0.0 ? 1.0 : -1.0;
    for (int k = 0; k < m->n * m->n; ++k) {
      const double own = k == 0 ? 0.6 : k == 4 ? 0.25 : -0.5;
      g[k] = size * ((k % (m->n + 1) == 0 ? turn * own : 0.0) + 0.3 * noise(seed));
    }
  } while (near_kink(m, g, size));
}

static double energy_part(const material *m, const double *g, int which)
{
  sdr_point_stress s;
  sdr_stress_of(m->n, m->law, m->split, &m->moduli, g, &s);
  return which == 0 ? s.plus : s.minus;
}

static void check_stress(const material *m)
{
  const double h = 1e-3;
  uint64_t seed = 4711;
  for (int trial = 0; trial < 6; ++trial) {
    double g[9];
    gradient_of(m, &seed, 0.5, g);
    sdr_point_stress s;
    sdr_stress_of(m->n, m->law, m->split, &m->moduli, g, &s);
    for (int which = 0; which < 2; ++which)
      for (int k = 0; k < m->n * m->n; ++k) {
        static const double at[6] = {-3, -2, -1, 1, 2, 3}, of[6] = {-1, 9, -45, 45, -9, 1};
        const double there = g[k];
        double slope = 0.0;
        for (int t = 0; t < 6; ++t) {
          g[k] = there + at[t] * h;
          slope += of[t] / (60.0 * h) * energy_part(m, g, which);
        }
        g[k] = there;
        assert_near(slope, (which == 0 ? s.p_plus : s.p_minus)[k], 1e-8 * young);
      }
  }
}

static void stress_is_the_slope_of_its_energy_to_1e_8(void **state)
{
  (void)state;
  for_all(check_stress);
}

static void check_tangent_at(const material *m, double *g, double tolerance)
{
  static const double at[6] = {-3, -2, -1, 1, 2, 3}, of[6] = {-1, 9, -45, 45, -9, 1};
  const int size = m->n * m->n;
  const double h = 1e-3;
  double tangent[2][81];
  sdr_stress_tangent(m->n, m->law, m->split, &m->moduli, g, tangent[0], tangent[1]);
  for (int k = 0; k < size; ++k) {
    double slope[2][9] = {{0.0}};
    const double there = g[k];
    for (int t = 0; t < 6; ++t) {
      sdr_point_stress s;
      g[k] = there + at[t] * h;
      sdr_stress_of(m->n, m->law, m->split, &m->moduli, g, &s);
      for (int r = 0; r < size; ++r) {
        slope[0][r] += of[t] / (60.0 * h) * s.p_plus[r];
        slope[1][r] += of[t] / (60.0 * h) * s.p_minus[r];
      }
    }
    g[k] = there;
    for (int which = 0; which < 2; ++which)
      for (int r = 0; r < size; ++r) {
        assert_near(slope[which][r], tangent[which][r * size + k], tolerance * young);
        assert_near(tangent[which][r * size + k], tangent[which][k * size + r], 1e-12 * young);
      }
  }
}

static void check_tangent(const material *m)
{
  uint64_t seed = 42;
  for (int trial = 0; trial < 6; ++trial) {
    double g[9];
    gradient_of(m, &seed, 0.5, g);
    check_tangent_at(m, g, 1e-7);
  }
}

static void tangent_is_the_slope_of_stress_to_1e_7_and_symmetric(void **state)
{
  (void)state;
  for_all(check_tangent);
}

/* Equal principal strains, in tension and in pressure, turned or not. */
static void check_equal(const material *m)
{
  for (int sign = -1; sign <= 1; sign += 2) {
    double g[9] = {0.0};
    for (int a = 0; a < m->n; ++a) g[a * m->n + a] = sign * 0.2;
    check_tangent_at(m, g, 1e-7);
    if (m->n == 3) {
      g[8] = sign * 0.35; /* two equal ones */
      check_tangent_at(m, g, 1e-7);
    }
  }
}

static void equal_principal_strains_need_no_direction(void **state)
{
  (void)state;
  for_all(check_equal);
}

/* Rotation by an axis and angle, n x n. */
static void rotation(int n, double angle, double *r)
{
  const double c = cos(angle), s = sin(angle), axis[3] = {2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0};
  static const int cross[9] = {0, -3, 2, 3, 0, -1, -2, 1, 0};
  if (n == 1) r[0] = 1.0;
  if (n == 2) {
    r[0] = r[3] = c;
    r[1] = -s;
    r[2] = s;
  }
  for (int a = 0; n == 3 && a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const int k = cross[3 * a + b];
      r[3 * a + b] = (a == b ? c : 0.0) + (1.0 - c) * axis[a] * axis[b] +
                     (k == 0  ? 0.0
                      : k > 0 ? s * axis[k - 1]
                              : -s * axis[-k - 1]);
    }
}

/* out = R (I + g) - I */
static void turned(int n, const double *r, const double *g, double *out)
{
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      out[n * a + b] = r[n * a + b] - (a == b ? 1.0 : 0.0);
      for (int k = 0; k < n; ++k) out[n * a + b] += r[n * a + k] * g[n * k + b];
    }
}

static void check_objective(const material *m)
{
  if (m->law == SDR_LINEAR) return;
  uint64_t seed = 99;
  const int n = m->n;
  for (int trial = 0; trial < 4; ++trial) {
    double g[9], r[9], t[9];
    gradient_of(m, &seed, 0.4, g);
    rotation(n, 1.0 + trial, r);
    turned(n, r, g, t);
    sdr_point_stress still, there;
    sdr_stress_of(n, m->law, m->split, &m->moduli, g, &still);
    sdr_stress_of(n, m->law, m->split, &m->moduli, t, &there);
    assert_near(there.plus, still.plus, 1e-13 * young);
    assert_near(there.minus, still.minus, 1e-13 * young);
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) {
        double plus = 0.0;
        for (int k = 0; k < n; ++k) plus += r[n * a + k] * still.p_plus[n * k + b];
        /* a few roundings of a tangent of up to 15 E (nu = 0.45, pressed) */
        assert_near(there.p_plus[n * a + b], plus, 1e-13 * 15.0 * young);
      }
  }
}

static void finite_strain_laws_turn_with_the_body_to_1e_13(void **state)
{
  (void)state;
  for_all(check_objective);
}

/* psi+ and psi- add up to the whole; growth in all directions is all psi+, shrinking all psi-. */
static void check_split(const material *m)
{
  uint64_t seed = 7;
  double g[9];
  sdr_point_stress s, whole;
  for (int trial = 0; trial < 6; ++trial) {
    gradient_of(m, &seed, 0.5, g);
    sdr_stress_of(m->n, m->law, m->split, &m->moduli, g, &s);
    sdr_stress_of(m->n, m->law, SDR_SPLIT_WHOLE, &m->moduli, g, &whole);
    assert_near(s.plus + s.minus, whole.plus, 1e-13 * young);
    assert_true(s.plus >= -1e-15 && s.minus >= 0.0);
    for (int k = 0; k < m->n * m->n; ++k)
      assert_near(s.p_plus[k] + s.p_minus[k], whole.p_plus[k], 2e-13 * young);
  }
  if (m->split == SDR_SPLIT_WHOLE) return;
  for (int sign = -1; sign <= 1; sign += 2) {
    memset(g, 0, sizeof g);
    for (int a = 0; a < m->n; ++a) g[a * m->n + a] = 0.1 * sign;
    sdr_stress_of(m->n, m->law, m->split, &m->moduli, g, &s);
    assert_near(sign > 0 ? s.minus : s.plus, 0.0, 1e-15);
    assert_true((sign > 0 ? s.plus : s.minus) > 0.0);
    assert_near(largest(sign > 0 ? s.p_minus : s.p_plus, m->n * m->n), 0.0, 1e-15);
  }
}

static void splits_add_up_and_divide_growth_from_shrinking(void **state)
{
  (void)state;
  for_all(check_split);
}

/* All laws are the linear one where strains are small: energy to second order in size. */
static void check_small(const material *m)
{
  uint64_t seed = 12;
  double g[9];
  gradient_of(m, &seed, 1e-6, g);
  material linear = *m;
  linear.law = SDR_LINEAR;
  linear.moduli =
      sdr_moduli_of(m->dimension, SDR_LINEAR, young, m->moduli.lambda > 0.0 ? 0.3 : 0.0);
  material own = *m;
  own.moduli = sdr_moduli_of(m->dimension, m->law, young, m->moduli.lambda > 0.0 ? 0.3 : 0.0);
  sdr_point_stress s, expected;
  sdr_stress_of(m->n, m->law, m->split, &own.moduli, g, &s);
  sdr_stress_of(m->n, SDR_LINEAR, m->split, &linear.moduli, g, &expected);
  assert_near(s.plus, expected.plus, 1e-5 * (expected.plus + expected.minus));
  assert_near(s.minus, expected.minus, 1e-5 * (expected.plus + expected.minus));
  for (int k = 0; k < m->n * m->n; ++k)
    assert_near(s.p_plus[k], expected.p_plus[k], 1e-5 * 1e-6 * young);
}

static void every_law_is_linear_for_small_strains(void **state)
{
  (void)state;
  for_all(check_small);
}

/* The energy of plane stress is that of the body, at the thickness that no stress holds. */
static void plane_stress_has_no_stress_across(void **state)
{
  (void)state;
  const double g[4] = {0.3, 0.1, -0.05, -0.15};
  const sdr_moduli plane = sdr_moduli_of(SDR_PLANE_STRESS, SDR_NEO_HOOKEAN, young, 0.3);
  const sdr_moduli solid = sdr_moduli_of(SDR_3D, SDR_NEO_HOOKEAN, young, 0.3);
  const double j = (1.0 + g[0]) * (1.0 + g[3]) - g[1] * g[2];
  const double across = sdr_thickness_stretch(&plane, log(j));
  const double full[9] = {g[0], g[1], 0.0, g[2], g[3], 0.0, 0.0, 0.0, across - 1.0};
  sdr_point_stress s, expected;
  sdr_stress_of(2, SDR_NEO_HOOKEAN, SDR_SPLIT_WHOLE, &plane, g, &s);
  sdr_stress_of(3, SDR_NEO_HOOKEAN, SDR_SPLIT_WHOLE, &solid, full, &expected);
  assert_near(expected.p_plus[8], 0.0, 1e-14 * young);
  assert_near(s.plus, expected.plus, 1e-14 * young);
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b)
      assert_near(s.p_plus[2 * a + b], expected.p_plus[3 * a + b], 1e-14 * young);
  double flat[4], solid_stress[9];
  sdr_cauchy(2, g, s.p_plus, across, flat);
  sdr_cauchy(3, full, expected.p_plus, 1.0, solid_stress);
  assert_near(flat[1], solid_stress[1], 1e-14 * young);
  assert_near(flat[1], flat[2], 1e-14 * young);
}

/* Pressed to nothing and turned inside out: finite, and still the slope of the energy. */
static void check_crushed(const material *m)
{
  if (m->law != SDR_NEO_HOOKEAN) return;
  double g[9] = {0.0};
  for (int a = 0; a < m->n; ++a) g[a * m->n + a] = a == 0 ? -0.97 : 0.02 * a;
  check_tangent_at(m, g, 1e-7 * 2e3); /* stiff by a factor 1/0.1^2 and more */
  g[0] = -1.3;
  sdr_point_stress s;
  sdr_stress_of(m->n, m->law, m->split, &m->moduli, g, &s);
  assert_true(isfinite(s.plus) && isfinite(s.minus));
}

static void a_crushed_point_has_a_finite_energy(void **state)
{
  (void)state;
  for_all(check_crushed);
}

static void eigenvectors_of_any_symmetric_matrix_are_orthonormal(void **state)
{
  (void)state;
  uint64_t seed = 5;
  for (int trial = 0; trial < 200; ++trial) {
    double a[9], e[3], v[9];
    for (int r = 0; r < 3; ++r)
      for (int c = r; c < 3; ++c)
        a[3 * r + c] = a[3 * c + r] = trial % 5 == 0 ? r == c : noise(&seed);
    if (trial % 3 == 0) a[1] = a[3] = 1e-9 * a[1];
    sdr_eigen3(a, e, v);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) {
        double back = 0.0, unit = 0.0;
        for (int k = 0; k < 3; ++k) {
          back += v[3 * r + k] * e[k] * v[3 * c + k];
          unit += v[3 * k + r] * v[3 * k + c];
        }
        assert_near(back, a[3 * r + c], 1e-14);
        assert_near(unit, r == c ? 1.0 : 0.0, 1e-14);
      }
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(stress_is_the_slope_of_its_energy_to_1e_8),
      cmocka_unit_test(tangent_is_the_slope_of_stress_to_1e_7_and_symmetric),
      cmocka_unit_test(equal_principal_strains_need_no_direction),
      cmocka_unit_test(finite_strain_laws_turn_with_the_body_to_1e_13),
      cmocka_unit_test(splits_add_up_and_divide_growth_from_shrinking),
      cmocka_unit_test(every_law_is_linear_for_small_strains),
      cmocka_unit_test(plane_stress_has_no_stress_across),
      cmocka_unit_test(a_crushed_point_has_a_finite_energy),
      cmocka_unit_test(eigenvectors_of_any_symmetric_matrix_are_orthonormal),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
