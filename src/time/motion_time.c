/* Loads, supports and layers at any time of a stretch. */
#include "time/motion_internal.h"

#include <math.h>
#include <string.h>

static double inside(const sdr_motion *m, double t)
{
  return fmin(fmax(t, m->first), m->last);
}

/* Where prescribed components are at time t; velocities act from the system's time on. */
static sdr_status find_positions(sdr_motion *m, double t)
{
  static const double node[3] = {-0.7745966692414834, 0.0, 0.7745966692414834};
  static const double weight[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0}; /* Gauss */
  sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  const int32_t count = sdr_supports_count(system->supports);
  const double way = t - system->time;
  SDR_TRY(sdr_supports_values(system->supports, inside(m, t), m->position));
  if (!m->has_velocities) return SDR_OK;
  for (int32_t k = 0; k < count; ++k)
    if (list[k].is_velocity && !isnan(m->position[k])) m->position[k] = m->implicit->reached[k];
  for (int g = 0; g < 3; ++g) {
    const double then = system->time + 0.5 * way * (1.0 + node[g]);
    SDR_TRY(sdr_supports_values(system->supports, inside(m, then), m->sample[0]));
    for (int32_t k = 0; k < count; ++k)
      if (list[k].is_velocity && !isnan(m->position[k]))
        m->position[k] += weight[g] * way * m->sample[0][k];
  }
  return SDR_OK;
}

/* Weights of five values at -2h .. 2h for the first and second derivative, times h and h^2, of the
   polynomial through them at s h. */
static void difference_weights(double s, double first[SDR_MOTION_SAMPLES],
                               double second[SDR_MOTION_SAMPLES])
{
  static const double factorial[SDR_MOTION_SAMPLES] = {24.0, -6.0, 4.0, -6.0, 24.0};
  for (int k = 0; k < SDR_MOTION_SAMPLES; ++k) {
    double others[SDR_MOTION_SAMPLES - 1];
    int n = 0;
    for (int j = 0; j < SDR_MOTION_SAMPLES; ++j)
      if (j != k) others[n++] = s - (j - 2);
    first[k] = second[k] = 0.0;
    for (int a = 0; a < 4; ++a) {
      double product = 1.0;
      for (int b = 0; b < 4; ++b)
        if (b != a) product *= others[b];
      first[k] += product / factorial[k];
      for (int b = 0; b < 4; ++b) {
        double pair = 1.0;
        for (int c = 0; c < 4; ++c)
          if (c != a && c != b) pair *= others[c];
        if (b != a) second[k] += pair / factorial[k];
      }
    }
  }
}

/* Five times about t within the stretch, h apart; t is s h from the middle one. */
static double choose_times(const sdr_motion *m, double t, double time[SDR_MOTION_SAMPLES],
                           double *s)
{
  const double h =
      fmin(fmax(1e-4 * (m->last - m->first), 1e-8 * fabs(t)), 0.25 * (m->last - m->first));
  const double middle = fmin(fmax(t, m->first + 2.0 * h), m->last - 2.0 * h);
  for (int k = 0; k < SDR_MOTION_SAMPLES; ++k) time[k] = inside(m, middle + (k - 2) * h);
  *s = (t - middle) / h;
  return h;
}

static sdr_status find_support_rates(sdr_motion *m, double t)
{
  sdr_system *system = m->implicit->system;
  const sdr_prescribed *list = sdr_supports_list(system->supports);
  double time[SDR_MOTION_SAMPLES], first[SDR_MOTION_SAMPLES], second[SDR_MOTION_SAMPLES], s;
  const double h = choose_times(m, inside(m, t), time, &s);
  difference_weights(s, first, second);
  for (int n = 0; n < SDR_MOTION_SAMPLES; ++n)
    SDR_TRY(sdr_supports_values(system->supports, time[n], m->sample[n]));
  SDR_TRY(sdr_supports_values(system->supports, inside(m, t), m->rate));
  for (int32_t k = 0; k < sdr_supports_count(system->supports); ++k) {
    double slope = 0.0, bend = 0.0;
    /* differences from the value here: a constant has none at all */
    for (int n = 0; n < SDR_MOTION_SAMPLES; ++n) {
      slope += first[n] * (m->sample[n][k] - m->rate[k]) / h;
      bend += second[n] * (m->sample[n][k] - m->rate[k]) / (h * h);
    }
    m->bend[k] = list[k].is_velocity ? slope : bend;
    if (!list[k].is_velocity) m->rate[k] = slope;
  }
  return SDR_OK;
}

