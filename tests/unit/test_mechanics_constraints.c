/* mechanics: u = a + B q, and what it makes of matrices and forces. */
#include "mechanics/constraints.h"
#include "mechanics/reduction.h"
#include "support/still_body.h"

enum { N = 12 }; /* unknowns of 6 points in 2-D */

static const body_how plate = {.dimension = SDR_PLANE_STRESS, .cells = {3, 2}};

/* Supports that name both components of point 0 and the second of point 3. */
static sdr_support_scene held[2] = {
    {.name = "a", .kind = {SDR_PRESCRIBED_DISPLACEMENT, SDR_PRESCRIBED_DISPLACEMENT, SDR_FREE}},
    {.name = "b", .kind = {SDR_FREE, SDR_PRESCRIBED_DISPLACEMENT, SDR_FREE}}};
static sdr_shape corner[2];

typedef struct {
  body body;
  sdr_scene scene;
  sdr_supports *supports;
} held_body;

static void place_support(int k, const sdr_points *points, int32_t i)
{
  corner[k] = (sdr_shape){.kind = SDR_BOX, .primitive_count = 1};
  for (int a = 0; a < 2; ++a) {
    corner[k].low[a] = points->x[a][i] - 0.1 * body_spacing;
    corner[k].high[a] = points->x[a][i] + 0.1 * body_spacing;
  }
  held[k].on.shape = &corner[k];
  held[k].schedule.until = INFINITY;
}

static held_body held_create(void)
{
  held_body h = {.body = body_create(&plate)};
  h.scene.dimension = plate.dimension;
  place_support(0, h.body.points, 0);
  place_support(1, h.body.points, 3);
  h.scene.support_count = 2;
  h.scene.support = held;
  assert_int_equal(sdr_supports_create(&h.scene, h.body.points, &h.supports), SDR_OK);
  assert_int_equal(sdr_supports_count(h.supports), 3);
  return h;
}

static void held_destroy(held_body *h)
{
  sdr_supports_destroy(&h->supports);
  body_destroy(&h->body);
}

/* u4 = 0.5 - u2 + 2 u7, u11 = -0.25 + 3 u0 with u0 prescribed. */
static int32_t slave_unknown[2] = {4, 11}, slave_master[3] = {2, 7, 0};
static int64_t slave_first[3] = {0, 2, 3};
static double slave_constant[2] = {0.5, -0.25}, slave_coefficient[3] = {-1.0, 3.0, 3.0};
static const sdr_slaves slaves = {.count = 2,
                                  .unknown = slave_unknown,
                                  .constant = slave_constant,
                                  .first = slave_first,
                                  .master = slave_master,
                                  .coefficient = slave_coefficient};

static const double values[3] = {0.1, 0.2, 0.3}; /* u0, u1, u7 */

static void components_are_free_prescribed_or_slaved(void **state)
{
  (void)state;
  held_body h = held_create();
  sdr_constraints c = {0};
  assert_int_equal(sdr_constraints_create(h.body.points, h.supports, values, &slaves, &c), SDR_OK);
  assert_int_equal(c.unknowns, N);
  assert_int_equal(c.free, 7); /* 2 3 5 6 8 9 10 */
  const double q[7] = {2.0, 3.0, 5.0, 6.0, 8.0, 9.0, 10.0};
  const int32_t unknown[7] = {2, 3, 5, 6, 8, 9, 10};
  assert_memory_equal(c.unknown, unknown, sizeof unknown);
  const double wanted[N] = {0.1, 0.2, 2.0, 3.0,  0.5 - 2.0 + 3.0 * 0.3, 5.0, 6.0,
                            0.3, 8.0, 9.0, 10.0, -0.25 + 3.0 * 0.1};
  double u[N];
  sdr_constraints_expand(&c, q, u);
  for (int k = 0; k < N; ++k) assert_near(u[k], wanted[k], 1e-15);
  for (int k = 0; k < N; ++k) assert_int_equal(c.prescribed[k], k == 0 || k == 1 || k == 7);
  sdr_constraints_destroy(&c);
  held_destroy(&h);
}

static void forces_do_the_same_work_on_the_free_components(void **state)
{
  (void)state;
  held_body h = held_create();
  sdr_constraints c = {0};
  assert_int_equal(sdr_constraints_create(h.body.points, h.supports, values, &slaves, &c), SDR_OK);
  double f[N], g[N], q[N], u[N], still[N], zero[N] = {0.0};
  uint64_t seed = 4;
  for (int k = 0; k < N; ++k) {
    f[k] = noise(&seed);
    q[k] = noise(&seed);
  }
  sdr_constraints_project(&c, f, g);
  sdr_constraints_expand(&c, q, u);
  sdr_constraints_expand(&c, zero, still);
  double work = 0.0, same = 0.0;
  for (int k = 0; k < N; ++k) work += f[k] * (u[k] - still[k]);
  for (int k = 0; k < c.free; ++k) same += g[k] * q[k];
  assert_near(work, same, 1e-14);
  sdr_constraints_destroy(&c);
  held_destroy(&h);
}

