/* What integrators see: M a = f(u, v, t), with supports, and the books of what acts from outside.
   No bonds here. */
#ifndef SDR_MECHANICS_SYSTEM_H
#define SDR_MECHANICS_SYSTEM_H

#include "mechanics/loads.h"
#include "mechanics/model.h"
#include "mechanics/supports.h"

typedef struct {
  int32_t count;
  int components;
  double *u[3]; /* m, at the system's time */
  double *v[3]; /* m/s, at the system's time + velocity_offset (leapfrog keeps the half step's) */
  double *f[3]; /* N, total force = mass times acceleration, supports' reactions included */
  double *mass; /* kg */
  double time;  /* s */
  int64_t step;
  double velocity_offset; /* s; leapfrog: half the step after the first, else 0 */

  sdr_model *model;
  sdr_loads *loads;
  sdr_supports *supports;

  /* Sums since t = 0. */
  double external_work;      /* J, of loads and supports */
  double impulse[3];         /* N s, of loads and supports */
  double angular_impulse[3]; /* N m s, about the origin, current positions */
} sdr_system;

/* Energies and momenta of the present state, velocities brought to its time. */
typedef struct {
  double kinetic;
  sdr_energies model;
  double momentum[3], angular[3];       /* sum m v; sum m x cross v */
  double momentum_scale, angular_scale; /* sum m |v|; sum m |x| |v| */
} sdr_balance;

/* A system over the model's points: masses from `density` (kg/m^3 per material index). The system
   borrows model, loads and supports. u = v = 0, f unset. Owner: the caller. */
sdr_status sdr_system_create(sdr_model *model, const double *density, sdr_loads *loads,
                             sdr_supports *supports, sdr_system **out);
void sdr_system_destroy(sdr_system **system); /* NULL-safe */

void sdr_system_balance(sdr_system *system, sdr_balance *out);

/* The fields a scene may name (design sec. 4). components: how many values a point has. */
int sdr_field_known(const char *name);
int sdr_field_components(const char *name, int dimension_components);

/* Field `name` at the present state: out holds count values per component, component-major; SI.
   `fragment` and unknown names are SDR_BAD_INPUT (observers make the former). */
sdr_status sdr_system_field(sdr_system *system, const char *name, double *out);

#endif
