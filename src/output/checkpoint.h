/* Checkpoints: everything that a run needs to go on with the same bits (design sec. 4). */
#ifndef SDR_OUTPUT_CHECKPOINT_H
#define SDR_OUTPUT_CHECKPOINT_H

#include "output/observer.h"

/* Write DIRECTORY/checkpoint.h5: version, scene hash, precision, instruction set, step, time,
   step_size, u, v, f, the model's state blocks, the system's sums and each observer's state; beside
   under a temporary name, fsync, rename. */
sdr_status sdr_checkpoint_write(const char *directory, const sdr_moment *moment,
                                const char *instruction_set, sdr_observer *const *observers,
                                int observer_count);

/* Read `path` into the system, model and observers of an already built run, and *step_size. A file
   of another scene (hash), version, precision, instruction set or size, or a truncated one, is
   SDR_BAD_INPUT and says which; an unreadable one SDR_IO_ERROR. Nothing is changed on failure. */
sdr_status sdr_checkpoint_read(const char *path, sdr_moment *moment, const char *instruction_set,
                               sdr_observer *const *observers, int observer_count);

#endif
