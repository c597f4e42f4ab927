/* What a uniformly strained body stores: exact in dilation, the family's moment sums otherwise, and
   exact throughout with isotropic weights (theory sec. 3 and 5). */
#include "damage/calibration.h"
#include "support/body.h"

static const double young = 70e9;

/* Bodies with one point in the middle whose family is complete. */
static const body_how shapes[] = {{.dimension = SDR_1D, .cells = {15}},
                                  {.dimension = SDR_PLANE_STRESS, .cells = {11, 11}},
                                  {.dimension = SDR_PLANE_STRESS, .cells = {13, 13}, .ratio = 4.1},
                                  {.dimension = SDR_PLANE_STRAIN, .cells = {11, 13}, .angle = 0.4},
                                  {.dimension = SDR_3D, .cells = {9, 9, 11}},
                                  {.dimension = SDR_3D, .cells = {9, 11, 9}, .angle = 0.3}};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static int32_t middle(const body *b)
{
  const double origin[3] = {0.0, 0.0, 0.0};
  return sdr_points_nearest(b->points, origin);
}

/* Stored energy per volume at the middle point under a displacement gradient. */
static double density(const body *b, const double gradient[9])
{
  double *u[3], *out = sdr_alloc((size_t)b->points->count, sizeof *out);
  vector_create(b->points, u);
  vector_linear(b->points, gradient, u);
  assert_int_equal(b->model->ops->field(b->model, u, SDR_FIELD_ENERGY_DENSITY, out), SDR_OK);
  const double value = out[middle(b)];
  vector_destroy(u);
  sdr_free(out);
  return value;
}

/* Second derivative of the energy density along a gradient: the odd part, geometry's, cancels. */
static double curvature(const body *b, const double direction[9], double size)
{
  double plus[9], minus[9];
  for (int c = 0; c < 9; ++c) {
    plus[c] = size * direction[c];
    minus[c] = -plus[c];
  }
  return (density(b, plus) + density(b, minus)) / (size * size);
}

static const double dilation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, uniaxial[9] = {1},
                    shear[9] = {0, 0.5, 0, 0.5, 0, 0, 0, 0, 0},
                    two_axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 0};

/* Of an isotropic body: 1/2 C : eps : eps with unit eps, written out. */
static double exact_dilation(sdr_dimension dimension)
{
  switch (dimension) {
  case SDR_1D:
    return 0.5 * young;
  case SDR_PLANE_STRESS: /* nu 1/3 */
    return young / (1.0 - 1.0 / 3.0);
  case SDR_PLANE_STRAIN: /* nu 1/4 */
    return young / (1.25 * 0.5);
  default:
    return 3.0 * young / (2.0 * 0.5);
  }
}

/* Weights whose constants are fixed by dilation. */
static const sdr_families_how dilating[] = {
    {0},
    {.partial_volume = 1},
    {.correction = SDR_CORRECTION_ISO},
    {.influence = SDR_INFLUENCE_CUBIC, .correction = SDR_CORRECTION_ISO},
    {.influence = SDR_INFLUENCE_INVERSE},
    {.influence = SDR_INFLUENCE_INVERSE_SQUARE},
    {.influence = SDR_INFLUENCE_LINEAR, .partial_volume = 1},
    {.influence = SDR_INFLUENCE_GAUSSIAN},
};
enum { DILATING = sizeof dilating / sizeof *dilating };

static void uniform_dilation_stores_the_exact_energy(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int weight = 0; weight < DILATING; ++weight)
      for (int loose = 0; loose < 2; ++loose) {
        body_how how = shapes[k];
        how.weight = dilating[weight];
        how.force_loose = loose;
        body b = body_create(&how);
        double stretched[9];
        for (int c = 0; c < 9; ++c) stretched[c] = 0.01 * dilation[c];
        const double exact = exact_dilation(how.dimension) * 1e-4;
        assert_near(density(&b, stretched), exact, 1e-12 * exact);
        body_destroy(&b);
      }
}

