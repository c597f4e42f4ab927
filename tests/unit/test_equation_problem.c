/* equation: problems from scenes, solved without the program around them. */
#include "equation/solution.h"
#include "support/cmocka_all.h"

#include <math.h>
#include <stdio.h>

static void load(const char *problem, const char *variant, sdr_scene **scene)
{
  char path[400];
  snprintf(path, sizeof path, "%s/problems/%s/scene.yaml", SUNDER_SOURCE_DIR, problem);
  if (sdr_scene_load(path, variant, 0, NULL, scene) != SDR_OK) fail_msg("%s", sdr_error_message());
}

/* The error at the coarsest spacing of the scene's study. */
static double coarse_error(const char *name, const char *variant)
{
  sdr_scene *scene;
  sdr_problem *problem;
  sdr_solution solution;
  load(name, variant, &scene);
  if (scene->equation->coarser_count > 0) scene->points.spacing = scene->equation->coarser[0];
  if (sdr_problem_create(scene, &problem) != SDR_OK) fail_msg("%s", sdr_error_message());
  if (sdr_problem_solve(problem, &solution) != SDR_OK) fail_msg("%s", sdr_error_message());
  const double error = solution.error_l2;
  sdr_solution_destroy(&solution);
  sdr_problem_destroy(&problem);
  sdr_scene_destroy(&scene);
  return error;
}

static void every_kind_and_form_solves_its_problem(void **state)
{
  (void)state;
  assert_true(coarse_error("nom_poisson", NULL) < 1e-2);
  assert_true(coarse_error("nom_poisson", "fourth_jittered") < 1e-4);
  assert_true(coarse_error("nom_poisson", "variational") < 2e-5);
  assert_true(coarse_error("nom_plate", "jittered") < 6e-2);
  assert_true(coarse_error("nom_elasticity", NULL) < 0.1);
  assert_true(coarse_error("nom_elasticity", "first") < 0.03);
  assert_true(coarse_error("nom_gradient_elasticity", NULL) < 0.03);
  assert_true(coarse_error("nom_gradient_elasticity", "sheet") < 0.04);
}

/* Cells at an edge of the square are halved, at a corner quartered. */
static void a_functionals_volumes_add_up_to_the_shape(void **state)
{
  (void)state;
  sdr_scene *scene;
  sdr_problem *problem;
  double all = 0.0;
  load("nom_elasticity", "first", &scene);
  scene->points.spacing = 0.125;
  assert_int_equal(sdr_problem_create(scene, &problem), SDR_OK);
  for (int32_t i = 0; i < problem->points->count; ++i) all += problem->volume[i];
  assert_true(fabs(all - 2.0) < 1e-12);
  sdr_problem_destroy(&problem);
  sdr_scene_destroy(&scene);
}

/* Jitter moves no point of the surface, where conditions are met. */
static void jitter_leaves_the_surface(void **state)
{
  (void)state;
  sdr_scene *scene;
  sdr_problem *problem;
  int32_t on = 0, moved = 0;
  load("nom_poisson", "jittered", &scene);
  scene->points.spacing = 0.1;
  assert_int_equal(sdr_problem_create(scene, &problem), SDR_OK);
  for (int32_t i = 0; i < problem->points->count; ++i) {
    double x[3];
    sdr_problem_place(problem, i, x);
    on += fabs(fmax(fabs(x[0] - 0.5), fabs(x[1] - 0.5)) - 0.5) < 1e-12;
    moved += fabs(x[0] / 0.1 - rint(x[0] / 0.1)) > 1e-9;
  }
  assert_int_equal(on, 40);
  assert_int_equal(moved, 81);
  sdr_problem_destroy(&problem);
  sdr_scene_destroy(&scene);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_kind_and_form_solves_its_problem),
      cmocka_unit_test(a_functionals_volumes_add_up_to_the_shape),
      cmocka_unit_test(jitter_leaves_the_surface),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
