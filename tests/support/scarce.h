/* Runs of a scene in which one allocation, or all from one on, fails. */
#ifndef SDR_TESTS_SCARCE_H
#define SDR_TESTS_SCARCE_H

#include "app/run.h"
#include "base/memory.h"
#include "support/cmocka_all.h"

#include <string.h>
#include <unistd.h>

typedef struct {
  const char *scene, *directory; /* paths; the directory of the results */
  int set_count;
  const char *const *sets;
} scarce_run;

static inline int scarce_has(const scarce_run *run, const char *name)
{
  char path[700];
  snprintf(path, sizeof path, "%s/%s", run->directory, name);
  return access(path, F_OK) == 0;
}

static inline void scarce_remove(const scarce_run *run, const char *name)
{
  char path[700];
  snprintf(path, sizeof path, "%s/%s", run->directory, name);
  assert_int_equal(unlink(path), 0);
}

/* What a run that failed may leave: nothing that looks complete or that stands in the way. */
static inline void scarce_check(const scarce_run *run, sdr_status status, long successes)
{
  static const char *const never[] = {"summary.json",      ".lock",          "checkpoint.h5.part",
                                      "snapshots.h5.part", "used.yaml.part", "summary.json.part"};
  if (status != SDR_RUN_FAILED)
    fail_msg("allocation %ld failed, status %d: %s", successes, (int)status, sdr_error_message());
  if (!strstr(sdr_error_message(), "memory"))
    fail_msg("allocation %ld failed: %s", successes, sdr_error_message());
  for (size_t k = 0; k < sizeof never / sizeof *never; ++k)
    if (scarce_has(run, never[k])) fail_msg("allocation %ld failed: %s", successes, never[k]);
}

/* Run with `successes` allocations allowed; once: only one fails. 1 if the run came to its end. */
static inline int scarce_try(const scarce_run *run, long successes, int once)
{
  const sdr_run_options options = {.scene = run->scene,
                                   .directory = run->directory,
                                   .set_count = run->set_count,
                                   .sets = run->sets,
                                   .quiet = 1};
  FILE *silent = fopen("/dev/null", "w");
  assert_non_null(silent);
  const size_t before = sdr_memory_now();
  sdr_fail(SDR_OK, "%s", "");
  if (once)
    sdr_memory_fail_once(successes);
  else
    sdr_memory_fail_after(successes);
  const sdr_status status = sdr_run(&options, silent);
  sdr_memory_fail_after(-1);
  fclose(silent);
  if (sdr_memory_now() != before)
    fail_msg("allocation %ld failed: %zu bytes are lost", successes, sdr_memory_now() - before);
  if (status == SDR_OK) {
    assert_true(scarce_has(run, "summary.json"));
    scarce_remove(run, "summary.json");
    return 1;
  }
  scarce_check(run, status, successes);
  return 0;
}

/* Let the allocations first, first + stride, ... fail, until a run comes to its end; how many runs
   did not. With `once` a run may come to its end earlier, where it knew what to do instead: those
   are counted in *survived. */
static inline int scarce_all(const scarce_run *run, long first, long stride, int once, long most,
                             int *survived)
{
  int failures = 0;
  for (long k = first; most <= 0 || k < most; k += stride) {
    if (!scarce_try(run, k, once))
      ++failures;
    else if (!once)
      break;
    else
      ++*survived;
  }
  return failures;
}

#endif
