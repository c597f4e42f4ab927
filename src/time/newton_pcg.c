/* Truncated Newton on the energy of equilibrium.h: steps by conjugate gradients on the exact
   tangent, preconditioned by a factor of the secant stiffness that is renewed when it has grown
   stale; each step is searched along for a sufficient decrease of the energy (Armijo). So the
   energy falls always, also past a peak, where the norm of the residual does not. Where the tangent
   has a negative curvature, as it has while bonds soften, conjugate gradients say little: there the
   factor itself gives the steps, improved by what the last steps have shown (secant_pairs.h), at
   a quarter of the cost, until the residual has fallen by far. A solver that iterates has no
   such factor; then the iterate so far is the direction. */
#include "time/newton_pcg.h"

#include "base/memory.h"
#include "time/secant_pairs.h"
#include "time/static.h"

#include <math.h>
#include <string.h>
#include <time.h>

enum { MOST_STEPS = 120, MOST_DESCENTS = 300, OLD = 40, MOST_PRODUCTS = 400, MOST_HALVINGS = 40 };

struct sdr_newton {
  sdr_equilibrium *e;
  int32_t room; /* of the vectors over q */
  double *gradient, *step, *residual, *scaled, *direction, *product, *tried_gradient;
  double *q;     /* free components of the state */
  double *tried; /* an unknown: a state */
  sdr_secant_pairs *pairs;
  int64_t iterations; /* of the last direction */
  int descents;       /* by pairs, with this factor */
};

/* ---- making ---------------------------------------------------------------------------------- */

static void free_vectors(sdr_newton *n)
{
  sdr_free(n->gradient);
  sdr_free(n->step);
  sdr_free(n->residual);
  sdr_free(n->scaled);
  sdr_free(n->direction);
  sdr_free(n->product);
  sdr_free(n->tried_gradient);
  sdr_free(n->q);
  sdr_free(n->tried);
  sdr_secant_pairs_destroy(&n->pairs);
}

sdr_status sdr_newton_create(sdr_equilibrium *e, sdr_newton **out)
{
  sdr_newton *n = sdr_alloc(1, sizeof *n);
  if (!n) return SDR_RUN_FAILED;
  const size_t room = (size_t)e->implicit->unknowns;
  n->e = e;
  n->gradient = sdr_alloc(room, sizeof *n->gradient);
  n->step = sdr_alloc(room, sizeof *n->step);
  n->residual = sdr_alloc(room, sizeof *n->residual);
  n->scaled = sdr_alloc(room, sizeof *n->scaled);
  n->direction = sdr_alloc(room, sizeof *n->direction);
  n->product = sdr_alloc(room, sizeof *n->product);
  n->tried_gradient = sdr_alloc(room, sizeof *n->tried_gradient);
  n->q = sdr_alloc(room, sizeof *n->q);
  n->tried = sdr_alloc(room, sizeof *n->tried);
  const sdr_status paired = sdr_secant_pairs_create(e->implicit->unknowns, &n->pairs);
  if (paired == SDR_OK && n->gradient && n->step && n->residual && n->scaled && n->direction &&
      n->product && n->tried_gradient && n->q && n->tried)
    *out = n;
  else
    sdr_newton_destroy(&n);
  return n ? SDR_OK : SDR_RUN_FAILED;
}

void sdr_newton_destroy(sdr_newton **newton)
{
  if (!*newton) return;
  free_vectors(*newton);
  sdr_free(*newton);
  *newton = NULL;
}

