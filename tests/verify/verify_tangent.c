/* With histories in double the tangent is the gradient of the force, and the force that of the
   energy, to 1e-7 of the largest entry: for every law, while damage grows, with bonds cut and
   protected, with horizons that differ, in runs and loose pairs. Differences are taken where no
   bond of the point that moves is near a kink of its law (theory, Derivative tests). */
#include "mechanics/bond_internal.h"
#include "mechanics/tangent.h"
#include "support/body.h"

static const body_how shapes[] = {
    {.dimension = SDR_1D, .cells = {40}},
    {.dimension = SDR_PLANE_STRESS, .cells = {11, 9}},
    {.dimension = SDR_PLANE_STRAIN,
     .cells = {9, 10},
     .angle = 0.3,
     .weight = {.correction = SDR_CORRECTION_ISO}},
    {.dimension = SDR_PLANE_STRESS, .cells = {10, 9}, .jitter = 0.3, .horizon_spread = 0.3},
    {.dimension = SDR_3D, .cells = {9, 3, 4}, .ratio = 1.75},
    {.dimension = SDR_3D, .cells = {8, 3, 3}, .ratio = 1.8, .jitter = 0.2, .horizon_spread = 0.2},
};
enum { SHAPES = sizeof shapes / sizeof *shapes, EVERY = 5 };

static const double step = 2e-5; /* spacings */

/* ---- states ---------------------------------------------------------------------------------- */

/* Stretches of about `factor` times 0.012 to 0.02, and noise that makes some bonds load, others
   unload and others shorten. */
static void stretched(const body *b, double factor, double spread, uint64_t seed,
                      double *const u[3])
{
  const double gradient[9] = {0.020, 0.003, 0.000, 0.001, 0.012, 0.001, 0.000, -0.001, 0.016};
  double *extra[3], scaled[9];
  for (int c = 0; c < 9; ++c) scaled[c] = factor * gradient[c];
  vector_create(b->points, extra);
  vector_noise(b->points, spread * body_spacing, seed, extra);
  vector_linear(b->points, scaled, u);
  vector_add(b->points, u, 1.0, extra, u);
  vector_destroy(extra);
}

typedef struct {
  const body *b;
  double *const *u;
  uint8_t *near; /* a point: 1 if one of its bonds is near a kink */
} kinks;

/* 1 if s is within the reach of a difference of a kink of the law with constants q and r. */
static int near_kink(const sdr_bond_body *bonds, double s, double k, double q, double r,
                     double reach)
{
  const double knots[5] = {
      0.0, k, bonds->law == SDR_LAW_AT1 ? sqrt(0.5 * q) : q,
      bonds->law == SDR_LAW_COHESIVE ? SDR_COHESIVE_MU * q : q,
      bonds->law == SDR_LAW_COHESIVE ? q * (SDR_COHESIVE_MU + SDR_COHESIVE_GAMMA / r) : q};
  for (int n = 0; n < 5; ++n)
    if (fabs(s - knots[n]) < reach) return 1;
  return 0;
}

static void look_at_pair(void *context, const sdr_pair *pair)
{
  const kinks *call = context;
  const sdr_bond_body *bonds = &((const sdr_bond_model *)call->b->model)->body;
  if (!sdr_law_softens((int)bonds->law)) return;
  const double k = (pair->loose ? bonds->loose_history : bonds->history)[pair->slot];
  const double s = sdr_pair_stretch(pair, bonds->points->components, call->u);
  const double reach = 4.0 * step * body_spacing / pair->length;
  if (k < 0.0) return; /* cut or protected */
  if (near_kink(bonds, s, k, sdr_body_threshold(bonds, pair->i), sdr_body_decline(bonds, pair->i),
                reach) ||
      near_kink(bonds, s, k, sdr_body_threshold(bonds, pair->j), sdr_body_decline(bonds, pair->j),
                reach))
    call->near[pair->i] = call->near[pair->j] = 1;
}

/* Points whose bonds are all away from kinks. */
static uint8_t *points_near_kinks(const body *b, double *const u[3])
{
  kinks call = {b, u, sdr_alloc((size_t)b->points->count, 1)};
  sdr_bonds_visit(b->bonds, b->points, look_at_pair, &call);
  return call.near;
}

