#include "mechanics/supports.h"

#include "base/memory.h"
#include "geometry/place.h"
#include "geometry/text.h"
#include "mechanics/schedule.h"

#include <stdlib.h>

struct sdr_supports {
  const sdr_scene *scene;
  const sdr_points *points;
  int32_t count, capacity;
  int means;
  sdr_prescribed *list;
  uint8_t *open; /* 1: another support takes over at `until`, which no longer counts */
  double *still; /* per entry: value of a formula of the place alone, before the ramp */
  double *once;  /* per support and component: value at the present time of one without place */
  double *share; /* per support: how far it has set in; NAN: not active */
};

static void place_of(const sdr_points *points, int32_t i, double x[3])
{
  for (int c = 0; c < 3; ++c) x[c] = c < points->components ? points->x[c][i] : 0.0;
}

static const sdr_support_scene *support_of(const sdr_supports *supports, int32_t entry)
{
  return &supports->scene->support[supports->list[entry].support];
}

static sdr_status add_entry(sdr_supports *supports, sdr_prescribed entry)
{
  if (supports->count == supports->capacity) {
    const int32_t capacity = supports->capacity ? 2 * supports->capacity : 256;
    sdr_prescribed *grown = sdr_realloc(supports->list, (size_t)capacity, sizeof *grown);
    if (!grown) return SDR_RUN_FAILED;
    supports->list = grown;
    supports->capacity = capacity;
  }
  supports->list[supports->count++] = entry;
  return SDR_OK;
}

static int uses_of(const sdr_support_scene *support, int c)
{
  return support->value[c] ? sdr_expression_uses(support->value[c]) : 0;
}

/* Number the means of a support, by component; -1: none. */
static sdr_status number_means(sdr_supports *supports, const sdr_support_scene *support,
                               int16_t mean[3])
{
  for (int c = 0; c < 3; ++c) {
    mean[c] = -1;
    if (!support->mean || c >= supports->points->components || support->kind[c] == SDR_FREE)
      continue;
    if (uses_of(support, c) & SDR_USES_SPACE)
      return sdr_fail(
          SDR_BAD_INPUT,
          "%s: support '%s' prescribes a mean, which has no place: let its %c component "
          "be a number or a formula of t",
          sdr_origin_text(support->origin), support->name, "xyz"[c]);
    mean[c] = (int16_t)supports->means++;
  }
  return SDR_OK;
}

static sdr_status add_support(sdr_supports *supports, int index)
{
  const sdr_support_scene *support = &supports->scene->support[index];
  const sdr_points *points = supports->points;
  int32_t met = 0;
  int16_t mean[3];
  if (support->layer) return SDR_OK; /* mechanics/layers.h */
  SDR_TRY(number_means(supports, support, mean));
  for (int32_t i = 0; i < points->count; ++i) {
    double x[3];
    if (!sdr_in_body(points, i)) continue;
    place_of(points, i, x);
    const double h = points->spacing[i];
    const double depth = support->depth.value * (support->depth.relative ? h : 1.0);
    if (!sdr_place_holds(supports->scene, &support->on, x, h, depth)) continue;
    ++met;
    for (int c = 0; c < points->components; ++c) {
      if (support->kind[c] == SDR_FREE) continue;
      const int8_t velocity = support->kind[c] == SDR_PRESCRIBED_VELOCITY;
      SDR_TRY(
          add_entry(supports, (sdr_prescribed){i, (int8_t)c, velocity, (int16_t)index, mean[c]}));
    }
  }
  if (met > 0) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: support '%s' meets no point: '%s' holds none; choose a place in the body%s",
                  sdr_origin_text(support->origin), support->name, support->on.text,
                  support->on.face[0] ? " or a larger depth" : "");
}

static int by_point(const void *a, const void *b)
{
  const sdr_prescribed *left = a, *right = b;
  if (left->point != right->point) return left->point < right->point ? -1 : 1;
  if (left->component != right->component) return left->component - right->component;
  return left->support - right->support;
}

static sdr_status refuse_overlap(const sdr_supports *supports, int32_t a, int32_t b)
{
  const sdr_support_scene *first = support_of(supports, a), *second = support_of(supports, b);
  char text[SDR_PLACE_TEXT];
  double x[3];
  place_of(supports->points, supports->list[a].point, x);
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: support '%s' prescribes the %c component of the point at %s, and so does "
                  "support '%s' (%s) at the same time; part their places or times",
                  sdr_origin_text(second->origin), second->name, "xyz"[supports->list[a].component],
                  sdr_place_text(x, supports->points->components, text), first -> name,
                  sdr_origin_text(first->origin));
}

/* Two entries for one component of a point: one may begin when the other ends. */
static sdr_status check_pair(sdr_supports *supports, int32_t a, int32_t b)
{
  const sdr_schedule *first = &support_of(supports, a)->schedule;
  const sdr_schedule *second = &support_of(supports, b)->schedule;
  const double from = fmax(first->from, second->from), until = fmin(first->until, second->until);
  if (from < until) return refuse_overlap(supports, a, b);
  if (from > until) return SDR_OK;
  if (first->from == second->from) return refuse_overlap(supports, a, b);
  supports->open[first->from < second->from ? a : b] = 1;
  return SDR_OK;
}

