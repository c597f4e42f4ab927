#include "geometry/layer_points.h"

#include "base/memory.h"
#include "geometry/face.h"
#include "geometry/place.h"
#include "geometry/point_grid.h"
#include "geometry/shape.h"
#include "geometry/text.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

int sdr_scene_layer(const sdr_scene *scene, int index, sdr_layer *out)
{
  for (int k = 0; k < scene->support_count; ++k) {
    const sdr_support_scene *support = &scene->support[k];
    if (!support->layer || index-- > 0) continue;
    *out = (sdr_layer){.kind = support->layer,
                       .index = k,
                       .on = &support->on,
                       .depth = support->depth,
                       .origin = support->origin};
    snprintf(out->name, sizeof out->name, "support '%s'", support->name);
    return 1;
  }
  for (int k = 0; k < scene->load_count; ++k) {
    const sdr_load *load = &scene->load[k];
    if (!load->layer || index-- > 0) continue;
    *out = (sdr_layer){.kind = load->layer,
                       .index = k,
                       .on = &load->on,
                       .depth = load->depth,
                       .name = "traction",
                       .origin = load->origin};
    return 1;
  }
  return 0;
}

/* A point of a layer on its way. Points are numbered on from those of the body. */
typedef struct {
  double x[3];
  int32_t cell[3];
  int32_t source, root; /* the point it is the image of, and the point of the body behind it */
  uint8_t layer;
} image;

typedef struct {
  const sdr_scene *scene;
  const sdr_points *body;
  sdr_layer layer;
  const sdr_shape *shape;
  double plane[3], normal[3]; /* out of the body */
  double depth;
  int32_t count, capacity;
  image *list;
} maker;

static void place_of(const maker *m, int32_t p, double x[3])
{
  const sdr_points *body = m->body;
  for (int c = 0; c < 3; ++c) {
    if (p >= body->count) {
      x[c] = m->list[p - body->count].x[c];
    } else {
      x[c] = c < body->components ? body->x[c][p] : 0.0;
    }
  }
}

static int32_t root_of(const maker *m, int32_t p)
{
  return p < m->body->count ? p : m->list[p - m->body->count].root;
}

/* How far x lies under the face's plane, m; below 0: outside. */
static double depth_of(const maker *m, const double x[3])
{
  double d = 0.0;
  for (int c = 0; c < 3; ++c) d += (m->plane[c] - x[c]) * m->normal[c];
  return d;
}

/* 1 if the foot of x[3] on the plane lies in the face. */
static int under_face(const maker *m, const double x[3], double spacing)
{
  const double d = fabs(depth_of(m, x));
  const double distance = sdr_face_distance(m->shape, m->layer.on->face, m->scene->dimension, x);
  return distance <= d + 1e-9 * spacing;
}

/* ---- wrong use ------------------------------------------------------------------------------- */

static int along_lattice(const maker *m)
{
  for (int a = 0; a < m->body->components; ++a) {
    double dot = 0.0;
    for (int c = 0; c < 3; ++c) dot += m->body->axes[a][c] * m->normal[c];
    if (fabs(dot) > 1.0 - 1e-12) return 1;
  }
  return 0;
}

static sdr_status find_plane(maker *m)
{
  const sdr_layer *layer = &m->layer;
  const char *where = sdr_origin_text(layer->origin);
  m->shape = sdr_place_shape(m->scene, layer->on);
  if (!sdr_face_plane(m->shape, layer->on->face, m->plane, m->normal)) {
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: %s: a layer needs one flat face, and '%s' is none; leave `layer` out to "
                    "act on the points near the face",
                    where, layer->name, layer->on->text);
  }
  if (m->body->irregular) {
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: %s: a layer needs points in rows, and these are %s; leave out `layer`%s",
                    where, layer->name, m->scene->points.imported ? "imported" : "jittered",
                    m->scene->points.imported ? "" : " or points.jitter");
  }
  if (along_lattice(m)) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: %s: a layer needs a face along the rows of the lattice, and '%s' lies "
                  "across them; turn points.angle or the face",
                  where, layer->name, layer->on->text);
}

static sdr_status check_halfway(const maker *m, const double x[3], double d, double spacing)
{
  const double rows = d / spacing - 0.5;
  char text[SDR_PLACE_TEXT];
  if (d > 0.0 && fabs(rows - rint(rows)) < 1e-6) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT,
                  "%s: %s: a layer needs its face halfway between two rows of points, but the "
                  "point at %s lies %.4g spacings from '%s'; move the face, or the lattice by "
                  "points.origin or points.align",
                  sdr_origin_text(m->layer.origin), m->layer.name,
                  sdr_place_text(x, m->body->components, text), d / spacing, m->layer.on->text);
}