/* a' of layers, from where they stand at five times if the body rests. */
static sdr_status find_layer_rates(sdr_motion *m, double t)
{
  sdr_system *system = m->implicit->system;
  sdr_layers *layers = system->layers;
  const int components = system->components;
  const int32_t count = sdr_layers_count(layers), *points = sdr_layers_points(layers);
  double time[SDR_MOTION_SAMPLES], first[SDR_MOTION_SAMPLES], second[SDR_MOTION_SAMPLES], s;
  const double h = choose_times(m, inside(m, t), time, &s);
  difference_weights(s, first, second);
  memset(m->layer_rate, 0, (size_t)(count * components) * sizeof(double));
  for (int n = 0; n < SDR_MOTION_SAMPLES; ++n) {
    SDR_TRY(sdr_layers_values(layers, time[n]));
    sdr_layers_follow(layers, m->slack);
    for (int32_t k = 0; k < count; ++k)
      for (int a = 0; a < components; ++a)
        m->layer_rate[k * components + a] += first[n] * m->slack[a][points[k]] / h;
  }
  return sdr_layers_values(layers, inside(m, m->at));
}

sdr_status sdr_motion_find_rates(sdr_motion *m, double t)
{
  if (m->rates_at == t) return SDR_OK;
  sdr_system *system = m->implicit->system;
  m->rates_at = NAN;
  if (sdr_supports_count(system->supports) > 0) SDR_TRY(find_support_rates(m, t));
  if (system->layers) SDR_TRY(find_layer_rates(m, t));
  m->rates_at = t;
  return SDR_OK;
}

sdr_status sdr_motion_stand(sdr_motion *m, double t)
{
  sdr_system *system = m->implicit->system;
  if (m->at == t) return SDR_OK;
  m->at = NAN;
  SDR_TRY(sdr_loads_evaluate(system->loads, inside(m, t)));
  if (sdr_supports_count(system->supports) > 0) SDR_TRY(find_positions(m, t));
  if (system->layers) SDR_TRY(sdr_layers_values(system->layers, inside(m, t)));
  m->at = t;
  return SDR_OK;
}

int sdr_motion_prescribes(const sdr_motion *motion, int32_t k)
{
  return !isnan(motion->position[k]);
}

sdr_status sdr_motion_prescribed(sdr_motion *motion, double t, int32_t k, double *position,
                                 double *rate, double *bend)
{
  SDR_TRY(sdr_motion_stand(motion, t));
  SDR_TRY(sdr_motion_find_rates(motion, t));
  *position = motion->position[k];
  *rate = motion->rate[k];
  *bend = motion->bend[k];
  return SDR_OK;
}

uint64_t sdr_motion_flags(const sdr_motion *motion)
{
  sdr_model *model = motion->implicit->system->model;
  sdr_state_block blocks[SDR_STATE_BLOCKS];
  uint64_t sum = 14695981039346656037u; /* FNV-1a, by words */
  int count = 0;
  model->ops->state(model, blocks, &count);
  for (int b = 0; b < count; ++b) {
    if (!strstr(blocks[b].name, "flags")) continue;
    const uint32_t *word = blocks[b].data;
    for (size_t k = 0; k < blocks[b].bytes / sizeof *word; ++k)
      sum = (sum ^ word[k]) * 1099511628211u;
  }
  return sum;
}
