#include "output/measures.h"

#include "base/memory.h"
#include "geometry/place.h"
#include "mechanics/system.h"
#include "output/ledger.h"

#include <math.h>
#include <string.h>

/* What one measure has summed up so far; a checkpoint holds it. */
typedef struct {
  int64_t instants;                        /* looked at */
  double weight, sum, low, high;           /* of the values; sum of volume times value */
  double error_square, exact_square, most; /* of value - exact */
} tally;

/* A measure and its points. */
typedef struct {
  const sdr_measurement *what;
  int32_t count; /* 0: a quantity of the body */
  int support;   /* whose reaction it is; -1: none's */
  int32_t *point;
} gauge;

typedef struct {
  sdr_observer head;
  const sdr_points *points;
  sdr_observer *ledger;
  int count;
  gauge *gauges;
  tally *tallies;
  double *field;           /* scratch: the widest field that is asked for as a whole; or NULL */
  const char *field_there; /* the one it holds at this moment */
} measures;

static measures *of(sdr_observer *observer)
{
  return (measures *)(void *)observer;
}

/* ---- when ------------------------------------------------------------------------------------ */

/* The present step is the one nearest to `at`; of steps chosen on the way the first that is not
   earlier. */
static int is_nearest(const sdr_moment *moment, double at)
{
  if (moment->steps == 0) return moment->time >= at * (1.0 - 1e-12) || moment->last;
  const double half = 0.5 * moment->step_size;
  if (moment->step == 0) return at <= half;
  const int reached = moment->time + half >= at * (1.0 - 1e-12);
  return reached && (moment->time - half < at * (1.0 - 1e-12) || moment->last);
}

static int is_due(const sdr_measurement *what, const tally *now, const sdr_moment *moment)
{
  if (what->over_time) {
    const double slack = 1e-6 * moment->step_size;
    return moment->time >= what->from - slack && moment->time <= what->until + slack &&
           moment->step % what->every == 0;
  }
  if (isinf(what->at.value)) return moment->last;
  if (now->instants > 0) return 0;
  if (what->at.relative) return moment->step == (int64_t)what->at.value;
  return is_nearest(moment, what->at.value);
}

static int due(const sdr_observer *observer, const sdr_moment *moment, int *wants_balance)
{
  const measures *m = (const measures *)(const void *)observer;
  int any = 0;
  for (int k = 0; k < m->count; ++k) {
    if (!is_due(m->gauges[k].what, &m->tallies[k], moment)) continue;
    any = 1;
    if (m->gauges[k].what->quantity[0] && m->gauges[k].support < 0) *wants_balance = 1;
  }
  return any;
}

/* ---- exact values ---------------------------------------------------------------------------- */

static double table_key(const sdr_exact *exact, const double x[3], double t)
{
  if (exact->by == 't') return t;
  if (exact->by == 'r') return sqrt(x[0] * x[0] + x[1] * x[1]);
  return x[exact->by - 'x'];
}

/* How far a key may lie outside a table by rounding. */
static double slack_of(const sdr_exact *exact)
{
  return 1e-6 * (exact->key[exact->rows - 1] - exact->key[0]) / (exact->rows - 1);
}

static double table_value(const sdr_exact *exact, double key)
{
  int low = 0, high = exact->rows - 1;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    if (exact->key[middle] <= key)
      low = middle;
    else
      high = middle;
  }
  const double share = (key - exact->key[low]) / (exact->key[high] - exact->key[low]);
  return exact->value[low] + share * (exact->value[high] - exact->value[low]);
}

static sdr_status exact_value(const sdr_measurement *what, const double x[3], double t, double *out)
{
  const sdr_exact *exact = &what->exact;
  sdr_status status = SDR_OK;
  if (exact->rows > 0)
    *out = table_value(exact, table_key(exact, x, t));
  else if (exact->is_series)
    status = sdr_expression_sum(exact->formula, x, t, exact->first, exact->last, out);
  else
    status = sdr_expression_value(exact->formula, x, t, out);
  if (status != SDR_BAD_INPUT) return status;
  return sdr_fail(SDR_BAD_INPUT, "%s: measure %s: %s", sdr_origin_text(what->origin), what->name,
                  sdr_error_message());
}

/* ---- looking --------------------------------------------------------------------------------- */

