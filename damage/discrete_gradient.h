/* The mean force of a directed bond over a step from stretch s0 to s1, such that its work is
   exactly what the bond's energy, dissipated included, grows by (theory sec. 7). In terms of E(s) =
   2 e(s)/(C |xi|), k the largest stretch before the step:

     mean = (E(s1) - E(s0))/(s1 - s0),   slope = d mean/d s1

   without cancellation: [s0, s1] is cut where E changes its form (s = 0, s = k, and the kinks of a
   law's envelope). On a piece from a to b

     straight          E' = 2 (alpha + beta s):   D(a, b) = 2 alpha + beta (a + b)
       compression alpha = 0, beta = 1; unloading alpha = 0, beta = g(k); at1 below its onset and
       cohesive below its strength likewise 0, 1; the slopes of cohesive A q, -B; broken 0, 0
     variational       E = q s^2/(s^2 + q):       D = q^2 (a + b)/((a^2 + q)(b^2 + q))
     at1 beyond onset  E = q - q^2/(4 s^2):       D = q^2 (a + b)/(4 a^2 b^2)

   and mean is the average of the pieces' D by their lengths. With T(a, b) = dD/db the derivative
   needs the difference of D on neighbouring pieces a..c, c..b: since the force is continuous at c
   it is (b - c) T(b, c) + (c - a) T(a, c), small steps or not. At s1 = s0 = k loading is taken,
   at s1 = s0 = 0 compression.
   Constants q, r as in damage/bond_law.h. */
#ifndef SDR_DAMAGE_DISCRETE_GRADIENT_H
#define SDR_DAMAGE_DISCRETE_GRADIENT_H

#include "damage/bond_law.h"

#include <stddef.h>

typedef struct {
  double mean, slope;
} sdr_mean_answer;

/* A bond that never softens. */
static inline sdr_mean_answer sdr_mean_elastic(double s0, double s1)
{
  return (sdr_mean_answer){s0 + s1, 1.0};
}

/* ---- variational, without branches -------------------------------------------------- */

/* D and T of loading. */
static inline double sdr_rational_mean(double a, double b, double q)
{
  return q * q * (a + b) / ((a * a + q) * (b * b + q));
}

static inline double sdr_rational_slope(double a, double b, double q)
{
  const double bb = b * b + q;
  return q * q * (q - b * b - 2.0 * a * b) / ((a * a + q) * bb * bb);
}

/* `before`: the largest stretch before the step, >= 0. */
static inline sdr_mean_answer sdr_mean_variational(double s0, double s1, double before, double q)
{
  const double k = s0 > before ? s0 : before, way = s1 - s0, kq = k * k + q;
  const double intact = q / kq, left = intact * intact;
  const double by = way != 0.0 ? 1.0 / way : 0.0;
  /* ends of the step on the three pieces, and the pieces' shares */
  const double ac = s0 < 0.0 ? s0 : 0.0, bc = s1 < 0.0 ? s1 : 0.0;
  const double at = s0 > 0.0 ? s0 : 0.0, b0 = s1 > 0.0 ? s1 : 0.0, bt = b0 < k ? b0 : k;
  const double bl = s1 > k ? s1 : k;
  const double wc = (bc - ac) * by, wt = (bt - at) * by, wl = (bl - k) * by;
  const double loading = sdr_rational_mean(k, bl, q);
  const double split = wc * (ac + bc) + wt * left * (at + bt) + wl * loading;
  const double still = 2.0 * (s0 > 0.0 ? left * s0 : s0);
  /* jumps of D: compression to unloading (either way), unloading to loading */
  const double up = bt * left - ac, down = bc - at * left;
  const double onto = (bl - k) * sdr_rational_slope(bl, k, q) + (k - at) * left;
  const double end = sdr_rational_slope(k, bl, q);
  const int loads = s1 > 0.0 && s1 >= k, first = way == 0.0;
  const double loaded = first ? end : wl * end + by * (wc * (up + onto) + wt * onto);
  const double unloaded = first ? left : wt * left + by * (way > 0.0 ? wc * up : 0.0);
  const double pressed = first ? 1.0 : wc + by * (way < 0.0 ? wt * down : 0.0);
  return (sdr_mean_answer){first ? still : split, loads ? loaded : s1 > 0.0 ? unloaded : pressed};
}

/* ---- any law ------------------------------------------------------------------------- */

typedef enum { SDR_PIECE_STRAIGHT, SDR_PIECE_RATIONAL, SDR_PIECE_INVERSE } sdr_piece_form;

/* Up to the stretch `end`, from where the piece before it ends. */
typedef struct {
  sdr_piece_form form;
  double end, alpha, beta;
} sdr_energy_piece;

enum { SDR_ENERGY_PIECES = 6 };

