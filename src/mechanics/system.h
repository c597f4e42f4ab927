/* What integrators see: M a = f(u, v, t), with supports, and the books of what acts from outside.
   No bonds here. */
#ifndef SDR_MECHANICS_SYSTEM_H
#define SDR_MECHANICS_SYSTEM_H

#include "mechanics/contact.h"
#include "mechanics/layers.h"
#include "mechanics/loads.h"
#include "mechanics/model.h"
#include "mechanics/supports.h"

/* How a system of linear equations was solved last (name NULL: none was). */
typedef struct {
  const char *name;        /* of the linear solver */
  int64_t unknowns;        /* free components */
  int64_t nonzeros;        /* of the matrix */
  double assemble_seconds; /* wall time */
  double factor_seconds;   /* order and factor, or preconditioner */
  double solve_seconds;
  double bytes;        /* the solver's at most */
  int64_t iterations;  /* 0: direct */
  double residual;     /* |K u - f| at the free components over |f - K a| */
  double nonlinearity; /* |K u - (forces of the bent body)| over |K u| */
  /* Of integrators that solve nonlinear equations; 0 of others. */
  int64_t accepted, cuts; /* increments or steps; how often one was too long */
  int64_t newton;         /* iterations; those of linear solvers are `iterations` */
  int64_t factorisations;
  int64_t fallbacks; /* statics: times that motion had to find the next equilibrium */
} sdr_solve_record;

/* What a method that chooses its steps did since the start, or since a resume (name NULL: none). */
typedef struct {
  const char *name, *solver;  /* of the method; of its linear solver, NULL: none */
  int64_t steps, evaluations; /* of the force */
  int64_t iterations, linear_iterations;
  int64_t error_failures, iteration_failures; /* steps taken back */
  int64_t tangents, factors;
  int64_t unknowns; /* of the linear system */
  int order;        /* of the last step */
  double last_step; /* s */
  double residual;  /* ida: the largest share of the forces that a step left unbalanced */
} sdr_method_record;

typedef struct {
  int32_t count;
  int components;
  double *u[3]; /* m, at the system's time */
  double *v[3]; /* m/s, at the system's time + velocity_offset (leapfrog keeps half steps) */
  double *f[3]; /* N, total force = mass times acceleration, supports' reactions included */
  double *mass; /* kg */
  double time;  /* s */
  int64_t step;
  /* Of the last change of the step's length: time and step then. */
  double time_since;
  int64_t step_since;
  int over;               /* 1: the integrator has come to an end before the run's */
  double velocity_offset; /* s; leapfrog: minus half a step */

  const sdr_time_scene *how; /* what the scene asks of the integrator, borrowed; NULL: nothing */
  void *work;                /* the integrator's own; NULL: none */
  void (*end_work)(void *work);
  sdr_solve_record solve;
  sdr_method_record method;

  sdr_model *model;
  sdr_loads *loads;
  sdr_supports *supports;
  sdr_layers *layers;   /* NULL: none */
  sdr_contact *contact; /* borrowed; NULL: none */

  /* Sums since t = 0, of loads and supports. */
  double external_work;      /* J */
  double refinement;         /* J: by how much the energy grew when points split */
  double viscous;            /* J: what damping of the motion took; most integrators have none */
  double impulse[3];         /* N s */
  double angular_impulse[3]; /* N m s, about the origin, current positions */

  /* Of each entry of the supports' list: reaction (N; 0 while free), and the motion prescribed at
     two times (scratch). Of each loaded point: force one step ago, N. */
  double *reaction, *motion, *next_motion;
  double *load_before[3];
  /* Components of a point together: of each layer point its displacement; of each point that the
     layers touch what they pulled with, N, and scratch. */
  double *layer_u, *layer_pull, *layer_scratch;
} sdr_system;

/* Energies and momenta of the present state, velocities brought to its time. */
typedef struct {
  double kinetic;
  double contact; /* energy of pieces that touch */
  sdr_energies model;
  double momentum[3], angular[3];       /* sum m v; sum m x cross v */
  double momentum_scale, angular_scale; /* sum m |v|; sum m |x| |v| */
} sdr_balance;

/* A system over the model's points: masses from `density` (kg/m^3 per material index). The system
   borrows model, loads and supports. u = v = 0, f unset. Owner: the caller. */
sdr_status sdr_system_create(sdr_model *model, const double *density, sdr_loads *loads,
                             sdr_supports *supports, sdr_system **out);
/* Let the points of fictitious layers follow those of the body from now on. Borrows the layers
   (NULL: none). */
sdr_status sdr_system_attach(sdr_system *system, sdr_layers *layers);
void sdr_system_destroy(sdr_system **system); /* NULL-safe */

/* The mean of `from` (component arrays of points) over the entries of a mean of the supports. */
double sdr_system_mean(const sdr_system *system, int mean, double *const from[3]);

/* Give prescribed components their motion at t = 0, for a first step of length dt. */
sdr_status sdr_system_start(sdr_system *system, double dt);

/* Force at the present u and time; points of layers are brought there first. The model's (history
   committed; dt is the length of the step that led here, 0 at the start), the loads', and what
   keeps prescribed components on their way: their force is mass (w - v)/kick, w the velocity
   prescribed for the next step of length dt_next. Books the work and impulse of the step as the
   trapezoid that leapfrog satisfies exactly. */
sdr_status sdr_system_force(sdr_system *system, double dt, double dt_next, double kick);

/* What a support (its index in the scene) exerts along a component, N: the sum over its points, and
   what its layer pulled with. */
double sdr_system_reaction(const sdr_system *system, int support, int component);

void sdr_system_balance(sdr_system *system, sdr_balance *out);

/* Blocks that a checkpoint must hold beside u, v, f and the sums above. */
void sdr_system_state(sdr_system *system, sdr_state_block *blocks, int *count);

/* Field `name` (design sec. 4) at the present state: out holds count values per component,
   component-major; SI. `fragment` and unknown names are SDR_BAD_INPUT. */
sdr_status sdr_system_field(sdr_system *system, const char *name, double *out);

/* The displacement, velocity, acceleration or force of point i (as in sdr_system_field) into
   value[0 .. components - 1]; 0 if `name` is another field, which costs a pass over all points. */
int sdr_system_point(const sdr_system *system, const char *name, int32_t i, double value[3]);

/* Values a point has in field `name` in a body of `components` coordinates; 0: no such field. */
int sdr_field_components(const char *name, int components);

#endif
