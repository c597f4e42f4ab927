/* Points that split while a run goes on (000 sec. 5.3; docs/theory.md, "Points that split"). */
#ifndef SDR_APP_ADAPT_H
#define SDR_APP_ADAPT_H

#include "app/build.h"
#include "output/observer.h"

/* What an adaptive run did. */
typedef struct {
  int64_t events;          /* times that points split, since the run began */
  int32_t first_points;    /* how many points it began with */
  double energy;           /* J: sum over the events of |change of the energy| */
  double seconds, looking; /* s of wall time since the run began or was resumed: rebuilding, and
                              finding out whether to */
} sdr_adapt_record;

/* An observer that, when it is shown a moment (after all others), splits points as the scene asks:
   it puts new points, model and system into *built, brings the moment's system, step_size and steps
   up to date and tells the `count` observers (itself may be among them). All are borrowed, the list
   may grow until the first look. Owner: the caller. */
sdr_status sdr_adapt_create(sdr_built *built, sdr_moment *moment, sdr_observer *const *observers,
                            const int *count, sdr_observer **out);

/* Before a checkpoint is read: bring the points of a run just built to those that the file at
   `path` is of, and tell the observers. Nothing if the file tells of none that fit: reading it says
   what is wrong. */
sdr_status sdr_adapt_resume(sdr_observer *adapt, const char *path);

sdr_adapt_record sdr_adapt_look(const sdr_observer *adapt);

#endif
