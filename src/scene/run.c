#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- time ------------------------------------------------------------------------------------ */

/* Steps of an explicit scheme. */
static void read_steps(sdr_reading *rd, sdr_node *map)
{
  sdr_reader *r = rd->reader;
  sdr_time_scene *time = &rd->scene->time;
  sdr_read_number_or(r, map, "step", "auto", NAN, SDR_ABOVE_ZERO(SDR_TIME), "auto", &time->step);
  sdr_read_number(r, map, "safety", (sdr_quantity){SDR_PLAIN, 0, 1, 1, 0}, "0.9", &time->safety);
  sdr_read_number(r, map, "end", SDR_ABOVE_ZERO(SDR_TIME), NULL, &time->end);
  sdr_read_flag(r, map, "allow_unstable", "false", &time->allow_unstable);
  sdr_allow_adaptive(rd, map);
}

/* Explicit kernels only have a mixed form. */
static void check_precision(sdr_reading *rd)
{
  const sdr_node *node = sdr_node_find(rd->root, "precision");
  const char *integrator = rd->scene->time.integrator;
  if (!rd->scene->mixed || strcmp(integrator, "leapfrog") == 0) return;
  sdr_read_error(rd->reader, node->origin,
                 "precision 'mixed' belongs to the integrator leapfrog; the integrator here is %s, "
                 "so take double",
                 integrator);
}

void sdr_read_time(sdr_reading *rd)
{
  static const char *const integrators[] = {"leapfrog", "static",          "cvode",
                                            "ida",      "energy_momentum", NULL};
  sdr_reader *r = rd->reader;
  sdr_time_scene *time = &rd->scene->time;
  int integrator = 0;
  time->step = NAN;
  sdr_node *map = sdr_read_map(r, rd->root, "time", NULL);
  if (!map) return;
  time->origin = map->key_origin;
  sdr_read_word(r, map, "integrator", integrators, NULL, "leapfrog", &integrator);
  snprintf(time->integrator, sizeof time->integrator, "%s", integrators[integrator]);
  check_precision(rd);
  sdr_check_masses(rd);
  const sdr_node *step = sdr_node_find(map, "step");
  time->step_origin = step ? step->origin : map->origin;
  if (strcmp(time->integrator, "static") == 0)
    sdr_read_static(rd, map);
  else if (strcmp(time->integrator, "leapfrog") == 0)
    read_steps(rd, map);
  else if (strcmp(time->integrator, "energy_momentum") == 0)
    sdr_read_energy_momentum(rd, map);
  else
    sdr_read_adaptive(rd, map);
  sdr_read_done(r, map);
}

/* ---- fields ---------------------------------------------------------------------------------- */

static const char *const fields[] = {
    "displacement", "velocity", "acceleration", "damage",  "energy_density",
    "dissipated",   "force",    "reaction",     "stress",  "strain",
    "dilatation",   "material", "horizon",      "spacing", "level",
    "fragment",     NULL};

enum { FIELD_SIZE = 24 };

static int is_in(char (*list)[FIELD_SIZE], int count, const char *name)
{
  for (int k = 0; k < count; ++k) {
    if (strcmp(list[k], name) == 0) return 1;
  }
  return 0;
}

static int read_fields(sdr_reading *rd, sdr_node *map, const char *fallback, int room,
                       char (*out)[FIELD_SIZE])
{
  int count = 0;
  sdr_node *list = sdr_read_list(rd->reader, map, "fields", fallback);
  if (!list) return 0;
  for (const sdr_node *child = list->first; child; child = child->next) {
    int index;
    if (!sdr_read_word_node(rd->reader, child, "field", fields, NULL, &index)) continue;
    if (is_in(out, count, fields[index])) {
      sdr_read_error(rd->reader, child->origin, "the field '%s' stands twice", fields[index]);
    } else if (count == room) {
      sdr_read_error(rd->reader, child->origin, "more than %d fields", room);
      return count;
    } else {
      snprintf(out[count++], FIELD_SIZE, "%s", fields[index]);
    }
  }
  return count;
}

/* ---- output ---------------------------------------------------------------------------------- */

