#include "scene/sections.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { PRIMITIVES_MAX = 10000 };

enum { IN_1D = 1, IN_2D = 2, IN_3D = 4 };

static int dimension_bit(sdr_dimension dimension)
{
  return dimension == SDR_1D ? IN_1D : dimension == SDR_3D ? IN_3D : IN_2D;
}

static void need(sdr_reader *reader, const sdr_node *node, const char *what)
{
  char path[256];
  sdr_node_path(node, path, sizeof path);
  sdr_read_error(reader, node->origin, "%s: %s", path, what);
}

/* ---- primitives ------------------------------------------------------------------------------ */

static int read_corners(sdr_reading *rd, sdr_node *node, sdr_shape *shape)
{
  sdr_reader *r = rd->reader;
  if (sdr_read_has(r, node, "centre") || sdr_read_has(r, node, "size")) {
    double centre[3], size[3];
    int good = sdr_read_vector(r, node, "centre", SDR_ANY_VALUE(SDR_LENGTH), "[0]", centre);
    good = sdr_read_vector(r, node, "size", SDR_ABOVE_ZERO(SDR_LENGTH), NULL, size) && good;
    for (int c = 0; good && c < 3; ++c) {
      shape->low[c] = centre[c] - size[c] / 2;
      shape->high[c] = centre[c] + size[c] / 2;
    }
    return good;
  }
  const int good = sdr_read_vector(r, node, "from", SDR_ANY_VALUE(SDR_LENGTH), NULL, shape->low);
  return sdr_read_vector(r, node, "to", SDR_ANY_VALUE(SDR_LENGTH), NULL, shape->high) && good;
}

static int read_box(sdr_reading *rd, sdr_node *node, sdr_shape *shape)
{
  const int components = sdr_components(rd->reader->dimension);
  sdr_read_allow(rd->reader, node, "from");
  sdr_read_allow(rd->reader, node, "to");
  if (!read_corners(rd, node, shape)) return 0;
  if (components == 2 && !sdr_read_number(rd->reader, node, "angle", SDR_ANY_VALUE(SDR_PLAIN),
                                          "0 deg", &shape->angle)) {
    return 0;
  }
  for (int c = 0; c < components; ++c) {
    if (!(shape->low[c] < shape->high[c])) {
      need(rd->reader, node, "'from' must be below 'to' in every component");
      return 0;
    }
  }
  for (int c = 0; c < 3; ++c) shape->centre[c] = (shape->low[c] + shape->high[c]) / 2;
  return 1;
}

static int read_interval(sdr_reading *rd, sdr_node *node, sdr_shape *shape)
{
  sdr_reader *r = rd->reader;
  int good = sdr_read_number(r, node, "from", SDR_ANY_VALUE(SDR_LENGTH), NULL, &shape->low[0]);
  good = sdr_read_number(r, node, "to", SDR_ANY_VALUE(SDR_LENGTH), NULL, &shape->high[0]) && good;
  if (!good) return 0;
  if (!(shape->low[0] < shape->high[0])) {
    need(r, node, "'from' must be below 'to'");
    return 0;
  }
  shape->centre[0] = (shape->low[0] + shape->high[0]) / 2;
  return 1;
}

/* radius (a full body) or inner and outer. */
static int read_radii(sdr_reading *rd, sdr_node *node, int is_hollow, sdr_shape *shape)
{
  sdr_reader *r = rd->reader;
  if (!is_hollow) {
    return sdr_read_number(r, node, "radius", SDR_ABOVE_ZERO(SDR_LENGTH), NULL, &shape->outer);
  }
  const sdr_quantity inner =
      rd->reader->dimension == SDR_3D ? SDR_FROM_ZERO(SDR_LENGTH) : SDR_ABOVE_ZERO(SDR_LENGTH);
  const char *fallback = rd->reader->dimension == SDR_3D ? "0 m" : NULL;
  int good = sdr_read_number(r, node, "inner", inner, fallback, &shape->inner);
  good = sdr_read_number(r, node, "outer", SDR_ABOVE_ZERO(SDR_LENGTH), NULL, &shape->outer) && good;
  if (!good) return 0;
  if (shape->inner < shape->outer) return 1;
  need(r, node, "'inner' must be below 'outer'");
  return 0;
}

static int read_disc(sdr_reading *rd, sdr_node *node, sdr_shape *shape)
{
  const int good = read_radii(rd, node, 0, shape);
  return sdr_read_vector(rd->reader, node, "centre", SDR_ANY_VALUE(SDR_LENGTH), "[0]",
                         shape->centre) &&
         good;
}

static int read_ring(sdr_reading *rd, sdr_node *node, sdr_shape *shape)
{
  const int good = read_radii(rd, node, 1, shape);
  return sdr_read_vector(rd->reader, node, "centre", SDR_ANY_VALUE(SDR_LENGTH), "[0]",
                         shape->centre) &&
         good;
}

