/* One step of the energy-momentum scheme: from (u0, v0) over h to

     M (v1 - v0) = h (F + load),   u1 - u0 = h/2 (v0 + v1)

   with the model's mean force F of the step and the load of its middle (theory sec. 7). With the
   way w = u1 - u0 the equations are 2/h^2 M (w - h v0) = F(w) + load, solved by Newton's method. */
#ifndef SDR_TIME_MIDPOINT_H
#define SDR_TIME_MIDPOINT_H

#include "time/step_solver.h"

typedef struct {
  sdr_implicit *implicit;
  sdr_step_solver *solver;
  double tolerance; /* of the residual, as a share of its terms */
  double *u0[3];    /* where the step starts, as component arrays of points */
  /* Over all components. */
  double *start;                        /* u0 */
  double *velocity;                     /* v0; of prescribed components that of this step, way/h */
  double *way;                          /* w */
  double *before, *last_way;            /* of the step before: its v0 and w */
  double last_h;                        /* its length, s; 0: there was none */
  double *internal;                     /* F */
  double *stiffness;                    /* of the undeformed body against its own motion, N/m */
  double most_stiffness;                /* the largest over its mass, 1/s^2 */
  double *residual, *direction, *trial; /* over q: trial is the way before a direction */
  double *scratch;                      /* over all components */
  int32_t room;                         /* of those over q */
  int64_t newton;                       /* iterations so far */
  int last_newton;                      /* of the last solution */
  int32_t worst;                        /* unknown with the largest residual where it failed */
  double reached;                       /* residual at the end, as a share of its terms */
} sdr_midpoint;

/* Borrows `implicit`; solver: by name (step_solver.h). Owner: the caller. */
sdr_status sdr_midpoint_create(sdr_implicit *implicit, const char *solver, double tolerance,
                               sdr_midpoint **out);
void sdr_midpoint_destroy(sdr_midpoint **midpoint); /* NULL-safe */

/* Find w for a step of length h from the system's u and v, to where `implicit` was moved; loads
   stand in implicit->load. *converged = 0: the step is too long, and nothing is changed but scratch
   and the system's u and f. Else the system's u is u1; way, velocity and internal hold the step.
   `renumbered` as of sdr_implicit_move. */
sdr_status sdr_midpoint_solve(sdr_midpoint *midpoint, double h, int renumbered, int *converged);

/* The step that was solved last is accepted: the next one's first guess goes on from it. */
void sdr_midpoint_accept(sdr_midpoint *midpoint, double h);

#endif
