/* The problems of nonlocal operators as users run them: every figure of every variant lies in its
   range, and what convergence the theory foretells is there. */
#include "support/figures.h"

/* All figures with a range of a problem's variant (NULL: the scene itself). */
static void expect(const char *problem, const char *variant, int ranges)
{
  static const char *const no_frame[] = {"output.snapshots=0", NULL};
  figures f;
  figures_run(&f, problem, variant, no_frame);
  figures_assert_accepted(&f, ranges);
  figures_free(&f);
}

static void poissons_equation_converges_on_lattices_and_jittered_points(void **state)
{
  (void)state;
  expect("nom_poisson", NULL, 2);
  expect("nom_poisson", "jittered", 2);
  expect("nom_poisson", "fourth", 2);
  expect("nom_poisson", "fourth_jittered", 2);
}

static void its_functional_is_of_order_four_where_supports_are_whole(void **state)
{
  (void)state;
  expect("nom_poisson", "variational", 2);
}

static void the_plate_bends_as_its_series_says(void **state)
{
  (void)state;
  expect("nom_plate", NULL, 2);
  expect("nom_plate", "jittered", 2);
  expect("nom_plate", "fourth", 2);
  expect("nom_plate", "fourth_jittered", 2);
}

static void the_cantilever_converges_with_operators_of_order_two(void **state)
{
  (void)state;
  expect("nom_elasticity", NULL, 4);
  expect("nom_elasticity", "jittered", 4);
}

/* Operators of order n are exact for polynomials of degree n. */
static void the_cantilever_is_exact_with_operators_of_order_three(void **state)
{
  (void)state;
  expect("nom_elasticity", "third", 2);
  expect("nom_elasticity", "third_jittered", 2);
  expect("nom_elasticity", "third_plane_strain", 2);
}

static void the_cantilevers_energy_takes_operators_of_order_one(void **state)
{
  (void)state;
  expect("nom_elasticity", "first", 4);
}

static void gradient_elasticity_has_its_boundary_layers(void **state)
{
  (void)state;
  expect("nom_gradient_elasticity", NULL, 2);
  expect("nom_gradient_elasticity", "smooth", 2);
  expect("nom_gradient_elasticity", "sheet", 2);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(poissons_equation_converges_on_lattices_and_jittered_points),
      cmocka_unit_test(its_functional_is_of_order_four_where_supports_are_whole),
      cmocka_unit_test(the_plate_bends_as_its_series_says),
      cmocka_unit_test(the_cantilever_converges_with_operators_of_order_two),
      cmocka_unit_test(the_cantilever_is_exact_with_operators_of_order_three),
      cmocka_unit_test(the_cantilevers_energy_takes_operators_of_order_one),
      cmocka_unit_test(gradient_elasticity_has_its_boundary_layers),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
