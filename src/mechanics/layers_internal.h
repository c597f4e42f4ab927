/* Shared by the files that make up the layers. */
#ifndef SDR_MECHANICS_LAYERS_INTERNAL_H
#define SDR_MECHANICS_LAYERS_INTERNAL_H

#include "geometry/layer_points.h"
#include "mechanics/layers.h"

/* u[component][point] times coefficient. */
typedef struct {
  int32_t point;
  int component;
  double coefficient;
} sdr_layer_entry;

/* A layer with what its formulas give. */
typedef struct {
  sdr_layer scene;
  sdr_expression *const *value; /* 3: displacement or traction */
  const sdr_schedule *schedule;
  double normal[3];
  int uses[3];
  double once[3];     /* at the present time, of formulas without place */
  double share;       /* how far the layer has set in */
  double reaction[3]; /* N, at the last sdr_layers_pull */
} sdr_acting_layer;

struct sdr_layers {
  const sdr_scene *scene;
  const sdr_points *points;
  int components, layer_count, symmetric;
  sdr_acting_layer *layers;
  int32_t count;
  int32_t *point;
  double (*foot)[3];  /* a point: on the face, m */
  double *away;       /* a point: x_f - x along the normal, m */
  double (*still)[3]; /* a point: values of formulas of the place alone */
  double *local;      /* a point and component: its own part of a, m */
  int32_t *first;     /* a point and component: its entries; and one more */
  int32_t entry_count, entry_capacity;
  sdr_layer_entry *entries;
  int32_t touched_count;
  int32_t *touched;
};

static inline sdr_acting_layer *sdr_acting_layer_of(const sdr_layers *layers, int32_t point)
{
  return &layers->layers[(layers->points->layer[point] & SDR_LAYERS) - 1];
}

/* Component c of the layer's displacement or traction at x[3] and t. */
static inline sdr_status sdr_layer_evaluate(const sdr_acting_layer *layer, int c, const double x[3],
                                            double t, double *value)
{
  if (sdr_expression_value(layer->value[c], x, t, value) == SDR_OK) return SDR_OK;
  return sdr_fail(SDR_BAD_INPUT, "%s: %s, %c component: %s", sdr_origin_text(layer->scene.origin),
                  layer->scene.name, "xyz"[c], sdr_error_message());
}

/* Moduli of the material at a point for a traction: u_n,n = (T_n - lambda sum u_t,t)/p,
   u_t,n = T_t/shear - u_n,t. */
typedef struct {
  double p, shear, ratio; /* Pa, Pa, lambda/p */
} sdr_layer_moduli;
sdr_layer_moduli sdr_layer_moduli_at(const sdr_layers *layers, int32_t point);

/* Find what each layer's point follows: foot, away, still, first and entries. */
sdr_status sdr_layers_connect(sdr_layers *layers);

#endif
