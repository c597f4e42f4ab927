#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { ANYWHERE_ANYTIME = SDR_USES_SPACE | SDR_USES_TIME };

static void read_schedule(sdr_reading *rd, sdr_node *map, sdr_schedule *schedule)
{
  sdr_reader *r = rd->reader;
  *schedule = (sdr_schedule){-INFINITY, INFINITY, 0};
  const sdr_quantity time = SDR_ANY_VALUE(SDR_TIME);
  int good = sdr_read_number_or(r, map, "from", "start", -INFINITY, time, "start", &schedule->from);
  good =
      sdr_read_number_or(r, map, "until", "end", INFINITY, time, "end", &schedule->until) && good;
  sdr_read_number(r, map, "ramp", SDR_FROM_ZERO(SDR_TIME), "0 s", &schedule->ramp);
  if (good && !(schedule->from < schedule->until)) {
    sdr_read_error(r, sdr_node_find(map, "until")->origin, "'until' must be later than 'from'");
  }
  if (good && schedule->until < 0) {
    sdr_read_error(r, sdr_node_find(map, "until")->origin,
                   "'until' lies before the run, which begins at t = 0, so this would never act");
  }
  if (schedule->ramp > 0 && isinf(schedule->from)) schedule->from = 0; /* a ramp has a beginning */
}

/* Layers follow the points of the body from the start to the end. */
static void check_layer_schedule(sdr_reading *rd, sdr_node *map, const sdr_schedule *schedule)
{
  const char *key = isfinite(schedule->until) ? "until" : "from";
  if (schedule->ramp > 0 && !isfinite(schedule->until) && schedule->from == 0) return;
  if (!isfinite(schedule->from) && !isfinite(schedule->until)) return;
  sdr_read_error(rd->reader, sdr_node_find(map, key)->key_origin,
                 "'%s' does not go with a layer, which acts all the time; leave it out (a formula "
                 "of t and 'ramp' are possible)",
                 key);
}

/* ---- loads ----------------------------------------------------------------------------------- */

static const struct {
  const char *word;
  sdr_load_kind kind;
  sdr_unit unit;
} load_kinds[] = {
    {"pressure", SDR_PRESSURE, {-1, 1, -2, 0}},
    {"traction", SDR_TRACTION, {-1, 1, -2, 0}},
    {"body", SDR_BODY_FORCE, {-2, 1, -2, 0}},
    {"point", SDR_POINT_FORCE, {1, 1, -2, 0}},
};
enum { LOAD_KINDS = sizeof load_kinds / sizeof *load_kinds };

/* 1 if the load acts through a layer; its face is there already. */
static int read_load_layer(sdr_reading *rd, sdr_node *map, sdr_load *load)
{
  static const char *const words[] = {"fictitious", NULL};
  int word;
  if (load->kind != SDR_TRACTION || !sdr_read_has(rd->reader, map, "layer")) return 0;
  if (!sdr_read_word(rd->reader, map, "layer", words, NULL, NULL, &word)) return 0;
  load->layer = SDR_TRACTION_LAYER;
  sdr_read_length(rd->reader, map, "depth", "horizon", SDR_ABOVE_ZERO(SDR_LENGTH), "2 horizon",
                  &load->depth);
  return 1;
}

static void read_load_place(sdr_reading *rd, sdr_node *map, sdr_load *load)
{
  if (load->kind == SDR_POINT_FORCE) {
    sdr_read_vector(rd->reader, map, "at", SDR_ANY_VALUE(SDR_LENGTH), NULL, load->at);
  } else if (load->kind == SDR_BODY_FORCE) {
    sdr_read_place(rd, map, "on", SDR_VOLUME_PLACE, "body", &load->on);
  } else {
    static const char *const words[] = {"nearest", "layer", NULL};
    sdr_read_place(rd, map, "on", SDR_FACE_PLACE, NULL, &load->on);
    if (read_load_layer(rd, map, load)) return;
    sdr_read_word(rd->reader, map, "spread", words, NULL, "nearest", &load->spread_layer);
  }
}

static void read_load_value(sdr_reading *rd, sdr_node *map, sdr_unit unit, sdr_load *load)
{
  if (load->kind == SDR_PRESSURE) {
    sdr_read_formula(rd->reader, map, "value", unit, ANYWHERE_ANYTIME, NULL, &load->value[0]);
    return;
  }
  sdr_node *node =
      sdr_read_value(rd->reader, map, "value", NULL, "components, as [x, y] or {x: ..., y: ...}");
  if (!node) return;
  const int before = rd->reader->error_count;
  const int given = sdr_read_components(rd->reader, node, unit, ANYWHERE_ANYTIME, load->value);
  if (given == 0 && rd->reader->error_count == before) {
    sdr_read_error(rd->reader, node->origin, "the load has no component; give at least one");
  }
}

