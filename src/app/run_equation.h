/* `sunder run` and `sunder check` of a scene with an equation: solved once, or at several spacings
   for its order of convergence. */
#ifndef SDR_APP_RUN_EQUATION_H
#define SDR_APP_RUN_EQUATION_H

#include "app/run.h"

/* Solve and write the run's directory; a few lines of results go to `out`. */
sdr_status sdr_run_equation(sdr_scene *scene, const sdr_run_options *options, FILE *out);

/* What would be solved: points, supports, condition numbers, defaults. */
sdr_status sdr_check_equation(sdr_scene *scene, FILE *out);

#endif
