/* The body of a scene: families, bonds and the model that the scene names. */
#ifndef SDR_APP_BODY_H
#define SDR_APP_BODY_H

#include "mechanics/model.h"
#include "nom/family.h"
#include "scene/scene.h"

/* Young's modulus of each point, Pa; scatter is drawn here. */
sdr_status sdr_body_young(const sdr_scene *scene, const sdr_points *points, double *young);

/* Families and model over arranged points, which they borrow, with `young` of each and `share`
   (sdr_bond_based_how; may be NULL). A horizon that gives no bonds is SDR_BAD_INPUT, with its place
   in the scene. Owner: the caller, of both. */
sdr_status sdr_body_create(const sdr_scene *scene, const sdr_points *points, const double *young,
                           const double *share, sdr_families **families, sdr_model **model);

#endif
