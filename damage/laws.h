/* Damage laws of a bond, per directed bond and point-volume pair (theory sec. 4).
   s: stretch; k: its largest value so far; C: micromodulus (half), N/m^6; q: threshold, the square
   of s_c (variational) or s0 (critical stretch). A bond's elastic energy is 1/2 C |xi| s^2.

     none              f = C s
     variational       d = k^2/(k^2 + q), f = C (1-d)^2 s for s > 0, C s for s < 0;
                       stored 1/2 C |xi| (1-d)^2 s^2 (s > 0), dissipated 1/2 C |xi| q d^2;
                       q = s0^2 delta/ell: a separated surface takes Gc delta/ell
     critical_stretch  lost for good once s > sqrt(q), q = s0^2; its energy is dissipated then
     at1, cohesive     damage/bond_law.h

   Valid for any s > -1; l = 0 has no direction and no force. Source: 002 sec. 2.1 made consistent,
   000 eq. 37. */
#ifndef SDR_DAMAGE_LAWS_H
#define SDR_DAMAGE_LAWS_H

#include "scene/scene.h"

#include <stdint.h>

/* One line a law: its name in scenes and code, its enumerator. */
#define SDR_LAWS(X)                                                                                \
  X(none, SDR_LAW_NONE)                                                                            \
  X(variational, SDR_LAW_VARIATIONAL)                                                              \
  X(critical_stretch, SDR_LAW_CRITICAL_STRETCH)                                                    \
  X(at1, SDR_LAW_AT1)                                                                              \
  X(cohesive, SDR_LAW_COHESIVE)

/* Those with float kernels (precision: mixed). */
#define SDR_MIXED_LAWS(X) SDR_STATE_LAWS(X)

/* Those of state-based bodies. */
#define SDR_STATE_LAWS(X)                                                                          \
  X(none, SDR_LAW_NONE)                                                                            \
  X(variational, SDR_LAW_VARIATIONAL)                                                              \
  X(critical_stretch, SDR_LAW_CRITICAL_STRETCH)

#define SDR_COUNT_LAW(name, code) SDR_COUNTED_##name,
enum { SDR_LAWS(SDR_COUNT_LAW) SDR_LAW_COUNT };

#define SDR_LAW_NAME(name, code) [code] = #name,
/* Their names in scenes, by enumerator; NULL at the end. */
#define SDR_LAW_NAMES                                                                              \
  {                                                                                                \
    SDR_LAWS(SDR_LAW_NAME) NULL                                                                    \
  }

/* Instead of a largest stretch: a pair cut at the start carries nothing, a protected one never
   softens. */
#define SDR_STRETCH_CUT (-1.0f)
#define SDR_STRETCH_PROTECTED (-2.0f)

/* Flags of a pair, as wide as the numbers beside them so that loops over both vectorise. A half is
 * a directed bond; `fresh` marks a loss that is not booked yet. */
enum {
  SDR_LOST_I = 1, /* i -> j */
  SDR_LOST_J = 2, /* j -> i */
  SDR_FRESH_I = 4,
  SDR_FRESH_J = 8,
  SDR_CUT = 16, /* at the start; then both halves are lost too */
  SDR_PROTECTED = 32
};

typedef int32_t sdr_flags;

/* (1-d) of the variational law; kk = k^2. */
static inline double sdr_variational_intact(double kk, double q)
{
  return q / (kk + q);
}

/* d(C (1-d)^2 s)/ds over C on loading, s = k > 0: (1-d)^2 (1-4d). */
static inline double sdr_variational_tangent(double kk, double q)
{
  const double intact = sdr_variational_intact(kk, q);
  return intact * intact * (1.0 - 4.0 * (1.0 - intact));
}

/* 1 if the stretch s breaks a directed bond of the critical-stretch law. */
static inline int sdr_critical_breaks(double s, double q)
{
  return s > 0.0 && s * s > q;
}

/* Damage of a directed bond from its pair's history. `lost`: SDR_LOST_I or SDR_LOST_J. */
static inline double sdr_variational_damage(float stretch, double q)
{
  if (stretch == SDR_STRETCH_CUT) return 1.0;
  if (stretch < 0.0f) return 0.0;
  const double kk = (double)stretch * (double)stretch;
  return kk / (kk + q);
}

static inline double sdr_flag_damage(sdr_flags flags, int lost)
{
  return flags & lost ? 1.0 : 0.0;
}

#endif
