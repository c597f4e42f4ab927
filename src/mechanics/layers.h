/* What moves the points of fictitious layers (004 sec. 3; theory sec. 6): each displacement
   component of a layer's point is an affine function of those of the points inside the face,
   u_f = a + B u.

   mirror: 2 U - u for a prescribed component, u for a free one, U at the foot on the face. The
   points have no family, so that the energy is that of the body; their forces act on the mirrored
   points as B^T f: a held face conserves energy, and a moving one does the work that U does.

   fictitious traction: u + (x_f - x).(strain that the traction asks for), eq. 29-32. The points
   have families; the forces on them are what pulls from outside and act on no point of the body. */
#ifndef SDR_MECHANICS_LAYERS_H
#define SDR_MECHANICS_LAYERS_H

#include "mechanics/constraints.h"
#include "nom/points.h"
#include "scene/scene.h"

typedef struct sdr_layers sdr_layers;

/* The layers of the scene over its arranged points; *out is NULL if it has none. They borrow scene
   and points. Owner: the caller. */
sdr_status sdr_layers_create(const sdr_scene *scene, const sdr_points *points, sdr_layers **out);
void sdr_layers_destroy(sdr_layers **layers); /* NULL-safe */

/* The layers' points, in an order in which each follows only earlier ones and the body. */
int32_t sdr_layers_count(const sdr_layers *layers);
const int32_t *sdr_layers_points(const sdr_layers *layers);

/* The points whose force a layer changes: its own, and those of the body that they act on; each
   once. */
int32_t sdr_layers_touched_count(const sdr_layers *layers);
const int32_t *sdr_layers_touched(const sdr_layers *layers);

/* Which map: how layers move (B), or on what their forces act. Equal for mirrors. */
typedef enum { SDR_LAYER_MOTION, SDR_LAYER_FORCE } sdr_layer_map;

/* 1 if both maps are the same. */
int sdr_layers_symmetric(const sdr_layers *layers);

/* Bring a to time t (s). Fails where a formula is not finite. */
sdr_status sdr_layers_values(sdr_layers *layers, double t);

/* u at the layers' points becomes a + B u (affine) or B u. */
void sdr_layers_follow(const sdr_layers *layers, double *const u[3]);
void sdr_layers_extend(const sdr_layers *layers, sdr_layer_map map, double *const u[3]);

/* Add the map's transpose times the layers' f to that of the points inside; layers get 0. */
void sdr_layers_gather(const sdr_layers *layers, sdr_layer_map map, double *const f[3]);

/* The same with the forces' map, for the model's forces; keeps what pulls each layer from outside.
 */
void sdr_layers_pull(sdr_layers *layers, double *const f[3]);

/* What the layer of a support pulled with then, N; 0 if it has none. */
double sdr_layers_reaction(const sdr_layers *layers, int support, int component);

/* The whole motion as rows over points of the body, at the time of sdr_layers_values. */
sdr_status sdr_layers_slaves(const sdr_layers *layers, sdr_slaves *out);

#endif
