#include "mechanics/loads.h"

#include "base/memory.h"
#include "geometry/face.h"
#include "geometry/place.h"
#include "geometry/point_grid.h"
#include "geometry/shape.h"
#include "geometry/text.h"
#include "mechanics/schedule.h"

#include <string.h>

enum { FIRST_SHARES = 256 };

/* How a load's formulas are evaluated. */
typedef enum {
  ONCE,   /* they use no place: one value at a time, shares merged by point */
  BEFORE, /* they use no time: values went into the shares, merged by point */
  AT_EACH /* both: at every share's own place */
} evaluation;

/* What a point gets of a load: force component c = weight[c] times the load's value. */
typedef struct {
  int32_t slot; /* of the loaded points; while loads are spread: the point */
  double weight[3];
} share;

typedef struct {
  const sdr_load *load;
  evaluation how;
  int64_t count, capacity;
  int32_t points; /* that have a share, each counted once */
  share *shares;
  double *x; /* AT_EACH: 3 per share */
} term;

struct sdr_loads {
  int components;
  int32_t count;
  int32_t *points;
  double *force[3];
  int term_count;
  term *terms;
};

/* One load on its way to the points. */
typedef struct {
  const sdr_scene *scene;
  const sdr_points *points;
  const sdr_point_grid *grid;
  int32_t *merged; /* per point: 1 + its share in the present term; 0: none */
  term *term;
  int64_t far_pieces;
  double far_place[3];
  int32_t layer_count;
  const sdr_piece *piece;
  double piece_share; /* of the piece's force that a point of the layer gets */
  sdr_status status;
} spreader;

static const char *kind_name(sdr_load_kind kind)
{
  static const char *const names[] = {"pressure", "traction", "body force", "point force"};
  return names[kind];
}

static sdr_expression *formula(const sdr_load *load, int c)
{
  return load->value[load->kind == SDR_PRESSURE ? 0 : c];
}

static sdr_status evaluate(const sdr_load *load, int c, const double x[3], double t, double *value)
{
  sdr_expression *expression = formula(load, c);
  *value = 0.0;
  if (!expression || sdr_expression_value(expression, x, t, value) == SDR_OK) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "%s: %s: %s", sdr_origin_text(load->origin), kind_name(load->kind),
                  sdr_error_message());
}

static evaluation how_to_evaluate(const sdr_load *load, int components)
{
  int uses = 0;
  for (int c = 0; c < components; ++c) {
    if (formula(load, c)) uses |= sdr_expression_uses(formula(load, c));
  }
  if (!(uses & SDR_USES_SPACE)) return ONCE;
  return uses & SDR_USES_TIME ? AT_EACH : BEFORE;
}

static sdr_status make_room(term *t)
{
  if (t->count < t->capacity) return SDR_OK;
  const int64_t capacity = t->capacity ? 2 * t->capacity : FIRST_SHARES;
  share *shares = sdr_realloc(t->shares, (size_t)capacity, sizeof *shares);
  if (!shares) return SDR_RUN_FAILED;
  t->shares = shares;
  if (t->how == AT_EACH) {
    double *x = sdr_realloc(t->x, (size_t)capacity, 3 * sizeof *x);
    if (!x) return SDR_RUN_FAILED;
    t->x = x;
  }
  t->capacity = capacity;
  return SDR_OK;
}

/* Give the point its share of the load at the place x[3]. */
static sdr_status add_share(spreader *s, int32_t point, const double x[3], const double weight[3])
{
  term *t = s->term;
  share added = {point, {weight[0], weight[1], weight[2]}};
  for (int c = 0; c < s->points->components && t->how == BEFORE; ++c) {
    double value;
    SDR_TRY(evaluate(t->load, c, x, 0.0, &value));
    added.weight[c] *= value;
  }
  const int32_t merged = t->how == AT_EACH ? 0 : s->merged[point];
  if (merged) {
    for (int c = 0; c < 3; ++c) t->shares[merged - 1].weight[c] += added.weight[c];
    return SDR_OK;
  }
  SDR_TRY(make_room(t));
  if (t->how == AT_EACH) {
    memcpy(&t->x[3 * t->count], x, 3 * sizeof *x);
  } else {
    s->merged[point] = (int32_t)t->count + 1;
  }
  t->shares[t->count++] = added;
  return SDR_OK;
}

