/* What a solved equation leaves in its directory: summary.json, snapshots.h5 and .xdmf. */
#ifndef SDR_APP_EQUATION_FILES_H
#define SDR_APP_EQUATION_FILES_H

#include "equation/solution.h"
#include "output/summary.h"

/* One spacing of a study. */
typedef struct {
  double spacing;
  int32_t points;
  double error_l2, error_max, error_stress; /* NAN: not known */
} sdr_study_level;

typedef struct {
  const sdr_problem *problem; /* at the spacing of the scene, as is the solution */
  const sdr_solution *solution;
  const char *directory, *commit;
  int threads, level_count;
  const sdr_study_level *level; /* coarsest first */
  const sdr_measured *measured;
  int measured_count;
  double setup_seconds, solve_seconds, output_seconds, total_seconds;
} sdr_equation_run;

/* One frame at t = 0: the solution's fields, `exact` and `error` (over the largest exact value)
   where they are known, and the shape tensors' condition numbers. */
sdr_status sdr_equation_write_frame(const sdr_equation_run *run);
sdr_status sdr_equation_write_summary(const sdr_equation_run *run);

#endif