/* ---- differences ----------------------------------------------------------------------------- */

static double energy(const body *b, double *const u[3])
{
  sdr_energies e;
  b->model->ops->energies(b->model, u, &e);
  return e.stored + e.dissipated;
}

/* slope = -df/du_ia and the return value d energy/du_ia, by differences of fourth order. */
static double differences(const body *b, double *const u[3], int a, int32_t i,
                          double *const slope[3])
{
  static const double factor[4] = {1.0, -8.0, 8.0, -1.0};
  const double there = u[a][i], h = step * body_spacing;
  double *f[3], sum = 0.0;
  vector_create(b->points, f);
  for (int c = 0; c < b->points->components; ++c)
    memset(slope[c], 0, (size_t)b->points->count * sizeof(double));
  for (int k = 0; k < 4; ++k) {
    u[a][i] = there + h * (k < 2 ? k - 2 : k - 1);
    b->model->ops->force(b->model, u, f);
    vector_add(b->points, slope, -factor[k] / (12.0 * h), f, slope);
    sum += factor[k] / (12.0 * h) * energy(b, u);
  }
  u[a][i] = there;
  vector_destroy(f);
  return sum;
}

typedef struct {
  double *unit[3], *column[3], *expected[3], *f[3], *diagonal;
  double largest; /* entry of the diagonal blocks */
} work;

static work work_create(const body *b, double *const u[3])
{
  work w = {0};
  const size_t entries = (size_t)(b->points->count * b->points->components * b->points->components);
  vector_create(b->points, w.unit);
  vector_create(b->points, w.column);
  vector_create(b->points, w.expected);
  vector_create(b->points, w.f);
  w.diagonal = sdr_alloc(entries, sizeof(double));
  assert_int_equal(b->model->ops->tangent_diagonal(b->model, u, w.diagonal), SDR_OK);
  for (size_t k = 0; k < entries; ++k) w.largest = fmax(w.largest, fabs(w.diagonal[k]));
  b->model->ops->force(b->model, u, w.f);
  return w;
}

static void work_destroy(work *w)
{
  vector_destroy(w->unit);
  vector_destroy(w->column);
  vector_destroy(w->expected);
  vector_destroy(w->f);
  sdr_free(w->diagonal);
}

static void check_component(const body *b, work *w, double *const u[3], int a, int32_t i)
{
  const int n = b->points->components;
  w->unit[a][i] = 1.0;
  assert_int_equal(b->model->ops->tangent_times(b->model, u, w->unit, w->column), SDR_OK);
  w->unit[a][i] = 0.0;
  const double slope = differences(b, u, a, i, w->expected);
  assert_at_most(vector_difference(b->points, w->column, w->expected), 1e-7 * w->largest);
  assert_near(-slope, w->f[a][i], 1e-7 * vector_largest(b->points, w->f));
  for (int c = 0; c < n; ++c)
    assert_near(w->diagonal[(size_t)i * (size_t)(n * n) + (size_t)(c * n + a)], w->column[c][i],
                1e-13 * w->largest);
}

/* Products and blocks of the tangent that is kept, at another u by then. */
static void check_kept(const body *b, double *const u[3])
{
  const sdr_model_ops *ops = b->model->ops;
  work w = work_create(b, u);
  const int n = b->points->components;
  double *blocks = sdr_alloc((size_t)(b->points->count * n * n), sizeof *blocks);
  vector_noise(b->points, 1.0, 77, w.unit);
  assert_int_equal(ops->tangent_times(b->model, u, w.unit, w.expected), SDR_OK);
  assert_int_equal(ops->tangent_keep(b->model, u), SDR_OK);
  for (int a = 0; a < n; ++a) u[a][0] += body_spacing;
  ops->kept_times(b->model, w.unit, w.column);
  ops->kept_diagonal(b->model, blocks);
  for (int a = 0; a < n; ++a) u[a][0] -= body_spacing;
  assert_at_most(vector_difference(b->points, w.column, w.expected), 1e-12 * w.largest);
  for (int32_t k = 0; k < b->points->count * n * n; ++k)
    assert_near(blocks[k], w.diagonal[k], 1e-13 * w.largest);
  work_destroy(&w);
  sdr_free(blocks);
}