/* ---- images ---------------------------------------------------------------------------------- */

static sdr_status add_image(maker *m, image one)
{
  if (m->count == m->capacity) {
    const int32_t capacity = m->capacity ? 2 * m->capacity : 256;
    image *grown = sdr_realloc(m->list, (size_t)capacity, sizeof *grown);
    if (!grown) return SDR_RUN_FAILED;
    m->list = grown;
    m->capacity = capacity;
  }
  m->list[m->count++] = one;
  return SDR_OK;
}

/* The largest horizon of the points whose horizon reaches through the face. */
static double depth_wanted(const maker *m)
{
  const sdr_points *body = m->body;
  double largest = 0.0;
  if (!m->layer.depth.relative) return m->layer.depth.value;
  for (int32_t i = 0; i < body->count; ++i) {
    double x[3];
    place_of(m, i, x);
    const double d = depth_of(m, x);
    if (body->horizon[i] <= largest || d < 0.0 || d > body->horizon[i]) continue;
    if (under_face(m, x, body->spacing[i])) largest = body->horizon[i];
  }
  return m->layer.depth.value * largest;
}

static void cell_of_image(const maker *m, int32_t p, double d, image *one)
{
  const sdr_points *body = m->body;
  const int32_t *from =
      p < body->count ? body->cell + 3 * (size_t)p : m->list[p - body->count].cell;
  const double size = body->spacing[one->root];
  for (int a = 0; a < 3; ++a) {
    double dot = 0.0;
    for (int c = 0; c < 3; ++c) dot += body->axes[a][c] * m->normal[c];
    one->cell[a] = from[a] + (int32_t)rint(2.0 * d * dot / size);
  }
}

static sdr_status mirror_point(maker *m, int32_t p, uint8_t layer)
{
  const sdr_points *body = m->body;
  const int32_t root = root_of(m, p);
  const double spacing = body->spacing[root];
  double x[3], behind[3];
  place_of(m, p, x);
  place_of(m, root, behind);
  const double d = depth_of(m, x);
  if (d < -1e-9 * spacing || d > m->depth + 1e-9 * spacing) return SDR_OK;
  if (depth_of(m, behind) < -1e-9 * spacing || !under_face(m, behind, spacing)) return SDR_OK;
  SDR_TRY(check_halfway(m, x, d, spacing));
  image one = {.source = p, .root = root, .layer = layer};
  /* the image of what has no family has none */
  if (p >= body->count) one.layer |= m->list[p - body->count].layer & SDR_NO_FAMILY;
  for (int c = 0; c < 3; ++c) one.x[c] = x[c] + 2.0 * d * m->normal[c];
  if (sdr_shape_contains(m->scene->points.shape, one.x, -1e-6 * spacing)) return SDR_OK;
  if (body->cell) cell_of_image(m, p, d, &one);
  return add_image(m, one);
}

static sdr_status make_layer(maker *m, int index)
{
  const int32_t before = m->count, points = m->body->count + m->count;
  if (index >= SDR_LAYERS)
    return sdr_fail(SDR_BAD_INPUT, "%s: at most %d layers are possible",
                    sdr_origin_text(m->layer.origin), (int)SDR_LAYERS);
  SDR_TRY(find_plane(m));
  m->depth = depth_wanted(m);
  /* What follows its own mirror image carries the energy of the body alone (theory sec. 6). */
  const int family = m->layer.kind == SDR_TRACTION_LAYER ? 0 : SDR_NO_FAMILY;
  for (int32_t p = 0; p < points; ++p) SDR_TRY(mirror_point(m, p, (uint8_t)((index + 1) | family)));
  if (m->count > before) return SDR_OK;
  return sdr_fail(
      SDR_BAD_INPUT,
      "%s: %s: no point lies under '%s' within the depth of the layer; choose a face of "
      "the body or a larger depth",
      sdr_origin_text(m->layer.origin), m->layer.name, m->layer.on->text);
}

/* ---- the points of body and layers ----------------------------------------------------------- */

