/* nom: multi-indices, shape tensors, their condition, and supports that are too poor for them. */
#include "base/parallel.h"
#include "support/grid.h"

#include <string.h>

static void there_are_as_many_derivatives_as_monomials(void **state)
{
  (void)state;
  const int expected[3][6] = {{1, 2, 3, 4, 5, 6}, {2, 5, 9, 14, 20, 27}, {3, 9, 19, 34, 55, 83}};
  sdr_multi_indices set;
  for (int d = 1; d <= 3; ++d)
    for (int n = 1; n <= 6; ++n) {
      assert_int_equal(sdr_multi_indices_of(d, n, &set), SDR_OK);
      assert_int_equal(set.count, expected[d - 1][n - 1]);
    }
}

static void derivatives_have_names_letters_in_any_order(void **state)
{
  (void)state;
  sdr_multi_indices set;
  int found = 0;
  assert_int_equal(sdr_multi_indices_of(3, 3, &set), SDR_OK);
  const char *const names[] = {"x",   "y",   "z",   "xx",  "xy",  "xz",  "yy",  "yz",  "zz", "xxx",
                               "xxy", "xxz", "xyy", "xyz", "xzz", "yyy", "yyz", "yzz", "zzz"};
  for (int k = 0; k < set.count; ++k) {
    assert_string_equal(set.name[k], names[k]);
    assert_int_equal(sdr_multi_index_find(&set, names[k], &found), SDR_OK);
    assert_int_equal(found, k);
  }
  assert_int_equal(sdr_multi_index_find(&set, "zyx", &found), SDR_OK);
  assert_string_equal(set.name[found], "xyz");
  assert_int_equal(sdr_multi_index_find(&set, "1", &found), SDR_OK);
  assert_int_equal(found, SDR_VALUE);
}

static void factorials_are_those_of_each_power(void **state)
{
  (void)state;
  sdr_multi_indices set;
  int k = 0;
  assert_int_equal(sdr_multi_indices_of(3, 6, &set), SDR_OK);
  assert_int_equal(sdr_multi_index_find(&set, "xxxyyz", &k), SDR_OK);
  assert_near(set.factorial[k], 12.0, 0.0);
  assert_int_equal(set.degree[k], 6);
  assert_int_equal(sdr_multi_index_find(&set, "yyyyyy", &k), SDR_OK);
  assert_near(set.factorial[k], 720.0, 0.0);
}

static void unknown_derivatives_and_orders_are_named(void **state)
{
  (void)state;
  sdr_multi_indices set;
  int k = 5;
  assert_int_equal(sdr_multi_indices_of(2, 2, &set), SDR_OK);
  const char *const wrong[] = {"xxx", "z", "", "dx"};
  for (int w = 0; w < 4; ++w) {
    assert_int_equal(sdr_multi_index_find(&set, wrong[w], &k), SDR_BAD_INPUT);
    assert_int_equal(k, 5);
  }
  assert_string_equal(
      sdr_error_message(),
      "no derivative 'dx' among operators of order 2 in 2-D: 1 (the value) x y xx xy yy");
  assert_int_equal(sdr_multi_indices_of(2, 7, &set), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(), "operators of order 7: give 1 to 6");
  assert_int_equal(sdr_multi_indices_of(2, 0, &set), SDR_BAD_INPUT);
  assert_int_equal(sdr_multi_indices_of(4, 2, &set), SDR_BAD_INPUT);
}

/* Points at 0, -1, 1, 2 seen from 0 with h = 2: q = -1/2, 1/2, 1, so
   M = [sum q^2, sum q^3; sum q^3, sum q^4] = [3/2, 1; 1, 9/8], |M|_1 = |M^-1|_1 11/16 = 5/2. */
static void a_tensor_worked_out_by_hand_has_its_inverse_and_condition(void **state)
{
  (void)state;
  const double x[4] = {0.0, -1.0, 1.0, 2.0}, radius[4] = {2.0, 3.0, 3.0, 3.0};
  const sdr_cloud cloud = {1, 4, {x, NULL, NULL}, NULL};
  const sdr_shape_how how = {.order = 2, .influence = SDR_INFLUENCE_CONSTANT};
  sdr_support s;
  sdr_shape_tensors shape;
  assert_int_equal(sdr_support_by_radius(&cloud, radius, &s), SDR_OK);
  assert_int_equal(sdr_shape_tensors_create(&s, &how, &shape), SDR_OK);
  const double g[2] = {1.0, 2.0};
  double y[2];
  sdr_shape_solve(&shape, 0, g, y);
  assert_near(y[0], (9.0 / 8.0 - 2.0) / 0.6875, 1e-14);
  assert_near(y[1], (-1.0 + 3.0) / 0.6875, 1e-14);
  assert_near(shape.condition[0], 2.5 * 2.5 / 0.6875, 1e-13);
  sdr_shape_tensors_destroy(&shape);
  sdr_support_destroy(&s);
}