static int read_sphere(sdr_reading *rd, sdr_node *node, sdr_shape *shape)
{
  sdr_read_allow(rd->reader, node, "inner");
  sdr_read_allow(rd->reader, node, "outer");
  if (sdr_node_find(node, "radius")) return read_disc(rd, node, shape);
  return read_ring(rd, node, shape);
}

static int read_cylinder(sdr_reading *rd, sdr_node *node, sdr_shape *shape)
{
  sdr_reader *r = rd->reader;
  const int is_hollow = !sdr_read_has(r, node, "radius");
  double axis[3] = {0, 0, 0};
  int good = read_radii(rd, node, is_hollow, shape);
  good = sdr_read_number(r, node, "from", SDR_ANY_VALUE(SDR_LENGTH), NULL, &shape->low[2]) && good;
  good = sdr_read_number(r, node, "to", SDR_ANY_VALUE(SDR_LENGTH), NULL, &shape->high[2]) && good;
  good = sdr_read_vector(r, node, "centre", SDR_ANY_VALUE(SDR_LENGTH), "[0]", axis) && good;
  if (!good) return 0;
  if (!(shape->low[2] < shape->high[2])) {
    need(r, node, "'from' must be below 'to' (both along z)");
    return 0;
  }
  memcpy(shape->centre, axis, sizeof axis);
  return 1;
}

static int read_half_space(sdr_reading *rd, sdr_node *node, sdr_shape *shape)
{
  sdr_reader *r = rd->reader;
  int good = sdr_read_vector(r, node, "point", SDR_ANY_VALUE(SDR_LENGTH), NULL, shape->centre);
  good = sdr_read_vector(r, node, "normal", SDR_ANY_VALUE(SDR_PLAIN), NULL, shape->normal) && good;
  if (!good) return 0;
  const double length =
      sqrt(shape->normal[0] * shape->normal[0] + shape->normal[1] * shape->normal[1] +
           shape->normal[2] * shape->normal[2]);
  if (!(length > 0) || !isfinite(length)) {
    need(r, node, "the normal must have a length above 0");
    return 0;
  }
  for (int c = 0; c < 3; ++c) shape->normal[c] /= length;
  return 1;
}

static double polygon_area(const sdr_shape *shape)
{
  double twice = 0;
  for (int k = 0; k < shape->vertex_count; ++k) {
    const double *a = shape->vertices + 2 * k;
    const double *b = shape->vertices + 2 * ((k + 1) % shape->vertex_count);
    twice += a[0] * b[1] - a[1] * b[0];
  }
  return fabs(twice) / 2;
}

/* Written {polygon: [[x, y], ...]}. */
static int read_polygon(sdr_reading *rd, sdr_node *node, sdr_shape *shape)
{
  if (node->count < 3) {
    need(rd->reader, node, "a polygon has at least 3 vertices, [[x, y], ...]");
    return 0;
  }
  shape->vertices = sdr_reading_room(rd, node, 2 * sizeof(double));
  if (!shape->vertices) return 0;
  int good = 1;
  for (sdr_node *child = node->first; child; child = child->next) {
    double x[3] = {0, 0, 0};
    good = sdr_read_vector_node(rd->reader, child, SDR_ANY_VALUE(SDR_LENGTH), x) && good;
    memcpy(shape->vertices + 2 * shape->vertex_count++, x, 2 * sizeof *x);
  }
  if (good && !(polygon_area(shape) > 0)) {
    need(rd->reader, node, "the polygon has no area");
    return 0;
  }
  return good;
}

/* ---- combinations ---------------------------------------------------------------------------- */

static int read_parts(sdr_reading *rd, sdr_node *node, sdr_shape *shape)
{
  if (node->count == 0) {
    need(rd->reader, node, "an empty list; give shapes or regions, [SHAPE, ...]");
    return 0;
  }
  shape->parts = sdr_reading_room(rd, node, sizeof *shape->parts);
  if (!shape->parts) return 0;
  int good = 1;
  shape->primitive_count = 0;
  for (sdr_node *child = node->first; child; child = child->next) {
    const sdr_shape *part = sdr_read_shape(rd, child, NULL);
    if (!part) {
      good = 0;
      continue;
    }
    shape->parts[shape->part_count++] = *part;
    shape->primitive_count += part->primitive_count;
    if (shape->primitive_count > PRIMITIVES_MAX) {
      need(rd->reader, node, "a shape of more than 10000 parts");
      return 0;
    }
  }
  return good;
}

/* ---- the table ------------------------------------------------------------------------------- */

