/* What a directed bond answers, in double: force, tangent, energies and damage from its stretch s
   and the largest stretch k so far (theory sec. 4). One place for all of SDR_LAWS; the explicit
   kernels of variational and critical_stretch have the same formulas in their own, faster order.

     F(s, k) = C g(k) s  for s > 0,   C s  for s < 0
     e(s, k) = C |xi| (1/2 g s^2 + D(k))  for s > 0,   C |xi| (1/2 s^2 + D(k))  for s < 0
     dD/dk = -1/2 k^2 dg/dk, so that F = 1/|xi| de/ds on loading (k = s) too

   C and |xi| are left out: forces are over C, energies over C |xi|. Constants q and r of a law:

     none              g = 1
     variational       q = s_c^2: 1-d = q/(k^2 + q), g = (1-d)^2, D = 1/2 q d^2
     at1               q = s_c^2: 1-d = q/(2 k^2) beyond k^2 = q/2, else 1; g = (1-d)^2, D = 1/2 q d
     cohesive          q = s_e, not squared, r = B2 = gamma/(x_f - mu); x = k/q;
                       g = phi(x) = min(1, max(A1/x - B1, A2/x - B2, 0)), A2 = gamma + mu B2,
                       D = 1/2 q^2 [A1 (min(x, mu) - 1)+ + A2 (min(x, x_f) - mu)+], d = 1 -
   sqrt(phi) critical_stretch  g = 1; a bond lost for good (its flag says so) answers sdr_bond_lost
 */
#ifndef SDR_DAMAGE_BOND_LAW_H
#define SDR_DAMAGE_BOND_LAW_H

#include "damage/laws.h"

#include <math.h>

/* The two slopes of `cohesive`: the force falls to gamma of its peak at mu times its stretch. */
#define SDR_COHESIVE_GAMMA 0.5
#define SDR_COHESIVE_MU 1.25
#define SDR_COHESIVE_B1 ((1.0 - SDR_COHESIVE_GAMMA) / (SDR_COHESIVE_MU - 1.0))
#define SDR_COHESIVE_A1 (1.0 + SDR_COHESIVE_B1)
/* Least a = (s_c/s_e)^2: there x_f = mu, and the second slope is a drop. */
#define SDR_COHESIVE_LEAST (SDR_COHESIVE_MU + SDR_COHESIVE_GAMMA * (SDR_COHESIVE_MU - 1.0))

/* What the history k >= 0 has left. */
typedef struct {
  double left;       /* g */
  double slope;      /* dF/ds over C on loading, where s = k */
  double dissipated; /* D */
  double damage;     /* d, in [0, 1] */
} sdr_softening;

static inline sdr_softening sdr_softening_variational(double k, double q)
{
  const double kk = k * k, by = 1.0 / (kk + q), intact = q * by, damage = kk * by;
  const double left = intact * intact;
  return (sdr_softening){left, left * (1.0 - 4.0 * damage), 0.5 * q * damage * damage, damage};
}

static inline sdr_softening sdr_softening_at1(double k, double q)
{
  const double twice = 2.0 * k * k;
  const double intact = twice > q ? q / twice : 1.0, left = intact * intact;
  return (sdr_softening){left, twice > q ? -3.0 * left : 1.0, 0.5 * q * (1.0 - intact),
                         1.0 - intact};
}

static inline sdr_softening sdr_softening_cohesive(double k, double q, double r)
{
  const double mu = SDR_COHESIVE_MU, b1 = SDR_COHESIVE_B1, a1 = SDR_COHESIVE_A1;
  const double a2 = SDR_COHESIVE_GAMMA + mu * r, last = mu + SDR_COHESIVE_GAMMA / r;
  const double x = k / q, y = x > 1.0 ? 1.0 / x : 1.0;
  const double first = a1 * y - b1, second = a2 * y - r;
  const double soft = x < mu ? first : second, left = soft > 0.0 ? soft : 0.0;
  const double slope = x < 1.0 ? 1.0 : x < mu ? -b1 : x < last ? -r : 0.0;
  const double steep = (x < mu ? x : mu) - 1.0, flat = (x < last ? x : last) - mu;
  const double work = a1 * (steep > 0.0 ? steep : 0.0) + a2 * (flat > 0.0 ? flat : 0.0);
  return (sdr_softening){left, slope, 0.5 * q * q * work, 1.0 - sqrt(left)};
}

/* `law` is a sdr_law; a literal where speed matters. */
static inline sdr_softening sdr_softening_of(int law, double k, double q, double r)
{
  if (law == SDR_LAW_VARIATIONAL) return sdr_softening_variational(k, q);
  if (law == SDR_LAW_AT1) return sdr_softening_at1(k, q);
  if (law == SDR_LAW_COHESIVE) return sdr_softening_cohesive(k, q, r);
  return (sdr_softening){1.0, 1.0, 0.0, 0.0};
}

/* 1 if the law's history is a stretch, else flags. */
static inline int sdr_law_softens(int law)
{
  return law == SDR_LAW_VARIATIONAL || law == SDR_LAW_AT1 || law == SDR_LAW_COHESIVE;
}

/* A directed bond at stretch s. */
typedef struct {
  double force;              /* F over C */
  double slope;              /* dF/ds over C; at s = k that of loading */
  double stored, dissipated; /* over C |xi| */
  double damage;             /* d */
} sdr_bond_answer;

/* With history k, of which `loading` says whether the present stretch has made it. */
static inline sdr_bond_answer sdr_bond_law_at(int law, double s, double k, int loading, double q,
                                              double r)
{
  const sdr_softening soft = sdr_softening_of(law, k, q, r);
  const double left = s > 0.0 ? soft.left : 1.0;
  return (sdr_bond_answer){left * s, loading ? soft.slope : left, 0.5 * left * s * s,
                           soft.dissipated, soft.damage};
}

/* `before`: the history at the start of the step, >= 0; what it grows to is max(before, s). */
static inline sdr_bond_answer sdr_bond_law(int law, double s, double before, double q, double r)
{
  const int loading = s > 0.0 && s >= before;
  return sdr_bond_law_at(law, s, loading ? s : before, loading, q, r);
}

/* A bond cut at the start or lost: what it dissipated is booked elsewhere. */
static inline sdr_bond_answer sdr_bond_lost(void)
{
  return (sdr_bond_answer){0.0, 0.0, 0.0, 0.0, 1.0};
}

#endif
