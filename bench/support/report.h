/* What every benchmark writes beside its figures: where they come from, and files to hold them. */
#ifndef SDR_BENCH_REPORT_H
#define SDR_BENCH_REPORT_H

#include "base/status.h"

#include <stdio.h>

enum { BENCH_PATH = 512 };

/* Make out/bench/NAME with its parents below the current folder; `path` gets it. */
sdr_status bench_directory(const char *name, char path[BENCH_PATH]);

/* Open DIRECTORY/NAME.csv and write three lines that begin with #: commit, compiler, machine. */
sdr_status bench_csv(const char *directory, const char *name, FILE **out);

/* The same on one line, for tables and pictures: "AMD EPYC (2 cores), gcc 12.2.0, commit ...". */
const char *bench_origin(void);

/* Seconds of a clock that only goes forward; seconds that this process has computed, all threads
   together. */
double bench_clock(void);
double bench_processor_clock(void);

#endif
