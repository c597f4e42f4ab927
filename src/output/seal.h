/* A seal over a whole file: tells a file that is as it was written from one that a disk, a copy or
   a hand has changed, before a library tries to make sense of it (HDF5 may hang, or take all
   memory, over a damaged file). It is no protection against intent. */
#ifndef SDR_OUTPUT_SEAL_H
#define SDR_OUTPUT_SEAL_H

#include "base/status.h"

/* Bytes at the start of a sealed file that are left to the seal: HDF5's smallest user block. */
enum { SDR_SEAL_BYTES = 512 };

/* Write the seal of what follows the first SDR_SEAL_BYTES bytes. SDR_IO_ERROR: the file is then as
   it was, or without a seal that holds. */
sdr_status sdr_seal_write(const char *path);

/* 1: the file has a seal and it holds; 0: not, or the file cannot be read. */
int sdr_seal_holds(const char *path);

#endif