/* P^T K B for a full K against sums over all; `apart`: forces on the first slave are lost. */
static void check_reduced(int apart)
{
  uint8_t which[2] = {(uint8_t)apart, 0};
  sdr_slaves some = slaves;
  some.apart = which;
  held_body h = held_create();
  sdr_constraints c = {0};
  sdr_csr k = {0}, reduced = {0};
  sdr_csr_builder *builder = NULL;
  double dense[N][N], b[N][N] = {{0.0}}, wanted[N][N] = {{0.0}};
  uint64_t seed = 9;
  assert_int_equal(sdr_constraints_create(h.body.points, h.supports, values, &some, &c), SDR_OK);
  assert_int_equal(c.symmetric, !apart);
  assert_int_equal(sdr_csr_builder_create(N, N, &builder), SDR_OK);
  for (int r = 0; r < N; ++r)
    for (int s = 0; s < N; ++s) {
      dense[r][s] = noise(&seed);
      assert_int_equal(sdr_csr_builder_add(builder, r, s, dense[r][s]), SDR_OK);
    }
  assert_int_equal(sdr_csr_builder_finish(builder, &k), SDR_OK);
  sdr_csr_builder_destroy(&builder);
  for (int r = 0; r < N; ++r)
    for (int64_t p = c.map.row[r]; p < c.map.row[r + 1]; ++p)
      b[r][c.map.column[p]] = c.map.value[p];
  for (int i = 0; i < c.free; ++i)
    for (int j = 0; j < c.free; ++j)
      for (int r = 0; r < N; ++r)
        for (int s = 0; s < N; ++s)
          if (!apart || r != 4) wanted[i][j] += b[r][i] * dense[r][s] * b[s][j];
  assert_int_equal(sdr_constraints_reduce(&c, &k, &reduced), SDR_OK);
  assert_int_equal(reduced.rows, c.free);
  assert_int_equal(reduced.columns, c.free);
  assert_int_equal(reduced.row[c.free], c.free * c.free);
  for (int i = 0; i < c.free; ++i)
    for (int64_t p = reduced.row[i]; p < reduced.row[i + 1]; ++p) {
      if (p > reduced.row[i]) assert_true(reduced.column[p] > reduced.column[p - 1]);
      assert_near(reduced.value[p], wanted[i][reduced.column[p]], 1e-14);
    }
  sdr_csr_destroy(&k);
  sdr_csr_destroy(&reduced);
  sdr_constraints_destroy(&c);
  held_destroy(&h);
}

static void a_matrix_is_reduced(void **state)
{
  (void)state;
  check_reduced(0);
  check_reduced(1);
}

/* A force on a slave that keeps its forces apart reaches nobody, on another its masters. */
static void forces_apart_act_on_nothing(void **state)
{
  (void)state;
  uint8_t which[2] = {1, 0};
  sdr_slaves some = slaves;
  some.apart = which;
  held_body h = held_create();
  sdr_constraints c = {0};
  double f[N] = {0.0}, g[N];
  assert_int_equal(sdr_constraints_create(h.body.points, h.supports, values, &some, &c), SDR_OK);
  f[4] = 1.0;
  f[5] = 2.0;
  sdr_constraints_project(&c, f, g);
  for (int k = 0; k < c.free; ++k) assert_near(g[k], c.unknown[k] == 5 ? 2.0 : 0.0, 0.0);
  sdr_constraints_destroy(&c);
  held_destroy(&h);
}

static void supports_that_do_not_act_leave_their_points_free(void **state)
{
  (void)state;
  held_body h = held_create();
  const double none[3] = {NAN, NAN, NAN};
  sdr_constraints c = {0};
  assert_int_equal(sdr_constraints_create(h.body.points, h.supports, none, NULL, &c), SDR_OK);
  assert_int_equal(c.free, N);
  sdr_constraints_destroy(&c);
  held_destroy(&h);
}

static void check_refused(int32_t first, int32_t second, int32_t master, const char *end)
{
  held_body h = held_create();
  int32_t unknown[2] = {first, second}, leads[3] = {master, 2, 2};
  const sdr_slaves bad = {.count = 2,
                          .unknown = unknown,
                          .constant = slave_constant,
                          .first = slave_first,
                          .master = leads,
                          .coefficient = slave_coefficient};
  sdr_constraints c = {0};
  assert_int_equal(sdr_constraints_create(h.body.points, h.supports, values, &bad, &c),
                   SDR_BAD_INPUT);
  assert_null(c.offset);
  const char *message = sdr_error_message();
  assert_true(strlen(message) > strlen(end));
  assert_string_equal(message + strlen(message) - strlen(end), end);
  held_destroy(&h);
}

