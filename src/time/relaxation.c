/* Adaptive dynamic relaxation (Kilic and Madenci 2010, in 004 as ref. 48): a cross-check of Newton
   that needs forces only. The free components move in steps of 1 under fictitious masses, a quarter
   of the sums of |K| along each row and so stable, damped by what the stiffness along the present
   way makes critical,

     c = 2 sqrt(sum q^2 k / sum q^2),   k = -(change of force)/(M velocity) where that is positive.
 */
#include "time/static.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

enum { MOST_STEPS = 200000 };

typedef struct {
  sdr_equilibrium *e;
  double *mass, *gradient, *before, *velocity, *q, *start;
} relaxation;

static void destroy(void *state)
{
  relaxation *r = state;
  sdr_free(r->mass);
  sdr_free(r->gradient);
  sdr_free(r->before);
  sdr_free(r->velocity);
  sdr_free(r->q);
  sdr_free(r->start);
  sdr_free(r);
}

static sdr_status create(sdr_equilibrium *e, void **state)
{
  relaxation *r = sdr_alloc(1, sizeof *r);
  if (!r) return SDR_RUN_FAILED;
  const size_t room = (size_t)e->implicit->unknowns;
  double **const arrays[] = {&r->mass, &r->gradient, &r->before, &r->velocity, &r->q, &r->start};
  r->e = e;
  *state = r;
  for (size_t k = 0; k < sizeof arrays / sizeof *arrays; ++k)
    if (!(*arrays[k] = sdr_alloc(room, sizeof(double)))) return SDR_RUN_FAILED;
  return SDR_OK;
}

/* P^T of the rows' sums of |K| at rest, through |B|: no row of P^T K B sums to more. */
static sdr_status set_masses(relaxation *r)
{
  sdr_equilibrium *e = r->e;
  const sdr_constraints *c = &e->implicit->constraints;
  SDR_TRY(sdr_tangent_update(e->tangent, NULL, e->still));
  const sdr_csr *k = sdr_tangent_matrix(e->tangent);
  memset(r->mass, 0, (size_t)c->free * sizeof *r->mass);
  for (int32_t i = 0; i < k->rows; ++i) {
    double sum = 0.0;
    for (int64_t p = k->row[i]; p < k->row[i + 1]; ++p) {
      double through = 0.0;
      for (int64_t b = c->map.row[k->column[p]]; b < c->map.row[k->column[p] + 1]; ++b)
        through += fabs(c->map.value[b]);
      sum += fabs(k->value[p]) * through;
    }
    for (int64_t b = c->map.row[i]; b < c->map.row[i + 1]; ++b)
      r->mass[c->map.column[b]] += 0.3 * sum * fabs(c->map.value[b]); /* over 1/4: forces stiffen */
  }
  return SDR_OK;
}

static double damping(const relaxation *r, int32_t count)
{
  double above = 0.0, below = 0.0;
  for (int32_t k = 0; k < count; ++k) {
    const double moved = r->q[k] - r->start[k], square = moved * moved;
    const double stiffness = r->velocity[k] != 0.0
                                 ? (r->gradient[k] - r->before[k]) / (r->mass[k] * r->velocity[k])
                                 : 0.0;
    if (stiffness > 0.0) above += square * stiffness;
    below += square;
  }
  return below > 0.0 && above > 0.0 ? fmin(2.0 * sqrt(above / below), 1.9) : 0.0;
}

static void advance(relaxation *r, double c, int first)
{
  const int32_t count = r->e->implicit->free;
  for (int32_t k = 0; k < count; ++k) {
    const double push = -r->gradient[k] / r->mass[k];
    r->velocity[k] = first ? 0.5 * push : ((2.0 - c) * r->velocity[k] + 2.0 * push) / (2.0 + c);
    r->q[k] += r->velocity[k];
  }
}

static sdr_status solve(void *state, double *u, sdr_newton_report *report)
{
  relaxation *r = state;
  sdr_equilibrium *e = r->e;
  const sdr_implicit *implicit = e->implicit;
  const size_t bytes = (size_t)implicit->free * sizeof *r->q;
  *report = (sdr_newton_report){0};
  SDR_TRY(set_masses(r));
  for (int32_t k = 0; k < implicit->free; ++k)
    r->q[k] = r->start[k] = u[implicit->constraints.unknown[k]];
  memset(r->velocity, 0, bytes);
  for (int k = 0; k < MOST_STEPS; ++k) {
    memcpy(r->before, r->gradient, bytes);
    report->residual = sdr_equilibrium_gradient(e, u, r->gradient);
    report->converged = report->residual <= sdr_equilibrium_tolerance(e);
    if (report->converged || !isfinite(report->residual)) return SDR_OK;
    advance(r, k > 0 ? damping(r, implicit->free) : 0.0, k == 0);
    sdr_constraints_expand(&implicit->constraints, r->q, u);
    ++report->steps;
    ++e->implicit->system->solve.iterations;
  }
  return SDR_OK;
}

const sdr_static_method sdr_static_relaxation = {
    .name = "relaxation", .create = create, .solve = solve, .destroy = destroy};
