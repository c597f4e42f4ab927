#include "mechanics/layers.h"

#include "base/memory.h"
#include "geometry/face.h"
#include "geometry/place.h"
#include "mechanics/layers_internal.h"
#include "mechanics/schedule.h"

#include <math.h>
#include <string.h>

/* ---- set-up ---------------------------------------------------------------------------------- */

static sdr_status find_layers(sdr_layers *layers)
{
  sdr_layer one;
  while (sdr_scene_layer(layers->scene, layers->layer_count, &one)) ++layers->layer_count;
  layers->layers = sdr_alloc((size_t)layers->layer_count, sizeof *layers->layers);
  if (!layers->layers) return SDR_RUN_FAILED;
  layers->symmetric = 1;
  for (int k = 0; k < layers->layer_count; ++k) {
    sdr_acting_layer *l = &layers->layers[k];
    double plane[3];
    sdr_scene_layer(layers->scene, k, &l->scene);
    const int mirror = l->scene.kind == SDR_MIRROR_LAYER;
    const sdr_support_scene *support = &layers->scene->support[mirror ? l->scene.index : 0];
    const sdr_load *load = &layers->scene->load[mirror ? 0 : l->scene.index];
    l->value = mirror ? support->value : load->value;
    l->schedule = mirror ? &support->schedule : &load->schedule;
    layers->symmetric &= mirror;
    sdr_face_plane(sdr_place_shape(layers->scene, l->scene.on), l->scene.on->face, plane,
                   l->normal);
    for (int c = 0; c < layers->components; ++c)
      l->uses[c] = l->value[c] ? sdr_expression_uses(l->value[c]) : 0;
  }
  return SDR_OK;
}

/* Points of layers by layer, then as stored. */
static sdr_status list_points(sdr_layers *layers)
{
  const sdr_points *points = layers->points;
  for (int32_t i = 0; i < points->count; ++i) layers->count += !sdr_in_body(points, i);
  const size_t count = (size_t)layers->count, components = (size_t)layers->components;
  layers->point = sdr_alloc(count, sizeof *layers->point);
  layers->foot = sdr_alloc(count, sizeof *layers->foot);
  layers->away = sdr_alloc(count, sizeof *layers->away);
  layers->still = sdr_alloc(count, sizeof *layers->still);
  layers->local = sdr_alloc(count * components, sizeof *layers->local);
  layers->first = sdr_alloc(count * components + 1, sizeof *layers->first);
  if (!layers->point || !layers->foot || !layers->away || !layers->still || !layers->local ||
      !layers->first)
    return SDR_RUN_FAILED;
  int32_t k = 0;
  for (int l = 1; l <= layers->layer_count; ++l)
    for (int32_t i = 0; i < points->count; ++i)
      if ((points->layer[i] & SDR_LAYERS) == l) layers->point[k++] = i;
  return SDR_OK;
}

static int maps(const sdr_layers *layers, sdr_layer_map map, int32_t k)
{
  return map == SDR_LAYER_MOTION ||
         sdr_acting_layer_of(layers, layers->point[k])->scene.kind == SDR_MIRROR_LAYER;
}

static sdr_status list_touched(sdr_layers *layers)
{
  const int32_t count = layers->points->count, n = layers->components;
  uint8_t *seen = sdr_alloc((size_t)count, 1);
  if (!seen) return SDR_RUN_FAILED;
  for (int32_t k = 0; k < layers->count; ++k) {
    seen[layers->point[k]] = 1;
    for (int32_t e = layers->first[k * n];
         maps(layers, SDR_LAYER_FORCE, k) && e < layers->first[(k + 1) * n]; ++e)
      seen[layers->entries[e].point] = 1;
  }
  for (int32_t i = 0; i < count; ++i) layers->touched_count += seen[i];
  layers->touched = sdr_alloc((size_t)layers->touched_count, sizeof *layers->touched);
  int32_t next = 0;
  for (int32_t i = 0; layers->touched && i < count; ++i)
    if (seen[i]) layers->touched[next++] = i;
  sdr_free(seen);
  return layers->touched ? SDR_OK : SDR_RUN_FAILED;
}

sdr_status sdr_layers_create(const sdr_scene *scene, const sdr_points *points, sdr_layers **out)
{
  if (!points->layer) {
    *out = NULL;
    return SDR_OK;
  }
  sdr_layers *layers = sdr_alloc(1, sizeof *layers);
  if (!layers) return SDR_RUN_FAILED;
  layers->scene = scene;
  layers->points = points;
  layers->components = points->components;
  sdr_status status = find_layers(layers);
  if (status == SDR_OK) status = list_points(layers);
  if (status == SDR_OK) status = sdr_layers_connect(layers);
  if (status == SDR_OK) status = list_touched(layers);
  if (status == SDR_OK) {
    *out = layers;
  } else {
    sdr_layers_destroy(&layers);
  }
  return status;
}

