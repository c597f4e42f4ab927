/* Table 1 of 000 and 002, first row: with one horizon everywhere the dual-horizon bond-based body
   is the traditional one, written here from its own formulas: one micromodulus c for both ends of a
   bond and the prototype microelastic brittle law. */
#include "support/body.h"

enum { STEPS = 8 };

/* Micromodulus and critical stretch of traditional bond-based peridynamics with horizon d, from
   Young's modulus and toughness (unit thickness and area). */
static double micromodulus(sdr_dimension dimension, double young, double d)
{
  const double pi = 3.14159265358979323846;
  switch (dimension) {
  case SDR_1D:
    return 2.0 * young / (d * d);
  case SDR_PLANE_STRESS:
    return 9.0 * young / (pi * d * d * d);
  case SDR_PLANE_STRAIN:
    return 48.0 * young / (5.0 * pi * d * d * d);
  default:
    return 12.0 * young / (pi * d * d * d * d);
  }
}

static double critical_stretch(sdr_dimension dimension, double young, double toughness, double d)
{
  const double pi = 3.14159265358979323846, ratio = toughness / (young * d);
  switch (dimension) {
  case SDR_1D:
    return sqrt(3.0 * ratio);
  case SDR_PLANE_STRESS:
    return sqrt(4.0 * pi / 9.0 * ratio);
  case SDR_PLANE_STRAIN:
    return sqrt(5.0 * pi / 12.0 * ratio);
  default:
    return sqrt(5.0 / 6.0 * ratio);
  }
}

/* A directed table of broken bonds, count x count. */
typedef struct {
  const sdr_points *points;
  double c, s0, horizon;
  uint8_t *broken;
} traditional;

static double length_of(const traditional *t, int32_t i, int32_t j, double *const u[3],
                        double xi[3])
{
  double square = 0.0;
  for (int a = 0; a < t->points->components; ++a) {
    xi[a] = t->points->x[a][j] - t->points->x[a][i] + (u ? u[a][j] - u[a][i] : 0.0);
    square += xi[a] * xi[a];
  }
  return sqrt(square);
}

/* f_i = sum over the horizon of c s n V_j V_i, with what the stretch breaks. */
static void traditional_force(traditional *t, double *const u[3], double *const f[3])
{
  const sdr_points *p = t->points;
  for (int32_t i = 0; i < p->count; ++i) {
    double sum[3] = {0.0};
    for (int32_t j = 0; j < p->count; ++j) {
      double xi[3], y[3];
      const double before = length_of(t, i, j, NULL, xi);
      if (i == j || before > t->horizon * (1.0 + 1e-9)) continue;
      const double now = length_of(t, i, j, u, y), s = (now - before) / before;
      uint8_t *const broken = &t->broken[(size_t)i * (size_t)p->count + (size_t)j];
      if (s > t->s0) *broken = 1;
      if (*broken) continue;
      for (int a = 0; a < p->components; ++a)
        sum[a] += t->c * s * y[a] / now * p->volume[i] * p->volume[j];
    }
    for (int a = 0; a < p->components; ++a) f[a][i] = sum[a];
  }
}

static sdr_model *dual_horizon(const sdr_points *points, sdr_dimension dimension, double young,
                               double toughness, sdr_families **families)
{
  const sdr_families_how plain = {.printed = 1};
  assert_int_equal(sdr_families_create(points, &plain, families), SDR_OK);
  const sdr_bonds_how bonds_how = {
      .weight = sdr_families_weight, .context = *families, .bulk = (*families)->bulk};
  sdr_bonds *bonds;
  assert_int_equal(sdr_bonds_create(points, &bonds_how, &bonds), SDR_OK);
  double *moduli = sdr_alloc(sdr_points_padded(points), sizeof *moduli);
  for (int32_t i = 0; i < points->count; ++i) moduli[i] = young;
  const sdr_bond_based_how how = {.dimension = dimension,
                                  .law = SDR_LAW_CRITICAL_STRETCH,
                                  .calibration = SDR_CALIBRATE_PRINTED,
                                  .young = moduli,
                                  .toughness = &toughness};
  sdr_model *model;
  assert_int_equal(sdr_bond_based_create(points, bonds, *families, &how, &model), SDR_OK);
  sdr_free(moduli);
  return model;
}

/* Steps of growing noise that break bonds; the force of each step is compared. */
static double largest_error(const body_how *how, double toughness, int64_t *broken)
{
  sdr_points *points = body_points(how, NULL);
  const double horizon = points->horizon[0];
  traditional t = {.points = points,
                   .c = micromodulus(how->dimension, body_young, horizon),
                   .s0 = critical_stretch(how->dimension, body_young, toughness, horizon),
                   .horizon = horizon,
                   .broken = sdr_alloc((size_t)points->count, (size_t)points->count)};
  sdr_families *families;
  sdr_model *model = dual_horizon(points, how->dimension, body_young, toughness, &families);
  double *u[3], *v[3], *ours[3], *theirs[3], worst = 0.0;
  vector_create(points, u);
  vector_create(points, v);
  vector_create(points, ours);
  vector_create(points, theirs);
  for (uint64_t step = 1; step <= STEPS; ++step) {
    vector_noise(points, 0.15 * (double)step * t.s0 * body_spacing, step, u);
    model->ops->force_commit(model, u, v, 0.0, ours);
    traditional_force(&t, u, theirs);
    worst = fmax(worst, vector_difference(points, ours, theirs) / vector_largest(points, theirs));
  }
  *broken = 0;
  for (size_t k = 0; k < (size_t)points->count * (size_t)points->count; ++k) *broken += t.broken[k];
  sdr_energies e;
  model->ops->energies(model, u, &e);
  assert_int_equal(e.broken, *broken);
  vector_destroy(u);
  vector_destroy(v);
  vector_destroy(ours);
  vector_destroy(theirs);
  sdr_free(t.broken);
  model->ops->destroy(model);
  sdr_families_destroy(&families);
  sdr_points_destroy(&points);
  return worst;
}

static void constant_horizons_give_traditional_peridynamics_to_round_off(void **state)
{
  (void)state;
  static const body_how shapes[] = {
      {.dimension = SDR_1D, .cells = {60}},
      {.dimension = SDR_PLANE_STRESS, .cells = {21, 14}},
      {.dimension = SDR_PLANE_STRAIN, .cells = {14, 15}, .angle = 0.4},
      {.dimension = SDR_PLANE_STRESS, .cells = {15, 15}, .jitter = 0.2},
      {.dimension = SDR_3D, .cells = {7, 8, 6}, .ratio = 2.01}};
  for (size_t k = 0; k < sizeof shapes / sizeof *shapes; ++k) {
    int64_t broken;
    const double error = largest_error(&shapes[k], 100.0, &broken);
    print_message("shape %zu: largest difference %.1e of the largest force, %lld bonds broken\n", k,
                  error, (long long)broken);
    assert_true(broken > 20);
    assert_at_most(error, 1e-12); /* s = (l - |xi|)/|xi| cancels: 1e-16/s */
  }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(constant_horizons_give_traditional_peridynamics_to_round_off)};
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