static double thickness_of(const sdr_scene *scene)
{
  return scene->dimension == SDR_3D ? 1.0 : scene->points.thickness;
}

/* The points around a piece, on which side of it they are. */
typedef struct {
  const sdr_points *points;
  const sdr_piece *piece;
  double side;
} sides;

static void add_side(void *context, int32_t point, double distance)
{
  sides *s = context;
  (void)distance;
  for (int c = 0; c < s->points->components; ++c)
    s->side += (s->points->x[c][point] - s->piece->x[c]) * s->piece->normal[c];
}

/* -1 if the normal points into the body, as on the rim of a region that is a hole of it. */
static double outward(const spreader *s, const sdr_piece *piece, int32_t nearest)
{
  const sdr_shape *body = s->scene->points.shape;
  double behind[3], ahead[3];
  if (!body) { /* imported: where its points are */
    sides around = {s->points, piece, 0.0};
    sdr_point_grid_within(s->grid, piece->x, 2.0 * s->points->spacing[nearest], add_side, &around);
    return around.side > 0.0 ? -1.0 : 1.0;
  }
  for (int c = 0; c < 3; ++c) {
    const double step = 1e-6 * s->scene->points.spacing * piece->normal[c];
    behind[c] = piece->x[c] - step;
    ahead[c] = piece->x[c] + step;
  }
  const int inwards =
      sdr_shape_contains(body, ahead, 0.0) && !sdr_shape_contains(body, behind, 0.0);
  return inwards ? -1.0 : 1.0;
}

static void give_piece(spreader *s, int32_t point)
{
  const sdr_piece *piece = s->piece;
  const double area = piece->measure * thickness_of(s->scene) * s->piece_share;
  double weight[3] = {area, area, area};
  if (s->term->load->kind == SDR_PRESSURE) {
    for (int c = 0; c < 3; ++c) weight[c] = -area * piece->normal[c];
  }
  if (s->status == SDR_OK) s->status = add_share(s, point, piece->x, weight);
}

static void count_layer(void *context, int32_t point, double distance)
{
  (void)point;
  (void)distance;
  ++((spreader *)context)->layer_count;
}

static void give_layer(void *context, int32_t point, double distance)
{
  (void)distance;
  give_piece(context, point);
}

static void spread_piece(void *context, const sdr_piece *given)
{
  spreader *s = context;
  sdr_piece piece = *given;
  if (s->status != SDR_OK) return;
  const int32_t nearest = sdr_point_grid_nearest(s->grid, piece.x);
  if (nearest < 0) {
    if (s->far_pieces++ == 0) memcpy(s->far_place, piece.x, sizeof s->far_place);
    return;
  }
  const double turn = outward(s, &piece, nearest);
  for (int c = 0; c < 3; ++c) piece.normal[c] *= turn;
  const double layer = s->points->spacing[nearest] * (1.0 + SDR_SHAPE_TOLERANCE);
  s->piece = &piece;
  s->piece_share = 1.0;
  s->layer_count = 0;
  if (s->term->load->spread_layer) {
    sdr_point_grid_within(s->grid, piece.x, layer, count_layer, s);
  }
  if (s->layer_count == 0) {
    give_piece(s, nearest);
    return;
  }
  s->piece_share = 1.0 / s->layer_count;
  sdr_point_grid_within(s->grid, piece.x, layer, give_layer, s);
}

static void place_of(const sdr_points *points, int32_t i, double x[3])
{
  for (int c = 0; c < 3; ++c) x[c] = c < points->components ? points->x[c][i] : 0.0;
}

/* Spacing of the finest points next to the face. */
static double finest_spacing(const spreader *s, const sdr_shape *shape, const char *face)
{
  const sdr_points *points = s->points;
  double finest = s->scene->points.spacing;
  for (int32_t i = 0; (points->level || points->irregular) && i < points->count; ++i) {
    double x[3];
    if (points->spacing[i] >= finest) continue;
    place_of(points, i, x);
    const double distance = sdr_face_distance(shape, face, s->scene->dimension, x);
    if (distance <= 2.0 * points->spacing[i]) finest = points->spacing[i];
  }
  return finest;
}

