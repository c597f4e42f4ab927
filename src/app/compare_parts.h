/* The two halves of a comparison: the table and the picture. */
#ifndef SDR_APP_COMPARE_PARTS_H
#define SDR_APP_COMPARE_PARTS_H

#include "app/rundata.h"

#include <stdio.h>

/* Frames of both runs at their last common time (within a step); the last frames if there is none.
   frame: negative without snapshots. */
typedef struct {
  int frame[2];
  int common; /* 1: the same time */
} sdr_frames;

sdr_frames sdr_compare_frames(const sdr_rundata *a, const sdr_rundata *b);

void sdr_compare_table(const sdr_rundata *a, const sdr_rundata *b, FILE *out);

/* Differences of the fields, printed on `out`, or why there are none. */
sdr_status sdr_compare_fields(const sdr_rundata *a, const sdr_rundata *b, FILE *out);

sdr_status sdr_compare_picture(const sdr_rundata *a, const sdr_rundata *b, const char *png,
                               FILE *out);

#endif