static void copy_body(const sdr_points *from, sdr_points *to)
{
  const size_t count = (size_t)from->count;
  for (int c = 0; c < from->components; ++c) memcpy(to->x[c], from->x[c], count * sizeof(double));
  memcpy(to->volume, from->volume, count * sizeof(double));
  memcpy(to->spacing, from->spacing, count * sizeof(double));
  memcpy(to->horizon, from->horizon, count * sizeof(double));
  memcpy(to->material, from->material, count);
  if (from->level) memcpy(to->level, from->level, count);
  if (from->cell) memcpy(to->cell, from->cell, 3 * count * sizeof(int32_t));
  memcpy(to->axes, from->axes, sizeof to->axes);
  to->lattice_spacing = from->lattice_spacing;
}

static void put_image(const image *one, const sdr_points *from, sdr_points *to, int32_t i)
{
  const int32_t root = one->root;
  for (int c = 0; c < from->components; ++c) to->x[c][i] = one->x[c];
  to->volume[i] = from->volume[root];
  to->spacing[i] = from->spacing[root];
  to->horizon[i] = from->horizon[root];
  to->material[i] = from->material[root];
  to->layer[i] = one->layer;
  if (from->level) to->level[i] = from->level[root];
  if (from->cell) memcpy(to->cell + 3 * (size_t)i, one->cell, sizeof one->cell);
}

static sdr_status join(const maker *m, sdr_points **out)
{
  const sdr_points *body = m->body;
  sdr_points *all = NULL;
  if (m->count > INT32_MAX - 8 - body->count)
    return sdr_fail(SDR_BAD_INPUT, "body and layers have more points than 2^31 - 9");
  SDR_TRY(sdr_points_create(body->count + m->count, body->components, body->cell != NULL, &all));
  const size_t padded = sdr_points_padded(all);
  all->layer = sdr_alloc(padded, 1);
  if (body->level) all->level = sdr_alloc(padded, 1);
  if (!all->layer || (body->level && !all->level)) {
    sdr_points_destroy(&all);
    return SDR_RUN_FAILED;
  }
  copy_body(body, all);
  for (int32_t k = 0; k < m->count; ++k) put_image(&m->list[k], body, all, body->count + k);
  *out = all;
  return SDR_OK;
}

static void count_point(void *context, int32_t point, double distance)
{
  (void)point;
  (void)distance;
  ++*(int *)context;
}

static sdr_status check_places(const maker *m, const sdr_points *all)
{
  sdr_point_grid *grid = NULL;
  char text[SDR_PLACE_TEXT];
  SDR_TRY(sdr_point_grid_create_all(all, &grid));
  sdr_status status = SDR_OK;
  for (int32_t k = 0; k < m->count && status == SDR_OK; ++k) {
    const image *one = &m->list[k];
    sdr_layer layer;
    int here = 0;
    sdr_point_grid_within(grid, one->x, 0.4 * all->spacing[m->body->count + k], count_point, &here);
    if (here == 1) continue;
    if (!sdr_scene_layer(m->scene, (one->layer & SDR_LAYERS) - 1, &layer)) continue;
    status = sdr_fail(SDR_BAD_INPUT,
                      "%s: %s: its layer has a point at %s where another layer has one too; part "
                      "their faces or take a smaller depth",
                      sdr_origin_text(layer.origin), layer.name,
                      sdr_place_text(one->x, all->components, text));
  }
  sdr_point_grid_destroy(&grid);
  return status;
}

sdr_status sdr_layer_points(const sdr_scene *scene, sdr_points **points)
{
  maker m = {.scene = scene, .body = *points};
  sdr_points *all = NULL;
  sdr_status status = SDR_OK;
  for (int k = 0; status == SDR_OK && sdr_scene_layer(scene, k, &m.layer); ++k)
    status = make_layer(&m, k);
  if (status == SDR_OK && m.count > 0) {
    status = join(&m, &all);
    if (status == SDR_OK) status = check_places(&m, all);
    if (status == SDR_OK) {
      sdr_points_destroy(points);
      *points = all;
    } else {
      sdr_points_destroy(&all);
    }
  }
  sdr_free(m.list);
  return status;
}

void sdr_layer_mirror(const sdr_scene *scene, const sdr_layer *layer, const double x[3],
                      double place[3])
{
  double plane[3], normal[3], d = 0.0;
  for (int c = 0; c < 3; ++c) place[c] = x[c];
  if (!sdr_face_plane(sdr_place_shape(scene, layer->on), layer->on->face, plane, normal)) return;
  for (int c = 0; c < 3; ++c) d += (plane[c] - x[c]) * normal[c];
  for (int c = 0; c < 3; ++c) place[c] = x[c] + 2.0 * d * normal[c];
}