/* About 200 rows over the run where the step is known, else left to the run. */
static void read_history(sdr_reading *rd, sdr_node *map)
{
  const sdr_time_scene *time = &rd->scene->time;
  char fallback[32] = "auto";
  int64_t every = 0;
  sdr_node *history = sdr_read_map(rd->reader, map, "history", "{}");
  if (!history) return;
  if (time->step > 0 && time->end > 0) {
    const double rows = 200, steps = ceil(time->end / time->step - 1e-9);
    const double wanted = fmin(fmax(rint(steps / rows), 1), 1e9);
    snprintf(fallback, sizeof fallback, "%.0f", wanted);
  }
  const sdr_node *node = sdr_node_find(history, "every");
  if (node && node->kind == SDR_SCALAR && strcmp(node->text, "auto") == 0) {
    sdr_read_allow(rd->reader, history, "every");
  } else if (strcmp(fallback, "auto") == 0 && !node) {
    sdr_read_value(rd->reader, history, "every", fallback, "a whole number");
  } else {
    sdr_read_integer(rd->reader, history, "every", 1, 1000000000, fallback, &every);
  }
  rd->scene->output.history_every = (int)every;
  sdr_read_done(rd->reader, history);
}

static void read_checkpoint(sdr_reading *rd, sdr_node *map)
{
  sdr_node *checkpoint = sdr_read_map(rd->reader, map, "checkpoint", "{}");
  rd->scene->output.checkpoint_every = INFINITY;
  if (!checkpoint) return;
  sdr_read_number_or(rd->reader, checkpoint, "every", "never", INFINITY, SDR_ABOVE_ZERO(SDR_TIME),
                     "never", &rd->scene->output.checkpoint_every);
  sdr_read_done(rd->reader, checkpoint);
}

static void read_probe(sdr_reading *rd, sdr_node *item, int index)
{
  sdr_reader *r = rd->reader;
  sdr_probe *probe = &rd->scene->output.probe[index];
  char name[SDR_NAME_MAX];
  probe->origin = item->origin;
  if (!sdr_read_is(r, item, SDR_MAPPING, "a probe, {name: ..., at: [x, y], fields: [...]}")) return;
  snprintf(name, sizeof name, "probe%d", index);
  const int named = sdr_read_name(r, item, "name", name, probe->name);
  for (int k = 0; named && k < index; ++k) {
    if (strcmp(rd->scene->output.probe[k].name, probe->name) != 0) continue;
    sdr_read_error(r, sdr_node_find(item, "name")->origin,
                   "the probe '%s' stands twice; give each its own name", probe->name);
  }
  sdr_read_vector(r, item, "at", SDR_ANY_VALUE(SDR_LENGTH), NULL, probe->at);
  const int before = r->error_count;
  probe->field_count = read_fields(rd, item, "[displacement]", 8, probe->field);
  if (probe->field_count == 0 && r->error_count == before) {
    sdr_read_error(r, item->origin,
                   "the probe has no fields; give at least one, like "
                   "[displacement]");
  }
  sdr_read_done(r, item);
}

static void read_probes(sdr_reading *rd, sdr_node *map)
{
  sdr_output_scene *output = &rd->scene->output;
  sdr_node *list = sdr_read_list(rd->reader, map, "probes", "[]");
  if (!list || list->count == 0) return;
  output->probe = sdr_reading_room(rd, list, sizeof *output->probe);
  if (!output->probe) return;
  for (sdr_node *item = list->first; item; item = item->next) {
    read_probe(rd, item, output->probe_count++);
  }
}

static void read_fragments(sdr_reading *rd, sdr_node *map)
{
  sdr_output_scene *output = &rd->scene->output;
  const char *fallback = rd->scene->damage.law == SDR_LAW_NONE ? "false" : "true";
  sdr_node *node =
      sdr_read_value(rd->reader, map, "fragments", fallback, "true, false or {threshold: 0.5}");
  output->fragment_threshold = 0.5;
  if (!node) return;
  if (node->kind != SDR_MAPPING) {
    sdr_read_flag(rd->reader, map, "fragments", fallback, &output->fragments);
    return;
  }
  output->fragments = 1;
  sdr_read_number(rd->reader, node, "threshold", (sdr_quantity){SDR_PLAIN, 0, 1, 1, 0}, "0.5",
                  &output->fragment_threshold);
  sdr_read_done(rd->reader, node);
}

