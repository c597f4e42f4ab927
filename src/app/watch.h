/* Everything that watches a run: made for `run`, and for `check` that it refuses the same. */
#ifndef SDR_APP_WATCH_H
#define SDR_APP_WATCH_H

#include "app/build.h"
#include "output/observer.h"

enum { SDR_WATCHERS = 8 };

typedef struct {
  sdr_observer *ledger, *runaway, *snapshots, *onset, *measures, *cracks, *progress, *adapt;
  sdr_observer *list[SDR_WATCHERS]; /* those there are, in the order they look */
  int count;
} sdr_watchers;

/* What watchers see before a run begins; borrows all. */
sdr_moment sdr_watch_moment(const sdr_built *built, const char *directory);

/* Those that the scene asks for, over what is built; progress only if wanted. Nothing is written
   before the first look. The moment's directory is where they will write. Borrows built and moment,
   which must stay where they are, as must *out. On failure those made so far are in *out. */
sdr_status sdr_watchers_create(sdr_built *built, sdr_moment *moment, int progress,
                               sdr_watchers *out);
void sdr_watchers_destroy(sdr_watchers *watchers); /* those that are NULL already are left out */

#endif
