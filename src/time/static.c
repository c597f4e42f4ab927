/* Nonlinear statics: equilibria of the energy of equilibrium.h, increment by increment (theory sec.
   7). Each starts from the last one; an increment that finds none, or whose energy does not balance
   the work done, is cut; when it cannot be cut any more the body moves to its next equilibrium
   (static_motion.c). Damage is committed once an increment is accepted. With critical stretch,
   which has no energy to minimise, bonds are kept while equilibrium is sought; then the most
   overstretched break, until none is. */
#include "time/static.h"

#include "base/memory.h"
#include "geometry/text.h"
#include "time/integrator.h"
#include "time/rigid.h"

#include <math.h>
#include <string.h>

static const sdr_static_method *const methods[] = {&sdr_static_newton, &sdr_static_relaxation,
                                                   &sdr_static_kinsol};

/* Of the largest energy so far: more than this is not balanced by an increment that found the
   equilibrium next to the last. */
static const double most_excess = 1e-3;
/* ... or of what the increment adds itself, so that these misses add up to no more of the whole. */
static const double most_share = 5e-3;
/* Likewise: so much may be set free when an equilibrium ceases to exist and the next one is found.
 */
static const double most_release = 2e-2;
/* Of the first length: shorter increments move the body instead. */
static const double least_length = 1.0 / 256.0;

/* ---- work ------------------------------------------------------------------------------------ */

static void end_work(void *given)
{
  sdr_static_work *w = given;
  if (!w) return;
  if (w->state) w->method->destroy(w->state);
  sdr_newton_destroy(&w->newton);
  sdr_equilibrium_destroy(&w->equilibrium);
  sdr_implicit_destroy(&w->implicit);
  sdr_free(w->u);
  sdr_free(w->tried);
  sdr_free(w->before);
  sdr_free(w->now);
  sdr_free(w->way);
  sdr_free(w->load);
  sdr_free(w);
}

static sdr_status allocate(sdr_static_work *w)
{
  const size_t unknowns = (size_t)w->implicit->unknowns;
  double **const arrays[] = {&w->u, &w->tried, &w->before, &w->now, &w->way, &w->load};
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; ++k)
    if (!(*arrays[k] = sdr_alloc(unknowns, sizeof(double)))) return SDR_RUN_FAILED;
  return SDR_OK;
}

/* A name of a linear solver means Newton with it. */
static const sdr_static_method *find_method(const char *name)
{
  for (size_t k = 0; k < sizeof methods / sizeof *methods; ++k)
    if (strcmp(methods[k]->name, name) == 0) return methods[k];
  return methods[0];
}

static sdr_status check_held(const sdr_system *system, const sdr_implicit *implicit)
{
  if (!implicit->constraints.symmetric)
    return sdr_fail(SDR_BAD_INPUT,
                    "time.linear: fictitious layers have a linear static solution only; take "
                    "time.linear: true, or supports in place of layers");
  if (system->layers || implicit->slaves.count > 0) return SDR_OK;
  return sdr_rigid_held(system->model->points, implicit->constraints.prescribed);
}

static sdr_status make_work(sdr_system *system, sdr_static_work *w)
{
  const char *solver = system->how && system->how->solver[0] ? system->how->solver : "auto";
  w->method = find_method(solver);
  const int linear = w->method == methods[0];
  SDR_TRY(sdr_implicit_create(system, &w->implicit));
  SDR_TRY(check_held(system, w->implicit));
  SDR_TRY(allocate(w));
  SDR_TRY(sdr_equilibrium_create(w->implicit, linear ? solver : "auto", &w->equilibrium));
  SDR_TRY(sdr_newton_create(w->equilibrium, &w->newton));
  return w->method->create(w->equilibrium, &w->state);
}

static sdr_status held(sdr_system *system, double dt)
{
  sdr_implicit *implicit = NULL;
  (void)dt;
  SDR_TRY(sdr_implicit_create(system, &implicit));
  const sdr_status status = check_held(system, implicit);
  sdr_implicit_destroy(&implicit);
  return status;
}

