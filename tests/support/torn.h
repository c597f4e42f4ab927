/* Bodies with critical stretch torn to pieces at the step that a scene gets by itself. */
#ifndef SDR_TESTS_TORN_H
#define SDR_TESTS_TORN_H

#include "support/still_body.h"
#include "time/integrator.h"
#include "time/stable_step.h"

typedef struct {
  double imbalance; /* largest, over the energy at the start */
  double fall;      /* of the dissipated energy in a step, largest, J */
  double limit;     /* least stable step of what was left, over the first */
  double taken;     /* dissipated over the energy at the start */
  double broken;    /* share of the directed bonds */
} torn;

/* Every point starts at `rate` (1/s) times its position, but for a random share `spread` of it. */
static inline void torn_start(sdr_system *system, double rate, double spread)
{
  const sdr_points *points = system->model->points;
  uint64_t seed = 5;
  for (int32_t i = 0; i < points->count; ++i)
    for (int a = 0; a < points->components; ++a)
      system->v[a][i] = rate * points->x[a][i] * (1.0 + spread * noise(&seed));
}

/* With the kinetic energy that leapfrog keeps, 1/2 m v(n - 1/2) v(n + 1/2). */
static inline double torn_energy(sdr_system *system, double dt, sdr_balance *balance)
{
  double kinetic = 0.0;
  for (int a = 0; a < system->components; ++a)
    for (int32_t i = 0; i < system->count; ++i) {
      const double v = system->v[a][i];
      kinetic += 0.5 * v * (system->mass[i] * v + dt * system->f[a][i]);
    }
  sdr_system_balance(system, balance);
  return kinetic + balance->model.stored + balance->model.dissipated;
}

/* Takes the body over. */
static inline torn tear(body b, double rate, double spread, int steps)
{
  still_body s;
  sdr_balance balance;
  torn out = {.limit = 1.0};
  double limit, left, taken = 0.0;
  still_of(b, &s);
  torn_start(s.system, rate, spread);
  assert_int_equal(sdr_stable_step(s.system, &limit), SDR_OK);
  assert_int_equal(sdr_leapfrog.start(s.system, 0.9 * limit), SDR_OK);
  const double start = torn_energy(s.system, 0.9 * limit, &balance);
  for (int n = 1; n <= steps; ++n) {
    if (sdr_leapfrog.step(s.system, 0.9 * limit) != SDR_OK) fail_msg("%s", sdr_error_message());
    out.imbalance =
        fmax(out.imbalance, fabs(torn_energy(s.system, 0.9 * limit, &balance) - start) / start);
    out.fall = fmax(out.fall, taken - balance.model.dissipated);
    taken = balance.model.dissipated;
    if (n % (steps / 5) != 0) continue;
    assert_int_equal(sdr_stable_step(s.system, &left), SDR_OK);
    out.limit = fmin(out.limit, left / limit);
  }
  out.taken = taken / start;
  out.broken = (double)balance.model.broken / (double)s.body.bonds->directed;
  print_message("imbalance %.2e, dissipated %.3f, least limit %.3f, broken %.3f\n", out.imbalance,
                out.taken, out.limit, out.broken);
  still_destroy(&s);
  return out;
}

/* Lose bonds at random displacements, a few times: no point may store more than before, and what
   all store less is booked. Takes the body over. */
static inline void lose_at_random(body b, double amplitude)
{
  const sdr_points *points = b.points;
  const size_t count = (size_t)points->count;
  double *u[3], *before = sdr_alloc(count, sizeof *before),
                *after = sdr_alloc(count, sizeof *after);
  int64_t broken = 0;
  vector_create(points, u);
  for (int round = 1; round <= 4; ++round) {
    sdr_energies had, has;
    vector_noise(points, round * amplitude, (uint64_t)round, u);
    assert_int_equal(b.model->ops->field(b.model, u, SDR_FIELD_ENERGY_DENSITY, before), SDR_OK);
    b.model->ops->energies(b.model, u, &had);
    b.model->ops->commit(b.model, u);
    b.model->ops->energies(b.model, u, &has);
    assert_int_equal(b.model->ops->field(b.model, u, SDR_FIELD_ENERGY_DENSITY, after), SDR_OK);
    for (size_t i = 0; i < count; ++i)
      assert_at_most(after[i], before[i] + 1e-12 * had.stored / points->volume[i]);
    assert_near(has.dissipated - had.dissipated, had.stored - has.stored, 1e-12 * had.stored);
    assert_true(has.broken > broken);
    broken = has.broken;
  }
  assert_true((double)broken < 0.9 * (double)b.bonds->directed);
  vector_destroy(u);
  sdr_free(before);
  sdr_free(after);
  body_destroy(&b);
}

#endif