static double seconds(void)
{
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- direction ------------------------------------------------------------------------------- */

static sdr_status renew_factor(sdr_newton *n, const double *u)
{
  const double from = seconds();
  SDR_TRY(sdr_equilibrium_factor(n->e, u));
  n->e->implicit->system->solve.factor_seconds += seconds() - from;
  n->iterations = n->descents = 0;
  return SDR_OK;
}

/* A factor is stale when the products that it costs take about a quarter as long as another: at
   1.5e10 flops a second of a factor, and 1e9 of solutions and products, which stream through their
   matrices. Counted, not timed, so that every run takes the same path. */
static int is_stale(const sdr_newton *n)
{
  const sdr_solver_report report = sdr_solver_report_of(n->e->solver);
  const double matrix = (double)n->e->matrix->row[n->e->matrix->rows];
  const double products = (4.0 * report.nonzeros + 2.0 * matrix) / 1e9;
  const double most = report.flops > 0.0 ? 0.25 * report.flops / 1.5e10 / products : 10.0;
  return (double)n->iterations > fmin(fmax(most, 8.0), 150.0) || n->descents > OLD;
}

/* K x = right to `share` of |right|, by conjugate gradients from 0; *curved = 1 if a direction of
   negative curvature came up: then x is the iterate so far, or that direction if it is the first.
 */
static sdr_status iterate(sdr_newton *n, const double *right, double share, double *x, int *curved)
{
  sdr_equilibrium *e = n->e;
  const int32_t count = e->implicit->free;
  const double target = share * sqrt(sdr_equilibrium_dot(e, right, right));
  double rho = 0.0;
  *curved = 0;
  n->iterations = 0;
  memset(x, 0, (size_t)count * sizeof *x);
  memcpy(n->residual, right, (size_t)count * sizeof *right);
  for (int k = 0; k < MOST_PRODUCTS; ++k) {
    const double before = rho;
    SDR_TRY(sdr_equilibrium_precondition(e, n->residual, n->scaled));
    rho = sdr_equilibrium_dot(e, n->residual, n->scaled);
    for (int32_t q = 0; q < count; ++q)
      n->direction[q] = n->scaled[q] + (k > 0 ? rho / before * n->direction[q] : 0.0);
    sdr_equilibrium_times(e, n->direction, n->product);
    const double curvature = sdr_equilibrium_dot(e, n->direction, n->product);
    ++n->iterations;
    if (!(curvature > 0.0)) {
      *curved = 1;
      if (k == 0) memcpy(x, n->direction, (size_t)count * sizeof *x);
      return SDR_OK;
    }
    const double alpha = rho / curvature;
    for (int32_t q = 0; q < count; ++q) {
      x[q] += alpha * n->direction[q];
      n->residual[q] -= alpha * n->product[q];
    }
    if (sqrt(sdr_equilibrium_dot(e, n->residual, n->residual)) <= target) return SDR_OK;
  }
  return SDR_OK;
}

static sdr_status find_direction(sdr_newton *n, const double *u, double share, int *curved)
{
  sdr_equilibrium *e = n->e;
  if (!e->factored || is_stale(n)) SDR_TRY(renew_factor(n, u));
  SDR_TRY(sdr_equilibrium_linearise(e, u, 0));
  for (int32_t q = 0; q < e->implicit->free; ++q) n->tried_gradient[q] = -n->gradient[q];
  return iterate(n, n->tried_gradient, share, n->step, curved);
}

static sdr_status precondition(void *equilibrium, const double *r, double *z)
{
  return sdr_equilibrium_precondition(equilibrium, r, z);
}

/* 1 if steps by pairs may be taken: the factor is of the whole matrix, so that its answers are good
   directions, and the step may go far. */
static int may_descend(const sdr_newton *n)
{
  const sdr_equilibrium *e = n->e;
  return !e->careful && !e->pull && e->factored &&
         strcmp(sdr_solver_report_of(e->solver).name, "pcg") != 0;
}

/* The next direction, and whether it is one of pairs. `curved_at`: the residual at which a negative
   curvature was last met; far below it Newton has another chance. */
static sdr_status next_direction(sdr_newton *n, const double *u, double share, double *curved_at,
                                 int *by_pairs, sdr_newton_report *report)
{
  int curved = 0;
  *by_pairs = may_descend(n) && report->residual > 0.1 * *curved_at;
  if (!*by_pairs) {
    SDR_TRY(find_direction(n, u, share, &curved));
    report->curved += curved;
    if (curved) *curved_at = report->residual;
    *by_pairs = curved && may_descend(n);
  }
  if (!*by_pairs) return SDR_OK;
  ++n->descents;
  ++report->descents;
  return sdr_secant_pairs_descend(n->pairs, n->gradient, precondition, n->e, n->step);
}

/* ---- search ---------------------------------------------------------------------------------- */

/* n->tried = the state alpha along the step. */
static void go_along(sdr_newton *n, double alpha)
{
  const int32_t count = n->e->implicit->free;
  for (int32_t q = 0; q < count; ++q) n->scaled[q] = n->q[q] + alpha * n->step[q];
  sdr_constraints_expand(&n->e->implicit->constraints, n->scaled, n->tried);
}

/* Energies too close to tell: the slope along the step must have fallen instead. */
static int slope_has_fallen(sdr_newton *n, double slope)
{
  sdr_equilibrium_gradient(n->e, n->tried, n->tried_gradient);
  return fabs(sdr_equilibrium_dot(n->e, n->tried_gradient, n->step)) <= 0.8 * fabs(slope);
}

/* Move u, whose energy is *energy (terms of *size), along the step; 0 if nowhere on it the energy
   is less. */
static int search(sdr_newton *n, double *u, double *energy, double *size)
{
  sdr_equilibrium *e = n->e;
  const double slope = sdr_equilibrium_dot(e, n->gradient, n->step);
  const double start = *energy, noise = 1e-13 * *size;
  double alpha = 1.0;
  if (!(slope < 0.0)) return 0;
  for (int k = 0; k < MOST_HALVINGS; ++k) {
    go_along(n, alpha);
    *energy = sdr_equilibrium_energy(e, n->tried, size);
    const double change = *energy - start;
    const int falls = change <= 1e-4 * alpha * slope && fabs(change) > noise;
    if (falls || (fabs(change) <= noise && slope_has_fallen(n, slope))) {
      memcpy(u, n->tried, (size_t)e->implicit->unknowns * sizeof *u);
      return 1;
    }
    const double best = -0.5 * alpha * slope / (change / alpha - slope); /* of a parabola */
    alpha = fmin(fmax(best > 0.0 ? best : 0.0, 0.1 * alpha), 0.5 * alpha);
  }
  return 0;
}

static void take_free(const sdr_implicit *implicit, const double *u, double *q)
{
  for (int32_t k = 0; k < implicit->free; ++k) q[k] = u[implicit->constraints.unknown[k]];
}

sdr_status sdr_newton_solve(sdr_newton *newton, double *u, sdr_newton_report *report)
{
  sdr_equilibrium *e = newton->e;
  double first = 0.0, curved_at = (double)INFINITY, size;
  double energy = sdr_equilibrium_energy(e, u, &size);
  *report = (sdr_newton_report){0};
  for (int k = 0; k <= MOST_STEPS + report->descents; ++k) {
    int by_pairs;
    take_free(e->implicit, u, newton->q);
    const double left = sdr_equilibrium_gradient(e, u, newton->gradient);
    if (k == 0) first = left;
    if (k == 0) sdr_secant_pairs_clear(newton->pairs, e->implicit->free);
    sdr_secant_pairs_note(newton->pairs, newton->q, newton->gradient);
    report->residual = left;
    report->converged = left <= sdr_equilibrium_tolerance(e);
    if (report->converged || k == MOST_STEPS + report->descents ||
        report->descents > MOST_DESCENTS || !isfinite(left))
      return SDR_OK;
    const double share =
        fmin(0.1, fmax(sqrt(left / first) * 0.3, 0.1 * sdr_equilibrium_tolerance(e) / left));
    SDR_TRY(next_direction(newton, u, fmin(share, 0.3), &curved_at, &by_pairs, report));
    ++report->steps;
    ++e->implicit->system->solve.newton;
    if (search(newton, u, &energy, &size)) continue;
    if (!by_pairs || sdr_secant_pairs_known(newton->pairs) == 0) return SDR_OK;
    sdr_secant_pairs_clear(newton->pairs, e->implicit->free);
    SDR_TRY(renew_factor(newton, u));
    energy = sdr_equilibrium_energy(e, u, &size);
  }
  return SDR_OK;
}

/* ---- first iterate --------------------------------------------------------------------------- */

/* K (u - before) = what is new outside, on the secant stiffness at `before`. */
sdr_status sdr_newton_predict(sdr_newton *newton, const double *before, double *u)
{
  sdr_equilibrium *e = newton->e;
  const sdr_implicit *implicit = e->implicit;
  int curved;
  take_free(implicit, before, newton->q);
  sdr_equilibrium_gradient(e, before, newton->gradient);
  SDR_TRY(e->factored ? SDR_OK : renew_factor(newton, before));
  SDR_TRY(sdr_equilibrium_linearise(e, before, 1));
  sdr_constraints_expand(&implicit->constraints, newton->q, u); /* held ones where they must be */
  for (int32_t r = 0; r < implicit->unknowns; ++r) newton->tried[r] = u[r] - before[r];
  sdr_csr_times(e->matrix, newton->tried, e->wide);
  for (int32_t r = 0; e->pull && r < implicit->unknowns; ++r)
    e->wide[r] += e->pull[r] * newton->tried[r];
  sdr_constraints_project(&implicit->constraints, e->wide, newton->tried_gradient);
  for (int32_t q = 0; q < implicit->free; ++q)
    newton->tried_gradient[q] = -newton->gradient[q] - newton->tried_gradient[q];
  SDR_TRY(iterate(newton, newton->tried_gradient, 1e-3, newton->step, &curved));
  for (int32_t q = 0; q < implicit->free; ++q) newton->q[q] += newton->step[q];
  sdr_constraints_expand(&implicit->constraints, newton->q, u);
  return SDR_OK;
}

/* ---- as a method of statics ------------------------------------------------------------------ */

static sdr_status create(sdr_equilibrium *e, void **state)
{
  sdr_newton *newton = NULL;
  SDR_TRY(sdr_newton_create(e, &newton));
  *state = newton;
  return SDR_OK;
}

static sdr_status solve(void *state, double *u, sdr_newton_report *report)
{
  return sdr_newton_solve(state, u, report);
}

static void destroy(void *state)
{
  sdr_newton *newton = state;
  sdr_newton_destroy(&newton);
}

const sdr_static_method sdr_static_newton = {
    .name = "newton", .create = create, .solve = solve, .destroy = destroy};