/* On its own for a body that is an annulus with a law of damage; about its centre. */
static void read_ring(sdr_reading *rd, sdr_node *map)
{
  sdr_output_scene *output = &rd->scene->output;
  const sdr_shape *body = rd->scene->points.shape;
  const int is_annulus = body && body->kind == SDR_ANNULUS;
  const char *fallback = is_annulus && rd->scene->damage.law != SDR_LAW_NONE ? "true" : "false";
  if (is_annulus) memcpy(output->ring_centre, body->centre, sizeof body->centre);
  sdr_node *node =
      sdr_read_value(rd->reader, map, "ring", fallback, "true, false or {centre: [0, 0]}");
  if (!node) return;
  if (node->kind == SDR_MAPPING) {
    output->ring = 1;
    sdr_read_vector(rd->reader, node, "centre", SDR_ANY_VALUE(SDR_LENGTH), NULL,
                    output->ring_centre);
    sdr_read_done(rd->reader, node);
  } else {
    sdr_read_flag(rd->reader, map, "ring", fallback, &output->ring);
    if (output->ring && body && !is_annulus) {
      sdr_read_error(rd->reader, node->origin,
                     "the body is no annulus; say where the ring's centre is: {centre: [0, 0]}");
    }
  }
  if (output->ring && sdr_components(rd->reader->dimension) != 2) {
    sdr_read_error(rd->reader, node->origin, "through-cracks of a ring are counted in 2-D only");
  }
}

void sdr_read_output(sdr_reading *rd)
{
  sdr_reader *r = rd->reader;
  sdr_output_scene *output = &rd->scene->output;
  char directory[2 * SDR_NAME_MAX + 8];
  int64_t snapshots = 0;
  sdr_node *map = sdr_read_map(r, rd->root, "output", "{}");
  if (!map) return;
  snprintf(directory, sizeof directory, "out/%s%s%s", rd->scene->name,
           rd->scene->variant[0] ? "-" : "", rd->scene->variant);
  sdr_read_text(r, map, "directory", directory, output->directory, sizeof output->directory);
  if (sdr_read_integer(r, map, "snapshots", 0, 10000, "20", &snapshots)) {
    output->snapshots = (int)snapshots;
  }
  output->field_count = read_fields(rd, map, "[displacement, damage]", 24, output->field);
  read_history(rd, map);
  read_checkpoint(rd, map);
  read_probes(rd, map);
  sdr_read_measures(rd, map);
  sdr_read_crack_tips(rd, map);
  read_fragments(rd, map);
  read_ring(rd, map);
  sdr_read_done(r, map);
}

/* ---- figures --------------------------------------------------------------------------------- */

static int read_bound(sdr_reading *rd, sdr_node *map, const char *key, double *out)
{
  const sdr_node *node = sdr_node_find(map, key);
  *out = NAN;
  sdr_read_allow(rd->reader, map, key);
  if (!node || sdr_node_is_null(node)) return 0; /* null: none, as in summary.json */
  return sdr_read_number(rd->reader, map, key, SDR_ANY_VALUE(SDR_ANY_UNIT), SDR_OPTIONAL, out);
}

static void read_figure(sdr_reading *rd, sdr_node *map, sdr_figure *figure)
{
  sdr_reader *r = rd->reader;
  figure->origin = map->key_origin;
  if (!sdr_read_is_name(r, map->key, map->key_origin, "a figure")) return;
  snprintf(figure->name, sizeof figure->name, "%s", map->key);
  if (!sdr_read_is(r, map, SDR_MAPPING, "{low: ..., high: ..., paper: ...}")) return;
  read_bound(rd, map, "low", &figure->low);
  read_bound(rd, map, "high", &figure->high);
  read_bound(rd, map, "paper", &figure->paper);
  if (figure->low > figure->high) {
    sdr_read_error(r, sdr_node_find(map, "high")->origin, "'high' must not be below 'low'");
  }
  sdr_read_done(r, map);
}

void sdr_read_figures(sdr_reading *rd)
{
  sdr_node *map = sdr_read_map(rd->reader, rd->root, "figures", "{}");
  if (!map || map->count == 0) return;
  rd->scene->figure = sdr_reading_room(rd, map, sizeof *rd->scene->figure);
  if (!rd->scene->figure) return;
  for (sdr_node *child = map->first; child; child = child->next) {
    if (sdr_node_is_null(child)) continue; /* a variant may drop one */
    read_figure(rd, child, &rd->scene->figure[rd->scene->figure_count++]);
  }
}
