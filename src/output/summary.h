/* summary.json: what a run was and what came out (design sec. 5), written last. */
#ifndef SDR_OUTPUT_SUMMARY_H
#define SDR_OUTPUT_SUMMARY_H

#include "mechanics/system.h"
#include "output/crack_report.h"
#include "output/fragments.h"
#include "output/ledger.h"
#include "output/record.h"
#include "scene/scene.h"

typedef struct {
  const char *name;
  double value; /* NAN: null */
  int always;   /* 1: stands among the figures even if the scene gives no range for it */
} sdr_measured;

/* What a state-based model makes of a material (theory sec. 5); NAN: null. */
typedef struct {
  double poisson, bulk, shear;          /* K of the scene's dimensions and G, Pa */
  double control_shear, control_normal; /* P_s and P_n, Pa */
  double condition;                     /* of shape tensors, the largest */
  double ell;                           /* m */
  double critical_stretch;
} sdr_material_constants;

/* SI. NULL texts and non-finite numbers become null. */
typedef struct {
  const sdr_scene *scene;
  const char *version;         /* NULL: SUNDER_VERSION */
  const char *commit;          /* git commit of the build */
  const char *instruction_set; /* "avx512", "avx2", "baseline" */
  int threads;
  int64_t points, bonds, pairs, runs, loose;
  int64_t steps;     /* accepted since t = 0 */
  int64_t steps_run; /* accepted by this process, whose wall times these are; 0: all */
  double step_size, time_end;
  double wall_setup, wall_integrate, wall_output, wall_total; /* s */
  double stable_step;                                         /* s; NAN: not looked for */
  const sdr_solve_record *solve;           /* of linear equations; NULL, or name NULL: none were */
  const sdr_method_record *method;         /* likewise of integrators that choose their steps */
  const sdr_material_constants *constants; /* of the first material; NULL: bond-based */
  sdr_books books;
  double onset_time;              /* NAN: never */
  double damage_max, damage_mean; /* of the points' damage field */
  int fragments_known;
  sdr_fragments fragments;
  double contact_closest; /* of pieces that touched, over where they began to; NAN: no contact */
  const sdr_crack_report *cracks; /* of the scene's tips; NULL: none were followed */
  const char *const *skipped;     /* one line each: what was skipped and why */
  int skipped_count;
  const sdr_measured *measured; /* values that the scene's figures may name */
  int measured_count;
} sdr_summary;

/* Is each figure of the scene among these names? SDR_BAD_INPUT with the origin of one that is not,
   and the names there are. For before the run: sdr_summary_write fails likewise after it. */
sdr_status sdr_figures_check(const sdr_scene *scene, const sdr_measured *measured, int count);

/* Parts that summaries of other kinds of runs have too: program .. dimension; and `figures`: the
   scene's in its order (each must be measured), then those that always stand there. */
void sdr_summary_identity(sdr_record *r, const sdr_scene *scene, const char *version,
                          const char *commit);
void sdr_summary_figures(sdr_record *r, const sdr_scene *scene, const sdr_measured *measured,
                         int count);

/* Write DIRECTORY/summary.json by rename. peak_memory_bytes is the process's (getrusage). */
sdr_status sdr_summary_write(const char *directory, const sdr_summary *summary);

#endif