static sdr_status check_overlaps(sdr_supports *supports)
{
  const sdr_prescribed *list = supports->list;
  for (int32_t a = 0; a < supports->count; ++a) {
    for (int32_t b = a + 1; b < supports->count && list[b].point == list[a].point &&
                            list[b].component == list[a].component;
         ++b) {
      SDR_TRY(check_pair(supports, a, b));
    }
  }
  return SDR_OK;
}

static sdr_status evaluate(const sdr_support_scene *support, int c, const double x[3], double t,
                           double *value)
{
  *value = 0.0;
  if (!support->value[c] || sdr_expression_value(support->value[c], x, t, value) == SDR_OK) {
    return SDR_OK;
  }
  return sdr_fail(SDR_BAD_INPUT, "%s: support '%s', %c component: %s",
                  sdr_origin_text(support->origin), support->name, "xyz"[c], sdr_error_message());
}

static sdr_status evaluate_still(sdr_supports *supports)
{
  for (int32_t k = 0; k < supports->count; ++k) {
    const sdr_prescribed *entry = &supports->list[k];
    double x[3];
    if (uses_of(support_of(supports, k), entry->component) != SDR_USES_SPACE) continue;
    place_of(supports->points, entry->point, x);
    SDR_TRY(evaluate(support_of(supports, k), entry->component, x, 0.0, &supports->still[k]));
  }
  return SDR_OK;
}

static sdr_status finish_list(sdr_supports *supports)
{
  const size_t entries = (size_t)supports->count, total = (size_t)supports->scene->support_count;
  if (entries > 0) qsort(supports->list, entries, sizeof *supports->list, by_point);
  supports->open = sdr_alloc(entries, sizeof *supports->open);
  supports->still = sdr_alloc(entries, sizeof *supports->still);
  supports->once = sdr_alloc(3 * total, sizeof *supports->once);
  supports->share = sdr_alloc(total, sizeof *supports->share);
  if (!supports->open || !supports->still || !supports->once || !supports->share) {
    return SDR_RUN_FAILED;
  }
  SDR_TRY(check_overlaps(supports));
  return evaluate_still(supports);
}

sdr_status sdr_supports_create(const sdr_scene *scene, const sdr_points *points, sdr_supports **out)
{
  sdr_supports *supports = sdr_alloc(1, sizeof *supports);
  if (!supports) return SDR_RUN_FAILED;
  supports->scene = scene;
  supports->points = points;
  sdr_status status = SDR_OK;
  for (int k = 0; k < scene->support_count && status == SDR_OK; ++k) {
    status = add_support(supports, k);
  }
  if (status == SDR_OK) status = finish_list(supports);
  if (status == SDR_OK) {
    *out = supports;
  } else {
    sdr_supports_destroy(&supports);
  }
  return status;
}

void sdr_supports_destroy(sdr_supports **supports)
{
  if (!*supports) return;
  sdr_free((*supports)->list);
  sdr_free((*supports)->open);
  sdr_free((*supports)->still);
  sdr_free((*supports)->once);
  sdr_free((*supports)->share);
  sdr_free(*supports);
  *supports = NULL;
}

int32_t sdr_supports_count(const sdr_supports *supports)
{
  return supports->count;
}

const sdr_prescribed *sdr_supports_list(const sdr_supports *supports)
{
  return supports->list;
}

int sdr_supports_means(const sdr_supports *supports)
{
  return supports->means;
}

static sdr_status bring_to_time(sdr_supports *supports, double t)
{
  static const double nowhere[3] = {0.0};
  for (int k = 0; k < supports->scene->support_count; ++k) {
    const sdr_support_scene *support = &supports->scene->support[k];
    supports->share[k] = sdr_schedule_share(&support->schedule, t);
    for (int c = 0; c < 3 && !isnan(supports->share[k]); ++c) {
      if (uses_of(support, c) & SDR_USES_SPACE) continue;
      SDR_TRY(evaluate(support, c, nowhere, t, &supports->once[3 * k + c]));
    }
  }
  return SDR_OK;
}

static sdr_status entry_value(const sdr_supports *supports, int32_t k, double t, double *value)
{
  const sdr_prescribed *entry = &supports->list[k];
  const sdr_support_scene *support = support_of(supports, k);
  const int uses = uses_of(support, entry->component);
  if (uses == (SDR_USES_SPACE | SDR_USES_TIME)) {
    double x[3];
    place_of(supports->points, entry->point, x);
    return evaluate(support, entry->component, x, t, value);
  }
  *value = uses & SDR_USES_SPACE ? supports->still[k]
                                 : supports->once[3 * entry->support + entry->component];
  return SDR_OK;
}

sdr_status sdr_supports_values(sdr_supports *supports, double t, double *values)
{
  SDR_TRY(bring_to_time(supports, t));
  for (int32_t k = 0; k < supports->count; ++k) {
    const double share = supports->share[supports->list[k].support];
    const int over = supports->open[k] && sdr_schedule_over(&support_of(supports, k)->schedule, t);
    values[k] = (double)NAN;
    if (isnan(share) || over) continue;
    SDR_TRY(entry_value(supports, k, t, &values[k]));
    values[k] *= share;
  }
  return SDR_OK;
}

double sdr_supports_next_event(const sdr_supports *supports, double t)
{
  double next = (double)INFINITY;
  for (int k = 0; k < supports->scene->support_count; ++k)
    next = fmin(next, sdr_schedule_next(&supports->scene->support[k].schedule, t));
  return next;
}
