/* Tables of reference values: two columns of a CSV file. */
#ifndef SDR_SCENE_TABLE_H
#define SDR_SCENE_TABLE_H

#include "scene/store.h"

/* Read the columns named `key` and `value` of a file whose first line names its columns; values
   are separated by commas, empty lines and lines that begin with # are left out. At least 2 rows,
   at most a million, keys rising. The arrays belong to the store. SDR_BAD_INPUT (also for a file
   that cannot be read): the message names the file and line. */
sdr_status sdr_table_read(sdr_store *store, const char *path, const char *key, const char *value,
                          int *rows, double **keys, double **values);

#endif