static void read_load(sdr_reading *rd, sdr_node *item, sdr_load *load)
{
  sdr_reader *r = rd->reader;
  const char *what = "one load: {pressure | traction | body | point: {...}}";
  load->origin = item->origin;
  if (!sdr_read_is(r, item, SDR_MAPPING, what)) return;
  if (item->count != 1) {
    sdr_read_error(r, item->origin, "wanted %s; each load is its own list entry (- )", what);
    return;
  }
  for (int k = 0; k < LOAD_KINDS; ++k) {
    sdr_read_allow(r, item, load_kinds[k].word);
    if (strcmp(item->first->key, load_kinds[k].word) != 0) continue;
    sdr_node *map = sdr_read_map(r, item, load_kinds[k].word, NULL);
    if (!map) return;
    load->kind = load_kinds[k].kind;
    load->origin = map->key_origin;
    read_load_place(rd, map, load);
    read_load_value(rd, map, load_kinds[k].unit, load);
    read_schedule(rd, map, &load->schedule);
    if (load->layer) check_layer_schedule(rd, map, &load->schedule);
    sdr_read_done(r, map);
    return;
  }
  sdr_read_done(r, item);
}

void sdr_read_loads(sdr_reading *rd)
{
  sdr_node *list = sdr_read_list(rd->reader, rd->root, "loads", "[]");
  if (!list || list->count == 0) return;
  rd->scene->load = sdr_reading_room(rd, list, sizeof *rd->scene->load);
  if (!rd->scene->load) return;
  for (sdr_node *item = list->first; item; item = item->next) {
    read_load(rd, item, &rd->scene->load[rd->scene->load_count++]);
  }
}

/* ---- supports -------------------------------------------------------------------------------- */

static int read_prescribed(sdr_reading *rd, sdr_node *map, const char *key, sdr_unit unit,
                           sdr_support_kind kind, sdr_support_scene *support)
{
  sdr_expression *value[3] = {NULL, NULL, NULL};
  sdr_node *node =
      sdr_read_value(rd->reader, map, key, SDR_OPTIONAL, "components, as {x: ..., y: ...}");
  if (!node) return 0;
  const int given = sdr_read_components(rd->reader, node, unit, ANYWHERE_ANYTIME, value);
  for (int c = 0; c < 3; ++c) {
    if (!value[c]) continue;
    if (support->kind[c] != SDR_FREE) {
      sdr_read_error(rd->reader, node->origin,
                     "the component %c has both a displacement and a velocity; give one", "xyz"[c]);
    }
    support->kind[c] = kind;
    support->value[c] = value[c];
  }
  return given;
}

/* 1 if the support acts through a layer. */
static int read_support_layer(sdr_reading *rd, sdr_node *map, sdr_support_scene *support)
{
  static const char *const words[] = {"mirror", NULL};
  int word;
  if (!sdr_read_has(rd->reader, map, "layer")) return 0;
  if (!sdr_read_word(rd->reader, map, "layer", words, NULL, NULL, &word)) return 0;
  if (support->on.face[0] == '\0') {
    sdr_read_error(rd->reader, sdr_node_find(map, "layer")->key_origin,
                   "a mirror layer lies outside a face; '%s' is a volume", support->on.text);
  }
  support->layer = SDR_MIRROR_LAYER;
  sdr_read_length(rd->reader, map, "depth", "horizon", SDR_ABOVE_ZERO(SDR_LENGTH), "1 horizon",
                  &support->depth);
  return 1;
}

static void check_mirror(sdr_reading *rd, sdr_node *map, const sdr_support_scene *support)
{
  check_layer_schedule(rd, map, &support->schedule);
  for (int c = 0; c < 3; ++c) {
    if (support->kind[c] != SDR_PRESCRIBED_VELOCITY) continue;
    sdr_read_error(rd->reader, sdr_node_find(map, "velocity")->key_origin,
                   "a mirror layer holds a displacement; give it as a formula of t");
    return;
  }
}

static void read_depth(sdr_reading *rd, sdr_node *map, sdr_support_scene *support)
{
  support->depth = (sdr_length){1, 1};
  if (read_support_layer(rd, map, support)) return;
  if (support->on.face[0] != '\0') {
    sdr_read_length(rd->reader, map, "depth", "spacing", SDR_ABOVE_ZERO(SDR_LENGTH), "1 spacing",
                    &support->depth);
  } else if (sdr_read_has(rd->reader, map, "depth")) {
    sdr_read_error(rd->reader, sdr_node_find(map, "depth")->key_origin,
                   "'depth' belongs to a support on a face; '%s' is a volume", support->on.text);
  }
}

static void check_support_name(sdr_reading *rd, sdr_node *map, int index)
{
  const sdr_support_scene *support = rd->scene->support;
  for (int k = 0; k < index; ++k) {
    if (strcmp(support[k].name, support[index].name) != 0) continue;
    sdr_read_error(rd->reader, sdr_node_find(map, "name")->origin,
                   "the support '%s' stands twice; give each its own name", support[k].name);
    return;
  }
}

