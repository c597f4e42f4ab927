/* `sunder run`: from a scene to a directory of results. */
#ifndef SDR_APP_RUN_H
#define SDR_APP_RUN_H

#include "scene/scene.h"

#include <stdio.h>

typedef struct {
  const char *scene;     /* path of the scene's file */
  const char *variant;   /* NULL: none */
  const char *directory; /* NULL: the checkpoint's, the scene's, or out/<scene>[-variant] */
  const char *resume;    /* a checkpoint; NULL: start at t = 0 */
  int set_count;
  const char *const *sets; /* "path=value" */
  int threads;             /* 0: the scene's, or all */
  int quiet;               /* 1: no progress */
  int stoppable; /* 1: SIGINT and SIGTERM end it after a step with a checkpoint and SDR_STOPPED;
                    0: signals are left alone */
} sdr_run_options;

/* Run to the end; a few lines of results go to `out`, progress to stderr. */
sdr_status sdr_run(const sdr_run_options *options, FILE *out);

#endif
