/* The interface of an integrator: it moves a system of equations through time and sees no bonds. */
#ifndef SDR_TIME_INTEGRATOR_H
#define SDR_TIME_INTEGRATOR_H

#include "mechanics/system.h"

typedef struct {
  const char *name, *doc;
  /* First force of a system at t = 0 with u and v set; dt is the length of all steps (s). */
  sdr_status (*start)(sdr_system *system, double dt);
  /* One step: system->time and step move on, u, v, f are those of the new time. */
  sdr_status (*step)(sdr_system *system, double dt);
  int is_static; /* 1: one step, as long as the whole run; there is no stable one */
} sdr_integrator;

extern const sdr_integrator sdr_leapfrog, sdr_static;

/* The integrator of that name; NULL: none. */
const sdr_integrator *sdr_integrator_find(const char *name);

#endif