static const struct {
  const char *word;
  sdr_shape_kind kind;
  int dimensions;
  sdr_node_kind node;
  int (*read)(sdr_reading *, sdr_node *, sdr_shape *);
} kinds[] = {
    {"box", SDR_BOX, IN_1D | IN_2D | IN_3D, SDR_MAPPING, read_box},
    {"interval", SDR_BOX, IN_1D, SDR_MAPPING, read_interval},
    {"disc", SDR_DISC, IN_2D, SDR_MAPPING, read_disc},
    {"annulus", SDR_ANNULUS, IN_2D, SDR_MAPPING, read_ring},
    {"polygon", SDR_POLYGON, IN_2D, SDR_SEQUENCE, read_polygon},
    {"sphere", SDR_SPHERE, IN_3D, SDR_MAPPING, read_sphere},
    {"cylinder", SDR_CYLINDER, IN_3D, SDR_MAPPING, read_cylinder},
    {"half_space", SDR_HALF_SPACE, IN_1D | IN_2D | IN_3D, SDR_MAPPING, read_half_space},
    {"union", SDR_UNION, IN_1D | IN_2D | IN_3D, SDR_SEQUENCE, read_parts},
    {"intersection", SDR_INTERSECTION, IN_1D | IN_2D | IN_3D, SDR_SEQUENCE, read_parts},
    {"difference", SDR_DIFFERENCE, IN_1D | IN_2D | IN_3D, SDR_SEQUENCE, read_parts},
};
enum { KIND_COUNT = sizeof kinds / sizeof *kinds };

static int kind_index(const char *word)
{
  for (int k = 0; k < KIND_COUNT; ++k) {
    if (strcmp(word, kinds[k].word) == 0) return k;
  }
  return -1;
}

int sdr_is_shape_word(const char *word)
{
  return kind_index(word) >= 0;
}

/* Words of the shapes that exist in a dimension. */
static int kind_words(sdr_dimension dimension, const char *words[KIND_COUNT], char *list,
                      size_t size)
{
  int count = 0;
  size_t used = 0;
  for (int k = 0; k < KIND_COUNT; ++k) {
    if (!(kinds[k].dimensions & dimension_bit(dimension))) continue;
    if (used < size) {
      used += (size_t)snprintf(list + used, size - used, "%s%s", count ? ", " : "", kinds[k].word);
    }
    words[count++] = kinds[k].word;
  }
  return count;
}

static void unknown_shape(sdr_reading *rd, const sdr_node *entry, int is_shape)
{
  const char *words[KIND_COUNT];
  char list[200];
  const int count = kind_words(rd->reader->dimension, words, list, sizeof list);
  if (is_shape) {
    sdr_read_error(rd->reader, entry->key_origin,
                   "the shape '%s' does not exist in this dimension; shapes here: %s", entry->key,
                   list);
    return;
  }
  const char *nearest = sdr_read_nearest(entry->key, words, count);
  sdr_read_error(rd->reader, entry->key_origin, "unknown shape '%.60s'%s%s%s shapes here: %s",
                 entry->key, nearest ? "; did you mean '" : "", nearest ? nearest : "",
                 nearest ? "'?" : ";", list);
}

static sdr_shape *read_kind(sdr_reading *rd, sdr_node *entry)
{
  const int k = kind_index(entry->key);
  if (k < 0 || !(kinds[k].dimensions & dimension_bit(rd->reader->dimension))) {
    unknown_shape(rd, entry, k >= 0);
    return NULL;
  }
  if (sdr_node_is_null(entry)) {
    need(rd->reader, entry, "the shape has no measures; see docs/scene.md");
    return NULL;
  }
  if (!sdr_read_is(rd->reader, entry, kinds[k].node,
                   kinds[k].node == SDR_MAPPING ? "the shape's measures, {key: value, ...}"
                                                : "a list")) {
    return NULL;
  }
  sdr_shape *shape = sdr_store_alloc(rd->reader->store, 1, sizeof *shape);
  if (!shape) {
    sdr_read_fatal(rd->reader, SDR_RUN_FAILED);
    return NULL;
  }
  shape->kind = kinds[k].kind;
  shape->origin = entry->key_origin;
  shape->primitive_count = 1;
  const int good = kinds[k].read(rd, entry, shape);
  if (entry->kind == SDR_MAPPING) sdr_read_done(rd->reader, entry);
  return good ? shape : NULL;
}

sdr_shape *sdr_read_shape(sdr_reading *rd, sdr_node *node, const char *beside)
{
  if (node->kind == SDR_SCALAR && !sdr_node_is_null(node)) {
    return sdr_read_region(rd, node, node->text);
  }
  if (!sdr_read_is(rd->reader, node, SDR_MAPPING, "a shape, like {box: {...}}, or a region")) {
    return NULL;
  }
  sdr_node *entry = NULL;
  for (sdr_node *child = node->first; child; child = child->next) {
    if (beside && strcmp(child->key, beside) == 0) continue;
    if (entry) {
      sdr_read_error(rd->reader, child->key_origin,
                     "'%s' beside '%s': one shape is wanted; combine several with union, "
                     "intersection or difference",
                     child->key, entry->key);
      return NULL;
    }
    entry = child;
  }
  if (entry) return read_kind(rd, entry);
  need(rd->reader, node, "no shape; give one, like {box: {...}}");
  return NULL;
}