static int32_t check_gradients(const body *b, double *const u[3])
{
  uint8_t *near = points_near_kinks(b, u);
  work w = work_create(b, u);
  int32_t checked = 0;
  for (int32_t i = 0; i < b->points->count; i += EVERY) {
    if (near[i]) continue;
    ++checked;
    for (int a = 0; a < b->points->components; ++a) check_component(b, &w, u, a, i);
  }
  work_destroy(&w);
  sdr_free(near);
  return checked;
}

/* ---- bodies ---------------------------------------------------------------------------------- */

static body body_of(int shape, sdr_law law, int variant)
{
  body_how how = shapes[shape];
  int64_t cut;
  how.precise = 1;
  how.law = law;
  how.force_loose = variant & 1;
  how.scatter = variant & 2 ? 0.3 : 0.0;
  how.two_materials = how.scatter > 0.0;
  how.stretch = law == SDR_LAW_COHESIVE ? 0.04 : 0.016;
  how.ell = 1.3;
  body b = body_create(&how);
  if (variant & 2)
    assert_int_equal(b.model->ops->mark(b.model, body_cut_and_protect, NULL, &cut), SDR_OK);
  return b;
}

/* A history, then a state where damage grows in some bonds and others go back. */
static void check_body(int shape, sdr_law law, int variant)
{
  body b = body_of(shape, law, variant);
  double *u[3];
  sdr_energies before, now;
  vector_create(b.points, u);
  stretched(&b, 0.8, 4e-4, 3, u);
  b.model->ops->commit(b.model, u);
  b.model->ops->energies(b.model, u, &before);
  int32_t checked = 0;
  for (int state = 0; state < 3; ++state) {
    static const double factor[3] = {1.3, 0.5, -0.4};
    stretched(&b, factor[state], 2e-3, 4 + (uint64_t)state, u);
    checked += check_gradients(&b, u);
    check_kept(&b, u);
    b.model->ops->energies(b.model, u, &now);
    if (state == 0 && sdr_law_softens((int)law)) {
      assert_true(now.dissipated > 1.05 * before.dissipated);
      assert_true(now.max_damage > 0.2);
    }
  }
  assert_true(checked >= b.points->count / EVERY); /* of three times as many */
  vector_destroy(u);
  body_destroy(&b);
}

/* What is committed is what the energy had taken in already. */
static void check_commit(int shape, sdr_law law, int variant)
{
  body b = body_of(shape, law, variant);
  double *u[3];
  sdr_energies before, after;
  vector_create(b.points, u);
  for (int state = 0; state < 3; ++state) {
    static const double factor[3] = {0.9, 0.5, 1.3};
    stretched(&b, factor[state], 2e-3, 4 + (uint64_t)state, u);
    b.model->ops->energies(b.model, u, &before);
    b.model->ops->commit(b.model, u);
    b.model->ops->energies(b.model, u, &after);
    assert_near(after.stored, before.stored, 1e-13 * before.stored);
    assert_near(after.dissipated, before.dissipated, 1e-13 * before.dissipated);
    stretched(&b, 0.1, 0.0, 4, u);
    b.model->ops->energies(b.model, u, &after); /* and it stays */
    assert_near(after.dissipated, before.dissipated, 1e-13 * before.dissipated);
  }
  vector_destroy(u);
  body_destroy(&b);
}

#define CHECK_COMMIT(law, code)                                                                    \
  for (int shape = 0; shape < SHAPES && sdr_law_softens(code); ++shape)                            \
    for (int variant = 0; variant < 4; ++variant)                                                  \
      if (!((variant & 1) && shapes[shape].jitter > 0.0)) check_commit(shape, code, variant);

static void histories_take_in_what_energies_had(void **state)
{
  (void)state;
  SDR_LAWS(CHECK_COMMIT)
}

#define CHECK_LAW(law, code)                                                                       \
  for (int shape = 0; shape < SHAPES; ++shape)                                                     \
    for (int variant = 0; variant < 4; ++variant)                                                  \
      if (!((variant & 1) && shapes[shape].jitter > 0.0)) check_body(shape, code, variant);

static void tangent_and_force_are_gradients_for_every_law(void **state)
{
  (void)state;
  SDR_LAWS(CHECK_LAW)
}

