/* What is prescribed and loaded at any moment between two events, for integrators that look at many
   moments within a step: u = a(t) + B q (mechanics/constraints.h), with a and its rates as
   functions of time. Vectors are over the free components q unless said otherwise. */
#ifndef SDR_TIME_MOTION_H
#define SDR_TIME_MOTION_H

#include "time/implicit.h"

typedef struct sdr_motion sdr_motion;

/* From the system's time and state on. Owner: the caller. */
sdr_status sdr_motion_create(sdr_system *system, sdr_motion **out);
void sdr_motion_destroy(sdr_motion **motion); /* NULL-safe */

/* Begin a stretch at the system's time: up to the next event, or `end`. Which components are free
   stays the same within it; moments at its ends are taken from inside. *renumbered = 1 if others
   are free than before. */
sdr_status sdr_motion_begin(sdr_motion *motion, double end, int *renumbered);
double sdr_motion_until(const sdr_motion *motion); /* s: where the stretch ends */

/* Give prescribed components the place and velocity that the beginning stretch wants, and layers
   those that follow. Where that is a jump, what it changes in energy and momenta counts as brought
   from outside, unless `silent`. */
sdr_status sdr_motion_jump(sdr_motion *motion, int silent);

/* The components q, borrowed until the next sdr_motion_begin. */
const sdr_constraints *sdr_motion_constraints(const sdr_motion *motion);
/* Masses of q, kg. */
const double *sdr_motion_mass(const sdr_motion *motion);

/* q and dq/dt of the system's state. */
void sdr_motion_take(const sdr_motion *motion, double *q, double *w);

/* Bring loads and a to time t, and the system's u to a + B q. */
sdr_status sdr_motion_place(sdr_motion *motion, double t, const double *q);

/* Means of supports. Their components are free, and a force, the same on all points of a mean,
   keeps it where it should be: on those with mass by the acceleration that is wanted, on those
   without by the velocity, with the resistance `viscous` (N s/m an unknown, borrowed; NULL: none),
   to be given before sdr_motion_begin. What rounding and errors of steps leave of the mean is
   shifted away. */
void sdr_motion_resist(sdr_motion *motion, const double *viscous);

/* The components of q that mean `mean` joins, *count of them (0: it does not act now). */
int sdr_motion_means(const sdr_motion *motion);
const int32_t *sdr_motion_mean(const sdr_motion *motion, int mean, int32_t *count);

/* 1 if entry k of the supports' list acts in this stretch; where it wants its component to be at
   time t (m), how fast (m/s), and how fast that changes (m/s^2). */
int sdr_motion_prescribes(const sdr_motion *motion, int32_t k);
sdr_status sdr_motion_prescribed(sdr_motion *motion, double t, int32_t k, double *position,
                                 double *rate, double *bend);

/* g = P^T f + loads + what keeps means, with the model's force f at the system's u; N. The system's
   f holds what the points feel of the model then, layers' forces handed on. Changes no history. */
void sdr_motion_force(sdr_motion *motion, double *g);

/* What comes from outside: power (W), force (N) and moment (N m) of loads, supports and layers. */
enum { SDR_MOTION_RATES = 7 };

/* Their values at time t after sdr_motion_place and sdr_motion_force, for integration over time:
   but what prescribed masses take up, which sdr_motion_accept adds. */
sdr_status sdr_motion_outside(sdr_motion *motion, double t, const double *w,
                              double rates[SDR_MOTION_RATES]);
/* 1 if anything acts from outside. */
int sdr_motion_driven(const sdr_motion *motion);

/* Accept q, w as the state at time t: u, v, time, step, damage. `outside`: integrals of the rates
   since the last call. g: of sdr_motion_force there, with the system's f (reactions are wanted), or
   acceleration times mass. */
sdr_status sdr_motion_accept(sdr_motion *motion, double t, const double *q, const double *w,
                             const double *g, const double outside[SDR_MOTION_RATES]);

/* 1 if bonds broke for good when the last state was accepted: the force has a jump there. */
int sdr_motion_broke(const sdr_motion *motion);

/* The total forces of the system's state at its time, into its f and reactions. */
sdr_status sdr_motion_show(sdr_motion *motion);

#endif