void sdr_layers_destroy(sdr_layers **layers)
{
  sdr_layers *l = *layers;
  if (!l) return;
  sdr_free(l->layers);
  sdr_free(l->point);
  sdr_free(l->foot);
  sdr_free(l->away);
  sdr_free(l->still);
  sdr_free(l->local);
  sdr_free(l->first);
  sdr_free(l->entries);
  sdr_free(l->touched);
  sdr_free(l);
  *layers = NULL;
}

int32_t sdr_layers_count(const sdr_layers *layers)
{
  return layers->count;
}

const int32_t *sdr_layers_points(const sdr_layers *layers)
{
  return layers->point;
}

int32_t sdr_layers_touched_count(const sdr_layers *layers)
{
  return layers->touched_count;
}

const int32_t *sdr_layers_touched(const sdr_layers *layers)
{
  return layers->touched;
}

int sdr_layers_symmetric(const sdr_layers *layers)
{
  return layers->symmetric;
}

/* ---- a --------------------------------------------------------------------------------------- */

static sdr_status bring_to_time(sdr_layers *layers, double t)
{
  static const double nowhere[3] = {0.0};
  for (int k = 0; k < layers->layer_count; ++k) {
    sdr_acting_layer *l = &layers->layers[k];
    l->share = sdr_schedule_share(l->schedule, t);
    for (int c = 0; c < layers->components; ++c) {
      l->once[c] = 0.0;
      if (l->value[c] && !(l->uses[c] & SDR_USES_SPACE))
        SDR_TRY(sdr_layer_evaluate(l, c, nowhere, t, &l->once[c]));
    }
  }
  return SDR_OK;
}

/* Displacement or traction at the foot of point k. */
static sdr_status value_at(const sdr_layers *layers, const sdr_acting_layer *l, int32_t k, double t,
                           double value[3])
{
  for (int c = 0; c < layers->components; ++c) {
    value[c] = l->uses[c] & SDR_USES_SPACE ? layers->still[k][c] : l->once[c];
    if (l->uses[c] == (SDR_USES_SPACE | SDR_USES_TIME))
      SDR_TRY(sdr_layer_evaluate(l, c, layers->foot[k], t, &value[c]));
    value[c] *= l->share;
  }
  return SDR_OK;
}

sdr_status sdr_layers_values(sdr_layers *layers, double t)
{
  const int n = layers->components;
  SDR_TRY(bring_to_time(layers, t));
  for (int32_t k = 0; k < layers->count; ++k) {
    const sdr_acting_layer *l = sdr_acting_layer_of(layers, layers->point[k]);
    double value[3], along = 0.0;
    SDR_TRY(value_at(layers, l, k, t, value));
    for (int c = 0; c < n; ++c) along += value[c] * l->normal[c];
    const sdr_layer_moduli m = sdr_layer_moduli_at(layers, layers->point[k]);
    for (int c = 0; c < n; ++c) {
      const double normal = along * l->normal[c];
      layers->local[k * n + c] =
          l->scene.kind == SDR_MIRROR_LAYER
              ? 2.0 * value[c]
              : layers->away[k] * (normal / m.p + (value[c] - normal) / m.shear);
    }
  }
  return SDR_OK;
}

/* ---- maps ------------------------------------------------------------------------------------ */

void sdr_layers_extend(const sdr_layers *layers, sdr_layer_map map, double *const u[3])
{
  const int n = layers->components;
  for (int32_t k = 0; k < layers->count; ++k)
    for (int c = 0; c < n; ++c) {
      double sum = 0.0;
      for (int32_t e = layers->first[k * n + c];
           maps(layers, map, k) && e < layers->first[k * n + c + 1]; ++e)
        sum += layers->entries[e].coefficient *
               u[layers->entries[e].component][layers->entries[e].point];
      u[c][layers->point[k]] = sum;
    }
}

void sdr_layers_follow(const sdr_layers *layers, double *const u[3])
{
  const int n = layers->components;
  for (int32_t k = 0; k < layers->count; ++k)
    for (int c = 0; c < n; ++c) {
      double sum = layers->local[k * n + c];
      for (int32_t e = layers->first[k * n + c]; e < layers->first[k * n + c + 1]; ++e)
        sum += layers->entries[e].coefficient *
               u[layers->entries[e].component][layers->entries[e].point];
      u[c][layers->point[k]] = sum;
    }
}

/* What pulls component c of point k from outside, if the force on it is `force`. */
static double outside(const sdr_layers *layers, int32_t k, int c, double force)
{
  const int32_t n = layers->components;
  double sum = -force;
  for (int32_t e = layers->first[k * n + c];
       maps(layers, SDR_LAYER_FORCE, k) && e < layers->first[k * n + c + 1]; ++e)
    sum += layers->entries[e].coefficient * force;
  return sum;
}

void sdr_layers_pull(sdr_layers *layers, double *const f[3])
{
  const int n = layers->components;
  for (int l = 0; l < layers->layer_count; ++l)
    memset(layers->layers[l].reaction, 0, sizeof layers->layers[l].reaction);
  for (int32_t k = layers->count - 1; k >= 0; --k)
    for (int c = 0; c < n; ++c)
      sdr_acting_layer_of(layers, layers->point[k])->reaction[c] +=
          outside(layers, k, c, f[c][layers->point[k]]);
  sdr_layers_gather(layers, SDR_LAYER_FORCE, f);
}