static inline double sdr_piece_mean(const sdr_energy_piece *p, double a, double b, double q)
{
  if (p->form == SDR_PIECE_STRAIGHT) return 2.0 * p->alpha + p->beta * (a + b);
  if (p->form == SDR_PIECE_RATIONAL) return sdr_rational_mean(a, b, q);
  return q * q * (a + b) / (4.0 * a * a * b * b);
}

static inline double sdr_piece_slope(const sdr_energy_piece *p, double a, double b, double q)
{
  if (p->form == SDR_PIECE_STRAIGHT) return p->beta;
  if (p->form == SDR_PIECE_RATIONAL) return sdr_rational_slope(a, b, q);
  return -q * q * (2.0 * a + b) / (4.0 * a * a * b * b * b);
}

/* The pieces of a law's energy after the history k, upwards; how many. */
static inline int sdr_energy_pieces(int law, double k, double q, double r,
                                    sdr_energy_piece piece[SDR_ENERGY_PIECES])
{
  int n = 0;
  piece[n++] = (sdr_energy_piece){SDR_PIECE_STRAIGHT, 0.0, 0.0, 1.0};
  if (!sdr_law_softens(law)) {
    piece[0].end = INFINITY;
    return n;
  }
  piece[n++] = (sdr_energy_piece){SDR_PIECE_STRAIGHT, k, 0.0, sdr_softening_of(law, k, q, r).left};
  if (law == SDR_LAW_VARIATIONAL) {
    piece[n++] = (sdr_energy_piece){SDR_PIECE_RATIONAL, INFINITY, 0.0, 0.0};
  } else if (law == SDR_LAW_AT1) {
    piece[n++] = (sdr_energy_piece){SDR_PIECE_STRAIGHT, sqrt(0.5 * q), 0.0, 1.0};
    piece[n++] = (sdr_energy_piece){SDR_PIECE_INVERSE, INFINITY, 0.0, 0.0};
  } else {
    const double mu = SDR_COHESIVE_MU, b1 = SDR_COHESIVE_B1, a1 = SDR_COHESIVE_A1;
    const double a2 = SDR_COHESIVE_GAMMA + mu * r;
    piece[n++] = (sdr_energy_piece){SDR_PIECE_STRAIGHT, q, 0.0, 1.0};
    piece[n++] = (sdr_energy_piece){SDR_PIECE_STRAIGHT, mu * q, a1 * q, -b1};
    piece[n++] = (sdr_energy_piece){SDR_PIECE_STRAIGHT, q * a2 / r, a2 * q, -r};
    piece[n++] = (sdr_energy_piece){SDR_PIECE_STRAIGHT, INFINITY, 0.0, 0.0};
  }
  return n;
}

/* `before`: the largest stretch before the step, >= 0. */
static inline sdr_mean_answer sdr_mean_any(int law, double s0, double s1, double before, double q,
                                           double r)
{
  sdr_energy_piece piece[SDR_ENERGY_PIECES];
  const double k = s0 > before ? s0 : before, way = s1 - s0;
  const int count = sdr_energy_pieces(law, k, q, r, piece);
  const int up = way >= 0.0;
  const sdr_energy_piece *last = NULL;
  double a = s0, last_a = s0, share = 0.0, mean = 0.0, jumps = 0.0, d = 0.0;
  /* downwards no further piece than that of unloading is met */
  for (int n = up || count == 1 ? 0 : 1; n >= 0 && n < count; n += up ? 1 : -1) {
    const double low = n > 0 ? piece[n - 1].end : (double)-INFINITY, high = piece[n].end;
    const int beyond = up ? a >= high : a <= low && n > 0;
    if (beyond && (n > 0 || a > 0.0 || way > 0.0)) continue; /* the step does not touch it */
    const double b = up ? (s1 < high ? s1 : high) : (s1 > low ? s1 : low);
    const double here = sdr_piece_mean(&piece[n], a, b, q);
    if (last) /* how D changes on the way over the cut at a */
      jumps += share * ((b - a) * sdr_piece_slope(&piece[n], b, a, q) +
                        (a - last_a) * sdr_piece_slope(last, last_a, a, q));
    const double part = way != 0.0 ? (b - a) / way : 1.0;
    share += part;
    mean += part * here;
    last = &piece[n];
    last_a = a;
    d = part * sdr_piece_slope(last, a, b, q);
    a = b;
    if (b == s1) break;
  }
  return (sdr_mean_answer){mean, way != 0.0 ? d + jumps / way : d};
}

/* `law` is a literal where speed matters. */
static inline sdr_mean_answer sdr_mean_of(int law, double s0, double s1, double before, double q,
                                          double r)
{
  if (law == SDR_LAW_VARIATIONAL) return sdr_mean_variational(s0, s1, before, q);
  if (!sdr_law_softens(law)) return sdr_mean_elastic(s0, s1);
  return sdr_mean_any(law, s0, s1, before, q, r);
}

#endif
