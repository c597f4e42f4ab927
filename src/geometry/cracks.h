/* Which bonds the scene's pre-cracks cut. */
#ifndef SDR_GEOMETRY_CRACKS_H
#define SDR_GEOMETRY_CRACKS_H

#include "scene/scene.h"

/* 1 if the straight bond from a[3] to b[3] (m) crosses or touches one of the scene's cracks;
   touching within `tolerance` (m) counts. Polylines are seen in the x-y plane only (in 1-D: points
   of the x axis); the three corners of a rectangle may come in any order, the right angle tells
   which is the middle one. */
int sdr_cracks_cut(const sdr_scene *scene, const double a[3], const double b[3], double tolerance);

/* 0 if no crack comes within `tolerance` (m) of the box low[3]..high[3], so that no bond inside it
   can be cut; a cheap test to skip whole regions. */
int sdr_cracks_near(const sdr_scene *scene, const double low[3], const double high[3],
                    double tolerance);

#endif
