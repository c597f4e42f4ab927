#include "scene/sections.h"
#include "scene/table.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- what can be measured -------------------------------------------------------------------- */

typedef enum { SCALAR, VECTOR, TENSOR } field_kind;

static const char *const field_names[] = {
    "displacement", "velocity",   "acceleration",   "force",      "reaction", "damage",  "stress",
    "strain",       "dilatation", "energy_density", "dissipated", "material", "horizon", "spacing",
    "level",        NULL};

/* Beside the names. */
static const struct {
  field_kind kind;
  sdr_unit unit;
} fields[] = {{VECTOR, {1, 0, 0, 0}},   {VECTOR, {1, 0, -1, 0}},  {VECTOR, {1, 0, -2, 0}},
              {VECTOR, {1, 1, -2, 0}},  {VECTOR, {1, 1, -2, 0}},  {SCALAR, {0, 0, 0, 0}},
              {TENSOR, {-1, 1, -2, 0}}, {TENSOR, {0, 0, 0, 0}},   {SCALAR, {0, 0, 0, 0}},
              {SCALAR, {-1, 1, -2, 0}}, {SCALAR, {-1, 1, -2, 0}}, {SCALAR, {0, 0, 0, 0}},
              {SCALAR, {1, 0, 0, 0}},   {SCALAR, {1, 0, 0, 0}},   {SCALAR, {0, 0, 0, 0}}};

/* Of the body as a whole, as in the ledger (output/ledger.h). */
static const char *const quantity_names[] = {
    "kinetic",         "stored",           "dissipated",
    "viscous",         "refinement",       "contact",
    "external_work",   "imbalance",        "imbalance_relative",
    "momentum_linear", "momentum_angular", "max_damage",
    "broken_bonds",    "reaction",         NULL};
enum { ENERGY_QUANTITIES = 8, REACTION = 13 }; /* energies come first; most others are numbers */

static const char *const kinds[] = {"value", "mean",     "min",       "max",
                                    "sum",   "l2_error", "max_error", NULL};

static int is_error_kind(sdr_measure_kind kind)
{
  return kind == SDR_MEASURE_L2_ERROR || kind == SDR_MEASURE_MAX_ERROR;
}

/* ---- components ------------------------------------------------------------------------------ */

static void read_component(sdr_reading *rd, sdr_node *item, field_kind kind, int *component)
{
  static const char *const vectors[3][5] = {
      {"x", "norm", NULL}, {"x", "y", "norm", NULL}, {"x", "y", "z", "norm", NULL}};
  static const char *const tensors[3][7] = {
      {"xx", NULL}, {"xx", "yy", "xy", NULL}, {"xx", "yy", "zz", "yz", "xz", "xy", NULL}};
  const int components = sdr_components(rd->reader->dimension);
  const char *const *words = kind == VECTOR ? vectors[components - 1] : tensors[components - 1];
  const char *fallback = components > 1 ? NULL : words[0];
  if (kind == SCALAR) {
    if (sdr_read_has(rd->reader, item, "component"))
      sdr_read_error(rd->reader, sdr_node_find(item, "component")->key_origin,
                     "this field has no components; leave 'component' out");
    return;
  }
  if (!sdr_read_word(rd->reader, item, "component", words, NULL, fallback, component)) return;
  if (kind == VECTOR && *component == components) *component = -1;
}

/* ---- exact values ---------------------------------------------------------------------------- */

/* The path of a table, from the scene's folder, for messages. The node then holds it in full, so
   that the copy of the scene in the run's directory finds it too. 0: error. */
static int find_table(sdr_reading *rd, sdr_node *node, char path[2 * PATH_MAX])
{
  char full[PATH_MAX];
  const char *scene = rd->scene->path, *slash = strrchr(scene, '/');
  if (!sdr_read_is(rd->reader, node, SDR_SCALAR, "a file of comma-separated values")) return 0;
  const int folder = slash && node->text[0] != '/' ? (int)(slash - scene) + 1 : 0;
  snprintf(path, 2 * PATH_MAX, "%.*s%s", folder, scene, node->text);
  if (!realpath(path, full)) {
    sdr_read_error(rd->reader, node->origin, "the table '%.300s' cannot be found", path);
    return 0;
  }
  node->text = sdr_store_copy(rd->reader->store, full, strlen(full));
  if (!node->text) sdr_read_fatal(rd->reader, SDR_RUN_FAILED);
  return node->text != NULL;
}

static void read_table(sdr_reading *rd, sdr_node *map, sdr_exact *exact)
{
  static const char *const keys[] = {"x", "y", "z", "r", "t", NULL};
  sdr_reader *r = rd->reader;
  char column[SDR_NAME_MAX], path[2 * PATH_MAX];
  int by;
  sdr_node *node = sdr_read_value(r, map, "table", NULL, "a file of comma-separated values");
  int good = node && find_table(rd, node, path);
  good = sdr_read_word(r, map, "by", keys, NULL, NULL, &by) && good;
  good = sdr_read_name(r, map, "column", NULL, column) && good;
  sdr_read_done(r, map);
  if (!good) return;
  exact->by = keys[by][0];
  const sdr_status status =
      sdr_table_read(r->store, path, keys[by], column, &exact->rows, &exact->key, &exact->value);
  if (status == SDR_BAD_INPUT)
    sdr_read_error(r, node->origin, "%s", sdr_error_message());
  else if (status != SDR_OK)
    sdr_read_fatal(r, status);
}

