/* A first reading of an HDF5 file in a process of its own: over a damaged file HDF5 may hang, take
   all memory or crash, and only that process then does. */
#ifndef SDR_OUTPUT_HDF_TRIAL_H
#define SDR_OUTPUT_HDF_TRIAL_H

#include "base/status.h"

/* Open the file in a child process and look at every group, dataset and attribute in it, not at
   the datasets' values, which cannot mislead HDF5. SDR_OK: the child came to the end, so this
   process may open the file, or learn in order from sdr_hdf_open what is the matter with it.
   SDR_IO_ERROR: it did not, within 1 s of processor time an object and 1 GB, or it met something
   that this program never writes (chunks; more values than the file has bytes). */
sdr_status sdr_hdf_trial(const char *path);

#endif
