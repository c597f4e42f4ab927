/* HDF5 files behind a few calls: datasets of numbers at paths like "frame_0000/damage", groups made
   as they are named. Snapshots and checkpoints are written, and read again, through it. */
#ifndef SDR_OUTPUT_STORE_H
#define SDR_OUTPUT_STORE_H

#include "base/status.h"

#include <stddef.h>

typedef struct sdr_store sdr_store;

typedef enum {
  SDR_STORE_FLOAT,
  SDR_STORE_DOUBLE,
  SDR_STORE_INT32,
  SDR_STORE_INT64,
  SDR_STORE_BYTES
} sdr_store_type;

/* rank 0: one value; 1: rows values; 2: rows x columns values, row after row. Unused sizes 1. */
typedef struct {
  sdr_store_type type; /* in memory; the file's type when written, any when read */
  int rank;
  size_t rows, columns;
} sdr_store_shape;

/* Make `path`, replacing what was there: SDR_IO_ERROR if it cannot be made. */
sdr_status sdr_store_create(const char *path, sdr_store **out);

/* Open an existing file. Missing or unreadable: SDR_IO_ERROR; not an HDF5 file, or one cut short:
   SDR_BAD_INPUT. A file that another process is writing may be opened to read. */
sdr_status sdr_store_open(const char *path, int writable, sdr_store **out);

/* Close and release; NULL-safe. SDR_IO_ERROR if the last bytes could not be written. */
sdr_status sdr_store_close(sdr_store **store);

sdr_status sdr_store_flush(sdr_store *store);

/* Write one dataset, new at `name`; `unit` becomes its attribute "unit" (NULL: none). */
sdr_status sdr_store_write(sdr_store *store, const char *name, sdr_store_shape shape,
                           const void *data, const char *unit);
sdr_status sdr_store_write_text(sdr_store *store, const char *name, const char *text);

int sdr_store_has(sdr_store *store, const char *name);

/* rank, rows and columns of a dataset; type is as the file has it. SDR_BAD_INPUT: no such one. */
sdr_status sdr_store_shape_of(sdr_store *store, const char *name, sdr_store_shape *shape);

/* Read a whole dataset of rows * columns values of shape.type into data; another number of values
   in the file, or a file cut short there, is SDR_BAD_INPUT. */
sdr_status sdr_store_read(sdr_store *store, const char *name, sdr_store_shape shape, void *data);
sdr_status sdr_store_read_text(sdr_store *store, const char *name, char *text, size_t size);

/* Members of a group ("/" for the root), by name: how many, and the k-th's name. */
int sdr_store_count(sdr_store *store, const char *group);
sdr_status sdr_store_name(sdr_store *store, const char *group, int k, char *name, size_t size);

/* Remove a group or dataset. */
sdr_status sdr_store_remove(sdr_store *store, const char *name);

#endif
