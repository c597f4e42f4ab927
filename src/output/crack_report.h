/* What is told of a crack when the run is over. */
#ifndef SDR_OUTPUT_CRACK_REPORT_H
#define SDR_OUTPUT_CRACK_REPORT_H

#include "output/crack_area.h"
#include "output/crack_tree.h"
#include "scene/scene.h"

/* A place where a crack branched. */
typedef struct {
  double time, x[3]; /* s, m */
  double distance;   /* m, from the notch's tip along the crack */
  double speed;      /* m/s there, over the window */
} sdr_crack_fork;

/* The observer's lengths in m, and what is made of them. */
typedef struct {
  double moved, window, shortest;
  double count_at;  /* s */
  double rayleigh;  /* m/s */
  double toughness; /* J/m^2 */
  double thickness; /* m, of a plane body; NAN: it is none */
} sdr_crack_how;

typedef struct {
  double figure[SDR_CRACK_FIGURES]; /* NAN: there is none */
  sdr_crack_tree tree;              /* at the end */
  int fork_count;
  sdr_crack_fork *fork; /* by time */
} sdr_crack_report;

/* From the growth of the crack that begins at the tip; surface: what it made. fit: of the angle,
   m. Owner: the caller, who clears. */
sdr_status sdr_crack_report_make(const sdr_crack_sites *sites, const sdr_crack_growth *growth,
                                 const sdr_crack_how *how, const double direction[3],
                                 const double fit[2], sdr_crack_surface surface,
                                 sdr_crack_report *out);
void sdr_crack_report_clear(sdr_crack_report *report);

#endif
