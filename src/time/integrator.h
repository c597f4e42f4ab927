/* The interface of an integrator: it moves a system of equations through time and sees no bonds. */
#ifndef SDR_TIME_INTEGRATOR_H
#define SDR_TIME_INTEGRATOR_H

#include "mechanics/system.h"

/* What an integrator needs beside the system's state (histories of a method, factors) is
   system->work; start and restart make it, the system destroys it. */
typedef struct {
  const char *name, *doc;
  /* First force of a system at t = 0 with u and v set; dt is the length of all steps (s), of those
     that choose theirs the longest. */
  sdr_status (*start)(sdr_system *system, double dt);
  /* What start or the first step would refuse about the supports, found without solving anything;
     leaves the system at rest. NULL: nothing is. */
  sdr_status (*held)(sdr_system *system, double dt);
  /* One step: system->time and step move on, u, v, f are those of the new time. One that chooses
     its steps ends no later than system->how->end, and at every moment at which a load or support
     has a kink. */
  sdr_status (*step)(sdr_system *system, double dt);
  /* Begin anew from the present state: after a checkpoint was written or read, so that a resumed
     run has the bits of the one that went on. NULL: nothing to do. */
  sdr_status (*restart)(sdr_system *system, double dt);
  /* Begin anew with steps of length dt from u and v at the system's time, velocity_offset 0: after
     points have split. NULL: this integrator cannot. */
  sdr_status (*begin)(sdr_system *system, double dt);
  int is_explicit; /* 1: steps above sdr_stable_step are unstable, every step is accepted */
  int chooses;     /* 1: how many steps a run takes is not known before its end */
  int is_static;   /* 1: nothing moves: no masses, no velocities */
  double reach; /* of implicit ones with steps of one length: theirs over the explicit limit, if the
                   scene leaves it to them */
} sdr_integrator;

extern const sdr_integrator sdr_energy_momentum;
extern const sdr_integrator sdr_leapfrog, sdr_static, sdr_static_linear;
extern const sdr_integrator sdr_cvode, sdr_ida;

/* The integrator of that name; NULL: none. */
const sdr_integrator *sdr_integrator_find(const char *name);

#endif
