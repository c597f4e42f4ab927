/* Prescribed means: sum over its points of u_k = N U(t). Free components all, each pulled with the
   same force p, which follows from the second derivative for points with mass and from the first
   for points of a resistance C without:

     p = (N U'' - sum g_k/m_k)/(sum 1/m_k)   or   p = (N U' - sum g_k/C_k)/(sum 1/C_k). */
#include "time/motion_internal.h"

#include "base/memory.h"
#include "geometry/text.h"

#include <math.h>

void sdr_motion_resist(sdr_motion *motion, const double *viscous)
{
  motion->viscous = viscous;
}

int sdr_motion_means(const sdr_motion *motion)
{
  return sdr_supports_means(motion->implicit->system->supports);
}

const int32_t *sdr_motion_mean(const sdr_motion *motion, int mean, int32_t *count)
{
  const int32_t first = motion->mean_first[mean], end = motion->mean_first[mean + 1];
  const int acts = end > first && !isnan(motion->position[motion->mean_entry[first]]);
  *count = acts ? end - first : 0;
  return motion->mean_place + first;
}

sdr_status sdr_motion_make_means(sdr_motion *motion)
{
  const sdr_supports *supports = motion->implicit->system->supports;
  const sdr_prescribed *list = sdr_supports_list(supports);
  const size_t held = (size_t)sdr_supports_count(supports);
  const int means = sdr_supports_means(supports);
  motion->mean_first = sdr_alloc((size_t)means + 1, sizeof *motion->mean_first);
  motion->mean_entry = sdr_alloc(held, sizeof *motion->mean_entry);
  motion->mean_place = sdr_alloc(held, sizeof *motion->mean_place);
  motion->mean_pull = sdr_alloc((size_t)means, sizeof *motion->mean_pull);
  if (!motion->mean_first || !motion->mean_entry || !motion->mean_place || !motion->mean_pull)
    return SDR_RUN_FAILED;
  int32_t at = 0;
  for (int mean = 0; mean < means; ++mean) {
    for (int32_t k = 0; k < (int32_t)held; ++k)
      if (list[k].mean == mean) motion->mean_entry[at++] = k;
    motion->mean_first[mean + 1] = at;
  }
  return SDR_OK;
}

/* Mass, or resistance, of entry k of the supports' list. */
static double inertia_of(const sdr_motion *m, int32_t k)
{
  const sdr_system *system = m->implicit->system;
  const sdr_prescribed *p = &sdr_supports_list(system->supports)[k];
  if (system->mass[p->point] > 0.0) return system->mass[p->point];
  return m->viscous ? m->viscous[p->point * system->components + p->component] : 0.0;
}

static sdr_status refuse(const sdr_motion *m, int32_t k)
{
  const sdr_system *system = m->implicit->system;
  const sdr_points *points = system->model->points;
  const sdr_prescribed *p = &sdr_supports_list(system->supports)[k];
  char text[SDR_PLACE_TEXT];
  double x[3] = {0.0};
  for (int a = 0; a < points->components; ++a) x[a] = points->x[a][p->point];
  return sdr_fail(SDR_BAD_INPUT,
                  "a support prescribes the mean over points of which that at %s has no mass; give "
                  "all of them one, or none and time.viscosity",
                  sdr_place_text(x, points->components, text));
}

sdr_status sdr_motion_number_means(sdr_motion *motion)
{
  const sdr_system *system = motion->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int mean = 0; mean < sdr_motion_means(motion); ++mean)
    for (int32_t n = motion->mean_first[mean]; n < motion->mean_first[mean + 1]; ++n) {
      const sdr_prescribed *p = &list[motion->mean_entry[n]];
      const sdr_prescribed *lead = &list[motion->mean_entry[motion->mean_first[mean]]];
      const int heavy = system->mass[p->point] > 0.0, leads = system->mass[lead->point] > 0.0;
      if (heavy != leads || !(inertia_of(motion, motion->mean_entry[n]) > 0.0))
        return refuse(motion, motion->mean_entry[heavy ? motion->mean_first[mean] : n]);
      motion->mean_place[n] = motion->place[p->point * system->components + p->component];
    }
  return SDR_OK;
}

void sdr_motion_shift_means(const sdr_motion *motion, const double *wanted, double *const from[3])
{
  const sdr_system *system = motion->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int mean = 0; mean < sdr_motion_means(motion); ++mean) {
    const int32_t first = motion->mean_first[mean], end = motion->mean_first[mean + 1];
    if (isnan(motion->position[motion->mean_entry[first]])) continue;
    const double shift = wanted[motion->mean_entry[first]] - sdr_system_mean(system, mean, from);
    for (int32_t n = first; n < end; ++n) {
      const sdr_prescribed *p = &list[motion->mean_entry[n]];
      from[p->component][p->point] += shift;
    }
  }
}

void sdr_motion_pull_means(sdr_motion *motion, double *g)
{
  sdr_system *system = motion->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  for (int mean = 0; mean < sdr_motion_means(motion); ++mean) {
    int32_t count;
    const int32_t *place = sdr_motion_mean(motion, mean, &count);
    const int32_t *entry = motion->mean_entry + motion->mean_first[mean];
    if (count == 0) continue;
    const int heavy = system->mass[list[entry[0]].point] > 0.0;
    double missing = count * (heavy ? motion->bend : motion->rate)[entry[0]], mobility = 0.0;
    for (int32_t n = 0; n < count; ++n) {
      const double inertia = inertia_of(motion, entry[n]);
      missing -= g[place[n]] / inertia;
      mobility += 1.0 / inertia;
    }
    motion->mean_pull[mean] = missing / mobility;
    for (int32_t n = 0; n < count; ++n) g[place[n]] += motion->mean_pull[mean];
  }
}
