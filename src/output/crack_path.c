#include "output/crack_path.h"

#include <math.h>

static double distance_between(const double a[3], const double b[3])
{
  double sum = 0.0;
  for (int c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sqrt(sum);
}

int32_t sdr_crack_run_up(const sdr_crack_node *path, int32_t count, double window)
{
  for (int32_t k = 0, first = 0; k < count; ++k) {
    if (path[k].time > path[first].time) first = k;
    if (first > 0 && path[k].distance - path[first].distance > window * (1.0 + 1e-9)) return first;
  }
  return count;
}

double sdr_crack_step_speed(const sdr_crack_node *path, int32_t count, int32_t k)
{
  int32_t before = k < count ? k - 1 : -1;
  if (k + 1 < count && !(path[k].time < path[k + 1].time)) return (double)NAN;
  while (before >= 0 && !(path[before].time < path[k].time)) --before;
  if (before < 0) return (double)NAN;
  return distance_between(path[k].x, path[before].x) / (path[k].time - path[before].time);
}

/* Distances are compared up to rounding. */
static int lies_within(double distance, double from, double to)
{
  const double slack = 1e-9 * (fabs(from) + fabs(distance));
  return distance >= from - slack && distance <= to + slack;
}

/* Whether times of the nodes from distance `from` to `to` tell how long the way took. */
static int is_timed(const sdr_crack_node *path, int32_t count, double from, double to)
{
  int different = 0;
  double latest = 0.0;
  for (int32_t k = 0; k < count && different < 3; ++k) {
    if (!lies_within(path[k].distance, from, to)) continue;
    different += different == 0 || path[k].time > latest;
    latest = path[k].time;
  }
  return different >= 3;
}

double sdr_crack_speed(const sdr_crack_node *path, int32_t count, double from, double to)
{
  double n = 0.0, mean_s = 0.0, mean_t = 0.0, ss = 0.0, st = 0.0;
  for (int32_t k = 0; k < count; ++k) {
    if (!lies_within(path[k].distance, from, to)) continue;
    n += 1.0;
    mean_s += path[k].distance;
    mean_t += path[k].time;
  }
  if (!is_timed(path, count, from, to)) return (double)NAN;
  mean_s /= n;
  mean_t /= n;
  for (int32_t k = 0; k < count; ++k) {
    if (!lies_within(path[k].distance, from, to)) continue;
    ss += (path[k].distance - mean_s) * (path[k].distance - mean_s);
    st += (path[k].distance - mean_s) * (path[k].time - mean_t);
  }
  return st > 0.0 ? ss / st : (double)NAN;
}

double sdr_crack_speed_at(const sdr_crack_node *path, int32_t count, int32_t k, double window)
{
  if (k >= count) return (double)NAN;
  const double end = path[count - 1].distance;
  double from = fmin(path[k].distance - 0.5 * window, end - window);
  from = fmax(from, path[0].distance);
  return sdr_crack_speed(path, count, from, from + window);
}

double sdr_crack_largest_speed(const sdr_crack_node *path, int32_t count, double from,
                               double window)
{
  double most = (double)NAN;
  for (int32_t k = 0; k < count; ++k) {
    const double begin = path[k].distance, end = begin + window;
    if (!lies_within(begin, from, HUGE_VAL) || !lies_within(end, 0.0, path[count - 1].distance))
      continue;
    most = fmax(most, sdr_crack_speed(path, count, begin, end)); /* the number, if one is NAN */
  }
  return most;
}

/* The first node that is as far; count: none. */
static int32_t node_at(const sdr_crack_node *path, int32_t count, double distance)
{
  int32_t k = 0;
  while (k < count && !lies_within(path[k].distance, distance, HUGE_VAL)) ++k;
  return k;
}

double sdr_crack_mean_speed(const sdr_crack_node *path, int32_t count, double from)
{
  const int32_t k = node_at(path, count, from), last = count - 1;
  if (k >= count || !is_timed(path, count, path[k].distance, path[last].distance))
    return (double)NAN;
  return (path[last].distance - path[k].distance) / (path[last].time - path[k].time);
}

double sdr_crack_time_at(const sdr_crack_node *path, int32_t count, double distance)
{
  const int32_t k = node_at(path, count, distance);
  return k < count ? path[k].time : (double)NAN;
}

double sdr_crack_angle(const sdr_crack_node *path, int32_t count, const double direction[3],
                       double from, double to)
{
  double n = 0.0, mean_s = 0.0, mean[3] = {0.0}, slope[3] = {0.0}, dot = 0.0, square = 0.0;
  for (int32_t k = 0; k < count; ++k) {
    if (!lies_within(path[k].distance, from, to)) continue;
    n += 1.0;
    mean_s += path[k].distance;
    for (int c = 0; c < 3; ++c) mean[c] += path[k].x[c];
  }
  for (int32_t k = 0; k < count; ++k)
    if (lies_within(path[k].distance, from, to))
      for (int c = 0; c < 3; ++c)
        slope[c] += (path[k].distance - mean_s / n) * (path[k].x[c] - mean[c] / n);
  for (int c = 0; c < 3; ++c) {
    dot += slope[c] * direction[c];
    square += slope[c] * slope[c];
  }
  if (!(square > 0.0)) return (double)NAN;
  return acos(fmin(fmax(dot / sqrt(square), -1.0), 1.0));
}

double sdr_rayleigh_speed(double young, double poisson, double density)
{
  const double shear = 0.5 * young / (1.0 + poisson);
  return sqrt(shear / density) * (0.87 + 1.12 * poisson) / (1.0 + poisson);
}
