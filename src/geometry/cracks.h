/* Which bonds the scene's pre-cracks cut. */
#ifndef SDR_GEOMETRY_CRACKS_H
#define SDR_GEOMETRY_CRACKS_H

#include "scene/scene.h"

/* 1 if the straight bond from a[3] to b[3] crosses or touches one of the scene's cracks; touching
   within `tolerance` (m) counts. */
int sdr_cracks_cut(const sdr_scene *scene, const double a[3], const double b[3], double tolerance);

#endif