static void volumes_and_weights_enter_the_tensor(void **state)
{
  (void)state;
  const double x[3] = {0.0, -1.0, 2.0}, volume[3] = {9.0, 2.0, 5.0}, radius[3] = {4.0, 4.0, 4.0};
  const sdr_cloud cloud = {1, 3, {x, NULL, NULL}, volume};
  const sdr_shape_how how = {.order = 1, .influence = SDR_INFLUENCE_LINEAR};
  sdr_support s;
  sdr_shape_tensors shape;
  assert_int_equal(sdr_support_by_radius(&cloud, radius, &s), SDR_OK);
  assert_int_equal(sdr_shape_tensors_create(&s, &how, &shape), SDR_OK);
  double r[3], p[1];
  const double one = 1.0;
  assert_near(sdr_shape_entry(&shape, 0, 0, r, p), 2.0 * 0.75, 1e-15);
  assert_near(r[0], -1.0, 0.0);
  assert_near(p[0], -0.25, 0.0);
  assert_near(sdr_shape_entry(&shape, 0, 1, r, p), 5.0 * 0.5, 1e-15);
  double inverse;
  sdr_shape_solve(&shape, 0, &one, &inverse);
  assert_near(1.0 / inverse, 1.5 / 16.0 + 2.5 / 4.0, 1e-15);
  assert_near(shape.condition[0], 1.0, 1e-15);
  sdr_shape_tensors_destroy(&shape);
  sdr_support_destroy(&s);
}

static sdr_status try_shape(const grid *g, int nearest, const sdr_shape_how *how,
                            sdr_shape_tensors *shape, sdr_support *s)
{
  assert_int_equal(sdr_support_by_count(&g->cloud, nearest, s), SDR_OK);
  return sdr_shape_tensors_create(s, how, shape);
}

static void a_support_too_small_is_named_with_what_it_needs(void **state)
{
  (void)state;
  grid g;
  sdr_support s;
  sdr_shape_tensors shape;
  const sdr_shape_how how = {.order = 2, .influence = SDR_INFLUENCE_CONSTANT};
  grid_create(2, 10, 0.0, 1.0, &g);
  assert_int_equal(try_shape(&g, 3, &how, &shape, &s), SDR_BAD_INPUT);
  assert_string_equal(sdr_error_message(),
                      "point 0 at (0, 0) has 3 neighbours, and operators of order 2 in 2-D "
                      "need at least 5 (and 120 more points): give more neighbours or a lower "
                      "order");
  sdr_support_destroy(&s);
  grid_destroy(&g);
}

/* Eight neighbours on a lattice lie on three lines in each direction: x^3 is x there. */
static void a_support_too_regular_is_named_with_its_condition(void **state)
{
  (void)state;
  grid g;
  sdr_support s;
  sdr_shape_tensors shape;
  const sdr_shape_how how = {.order = 3, .influence = SDR_INFLUENCE_CONSTANT};
  grid_create(2, 10, 0.0, 1.0, &g);
  assert_int_equal(try_shape(&g, 9, &how, &shape, &s), SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), " has a singular shape tensor: condition number "));
  assert_non_null(strstr(sdr_error_message(), " neighbours, at most 1.0e+12 for operators of "
                                              "order 3"));
  sdr_support_destroy(&s);
  grid_destroy(&g);
}

static void singular_supports_grow_where_that_is_asked_for(void **state)
{
  (void)state;
  grid g;
  sdr_support s;
  sdr_shape_tensors shape;
  const sdr_shape_how how = {.order = 3, .influence = SDR_INFLUENCE_CUBIC, .enlarge = 1};
  grid_create(2, 10, 0.0, 1.0, &g);
  assert_int_equal(try_shape(&g, 6, &how, &shape, &s), SDR_OK);
  assert_true(shape.enlarged > 0);
  int32_t largest = 0;
  for (int32_t i = 0; i < g.count; ++i) {
    assert_true(shape.condition[i] <= 1e12);
    if (shape.condition[i] > shape.condition[largest]) largest = i;
  }
  assert_int_equal(shape.worst, largest);
  sdr_shape_tensors_destroy(&shape);
  sdr_support_destroy(&s);
  grid_destroy(&g);
}

