/* From a scene to a wired model, ready to be integrated. */
#ifndef SDR_APP_BUILD_H
#define SDR_APP_BUILD_H

#include "mechanics/system.h"
#include "nom/bonds.h"
#include "nom/family.h"
#include "scene/scene.h"
#include "time/integrator.h"

enum { SDR_SKIPPED_MAX = 16 };

typedef struct {
  sdr_scene *scene;
  sdr_points *points;
  sdr_families *families;
  sdr_model *model;
  sdr_loads *loads;
  sdr_supports *supports;
  sdr_layers *layers;   /* NULL: none */
  sdr_contact *contact; /* NULL: none */
  sdr_system *system;
  const sdr_integrator *integrator;
  sdr_model_traits traits;
  const sdr_bonds *bonds;               /* the model's */
  int64_t cut_bonds;                    /* directed, by pre-cracks */
  double plane_cut;                     /* 0.9 of the damage beside a plane crack: tells cracks */
  double onset;                         /* damage of a point that counts as onset */
  double stable_step;                   /* s */
  double step;                          /* s */
  int64_t steps;                        /* to the end; 0: the integrator chooses */
  char warning[512];                    /* "" or what the user should know before the run */
  const char *skipped[SDR_SKIPPED_MAX]; /* what this scene does not need, so is not done */
  int skipped_count;
} sdr_built;

/* Load the scene (see sdr_scene_load) and build all of a run but its observers. A step above the
   stability limit is SDR_BAD_INPUT unless the scene allows it. Owner: the caller; *out is zero on
   failure. */
sdr_status sdr_build(const char *path, const char *variant, int set_count, const char *const *sets,
                     sdr_built *out);
/* The same of a scene that was loaded (not one with an equation); it is taken over and *scene NULL
   then, also on failure. */
sdr_status sdr_build_scene(sdr_scene **scene, sdr_built *out);

/* Run it: begin, then a step after another until it is over. Begin computes the first force. What
   only `sunder run` does is refused (SDR_BAD_INPUT): points that split on the way. */
sdr_status sdr_built_start(sdr_built *built);
sdr_status sdr_built_step(sdr_built *built);
int sdr_built_is_over(const sdr_built *built);

/* Parts of it, to build them over other points (built->points) of the same scene: families and
   model, not marked, with Young's modulus (Pa) of each point and what share of a full family's
   energy each keeps (sdr_bond_based_how; NULL: its own); then what acts on them, and the system, at
   rest. */
sdr_status sdr_built_model(sdr_built *built, const double *young, const double *share);
sdr_status sdr_built_system(sdr_built *built);
/* What marks the pairs of the scene before a run: pre-cracks, protected zones. */
sdr_pair_mark_of sdr_built_mark(const sdr_scene *scene);

void sdr_built_destroy(sdr_built *built);

#endif