static sdr_status add(tally *now, const sdr_measurement *what, const double x[3], double t,
                      double volume, double value)
{
  double exact = 0.0;
  if (what->exact.formula || what->exact.rows > 0) SDR_TRY(exact_value(what, x, t, &exact));
  const double error = value - exact;
  const int first = now->weight == 0.0;
  now->weight += volume;
  now->sum += what->kind == SDR_MEASURE_SUM ? value : volume * value;
  now->low = first ? value : fmin(now->low, value);
  now->high = first ? value : fmax(now->high, value);
  now->error_square += volume * error * error;
  now->exact_square += volume * exact * exact;
  now->most = fmax(now->most, fabs(error));
  return SDR_OK;
}

/* Component of the field at point i: by itself if that is cheap, else from the whole field. */
static sdr_status value_at(measures *m, const sdr_measurement *what, sdr_system *system, int32_t i,
                           double *out)
{
  double value[6] = {0.0};
  const int width = sdr_field_components(what->field, system->components);
  if (!sdr_system_point(system, what->field, i, value)) {
    if (!m->field_there || strcmp(m->field_there, what->field) != 0)
      SDR_TRY(sdr_system_field(system, what->field, m->field));
    m->field_there = what->field;
    for (int c = 0; c < width; ++c)
      value[c] = m->field[(size_t)c * (size_t)system->count + (size_t)i];
  }
  *out = value[0];
  if (what->component >= 0) *out = value[what->component];
  if (what->component < 0)
    *out = sqrt(value[0] * value[0] + value[1] * value[1] + value[2] * value[2]);
  return SDR_OK;
}

static sdr_status look_at_points(measures *m, int k, const sdr_moment *moment)
{
  const gauge *g = &m->gauges[k];
  for (int32_t p = 0; p < g->count; ++p) {
    const int32_t i = g->point[p];
    double x[3] = {0.0}, value = 0.0;
    for (int c = 0; c < m->points->components; ++c) x[c] = m->points->x[c][i];
    SDR_TRY(value_at(m, g->what, moment->system, i, &value));
    SDR_TRY(add(&m->tallies[k], g->what, x, moment->time, m->points->volume[i], value));
  }
  return SDR_OK;
}

static double quantity(const sdr_books *books, const char *name)
{
  const struct {
    const char *name;
    double value;
  } known[] = {{"kinetic", books->kinetic},
               {"stored", books->stored},
               {"dissipated", books->dissipated},
               {"viscous", books->viscous},
               {"refinement", books->refinement},
               {"contact", books->contact},
               {"external_work", books->external_work},
               {"imbalance", books->imbalance},
               {"imbalance_relative", books->imbalance_relative},
               {"momentum_linear", books->linear_residual},
               {"momentum_angular", books->angular_residual},
               {"max_damage", books->max_damage},
               {"broken_bonds", (double)books->broken}};
  for (size_t k = 0; k < sizeof known / sizeof *known; ++k)
    if (strcmp(known[k].name, name) == 0) return known[k].value;
  return (double)NAN;
}

static sdr_status look_at_body(measures *m, int k, const sdr_moment *moment)
{
  const double nowhere[3] = {0.0};
  const sdr_measurement *what = m->gauges[k].what;
  if (m->gauges[k].support >= 0) {
    const double reaction =
        sdr_system_reaction(moment->system, m->gauges[k].support, what->component);
    return add(&m->tallies[k], what, nowhere, moment->time, 1.0, reaction);
  }
  sdr_ledger_book(m->ledger, moment);
  const sdr_books books = sdr_ledger_books(m->ledger);
  return add(&m->tallies[k], what, nowhere, moment->time, 1.0, quantity(&books, what->quantity));
}

static sdr_status look(sdr_observer *observer, const sdr_moment *moment)
{
  measures *m = of(observer);
  m->field_there = NULL;
  for (int k = 0; k < m->count; ++k) {
    const sdr_measurement *what = m->gauges[k].what;
    if (!is_due(what, &m->tallies[k], moment)) continue;
    if (!what->over_time) m->tallies[k] = (tally){0}; /* what went on had another end before */
    SDR_TRY(what->quantity[0] ? look_at_body(m, k, moment) : look_at_points(m, k, moment));
    ++m->tallies[k].instants;
  }
  return SDR_OK;
}

static void state(sdr_observer *observer, sdr_state_block *blocks, int *count)
{
  measures *m = of(observer);
  blocks[0] = (sdr_state_block){"tallies", m->tallies, (size_t)m->count * sizeof *m->tallies};
  *count = 1;
}

