/* What runs by CVODES and by IDA have alike: how they start, go on from a checkpoint, say what they
   did, and why they stopped. */
#ifndef SDR_TIME_SUN_RUN_H
#define SDR_TIME_SUN_RUN_H

#include "time/motion.h"
#include "time/reduced_solver.h"
#include "time/sun_parts.h"

typedef struct {
  const char *(*name)(const sdr_system *system);
  /* A work of its own; `before`: what the method did already. */
  sdr_status (*create)(sdr_system *system, double dt, const sdr_method_record *before, void **work);
  void (*destroy)(void *work);
  /* From the system's time on; `silent`: what jumps there is no work from outside. */
  sdr_status (*next_stretch)(void *work, int silent);
  sdr_motion *(*motion)(void *work);
} sdr_sun_method;

/* The operations `start` and `restart` of an integrator. A restart makes all anew, tolerances too,
   so that a resumed run does the same; only the counts go on. */
sdr_status sdr_sun_start(const sdr_sun_method *method, sdr_system *system, double dt);
sdr_status sdr_sun_restart(const sdr_sun_method *method, sdr_system *system, double dt);

/* Counts of the library and of the linear solver (NULL: none) into the system's record. */
void sdr_sun_report(sdr_system *system, const sdr_reduced_solver *reduced,
                    const sdr_method_record *counts);

/* What broke: a failure of a function of ours, else the library's own complaint. */
typedef struct {
  sdr_status status;
  const sdr_sun_complaint *complaint;
} sdr_sun_failure;

/* At setting up. */
sdr_status sdr_sun_complain(const char *library, sdr_sun_failure failure);

/* At a step that ended with `flag`: of `known` reasons, each with what to try. */
typedef struct {
  int flag;
  const char *what, *try;
} sdr_sun_reason;
sdr_status sdr_sun_explain(const sdr_system *system, const char *name, sdr_sun_failure failure,
                           int flag, const sdr_sun_reason *known, size_t count);

#endif