static void read_series(sdr_reading *rd, sdr_node *map, sdr_unit unit, int allowed,
                        sdr_exact *exact)
{
  sdr_reader *r = rd->reader;
  const int64_t most = 100000;
  exact->is_series = 1;
  sdr_read_formula(r, map, "series", unit, allowed | SDR_USES_INDEX, NULL, &exact->formula);
  sdr_read_integer(r, map, "from", -most, most, "0", &exact->first);
  if (sdr_read_integer(r, map, "to", -most, most, NULL, &exact->last) &&
      exact->last < exact->first) {
    sdr_read_error(r, sdr_node_find(map, "to")->origin, "'to' must not be below 'from'");
  }
  sdr_read_done(r, map);
}

static void read_exact(sdr_reading *rd, sdr_node *item, sdr_unit unit, int allowed,
                       sdr_measurement *m)
{
  const char *what = "a formula, {series: FORMULA of n, from: 0, to: 100} or {table: FILE, by: x, "
                     "column: NAME}";
  sdr_node *node =
      sdr_read_value(rd->reader, item, "exact", is_error_kind(m->kind) ? NULL : SDR_OPTIONAL, what);
  if (!node) return;
  if (!is_error_kind(m->kind)) {
    sdr_read_error(rd->reader, node->key_origin,
                   "'exact' belongs to l2_error and max_error; '%s' compares with nothing",
                   kinds[m->kind]);
  } else if (node->kind == SDR_SCALAR) {
    sdr_read_formula_node(rd->reader, node, unit, allowed, &m->exact.formula);
  } else if (node->kind == SDR_MAPPING && sdr_node_find(node, "series")) {
    read_series(rd, node, unit, allowed, &m->exact);
  } else if (node->kind == SDR_MAPPING && sdr_node_find(node, "table")) {
    read_table(rd, node, &m->exact);
  } else {
    sdr_read_error(rd->reader, node->origin, "wanted %s", what);
  }
}

/* ---- where and when -------------------------------------------------------------------------- */

static void read_where(sdr_reading *rd, sdr_node *item, sdr_measurement *m)
{
  sdr_reader *r = rd->reader;
  const sdr_node *on = sdr_node_find(item, "on");
  m->at_point = sdr_read_has(r, item, "point");
  if (m->at_point && on) {
    sdr_read_error(r, on->key_origin, "a measure has a 'point' or a place 'on', not both");
    sdr_read_allow(r, item, "on");
  } else if (m->at_point) {
    sdr_read_vector(r, item, "point", SDR_ANY_VALUE(SDR_LENGTH), NULL, m->point);
    if (m->kind == SDR_MEASURE_SUM)
      sdr_read_error(r, sdr_node_find(item, "point")->key_origin,
                     "a sum is over a place; give 'on', or the kind value");
  } else if (m->kind == SDR_MEASURE_VALUE) {
    sdr_read_error(
        r, item->origin,
        "a value is that of one point: give 'point', or one of the kinds mean, min, max, "
        "sum for a place");
    sdr_read_allow(r, item, "on");
  } else {
    sdr_read_place(rd, item, "on", SDR_ANY_PLACE, "body", &m->on);
  }
}

static void read_window(sdr_reading *rd, sdr_node *item, sdr_measurement *m)
{
  sdr_reader *r = rd->reader;
  const sdr_quantity time = SDR_ANY_VALUE(SDR_TIME);
  int good = sdr_read_number_or(r, item, "from", "start", -INFINITY, time, "start", &m->from);
  good = sdr_read_number_or(r, item, "until", "end", INFINITY, time, "end", &m->until) && good;
  sdr_read_integer(r, item, "every", 1, 1000000000, "1", &m->every);
  if (good && !(m->from < m->until))
    sdr_read_error(r, sdr_node_find(item, "until")->origin, "'until' must be later than 'from'");
  if (good && m->from > rd->scene->time.end)
    sdr_read_error(r, sdr_node_find(item, "from")->origin, "'from' lies after the end of the run");
  if (m->kind == SDR_MEASURE_VALUE || m->kind == SDR_MEASURE_SUM)
    sdr_read_error(r, item->origin,
                   "a %s is that of one instant: give 'at', or one of the kinds mean, min, max for "
                   "a time",
                   kinds[m->kind]);
}

static void read_instant(sdr_reading *rd, sdr_node *item, sdr_measurement *m)
{
  sdr_reader *r = rd->reader;
  const sdr_node *node = sdr_read_value(r, item, "at", "end", "a time, like 1 us, or 100 steps");
  m->at = (sdr_length){INFINITY, 0};
  if (!node || (node->kind == SDR_SCALAR && strcmp(node->text, "end") == 0)) return;
  if (!sdr_read_length(r, item, "at", "steps", SDR_FROM_ZERO(SDR_TIME), NULL, &m->at)) return;
  if (m->at.relative && m->at.value != rint(m->at.value))
    sdr_read_error(r, node->origin, "'%s': steps are whole", node->text);
  if (!m->at.relative && m->at.value > rd->scene->time.end * (1 + 1e-9))
    sdr_read_error(r, node->origin, "'%s' lies after the end of the run", node->text);
}

