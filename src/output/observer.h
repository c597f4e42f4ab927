/* The interface of an observer: something that looks at a run as it goes and writes what it sees.
 */
#ifndef SDR_OUTPUT_OBSERVER_H
#define SDR_OUTPUT_OBSERVER_H

#include "mechanics/refine.h"
#include "mechanics/system.h"
#include "scene/scene.h"

#include <math.h>

/* A moment of a run, given to every observer. */
typedef struct {
  sdr_system *system;
  const sdr_scene *scene;
  const char *directory; /* of the run's output */
  double time, step_size, end;
  int64_t step, steps; /* accepted so far; expected in all, 0: the integrator chooses */
  int last;            /* 1 at the end of the run */
  const sdr_balance
      *balance; /* energies and momenta now; NULL unless some observer asked (wants) */
} sdr_moment;

/* Two times that differ by less are of the same step; chosen steps may be of any length. */
static inline double sdr_moment_slack(const sdr_moment *moment)
{
  return moment->steps > 0 ? 0.5 * moment->step_size : 1e-12 * moment->time;
}

/* The number of the first step that is not before `end`, with steps of length dt from the latest
   change of it. */
static inline int64_t sdr_steps_until(double end, const sdr_system *system, double dt)
{
  const double left = (end - system->time_since) / dt;
  return system->step_since + (int64_t)ceil(left * (1.0 - 1e-12));
}

typedef struct sdr_observer sdr_observer;

typedef struct {
  const char *name; /* unique; names the observer's group in a checkpoint */

  /* 1 if the observer wants to be shown this moment; called every step, must be cheap.
   *wants_balance is set to 1 if it needs energies. NULL: never. */
  int (*due)(const sdr_observer *observer, const sdr_moment *moment, int *wants_balance);

  /* Look. Called for step 0 too, if due. */
  sdr_status (*look)(sdr_observer *observer, const sdr_moment *moment);

  /* The run is over (moment->last = 1) : write what is left. NULL: nothing to do. */
  sdr_status (*finish)(sdr_observer *observer, const sdr_moment *moment);

  /* State that a checkpoint must hold so that a resumed run continues with the same bits; NULL:
     none. The blocks point into the observer; after they have been overwritten on resume,
     `resumed` is called (NULL: nothing to do): cut files back to moment->time and go on. */
  void (*state)(sdr_observer *observer, sdr_state_block *blocks, int *count);
  sdr_status (*resumed)(sdr_observer *observer, const sdr_moment *moment);

  /* Points have split: moment->system and its model are over the new points, those of before are
     gone. Points that the observer borrowed, indices and arrays over points must be made anew;
     `map` tells which became which. On resume from a run that had refined, called before its state
     is read (sizes must fit then) with a map from the first points. NULL: nothing depends on
     points. */
  sdr_status (*points_changed)(sdr_observer *observer, const sdr_moment *moment,
                               const sdr_point_map *map);

  void (*destroy)(sdr_observer *observer);
} sdr_observer_ops;

/* The head of every observer; concrete ones have it as their first member. */
struct sdr_observer {
  const sdr_observer_ops *ops;
};

#endif