static void what_contradicts_itself_is_refused(void **state)
{
  (void)state;
  check_refused(0, 4, 2, " is prescribed by a support and follows a fictitious layer as well");
  check_refused(4, 4, 2, " follows two fictitious layers at once");
  check_refused(4, 5, 5, " leads a fictitious layer and follows one: layers must follow the body");
}

/* ---- again and again ------------------------------------------------------------------------- */

/* The pattern of neighbours in a ring. */
static sdr_csr ring_matrix(void)
{
  sdr_csr_builder *builder = NULL;
  sdr_csr k = {0};
  assert_int_equal(sdr_csr_builder_create(N, N, &builder), SDR_OK);
  for (int r = 0; r < N; ++r)
    for (int d = -1; d < 2; ++d)
      assert_int_equal(sdr_csr_builder_add(builder, r, (r + d + N) % N, 1.0), SDR_OK);
  assert_int_equal(sdr_csr_builder_finish(builder, &k), SDR_OK);
  sdr_csr_builder_destroy(&builder);
  return k;
}

static int update_and_compare(sdr_reduction *reduction, const sdr_constraints *c, sdr_csr *k,
                              uint64_t *seed)
{
  sdr_csr wanted = {0};
  int renewed = -1;
  for (int64_t p = 0; p < k->row[N]; ++p) k->value[p] = noise(seed);
  assert_int_equal(sdr_reduction_update(reduction, c, &renewed), SDR_OK);
  assert_int_equal(sdr_constraints_reduce(c, k, &wanted), SDR_OK);
  const sdr_csr *made = sdr_reduction_matrix(reduction);
  assert_int_equal(made->rows, wanted.rows);
  assert_int_equal(made->columns, wanted.columns);
  const size_t rows = (size_t)wanted.rows, entries = (size_t)wanted.row[rows];
  assert_memory_equal(made->row, wanted.row, (rows + 1) * sizeof *wanted.row);
  assert_memory_equal(made->column, wanted.column, entries * sizeof *wanted.column);
  assert_memory_equal(made->value, wanted.value, entries * sizeof *wanted.value);
  sdr_csr_destroy(&wanted);
  return renewed;
}

static void a_matrix_is_reduced_again_and_again(void **state)
{
  (void)state;
  held_body h = held_create();
  const double fewer[3] = {0.1, NAN, 0.3};
  sdr_constraints selection = {0}, other = {0}, slaved = {0};
  sdr_csr k = ring_matrix();
  sdr_reduction *reduction = NULL;
  uint64_t seed = 2;
  assert_int_equal(sdr_constraints_create(h.body.points, h.supports, values, NULL, &selection),
                   SDR_OK);
  assert_int_equal(sdr_constraints_create(h.body.points, h.supports, fewer, NULL, &other), SDR_OK);
  assert_int_equal(sdr_constraints_create(h.body.points, h.supports, values, &slaves, &slaved),
                   SDR_OK);
  assert_int_equal(sdr_reduction_create(&k, &reduction), SDR_OK);
  assert_int_equal(update_and_compare(reduction, &selection, &k, &seed), 1);
  assert_int_equal(update_and_compare(reduction, &selection, &k, &seed), 0);
  assert_int_equal(update_and_compare(reduction, &other, &k, &seed), 1);
  assert_int_equal(update_and_compare(reduction, &slaved, &k, &seed), 1);
  assert_int_equal(update_and_compare(reduction, &slaved, &k, &seed), 0);
  assert_int_equal(update_and_compare(reduction, &other, &k, &seed), 1);
  assert_int_equal(update_and_compare(reduction, &other, &k, &seed), 0);
  sdr_reduction_destroy(&reduction);
  assert_null(reduction);
  sdr_csr_destroy(&k);
  sdr_constraints_destroy(&selection);
  sdr_constraints_destroy(&other);
  sdr_constraints_destroy(&slaved);
  held_destroy(&h);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(components_are_free_prescribed_or_slaved),
      cmocka_unit_test(forces_do_the_same_work_on_the_free_components),
      cmocka_unit_test(a_matrix_is_reduced),
      cmocka_unit_test(a_matrix_is_reduced_again_and_again),
      cmocka_unit_test(forces_apart_act_on_nothing),
      cmocka_unit_test(supports_that_do_not_act_leave_their_points_free),
      cmocka_unit_test(what_contradicts_itself_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
