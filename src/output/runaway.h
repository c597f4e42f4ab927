/* Stops a run whose energy comes from nowhere: an unstable step that damage keeps from growing to
   numbers that are not finite. */
#ifndef SDR_OUTPUT_RUNAWAY_H
#define SDR_OUTPUT_RUNAWAY_H

#include "output/observer.h"

/* Looks whenever the ledger (borrowed, and before it in the run's list) writes a row. After 5 rows
   in a row in which more than half of the largest energy is imbalance, or bonds gave more than half
   of what is there by breaking, SDR_RUN_FAILED with the time and the fastest point; at once where
   the energy is no number. Owner: the caller. */
sdr_status sdr_runaway_create(sdr_observer *ledger, sdr_observer **out);

#endif
