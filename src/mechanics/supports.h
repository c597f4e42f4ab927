/* Prescribed displacements and velocities, by component (design sec. 4). A support holds the points
   of its volume, or those within `depth` of its face. */
#ifndef SDR_MECHANICS_SUPPORTS_H
#define SDR_MECHANICS_SUPPORTS_H

#include "nom/points.h"
#include "scene/scene.h"

typedef struct sdr_supports sdr_supports;

/* Find the supported points. A support that meets no point is SDR_BAD_INPUT with its origin; so
   are two supports that prescribe the same component of a point at overlapping times; one may begin
   at the moment the other ends, and then takes over at it. The supports borrow scene and points.
   Owner: the caller. */
sdr_status sdr_supports_create(const sdr_scene *scene, const sdr_points *points,
                               sdr_supports **out);
void sdr_supports_destroy(sdr_supports **supports); /* NULL-safe */

/* A prescribed component of a point, or one of several whose mean is prescribed: then each is
   pulled by the same share of the support's force. */
typedef struct {
  int32_t point;
  int8_t component;
  int8_t is_velocity; /* value is m/s, else m */
  int16_t support;    /* index in the scene: names the reaction */
  int16_t mean;       /* which mean it is part of; -1: none, the component itself is prescribed */
} sdr_prescribed;

/* All prescribed components, by point then component, whether active or not. */
int32_t sdr_supports_count(const sdr_supports *supports);
const sdr_prescribed *sdr_supports_list(const sdr_supports *supports);

/* How many means are prescribed: one for each component of a support with `mean`. */
int sdr_supports_means(const sdr_supports *supports);

/* Values of all entries at time t (m or m/s, times the ramp), of a mean's entries that of the mean;
   NAN where not active at t. Formulas
   of the place see the point's reference position; those of place and time are evaluated at every
   point (slow). Fails where one is not finite. The array holds sdr_supports_count values. */
sdr_status sdr_supports_values(sdr_supports *supports, double t, double *values);

/* The first moment after t at which a support begins, ends or has set in; INFINITY: none. */
double sdr_supports_next_event(const sdr_supports *supports, double t);

#endif
