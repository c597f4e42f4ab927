/* The plate under tension (problem tension_plate) with a quarter of the points, against finite
   elements; verify_long_plates has it whole. */
#include "support/figures.h"
#include "support/scene_text.h"

/* Twice the spacing, and the places beside the axes so that they hold its points. */
#define TWICE                                                                                      \
  "points.spacing=20 mm", "points.refine.0.spacing=10 mm",                                         \
      "regions.x_axis={box: {from: [-0.5 m, 0], to: [0.5 m, 12 mm]}}",                             \
      "regions.y_axis_fine={box: {from: [-8 mm, -0.5 m], to: [0, 0.5 m]}}",                        \
      "regions.y_axis_coarse={box: {from: [0, -0.5 m], to: [12 mm, 0.5 m]}}", "output.probes=[]",  \
      "output.snapshots=0"

static void a_non_ordinary_plate_bends_as_finite_elements_do(void **state)
{
  (void)state;
  static const char *const twice[] = {TWICE, NULL};
  figures f;
  figures_run(&f, "tension_plate", "nonordinary_2", twice);
  figures_assert_accepted(&f, 3);
  figures_free(&f);
}

/* Four neighbours along the axes resist no shear. */
static void
an_ordinary_plate_with_a_horizon_of_one_spacing_is_a_mechanism_and_is_refused(void **state)
{
  (void)state;
  static const char *const coarse[] = {"points.spacing=50 mm", "points.refine.0.spacing=25 mm",
                                       "output.measures={}", "figures={}", NULL};
  sdr_built built;
  problem_build(&built, "tension_plate", "ordinary_1", coarse);
  sdr_status status = built.integrator->start(built.system, built.step);
  if (status == SDR_OK) status = built.integrator->step(built.system, built.step);
  assert_int_equal(status, SDR_RUN_FAILED);
  static const char begin[] = "the stiffness is singular: the point at x = ";
  assert_int_equal(strncmp(sdr_error_message(), begin, sizeof begin - 1), 0);
  assert_non_null(strstr(sdr_error_message(), "can move freely along "));
  sdr_built_destroy(&built);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_non_ordinary_plate_bends_as_finite_elements_do),
      cmocka_unit_test(
          an_ordinary_plate_with_a_horizon_of_one_spacing_is_a_mechanism_and_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