static void destroy(sdr_observer *observer)
{
  measures *m = of(observer);
  for (int k = 0; m->gauges && k < m->count; ++k) sdr_free(m->gauges[k].point);
  sdr_free(m->gauges);
  sdr_free(m->tallies);
  sdr_free(m->field);
  sdr_free(m);
}

/* ---- set-up ---------------------------------------------------------------------------------- */

static void place_of(const sdr_points *points, int32_t i, double x[3])
{
  for (int c = 0; c < points->components; ++c) x[c] = points->x[c][i];
}

/* Points of fictitious layers are none of the body's. */
static int is_meant(const sdr_scene *scene, const sdr_points *points, const sdr_measurement *what,
                    int32_t i)
{
  double x[3] = {0.0};
  if (!sdr_in_body(points, i)) return 0;
  place_of(points, i, x);
  return sdr_place_holds(scene, &what->on, x, points->spacing[i], points->spacing[i]);
}

static sdr_status choose_places(const sdr_scene *scene, const sdr_points *points, gauge *g)
{
  for (int32_t i = 0; i < points->count; ++i) g->count += is_meant(scene, points, g->what, i);
  if (g->count == 0)
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: measure %s: '%s' meets no point; choose a place in the body",
                    sdr_origin_text(g->what->origin), g->what->name, g->what->on.text);
  g->point = sdr_alloc((size_t)g->count, sizeof *g->point);
  if (!g->point) return SDR_RUN_FAILED;
  for (int32_t i = 0, p = 0; i < points->count; ++i)
    if (is_meant(scene, points, g->what, i)) g->point[p++] = i;
  return SDR_OK;
}

static sdr_status choose_point(const sdr_points *points, gauge *g)
{
  double x[3] = {0.0}, square = 0.0;
  g->point = sdr_alloc(1, sizeof *g->point);
  if (!g->point) return SDR_RUN_FAILED;
  g->count = 1;
  g->point[0] = sdr_points_nearest(points, g->what->point);
  place_of(points, g->point[0], x);
  for (int c = 0; c < 3; ++c) square += (x[c] - g->what->point[c]) * (x[c] - g->what->point[c]);
  if (sqrt(square) <= points->horizon[g->point[0]]) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: measure %s: the point lies outside the body: the nearest one is %.4g mm "
                  "away, beyond its horizon of %.4g mm",
                  sdr_origin_text(g->what->origin), g->what->name, 1e3 * sqrt(square),
                  1e3 * points->horizon[g->point[0]]);
}

static sdr_status check_key(const sdr_measurement *what, double key)
{
  const sdr_exact *exact = &what->exact;
  const double slack = slack_of(exact), low = exact->key[0], high = exact->key[exact->rows - 1];
  if (key >= low - slack && key <= high + slack) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: measure %s: its table goes from %c = %g to %g and lacks %c = %g",
                  sdr_origin_text(what->origin), what->name, exact->by, low, high, exact->by, key);
}

/* Tables must reach over all that will be looked up. */
static sdr_status check_table(const sdr_scene *scene, const sdr_points *points, const gauge *g)
{
  const sdr_measurement *what = g->what;
  const double end = scene->time.end;
  if (what->exact.rows == 0) return SDR_OK;
  if (what->exact.by == 't' && what->over_time) {
    SDR_TRY(check_key(what, fmax(what->from, 0.0)));
    return check_key(what, fmin(what->until, end));
  }
  if (what->exact.by == 't')
    return what->at.relative ? SDR_OK : check_key(what, fmin(what->at.value, end));
  for (int32_t p = 0; p < g->count; ++p) {
    double x[3] = {0.0};
    place_of(points, g->point[p], x);
    SDR_TRY(check_key(what, table_key(&what->exact, x, 0.0)));
  }
  return SDR_OK;
}

static sdr_status choose_support(const sdr_scene *scene, gauge *g)
{
  const sdr_measurement *what = g->what;
  for (int k = 0; k < scene->support_count && g->support < 0; ++k)
    if (strcmp(scene->support[k].name, what->support) == 0) g->support = k;
  if (g->support < 0)
    return sdr_fail(SDR_BAD_INPUT, "%s: measure %s: no support has the name '%s'",
                    sdr_origin_text(what->origin), what->name, what->support);
  if (scene->support[g->support].kind[what->component] != SDR_FREE) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "%s: measure %s: the support '%s' leaves %c free",
                  sdr_origin_text(what->origin), what->name, what->support, "xyz"[what->component]);
}