/* The system's u is an equilibrium: what acts there, and its energy. */
static void look_at_present(sdr_static_work *w)
{
  sdr_system *system = w->implicit->system;
  sdr_energies energies;
  sdr_implicit_gather(w->implicit, system->u, w->u);
  sdr_implicit_force(w->implicit, w->u, w->equilibrium->internal);
  sdr_implicit_outside(w->implicit, w->equilibrium->internal, NULL, w->before);
  memcpy(w->load, w->implicit->load, (size_t)w->implicit->unknowns * sizeof *w->load);
  system->model->ops->energies(system->model, system->u, &energies);
  w->energy = energies.stored + energies.dissipated;
  w->largest = fmax(w->largest, w->energy);
  for (int a = 0; a < system->components; ++a)
    memset(system->f[a], 0, (size_t)system->count * sizeof(double));
}

static sdr_status restart(sdr_system *system, double dt)
{
  sdr_static_work *w = sdr_alloc(1, sizeof *w);
  if (!w) return SDR_RUN_FAILED;
  if (system->work) system->end_work(system->work);
  system->work = NULL;
  w->length = w->longest = dt;
  const sdr_status status = make_work(system, w);
  if (status != SDR_OK) {
    end_work(w);
    return status;
  }
  system->work = w;
  system->end_work = end_work;
  look_at_present(w);
  return SDR_OK;
}

/* ---- one equilibrium ------------------------------------------------------------------------- */

void sdr_static_take(sdr_static_work *w, const double *total, double dt)
{
  sdr_implicit *implicit = w->implicit;
  const size_t bytes = (size_t)implicit->unknowns * sizeof *w->u;
  sdr_implicit_force(implicit, w->tried, w->equilibrium->internal);
  sdr_implicit_outside(implicit, w->equilibrium->internal, total, w->now);
  for (int32_t r = 0; r < implicit->unknowns; ++r) {
    w->way[r] = w->tried[r] - w->u[r];
    if (!implicit->held[r]) w->before[r] = w->load[r]; /* also where a support has let go */
  }
  sdr_implicit_book(implicit, w->way, w->before, w->now, dt);
  memcpy(w->u, w->tried, bytes);
  look_at_present(w);
  memcpy(w->before, w->now, bytes);
}

double sdr_static_excess(sdr_static_work *w, const double *total)
{
  sdr_implicit *implicit = w->implicit;
  sdr_system *system = implicit->system;
  sdr_energies energies;
  double work = 0.0;
  sdr_implicit_force(implicit, w->tried, w->equilibrium->internal);
  sdr_implicit_outside(implicit, w->equilibrium->internal, total, w->now);
  for (int32_t r = 0; r < implicit->unknowns; ++r) {
    const double before = implicit->held[r] ? w->before[r] : w->load[r];
    work += 0.5 * (before + w->now[r]) * (w->tried[r] - w->u[r]);
  }
  system->model->ops->energies(system->model, system->u, &energies);
  w->reached = energies.stored + energies.dissipated;
  return w->reached - w->energy - work;
}

/* Break what critical stretch has overstretched, and find the equilibrium of what is left, until
   nothing breaks. What the energy falls by is what damped motion would take. */
static sdr_status break_bonds(sdr_static_work *w, int *found)
{
  sdr_system *system = w->implicit->system;
  sdr_newton_report report;
  double size;
  *found = 1;
  if (!system->model->ops->break_most) return SDR_OK;
  while (system->model->ops->break_most(system->model, system->u, 0.98) > 0) {
    const double before = sdr_equilibrium_energy(w->equilibrium, w->u, &size);
    memcpy(w->tried, w->u, (size_t)w->implicit->unknowns * sizeof *w->u);
    w->equilibrium->factored = 0;
    SDR_TRY(w->method->solve(w->state, w->tried, &report));
    if (!report.converged) {
      *found = 0;
      return SDR_OK;
    }
    system->viscous += before - sdr_equilibrium_energy(w->equilibrium, w->tried, &size);
    sdr_static_take(w, NULL, 0.0);
  }
  return SDR_OK;
}

