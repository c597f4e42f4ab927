/* The program's version, as summary.json and checkpoints carry it. */
#ifndef SDR_OUTPUT_VERSION_H
#define SDR_OUTPUT_VERSION_H

/* A build may give another with -DSUNDER_VERSION=... */
#ifndef SUNDER_VERSION
#define SUNDER_VERSION "0.1.0"
#endif

#endif
