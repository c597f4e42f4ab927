/* Each allocation of a run, from the scene's first letter to the summary, fails once by itself and
   once with all after it: the run says so, leaks nothing and leaves nothing that looks complete. */
#include "support/scarce.h"

#include "app/find_scene.h"

#include <stdlib.h>

static char folder[] = "/tmp/sunder_memory_XXXXXX";

static int enter(void **state)
{
  (void)state;
  return !mkdtemp(folder) || chdir(folder) != 0;
}

static int leave(void **state)
{
  (void)state;
  return chdir("/") != 0 || system("rm -rf /tmp/sunder_memory_??????") != 0;
}

/* Not missed: a scratch list that saves time when bonds are made. */
static void starve(const scarce_run *run)
{
  int survived = 0;
  const int all = scarce_all(run, 0, 1, 0, 0, &survived);
  assert_true(all > 100);
  const int alone = scarce_all(run, 0, 1, 1, all, &survived);
  print_message("%s: %d allocations, %d of them not missed\n", run->scene, all, survived);
  assert_int_equal(alone + survived, all);
  assert_true(survived <= 1);
}

static void a_cylinder_that_breaks(void **state)
{
  (void)state;
  static const char *const sets[] = {
      "points.spacing=8 mm",
      "time.end=8 us",
      "time.step=1.6 us",
      "output.snapshots=2",
      "output.checkpoint.every=4 us",
      "output.measures={m: {kind: max, field: velocity, component: norm}}",
      "output.probes=[{name: tip, at: [81 mm, 0]}]",
      "output.fields=[displacement, damage, stress, fragment]"};
  char scene[SDR_SCENE_PATH];
  assert_int_equal(sdr_find_scene("thick_cylinder", scene), SDR_OK);
  starve(&(scarce_run){scene, "ring", sizeof sets / sizeof *sets, sets});
}

static const char *write_scene(const char *name, const char *text)
{
  FILE *file = fopen(name, "w");
  assert_non_null(file);
  fputs(text, file);
  fclose(file);
  return name;
}

#define PLATE                                                                                      \
  "dimension: plane_stress\n"                                                                      \
  "points: {shape: {box: {size: [30 mm, 12 mm]}}, spacing: 2 mm, align: cell}\n"                   \
  "material: {young: 30 GPa, density: 2400 kg/m^3, toughness: 80 J/m^2, strength: 3 MPa}\n"        \
  "supports:\n"                                                                                    \
  "  - {name: foot, on: left, depth: 2 spacing, displacement: [0, 0]}\n"                           \
  "  - {name: pull, on: right, depth: 2 spacing, displacement: {x: \"4 um * t/(1 s)\"}}\n"         \
  "output: {snapshots: 1, checkpoint: {every: 0.5 s}}\n"

static void a_plate_pulled_apart_slowly(void **state)
{
  (void)state;
  const char *scene = write_scene("slow.yaml", PLATE "damage: {law: cohesive}\n"
                                                     "time: {integrator: static, end: 1 s, "
                                                     "step: 0.25 s}\n");
  starve(&(scarce_run){scene, "slow", 0, NULL});
}

static void a_linear_plate_with_every_solver(void **state)
{
  (void)state;
  static const char *const sets[][1] = {
      {"time.solver=cholmod"}, {"time.solver=umfpack"}, {"time.solver=klu"}, {"time.solver=pcg"}};
  const char *scene = write_scene("linear.yaml", PLATE "time: {integrator: static}\n");
  for (size_t k = 0; k < sizeof sets / sizeof *sets; ++k)
    starve(&(scarce_run){scene, "linear", 1, sets[k]});
}

static void a_plate_in_motion_by_each_implicit_integrator(void **state)
{
  (void)state;
  static const char *const sets[][1] = {
      {"time.integrator=energy_momentum"}, {"time.integrator=cvode"}, {"time.integrator=ida"}};
  const char *scene = write_scene("moving.yaml", PLATE "damage: {law: variational}\n"
                                                       "initial: {velocity: [1 m/s * x/(1 m), 0]}\n"
                                                       "time: {step: 2 us, end: 6 us}\n");
  for (size_t k = 0; k < sizeof sets / sizeof *sets; ++k)
    starve(&(scarce_run){scene, "moving", 1, sets[k]});
}

static void state_based_plates_that_tear(void **state)
{
  (void)state;
  static const char *const sets[][3] = {
      {"material.model=ordinary", "material.poisson=0.2", "damage.law=critical_stretch"},
      {"material.model=nonordinary", "material.poisson=0.2", "damage.law=variational"}};
  const char *scene = write_scene("state.yaml", PLATE "damage: {law: variational}\n"
                                                      "cracks: [{segment: {from: [0, 0], to: "
                                                      "[0, 9 mm]}}]\n"
                                                      "time: {step: 0.1 us, end: 0.4 us}\n");
  for (size_t k = 0; k < sizeof sets / sizeof *sets; ++k)
    starve(&(scarce_run){scene, "state", 3, sets[k]});
}

static void scattered_points_with_layers_and_loads(void **state)
{
  (void)state;
  const char *scene = write_scene(
      "scattered.yaml",
      "dimension: plane_strain\n"
      "points: {shape: {box: {size: [20 mm, 10 mm]}}, spacing: 1 mm, jitter: {share: 10 %},\n"
      "         refine: [{where: {disc: {radius: 2 mm}}, spacing: 0.5 mm}]}\n"
      "family: {weight: surface_iso}\n"
      "material: {young: 30 GPa, density: 2400 kg/m^3, toughness: 80 J/m^2, scatter: {young: 5 "
      "%}}\n"
      "damage: {law: critical_stretch, protect: [{disc: {radius: 2 mm}}]}\n"
      "loads:\n"
      "  - {traction: {on: right, value: [1 MPa, 0], spread: layer}}\n"
      "  - {body: {value: [0, \"1 MPa/(1 m) * t/(1 us)\"]}}\n"
      "supports: [{on: left, displacement: [0, null], ramp: 1 us}]\n"
      "time: {step: 0.05 us, end: 0.2 us}\n"
      "output: {snapshots: 1, fields: [velocity, reaction, strain, energy_density]}\n");
  starve(&(scarce_run){scene, "scattered", 0, NULL});
}

static void equations(void **state)
{
  (void)state;
  static const char *const sets[] = {"points.spacing=0.1", "equation.coarser=[]"};
  char scene[SDR_SCENE_PATH];
  assert_int_equal(sdr_find_scene("nom_poisson", scene), SDR_OK);
  starve(&(scarce_run){scene, "poisson", 2, sets});
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_cylinder_that_breaks),
      cmocka_unit_test(a_plate_pulled_apart_slowly),
      cmocka_unit_test(a_linear_plate_with_every_solver),
      cmocka_unit_test(a_plate_in_motion_by_each_implicit_integrator),
      cmocka_unit_test(state_based_plates_that_tear),
      cmocka_unit_test(scattered_points_with_layers_and_loads),
      cmocka_unit_test(equations),
  };
  return cmocka_run_group_tests(tests, enter, leave);
}
