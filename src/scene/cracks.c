#include "scene/sections.h"

#include <math.h>
#include <string.h>

static double *vertex_room(sdr_reading *rd, int count, sdr_crack *crack)
{
  crack->vertices = sdr_store_alloc(rd->reader->store, (size_t)count, 3 * sizeof(double));
  if (!crack->vertices) sdr_read_fatal(rd->reader, SDR_RUN_FAILED);
  return crack->vertices;
}

static void in_error(sdr_reading *rd, const sdr_node *node, const char *what)
{
  sdr_read_error(rd->reader, node->origin, "the %s: %s", node->key, what);
}

static double span(const double a[3], const double b[3])
{
  return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
              (a[2] - b[2]) * (a[2] - b[2]));
}

static void read_segment(sdr_reading *rd, sdr_node *node, sdr_crack *crack)
{
  if (!vertex_room(rd, 2, crack)) return;
  crack->kind = SDR_CRACK_POLYLINE;
  crack->point_count = 2;
  const sdr_quantity any = SDR_ANY_VALUE(SDR_LENGTH);
  int good = sdr_read_vector(rd->reader, node, "from", any, NULL, crack->vertices);
  good = sdr_read_vector(rd->reader, node, "to", any, NULL, crack->vertices + 3) && good;
  if (good && !(span(crack->vertices, crack->vertices + 3) > 0)) {
    in_error(rd, node, "'from' and 'to' are the same place");
  }
}

static void read_polyline(sdr_reading *rd, sdr_node *node, sdr_crack *crack)
{
  if (node->count < 2) {
    in_error(rd, node, "at least 2 points are wanted, [[x, y], [x, y]]");
    return;
  }
  if (!vertex_room(rd, node->count, crack)) return;
  crack->kind = SDR_CRACK_POLYLINE;
  for (sdr_node *child = node->first; child; child = child->next) {
    sdr_read_vector_node(rd->reader, child, SDR_ANY_VALUE(SDR_LENGTH),
                         crack->vertices + 3 * crack->point_count++);
  }
}

/* 1-D: {point: 0.5 m} or {point: [0.5 m]}. */
static void read_point(sdr_reading *rd, sdr_node *node, sdr_crack *crack)
{
  if (!vertex_room(rd, 1, crack)) return;
  crack->kind = SDR_CRACK_POLYLINE;
  crack->point_count = 1;
  const sdr_quantity any = SDR_ANY_VALUE(SDR_LENGTH);
  if (node->kind == SDR_SCALAR) {
    sdr_read_number_node(rd->reader, node, any, crack->vertices);
  } else {
    sdr_read_vector_node(rd->reader, node, any, crack->vertices);
  }
}

static void read_disc(sdr_reading *rd, sdr_node *node, sdr_crack *crack)
{
  sdr_reader *r = rd->reader;
  if (!vertex_room(rd, 1, crack)) return;
  crack->kind = SDR_CRACK_DISC;
  crack->point_count = 1;
  sdr_read_vector(r, node, "centre", SDR_ANY_VALUE(SDR_LENGTH), NULL, crack->vertices);
  sdr_read_number(r, node, "radius", SDR_ABOVE_ZERO(SDR_LENGTH), NULL, &crack->radius);
  if (!sdr_read_vector(r, node, "normal", SDR_ANY_VALUE(SDR_PLAIN), NULL, crack->normal)) return;
  const double length = span(crack->normal, (double[3]){0, 0, 0});
  if (!(length > 0) || !isfinite(length)) {
    in_error(rd, node, "the normal must have a length above 0");
    return;
  }
  for (int c = 0; c < 3; ++c) crack->normal[c] /= length;
}