static double whole_volume(const sdr_points *points)
{
  double sum = 0.0;
  for (int32_t i = 0; i < points->count; ++i) sum += points->volume[i];
  return sum;
}

static void surface_iso_stores_the_exact_energy_of_dilation_in_the_whole_body(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int jitter = 0; jitter < 2; ++jitter) {
      body_how how = shapes[k];
      how.weight =
          (sdr_families_how){.partial_volume = 1, .correction = SDR_CORRECTION_SURFACE_ISO};
      how.jitter = 0.2 * jitter;
      how.horizon_spread = 0.1 * jitter;
      body b = body_create(&how);
      double *u[3], stretched[9];
      sdr_energies energies;
      for (int c = 0; c < 9; ++c) stretched[c] = 0.01 * dilation[c];
      vector_create(b.points, u);
      vector_linear(b.points, stretched, u);
      b.model->ops->energies(b.model, u, &energies);
      const double exact = exact_dilation(how.dimension) * 1e-4 * whole_volume(b.points);
      assert_near(energies.stored, exact, 1e-11 * exact);
      vector_destroy(u);
      body_destroy(&b);
    }
}

/* Factors of madenci_oterkus promise uniaxial strains. */
static void madenci_oterkus_stores_the_exact_energy_of_axial_strain_in_the_bulk(void **state)
{
  (void)state;
  static const body_how large[] = {
      {.dimension = SDR_1D, .cells = {25}},
      {.dimension = SDR_PLANE_STRESS, .cells = {17, 17}},
      {.dimension = SDR_PLANE_STRAIN, .cells = {17, 19}, .force_loose = 1},
      {.dimension = SDR_3D, .cells = {11, 11, 11}, .ratio = 2.1}};
  for (int k = 0; k < 4; ++k) {
    body_how how = large[k];
    how.weight = (sdr_families_how){.correction = SDR_CORRECTION_MADENCI_OTERKUS};
    body b = body_create(&how);
    const double nu = how.dimension == SDR_PLANE_STRESS ? 1.0 / 3.0 : 0.25;
    const double c11 = how.dimension == SDR_1D ? young
                       : how.dimension == SDR_PLANE_STRESS
                           ? young / (1.0 - nu * nu)
                           : young * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
    assert_near(curvature(&b, uniaxial, 1e-5), c11, 1e-9 * c11);
    body_destroy(&b);
  }
}

/* sum over a square lattice's family of |xi| n_x^p n_y^q, over sum |xi|; axes turned by angle. */
static double moment(const body_how *how, int p, int q)
{
  const int n = sdr_components(how->dimension);
  const double ratio = how->ratio > 0.0 ? how->ratio : 3.015;
  double sum = 0.0, all = 0.0;
  for (int z = n > 2 ? -5 : 0; z <= (n > 2 ? 5 : 0); ++z)
    for (int y = n > 1 ? -5 : 0; y <= (n > 1 ? 5 : 0); ++y)
      for (int x = -5; x <= 5; ++x) {
        const double length = sqrt((double)(x * x + y * y + z * z));
        if (length <= 0.0 || length > ratio) continue;
        const double nx = (cos(how->angle) * x - sin(how->angle) * y) / length;
        const double ny = (sin(how->angle) * x + cos(how->angle) * y) / length;
        sum += length * pow(nx, p) * pow(ny, q);
        all += length;
      }
  return sum / all;
}

static void other_strains_store_the_moment_sums_of_the_family(void **state)
{
  (void)state;
  for (int k = 1; k < SHAPES; ++k) {
    body b = body_create(&shapes[k]);
    /* C sum |xi| V, which dilation fixes: its energy is 1/2 of it */
    const double whole = 2.0 * exact_dilation(b.how.dimension);
    const double c11 = whole * moment(&b.how, 4, 0), c66 = whole * moment(&b.how, 2, 2);
    const double c22 = whole * moment(&b.how, 0, 4);
    assert_near(curvature(&b, uniaxial, 1e-5), c11, 1e-9 * c11);
    assert_near(curvature(&b, shear, 1e-5), c66, 1e-9 * c11);
    assert_near(curvature(&b, two_axes, 1e-5), c11 + c22 + 2.0 * c66, 1e-9 * c11);
    body_destroy(&b);
  }
}

