/* Forces from outside: pressure, traction, body and point forces (design sec. 4). Dead loads: they
   follow the reference shape. */
#ifndef SDR_MECHANICS_LOADS_H
#define SDR_MECHANICS_LOADS_H

#include "nom/points.h"
#include "scene/scene.h"

typedef struct sdr_loads sdr_loads;

/* Spread the scene's loads over the points. A load that meets no point is SDR_BAD_INPUT with its
   origin. The loads borrow scene and points. Owner: the caller. */
sdr_status sdr_loads_create(const sdr_scene *scene, const sdr_points *points, sdr_loads **out);
void sdr_loads_destroy(sdr_loads **loads); /* NULL-safe */

/* Bring the force of every loaded point to time t (N). Fails where a formula is not finite. */
sdr_status sdr_loads_evaluate(sdr_loads *loads, double t);

/* The loaded points, each once, ascending, and their force at the last evaluated time. */
int32_t sdr_loads_count(const sdr_loads *loads);
const int32_t *sdr_loads_points(const sdr_loads *loads);
const double *sdr_loads_force(const sdr_loads *loads, int component);

#endif
