/* Forces from outside: pressure, traction, body and point forces (design sec. 4). Dead loads: they
   follow the reference shape.

   A face is cut into pieces no longer than an eighth of the spacing (of the finest points next to
   it). Each piece's force, -P n dA or T dA with the thickness included, goes to the nearest point,
   the first generated of several as near; with spread_layer it goes in equal parts to all points
   within one spacing of the piece. So the total force is exact. n points out of the body; on a
   region's face that bounds the body from the other side (the disc of a hole) it is turned round.
   A body force acts with value times volume on the points of its place. */
#ifndef SDR_MECHANICS_LOADS_H
#define SDR_MECHANICS_LOADS_H

#include "nom/points.h"
#include "scene/scene.h"

typedef struct sdr_loads sdr_loads;

/* Spread the scene's loads over the points. A load that meets no point, or a face that somewhere
   lies farther than 2 spacings from every point, is SDR_BAD_INPUT with its origin. The loads borrow
   scene and points. Owner: the caller. */
sdr_status sdr_loads_create(const sdr_scene *scene, const sdr_points *points, sdr_loads **out);
void sdr_loads_destroy(sdr_loads **loads); /* NULL-safe */

/* How many points the load with that index in the scene acts on; 0 for one with a layer. */
int32_t sdr_loads_points_of(const sdr_loads *loads, int index);

/* Bring the force of every loaded point to time t (N). Formulas are evaluated once per load, but
   at every piece if they use both place and time (slow). Fails where one is not finite. */
sdr_status sdr_loads_evaluate(sdr_loads *loads, double t);

/* The first moment after t at which a load has a kink in time; INFINITY: none. */
double sdr_loads_next_event(const sdr_loads *loads, double t);

/* The loaded points, each once, ascending, and their force at the last evaluated time (at first
   0). Unused components are NULL. */
int32_t sdr_loads_count(const sdr_loads *loads);
const int32_t *sdr_loads_points(const sdr_loads *loads);
const double *sdr_loads_force(const sdr_loads *loads, int component);

#endif