static sdr_status set_gauge(const sdr_scene *scene, const sdr_points *points, int64_t steps,
                            gauge *g)
{
  const sdr_measurement *what = g->what;
  if (!what->over_time && what->at.relative && steps > 0 && what->at.value > (double)steps)
    return sdr_fail(SDR_BAD_INPUT, "%s: measure %s: the run has %lld steps, so none has number %g",
                    sdr_origin_text(what->origin), what->name, (long long)steps, what->at.value);
  g->support = -1;
  if (what->support[0]) SDR_TRY(choose_support(scene, g));
  if (!what->quantity[0])
    SDR_TRY(what->at_point ? choose_point(points, g) : choose_places(scene, points, g));
  return check_table(scene, points, g);
}

/* Room for the widest field. */
static sdr_status make_scratch(measures *m)
{
  size_t widest = 0;
  for (int k = 0; k < m->count; ++k) {
    const int width = sdr_field_components(m->gauges[k].what->field, m->points->components);
    if ((size_t)width > widest) widest = (size_t)width;
  }
  sdr_free(m->field);
  m->field = sdr_alloc(widest * (size_t)m->points->count, sizeof *m->field);
  return m->field ? SDR_OK : SDR_RUN_FAILED;
}

/* The points of each measure are chosen anew. */
static sdr_status points_changed(sdr_observer *observer, const sdr_moment *moment,
                                 const sdr_point_map *map)
{
  measures *m = of(observer);
  (void)map;
  m->points = moment->system->model->points;
  for (int k = 0; k < m->count; ++k) {
    gauge *g = &m->gauges[k];
    if (g->what->quantity[0]) continue;
    sdr_free(g->point);
    g->point = NULL;
    g->count = 0;
    SDR_TRY(g->what->at_point ? choose_point(m->points, g)
                              : choose_places(moment->scene, m->points, g));
  }
  return make_scratch(m);
}

static const sdr_observer_ops ops = {.name = "measures",
                                     .due = due,
                                     .look = look,
                                     .state = state,
                                     .points_changed = points_changed,
                                     .destroy = destroy};

static sdr_status make_room(const sdr_scene *scene, measures *m)
{
  const size_t room = (size_t)scene->output.measure_count;
  m->gauges = sdr_alloc(room, sizeof *m->gauges);
  m->tallies = sdr_alloc(room, sizeof *m->tallies);
  if (!m->gauges || !m->tallies) return SDR_RUN_FAILED;
  m->count = scene->output.measure_count;
  for (int k = 0; k < m->count; ++k) m->gauges[k].what = &scene->output.measure[k];
  return make_scratch(m);
}

sdr_status sdr_measures_create(const sdr_scene *scene, const sdr_points *points,
                               sdr_observer *ledger, int64_t steps, sdr_observer **out)
{
  measures *m = sdr_alloc(1, sizeof *m);
  if (!m) return SDR_RUN_FAILED;
  *m = (measures){.head.ops = &ops, .points = points, .ledger = ledger};
  sdr_status status = make_room(scene, m);
  for (int k = 0; status == SDR_OK && k < m->count; ++k)
    status = set_gauge(scene, points, steps, &m->gauges[k]);
  if (status == SDR_OK)
    *out = &m->head;
  else
    destroy(&m->head);
  return status;
}

/* ---- what came out --------------------------------------------------------------------------- */

double sdr_measures_value(const sdr_observer *observer, int k)
{
  const measures *m = (const measures *)(const void *)observer;
  const tally *t = &m->tallies[k];
  if (t->instants == 0) return (double)NAN;
  switch (m->gauges[k].what->kind) {
  case SDR_MEASURE_MEAN:
    return t->sum / t->weight;
  case SDR_MEASURE_VALUE: /* there is only one */
  case SDR_MEASURE_MIN:
    return t->low;
  case SDR_MEASURE_MAX:
    return t->high;
  case SDR_MEASURE_SUM:
    return t->sum;
  case SDR_MEASURE_L2_ERROR:
    return t->exact_square > 0.0 ? sqrt(t->error_square / t->exact_square) : (double)NAN;
  case SDR_MEASURE_MAX_ERROR:
    return t->most;
  }
  return (double)NAN;
}
