/* The points of a scene: a lattice clipped by a shape, refined, jittered. */
#ifndef SDR_GEOMETRY_LATTICE_H
#define SDR_GEOMETRY_LATTICE_H

#include "nom/points.h"
#include "scene/scene.h"

/* Generate the scene's points, with volume, spacing, horizon, material (and cell, if not
   jittered), not yet arranged. They are the sites lattice_origin + axes . spacing (i, j, k), half a
   spacing further in components that are cell_centred, which lie in the shape; z slowest, x
   fastest.

   Refinement replaces the cell around a site whose centre lies in `where` by children of half its
   size, down to the spacing asked for; deeper places inside go on from there. All children are
   kept, so that the volume stays, even where a cell on the surface reaches out of the shape.
   Neighbouring cells may differ by more than one level. Jitter moves each coordinate of a point by
   up to jitter times its own spacing, drawn in the order of generation (gsl_rng_mt19937); points
   may so leave the shape a little, unless those at its surface stay (jitter_inside). Jittered
   points are no lattice (cell stays NULL).

   The points of fictitious layers follow those of the body (layer_points.h).

   SDR_BAD_INPUT with the origin: no point, too many, a horizon below the spacing, a refined spacing
   that is no halving, a material without points, an unbounded shape. Owner of *out: the caller. */
sdr_status sdr_lattice_points(const sdr_scene *scene, sdr_points **out);

#endif
