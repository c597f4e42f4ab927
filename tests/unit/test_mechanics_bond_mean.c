/* mechanics: mean forces of bond-based bodies over a step, and their tangent. */
#include "support/body.h"

static const body_how shapes[] = {
    {.dimension = SDR_1D, .cells = {30}, .scatter = 0.1},
    {.dimension = SDR_PLANE_STRESS, .cells = {11, 9}},
    {.dimension = SDR_PLANE_STRAIN, .cells = {9, 10}, .angle = 0.3, .scatter = 0.1},
    {.dimension = SDR_PLANE_STRESS,
     .cells = {10, 9},
     .jitter = 0.3,
     .horizon_spread = 0.3,
     .two_materials = 1},
    {.dimension = SDR_3D, .cells = {9, 3, 4}, .ratio = 1.75},
};
static const sdr_law laws[] = {SDR_LAW_NONE, SDR_LAW_VARIATIONAL, SDR_LAW_CRITICAL_STRETCH,
                               SDR_LAW_AT1, SDR_LAW_COHESIVE};
enum { SHAPES = sizeof shapes / sizeof *shapes, LAWS = sizeof laws / sizeof *laws };

/* A body with some bonds cut and some protected, and a step of it: stretches of a few thresholds
   both ways, a turn by `angle`, and an earlier state that is committed. */
typedef struct {
  body b;
  double *u0[3], *u1[3], *f[3], *v[3], *out[3];
} stepped;

static void turn(const sdr_points *points, double angle, double *const u[3])
{
  if (points->components < 2) return;
  const double c = cos(angle), s = sin(angle);
  for (int32_t i = 0; i < points->count; ++i) {
    const double x = points->x[0][i] + u[0][i], y = points->x[1][i] + u[1][i];
    u[0][i] = c * x - s * y - points->x[0][i];
    u[1][i] = s * x + c * y - points->x[1][i];
  }
}

static stepped step_of(const body_how *shape, sdr_law law, double size, double angle)
{
  body_how how = *shape;
  how.law = law;
  how.precise = 1;
  stepped t = {.b = body_create(&how)};
  int64_t cut;
  assert_int_equal(t.b.model->ops->mark(t.b.model, body_cut_and_protect, NULL, &cut), SDR_OK);
  vector_create(t.b.points, t.u0);
  vector_create(t.b.points, t.u1);
  vector_create(t.b.points, t.f);
  vector_create(t.b.points, t.v);
  vector_create(t.b.points, t.out);
  vector_noise(t.b.points, 0.012 * body_spacing, 5, t.u0);
  t.b.model->ops->commit(t.b.model, t.u0);
  vector_noise(t.b.points, 0.012 * body_spacing, 6, t.u0); /* some bonds unload */
  t.b.model->ops->commit(t.b.model, t.u0);
  vector_noise(t.b.points, size * body_spacing, 7, t.v);
  vector_add(t.b.points, t.u0, 1.0, t.v, t.u1);
  turn(t.b.points, angle, t.u1);
  return t;
}

static void end(stepped *t)
{
  vector_destroy(t->u0);
  vector_destroy(t->u1);
  vector_destroy(t->f);
  vector_destroy(t->v);
  vector_destroy(t->out);
  body_destroy(&t->b);
}

/* Of bonds that critical stretch is about to break the energy is whole until commit. */
static double energy(const body *b, double *const u[3])
{
  sdr_energies e;
  b->model->ops->energies(b->model, u, &e);
  return e.stored + e.dissipated;
}

static void the_work_of_the_mean_force_is_what_the_energy_loses(void **state)
{
  (void)state;
  static const double sizes[] = {0.05, 0.01, 1e-4, 1e-7};
  for (int k = 0; k < SHAPES; ++k)
    for (int l = 0; l < LAWS; ++l)
      for (int n = 0; n < 4; ++n) {
        stepped t = step_of(&shapes[k], laws[l], sizes[n], n == 0 ? 0.5 : 0.0);
        const double before = energy(&t.b, t.u0), after = energy(&t.b, t.u1);
        t.b.model->ops->mean_force(t.b.model, t.u0, t.u1, t.f);
        vector_add(t.b.points, t.u1, -1.0, t.u0, t.v);
        const double work = vector_dot(t.b.points, t.f, t.v);
        assert_true(after > 0.0 && before > 0.0);
        assert_near(-work, after - before, 2e-14 * (after + before));
        end(&t);
      }
}

