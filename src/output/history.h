/* history.csv: a header line, then rows of numbers at 17 digits, each on the disk when written. */
#ifndef SDR_OUTPUT_HISTORY_H
#define SDR_OUTPUT_HISTORY_H

#include "base/status.h"

typedef struct sdr_history_file sdr_history_file;

/* A new DIRECTORY/history.csv with this header (no newline in it). */
sdr_status sdr_history_file_create(const char *directory, const char *header,
                                   sdr_history_file **out);

/* Go on with the file there: rows later than `time` (s, their first number) and a torn last line
   are cut; *last becomes the time of the last row kept, NAN if none. Another header is
   SDR_BAD_INPUT. No file there: a new one. */
sdr_status sdr_history_file_continue(const char *directory, const char *header, double time,
                                     double *last, sdr_history_file **out);

/* Append a row. On failure (SDR_IO_ERROR) no part of it is left. */
sdr_status sdr_history_file_row(sdr_history_file *history, const double *values, int count);

void sdr_history_file_close(sdr_history_file **history); /* NULL-safe */

#endif
