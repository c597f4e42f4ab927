#include "output/onset.h"

#include "base/memory.h"

#include <math.h>

/* What a checkpoint holds beside the first damage. */
typedef struct {
  double found;  /* s; NAN: not yet */
  double looked; /* s, latest look */
} progress;

typedef struct {
  sdr_observer head;
  int32_t count;
  double threshold;
  progress now;
  float *first;   /* damage of each point at t = 0 */
  double *damage; /* scratch */
} onset;

static const double interval = 0.5e-6; /* s */

/* Due if the next step would come too late. The balance knows the largest damage of a bond, for
   less than the field costs and often made anyway. */
static int due(const sdr_observer *observer, const sdr_moment *moment, int *wants_balance)
{
  const onset *o = (const onset *)(const void *)observer;
  if (!isnan(o->now.found)) return 0;
  if (moment->step == 0) return 1;
  const double late = moment->time + moment->step_size - o->now.looked;
  if (!moment->last && late <= interval * (1.0 + 1e-6)) return 0;
  *wants_balance = 1;
  return 1;
}

/* No point, whose damage is a mean over bonds, can have passed what no bond has. */
static int cannot_have_passed(const onset *o, const sdr_moment *moment)
{
  return moment->balance && moment->balance->model.max_damage < o->threshold;
}

static sdr_status look(sdr_observer *observer, const sdr_moment *moment)
{
  onset *o = (onset *)(void *)observer;
  if (moment->step > 0 && cannot_have_passed(o, moment)) {
    o->now.looked = moment->time;
    return SDR_OK;
  }
  SDR_TRY(sdr_system_field(moment->system, "damage", o->damage));
  o->now.looked = moment->time;
  if (moment->step == 0) {
    for (int32_t i = 0; i < o->count; ++i) o->first[i] = (float)o->damage[i];
    return SDR_OK;
  }
  double most = 0.0;
  for (int32_t i = 0; i < o->count; ++i)
    if (sdr_in_body(moment->system->model->points, i))
      most = fmax(most, o->damage[i] - (double)o->first[i]);
  if (most > o->threshold) o->now.found = moment->time;
  return SDR_OK;
}

static void state(sdr_observer *observer, sdr_state_block *blocks, int *count)
{
  onset *o = (onset *)(void *)observer;
  blocks[0] = (sdr_state_block){"found", &o->now, sizeof o->now};
  blocks[1] = (sdr_state_block){"first", o->first, (size_t)o->count * sizeof *o->first};
  *count = 2;
}

/* Children begin with the damage that their parent began with. */
static sdr_status points_changed(sdr_observer *observer, const sdr_moment *moment,
                                 const sdr_point_map *map)
{
  onset *o = (onset *)(void *)observer;
  (void)moment;
  float *first = sdr_alloc((size_t)map->now, sizeof *first);
  double *damage = sdr_alloc((size_t)map->now, sizeof *damage);
  if (!first || !damage) {
    sdr_free(first);
    sdr_free(damage);
    return SDR_RUN_FAILED;
  }
  for (int32_t i = 0; i < map->now; ++i) first[i] = o->first[map->parent[i]];
  sdr_free(o->first);
  sdr_free(o->damage);
  o->count = map->now;
  o->first = first;
  o->damage = damage;
  return SDR_OK;
}

static void destroy(sdr_observer *observer)
{
  onset *o = (onset *)(void *)observer;
  sdr_free(o->first);
  sdr_free(o->damage);
  sdr_free(o);
}

static const sdr_observer_ops ops = {.name = "onset",
                                     .due = due,
                                     .look = look,
                                     .state = state,
                                     .points_changed = points_changed,
                                     .destroy = destroy};

sdr_status sdr_onset_create(const sdr_points *points, double threshold, sdr_observer **out)
{
  onset *o = sdr_alloc(1, sizeof *o);
  if (!o) return SDR_RUN_FAILED;
  *o = (onset){.head.ops = &ops, .count = points->count, .threshold = threshold};
  o->now = (progress){.found = NAN};
  o->first = sdr_alloc((size_t)points->count, sizeof *o->first);
  o->damage = sdr_alloc((size_t)points->count, sizeof *o->damage);
  if (!o->first || !o->damage) {
    destroy(&o->head);
    return SDR_RUN_FAILED;
  }
  *out = &o->head;
  return SDR_OK;
}

double sdr_onset_time(const sdr_observer *observer)
{
  return ((const onset *)(const void *)observer)->now.found;
}