static void mean_forces_balance_momenta(void **state)
{
  (void)state;
  for (int k = 1; k < 4; ++k)
    for (int l = 0; l < LAWS; ++l) {
      stepped t = step_of(&shapes[k], laws[l], 0.05, 0.7);
      double sum[2] = {0.0}, torque = 0.0, size = 0.0;
      t.b.model->ops->mean_force(t.b.model, t.u0, t.u1, t.f);
      for (int32_t i = 0; i < t.b.points->count; ++i) {
        double y[2];
        for (int a = 0; a < 2; ++a) {
          y[a] = t.b.points->x[a][i] + 0.5 * (t.u0[a][i] + t.u1[a][i]);
          sum[a] += t.f[a][i];
          size += fabs(t.f[a][i]);
        }
        torque += y[0] * t.f[1][i] - y[1] * t.f[0][i];
      }
      assert_near(sum[0], 0.0, 1e-14 * size);
      assert_near(sum[1], 0.0, 1e-14 * size);
      assert_near(torque, 0.0, 1e-14 * size * 10.0 * body_spacing);
      end(&t);
    }
}

/* Steps far from any kink: each bond loads, or unloads, or is pressed, at both ends. */
static void move_smoothly(stepped *t, double angle)
{
  const int n = t->b.points->components;
  for (int32_t i = 0; i < t->b.points->count; ++i)
    for (int a = 0; a < n; ++a)
      t->u1[a][i] = t->u0[a][i] + (0.004 + 0.001 * a) * t->b.points->x[a][i];
  turn(t->b.points, angle, t->u1);
}

/* -d f/d u1 along v by differences of fourth order. */
static void difference(stepped *t, double h)
{
  static const double factor[4] = {1.0, -8.0, 8.0, -1.0};
  const sdr_points *points = t->b.points;
  double *u[3];
  vector_create(points, u);
  for (int a = 0; a < points->components; ++a)
    memset(t->out[a], 0, (size_t)points->count * sizeof(double));
  for (int k = 0; k < 4; ++k) {
    vector_add(points, t->u1, h * (k < 2 ? k - 2 : k - 1), t->v, u);
    t->b.model->ops->mean_force(t->b.model, t->u0, u, t->f);
    vector_add(points, t->out, -factor[k] / (12.0 * h), t->f, t->out);
  }
  vector_destroy(u);
}

static void products_with_the_tangent_are_differences_of_the_mean_force(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int l = 0; l < LAWS; ++l) {
      stepped t = step_of(&shapes[k], laws[l], 0.01, 0.0);
      double *exact[3];
      vector_create(t.b.points, exact);
      move_smoothly(&t, k == 0 ? 0.0 : 0.4);
      vector_noise(t.b.points, 1.0, 11, t.v);
      difference(&t, 2e-7 * body_spacing);
      assert_int_equal(t.b.model->ops->mean_keep(t.b.model, t.u0, t.u1, t.f), SDR_OK);
      t.b.model->ops->mean_times(t.b.model, t.u0, t.u1, t.v, exact);
      assert_at_most(vector_difference(t.b.points, exact, t.out),
                     1e-7 * vector_largest(t.b.points, exact));
      vector_destroy(exact);
      end(&t);
    }
}

typedef struct {
  const stepped *t;
  double *diagonal;
  double asymmetry, size;
} gathering;

/* out += block v */
static void take_block(void *context, int count, const int32_t *point, const double *block)
{
  gathering *g = context;
  const int m = g->t->b.points->components, width = count * m;
  for (int r = 0; r < width; ++r)
    for (int c = 0; c < width; ++c) {
      const double k = block[r * width + c];
      g->t->out[r % m][point[r / m]] += k * g->t->v[c % m][point[c / m]];
      g->asymmetry = fmax(g->asymmetry, fabs(k - block[c * width + r]));
      g->size = fmax(g->size, fabs(k));
      if (r / m == c / m) g->diagonal[(point[r / m] * m + r % m) * m + c % m] += k;
    }
}

