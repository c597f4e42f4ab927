/* Nonlinear statics: what its parts share (theory sec. 7). static.c takes the increments, a method
   finds the equilibrium of each, static_motion.c helps where statics has none nearby.

   A method is one more `const sdr_static_method` in the table of static.c, named in scenes by
   time.solver: it minimises the energy of equilibrium.h, or solves gradient = 0, from the u it is
   given, and may use whatever equilibrium.h offers (gradient, exact tangent times vector, factor of
   the secant stiffness). It judges by sdr_equilibrium_tolerance, never by the size of corrections.
 */
#ifndef SDR_TIME_STATIC_H
#define SDR_TIME_STATIC_H

#include "time/newton_pcg.h"

typedef struct {
  const char *name;
  /* A state of its own; e is borrowed. */
  sdr_status (*create)(sdr_equilibrium *e, void **state);
  /* From u (over unknowns, held components where they must be) to the equilibrium: as
     sdr_newton_solve. */
  sdr_status (*solve)(void *state, double *u, sdr_newton_report *report);
  void (*destroy)(void *state);
} sdr_static_method;

extern const sdr_static_method sdr_static_newton, sdr_static_relaxation, sdr_static_kinsol;

typedef struct {
  sdr_implicit *implicit;
  sdr_equilibrium *equilibrium;
  sdr_newton *newton; /* for first iterates, and motion */
  const sdr_static_method *method;
  void *state;            /* the method's */
  double length, longest; /* s: of the next increment; of any */
  double *u, *tried;      /* an unknown: the last equilibrium; the next, m */
  double *before, *now,
      *way;               /* an unknown: forces from outside at both (N), and what lies between */
  double *load;           /* an unknown: loads at the last equilibrium, N */
  double energy;          /* stored and dissipated at the last equilibrium, J */
  double largest;         /* most of it so far, J */
  double reached, excess; /* of tried: its energy, and what that exceeds the work by, J */
} sdr_static_work;

/* Book what the step from the last equilibrium (or state of motion) to `tried` took, where `total`
   is mass times acceleration and damping (NULL: 0), and make it the last one. dt: of impulses, s.
 */
void sdr_static_take(sdr_static_work *work, const double *total, double dt);

/* What the energy would grow by beyond the work done if `tried` were taken, J; total as before. */
double sdr_static_excess(sdr_static_work *work, const double *total);

/* Let the body move, damped, under the constraints and loads of now until it has come to rest;
   *rested = 0 if it does not. Damage grows and is committed on the way; what damping took is booked
   as viscous. */
sdr_status sdr_static_move(sdr_static_work *work, int *rested);

#endif