static void only_the_poor_supports_grow(void **state)
{
  (void)state;
  grid g;
  sdr_support s, plain;
  sdr_shape_tensors shape;
  const sdr_shape_how how = {.order = 2, .influence = SDR_INFLUENCE_GAUSSIAN, .enlarge = 1};
  grid_create(2, 10, 0.2, 1.0, &g);
  double *radius = sdr_alloc((size_t)g.count, sizeof *radius);
  for (int32_t i = 0; i < g.count; ++i) radius[i] = i == 60 ? 0.05 : 0.3;
  assert_int_equal(sdr_support_by_radius(&g.cloud, radius, &s), SDR_OK);
  assert_int_equal(sdr_support_by_radius(&g.cloud, radius, &plain), SDR_OK);
  assert_int_equal(sdr_shape_tensors_create(&s, &how, &shape), SDR_OK);
  assert_int_equal(shape.enlarged, 1);
  for (int32_t i = 0; i < g.count; ++i) {
    const int64_t held = s.row[i + 1] - s.row[i];
    if (i == 60)
      assert_true(held >= 5 && s.radius[i] > 0.05);
    else
      assert_int_equal(held, plain.row[i + 1] - plain.row[i]);
  }
  sdr_shape_tensors_destroy(&shape);
  sdr_support_destroy(&s);
  sdr_support_destroy(&plain);
  sdr_free(radius);
  grid_destroy(&g);
}

static void points_that_no_support_makes_regular_are_named(void **state)
{
  (void)state;
  double x[20], y[20];
  for (int i = 0; i < 20; ++i) x[i] = y[i] = i;
  const sdr_cloud cloud = {2, 20, {x, y, NULL}, NULL};
  const sdr_shape_how how = {.order = 1, .influence = SDR_INFLUENCE_CONSTANT, .enlarge = 1};
  sdr_support s;
  sdr_shape_tensors shape;
  assert_int_equal(sdr_support_by_count(&cloud, 3, &s), SDR_OK);
  assert_int_equal(sdr_shape_tensors_create(&s, &how, &shape), SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), " has a singular shape tensor"));
  assert_non_null(strstr(sdr_error_message(), "with 19 neighbours"));
  assert_non_null(strstr(sdr_error_message(), "these points bear no operators of that order"));
  sdr_support_destroy(&s);
}

static void a_lower_limit_of_the_condition_refuses_more(void **state)
{
  (void)state;
  grid g;
  sdr_support s;
  sdr_shape_tensors shape;
  const sdr_shape_how how = {
      .order = 4, .influence = SDR_INFLUENCE_GAUSSIAN, .most_condition = 1e3};
  grid_create(2, 12, 0.2, 1.0, &g);
  assert_int_equal(try_shape(&g, 32, &how, &shape, &s), SDR_BAD_INPUT);
  assert_non_null(strstr(sdr_error_message(), "at most 1.0e+03"));
  sdr_support_destroy(&s);
  grid_destroy(&g);
}

static void no_memory_leaves_nothing_behind(void **state)
{
  (void)state;
  grid g;
  sdr_support s;
  sdr_shape_tensors shape;
  const sdr_shape_how how = {.order = 2, .influence = SDR_INFLUENCE_GAUSSIAN, .enlarge = 1};
  grid_create(2, 6, 0.2, 1.0, &g);
  assert_int_equal(sdr_support_by_count(&g.cloud, 3, &s), SDR_OK);
  const size_t before = sdr_memory_now();
  const int threads = sdr_threads();
  sdr_set_threads(1);
  sdr_memory_fail_after(3);
  assert_int_equal(sdr_shape_tensors_create(&s, &how, &shape), SDR_RUN_FAILED);
  sdr_memory_fail_after(4);
  assert_int_equal(sdr_shape_tensors_create(&s, &how, &shape), SDR_RUN_FAILED);
  sdr_memory_fail_after(-1);
  sdr_set_threads(threads);
  assert_string_equal(sdr_error_message(), "out of memory for shape tensors");
  assert_int_equal(sdr_memory_now(), before);
  sdr_support_destroy(&s);
  grid_destroy(&g);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(there_are_as_many_derivatives_as_monomials),
      cmocka_unit_test(derivatives_have_names_letters_in_any_order),
      cmocka_unit_test(factorials_are_those_of_each_power),
      cmocka_unit_test(unknown_derivatives_and_orders_are_named),
      cmocka_unit_test(a_tensor_worked_out_by_hand_has_its_inverse_and_condition),
      cmocka_unit_test(volumes_and_weights_enter_the_tensor),
      cmocka_unit_test(a_support_too_small_is_named_with_what_it_needs),
      cmocka_unit_test(a_support_too_regular_is_named_with_its_condition),
      cmocka_unit_test(singular_supports_grow_where_that_is_asked_for),
      cmocka_unit_test(only_the_poor_supports_grow),
      cmocka_unit_test(points_that_no_support_makes_regular_are_named),
      cmocka_unit_test(a_lower_limit_of_the_condition_refuses_more),
      cmocka_unit_test(no_memory_leaves_nothing_behind),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