static void parts_and_diagonal_and_products_are_of_one_tangent(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int l = 0; l < LAWS; ++l) {
      stepped t = step_of(&shapes[k], laws[l], 0.05, 0.5);
      const sdr_model_ops *ops = t.b.model->ops;
      const size_t m = (size_t)t.b.points->components, count = (size_t)t.b.points->count;
      double *own = sdr_alloc(count * m * m, sizeof *own);
      gathering g = {.t = &t, .diagonal = sdr_alloc(count * m * m, sizeof(double))};
      vector_noise(t.b.points, 1.0, 12, t.v);
      assert_int_equal(ops->visit_mean_tangent(t.b.model, t.u0, t.u1, take_block, &g), SDR_OK);
      assert_int_equal(ops->mean_keep(t.b.model, t.u0, t.u1, t.f), SDR_OK);
      ops->mean_times(t.b.model, t.u0, t.u1, t.v, t.f);
      ops->mean_diagonal(t.b.model, t.u0, t.u1, own);
      assert_at_most(vector_difference(t.b.points, t.f, t.out),
                     1e-13 * vector_largest(t.b.points, t.f));
      for (size_t r = 0; r < count * m * m; ++r)
        assert_near(own[r], g.diagonal[r], 1e-12 * g.size * 20.0);
      if (m > 1) assert_true(g.asymmetry > 0.1 * g.size); /* half a radian in the step */
      sdr_free(own);
      sdr_free(g.diagonal);
      end(&t);
    }
}

static void a_step_of_no_length_has_the_force_itself(void **state)
{
  (void)state;
  for (int k = 0; k < SHAPES; ++k)
    for (int l = 0; l < LAWS; ++l) {
      stepped t = step_of(&shapes[k], laws[l], 0.0, 0.0);
      t.b.model->ops->mean_force(t.b.model, t.u0, t.u0, t.f);
      t.b.model->ops->force(t.b.model, t.u0, t.out);
      assert_at_most(vector_difference(t.b.points, t.f, t.out),
                     1e-13 * vector_largest(t.b.points, t.f));
      end(&t);
    }
}

static void runs_and_loose_pairs_have_the_same_mean_force(void **state)
{
  (void)state;
  for (int l = 0; l < LAWS; ++l) {
    body_how loose = shapes[2];
    loose.force_loose = 1;
    stepped t = step_of(&shapes[2], laws[l], 0.03, 0.2), w = step_of(&loose, laws[l], 0.03, 0.2);
    t.b.model->ops->mean_force(t.b.model, t.u0, t.u1, t.f);
    w.b.model->ops->mean_force(w.b.model, t.u0, t.u1, w.f);
    assert_at_most(vector_difference(t.b.points, t.f, w.f),
                   1e-13 * vector_largest(t.b.points, t.f));
    end(&t);
    end(&w);
  }
}

static void threads_and_instruction_sets_change_nothing_that_matters(void **state)
{
  (void)state;
  const int threads = sdr_threads();
  for (int k = 1; k < SHAPES; ++k) {
    stepped t = step_of(&shapes[k], SDR_LAW_VARIATIONAL, 0.05, 0.1);
    for (int n = 1; n <= 3; ++n) {
      sdr_set_threads(n);
      t.b.model->ops->mean_force(t.b.model, t.u0, t.u1, n == 1 ? t.f : t.out);
      if (n > 1) assert_true(vector_difference(t.b.points, t.f, t.out) == 0.0);
    }
    assert_int_equal(sdr_isa_limit("baseline"), SDR_OK);
    t.b.model->ops->mean_force(t.b.model, t.u0, t.u1, t.out);
    assert_at_most(vector_difference(t.b.points, t.f, t.out),
                   1e-13 * vector_largest(t.b.points, t.f));
    sdr_isa_limit("avx512");
    end(&t);
  }
  sdr_set_threads(threads);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_work_of_the_mean_force_is_what_the_energy_loses),
      cmocka_unit_test(mean_forces_balance_momenta),
      cmocka_unit_test(products_with_the_tangent_are_differences_of_the_mean_force),
      cmocka_unit_test(parts_and_diagonal_and_products_are_of_one_tangent),
      cmocka_unit_test(a_step_of_no_length_has_the_force_itself),
      cmocka_unit_test(runs_and_loose_pairs_have_the_same_mean_force),
      cmocka_unit_test(threads_and_instruction_sets_change_nothing_that_matters)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
