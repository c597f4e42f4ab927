/* Constants of a bond-based body's points from its materials and families (theory sec. 3-4). */
#include "base/memory.h"
#include "damage/strength.h"
#include "mechanics/bond_internal.h"
#include "nom/own_share.h"

#include <math.h>

/* beta of the law cohesive by kind of family: it costs a path of stretching to know. Full stencils
   of equally many neighbours have one, and so have all families of irregular points. */
enum { BETAS = 64 };
typedef struct {
  int count;
  int neighbours[BETAS]; /* -1: irregular */
  double beta[BETAS];
} betas;

typedef struct {
  const sdr_points *points;
  const sdr_families *families;
  const sdr_bond_based_how *how;
  betas known;
} constants_call;

typedef struct {
  double c, q, r;
} constants;

static sdr_status beta_of(constants_call *call, const sdr_family *family, double c, double young,
                          double *beta)
{
  betas *known = &call->known;
  const int neighbours = family->source == SDR_MOMENTS_STENCIL ? family->neighbours : -1;
  for (int k = 0; k < known->count; ++k)
    if (known->neighbours[k] == neighbours) {
      *beta = known->beta[k];
      return SDR_OK;
    }
  SDR_TRY(sdr_cohesive_beta(call->families, family, c, young, beta));
  if (known->count == BETAS) return SDR_OK;
  known->neighbours[known->count] = neighbours;
  known->beta[known->count++] = *beta;
  return SDR_OK;
}

static sdr_status constants_of(constants_call *call, int32_t i, constants *out)
{
  const sdr_bond_based_how *how = call->how;
  const sdr_family *family = sdr_family_of(call->families, i);
  const double young = how->young[i], horizon = call->points->horizon[i];
  const uint8_t material = call->points->material[i];
  *out = (constants){sdr_micromodulus(how->dimension, how->calibration, family, young), 1.0, 1.0};
  if (how->law == SDR_LAW_NONE) return SDR_OK;
  out->q = sdr_critical_stretch_squared(how->dimension, how->calibration, family, young,
                                        how->toughness[material]);
  if (how->law == SDR_LAW_COHESIVE) {
    double beta;
    SDR_TRY(beta_of(call, family, out->c, young, &beta));
    return sdr_cohesive_constants(horizon, young, out->q, how->strength[material], beta, &out->q,
                                  &out->r);
  }
  if (!sdr_law_softens((int)how->law)) return SDR_OK;
  const double ell = how->ell.relative ? how->ell.value * horizon : how->ell.value;
  out->q *= horizon / ell;
  return SDR_OK;
}

static sdr_status set_each(constants_call *call, sdr_bond_body *body)
{
  const size_t padded = sdr_points_padded(call->points);
  const int second = call->how->law == SDR_LAW_COHESIVE;
  body->stiffness_at = sdr_alloc(padded, sizeof(double));
  body->threshold_at = sdr_alloc(padded, sizeof(double));
  if (second) body->decline_at = sdr_alloc(padded, sizeof(double));
  if (!body->stiffness_at || !body->threshold_at || (second && !body->decline_at))
    return SDR_RUN_FAILED;
  for (int32_t i = 0; i < call->points->count; ++i) {
    constants at;
    SDR_TRY(constants_of(call, i, &at));
    body->stiffness_at[i] = at.c;
    body->threshold_at[i] = at.q;
    if (second) body->decline_at[i] = at.r;
  }
  for (size_t i = (size_t)call->points->count; i < padded; ++i) {
    body->threshold_at[i] = 1.0; /* padding is divided by */
    if (second) body->decline_at[i] = 1.0;
  }
  return SDR_OK;
}

/* Bring each family's energy of dilation to its `share` (theory sec. 14). Where it is that already
   but for rounding, nothing changes. */
static sdr_status keep_shares(const constants_call *call, sdr_bond_body *body)
{
  const double *share = call->how->share;
  double *own = sdr_alloc((size_t)call->points->count, sizeof *own);
  if (!own) return SDR_RUN_FAILED;
  sdr_own_shares(body->bonds, call->families, own);
  for (int32_t i = 0; i < call->points->count; ++i)
    if (own[i] > 0.0 && fabs(share[i] / own[i] - 1.0) > 1e-12)
      body->stiffness_at[i] *= share[i] / own[i];
  sdr_free(own);
  return SDR_OK;
}

sdr_status sdr_bond_set_constants(sdr_bond_body *body, const sdr_families *families,
                                  const sdr_bond_based_how *how)
{
  constants_call call = {.points = body->points, .families = families, .how = how};
  constants first;
  if (how->share) {
    SDR_TRY(set_each(&call, body));
    return keep_shares(&call, body);
  }
  SDR_TRY(constants_of(&call, 0, &first));
  body->stiffness = first.c;
  body->threshold = first.q;
  body->decline = first.r;
  for (int32_t i = 1; i < body->points->count; ++i) {
    constants at;
    SDR_TRY(constants_of(&call, i, &at));
    if (at.c != first.c || at.q != first.q || at.r != first.r) return set_each(&call, body);
  }
  return SDR_OK;
}