/* A corner and the two edges that leave it. */
static void read_rectangle(sdr_reading *rd, sdr_node *node, sdr_crack *crack)
{
  sdr_reader *r = rd->reader;
  const sdr_quantity any = SDR_ANY_VALUE(SDR_LENGTH);
  if (!vertex_room(rd, 3, crack)) return;
  crack->kind = SDR_CRACK_RECTANGLE;
  crack->point_count = 3;
  double *v = crack->vertices, edge[2][3] = {{0, 0, 0}, {0, 0, 0}};
  sdr_read_vector(r, node, "corner", any, NULL, v);
  sdr_node *edges = sdr_read_list(r, node, "edges", NULL);
  if (!edges) return;
  if (edges->count != 2) {
    in_error(rd, node, "two edges are wanted, [[x, y, z], [x, y, z]]");
    return;
  }
  const int good = sdr_read_vector_node(r, edges->first, any, edge[0]);
  if (!sdr_read_vector_node(r, edges->last, any, edge[1]) || !good) return;
  const double zero[3] = {0, 0, 0}, a = span(edge[0], zero), b = span(edge[1], zero);
  const double dot = edge[0][0] * edge[1][0] + edge[0][1] * edge[1][1] + edge[0][2] * edge[1][2];
  if (!(a > 0) || !(b > 0) || fabs(dot) > 1e-9 * a * b) {
    in_error(rd, node, "the two edges must have a length and be perpendicular");
    return;
  }
  for (int c = 0; c < 3; ++c) {
    v[3 + c] = v[c] + edge[0][c];
    v[6 + c] = v[c] + edge[1][c];
  }
}

static const struct {
  const char *word;
  int components;     /* of the scenes it is for */
  sdr_node_kind node; /* a point may also be a single value */
  void (*read)(sdr_reading *, sdr_node *, sdr_crack *);
} kinds[] = {
    {"point", 1, SDR_SEQUENCE, read_point},        {"segment", 2, SDR_MAPPING, read_segment},
    {"polyline", 2, SDR_SEQUENCE, read_polyline},  {"disc", 3, SDR_MAPPING, read_disc},
    {"rectangle", 3, SDR_MAPPING, read_rectangle},
};
enum { KIND_COUNT = sizeof kinds / sizeof *kinds };

static void unknown_crack(sdr_reading *rd, const sdr_node *entry)
{
  const int components = sdr_components(rd->reader->dimension);
  sdr_read_error(rd->reader, entry->key_origin, "unknown crack '%.60s'; cracks in %d-D: %s",
                 entry->key, components,
                 components == 1   ? "point"
                 : components == 2 ? "segment, polyline"
                                   : "disc, rectangle");
}

static void read_crack(sdr_reading *rd, sdr_node *item, sdr_crack *crack)
{
  const char *what = "a crack, like {segment: {from: [0, 0], to: [1 mm, 0]}}";
  crack->origin = item->origin;
  if (!sdr_read_is(rd->reader, item, SDR_MAPPING, what)) return;
  sdr_node *entry = item->first;
  if (item->count != 1 || sdr_node_is_null(entry)) {
    sdr_read_error(rd->reader, item->origin, "one crack is wanted here: %s", what);
    return;
  }
  for (int k = 0; k < KIND_COUNT; ++k) {
    if (strcmp(entry->key, kinds[k].word) != 0) continue;
    if (kinds[k].components != sdr_components(rd->reader->dimension)) break;
    if (kinds[k].read != read_point &&
        !sdr_read_is(rd->reader, entry, kinds[k].node,
                     kinds[k].node == SDR_MAPPING ? "a mapping" : "a list of points")) {
      return;
    }
    kinds[k].read(rd, entry, crack);
    if (entry->kind == SDR_MAPPING) sdr_read_done(rd->reader, entry);
    return;
  }
  unknown_crack(rd, entry);
}

void sdr_read_cracks(sdr_reading *rd)
{
  sdr_node *list = sdr_read_list(rd->reader, rd->root, "cracks", "[]");
  if (!list || list->count == 0) return;
  rd->scene->crack = sdr_reading_room(rd, list, sizeof *rd->scene->crack);
  if (!rd->scene->crack) return;
  for (sdr_node *item = list->first; item; item = item->next) {
    read_crack(rd, item, &rd->scene->crack[rd->scene->crack_count++]);
  }
}