static void read_support(sdr_reading *rd, sdr_node *item, int index)
{
  sdr_reader *r = rd->reader;
  sdr_support_scene *support = &rd->scene->support[index];
  char name[SDR_NAME_MAX];
  support->origin = item->origin;
  if (!sdr_read_is(r, item, SDR_MAPPING, "a support, {on: ..., displacement: {...}}")) return;
  snprintf(name, sizeof name, "support%d", index);
  if (sdr_read_name(r, item, "name", name, support->name)) check_support_name(rd, item, index);
  if (sdr_read_place(rd, item, "on", SDR_ANY_PLACE, NULL, &support->on)) {
    read_depth(rd, item, support);
  } else {
    sdr_read_allow(r, item, "depth");
    sdr_read_allow(r, item, "layer");
  }
  const int before = r->error_count;
  int given =
      read_prescribed(rd, item, "displacement", SDR_LENGTH, SDR_PRESCRIBED_DISPLACEMENT, support);
  given += read_prescribed(rd, item, "velocity", (sdr_unit){1, 0, -1, 0}, SDR_PRESCRIBED_VELOCITY,
                           support);
  sdr_read_flag(r, item, "mean", SDR_OPTIONAL, &support->mean);
  if (support->mean && support->layer)
    sdr_read_error(r, sdr_node_find(item, "mean")->origin,
                   "a layer prescribes no mean; leave mean or layer out");
  read_schedule(rd, item, &support->schedule);
  if (support->layer) check_mirror(rd, item, support);
  sdr_read_done(r, item);
  if (given == 0 && r->error_count == before) /* an unknown key was likely meant for it */
    sdr_read_error(r, item->origin,
                   "the support prescribes nothing; give displacement or velocity, like "
                   "displacement: {x: 0}");
}

void sdr_read_supports(sdr_reading *rd)
{
  sdr_node *list = sdr_read_list(rd->reader, rd->root, "supports", "[]");
  if (!list || list->count == 0) return;
  rd->scene->support = sdr_reading_room(rd, list, sizeof *rd->scene->support);
  if (!rd->scene->support) return;
  for (sdr_node *item = list->first; item; item = item->next) {
    read_support(rd, item, rd->scene->support_count++);
  }
}

/* ---- initial values -------------------------------------------------------------------------- */

static void read_start_value(sdr_reading *rd, sdr_node *node, int is_velocity, sdr_initial *initial)
{
  const sdr_unit unit = {1, 0, (signed char)(is_velocity ? -1 : 0), 0};
  sdr_read_components(rd->reader, node, unit, SDR_USES_SPACE, initial->value);
}

static void read_start_item(sdr_reading *rd, sdr_node *item, int is_velocity, sdr_initial *initial)
{
  if (!sdr_read_is(rd->reader, item, SDR_MAPPING, "{on: PLACE, value: [x, y]}")) return;
  sdr_read_place(rd, item, "on", SDR_VOLUME_PLACE, "body", &initial->on);
  sdr_node *node = sdr_read_value(rd->reader, item, "value", NULL, "components, as [x, y]");
  if (node) read_start_value(rd, node, is_velocity, initial);
  sdr_read_done(rd->reader, item);
}

/* Components for the whole body ([x, y] or {x: ..}), or a list of {on, value}. */
static void read_start(sdr_reading *rd, sdr_node *node, int is_velocity)
{
  sdr_scene *scene = rd->scene;
  if (node->kind == SDR_SEQUENCE && node->first && node->first->kind == SDR_MAPPING) {
    for (sdr_node *item = node->first; item; item = item->next) {
      sdr_initial *initial = &scene->initial[scene->initial_count++];
      *initial = (sdr_initial){.velocity = is_velocity, .origin = item->origin};
      read_start_item(rd, item, is_velocity, initial);
    }
    return;
  }
  sdr_initial *initial = &scene->initial[scene->initial_count++];
  *initial = (sdr_initial){.velocity = is_velocity, .origin = node->origin};
  initial->on.origin = node->origin;
  snprintf(initial->on.text, sizeof initial->on.text, "body");
  read_start_value(rd, node, is_velocity, initial);
}

void sdr_read_initial(sdr_reading *rd)
{
  static const char *const keys[] = {"displacement", "velocity"};
  sdr_node *map = sdr_read_map(rd->reader, rd->root, "initial", "{}");
  sdr_node *node[2];
  size_t most = 0;
  if (!map) return;
  for (int k = 0; k < 2; ++k) {
    node[k] = sdr_read_value(rd->reader, map, keys[k], SDR_OPTIONAL, "components, as [x, y]");
    if (node[k]) most += (size_t)node[k]->count + 1;
  }
  sdr_read_done(rd->reader, map);
  if (most == 0) return;
  rd->scene->initial = sdr_store_alloc(rd->reader->store, most, sizeof *rd->scene->initial);
  if (!rd->scene->initial) {
    sdr_read_fatal(rd->reader, SDR_RUN_FAILED);
    return;
  }
  for (int k = 0; k < 2; ++k) {
    if (node[k]) read_start(rd, node[k], k);
  }
}
