/* What a run left in its directory (design: commands and files), read back: summary.json,
   history.csv and snapshots.h5. Each may be missing, so that a run in progress can be looked at. */
#ifndef SDR_APP_RUNDATA_H
#define SDR_APP_RUNDATA_H

#include "base/status.h"

#include <stdint.h>

struct json_t;

/* history.csv: `row_count` rows of `column_count` numbers, column after column. */
typedef struct {
  int row_count, column_count;
  char **name;   /* of each column */
  double *value; /* value[column * row_count + row] */
} sdr_history;

typedef struct {
  char *directory;
  struct json_t *summary; /* NULL: the run has not finished */
  sdr_history history;    /* no rows: no history.csv */
  int64_t snapshots;      /* HDF5 file; negative: no snapshots.h5 */
  int32_t point_count;    /* 0 without snapshots */
  int dimension;          /* 1, 2 or 3: up to the last component in which the points differ */
  double *position[3];    /* m */
  double *volume;         /* m^3; NULL if the file has none */
  int frame_count;        /* whole frames only; one that is being written does not count */
  double *frame_time;     /* s, rising */
  int points_frame;       /* the frame whose points these are; -1: those that the run began with */
} sdr_rundata;

/* Read the directory; the fields of the frames are read when asked for. A missing directory or an
   unreadable file is SDR_IO_ERROR; one without any of the three files, or a file with wrong
   content, is SDR_BAD_INPUT. Owner: the caller. */
sdr_status sdr_rundata_open(const char *directory, sdr_rundata **out);
void sdr_rundata_destroy(sdr_rundata **run); /* NULL-safe */

/* Bring point_count, position and volume to those of the frame: points may have split on the way.
   To be called before fields of the frame are read. */
sdr_status sdr_rundata_use(sdr_rundata *run, int frame);

/* A value of summary.json by its path ("energy.kinetic"): NULL or NAN where it is missing, null or
   of another type. The text belongs to the run. */
const char *sdr_rundata_text(const sdr_rundata *run, const char *path);
double sdr_rundata_number(const sdr_rundata *run, const char *path);

/* Name of the k-th entry of `figures` in summary.json; NULL past the last. */
const char *sdr_rundata_figure(const sdr_rundata *run, int k);

/* Column of history.csv, row_count numbers; NULL if there is none of this name. */
const double *sdr_rundata_column(const sdr_rundata *run, const char *name);

/* The last row's value, NAN if there is no such column or row. */
double sdr_rundata_last(const sdr_rundata *run, const char *name);

/* The frame whose time is nearest; negative if there is none. */
int sdr_rundata_nearest(const sdr_rundata *run, double time);

/* 1 if the frame holds the field. */
int sdr_rundata_has(const sdr_rundata *run, int frame, const char *field);

/* Names of the frame's fields, sorted, joined by ", ". Caller: sdr_free. NULL: out of memory. */
char *sdr_rundata_fields(const sdr_rundata *run, int frame);

/* Read a field: (*values)[point * *components + component], SI. The caller frees with sdr_free.
   An unknown field is SDR_BAD_INPUT and the message lists those present. */
sdr_status sdr_rundata_field(const sdr_rundata *run, int frame, const char *field, float **values,
                             int *components);

/* Parts of sdr_rundata_open: read one file. */
sdr_status sdr_history_read(const char *path, sdr_history *out);
void sdr_history_clear(sdr_history *history);

#endif
