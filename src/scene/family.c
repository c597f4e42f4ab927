#include "scene/import.h"
#include "scene/sections.h"

#include <math.h>
#include <string.h>

static void read_horizon(sdr_reading *rd)
{
  sdr_scene *scene = rd->scene;
  if (scene->points.imported && scene->points.imported->horizon) {
    const sdr_node *given = sdr_node_find(rd->root, "horizon");
    if (given)
      sdr_read_error(rd->reader, given->key_origin,
                     "the imported file has a column 'horizon'; remove this key, or name the "
                     "column in points.import.ignore");
    scene->horizon_origin = scene->points.origin;
    return;
  }
  sdr_node *node = sdr_read_value(rd->reader, rd->root, "horizon", "3.015 spacing",
                                  "a length, like 3 mm or 3.015 spacing");
  if (!node) return;
  scene->horizon_origin = node->origin;
  if (!sdr_read_relative_node(rd->reader, node, SDR_LENGTH, "spacing", SDR_USES_SPACE,
                              &scene->horizon_relative, &scene->horizon) ||
      sdr_expression_uses(scene->horizon)) {
    return;
  }
  double value;
  sdr_expression_value(scene->horizon, (double[3]){0, 0, 0}, 0, &value);
  if (!(value > 0)) {
    sdr_read_error(rd->reader, node->origin, "horizon = %s is out of range; allowed: above 0 m",
                   node->text);
  }
}

/* ---- weight: one word or a list of factors --------------------------------------------------- */

/* The words and what they set; the first six in the order of sdr_weight_function. */
static const char *const weights[] = {
    "constant",       "inverse", "inverse_square", "linear",          "cubic", "gaussian",
    "partial_volume", "iso",     "surface_iso",    "madenci_oterkus", NULL};
enum { FUNCTIONS = 6, PARTIAL_VOLUME = 6 };

/* What has been named so far: its word, NULL for none. */
typedef struct {
  const char *function, *partial_volume, *correction;
} named;

static void take_word(sdr_reading *rd, const sdr_node *node, named *before)
{
  sdr_weight *weight = &rd->scene->weight;
  int word = 0;
  if (!sdr_read_word_node(rd->reader, node, "weight", weights, NULL, &word)) return;
  const char **slot = word < FUNCTIONS         ? &before->function
                      : word == PARTIAL_VOLUME ? &before->partial_volume
                                               : &before->correction;
  if (*slot && strcmp(*slot, weights[word]) == 0) {
    sdr_read_error(rd->reader, node->origin, "the weight '%s' stands twice; name it once", *slot);
  } else if (*slot) {
    sdr_read_error(rd->reader, node->origin, "the weights '%s' and '%s' together; give one %s",
                   *slot, weights[word], word < FUNCTIONS ? "influence function" : "correction");
  }
  *slot = weights[word];
  if (word < FUNCTIONS) {
    weight->function = (sdr_weight_function)word;
  } else if (word == PARTIAL_VOLUME) {
    weight->partial_volume = 1;
  } else {
    weight->correction = (sdr_weight_correction)(word - PARTIAL_VOLUME);
  }
}

static void read_weight(sdr_reading *rd, sdr_node *map)
{
  sdr_reader *r = rd->reader;
  named before = {NULL, NULL, NULL};
  sdr_node *node = sdr_read_value(r, map, "weight", "constant", "a word or a list of words");
  if (!node) return;
  if (node->kind != SDR_SEQUENCE) {
    take_word(rd, node, &before);
    return;
  }
  if (node->count == 0) {
    sdr_read_error(r, node->origin, "family.weight is an empty list; give at least one word");
  }
  for (const sdr_node *word = node->first; word; word = word->next) take_word(rd, word, &before);
}

static void read_calibration(sdr_reading *rd, sdr_node *map)
{
  static const char *const calibrations[] = {"family", "printed", NULL};
  sdr_reader *r = rd->reader;
  const sdr_scene *scene = rd->scene;
  int calibration = 0;
  if (!sdr_read_word(r, map, "calibration", calibrations, NULL, "family", &calibration)) return;
  rd->scene->calibration = (sdr_calibration_kind)calibration;
  const sdr_node *node = sdr_node_find(map, "calibration");
  if (calibration == SDR_CALIBRATE_FAMILY) return;
  if (scene->model != SDR_BOND_BASED) {
    sdr_read_error(r, node->origin,
                   "calibration 'printed' belongs to the model bond_based; the model here is %s",
                   sdr_model_words[scene->model]);
  } else if (scene->weight.function != SDR_WEIGHT_CONSTANT) {
    sdr_read_error(r, node->origin,
                   "calibration 'printed' is for the weight constant; with '%s' leave it at family",
                   weights[scene->weight.function]);
  }
}

void sdr_read_family(sdr_reading *rd)
{
  static const char *const words[] = {"false", "true", "auto", NULL};
  int dual = 1, balance = 0;
  read_horizon(rd);
  sdr_node *map = sdr_read_map(rd->reader, rd->root, "family", "{}");
  if (!map) return;
  read_weight(rd, map);
  read_calibration(rd, map);
  sdr_read_flag(rd->reader, map, "dual", "true", &dual);
  if (sdr_read_word(rd->reader, map, "balance", words, NULL, "auto", &balance))
    rd->scene->balance = (sdr_border)balance;
  rd->scene->one_sided = !dual;
  sdr_read_done(rd->reader, map);
}
