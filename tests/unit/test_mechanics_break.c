/* break_most: the bonds that statics takes away first. */
#include "support/ordinary.h"

/* s0 is 0.01. A bar along x pulled apart, more the further right: strain 0.005 to 0.0195. */
static const body_how bar = {.dimension = SDR_PLANE_STRESS,
                             .cells = {30, 8, 1},
                             .law = SDR_LAW_CRITICAL_STRETCH,
                             .precise = 1};

typedef struct {
  double *u[3];
  double length;
} field;

static field pulled(const sdr_points *points, double share)
{
  field f = {.length = 30 * body_spacing};
  for (int a = 0; a < 2; ++a) f.u[a] = sdr_alloc(sdr_points_padded(points), sizeof(double));
  for (int32_t i = 0; i < points->count; ++i) {
    const double x = points->x[0][i] + 0.5 * f.length;
    f.u[0][i] = share * (0.005 * x + 0.00725 * x * x / f.length);
  }
  return f;
}

static void field_free(field *f)
{
  for (int a = 0; a < 2; ++a) sdr_free(f->u[a]);
}

/* The pairs that are lost; the smallest and the largest stretch of these, and of the others. */
typedef struct {
  const sdr_points *points;
  double *const *u;
  double least_lost, most_kept;
} stretches;

static void look(void *context, int32_t i, int32_t j, double damage)
{
  stretches *found = context;
  double square = 0.0, now = 0.0;
  for (int a = 0; a < 2; ++a) {
    const double xi = found->points->x[a][j] - found->points->x[a][i];
    const double y = xi + found->u[a][j] - found->u[a][i];
    square += xi * xi;
    now += y * y;
  }
  const double s = sqrt(now / square) - 1.0;
  if (damage > 0.0)
    found->least_lost = fmin(found->least_lost, s);
  else
    found->most_kept = fmax(found->most_kept, s);
}

static double energy(sdr_model *model, double *const u[3])
{
  sdr_energies e;
  model->ops->energies(model, u, &e);
  return e.stored + e.dissipated;
}

/* A first round loses what is above 0.98 of the largest only, a last one leaves nothing above s0;
   all that is lost is booked. */
static void check(sdr_model *model, double tolerance)
{
  field f = pulled(model->points, 1.0), less = pulled(model->points, 0.5);
  const double before = energy(model, f.u);
  stretches first = {model->points, f.u, INFINITY, 0.0};
  assert_int_equal(model->ops->break_most(model, less.u, 0.98), 0);
  assert_true(model->ops->break_most(model, f.u, 0.98) > 0);
  model->ops->visit_damage(model, f.u, look, &first);
  assert_true(first.least_lost > 0.01 && first.most_kept > 0.01);
  assert_near(first.most_kept, first.least_lost, 0.03 * first.most_kept);
  assert_true(first.most_kept <= first.least_lost * (1.0 + 1e-12));
  assert_near(energy(model, f.u), before, tolerance * before);
  int rounds = 0;
  while (model->ops->break_most(model, f.u, 0.98) > 0) ++rounds;
  stretches last = {model->points, f.u, INFINITY, 0.0};
  model->ops->visit_damage(model, f.u, look, &last);
  assert_true(rounds > 5 && rounds < 100);
  assert_true(last.most_kept <= 0.01 * (1.0 + 1e-9));
  assert_near(energy(model, f.u), before, tolerance * before);
  field_free(&f);
  field_free(&less);
}

static void bond_based_bodies_lose_the_most_overstretched_first(void **state)
{
  (void)state;
  for (int loose = 0; loose < 2; ++loose) {
    body_how how = bar;
    how.force_loose = loose;
    body b = body_create(&how);
    check(b.model, 1e-12);
    body_destroy(&b);
  }
}

static void so_do_ordinary_ones(void **state)
{
  (void)state;
  for (int loose = 0; loose < 2; ++loose) {
    ordinary_how how = {.body = bar};
    how.body.force_loose = loose;
    body b = ordinary_create(&how);
    check(b.model, 1e-12);
    body_destroy(&b);
  }
}

/* What is protected stays, and other laws lose nothing. */
static int protects_all(const void *context, const double a[3], const double b[3])
{
  (void)context, (void)a, (void)b;
  return SDR_PROTECTED;
}

static void what_is_protected_or_of_another_law_stays(void **state)
{
  (void)state;
  int64_t cut;
  body_how elastic = bar;
  elastic.law = SDR_LAW_NONE;
  body b = body_create(&bar), whole = body_create(&elastic);
  field f = pulled(b.points, 1.0);
  assert_int_equal(b.model->ops->mark(b.model, protects_all, NULL, &cut), SDR_OK);
  assert_int_equal(b.model->ops->break_most(b.model, f.u, 0.98), 0);
  assert_int_equal(whole.model->ops->break_most(whole.model, f.u, 0.98), 0);
  field_free(&f);
  body_destroy(&b);
  body_destroy(&whole);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(bond_based_bodies_lose_the_most_overstretched_first),
      cmocka_unit_test(so_do_ordinary_ones),
      cmocka_unit_test(what_is_protected_or_of_another_law_stays)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