/* ---- secant ---------------------------------------------------------------------------------- */

/* v . K v over v . v of a matrix. */
static double quotient(const sdr_csr *k, uint64_t seed, double *x, double *y)
{
  double top = 0.0, bottom = 0.0;
  for (int32_t r = 0; r < k->rows; ++r) x[r] = noise(&seed);
  sdr_csr_times(k, x, y);
  for (int32_t r = 0; r < k->rows; ++r) {
    top += x[r] * y[r];
    bottom += x[r] * x[r];
  }
  return top / bottom;
}

static void the_secant_is_never_negative_where_the_tangent_is(void **state)
{
  (void)state;
  body b = body_of(1, SDR_LAW_VARIATIONAL, 0);
  sdr_tangent *exact = NULL, *secant = NULL;
  double *u[3], least[2] = {INFINITY, INFINITY};
  const size_t unknowns = (size_t)b.points->count * 2;
  double *x = sdr_alloc(unknowns, sizeof *x), *y = sdr_alloc(unknowns, sizeof *y);
  vector_create(b.points, u);
  stretched(&b, 2.0, 2e-3, 5, u); /* nearly all bonds past their peak */
  assert_int_equal(sdr_tangent_create(b.model, SDR_TANGENT_EXACT, &exact), SDR_OK);
  assert_int_equal(sdr_tangent_create(b.model, SDR_TANGENT_SECANT, &secant), SDR_OK);
  assert_int_equal(sdr_tangent_update(exact, NULL, u), SDR_OK);
  assert_int_equal(sdr_tangent_update(secant, NULL, u), SDR_OK);
  for (uint64_t seed = 1; seed < 40; ++seed) {
    least[0] = fmin(least[0], quotient(sdr_tangent_matrix(exact), seed, x, y));
    least[1] = fmin(least[1], quotient(sdr_tangent_matrix(secant), seed, x, y));
  }
  assert_true(least[0] < 0.0);
  assert_true(least[1] > 0.0);
  sdr_tangent_destroy(&exact);
  sdr_tangent_destroy(&secant);
  vector_destroy(u);
  sdr_free(x);
  sdr_free(y);
  body_destroy(&b);
}

/* A bar's bonds do not turn, and unloading follows the secant. */
static void on_unloading_a_bar_has_its_secant_for_a_tangent(void **state)
{
  (void)state;
#define COMPARE(law, code)                                                                         \
  {                                                                                                \
    body b = body_of(0, code, 2);                                                                  \
    sdr_tangent *exact = NULL, *secant = NULL;                                                     \
    double *u[3];                                                                                  \
    vector_create(b.points, u);                                                                    \
    stretched(&b, 1.2, 4e-4, 3, u);                                                                \
    b.model->ops->commit(b.model, u);                                                              \
    stretched(&b, 0.6, 4e-4, 4, u);                                                                \
    assert_int_equal(sdr_tangent_create(b.model, SDR_TANGENT_EXACT, &exact), SDR_OK);              \
    assert_int_equal(sdr_tangent_create(b.model, SDR_TANGENT_SECANT, &secant), SDR_OK);            \
    assert_int_equal(sdr_tangent_update(exact, NULL, u), SDR_OK);                                  \
    assert_int_equal(sdr_tangent_update(secant, NULL, u), SDR_OK);                                 \
    const sdr_csr *k = sdr_tangent_matrix(exact), *s = sdr_tangent_matrix(secant);                 \
    for (int64_t e = 0; e < k->row[k->rows]; ++e)                                                  \
      assert_near(s->value[e], k->value[e], 1e-12 * fabs(k->value[0]));                            \
    sdr_tangent_destroy(&exact);                                                                   \
    sdr_tangent_destroy(&secant);                                                                  \
    vector_destroy(u);                                                                             \
    body_destroy(&b);                                                                              \
  }
  SDR_LAWS(COMPARE)
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tangent_and_force_are_gradients_for_every_law),
      cmocka_unit_test(histories_take_in_what_energies_had),
      cmocka_unit_test(the_secant_is_never_negative_where_the_tangent_is),
      cmocka_unit_test(on_unloading_a_bar_has_its_secant_for_a_tangent),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
