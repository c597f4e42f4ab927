/* Progress on stderr: a bar on a terminal, a line now and then elsewhere. */
#ifndef SDR_OUTPUT_PROGRESS_H
#define SDR_OUTPUT_PROGRESS_H

#include "output/observer.h"

/* Bar: percent, step, time, energies (kinetic, dissipated, imbalance), rate (steps/s), time left;
   redrawn at most 10 times a second on a terminal, else a line every 10 % or 30 s. `ledger` may be
   NULL (then no energies). */
sdr_status sdr_progress_create(const sdr_observer *ledger, sdr_observer **out);

#endif
