/* Progress on stderr: a bar on a terminal, a line now and then elsewhere. */
#ifndef SDR_OUTPUT_PROGRESS_H
#define SDR_OUTPUT_PROGRESS_H

#include "output/observer.h"

/* On a terminal one line, redrawn at most 10 times a second and cut to the terminal's width:
   percent, bar, time, time left, step, rate (steps/s), energies, imbalance. Elsewhere a line every
   10 % or 30 s. Energies are those of the ledger's latest row (NULL: none shown). A drawn bar is
   ended with a newline by finish or destroy: destroy it before printing anything else. Borrows the
   ledger. Owner: the caller. */
sdr_status sdr_progress_create(const sdr_observer *ledger, sdr_observer **out);

/* `value` with three digits and an SI prefix: "42.0 us", "1.23 kJ", "0 J". Returns text. */
enum { SDR_PREFIXED_SIZE = 32 };
char *sdr_prefixed(char text[SDR_PREFIXED_SIZE], double value, const char *unit);

#endif
