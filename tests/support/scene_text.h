/* Runs from scenes written in a test. */
#ifndef SDR_TESTS_SCENE_TEXT_H
#define SDR_TESTS_SCENE_TEXT_H

#include "app/build.h"
#include "support/body.h"

#include <unistd.h>

/* Build a scene from its text, formatted as by printf. */
__attribute__((format(printf, 2, 3))) static inline sdr_status scene_try(sdr_built *out,
                                                                         const char *format, ...)
{
  char path[] = "/tmp/sunder_verify_XXXXXX";
  const int descriptor = mkstemp(path);
  assert_true(descriptor >= 0);
  FILE *file = fdopen(descriptor, "w");
  assert_non_null(file);
  va_list arguments;
  va_start(arguments, format);
  vfprintf(file, format, arguments);
  va_end(arguments);
  fclose(file);
  const sdr_status status = sdr_build(path, NULL, 0, NULL, out);
  unlink(path);
  return status;
}

#define scene_build(out, ...)                                                                      \
  do {                                                                                             \
    if (scene_try(out, __VA_ARGS__) != SDR_OK) fail_msg("%s", sdr_error_message());                \
  } while (0)

/* A scene of problems/ with overrides (a NULL ends them). */
static inline void problem_build(sdr_built *out, const char *name, const char *variant,
                                 const char *const sets[])
{
  char path[512];
  int count = 0;
  while (sets && sets[count]) ++count;
  snprintf(path, sizeof path, "%s/problems/%s/scene.yaml", SUNDER_SOURCE_DIR, name);
  if (sdr_build(path, variant, count, sets, out) != SDR_OK) fail_msg("%s", sdr_error_message());
}

static inline void run_start(const sdr_built *built)
{
  if (built->integrator->start(built->system, built->step) != SDR_OK)
    fail_msg("%s", sdr_error_message());
}

static inline void run_step(const sdr_built *built)
{
  if (built->integrator->step(built->system, built->step) != SDR_OK)
    fail_msg("%s", sdr_error_message());
}

static inline double balance_energy(const sdr_balance *balance)
{
  return balance->kinetic + balance->model.stored + balance->model.dissipated;
}

/* Run to `end` (s) and look every `interval` (s, a multiple of the step): the largest |energy -
   start - external work| over the largest energy. */
static inline double run_imbalance(const sdr_built *built, double end, double interval)
{
  sdr_balance balance;
  run_start(built);
  sdr_system_balance(built->system, &balance);
  const double start = balance_energy(&balance);
  double worst = 0.0, most = start;
  const long every = lround(interval / built->step), steps = lround(end / built->step);
  for (long n = 1; n <= steps; ++n) {
    run_step(built);
    if (n % every != 0) continue;
    sdr_system_balance(built->system, &balance);
    const double energy = balance_energy(&balance);
    worst = fmax(worst, fabs(energy - start - built->system->external_work));
    most = fmax(most, energy);
  }
  return worst / most;
}

#endif