/* What was found at `time`. */
typedef enum { NOTHING, ELSEWHERE, NEXT } finding;

/* The equilibrium of the present constraints and loads into w->tried. */
static sdr_status look_for(sdr_static_work *w, int careful, sdr_newton_report *report,
                           finding *found)
{
  w->equilibrium->careful = careful;
  if (careful) w->equilibrium->factored = 0; /* a stale one makes steps that go astray */
  SDR_TRY(sdr_newton_predict(w->newton, w->u, w->tried));
  SDR_TRY(w->method->solve(w->state, w->tried, report));
  *found = NOTHING;
  if (!report->converged) return SDR_OK;
  w->excess = sdr_static_excess(w, NULL);
  const double most =
      fmax(most_excess * fmax(w->largest, w->reached), most_share * fabs(w->reached - w->energy));
  *found = fabs(w->excess) <= most ? NEXT : ELSEWHERE;
  return SDR_OK;
}

/* The equilibrium at `time` into w->tried: the next to the last one, or one whose energy does not
   balance the work on the way there. Fast steps first; where these lead elsewhere, careful ones. */
static sdr_status attempt(sdr_static_work *w, double time, sdr_newton_report *report,
                          finding *found)
{
  int renumbered;
  SDR_TRY(sdr_implicit_move(w->implicit, time, &renumbered));
  if (renumbered) sdr_equilibrium_renumber(w->equilibrium);
  SDR_TRY(look_for(w, 0, report, found));
  if (*found == NEXT || report->descents == 0) return SDR_OK;
  const sdr_status status = look_for(w, 1, report, found);
  w->equilibrium->careful = 0;
  return status;
}

/* ---- increments ------------------------------------------------------------------------------ */

/* Where nothing was found: the point that is worst off, and what to do. */
static sdr_status stop(sdr_static_work *w, double time)
{
  const sdr_system *system = w->implicit->system;
  const sdr_points *points = system->model->points;
  const int m = system->components;
  int32_t worst = 0;
  double x[3] = {0.0}, most = -1.0;
  char text[SDR_PLACE_TEXT];
  sdr_implicit_force(w->implicit, w->tried, w->now);
  for (int32_t i = 0; i < system->count; ++i) {
    double squared = 0.0;
    for (int a = 0; a < m; ++a) {
      const int32_t r = i * m + a;
      const double left = w->implicit->held[r] ? 0.0 : w->now[r] + w->implicit->load[r];
      squared += left * left;
    }
    if (!(squared > most)) continue;
    most = squared;
    worst = i;
  }
  for (int a = 0; a < m; ++a) x[a] = points->x[a][worst];
  return sdr_fail(
      SDR_RUN_FAILED,
      "no equilibrium was found at t = %.6g s, after %lld increments: the point at %s is "
      "left with a force of %.3g N; prescribe displacements (or their mean) in place of "
      "loads that nothing can carry any more, end the run before, or take a smaller "
      "time.step",
      time, (long long)system->step, sdr_place_text(x, m, text), sqrt(most));
}

static void finish(sdr_static_work *w, double time)
{
  sdr_system *system = w->implicit->system;
  system->model->ops->commit(system->model, system->u);
  look_at_present(w);
  sdr_implicit_accept(w->implicit);
  system->time = time;
  ++system->step;
  ++system->solve.accepted;
}

/* Take the equilibrium found: what its energy is short of is what a damped motion would have lost
   on the way. */
static void release(sdr_static_work *w, double dt)
{
  w->implicit->system->viscous -= w->excess;
  sdr_static_take(w, NULL, dt);
}

/* Statics has no answer: the body moves there. */
static sdr_status move(sdr_static_work *w, double time, finding found)
{
  sdr_system *system = w->implicit->system;
  sdr_newton_report report;
  int rested;
  if (found == ELSEWHERE && w->excess < 0.0 && -w->excess < most_release * w->largest) {
    release(w, time - system->time);
    return SDR_OK;
  }
  ++system->solve.fallbacks;
  SDR_TRY(sdr_static_move(w, &rested));
  if (rested) return SDR_OK;
  SDR_TRY(attempt(w, time, &report, &found)); /* from where motion has got stuck */
  if (found == NOTHING || w->excess > 0.0) return stop(w, time);
  release(w, 0.0);
  return SDR_OK;
}