static void read_when(sdr_reading *rd, sdr_node *item, sdr_measurement *m)
{
  static const char *const window[] = {"from", "until", "every"};
  const sdr_node *at = sdr_node_find(item, "at");
  for (int k = 0; k < 3; ++k) {
    sdr_read_allow(rd->reader, item, window[k]);
    const sdr_node *node = sdr_node_find(item, window[k]);
    if (node && at)
      sdr_read_error(
          rd->reader, node->key_origin,
          "a measure is 'at' an instant or over a time, 'from', 'until' and 'every', not "
          "both");
    m->over_time |= node != NULL;
  }
  sdr_read_allow(rd->reader, item, "at");
  if (at && m->over_time) return;
  if (m->over_time)
    read_window(rd, item, m);
  else
    read_instant(rd, item, m);
}

/* ---- one measure ----------------------------------------------------------------------------- */

static void read_of_points(sdr_reading *rd, sdr_node *item, sdr_measurement *m)
{
  int field;
  if (!sdr_read_word(rd->reader, item, "field", field_names, NULL, NULL, &field)) return;
  snprintf(m->field, sizeof m->field, "%s", field_names[field]);
  read_component(rd, item, fields[field].kind, &m->component);
  read_where(rd, item, m);
  read_exact(rd, item, fields[field].unit, SDR_USES_SPACE | SDR_USES_TIME, m);
  read_when(rd, item, m);
  sdr_read_done(rd->reader, item);
}

/* Which support's reaction, N: its name is looked up when the body is built. */
static void read_support(sdr_reading *rd, sdr_node *item, sdr_measurement *m)
{
  const sdr_node *node = sdr_read_value(rd->reader, item, "support", NULL, "the name of a support");
  if (node && sdr_read_is_name(rd->reader, node->text, node->origin, "a support"))
    snprintf(m->support, sizeof m->support, "%s", node->text);
  read_component(rd, item, VECTOR, &m->component);
  if (m->component < 0)
    sdr_read_error(rd->reader, item->origin, "a reaction is measured by component: x, y or z");
}

static sdr_unit unit_of_quantity(int which)
{
  if (which == REACTION) return (sdr_unit){1, 1, -2, 0};
  return which < ENERGY_QUANTITIES ? (sdr_unit){2, 1, -2, 0} : SDR_PLAIN;
}

static void read_of_body(sdr_reading *rd, sdr_node *item, sdr_measurement *m)
{
  int which;
  const sdr_node *field = sdr_node_find(item, "field");
  sdr_read_allow(rd->reader, item, "field");
  if (field)
    sdr_read_error(rd->reader, field->key_origin,
                   "a measure has a 'field' of points or a 'quantity' of the body, not both");
  if (!sdr_read_word(rd->reader, item, "quantity", quantity_names, NULL, NULL, &which)) return;
  snprintf(m->quantity, sizeof m->quantity, "%s", quantity_names[which]);
  if (m->kind == SDR_MEASURE_SUM)
    sdr_read_error(rd->reader, item->origin, "a quantity of the body has no sum; take its value");
  if (which == REACTION) read_support(rd, item, m);
  read_exact(rd, item, unit_of_quantity(which), SDR_USES_TIME, m);
  if (m->exact.rows > 0 && m->exact.by != 't')
    sdr_read_error(rd->reader, item->origin, "a quantity of the body has no place: give by: t");
  read_when(rd, item, m);
  sdr_read_done(rd->reader, item);
}

static void read_measure(sdr_reading *rd, sdr_node *item, sdr_measurement *m)
{
  sdr_reader *r = rd->reader;
  int kind;
  m->origin = item->key_origin;
  if (!sdr_read_is_name(r, item->key, item->key_origin, "a measure")) return;
  snprintf(m->name, sizeof m->name, "%s", item->key);
  if (!sdr_read_is(r, item, SDR_MAPPING, "a measure, {kind: ..., field: ...}")) return;
  if (!sdr_read_word(r, item, "kind", kinds, NULL, NULL, &kind)) return;
  m->kind = (sdr_measure_kind)kind;
  if (sdr_read_has(r, item, "quantity"))
    read_of_body(rd, item, m);
  else
    read_of_points(rd, item, m);
}

void sdr_read_measures(sdr_reading *rd, sdr_node *map)
{
  sdr_output_scene *output = &rd->scene->output;
  sdr_node *all = sdr_read_map(rd->reader, map, "measures", "{}");
  if (!all || all->count == 0) return;
  output->measure = sdr_reading_room(rd, all, sizeof *output->measure);
  if (!output->measure) return;
  for (sdr_node *item = all->first; item; item = item->next) {
    if (sdr_node_is_null(item)) continue; /* a variant may drop one */
    read_measure(rd, item, &output->measure[output->measure_count++]);
  }
}
