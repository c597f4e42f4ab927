/* history.csv: a header line, then rows of numbers at 17 digits, each on the disk when written. */
#ifndef SDR_OUTPUT_HISTORY_H
#define SDR_OUTPUT_HISTORY_H

#include "base/status.h"

typedef struct sdr_history sdr_history;

/* A new DIRECTORY/history.csv with this header (no newline in it). */
sdr_status sdr_history_create(const char *directory, const char *header, sdr_history **out);

/* Go on with the file there: rows later than `time` (s, their first number) and a torn last line
   are cut; *last becomes the time of the last row kept, NAN if none. Another header is
   SDR_BAD_INPUT. No file there: a new one. */
sdr_status sdr_history_continue(const char *directory, const char *header, double time,
                                double *last, sdr_history **out);

/* Append a row. On failure (SDR_IO_ERROR) no part of it is left. */
sdr_status sdr_history_row(sdr_history *history, const double *values, int count);

void sdr_history_close(sdr_history **history); /* NULL-safe */

#endif
