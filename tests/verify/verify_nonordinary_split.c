/* Split non-ordinary bodies dissipate their toughness, whatever the direction of the cut (theory
   sec. 11). */
#include "support/nonordinary.h"
#include "support/split.h"

#include <math.h>

static double separation(const nonordinary_how *how, double tilt)
{
  nonordinary_how longer = *how;
  split plan = split_plan(&longer.shape, tilt);
  nonordinary b = nonordinary_create(&longer);
  const double taken = split_dissipated(&plan, b.shape.points, b.shape.model) / b.toughness[0];
  nonordinary_destroy(&b);
  return taken;
}

static void a_split_body_dissipates_the_toughness_at_0_and_22_5_and_45_degrees(void **state)
{
  (void)state;
  for (int k = 0; k < 2; ++k)
    for (int angle = 0; angle < 3; ++angle) {
      const nonordinary_how how = {
          .shape = {.dimension = k ? SDR_3D : SDR_PLANE_STRESS, .law = SDR_LAW_VARIATIONAL}};
      const double taken = separation(&how, angle * 3.14159265358979323846 / 8.0);
      print_message("%d-D, %g degrees: %.4f\n", 2 + k, 22.5 * angle, taken);
      assert_near(taken, 1.0, 0.05);
    }
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_split_body_dissipates_the_toughness_at_0_and_22_5_and_45_degrees),
  };
  sdr_set_threads(1);
  return cmocka_run_group_tests(tests, NULL, NULL);
}