static sdr_status spread_face(spreader *s)
{
  const sdr_load *load = s->term->load;
  const sdr_shape *shape = sdr_place_shape(s->scene, &load->on);
  char text[SDR_PLACE_TEXT];
  if (!load->on.face[0]) {
    return sdr_fail(SDR_BAD_INPUT,
                    "%s: a %s acts on a face, and '%s' is a volume; its faces are: %s",
                    sdr_origin_text(load->on.origin), kind_name(load->kind), load->on.text,
                    sdr_shape_faces(shape, text, (int)sizeof text));
  }
  const double size = finest_spacing(s, shape, load->on.face) / 8.0;
  if (sdr_face_pieces(shape, load->on.face, s->scene->dimension, size, spread_piece, s) != SDR_OK) {
    return sdr_fail(SDR_BAD_INPUT, "%s: %s: %s", sdr_origin_text(load->on.origin),
                    kind_name(load->kind), sdr_error_message());
  }
  if (s->status != SDR_OK || s->far_pieces == 0) return s->status;
  return sdr_fail(
      SDR_BAD_INPUT,
      "%s: the %s on '%s' meets no point at %s: the face lies more than 2 spacings from "
      "every point there; load a face of the body",
      sdr_origin_text(load->origin), kind_name(load->kind), load->on.text,
      sdr_place_text(s->far_place, s->points->components, text));
}

static sdr_status spread_body_force(spreader *s)
{
  const sdr_points *points = s->points;
  for (int32_t i = 0; i < points->count; ++i) {
    double x[3];
    if (!sdr_in_body(points, i)) continue;
    place_of(points, i, x);
    const double h = points->spacing[i], volume = points->volume[i];
    if (!sdr_place_holds(s->scene, &s->term->load->on, x, h, h)) continue;
    SDR_TRY(add_share(s, i, x, (double[3]){volume, volume, volume}));
  }
  return SDR_OK;
}

static sdr_status spread_point_force(spreader *s)
{
  const sdr_load *load = s->term->load;
  const int32_t nearest = sdr_point_grid_nearest(s->grid, load->at);
  char text[SDR_PLACE_TEXT];
  if (nearest < 0) {
    return sdr_fail(
        SDR_BAD_INPUT, "%s: the point force at %s meets no point: none lies within 2 spacings",
        sdr_origin_text(load->origin), sdr_place_text(load->at, s->points->components, text));
  }
  return add_share(s, nearest, load->at, (double[3]){1.0, 1.0, 1.0});
}

/* Leaves nothing merged. */
static void count_points(spreader *s)
{
  term *t = s->term;
  for (int64_t k = 0; k < t->count; ++k) {
    int32_t *mark = &s->merged[t->shares[k].slot];
    t->points += t->how != AT_EACH || !*mark;
    *mark = 1;
  }
  for (int64_t k = 0; k < t->count; ++k) s->merged[t->shares[k].slot] = 0;
}

static sdr_status spread(spreader *s)
{
  const sdr_load *load = s->term->load;
  s->status = SDR_OK;
  s->far_pieces = 0;
  switch (load->kind) {
  case SDR_PRESSURE:
  case SDR_TRACTION:
    SDR_TRY(spread_face(s));
    break;
  case SDR_BODY_FORCE:
    SDR_TRY(spread_body_force(s));
    break;
  case SDR_POINT_FORCE:
    SDR_TRY(spread_point_force(s));
    break;
  }
  if (s->term->count == 0) {
    return sdr_fail(SDR_BAD_INPUT, "%s: the %s on '%s' meets no point; choose a place in the body",
                    sdr_origin_text(load->origin), kind_name(load->kind), load->on.text);
  }
  count_points(s);
  return SDR_OK;
}

/* List the loaded points, and let shares name slots instead of points. */
static sdr_status number_slots(sdr_loads *loads, const sdr_points *points, int32_t *slot)
{
  for (int k = 0; k < loads->term_count; ++k) {
    const term *t = &loads->terms[k];
    for (int64_t n = 0; n < t->count; ++n) slot[t->shares[n].slot] = 1;
  }
  for (int32_t i = 0; i < points->count; ++i) loads->count += slot[i];
  loads->points = sdr_alloc((size_t)loads->count, sizeof *loads->points);
  int failed = !loads->points;
  for (int c = 0; c < loads->components; ++c) {
    failed |= !(loads->force[c] = sdr_alloc((size_t)loads->count, sizeof(double)));
  }
  if (failed) return SDR_RUN_FAILED;
  int32_t next = 0;
  for (int32_t i = 0; i < points->count; ++i) {
    if (!slot[i]) continue;
    slot[i] = next;
    loads->points[next++] = i;
  }
  for (int k = 0; k < loads->term_count; ++k) {
    term *t = &loads->terms[k];
    for (int64_t n = 0; n < t->count; ++n) t->shares[n].slot = slot[t->shares[n].slot];
  }
  return SDR_OK;
}

