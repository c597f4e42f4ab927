#include "app/watch.h"

#include "app/adapt.h"
#include "output/crack_tips.h"
#include "output/ledger.h"
#include "output/measures.h"
#include "output/onset.h"
#include "output/progress.h"
#include "output/runaway.h"
#include "output/snapshots.h"

sdr_moment sdr_watch_moment(const sdr_built *built, const char *directory)
{
  return (sdr_moment){.system = built->system,
                      .scene = built->scene,
                      .directory = directory,
                      .step_size = built->step,
                      .end = built->scene->time.end,
                      .steps = built->steps};
}

static void add(sdr_watchers *w, sdr_observer *observer)
{
  if (observer) w->list[w->count++] = observer;
}

sdr_status sdr_watchers_create(sdr_built *built, sdr_moment *moment, int progress,
                               sdr_watchers *out)
{
  sdr_watchers *w = out;
  const sdr_scene *scene = built->scene;
  *w = (sdr_watchers){0};
  SDR_TRY(sdr_ledger_create(scene, built->points, &w->ledger));
  add(w, w->ledger);
  SDR_TRY(sdr_runaway_create(w->ledger, &w->runaway));
  add(w, w->runaway);
  if (scene->damage.law != SDR_LAW_NONE)
    SDR_TRY(sdr_onset_create(built->points, built->onset, &w->onset));
  add(w, w->onset);
  if (scene->output.measure_count > 0)
    SDR_TRY(sdr_measures_create(scene, built->points, w->ledger, built->steps, &w->measures));
  add(w, w->measures);
  if (scene->output.cracks.tip_count > 0)
    SDR_TRY(sdr_crack_tips_create(scene, built->points, built->plane_cut, &w->cracks));
  add(w, w->cracks);
  SDR_TRY(sdr_snapshots_create(scene, moment->directory, built->points, &w->snapshots));
  add(w, w->snapshots);
  if (progress) SDR_TRY(sdr_progress_create(w->ledger, &w->progress));
  add(w, w->progress);
  if (scene->points.adapt) /* the last: what it changes is for the next step */
    SDR_TRY(sdr_adapt_create(built, moment, w->list, &w->count, &w->adapt));
  add(w, w->adapt);
  return SDR_OK;
}

void sdr_watchers_destroy(sdr_watchers *w)
{
  sdr_observer *const all[SDR_WATCHERS] = {w->progress, w->snapshots, w->adapt,   w->cracks,
                                           w->measures, w->onset,     w->runaway, w->ledger};
  for (int k = 0; k < SDR_WATCHERS; ++k)
    if (all[k]) all[k]->ops->destroy(all[k]);
  *w = (sdr_watchers){0};
}
