/* Checkpoints: everything that a run needs to go on with the same bits (design sec. 4). */
#ifndef SDR_OUTPUT_CHECKPOINT_H
#define SDR_OUTPUT_CHECKPOINT_H

#include "output/observer.h"

/* 1 at the steps nearest to the multiples of scene->output.checkpoint_every, and at the end; never
   at step 0. Cheap: asked every step. */
int sdr_checkpoint_due(const sdr_moment *moment);

/* Write DIRECTORY/checkpoint.h5: version, scene hash, precision, instruction set, step, time,
   step size, u, v, f, the model's state blocks, the system's sums and each observer's state, under
   a seal over the whole file; beside under a temporary name, fsync, rename, so that an earlier
   checkpoint lives until the new one is whole. To be called when all observers have looked at the
   moment. */
sdr_status sdr_checkpoint_write(const char *directory, const sdr_moment *moment,
                                const char *instruction_set, sdr_observer *const *observers,
                                int observer_count);

/* Read `path` into the system, model and observers of an already built run, and into the moment's
   time, step and step_size; then remove the mark of completeness in moment->directory and call
   each observer's `resumed`. A file of another scene (hash), version, precision, instruction set
   or size, or a truncated or damaged one, is SDR_BAD_INPUT and says which; one that cannot be read
   SDR_IO_ERROR; nothing is changed then. What `resumed` fails with is passed on, the state is then
   the checkpoint's. */
sdr_status sdr_checkpoint_read(const char *path, sdr_moment *moment, const char *instruction_set,
                               sdr_observer *const *observers, int observer_count);

#endif