static void isotropic_weights_store_the_exact_energy_of_any_strain(void **state)
{
  (void)state;
  for (int k = 1; k < SHAPES; ++k) {
    body_how how = shapes[k];
    how.weight.correction = SDR_CORRECTION_ISO;
    body b = body_create(&how);
    const double nu = how.dimension == SDR_PLANE_STRESS ? 1.0 / 3.0 : 0.25;
    const double plain = young / (1.0 - nu * nu);
    const double strain = young * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
    const double c11 = how.dimension == SDR_PLANE_STRESS ? plain : strain;
    const double c66 = young / (2.0 * (1.0 + nu));
    assert_near(curvature(&b, uniaxial, 1e-5), c11, 1e-9 * c11);
    assert_near(curvature(&b, shear, 1e-5), c66, 1e-9 * c11);
    assert_near(curvature(&b, two_axes, 1e-5), 4.0 * (c11 - c66), 1e-9 * c11); /* c12 = c11-2c66 */
    body_destroy(&b);
  }
}

/* The lattice's anisotropy, as theory sec. 3 has it for m = 3.015. */
static void the_lattice_is_off_by_what_theory_says(void **state)
{
  (void)state;
  static const struct {
    sdr_dimension dimension;
    int32_t cells[3];
    double c11, c12; /* % */
  } cases[] = {{SDR_PLANE_STRESS, {9, 9, 1}, 1.1, -3.4},
               {SDR_PLANE_STRAIN, {9, 9, 1}, 1.1, -3.4},
               {SDR_3D, {7, 7, 7}, -5.7, 8.6}};
  for (int k = 0; k < 3; ++k) {
    body_how how = {.dimension = cases[k].dimension};
    memcpy(how.cells, cases[k].cells, sizeof how.cells);
    body b = body_create(&how);
    const sdr_effective_stiffness s =
        sdr_stiffness_of(how.dimension, b.families->family, body_micromodulus(&b, 0), young);
    assert_near(100.0 * (s.c11 / s.exact_c11 - 1.0), cases[k].c11, 0.05);
    assert_near(100.0 * (s.c12 / s.exact_c12 - 1.0), cases[k].c12, 0.05);
    assert_near(curvature(&b, shear, 1e-5), s.c66, 1e-9 * s.c11);
    body_destroy(&b);
  }
}

static void a_pure_compression_stores_the_same_with_any_damage_law(void **state)
{
  (void)state;
  for (int law = SDR_LAW_NONE; law < SDR_LAW_COUNT; ++law) {
    body_how how = shapes[1];
    how.law = (sdr_law)law;
    how.stretch = 1e-6;
    body b = body_create(&how);
    double squeezed[9];
    for (int c = 0; c < 9; ++c) squeezed[c] = -0.01 * dilation[c];
    const double exact = exact_dilation(how.dimension) * 1e-4;
    assert_near(density(&b, squeezed), exact, 1e-12 * exact);
    body_destroy(&b);
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(uniform_dilation_stores_the_exact_energy),
      cmocka_unit_test(surface_iso_stores_the_exact_energy_of_dilation_in_the_whole_body),
      cmocka_unit_test(madenci_oterkus_stores_the_exact_energy_of_axial_strain_in_the_bulk),
      cmocka_unit_test(other_strains_store_the_moment_sums_of_the_family),
      cmocka_unit_test(isotropic_weights_store_the_exact_energy_of_any_strain),
      cmocka_unit_test(the_lattice_is_off_by_what_theory_says),
      cmocka_unit_test(a_pure_compression_stores_the_same_with_any_damage_law),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
