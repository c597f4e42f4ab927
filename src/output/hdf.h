/* HDF5 files behind a few calls: datasets of numbers at paths like "frame_0000/damage", groups made
   as they are named. Snapshots and checkpoints are written, and read again, through it. */
#ifndef SDR_OUTPUT_HDF_H
#define SDR_OUTPUT_HDF_H

#include "base/status.h"

#include <stddef.h>

typedef struct sdr_hdf sdr_hdf;

typedef enum {
  SDR_HDF_FLOAT,
  SDR_HDF_DOUBLE,
  SDR_HDF_INT32,
  SDR_HDF_INT64,
  SDR_HDF_BYTES
} sdr_hdf_type;

/* rank 0: one value; 1: rows values; 2: rows x columns values, row after row. Unused sizes 1. */
typedef struct {
  sdr_hdf_type type; /* in memory; the file's type when written, any when read */
  int rank;
  size_t rows, columns;
} sdr_hdf_shape;

/* Make `path`, replacing what was there: SDR_IO_ERROR if it cannot be made. */
sdr_status sdr_hdf_create(const char *path, sdr_hdf **out);
/* The same with SDR_SEAL_BYTES bytes before all that HDF5 writes (sdr_seal_write fills them). */
sdr_status sdr_hdf_create_sealed(const char *path, sdr_hdf **out);

/* Open an existing file. Missing or unreadable: SDR_IO_ERROR; not an HDF5 file, or one cut short:
   SDR_BAD_INPUT. A file that another process is writing may be opened to read. */
sdr_status sdr_hdf_open(const char *path, int writable, sdr_hdf **out);

/* Close and release; NULL-safe. SDR_IO_ERROR if the last bytes could not be written. */
sdr_status sdr_hdf_close(sdr_hdf **file);

/* The same without a word about failure: for files only read, or already failed. The error message
   stays that of before. NULL-safe. */
void sdr_hdf_discard(sdr_hdf **file);

sdr_status sdr_hdf_flush(sdr_hdf *file);

/* Ask for `bytes` more on the disk ahead of writing them, where the file system can promise that;
   SDR_IO_ERROR if there is no room. HDF5 may spoil a file whose disk fills half way through a
   write, so ask before. */
sdr_status sdr_hdf_reserve(sdr_hdf *file, size_t bytes);

/* Write one dataset, new at `name`; `unit` becomes its attribute "unit" (NULL: none). */
sdr_status sdr_hdf_write(sdr_hdf *file, const char *name, sdr_hdf_shape shape, const void *data,
                         const char *unit);
sdr_status sdr_hdf_write_text(sdr_hdf *file, const char *name, const char *text);

int sdr_hdf_has(sdr_hdf *file, const char *name);

/* rank, rows and columns of a dataset; type is as the file has it. SDR_BAD_INPUT: no such one. */
sdr_status sdr_hdf_shape_of(sdr_hdf *file, const char *name, sdr_hdf_shape *shape);

/* Read a whole dataset of rows * columns values of shape.type into data; another number of values
   in the file, or a file cut short there, is SDR_BAD_INPUT. */
sdr_status sdr_hdf_read(sdr_hdf *file, const char *name, sdr_hdf_shape shape, void *data);
sdr_status sdr_hdf_read_text(sdr_hdf *file, const char *name, char *text, size_t size);

/* How many members a group has ("/" for the root); 0 if there is no such group. */
int sdr_hdf_count(sdr_hdf *file, const char *group);

/* Copy a group, with all that is in it, or a dataset to the same name in another file. */
sdr_status sdr_hdf_copy(sdr_hdf *from, sdr_hdf *to, const char *name);

#endif
