/* The directory of a run: made, locked, replaced. */
#ifndef SDR_OUTPUT_RUNDIR_H
#define SDR_OUTPUT_RUNDIR_H

#include "base/status.h"

/* Make `directory` (with parents) ready for a new run (resume = 0): a finished or dead run's files
   of ours (the names of design sec. 5) are removed, files of others are left; or for a resumed one
   (files kept). Locked by a live process: SDR_BAD_INPUT naming its pid. Not writable: SDR_IO_ERROR.
   The lock is the file DIRECTORY/.lock held by flock; *lock is its descriptor. */
sdr_status sdr_rundir_open(const char *directory, int resume, int *lock);
void sdr_rundir_close(const char *directory, int lock);

/* Write `text` to DIRECTORY/name: temporary name, fsync, rename. */
sdr_status sdr_rundir_write(const char *directory, const char *name, const char *text);

#endif