double sdr_layers_reaction(const sdr_layers *layers, int support, int component)
{
  for (int l = 0; l < layers->layer_count; ++l) {
    const sdr_acting_layer *one = &layers->layers[l];
    if (one->scene.kind == SDR_MIRROR_LAYER && one->scene.index == support)
      return one->reaction[component];
  }
  return 0.0;
}

void sdr_layers_gather(const sdr_layers *layers, sdr_layer_map map, double *const f[3])
{
  const int n = layers->components;
  for (int32_t k = layers->count - 1; k >= 0; --k)
    for (int c = 0; c < n; ++c) {
      const double force = f[c][layers->point[k]];
      f[c][layers->point[k]] = 0.0;
      for (int32_t e = layers->first[k * n + c];
           maps(layers, map, k) && e < layers->first[k * n + c + 1]; ++e)
        f[layers->entries[e].component][layers->entries[e].point] +=
            layers->entries[e].coefficient * force;
    }
}

/* ---- rows over the body ---------------------------------------------------------------------- */

/* A row on its way: a constant and terms, each master once. */
typedef struct {
  sdr_slaves *slaves;
  int64_t capacity;
  int32_t *row_of; /* an unknown: its row; -1: it is of the body */
} composer;

static sdr_status add_term(composer *made, int32_t row, int32_t master, double coefficient)
{
  sdr_slaves *slaves = made->slaves;
  int64_t *end = &slaves->first[row + 1];
  for (int64_t p = slaves->first[row]; p < *end; ++p) {
    if (slaves->master[p] != master) continue;
    slaves->coefficient[p] += coefficient;
    return SDR_OK;
  }
  if (*end == made->capacity) {
    const int64_t capacity = made->capacity ? 2 * made->capacity : 256;
    int32_t *masters = sdr_realloc(slaves->master, (size_t)capacity, sizeof *masters);
    if (!masters) return SDR_RUN_FAILED;
    slaves->master = masters;
    double *values = sdr_realloc(slaves->coefficient, (size_t)capacity, sizeof *values);
    if (!values) return SDR_RUN_FAILED;
    slaves->coefficient = values;
    made->capacity = capacity;
  }
  slaves->master[*end] = master;
  slaves->coefficient[(*end)++] = coefficient;
  return SDR_OK;
}

static sdr_status compose_row(const sdr_layers *layers, composer *made, int32_t row)
{
  sdr_slaves *slaves = made->slaves;
  slaves->first[row + 1] = slaves->first[row];
  slaves->constant[row] = layers->local[row];
  for (int32_t e = layers->first[row]; e < layers->first[row + 1]; ++e) {
    const sdr_layer_entry *one = &layers->entries[e];
    const int32_t unknown = one->point * layers->components + one->component;
    const int32_t through = made->row_of[unknown];
    if (through < 0) {
      SDR_TRY(add_term(made, row, unknown, one->coefficient));
      continue;
    }
    slaves->constant[row] += one->coefficient * slaves->constant[through];
    for (int64_t p = slaves->first[through]; p < slaves->first[through + 1]; ++p)
      SDR_TRY(add_term(made, row, slaves->master[p], one->coefficient * slaves->coefficient[p]));
  }
  return SDR_OK;
}

static sdr_status compose(const sdr_layers *layers, composer *made)
{
  const int32_t n = layers->components, rows = layers->count * n;
  sdr_slaves *slaves = made->slaves;
  slaves->unknown = sdr_alloc((size_t)rows, sizeof *slaves->unknown);
  slaves->constant = sdr_alloc((size_t)rows, sizeof *slaves->constant);
  slaves->first = sdr_alloc((size_t)rows + 1, sizeof *slaves->first);
  slaves->apart = sdr_alloc((size_t)rows, sizeof *slaves->apart);
  if (!made->row_of || !slaves->unknown || !slaves->constant || !slaves->first || !slaves->apart)
    return SDR_RUN_FAILED;
  slaves->count = rows;
  for (int32_t i = 0; i < layers->points->count * n; ++i) made->row_of[i] = -1;
  for (int32_t row = 0; row < rows; ++row) {
    slaves->unknown[row] = layers->point[row / n] * n + row % n;
    slaves->apart[row] = !maps(layers, SDR_LAYER_FORCE, row / n);
    SDR_TRY(compose_row(layers, made, row));
    made->row_of[slaves->unknown[row]] = row;
  }
  return SDR_OK;
}

sdr_status sdr_layers_slaves(const sdr_layers *layers, sdr_slaves *out)
{
  sdr_slaves slaves = {0};
  composer made = {.slaves = &slaves};
  const size_t unknowns = (size_t)layers->points->count * (size_t)layers->components;
  made.row_of = sdr_alloc(unknowns, sizeof *made.row_of);
  const sdr_status status = compose(layers, &made);
  sdr_free(made.row_of);
  if (status == SDR_OK)
    *out = slaves;
  else
    sdr_slaves_destroy(&slaves);
  return status;
}
