/* When a load or support acts, and how far it has set in. */
#ifndef SDR_MECHANICS_SCHEDULE_H
#define SDR_MECHANICS_SCHEDULE_H

#include "scene/scene.h"

#include <math.h>

#define SDR_TIME_SLACK 1e-12

/* Share of its full value, 0..1, that a load or support has at time t (s); NAN while it does not
   act. A ramp without `from` starts at t = 0. Times are compared to 1e-12 of their size, since t
   comes from steps. */
static inline double sdr_schedule_share(const sdr_schedule *schedule, double t)
{
  const double slack = SDR_TIME_SLACK * fabs(t);
  if (t < schedule->from - slack || t > schedule->until + slack) return (double)NAN;
  if (!(schedule->ramp > 0.0)) return 1.0;
  const double start = isfinite(schedule->from) ? schedule->from : 0.0;
  return fmin(1.0, fmax(0.0, (t - start) / schedule->ramp));
}

/* 1 if t has come to `until`, the last moment that still counts. */
static inline int sdr_schedule_over(const sdr_schedule *schedule, double t)
{
  return t >= schedule->until - SDR_TIME_SLACK * fabs(t);
}

/* The first kink after t; INFINITY: none. Kinks nearer than 1e-9 of t have passed. */
static inline double sdr_schedule_next(const sdr_schedule *schedule, double t)
{
  const double start = isfinite(schedule->from) ? schedule->from : 0.0;
  const double kinks[3] = {schedule->from, schedule->until, start + schedule->ramp};
  double next = (double)INFINITY;
  for (int k = 0; k < 3; ++k)
    if (kinks[k] > t + 1e-9 * fabs(t) && kinks[k] > 0.0) next = fmin(next, kinks[k]);
  return next;
}

#endif
