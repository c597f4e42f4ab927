/* What implicit integrators share: the components q that are free to move, u = a(t) + B q
   (mechanics/constraints.h), what acts from outside, and its books.

   Vectors over all displacement components are numbered unknown = point * components + component;
   those over the free ones as q. */
#ifndef SDR_TIME_IMPLICIT_H
#define SDR_TIME_IMPLICIT_H

#include "mechanics/constraints.h"
#include "mechanics/system.h"

typedef struct {
  sdr_system *system;
  int32_t unknowns, free; /* components of u; of q */
  double time;            /* s, of all that follows */
  sdr_constraints constraints;
  sdr_slaves slaves;
  int32_t means;   /* how many of the slaves, the last ones, keep means */
  double *load;    /* an unknown: what loads put on it, N */
  double *mass;    /* an unknown: kg; 0 for points of layers */
  double *reached; /* an entry of the supports' list: its displacement at the system's time, m */
  double *scratch; /* an unknown; NULL: no layers */
  int free_means; /* 1: components of prescribed means are free: the integrator pulls them itself */
  uint8_t *held;  /* an unknown: 1 where constraints act: prescribed, slaved, leading a slave */
} sdr_implicit;

/* At the system's time. The supports and layers of the system at other times follow by
   sdr_implicit_move. Owner: the caller. */
sdr_status sdr_implicit_create(sdr_system *system, sdr_implicit **out);
void sdr_implicit_destroy(sdr_implicit **implicit); /* NULL-safe */

/* Bring constraints and loads to `time`; prescribed velocities act from the system's time on (that
   of the middle, times the time between). *renumbered = 1 if other components are free than before,
   so that q, and matrices over it, must be made anew. */
sdr_status sdr_implicit_move(sdr_implicit *implicit, double time, int *renumbered);

/* The first moment after t at which a load or support has a kink or jump (begins, ends, or its ramp
   does); INFINITY: none. */
double sdr_implicit_next_event(const sdr_implicit *implicit, double t);

/* Between vectors over unknowns and component arrays of points. */
void sdr_implicit_gather(const sdr_implicit *implicit, double *const from[3], double *to);
void sdr_implicit_scatter(const sdr_implicit *implicit, const double *from, double *const to[3]);

/* The model's force at u: -d(energy)/du, N; both over unknowns. Uses the system's u and f as
   scratch. */
void sdr_implicit_force(sdr_implicit *implicit, const double *u, double *force);

/* What acts from outside where the model's force is `internal` and mass times acceleration is
   `total` (NULL: zero): loads, and on held components whatever is missing to `total`. Over
   unknowns, N. Also into the supports' reactions. */
void sdr_implicit_outside(sdr_implicit *implicit, const double *internal, const double *total,
                          double *out);

/* Accept the system's u at its time as where the next step starts. */
void sdr_implicit_accept(sdr_implicit *implicit);

/* Book work, impulse and angular impulse of a step of length dt: the body moved by `way` (m) to the
   system's u; forces `before` and `now` acted at its ends, their mean on average. One force of the
   middle is given twice. All over unknowns. */
void sdr_implicit_book(sdr_implicit *implicit, const double *way, const double *before,
                       const double *now, double dt);

#endif
