/* A wish from outside that a run end early: SIGINT (Ctrl-C) or SIGTERM. */
#ifndef SDR_APP_STOP_H
#define SDR_APP_STOP_H

/* From here on the first of these signals is only noted; a second one ends the process at once.
   Signals that are ignored stay so. */
void sdr_stop_watch(void);
void sdr_stop_unwatch(void); /* as before sdr_stop_watch */

/* "SIGINT" or "SIGTERM" once it has come, else NULL. Cheap: asked every step. */
const char *sdr_stop_asked(void);

#endif
