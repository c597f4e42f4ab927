/* Who follows whom: the rows of B. */
#include "base/memory.h"
#include "damage/calibration.h"
#include "geometry/point_grid.h"
#include "mechanics/layers_internal.h"

#include <math.h>

static void place_of(const sdr_points *points, int32_t i, double x[3])
{
  for (int c = 0; c < 3; ++c) x[c] = c < points->components ? points->x[c][i] : 0.0;
}

/* The nearest point within `distance` that belongs to the body or to a layer before `before`. */
typedef struct {
  const sdr_points *points;
  int before;
  int32_t point;
  double distance;
} finder;

static void keep_earlier(void *context, int32_t point, double distance)
{
  finder *f = context;
  const int layer = f->points->layer[point] & SDR_LAYERS;
  if (layer >= f->before || distance >= f->distance) return;
  f->point = point;
  f->distance = distance;
}

static int32_t find(const sdr_layers *layers, const sdr_point_grid *grid, int before,
                    const double x[3], double spacing)
{
  finder f = {.points = layers->points, .before = before, .point = -1, .distance = HUGE_VAL};
  sdr_point_grid_within(grid, x, 1e-3 * spacing, keep_earlier, &f);
  return f.point;
}

static sdr_status add_entry(sdr_layers *layers, sdr_layer_entry one)
{
  if (layers->entry_count == layers->entry_capacity) {
    const int32_t capacity = layers->entry_capacity ? 2 * layers->entry_capacity : 256;
    sdr_layer_entry *grown = sdr_realloc(layers->entries, (size_t)capacity, sizeof *grown);
    if (!grown) return SDR_RUN_FAILED;
    layers->entries = grown;
    layers->entry_capacity = capacity;
  }
  layers->entries[layers->entry_count++] = one;
  return SDR_OK;
}

/* A layer's point on the way to its entries. */
typedef struct {
  sdr_layers *layers;
  const sdr_point_grid *grid;
  const sdr_acting_layer *layer;
  int32_t k, point, source; /* number in the list, point, and the point that it mirrors */
  int before;               /* 1 + index of its layer */
} follower;

sdr_layer_moduli sdr_layer_moduli_at(const sdr_layers *layers, int32_t point)
{
  const sdr_scene *scene = layers->scene;
  const sdr_material *material = &scene->material[layers->points->material[point]];
  const double e = material->young;
  const double nu =
      scene->model == SDR_BOND_BASED ? sdr_bond_poisson(scene->dimension) : material->poisson;
  if (scene->dimension == SDR_1D) return (sdr_layer_moduli){.p = e, .shear = 0.5 * e, .ratio = 0.0};
  const double shear = 0.5 * e / (1.0 + nu);
  if (scene->dimension == SDR_PLANE_STRESS)
    return (sdr_layer_moduli){.p = e / (1.0 - nu * nu), .shear = shear, .ratio = nu};
  return (sdr_layer_moduli){
      .p = 2.0 * shear * (1.0 - nu) / (1.0 - 2.0 * nu), .shear = shear, .ratio = nu / (1.0 - nu)};
}

/* Neighbours of the mirrored point along the lattice axis, one spacing off, or the point itself
   where there is none: places of a difference. Returns their distance. */
static double neighbours_along(const follower *f, int axis, int32_t side[2])
{
  const sdr_points *points = f->layers->points;
  const double *along = points->axes[axis], h = points->spacing[f->source];
  double x[3], width = 0.0;
  for (int s = 0; s < 2; ++s) {
    place_of(points, f->source, x);
    for (int c = 0; c < points->components; ++c) x[c] += (s ? h : -h) * along[c];
    side[s] = find(f->layers, f->grid, f->before, x, h);
    if (side[s] < 0)
      side[s] = f->source;
    else
      width += h;
  }
  return width;
}

/* Component c of a traction layer: - away (ratio n_c d_t u_t + t_c d_t u_n) for the axis t. */
static sdr_status add_tangential(const follower *f, int c, int axis)
{
  const sdr_layers *layers = f->layers;
  const double *t = layers->points->axes[axis], *n = f->layer->normal;
  const double ratio = sdr_layer_moduli_at(layers, f->source).ratio;
  int32_t side[2];
  const double width = neighbours_along(f, axis, side);
  if (width == 0.0) return SDR_OK;
  for (int b = 0; b < layers->components; ++b) {
    const double part = -layers->away[f->k] * (ratio * n[c] * t[b] + t[c] * n[b]) / width;
    if (part == 0.0) continue;
    SDR_TRY(add_entry(f->layers, (sdr_layer_entry){side[1], b, part}));
    SDR_TRY(add_entry(f->layers, (sdr_layer_entry){side[0], b, -part}));
  }
  return SDR_OK;
}

static int across(const follower *f, int axis)
{
  double dot = 0.0;
  for (int c = 0; c < 3; ++c) dot += f->layers->points->axes[axis][c] * f->layer->normal[c];
  return fabs(dot) < 0.5;
}

static sdr_status add_component(const follower *f, int c)
{
  const int mirror = f->layer->scene.kind == SDR_MIRROR_LAYER;
  const double own = mirror && f->layer->value[c] ? -1.0 : 1.0;
  SDR_TRY(add_entry(f->layers, (sdr_layer_entry){f->source, c, own}));
  for (int axis = 0; !mirror && axis < f->layers->components; ++axis)
    if (across(f, axis)) SDR_TRY(add_tangential(f, c, axis));
  return SDR_OK;
}

static sdr_status add_follower(follower *f)
{
  sdr_layers *layers = f->layers;
  const sdr_points *points = layers->points;
  double x[3], inside[3];
  place_of(points, f->point, x);
  sdr_layer_mirror(layers->scene, &f->layer->scene, x, inside);
  f->source = find(layers, f->grid, f->before, inside, points->spacing[f->point]);
  if (f->source < 0)
    return sdr_fail(SDR_RUN_FAILED, "%s: %s: a point of the layer has lost the point it follows",
                    sdr_origin_text(f->layer->scene.origin), f->layer->scene.name);
  for (int c = 0; c < 3; ++c) {
    layers->foot[f->k][c] = 0.5 * (x[c] + inside[c]);
    layers->away[f->k] += (x[c] - inside[c]) * f->layer->normal[c];
  }
  for (int c = 0; c < layers->components; ++c) {
    if (f->layer->uses[c] == SDR_USES_SPACE)
      SDR_TRY(sdr_layer_evaluate(f->layer, c, layers->foot[f->k], 0.0, &layers->still[f->k][c]));
    SDR_TRY(add_component(f, c));
    layers->first[f->k * layers->components + c + 1] = layers->entry_count;
  }
  return SDR_OK;
}

sdr_status sdr_layers_connect(sdr_layers *layers)
{
  sdr_point_grid *grid = NULL;
  SDR_TRY(sdr_point_grid_create_all(layers->points, &grid));
  sdr_status status = SDR_OK;
  for (int32_t k = 0; k < layers->count && status == SDR_OK; ++k) {
    follower f = {.layers = layers, .grid = grid, .k = k, .point = layers->point[k]};
    f.layer = sdr_acting_layer_of(layers, f.point);
    f.before = layers->points->layer[f.point] & SDR_LAYERS;
    status = add_follower(&f);
  }
  sdr_point_grid_destroy(&grid);
  return status;
}