static sdr_status spread_all(sdr_loads *loads, spreader *s)
{
  for (int k = 0; k < s->scene->load_count; ++k) {
    term *t = &loads->terms[k];
    t->load = &s->scene->load[k];
    t->how = how_to_evaluate(t->load, loads->components);
    s->term = t;
    if (!t->load->layer) SDR_TRY(spread(s)); /* layers: mechanics/layers.h */
  }
  return number_slots(loads, s->points, s->merged);
}

sdr_status sdr_loads_create(const sdr_scene *scene, const sdr_points *points, sdr_loads **out)
{
  spreader s = {.scene = scene, .points = points};
  sdr_point_grid *grid = NULL;
  sdr_loads *loads = sdr_alloc(1, sizeof *loads);
  if (!loads) return SDR_RUN_FAILED;
  sdr_status status = SDR_RUN_FAILED;
  loads->components = points->components;
  loads->term_count = scene->load_count;
  loads->terms = sdr_alloc((size_t)scene->load_count, sizeof *loads->terms);
  s.merged = sdr_alloc((size_t)points->count, sizeof *s.merged);
  if (!loads->terms || !s.merged) goto done;
  if (scene->load_count > 0) {
    status = sdr_point_grid_create(points, &grid);
    if (status != SDR_OK) goto done;
  }
  s.grid = grid;
  status = spread_all(loads, &s);
done:
  sdr_free(s.merged);
  sdr_point_grid_destroy(&grid);
  if (status == SDR_OK) {
    *out = loads;
  } else {
    sdr_loads_destroy(&loads);
  }
  return status;
}

void sdr_loads_destroy(sdr_loads **loads)
{
  if (!*loads) return;
  for (int k = 0; (*loads)->terms && k < (*loads)->term_count; ++k) {
    sdr_free((*loads)->terms[k].shares);
    sdr_free((*loads)->terms[k].x);
  }
  for (int c = 0; c < 3; ++c) sdr_free((*loads)->force[c]);
  sdr_free((*loads)->terms);
  sdr_free((*loads)->points);
  sdr_free(*loads);
  *loads = NULL;
}

int32_t sdr_loads_points_of(const sdr_loads *loads, int index)
{
  return loads->terms[index].points;
}

/* Add what a load gives at time t, `in` being how far it has set in. */
static sdr_status add_term(sdr_loads *loads, const term *t, double time, double in)
{
  static const double nowhere[3] = {0.0};
  for (int c = 0; c < loads->components; ++c) {
    double value = 1.0, *force = loads->force[c];
    if (!formula(t->load, c)) continue;
    if (t->how == ONCE) SDR_TRY(evaluate(t->load, c, nowhere, time, &value));
    for (int64_t n = 0; n < t->count; ++n) {
      if (t->how == AT_EACH) SDR_TRY(evaluate(t->load, c, &t->x[3 * n], time, &value));
      force[t->shares[n].slot] += in * value * t->shares[n].weight[c];
    }
  }
  return SDR_OK;
}

sdr_status sdr_loads_evaluate(sdr_loads *loads, double t)
{
  for (int c = 0; c < loads->components; ++c) {
    memset(loads->force[c], 0, (size_t)loads->count * sizeof(double));
  }
  for (int k = 0; k < loads->term_count; ++k) {
    const double in = sdr_schedule_share(&loads->terms[k].load->schedule, t);
    if (in > 0.0) SDR_TRY(add_term(loads, &loads->terms[k], t, in));
  }
  return SDR_OK;
}

int32_t sdr_loads_count(const sdr_loads *loads)
{
  return loads->count;
}

const int32_t *sdr_loads_points(const sdr_loads *loads)
{
  return loads->points;
}

const double *sdr_loads_force(const sdr_loads *loads, int component)
{
  return loads->force[component];
}

double sdr_loads_next_event(const sdr_loads *loads, double t)
{
  double next = (double)INFINITY;
  for (int k = 0; k < loads->term_count; ++k)
    next = fmin(next, sdr_schedule_next(&loads->terms[k].load->schedule, t));
  return next;
}