static void say_what_was_solved(sdr_static_work *w)
{
  sdr_solve_record *record = &w->implicit->system->solve;
  const sdr_solver_report report = sdr_solver_report_of(w->equilibrium->solver);
  record->name = w->method == methods[0] ? report.name : w->method->name;
  record->unknowns = w->implicit->free;
  record->nonzeros = sdr_tangent_matrix(w->equilibrium->tangent)->row[w->implicit->unknowns];
  record->bytes = fmax(record->bytes, report.bytes);
}

static double next_time(const sdr_static_work *w)
{
  const sdr_system *system = w->implicit->system;
  const double event = sdr_implicit_next_event(w->implicit, system->time);
  const double end = system->how ? fmin(event, system->how->end) : event;
  const double next = system->time + w->length;
  return next > end - 1e-6 * w->length ? end : next;
}

/* The last equilibrium stands; the run ends with it. */
static sdr_status collapse(sdr_system *system)
{
  const sdr_static_work *w = system->work;
  sdr_implicit_scatter(w->implicit, w->u, system->u);
  for (int a = 0; a < system->components; ++a)
    memset(system->f[a], 0, (size_t)system->count * sizeof(double));
  system->over = 1;
  return SDR_OK;
}

static sdr_status step(sdr_system *system, double dt)
{
  sdr_static_work *w = system->work;
  sdr_newton_report report = {0};
  finding found = NOTHING;
  int cut = 0, balanced = 1;
  w->longest = dt;
  double time = next_time(w);
  SDR_TRY(attempt(w, time, &report, &found));
  while (found != NEXT && time - system->time > 2.0 * least_length * dt) {
    time = system->time + 0.5 * (time - system->time);
    cut = 1;
    ++system->solve.cuts;
    SDR_TRY(attempt(w, time, &report, &found));
  }
  if (found == NOTHING && system->how && system->how->ends_at_collapse) return collapse(system);
  if (found == NEXT)
    sdr_static_take(w, NULL, time - system->time);
  else
    SDR_TRY(move(w, time, found));
  SDR_TRY(break_bonds(w, &balanced));
  if (!balanced && system->how && system->how->ends_at_collapse) return collapse(system);
  if (!balanced) SDR_TRY(move(w, time, NOTHING));
  if (cut) w->length = time - system->time;
  if (!cut) w->length = fmin(2.0 * w->length, dt);
  finish(w, time);
  say_what_was_solved(w);
  return SDR_OK;
}

/* Loads and supports that act from t = 0 on: the first equilibrium, from which energies count. */
static sdr_status start(sdr_system *system, double dt)
{
  for (int a = 0; a < system->components; ++a) {
    const size_t bytes = (size_t)system->count * sizeof(double);
    memset(system->u[a], 0, bytes);
    memset(system->v[a], 0, bytes);
  }
  system->velocity_offset = 0.0;
  SDR_TRY(restart(system, dt));
  sdr_static_work *w = system->work;
  sdr_newton_report report;
  SDR_TRY(sdr_newton_predict(w->newton, w->u, w->tried));
  SDR_TRY(w->method->solve(w->state, w->tried, &report));
  if (!report.converged) return stop(w, 0.0);
  sdr_implicit_scatter(w->implicit, w->tried, system->u);
  system->model->ops->commit(system->model, system->u);
  look_at_present(w);
  sdr_implicit_accept(w->implicit);
  say_what_was_solved(w);
  return SDR_OK;
}

const sdr_integrator sdr_static = {.name = "static",
                                   .doc = "equilibria under loads and supports that change slowly",
                                   .start = start,
                                   .held = held,
                                   .step = step,
                                   .restart = restart,
                                   .chooses = 1,
                                   .is_static = 1};
