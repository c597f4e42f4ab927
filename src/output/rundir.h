/* The directory of a run: made, locked, replaced. */
#ifndef SDR_OUTPUT_RUNDIR_H
#define SDR_OUTPUT_RUNDIR_H

#include "base/status.h"

/* Make `directory` (with parents) and lock it for this process. For a new run (resume = 0) what an
   earlier run left there under our names (design sec. 5, pictures of `plot` too) is removed, files
   of others stay; for a resumed one everything stays. Held by a live process: SDR_BAD_INPUT with
   its pid, nothing touched. Cannot be made or written: SDR_IO_ERROR.
   The lock is DIRECTORY/.lock held by flock, so a dead process holds nothing; *lock is its
   descriptor, given back by sdr_rundir_close (which takes lock < 0 as nothing to do). */
sdr_status sdr_rundir_open(const char *directory, int resume, int *lock);
void sdr_rundir_close(const char *directory, int lock);

/* SDR_IO_ERROR where sdr_rundir_open would fail to make `directory` or to write there; leaves no
   directory that was not there. */
sdr_status sdr_rundir_try(const char *directory);

/* Remove what says that a run is complete (summary.json, pictures): a finished run goes on. */
sdr_status sdr_rundir_reopen(const char *directory);

/* Write `text` to DIRECTORY/name: temporary name, fsync, rename; on failure (SDR_IO_ERROR) the old
   file is as it was and nothing new is left. */
sdr_status sdr_rundir_write(const char *directory, const char *name, const char *text);

/* Bring the finished file `temporary` to the disk and rename it to `path`; on failure
   (SDR_IO_ERROR) `temporary` is removed. */
sdr_status sdr_rundir_settle(const char *temporary, const char *path);

#endif
